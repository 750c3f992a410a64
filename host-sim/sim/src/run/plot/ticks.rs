//! Ticks of a logarithmic axis.

/// Most ticks of an axis: more of them overprint.
const MOST: usize = 9;

/// Ticks of a logarithmic axis from `low` to `high`, both above zero: powers of ten if the axis holds at least two of them,
/// otherwise their multiples by 1, 2 and 5, otherwise equal steps. Never more than nine.
pub(super) fn ticks(low: f64, high: f64) -> Vec<f64> {
    let [first, last] = [low.log10().floor(), high.log10().ceil()].map(|power| power as i32);
    let decimals = |digits: &[u32]| -> Vec<f64> {
        let all = (first..=last).flat_map(|power| digits.iter().map(move |digit| decimal(*digit, power)));
        all.filter(|tick| (low..=high).contains(tick)).collect()
    };
    let choices = [decimals(&[1]), decimals(&[1, 2, 5]), steps(low, high)];
    let found = choices.into_iter().find(|ticks| ticks.len() >= 2).unwrap_or_default();
    let stride = found.len().div_ceil(MOST).max(1);
    found.into_iter().step_by(stride).collect()
}

/// `digit` times a power of ten, as the nearest number to its decimal text, so that it prints without rounding errors.
fn decimal(digit: u32, power: i32) -> f64 {
    format!("{digit}e{power}").parse().unwrap_or(f64::NAN)
}

/// Multiples of the smallest step of 1, 2 or 5 times a power of ten that leaves at most six of them.
fn steps(low: f64, high: f64) -> Vec<f64> {
    let power = (high - low).log10().floor() as i32 - 1;
    let step = [(1, 0), (2, 0), (5, 0), (1, 1), (2, 1), (5, 1), (1, 2)].map(|(digit, more)| (digit, power + more));
    let count = |digit, power| (high / decimal(digit, power)).floor() - (low / decimal(digit, power)).ceil() + 1.0;
    let Some((digit, power)) = step.into_iter().find(|&(digit, power)| count(digit, power) <= 6.0) else {
        return Vec::new();
    };
    let first = (low / decimal(digit, power)).ceil() as u32;
    let all = (first..).map(|k| decimal(k * digit, power));
    all.take_while(|tick| *tick <= high).collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "ticks are the nearest numbers to short decimals")]
mod tests {
    use super::ticks;

    #[test]
    fn an_axis_of_decades_has_powers_of_ten_and_no_more_of_them_than_fit() {
        assert_eq!(ticks(0.7, 1500.0), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(ticks(9e-5, 2e-3), [1e-4, 1e-3]);
        let many = ticks(1e-14, 1e3);
        assert!(many.len() <= 9 && many[1] / many[0] > 99.0, "{many:?}");
    }

    #[test]
    fn an_axis_with_fewer_than_two_powers_of_ten_has_ticks_at_1_2_and_5() {
        assert_eq!(ticks(150.0, 800.0), [200.0, 500.0]);
        assert_eq!(ticks(700.0, 3000.0), [1000.0, 2000.0]);
        assert_eq!(ticks(0.3, 6.0), [0.5, 1.0, 2.0, 5.0]);
    }

    #[test]
    fn a_narrow_axis_has_equal_steps_with_numbers_that_read_well() {
        assert_eq!(ticks(6070.0, 7650.0), [6500.0, 7000.0, 7500.0]);
        assert_eq!(ticks(0.0023, 0.0041), [0.0025, 0.003, 0.0035, 0.004]);
        for (low, high) in [(1.0, 1.01), (5.0, 5.4), (0.11, 0.19), (2100.0, 4900.0)] {
            let found = ticks(low, high);
            assert!((2..=9).contains(&found.len()), "{low} to {high}: {found:?}");
        }
    }
}
