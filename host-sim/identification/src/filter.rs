//! Resampling to even time, a zero-phase low-pass, and derivatives.

use crate::Series;
use std::f64::consts::PI;

/// A second-order section: `y = b (x + 2 x' + x'') - a1 y' - a2 y''`, where `'` is one sample earlier.
#[derive(Clone, Copy, Debug)]
struct Section {
    b: f64,
    a1: f64,
    a2: f64,
}

/// A fourth-order Butterworth low-pass, run forwards and then backwards: eighth order, zero phase.
///
/// The gain is `1 / (1 + (f / f_c)^8)`, 1/2 at the cut-off, apart from the frequency warping of the bilinear transformation.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    sections: [Section; 2],
    /// Samples in which a step response settles. The ends are continued by this many samples.
    settling: usize,
}

impl LowPass {
    /// Creates the filter; `cutoff` in Hz, below half the `rate`, Hz.
    #[must_use]
    pub fn new(cutoff: f64, rate: f64) -> Self {
        // Bilinear transformation, prewarped so that the cut-off is exact.
        let w = (PI * (cutoff / rate).min(0.499)).tan();
        let section = |angle: f64| {
            let damping = 2.0 * angle.cos();
            let norm = 1.0 + damping * w + w * w;
            Section { b: w * w / norm, a1: 2.0 * (w * w - 1.0) / norm, a2: (1.0 - damping * w + w * w) / norm }
        };
        Self { sections: [section(PI / 8.0), section(3.0 * PI / 8.0)], settling: (2.5 * rate / cutoff).ceil() as usize }
    }

    /// Returns the filtered samples, as many as given. Beyond its ends the signal is continued by its point reflection at the end, which keeps value
    /// and slope.
    #[must_use]
    pub fn apply(&self, x: &[f64]) -> Vec<f64> {
        let (Some(first), Some(last)) = (x.first(), x.last()) else { return Vec::new() };
        let more = self.settling.min(x.len() - 1);
        let before = (1..=more).rev().map(|k| 2.0 * first - x[k]);
        let after = (1..=more).map(|k| 2.0 * last - x[x.len() - 1 - k]);
        let mut y: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
        for _ in 0..2 {
            for section in &self.sections {
                section.run(&mut y);
            }
            y.reverse();
        }
        y[more..more + x.len()].to_vec()
    }
}

impl Section {
    /// Starts in the steady state of the first sample.
    fn run(&self, y: &mut [f64]) {
        let start = y.first().copied().unwrap_or(0.0);
        let (mut x1, mut x2, mut y1, mut y2) = (start, start, start, start);
        for sample in y {
            let x = *sample;
            let out = self.b * (x + 2.0 * x1 + x2) - self.a1 * y1 - self.a2 * y2;
            (x2, x1, y2, y1) = (x1, x, y1, out);
            *sample = out;
        }
    }
}

/// Central differences, one-sided at the ends; unit of `x` per second.
#[must_use]
pub fn derivative(x: &[f64], rate: f64) -> Vec<f64> {
    let last = x.len().saturating_sub(1);
    (0..x.len())
        .map(|k| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
            (x[b] - x[a]) * rate / (b - a).max(1) as f64
        })
        .collect()
}

/// Evenly spaced times from first to last, `1 / rate` apart, s.
#[must_use]
pub fn even_times(time: &[f64], rate: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return Vec::new() };
    let count = ((last - first) * rate + 1e-6).floor() as usize + 1;
    (0..count).map(|k| first + k as f64 / rate).collect()
}

/// Evaluates a natural cubic spline through `(time, x)` at the times `at`. Times must rise.
#[must_use]
pub fn spline(time: &[f64], x: &[f64], at: &[f64]) -> Vec<f64> {
    let n = x.len();
    if n < 3 {
        return lines(time, x, at);
    }
    // Second derivatives m: solve a tridiagonal system by forward elimination.
    let h: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    let slope: Vec<f64> = x.windows(2).zip(&h).map(|(x, h)| (x[1] - x[0]) / h).collect();
    let (mut factor, mut right) = (vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let pivot = 2.0 * (h[i - 1] + h[i]) - h[i - 1] * factor[i - 1];
        factor[i] = h[i] / pivot;
        right[i] = (6.0 * (slope[i] - slope[i - 1]) - h[i - 1] * right[i - 1]) / pivot;
    }
    let mut m = vec![0.0_f64; n];
    for i in (1..n - 1).rev() {
        m[i] = right[i] - factor[i] * m[i + 1];
    }
    between(time, at, |i, t| {
        let (a, b) = (time[i + 1] - t, t - time[i]);
        let cubic = (m[i] * a * a * a + m[i + 1] * b * b * b) / (6.0 * h[i]);
        cubic + (x[i] / h[i] - m[i] * h[i] / 6.0) * a + (x[i + 1] / h[i] - m[i + 1] * h[i] / 6.0) * b
    })
}

/// Interpolates linearly through `(time, x)` at the times `at`. Use it for torques: they jump, and a spline would overshoot.
#[must_use]
pub fn lines(time: &[f64], x: &[f64], at: &[f64]) -> Vec<f64> {
    between(time, at, |i, t| {
        let share = (t - time[i]) / (time[i + 1] - time[i]);
        x[i] + share * (x[i + 1] - x[i])
    })
}

fn between(time: &[f64], at: &[f64], value: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    let mut i = 0;
    at.iter()
        .map(|&t| {
            while i + 2 < time.len() && time[i + 1] <= t {
                i += 1;
            }
            value(i, t)
        })
        .collect()
}

/// Every `step`-th sample of each joint.
#[must_use]
pub fn thinned(series: &Series, step: usize) -> Series {
    series.iter().map(|x| x.iter().step_by(step).copied().collect()).collect()
}
