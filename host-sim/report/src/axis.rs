//! Ticks and scales of figures.

/// Scale of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Scale {
    /// Linear scale.
    #[default]
    Linear,
    /// Logarithmic scale; values that are not above zero are left out.
    Log,
    /// Named positions at 0, 1, 2, ...
    Names(Vec<String>),
}

/// An axis from `low` to `high`, mapped to a range of pixels.
pub(crate) struct Axis<'a> {
    scale: &'a Scale,
    low: f64,
    high: f64,
    pixels: (f64, f64),
}

/// Width of a letter of a label, pixels. The widest common font, DejaVu Sans, has 6.9 on average.
const LETTER: f64 = 7.2;
/// Largest number of ticks on an axis.
const TICKS: f64 = 7.0;

impl<'a> Axis<'a> {
    /// Creates an axis that contains all values with a margin. With `zero` it also contains zero, as bars require.
    pub(crate) fn new(scale: &'a Scale, values: impl Iterator<Item = f64>, zero: bool, pixels: (f64, f64)) -> Self {
        let all = values.filter(|x| scale.can(*x));
        let (mut low, mut high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        match scale {
            Scale::Names(names) => (low, high) = (-0.5, names.len() as f64 - 0.5),
            Scale::Log => (low, high) = (low / 1.3, high * 1.3),
            Scale::Linear => {
                if zero {
                    (low, high) = (low.min(0.0), high.max(0.0));
                }
                let room = (0.05 * (high - low)).max(1e-6 * low.abs().max(high.abs())).max(1e-12);
                let at = |end: f64, out: f64| if zero && end == 0.0 { 0.0 } else { end + out };
                (low, high) = (at(low, -room), at(high, room));
            }
        }
        Self { scale, low, high, pixels }
    }

    /// Pixel of a value; `None` for a value that the scale cannot show.
    pub(crate) fn pixel(&self, value: f64) -> Option<f64> {
        let of = |x: f64| if *self.scale == Scale::Log { x.ln() } else { x };
        let share = (of(value) - of(self.low)) / (of(self.high) - of(self.low));
        self.scale.can(value).then_some(self.pixels.0 + share * (self.pixels.1 - self.pixels.0))
    }

    /// Ticks and their labels.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Names(names) => names.iter().enumerate().map(|(k, name)| (k as f64, name.clone())).collect(),
            Scale::Linear => self.steps(),
            Scale::Log => {
                let decades = (self.low.log10().ceil() as i32)..=(self.high.log10().floor() as i32);
                let count = decades.clone().count();
                let every = count.div_ceil(TICKS as usize).max(1);
                let digits: &[f64] = if count > 2 { &[1.0] } else { &[1.0, 2.0, 5.0] };
                let first = *decades.start() - 1;
                let all = (first..=*decades.end()).flat_map(|power| digits.iter().map(move |digit| (power, *digit)));
                let inside = all.map(|(power, digit)| (power, digit * 10f64.powi(power)));
                let inside = inside.filter(|(_, x)| (self.low..=self.high).contains(x));
                let kept = inside.filter(|(power, _)| ((power - first) as usize).is_multiple_of(every));
                let found: Vec<_> = kept.map(|(_, x)| (x, label(x))).collect();
                if found.len() >= 2 { found } else { self.steps() }
            }
        }
    }

    /// Breaks a label into lines, so that a name does not overlap its neighbours. Labels of numbers are short and stay on one line.
    pub(crate) fn lines(&self, label: &str) -> Vec<String> {
        let Scale::Names(names) = self.scale else { return vec![label.to_owned()] };
        let room = (self.pixels.1 - self.pixels.0).abs() / names.len().max(1) as f64;
        broken(label, ((room / LETTER) as usize).max(1))
    }

    /// Ticks at multiples of 1, 2 or 5 times a power of ten.
    fn steps(&self) -> Vec<(f64, String)> {
        let rough = (self.high - self.low) / TICKS;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        (first..=last).map(|k| (k as f64 * step, label(k as f64 * step))).collect()
    }
}

impl Scale {
    fn can(&self, value: f64) -> bool {
        value.is_finite() && (*self != Self::Log || value > 0.0)
    }
}

/// Breaks text into lines of at most `letters` letters, after a joining character of the name if the line contains one.
fn broken(text: &str, letters: usize) -> Vec<String> {
    let mut rest: Vec<char> = text.chars().collect();
    let mut lines = Vec::new();
    while rest.len() > letters {
        let joint = rest[..letters].iter().rposition(|c| matches!(c, '.' | '_' | '-' | '/' | ' '));
        let behind = rest.split_off(joint.map_or(letters, |at| at + 1));
        lines.push(rest.into_iter().collect());
        rest = behind;
    }
    lines.push(rest.into_iter().collect());
    lines
}

/// Label of a tick: six digits, in the shortest form.
fn label(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) {
        return format!("{:e}", format!("{x:.5e}").parse::<f64>().unwrap_or(x));
    }
    let short = format!("{x:.6}");
    let short = short.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Scale, broken};

    fn labels(scale: &Scale, values: [f64; 2]) -> Vec<String> {
        Axis::new(scale, values.into_iter(), false, (0.0, 100.0)).ticks().into_iter().map(|tick| tick.1).collect()
    }

    #[test]
    fn ticks_are_short_numbers_inside_the_axis() {
        assert_eq!(labels(&Scale::Linear, [0.0, 10.0]), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(&Scale::Linear, [-0.003, 0.0021]), ["-0.003", "-0.002", "-0.001", "0", "0.001", "0.002"]);
        assert_eq!(labels(&Scale::Log, [2.0, 90.0]), ["2", "5", "10", "20", "50", "100"]);
        assert_eq!(labels(&Scale::Log, [2.0, 900.0]), ["10", "100", "1000"]);
        assert!((3..=7).contains(&labels(&Scale::Log, [1e-8, 1.0]).len()));
        assert!(labels(&Scale::Log, [3.1, 3.2]).len() >= 2);
        assert!(labels(&Scale::Linear, [5.0, 5.0]).len() >= 2);
    }

    #[test]
    fn a_name_without_room_is_broken_where_its_words_join_and_loses_nothing() {
        assert_eq!(broken("robot.joint.1.friction.viscous", 13), ["robot.joint.", "1.friction.", "viscous"]);
        assert_eq!(broken("actuators.delay", 15), ["actuators.delay"]);
        assert_eq!(
            (broken("shoulder", 3), broken("", 3)),
            (["sho", "uld", "er"].map(str::to_owned).to_vec(), vec![String::new()])
        );
    }

    #[test]
    fn a_value_that_the_scale_cannot_show_has_no_place() {
        let axis = Axis::new(&Scale::Log, [0.0, 1.0, 10.0].into_iter(), false, (0.0, 100.0));
        assert_eq!(axis.pixel(0.0), None);
        assert_eq!(axis.pixel(f64::NAN), None);
        assert!(axis.pixel(1.0).unwrap() > 0.0);
    }
}
