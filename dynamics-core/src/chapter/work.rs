//! Work done by the actuators along a motion.

use crate::scalar::Real;

/// Adds up the work of every joint. Work done by the actuator and work done on the actuator are summed separately.
///
/// `W = int tau qd dt`. The power is taken as linear between two instants, so `W` follows the trapezoid rule. If the power changes its sign
/// in between, the positive and the negative triangle are counted separately. For smooth torques and velocities the error falls with the
/// square of the step. A constant torque and a linearly changing velocity give a linear power: pass the held torque to
/// [`WorkMeter::step`] at both ends, and the sum is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkMeter<S, const N: usize> {
    positive: [S; N],
    negative: [S; N],
    power: Option<[S; N]>,
}

impl<S: Real, const N: usize> Default for WorkMeter<S, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Real, const N: usize> WorkMeter<S, N> {
    /// No work yet.
    #[must_use]
    pub fn new() -> Self {
        Self { positive: [S::zero(); N], negative: [S::zero(); N], power: None }
    }

    /// The next sample of a motion, `dt` (s) after the one before; of the first one `dt` is not read.
    ///
    /// `tau` in N m or N, `qd` in rad/s or m/s.
    pub fn sample(&mut self, dt: S, tau: &[S; N], qd: &[S; N]) {
        let power = power(tau, qd);
        if let Some(before) = self.power.replace(power) {
            self.add(dt, &before, &power);
        }
    }

    /// A step of `dt` (s) from one torque and velocity to another. The steps need not join: at a jump of the torque one ends
    /// with the torque before it and the next begins with the torque after it.
    pub fn step(&mut self, dt: S, from: (&[S; N], &[S; N]), to: (&[S; N], &[S; N])) {
        self.add(dt, &power(from.0, from.1), &power(to.0, to.1));
    }

    /// Work that each actuator gave the arm, J; not below zero.
    #[must_use]
    pub const fn positive(&self) -> &[S; N] {
        &self.positive
    }

    /// Work that each actuator took from the arm, J; not above zero.
    #[must_use]
    pub const fn negative(&self) -> &[S; N] {
        &self.negative
    }

    /// Work of each actuator, J: the sum of both.
    #[must_use]
    pub fn total(&self) -> [S; N] {
        core::array::from_fn(|i| self.positive[i] + self.negative[i])
    }

    /// Adds a step in which the power, W, changes linearly from `from` to `to`.
    fn add(&mut self, dt: S, from: &[S; N], to: &[S; N]) {
        let zero = S::zero();
        let half = dt * S::literal(0.5);
        for i in 0..N {
            let (a, b) = (from[i], to[i]);
            let (high, low) = if a > b { (a, b) } else { (b, a) };
            if low >= zero {
                self.positive[i] += (a + b) * half;
            } else if high <= zero {
                self.negative[i] += (a + b) * half;
            } else {
                // The share of the step above zero is `high / (high - low)`. A NaN shows in the sums.
                let slope = half / (high - low);
                self.positive[i] += high * (high * slope);
                self.negative[i] -= low * (low * slope);
            }
        }
    }
}

fn power<S: Real, const N: usize>(tau: &[S; N], qd: &[S; N]) -> [S; N] {
    core::array::from_fn(|i| tau[i] * qd[i])
}
