//! Finite Fourier series.

use super::bounds::{Bounds, Peaks};
use super::error::{MotionError, check_ramp, check_time};
use crate::control::Reference;
use crate::scalar::Real;
use core::f64::consts::TAU;

/// Most harmonics of a series.
pub const HARMONICS_MAX: usize = 8;

/// Number of samples in a period of the highest harmonic, and in a ramp, among which peaks are searched.
const FINENESS: u32 = 64;

/// Factor on the peaks of the samples. A sine can exceed its samples by `(2 pi / 64)^2 / 8`; the same again is added for the ramps.
const BETWEEN: f64 = 1.003;

/// Most periods that a series may last.
const PERIODS_MAX: f64 = 1000.0;

/// Parameters of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierSpec<S, const N: usize> {
    /// Position at which each joint starts and ends, and about which it moves, rad or m.
    pub centre: [S; N],
    /// Sine amplitudes of each harmonic for each joint, rad or m; zero beyond the last harmonic.
    pub sine: [[S; N]; HARMONICS_MAX],
    /// Cosine amplitudes, likewise.
    pub cosine: [[S; N]; HARMONICS_MAX],
    /// Period of the first harmonic, s.
    pub period: S,
    /// Duration from start to end, s.
    pub duration: S,
    /// Time in which the series grows at the start, and vanishes at the end, s. At most half the duration.
    pub ramp: S,
}

/// A sum of sines and cosines whose frequencies are multiples of one, from rest to rest.
///
/// ```text
/// q = centre + w sum_k (a_k sin(k phi) + b_k cos(k phi)),   phi = 2 pi t / period
/// w = u^3 (10 - 15 u + 6 u^2),   u = min(t, T - t, r) / r
/// ```
///
/// `w` and its first two derivatives vanish at both ends. Positions, speeds and accelerations are sampled 64 times a period of the
/// highest harmonic; peaks are the largest of these and 0.3 % more.
///
/// Evaluated in double precision with libm's sine and cosine, for every `S`: for the desk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fourier<S, const N: usize> {
    spec: FourierSpec<S, N>,
    peaks: Peaks<S, N>,
}

impl<S: Real, const N: usize> Fourier<S, N> {
    pub(super) fn new(spec: &FourierSpec<S, N>, bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        bounds.check()?;
        bounds.check_position(0, &spec.centre)?;
        for joint in 0..N {
            let finite = |list: &[[S; N]; HARMONICS_MAX]| list.iter().all(|a| a[joint].is_finite());
            if !(finite(&spec.sine) && finite(&spec.cosine)) {
                return Err(MotionError::NotFinite { what: "amplitude", point: 0, joint });
            }
        }
        check_time("period", spec.period)?;
        check_ramp(spec.duration, spec.ramp)?;
        if spec.duration > S::literal(PERIODS_MAX) * spec.period {
            let value = spec.duration.to_f64();
            return Err(MotionError::OutOfRange { what: "duration", value, wanted: "at most 1000 periods" });
        }
        let still = Peaks { velocity: [S::zero(); N], acceleration: [S::zero(); N] };
        let mut motion = Self { spec: *spec, peaks: still };
        let (reach, peaks) = motion.sampled();
        for joint in 0..N {
            let ((low, high), limits) = (reach[joint], bounds.position[joint]);
            let limits = (limits.0.to_f64(), limits.1.to_f64());
            if low < limits.0 || high > limits.1 {
                return Err(MotionError::AmplitudeBeyondLimits { joint, reach: (low, high), limits });
            }
        }
        motion.peaks = peaks;
        bounds.check_peaks(&peaks)?;
        Ok(motion)
    }

    /// Lowest and highest position, and the peaks, of samples.
    fn sampled(&self) -> ([(f64, f64); N], Peaks<S, N>) {
        let (duration, period) = (self.spec.duration.to_f64(), self.spec.period.to_f64());
        let grain = (period / HARMONICS_MAX as f64).min(self.spec.ramp.to_f64()) / f64::from(FINENESS);
        let count = libm::ceil(duration / grain).clamp(1.0, 1e7);
        let mut reach = self.spec.centre.map(|q| (q.to_f64(), q.to_f64()));
        let mut peaks = Peaks { velocity: [0.0_f64; N], acceleration: [0.0_f64; N] };
        for step in 0..count as u32 {
            let [q, qd, qdd] = self.at(duration * f64::from(step) / count);
            for joint in 0..N {
                reach[joint] = (reach[joint].0.min(q[joint]), reach[joint].1.max(q[joint]));
                peaks.velocity[joint] = peaks.velocity[joint].max(qd[joint].abs());
                peaks.acceleration[joint] = peaks.acceleration[joint].max(qdd[joint].abs());
            }
        }
        let between = |x: [f64; N]| x.map(|x| S::literal(BETWEEN * x));
        (reach, Peaks { velocity: between(peaks.velocity), acceleration: between(peaks.acceleration) })
    }

    /// Position, velocity and acceleration at `t`.
    fn at(&self, t: f64) -> [[f64; N]; 3] {
        let omega = TAU / self.spec.period.to_f64();
        let mut swing = [[0.0; N]; 3];
        for (k, (a, b)) in self.spec.sine.iter().zip(&self.spec.cosine).enumerate() {
            if a.iter().chain(b).all(|x| *x == S::zero()) {
                continue;
            }
            let rate = omega * (k + 1) as f64;
            let (sin, cos) = libm::sincos(rate * t);
            for joint in 0..N {
                let (a, b) = (a[joint].to_f64(), b[joint].to_f64());
                swing[0][joint] += a * sin + b * cos;
                swing[1][joint] += rate * (a * cos - b * sin);
                swing[2][joint] -= rate * rate * (a * sin + b * cos);
            }
        }
        let [w, wd, wdd] = envelope(t, self.spec.duration.to_f64(), self.spec.ramp.to_f64());
        let [x, xd, xdd] = swing;
        [
            core::array::from_fn(|i| self.spec.centre[i].to_f64() + w * x[i]),
            core::array::from_fn(|i| wd * x[i] + w * xd[i]),
            core::array::from_fn(|i| wdd * x[i] + 2.0 * wd * xd[i] + w * xdd[i]),
        ]
    }

    pub(super) fn centre(&self) -> [S; N] {
        self.spec.centre
    }

    pub(super) fn duration(&self) -> S {
        self.spec.duration
    }

    pub(super) fn peaks(&self) -> Peaks<S, N> {
        self.peaks
    }

    pub(super) fn stretched(&self, factor: S) -> Self {
        let spec = FourierSpec {
            period: self.spec.period * factor,
            duration: self.spec.duration * factor,
            ramp: self.spec.ramp * factor,
            ..self.spec
        };
        let peaks = Peaks {
            velocity: self.peaks.velocity.map(|v| v / factor),
            acceleration: self.peaks.acceleration.map(|a| a / (factor * factor)),
        };
        Self { spec, peaks }
    }

    pub(super) fn sample(&self, t: S) -> Reference<S, N> {
        let [q, qd, qdd] = self.at(t.to_f64()).map(|x| x.map(S::literal));
        Reference { q, qd, qdd }
    }
}

/// `[w, w', w'']`: from 0 to 1 at the start and back at the end, each in a ramp.
pub(super) fn envelope(t: f64, duration: f64, ramp: f64) -> [f64; 3] {
    let left = duration - t;
    let (near, sign) = if left < t { (left, -1.0) } else { (t, 1.0) };
    if near >= ramp {
        return [1.0, 0.0, 0.0];
    }
    let u = near / ramp;
    let v = 1.0 - u;
    [
        u * u * u * (10.0 + u * (6.0 * u - 15.0)),
        sign * 30.0 * (u * v) * (u * v) / ramp,
        60.0 * u * v * (v - u) / (ramp * ramp),
    ]
}
