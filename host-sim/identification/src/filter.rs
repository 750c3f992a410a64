//! Even time, a low-pass without delay, and derivatives.

use crate::Series;
use std::f64::consts::PI;

/// A section of second order: `y = b (x + 2 x' + x'') - a1 y' - a2 y''`, with `'` one sample before.
#[derive(Clone, Copy, Debug)]
struct Section {
    b: f64,
    a1: f64,
    a2: f64,
}

/// Butterworth's low-pass of fourth order, run forwards and then backwards: eighth order, no delay.
///
/// The gain is `1 / (1 + (f / f_c)^8)` before the frequencies are warped by sampling: 1/2 at the cut-off.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    sections: [Section; 2],
    /// Samples that a step takes to settle: how far the ends are continued.
    settling: usize,
}

impl LowPass {
    /// `cutoff` in Hz, below half the `rate`, Hz.
    #[must_use]
    pub fn new(cutoff: f64, rate: f64) -> Self {
        // Bilinear transformation with the cut-off kept in its place.
        let w = (PI * (cutoff / rate).min(0.499)).tan();
        let section = |angle: f64| {
            let damping = 2.0 * angle.cos();
            let norm = 1.0 + damping * w + w * w;
            Section { b: w * w / norm, a1: 2.0 * (w * w - 1.0) / norm, a2: (1.0 - damping * w + w * w) / norm }
        };
        Self { sections: [section(PI / 8.0), section(3.0 * PI / 8.0)], settling: (2.5 * rate / cutoff).ceil() as usize }
    }

    /// The filtered samples, as many as before. Beyond its ends a signal is continued by its own reflection in the end point, which keeps
    /// value and slope.
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
    /// Starts as if the first sample had been there for ever.
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

/// Central differences, one-sided at the ends: per second.
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

/// Times from first to last, evenly, `1 / rate` apart.
#[must_use]
pub fn even_times(time: &[f64], rate: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return Vec::new() };
    let count = ((last - first) * rate + 1e-6).floor() as usize + 1;
    (0..count).map(|k| first + k as f64 / rate).collect()
}

/// A natural cubic spline through `(time, x)`, at `at`. Times rise.
#[must_use]
pub fn spline(time: &[f64], x: &[f64], at: &[f64]) -> Vec<f64> {
    let n = x.len();
    if n < 3 {
        return lines(time, x, at);
    }
    // Second derivatives m: a tridiagonal system, by elimination from the front.
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

/// Straight lines through `(time, x)`, at `at`: torque jumps, and a spline would overshoot.
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

/// Standard deviation of the noise of a position, from third differences, which leave little of a motion.
#[must_use]
pub fn position_noise(q: &[f64]) -> f64 {
    let third: f64 = q.windows(4).map(|q| (q[3] - 3.0 * q[2] + 3.0 * q[1] - q[0]).powi(2)).sum();
    (third / (20 * q.len().max(1)) as f64).sqrt()
}
