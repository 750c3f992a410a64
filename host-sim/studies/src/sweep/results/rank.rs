//! Sensitivities: rank correlations of a figure with a key.

use serde::Serialize;

/// Spearman's rank correlation with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// Correlation from -1 (one always falls when the other rises) to 1; 0 without a monotonic relation.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Share of the variance of the figure's ranks that the key alone explains, also if the relation is not monotonic: a first-order Sobol index.
    pub share: f64,
}

/// Rank correlation of a figure with a key.
#[derive(Clone, Debug, Serialize)]
pub struct Sensitivity {
    /// Title of the figure.
    pub metric: String,
    /// Name of the key.
    pub key: String,
    /// The correlation; `None` if figure or key has only one value.
    pub correlation: Option<Correlation>,
}

/// Rank correlation of pairs; `None` for fewer than four pairs, or if one side has only one value.
///
/// Its interval uses Fisher's `z = atanh(r)` with a variance of `(1 + r^2/2) / (n - 3)` (Bonett and Wright, Psychometrika 65, 2000).
#[must_use]
pub(super) fn correlation(pairs: &[(f64, f64)]) -> Option<Correlation> {
    const WIDTH: f64 = 1.959_963_984_540_054;
    if pairs.len() < 4 {
        return None;
    }
    let (a, b) = (ranks(pairs.iter().map(|pair| pair.0)), ranks(pairs.iter().map(|pair| pair.1)));
    let n = pairs.len() as f64;
    // Ranks have this mean, with and without ties.
    let mean = 0.5 * (n + 1.0);
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    let (aa, bb) = (product(&a, &a), product(&b, &b));
    if aa <= 0.0 || bb <= 0.0 {
        return None;
    }
    let value = (product(&a, &b) / libm::sqrt(aa * bb)).clamp(-1.0, 1.0);
    let half = WIDTH * libm::sqrt((1.0 + 0.5 * value * value) / (n - 3.0));
    let end = |sign: f64| if value.abs() < 1.0 { libm::tanh(libm::atanh(value) + sign * half) } else { value };
    Some(Correlation { value, low: end(-1.0), high: end(1.0), share: share(&a, &b) })
}

/// Share of the variance of `y` that is explained by the means of `y` in steps of `x`, minus the share expected by chance: epsilon squared.
///
/// `(between - (m - 1) within / (n - m)) / (between + within)` with `m` steps of about equally many runs.
fn share(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let steps = libm::sqrt(n).clamp(2.0, 40.0).trunc();
    let mut sums = vec![(0.0, 0.0); steps as usize];
    for (x, y) in x.iter().zip(y) {
        // Equal values have equal ranks, and are therefore in the same step.
        let step = (((x - 0.5) / n * steps) as usize).min(sums.len() - 1);
        sums[step].0 += 1.0;
        sums[step].1 += y;
    }
    let mean = 0.5 * (n + 1.0);
    let total: f64 = y.iter().map(|y| (y - mean) * (y - mean)).sum();
    let used = sums.iter().filter(|(count, _)| *count > 0.0);
    let m = used.clone().count() as f64;
    let between: f64 = used.map(|(count, sum)| count * (sum / count - mean) * (sum / count - mean)).sum();
    if n <= m {
        return 0.0;
    }
    ((between - (m - 1.0) * (total - between) / (n - m)) / total).max(0.0)
}

/// Ranks from 1; equal numbers share the mean of their ranks.
fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<(f64, usize)> = values.enumerate().map(|(index, x)| (x, index)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut ranks = vec![0.0; sorted.len()];
    let mut start = 0;
    while start < sorted.len() {
        let end =
            start + sorted[start..].iter().take_while(|other| other.0.total_cmp(&sorted[start].0).is_eq()).count();
        let shared = 0.5 * ((start + 1) + end) as f64;
        sorted[start..end].iter().for_each(|(_, index)| ranks[*index] = shared);
        start = end;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::{correlation, ranks};

    #[test]
    fn equal_numbers_share_a_rank() {
        assert_eq!(ranks([3.0, 1.0, 3.0, f64::INFINITY].into_iter()), [2.5, 1.0, 2.5, 4.0]);
    }

    #[test]
    fn the_correlation_is_that_of_another_program() {
        // Value of SciPy 1.17: spearmanr([1, 2, 3, 4, 5, 6], [2, 1, 4, 3, 3, 9]).statistic.
        let pairs: Vec<_> =
            [2.0, 1.0, 4.0, 3.0, 3.0, 9.0].into_iter().zip(1..).map(|(y, x)| (f64::from(x), y)).collect();
        let found = correlation(&pairs).unwrap();
        assert!((found.value - 0.753_702_346_348_183).abs() < 1e-14, "{found:?}");
        assert!(found.low < found.value && found.value < found.high);
    }

    #[test]
    fn what_falls_and_rises_again_has_a_share_and_no_correlation() {
        let valley: Vec<_> = (-500..=500).map(|x| (f64::from(x), f64::from(x * x))).collect();
        let found = correlation(&valley).unwrap();
        assert!(found.value.abs() < 1e-12 && found.share > 0.98, "{found:?}");
        let noise: Vec<_> =
            (0..1000_u32).map(|x| (f64::from(x), f64::from(x.wrapping_mul(2_654_435_761) >> 8))).collect();
        assert!(correlation(&noise).unwrap().share < 0.05);
    }

    #[test]
    fn an_order_is_found_and_none_is_not() {
        let rising: Vec<_> = (0..9).map(|x| (f64::from(x), f64::from(x * x))).collect();
        assert!((correlation(&rising).unwrap().value - 1.0).abs() < 1e-15);
        let flat: Vec<_> = (0..9).map(|x| (f64::from(x), 1.0)).collect();
        assert!(correlation(&flat).is_none() && correlation(&rising[..3]).is_none());
    }
}
