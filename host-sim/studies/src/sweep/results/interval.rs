//! Confidence intervals for the share of failing runs.

use serde::Serialize;

/// A share of runs, with the 95 % confidence interval of the true share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunShare {
    /// Number of runs that count, for example failing ones.
    pub count: u64,
    /// Number of all runs.
    pub of: u64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval. If no run counts, about `3 / of`.
    pub high: f64,
}

/// Probability that the interval misses the true value.
const MISS: f64 = 0.05;

impl RunShare {
    /// Computes the Clopper-Pearson interval, which is exact for every true share. It is one-sided if no run counts or all do.
    ///
    /// Its ends are quantiles of beta distributions: `low` of `Beta(k, n - k + 1)`, `high` of `Beta(k + 1, n - k)`.
    #[must_use]
    pub fn new(count: u64, of: u64) -> Self {
        let (k, n) = (count as f64, of as f64);
        let (low, high) = match (count, of) {
            (_, 0) => (0.0, 1.0),
            (0, _) => (0.0, 1.0 - libm::pow(MISS, 1.0 / n)),
            (k, n) if k == n => (libm::pow(MISS, 1.0 / n as f64), 1.0),
            _ => (quantile(0.5 * MISS, k, n - k + 1.0), quantile(1.0 - 0.5 * MISS, k + 1.0, n - k)),
        };
        Self { count, of, low, high }
    }

    /// The share itself; NaN if there are no runs.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.count as f64 / self.of as f64
    }
}

/// Quantile of `Beta(a, b)` at probability `p`, by bisection.
fn quantile(p: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Each step halves the interval; 200 steps exhaust the precision of f64.
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if incomplete_beta(middle, a, b) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Regularised incomplete beta function `I_x(a, b)`, by the continued fraction of Abramowitz and Stegun 26.5.8 in Lentz's form.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let scale = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log1p(-x);
    const TINY: f64 = 1e-300;
    let away = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut c = 1.0;
    let mut d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    // Needs about sqrt(max(a, b)) iterations.
    for m in 1..10_000_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for term in [even, odd] {
            d = 1.0 / away(1.0 + term * d);
            c = away(1.0 + term / c);
            change = c * d;
            fraction *= change;
        }
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    libm::exp(scale) * fraction / a
}

#[cfg(test)]
mod tests {
    use super::{RunShare, incomplete_beta};

    #[test]
    fn the_ends_are_those_of_another_program() {
        // Values of SciPy 1.17: binomtest(k, n).proportion_ci(method="exact").
        for (k, n, low, high) in [
            (3, 100, 0.006_229_971_538_306_227, 0.085_176_052_974_280_28),
            (1, 1_000_000, 2.531_780_513_911_381_5e-8, 5.571_630_655_512_304e-6),
            (50, 100, 0.398_321_129_503_300_95, 0.601_678_870_496_699_1),
        ] {
            let share = RunShare::new(k, n);
            // Logarithms of gamma functions near a million lose seven of sixteen digits.
            assert!((share.low / low - 1.0).abs() < 1e-6 && (share.high / high - 1.0).abs() < 1e-6, "{share:?}");
        }
    }

    #[test]
    fn none_of_many_is_the_rule_of_three() {
        let share = RunShare::new(0, 1000);
        assert!(share.low == 0.0 && (share.high - 3.0 / 1000.0).abs() < 1e-5, "{share:?}");
        let all = RunShare::new(1000, 1000);
        assert!((all.high - 1.0).abs() < 1e-15 && (all.low - (1.0 - share.high)).abs() < 1e-12);
        assert!((RunShare::new(0, 0).high - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_beta_function_is_symmetric_and_known_where_it_is_a_polynomial() {
        assert!((incomplete_beta(0.3, 2.0, 3.0) - 0.3483).abs() < 1e-12);
        assert!((incomplete_beta(0.3, 2.0, 3.0) + incomplete_beta(0.7, 3.0, 2.0) - 1.0).abs() < 1e-14);
    }
}
