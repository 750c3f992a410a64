//! The loop of arm and controller about a posture, linearised and sampled, to find the stable gains.
//!
//! Between two ticks the torque is held. Let `x = (dq, dqd)` be the deviation from rest at `q0`, `u` the torque, and `d` the delay in ticks. The
//! derivatives of the recursion come from dual numbers:
//!
//! ```text
//! x' = A x + B u,   A = [0 1; -D^-1 dID/dq  -D^-1 dID/dqd],   B = [0; D^-1]              of the arm
//! x(k+1) = e^(A h) x(k) + (int_0^h e^(A s) ds) B u(k-d),   u(k) = K x(k),   K = (dlaw/dq, dlaw/dqd)   of the model
//! ```
//!
//! The loop is stable if every eigenvalue of the map from `(x(k), u(k-1), .., u(k-d))` to the next such vector is inside the unit circle. Arm and
//! model may differ: if the model is wrong, a constant torque is assumed to hold the arm in its posture.

use dynamics_core::control::{ControlLaw, FeedbackInertia, Gains, computed_torque};
use dynamics_core::dual::Dual;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Reference, Scalar, SinCos, Trig};
use nalgebra::{DMatrix, SMatrix};
use num_traits::Zero as _;

/// Arm and control law about a posture.
#[derive(Clone, Debug)]
pub(crate) struct SampledLoop<const N: usize> {
    /// The arm and its surroundings.
    pub(crate) arm: Dynamics<f64, N>,
    /// The control law's model of the arm.
    pub(crate) model: Dynamics<f64, N>,
    /// Posture in which the arm is held, rad or m.
    pub(crate) posture: [f64; N],
    /// [`ControlLaw::ComputedTorque`], [`ControlLaw::Pd`] or [`ControlLaw::PdGravity`]. Feedforward is treated as PD, and a diagonal inertia as PD
    /// with gravity.
    pub(crate) law: ControlLaw,
    /// Gains of each joint.
    pub(crate) gains: [Gains<f64>; N],
    /// Number of ticks between command and action.
    pub(crate) delay: usize,
}

impl<const N: usize> SampledLoop<N> {
    /// Largest magnitude of the eigenvalues of the map over one period `h` (s).
    ///
    /// Computed as `lim |A^m|^(1/m)`, at `m = 2^40` by squaring. A QR iteration may not converge for such a map, which can have six equal
    /// eigenvalues; squaring always ends.
    ///
    /// Cost: `4 N` inverse dynamics on dual numbers, and 40 products of matrices of size `(2 + delay) N`.
    #[must_use]
    pub(crate) fn spectral_radius(&self, h: f64) -> f64 {
        const SQUARINGS: i32 = 40;
        let mut map = self.map(h);
        let mut logarithm = 0.0;
        for squared in 0..=SQUARINGS {
            let size = map.norm();
            if size == 0.0 {
                return 0.0;
            }
            logarithm += libm::ldexp(libm::log(size), -squared);
            map /= size;
            map = &map * &map;
        }
        libm::exp(logarithm)
    }

    /// The loop with another natural frequency for every joint, rad/s, critically damped.
    #[must_use]
    pub(crate) fn with_frequency(&self, frequency: f64) -> Self {
        Self { gains: self.gains.map(|gains| Gains::new(frequency, 1.0, gains.inertia)), ..self.clone() }
    }

    /// The map over one period.
    fn map(&self, h: f64) -> DMatrix<f64> {
        let (free, forced) = self.sampled(h);
        let feedback = self.feedback();
        let size = (2 + self.delay) * N;
        let mut map = DMatrix::zeros(size, size);
        map.view_mut((0, 0), (2 * N, 2 * N)).copy_from(&free);
        if self.delay == 0 {
            let mut closed = map.view_mut((0, 0), (2 * N, 2 * N));
            closed += &forced * &feedback;
        } else {
            // The delayed torques, newest first: the oldest one acts, the newest one comes from the control law.
            map.view_mut((0, size - N), (2 * N, N)).copy_from(&forced);
            map.view_mut((2 * N, 0), (N, 2 * N)).copy_from(&feedback);
            for k in 0..(self.delay - 1) * N {
                map[(3 * N + k, 2 * N + k)] = 1.0;
            }
        }
        map
    }

    /// The longest stable period, s, between 10 us and 1 s, to 0.01 %; the loop is stable for all shorter ones.
    #[must_use]
    pub(crate) fn period_max(&self) -> f64 {
        last((1e-5, 1.0), 17, |h| self.spectral_radius(h) < 1.0)
    }

    /// The highest stable natural frequency of all joints, rad/s, at the period `h` (s), between 0.1 / h and 10 / h, to 0.1 %.
    #[must_use]
    pub(crate) fn frequency_max(&self, h: f64) -> f64 {
        last((0.1 / h, 10.0 / h), 13, |frequency| self.with_frequency(frequency).spectral_radius(h) < 1.0)
    }

    /// The matrices `A` and `B`.
    fn continuous(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let turn = Libm.sin_cos_all(&self.posture);
        let inertia: SMatrix<f64, N, N> = mass_matrix(&self.arm, &turn, &self.posture, &Live::zero());
        let mobility = inertia.try_inverse().unwrap_or_else(|| SMatrix::from_element(f64::NAN));
        let mut a = DMatrix::zeros(2 * N, 2 * N);
        let mut b = DMatrix::zeros(2 * N, N);
        let zero = [Dual::zero(); N];
        for j in 0..2 * N {
            let (turn, q, qd) = self.towards(j);
            let torque = dual(&self.arm).inverse_dynamics(&turn, &q, &qd, &zero, &Live::zero());
            let change = mobility * SMatrix::<f64, N, 1>::from_fn(|i, _| -torque[i].slope);
            for i in 0..N {
                a[(N + i, j)] = change[i];
            }
        }
        for i in 0..N {
            a[(i, N + i)] = 1.0;
        }
        b.view_mut((N, 0), (N, N)).copy_from(&mobility);
        (a, b)
    }

    /// `e^(A h)` and `int_0^h e^(A s) ds B`: both are blocks of one exponential.
    fn sampled(&self, h: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let (a, b) = self.continuous();
        let mut whole = DMatrix::zeros(3 * N, 3 * N);
        whole.view_mut((0, 0), (2 * N, 2 * N)).copy_from(&(a * h));
        whole.view_mut((0, 2 * N), (2 * N, N)).copy_from(&(b * h));
        let whole = whole.exp();
        (whole.view((0, 0), (2 * N, 2 * N)).into_owned(), whole.view((0, 2 * N), (2 * N, N)).into_owned())
    }

    /// The feedback matrix `K`.
    fn feedback(&self) -> DMatrix<f64> {
        let mut k = DMatrix::zeros(N, 2 * N);
        let at = self.posture.map(Dual::literal);
        let zero = [Dual::zero(); N];
        let reference = Reference { q: at, qd: zero, qdd: zero };
        let gains = self.gains.map(|g| Gains {
            position: Dual::literal(g.position),
            velocity: Dual::literal(g.velocity),
            inertia: Dual::literal(g.inertia),
        });
        let dynamics = dual(&self.model);
        for j in 0..2 * N {
            let (turn, q, qd) = self.towards(j);
            let through_model = self.law.traits().feedback == FeedbackInertia::Model;
            let held = if through_model {
                computed_torque(&gains, &dynamics, || turn, &reference, (&q, &qd), &Live::zero())
            } else if self.law.traits().carries_weight {
                dynamics.inverse_dynamics(&turn, &q, &zero, &zero, &Live::zero())
            } else {
                zero
            };
            for i in 0..N {
                let weighted = if through_model {
                    zero[i]
                } else {
                    gains[i].inertia * (gains[i].position * (at[i] - q[i]) - gains[i].velocity * qd[i])
                };
                k[(i, j)] = (held[i] + weighted).slope;
            }
        }
        k
    }

    /// The posture at rest as dual numbers, varied along the position (first `N` indices) or the velocity of a joint.
    fn towards(&self, j: usize) -> ([SinCos<Dual>; N], [Dual; N], [Dual; N]) {
        let along = |k: usize| f64::from(u8::from(j == k));
        let q = core::array::from_fn(|i| Dual::new(self.posture[i], along(i)));
        let qd = core::array::from_fn(|i| Dual::new(0.0, along(N + i)));
        let turn = core::array::from_fn(|i| {
            let SinCos { sin, cos } = Libm.sin_cos(self.posture[i]);
            SinCos { sin: Dual::new(sin, cos * along(i)), cos: Dual::new(cos, -sin * along(i)) }
        });
        (turn, q, qd)
    }
}

fn dual<const N: usize>(dynamics: &Dynamics<f64, N>) -> Dynamics<Dual, N> {
    Dynamics::new(dynamics.model().cast(), dynamics.scene().cast())
}

/// Returns the largest number inside `(low, high)` up to which `stable` holds; bisects the interval's logarithm `halvings` times.
pub(crate) fn last((low, high): (f64, f64), halvings: u32, stable: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (libm::log2(low), libm::log2(high));
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if stable(libm::exp2(middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    libm::exp2(low)
}
