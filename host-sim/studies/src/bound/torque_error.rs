//! Error of single precision in a state, and bounds on it.

use super::region::{Region, State};
use crate::ranked::Ranked;
use core::f64::consts::{FRAC_PI_4, TAU};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, Field, InverseDynamics, JointKind, Live, Model, Scalar, Scene, SinCos, Trig};
use indicatif::ProgressBar;
use robot_compiler::kernel::inputs::input_values;
use robot_compiler::kernel::{Function, Level, Precision, Program, compile};
use robot_compiler::precision::{Bounded, DoubleDouble, Rounding, Single};
use sim::parallel::in_parallel;
use std::collections::BinaryHeap;

/// Largest |angle|, rad, and the largest errors of sine and cosine in f32 over every float up to it.
/// `dynamics-core/tests/trig.rs` measures and asserts these errors (the table in [`dynamics_core::trig`]).
pub const TRIG_ERROR: [(f64, f64, f64); 4] =
    [(FRAC_PI_4, 6.29e-8, 5.87e-8), (TAU, 8.20e-8, 7.80e-8), (100.0, 8.20e-8, 8.12e-8), (8192.0, 8.20e-8, 8.36e-8)];

/// Allowance for rounding: the test's reference is rounded to f64, and ends of ranges are rounded to f32.
const TRIG_SLACK: f64 = 1e-15;

/// An arm in a scene, in one scalar type.
#[derive(Clone, Debug)]
struct Torques<S, const N: usize> {
    dynamics: Dynamics<S, N>,
    live: Live<S, N>,
}

impl<S: Field, const N: usize> Torques<S, N> {
    fn new(model: &Model<f64, N>, scene: &Scene<f64, N>, live: &Live<f64, N>) -> Self {
        Self { dynamics: Dynamics::new(model.cast(), scene.cast()), live: live.cast() }
    }

    fn at(&self, kernel: Option<&Program>, turn: &[SinCos<S>; N], [q, qd, qdd]: &[[S; N]; 3]) -> [S; N] {
        match kernel {
            None => self.dynamics.inverse_dynamics(turn, q, qd, qdd, &self.live),
            Some(kernel) => {
                let found = kernel.evaluate(&input_values(turn, q, qd, qdd, &self.live));
                core::array::from_fn(|i| found[i])
            }
        }
    }
}

/// An arm in a scene, with its torques in single precision and its exact ones.
#[derive(Clone, Debug)]
pub struct TorqueError<const N: usize> {
    kind: [JointKind; N],
    kernel: Option<Program>,
    model: Model<f64, N>,
    scene: Scene<f64, N>,
    live: Live<f64, N>,
    single: Torques<f32, N>,
    double: Torques<f64, N>,
    reference: Torques<DoubleDouble, N>,
}

/// Bounds on the error of a precision `R`, for one state or for a whole region.
#[derive(Clone, Debug)]
pub struct Bounds<'a, R, const N: usize> {
    kind: [JointKind; N],
    kernel: Option<&'a Program>,
    torques: Torques<Bounded<R>, N>,
    trig: Option<(f64, f64)>,
}

impl<const N: usize> TorqueError<N> {
    /// Torque errors of a model in a scene, with these values of the live terms.
    #[must_use]
    pub fn new(model: &Model<f64, N>, scene: &Scene<f64, N>, live: &Live<f64, N>, level: Level) -> Self {
        let kernel = match level {
            // The exact kernel's results equal the recursion's, so the recursion itself is evaluated.
            Level::Exact => None,
            Level::Regrouped => Some(compile(Function::InverseDynamics, model, scene, level, Precision::of::<f32>())),
        };
        Self {
            kind: model.links().map(|link| link.kind),
            kernel,
            model: *model,
            scene: *scene,
            live: *live,
            single: Torques::new(model, scene, live),
            double: Torques::new(model, scene, live),
            reference: Torques::new(model, scene, live),
        }
    }

    /// Torques in single precision, N m or N.
    #[must_use]
    pub fn single(&self, state: &State<N>) -> [f32; N] {
        let State { q, qd, qdd } = *state;
        self.single.at(self.kernel.as_ref(), &Polynomial.sin_cos_all(&q), &[q, qd, qdd])
    }

    /// Torques in double precision with libm's sine and cosine, N m or N.
    #[must_use]
    pub fn double(&self, state: &State<N>) -> [f64; N] {
        let inputs = inputs(state);
        let turn = inputs[0].map(|q| SinCos { sin: libm::sin(q), cos: libm::cos(q) });
        self.double.at(self.kernel.as_ref(), &turn, &inputs)
    }

    /// Torques with at least 27 digits, N m or N.
    #[must_use]
    pub fn reference(&self, state: &State<N>) -> [DoubleDouble; N] {
        let inputs = inputs(state);
        let zero = SinCos { sin: DoubleDouble::literal(0.0), cos: DoubleDouble::literal(1.0) };
        let turn = core::array::from_fn(|i| match self.kind[i] {
            JointKind::Revolute => DoubleDouble::sin_cos(inputs[0][i]),
            JointKind::Prismatic => zero,
        });
        self.reference.at(self.kernel.as_ref(), &turn, &inputs.map(|all| all.map(DoubleDouble::literal)))
    }

    /// Error of single precision in a state, N m or N.
    #[must_use]
    pub fn error(&self, state: &State<N>) -> [f64; N] {
        let (single, reference) = (self.single(state), self.reference(state));
        core::array::from_fn(|i| reference[i].minus(f64::from(single[i])).abs())
    }

    /// Bounds on the error of single precision.
    #[must_use]
    pub fn bounds(&self) -> Bounds<'_, Single, N> {
        self.bounds_of(None)
    }

    /// Bounds with another rounding. If `trig` is given, its errors of sine and cosine replace [`TRIG_ERROR`].
    #[must_use]
    pub fn bounds_of<R: Rounding>(&self, trig: Option<(f64, f64)>) -> Bounds<'_, R, N> {
        let torques = Torques::new(&self.model, &self.scene, &self.live);
        Bounds { kind: self.kind, kernel: self.kernel.as_ref(), torques, trig }
    }
}

fn inputs<const N: usize>(state: &State<N>) -> [[f64; N]; 3] {
    [state.q, state.qd, state.qdd].map(|all| all.map(f64::from))
}

impl<R: Rounding, const N: usize> Bounds<'_, R, N> {
    /// Bound for all states of the region, N m or N. Infinite if a torque may overflow or an angle exceeds 8192 rad.
    #[must_use]
    pub fn over(&self, region: &Region<N>) -> [f64; N] {
        let [q, ..] = region.inputs;
        let turn = core::array::from_fn(|i| match self.kind[i] {
            JointKind::Revolute => Bounded::sin_cos(i, q[i], self.trig.unwrap_or_else(|| trig_error(q[i]))),
            JointKind::Prismatic => SinCos { sin: Bounded::exact(0.0, 0.0), cos: Bounded::exact(1.0, 1.0) },
        });
        let inputs = region.inputs.map(|all| all.map(|(lo, hi)| Bounded::exact(lo, hi)));
        self.torques.at(self.kernel, &turn, &inputs).map(|torque| torque.error())
    }

    /// Bound for all states of the region after it is cut into smaller ones, N m or N. `boxes` regions are evaluated for every joint.
    #[must_use]
    pub fn everywhere(&self, region: &Region<N>, boxes: usize, progress: &ProgressBar) -> [f64; N]
    where
        Self: Sync,
    {
        let found: Vec<f64> = in_parallel(N, |joint| self.for_joint(joint, region, boxes, progress));
        core::array::from_fn(|i| found[i])
    }

    fn for_joint(&self, joint: usize, region: &Region<N>, boxes: usize, progress: &ProgressBar) -> f64 {
        let bound = |region: &Region<N>| self.over(region)[joint];
        // Regions that are still to be cut, ordered by their bounds.
        let mut heap = BinaryHeap::from([Ranked { rank: bound(region), item: *region }]);
        let mut looked_at = 1;
        while looked_at < boxes {
            let Some(worst) = heap.pop() else { break };
            // Cut the input that gives the best bound in one half, because sign changes of velocities pay off only after two cuts.
            let mut best: Option<(f64, [Region<N>; 2], f64)> = None;
            for input in 0..3 * N {
                let (lo, hi) = worst.item.inputs[input / N][input % N];
                if lo + (hi - lo) / 2.0 <= lo {
                    continue;
                }
                let halves = worst.item.halves(input);
                let value = bound(&halves[1]);
                looked_at += 1;
                if best.as_ref().is_none_or(|(least, ..)| value < *least) {
                    best = Some((value, halves, value));
                }
            }
            let Some((_, [lower, upper], value)) = best else {
                heap.push(worst);
                break;
            };
            looked_at += 1;
            progress.inc(3 * N as u64 + 1);
            // A bound of a region also holds for each half of it.
            heap.push(Ranked { rank: bound(&lower).min(worst.rank), item: lower });
            heap.push(Ranked { rank: value.min(worst.rank), item: upper });
        }
        heap.peek().map_or(f64::INFINITY, |worst| worst.rank)
    }
}

/// Errors of sine and cosine in f32 for the angles of a range.
fn trig_error((lo, hi): (f64, f64)) -> (f64, f64) {
    let size = lo.abs().max(hi.abs());
    let row = TRIG_ERROR.iter().find(|(limit, ..)| size <= f64::from(*limit as f32));
    row.map_or((f64::INFINITY, f64::INFINITY), |(_, sin, cos)| (sin + TRIG_SLACK, cos + TRIG_SLACK))
}
