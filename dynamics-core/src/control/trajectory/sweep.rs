//! A sine whose frequency changes linearly.

use super::bounds::{Bounds, Peaks};
use super::error::{MotionError, check_ramp, check_time};
use super::fourier::envelope;
use crate::control::Reference;
use crate::scalar::Real;
use core::f64::consts::TAU;

/// Most periods of its highest frequency that a sweep may last. Its peaks are found by sampling, 100 times a period.
const PERIODS_MAX: f64 = 1e4;

/// Parameters of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepSpec<S, const N: usize> {
    /// Position at which each joint starts and ends, and about which it moves, rad or m.
    pub centre: [S; N],
    /// Amplitude of each joint, rad or m; a negative one starts in the negative direction.
    pub amplitude: [S; N],
    /// Frequency at the start, Hz.
    pub from: S,
    /// Frequency at the end, Hz.
    pub to: S,
    /// Duration from start to end, s.
    pub duration: S,
    /// Time in which the amplitude grows at the start, and vanishes at the end, s. At most half the duration.
    pub ramp: S,
}

/// A sine whose frequency goes linearly from `f0` to `f1` in the time `T`, all joints in step, from rest to rest.
///
/// ```text
/// q   = centre + amplitude y,      y = w sin(phi),      phi = 2 pi (f0 t + (f1 - f0) t^2 / (2 T))
/// qd  = amplitude (w' sin(phi) + w phi' cos(phi))
/// qdd = amplitude (w'' sin(phi) + 2 w' phi' cos(phi) + w (phi'' cos(phi) - phi'^2 sin(phi)))
/// w   = u^3 (10 - 15 u + 6 u^2),   u = min(t, T - t, r) / r
/// ```
///
/// `w` and its first two derivatives vanish at both ends, so position, velocity and acceleration start and end at rest.
///
/// The peaks of `y'` and `y''` are the largest of samples `h` apart plus `h^2 / 8` times a bound on the derivative two orders up.
/// They are never too low. They are at most 1 % too high if the ramps last for a fiftieth of a period or more (largest error found:
/// 0.82 %), or 0.3 % if they last for a fifth.
///
/// Evaluated in double precision with libm's sine and cosine, for every `S`: for the desk, not for a tick on a chip
/// without double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep<S, const N: usize> {
    spec: SweepSpec<S, N>,
    /// Greatest `|y'|`, 1/s, and `|y''|`, 1/s^2.
    unit_peaks: (S, S),
}

impl<S: Real, const N: usize> Sweep<S, N> {
    pub(super) fn new(spec: &SweepSpec<S, N>, bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        bounds.check()?;
        for joint in 0..N {
            for (what, value) in [("centre", spec.centre[joint]), ("amplitude", spec.amplitude[joint])] {
                if !value.is_finite() {
                    return Err(MotionError::NotFinite { what, point: 0, joint });
                }
            }
            let swing = spec.amplitude[joint].abs();
            let reach = (spec.centre[joint] - swing, spec.centre[joint] + swing);
            let (lo, hi) = bounds.position[joint];
            if reach.0 < lo || reach.1 > hi {
                let pair = |(a, b): (S, S)| (a.to_f64(), b.to_f64());
                return Err(MotionError::AmplitudeBeyondLimits { joint, reach: pair(reach), limits: pair((lo, hi)) });
            }
        }
        check_ramp(spec.duration, spec.ramp)?;
        let out_of_range =
            |what, value: S, wanted| Err(MotionError::OutOfRange { what, value: value.to_f64(), wanted });
        for frequency in [spec.from, spec.to] {
            if !(frequency >= S::zero() && frequency.is_finite()) {
                return out_of_range("frequency", frequency, "finite and not negative");
            }
        }
        let highest = if spec.from > spec.to { spec.from } else { spec.to };
        check_time("highest frequency", highest)?;
        if highest * spec.duration > S::literal(PERIODS_MAX) {
            return out_of_range("duration in periods", highest * spec.duration, "at most 10000");
        }
        let (velocity, acceleration) = Chirp::new(spec).peaks();
        if !(velocity.is_finite() && acceleration.is_finite()) {
            return out_of_range("ramp", spec.ramp, "long enough for a finite acceleration");
        }
        let motion = Self { spec: *spec, unit_peaks: (S::literal(velocity), S::literal(acceleration)) };
        bounds.check_peaks(&motion.peaks())?;
        Ok(motion)
    }

    pub(super) fn centre(&self) -> [S; N] {
        self.spec.centre
    }

    pub(super) fn duration(&self) -> S {
        self.spec.duration
    }

    /// Parameters of the sweep.
    #[must_use]
    pub fn spec(&self) -> &SweepSpec<S, N> {
        &self.spec
    }

    pub(super) fn stretched(&self, factor: S) -> Self {
        let spec = SweepSpec {
            from: self.spec.from / factor,
            to: self.spec.to / factor,
            duration: self.spec.duration * factor,
            ramp: self.spec.ramp * factor,
            ..self.spec
        };
        Self { spec, unit_peaks: (self.unit_peaks.0 / factor, self.unit_peaks.1 / (factor * factor)) }
    }

    pub(super) fn peaks(&self) -> Peaks<S, N> {
        let swing = self.spec.amplitude.map(|a| a.abs());
        Peaks { velocity: swing.map(|a| a * self.unit_peaks.0), acceleration: swing.map(|a| a * self.unit_peaks.1) }
    }

    pub(super) fn sample(&self, t: S) -> Reference<S, N> {
        let y = Chirp::new(&self.spec).sample(t.to_f64());
        let times = |x: f64| self.spec.amplitude.map(|a| S::literal(a.to_f64() * x));
        let swing = times(y[0]);
        Reference { q: core::array::from_fn(|i| self.spec.centre[i] + swing[i]), qd: times(y[1]), qdd: times(y[2]) }
    }
}

/// Parameters of `y`.
struct Chirp {
    omega: f64,
    alpha: f64,
    duration: f64,
    ramp: f64,
}

impl Chirp {
    fn new<S: Real, const N: usize>(spec: &SweepSpec<S, N>) -> Self {
        let (from, to, duration) = (spec.from.to_f64(), spec.to.to_f64(), spec.duration.to_f64());
        Self { omega: TAU * from, alpha: TAU * (to - from) / duration, duration, ramp: spec.ramp.to_f64() }
    }

    /// `[y, y', y'']`.
    fn sample(&self, t: f64) -> [f64; 3] {
        let [w, wd, wdd] = envelope(t, self.duration, self.ramp);
        let phid = self.omega + self.alpha * t;
        let (sin, cos) = libm::sincos(t * (self.omega + 0.5 * self.alpha * t));
        [
            w * sin,
            wd * sin + w * phid * cos,
            wdd * sin + 2.0 * wd * phid * cos + w * (self.alpha * cos - phid * phid * sin),
        ]
    }

    /// Bounds on `|y'|` and `|y''|`.
    ///
    /// `w''` has a kink where a ramp meets the full amplitude, so the three parts are sampled apart, each with its ends.
    fn peaks(&self) -> (f64, f64) {
        /// Samples in a period, and in a ramp that is shorter than one.
        const FINENESS: f64 = 100.0;
        let omega = self.omega.max(self.omega + self.alpha * self.duration);
        let period = TAU / omega;
        let mut peaks = (0.0_f64, 0.0_f64);
        let parts =
            [(0.0, self.ramp), (self.ramp, self.duration - self.ramp), (self.duration - self.ramp, self.duration)];
        for (ramped, (from, to)) in [true, false, true].into_iter().zip(parts) {
            let grain = if ramped { period.min(self.ramp) } else { period } / FINENESS;
            let count = libm::ceil((to - from) / grain).max(1.0);
            let h = (to - from) / count;
            let mut sampled = (0.0_f64, 0.0_f64);
            for i in 0..=count as u32 {
                let [_, yd, ydd] = self.sample(from + h * f64::from(i));
                sampled = (sampled.0.max(yd.abs()), sampled.1.max(ydd.abs()));
            }
            let (yddd, ydddd) = self.derivative_bounds(omega, ramped);
            if !(yddd.is_finite() && ydddd.is_finite()) {
                return (f64::INFINITY, f64::INFINITY);
            }
            peaks.0 = peaks.0.max(sampled.0 + h * h / 8.0 * yddd);
            peaks.1 = peaks.1.max(sampled.1 + h * h / 8.0 * ydddd);
        }
        peaks
    }

    /// Bounds on `|y'''|` and `|y''''|` by Leibniz's rule, from bounds on the derivatives of `w` and of `sin(phi)`.
    fn derivative_bounds(&self, omega: f64, ramped: bool) -> (f64, f64) {
        let per = if ramped { 1.0 / self.ramp } else { 0.0 };
        // Greatest |w|, |w'|, ... of the smooth step: 1, 15/8, 10/sqrt(3), 60, 360.
        let w = [1.0, 1.875 * per, 5.774 * per * per, 60.0 * per * per * per, 360.0 * per * per * per * per];
        let alpha = self.alpha.abs();
        let s = [
            1.0,
            omega,
            omega * omega + alpha,
            omega * (omega * omega + 3.0 * alpha),
            omega * omega * (omega * omega + 6.0 * alpha) + 3.0 * alpha * alpha,
        ];
        (
            w[3] * s[0] + 3.0 * w[2] * s[1] + 3.0 * w[1] * s[2] + w[0] * s[3],
            w[4] * s[0] + 4.0 * w[3] * s[1] + 6.0 * w[2] * s[2] + 4.0 * w[1] * s[3] + w[0] * s[4],
        )
    }
}
