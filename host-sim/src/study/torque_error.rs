//! How wrong the joint torques of single precision are: never more than a proven bound, and at least what was found.
//!
//! The exact torque is that of the robot file's numbers (`f64`) in exact arithmetic, at inputs that `f32` holds. Single
//! precision rounds the constants, computes sine and cosine with [`dynamics_core::trig::Polynomial`], and rounds every
//! operation: all three are in the bound, and in what is found. At level `regrouped` the constants are those that the kernel
//! holds, already in single precision: there the bound is of sine, cosine and arithmetic.
//!
//! - **Found.** Random states and corners of the box, then a climb on the error from the worst of them, both against the same
//!   computation in double-double arithmetic. One seed gives one answer, however many threads there are.
//! - **Proven.** The same computation on [`Bounded`], for boxes of states that together are all of them. The worst box is cut
//!   in two, along the input that helps most, until a number of boxes has been looked at: the bound holds after any number,
//!   and falls with it.

use core::cmp::Ordering;
use core::f64::consts::{FRAC_PI_4, PI, TAU};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, Field, InverseDynamics, JointKind, Live, Model, Scalar, Scene, SinCos, Trig};
use indicatif::ProgressBar;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use robot_compiler::kernel::functions::input_values;
use robot_compiler::kernel::{Function, Level, Precision, Program, compile};
use robot_compiler::precision::{Bounded, Double, DoubleDouble, Rounding, Single};
use std::collections::BinaryHeap;

/// Largest |angle|, rad, and the largest errors of sine and cosine in f32 over every float up to there, as
/// `dynamics-core/tests/trig.rs` measures and asserts them (the table in [`dynamics_core::trig`]).
pub const TRIG_ERROR: [(f64, f64, f64); 4] =
    [(FRAC_PI_4, 6.29e-8, 5.87e-8), (TAU, 8.20e-8, 7.80e-8), (100.0, 8.20e-8, 8.12e-8), (8192.0, 8.20e-8, 8.36e-8)];

/// That test's reference is itself rounded to f64, and ends of ranges to f32.
const TRIG_SLACK: f64 = 1e-15;

/// A motion at one instant, in numbers that `f32` holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// Position, rad or m.
    pub q: [f32; N],
    /// Velocity, rad/s or m/s.
    pub qd: [f32; N],
    /// Acceleration, rad/s^2 or m/s^2.
    pub qdd: [f32; N],
}

/// A box of states: lowest and highest of each input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<const N: usize> {
    /// Position, velocity, acceleration, in the units of [`State`].
    pub inputs: [[(f64, f64); N]; 3],
}

impl<const N: usize> Region<N> {
    /// From limits, rounded to `f32` as the controller holds them; velocity and acceleration in both directions.
    #[must_use]
    pub fn new(q: [(f64, f64); N], qd: [f64; N], qdd: [f64; N]) -> Self {
        let round = |x: f64| f64::from(x as f32);
        let both = |x: f64| (-round(x), round(x));
        Self { inputs: [q.map(|(lo, hi)| (round(lo), round(hi))), qd.map(both), qdd.map(both)] }
    }

    /// A single state.
    #[must_use]
    pub fn of(state: &State<N>) -> Self {
        let point = |x: f32| (f64::from(x), f64::from(x));
        Self { inputs: [state.q, state.qd, state.qdd].map(|all| all.map(point)) }
    }

    /// The two halves along an input, counted through all positions, velocities and accelerations.
    fn halves(&self, input: usize) -> [Self; 2] {
        let (lo, hi) = self.inputs[input / N][input % N];
        let middle = lo + (hi - lo) / 2.0;
        [(lo, middle), (middle, hi)].map(|half| {
            let mut region = *self;
            region.inputs[input / N][input % N] = half;
            region
        })
    }

    /// The state at these shares of each input's range.
    fn state(&self, mut share: impl FnMut() -> f64) -> State<N> {
        let [q, qd, qdd] = self.inputs.map(|all| all.map(|(lo, hi)| clamped(lo + (hi - lo) * share(), (lo, hi))));
        State { q, qd, qdd }
    }
}

/// Ends of a range are numbers of `f32`, so rounding does not leave it.
fn clamped(x: f64, (lo, hi): (f64, f64)) -> f32 {
    x.clamp(lo, hi) as f32
}

/// An arm in a scene in one scalar.
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

/// An arm in a scene, its torques in single precision and what they should be.
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

/// Bounds on the error of a precision `R`, for one state or for all of a region.
#[derive(Clone, Debug)]
pub struct Bounds<'a, R, const N: usize> {
    kind: [JointKind; N],
    kernel: Option<&'a Program>,
    torques: Torques<Bounded<R>, N>,
    trig: Option<(f64, f64)>,
}

impl<const N: usize> TorqueError<N> {
    /// Of a model in a scene, live terms at these values.
    #[must_use]
    pub fn new(model: &Model<f64, N>, scene: &Scene<f64, N>, live: &Live<f64, N>, level: Level) -> Self {
        let kernel = match level {
            // Equal to the recursion's results, so the recursion itself is run.
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

    /// The same in double precision, with libm's sine and cosine.
    #[must_use]
    pub fn double(&self, state: &State<N>) -> [f64; N] {
        let inputs = inputs(state);
        let turn = inputs[0].map(|q| SinCos { sin: libm::sin(q), cos: libm::cos(q) });
        self.double.at(self.kernel.as_ref(), &turn, &inputs)
    }

    /// The same with 27 digits or more.
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

    /// What single precision is wrong by in a state, N m or N.
    #[must_use]
    pub fn error(&self, state: &State<N>) -> [f64; N] {
        let (single, reference) = (self.single(state), self.reference(state));
        core::array::from_fn(|i| reference[i].minus(f64::from(single[i])).abs())
    }

    /// Bounds on it.
    #[must_use]
    pub fn bounds(&self) -> Bounds<'_, Single, N> {
        self.bounds_of(None)
    }

    /// Bounds on what [`Self::double`] is wrong by.
    #[must_use]
    pub fn bounds_of_double(&self) -> Bounds<'_, Double, N> {
        // libm's errors are below a unit in the last place.
        self.bounds_of(Some((f64::EPSILON, f64::EPSILON)))
    }

    /// Bounds with another rounding and, if given, other errors of sine and cosine than [`TRIG_ERROR`].
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
    /// What no state of the region exceeds, N m or N. Infinite where a torque may overflow or an angle is beyond 8192 rad.
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

    /// What no state of the region exceeds, after cutting it into smaller ones: `boxes` of them are looked at for every joint.
    #[must_use]
    pub fn everywhere(&self, region: &Region<N>, boxes: usize, progress: &ProgressBar) -> [f64; N]
    where
        Self: Sync,
    {
        let found: Vec<f64> =
            (0..N).into_par_iter().map(|joint| self.for_joint(joint, region, boxes, progress)).collect();
        core::array::from_fn(|i| found[i])
    }

    fn for_joint(&self, joint: usize, region: &Region<N>, boxes: usize, progress: &ProgressBar) -> f64 {
        let bound = |region: &Region<N>| self.over(region)[joint];
        let mut heap = BinaryHeap::from([Cell { bound: bound(region), region: *region }]);
        let mut looked_at = 1;
        while looked_at < boxes {
            let Some(worst) = heap.pop() else { break };
            // The input along which one half is bounded best; sign changes of velocities cost two cuts to pay.
            let mut best: Option<(f64, [Region<N>; 2], f64)> = None;
            for input in 0..3 * N {
                let (lo, hi) = worst.region.inputs[input / N][input % N];
                if lo + (hi - lo) / 2.0 <= lo {
                    continue;
                }
                let halves = worst.region.halves(input);
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
            // A bound of a region holds for each half of it.
            heap.push(Cell { bound: bound(&lower).min(worst.bound), region: lower });
            heap.push(Cell { bound: value.min(worst.bound), region: upper });
        }
        heap.peek().map_or(f64::INFINITY, |cell| cell.bound)
    }
}

/// Errors of sine and cosine in f32 for angles of a range.
fn trig_error((lo, hi): (f64, f64)) -> (f64, f64) {
    let size = lo.abs().max(hi.abs());
    let row = TRIG_ERROR.iter().find(|(limit, ..)| size <= f64::from(*limit as f32));
    row.map_or((f64::INFINITY, f64::INFINITY), |(_, sin, cos)| (sin + TRIG_SLACK, cos + TRIG_SLACK))
}

/// A region that waits to be cut, the worst first.
struct Cell<const N: usize> {
    bound: f64,
    region: Region<N>,
}

impl<const N: usize> Ord for Cell<N> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl<const N: usize> PartialOrd for Cell<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<const N: usize> PartialEq for Cell<N> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<const N: usize> Eq for Cell<N> {}

/// How hard to look for a large error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Random states.
    pub samples: usize,
    /// Climbs for every joint.
    pub climbs: usize,
    /// Steps of each climb.
    pub steps: usize,
    /// Of everything random.
    pub seed: u64,
}

/// The largest value of something that was found for a joint, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found<const N: usize> {
    /// N m or N.
    pub value: f64,
    /// The state.
    pub state: State<N>,
}

/// Random states are drawn in lots, each with a stream of its own, so that threads do not change what is drawn.
const LOT: usize = 1000;

/// Random states of a region, lot after lot: every second one with each input at an end of its range, or anywhere, by chance.
pub fn random_states<const N: usize>(region: &Region<N>, seed: u64, lot: usize) -> impl Iterator<Item = State<N>> {
    let (region, mut random) = (*region, generator(seed, lot as u64));
    (0..LOT).map(move |k| {
        region.state(|| {
            let share = share(&mut random);
            match (k % 2, random.next_u32() % 4) {
                (1, 0) => 0.0,
                (1, 1) => 1.0,
                _ => share,
            }
        })
    })
}

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random
}

/// From 0 to 1.
fn share(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Look for the states in which `what` is largest for each joint: random ones, then uphill from the worst.
pub fn search<const N: usize>(
    region: &Region<N>,
    effort: &Effort,
    what: impl Fn(&State<N>) -> [f64; N] + Sync,
    progress: &ProgressBar,
) -> [Found<N>; N] {
    let lots = effort.samples.div_ceil(LOT).max(1);
    let worst_of_lot = |lot: usize| {
        let mut worst: Option<[Found<N>; N]> = None;
        for state in random_states(region, effort.seed, lot) {
            let value = what(&state);
            let worst = worst.get_or_insert_with(|| value.map(|value| Found { value, state }));
            for (worst, value) in worst.iter_mut().zip(value) {
                if value > worst.value {
                    *worst = Found { value, state };
                }
            }
        }
        progress.inc(LOT as u64);
        worst
    };
    let lots: Vec<[Found<N>; N]> = (0..lots).into_par_iter().filter_map(worst_of_lot).collect();
    core::array::from_fn(|joint| {
        let mut starts: Vec<Found<N>> = lots.iter().map(|lot| lot[joint]).collect();
        starts.sort_by(|a, b| b.value.total_cmp(&a.value));
        let first = starts[0];
        let climbs: Vec<Found<N>> = (0..effort.climbs)
            .into_par_iter()
            .map(|k| {
                let stream = (1 << 40) + (joint * effort.climbs + k) as u64;
                let start = starts[k % starts.len()];
                let top =
                    climb(region, start, effort.steps, generator(effort.seed, stream), |state| what(state)[joint]);
                progress.inc(effort.steps as u64);
                top
            })
            .collect();
        climbs.into_iter().fold(first, |best, next| if next.value > best.value { next } else { best })
    })
}

/// Steps in random directions, at most three inputs at a time, from a third of the range down to a few units in the last
/// place: the error rises with the torques and jumps from float to float, and each size of step finds another part of that.
fn climb<const N: usize>(
    region: &Region<N>,
    start: Found<N>,
    steps: usize,
    mut random: ChaCha8Rng,
    what: impl Fn(&State<N>) -> f64,
) -> Found<N> {
    let mut best = start;
    for step in 0..steps {
        let size = 0.3 * 10.0_f64.powf(-6.0 * step as f64 / steps as f64);
        let mut state = best.state;
        for _ in 0..=random.next_u32() % 3 {
            let input = random.next_u32() as usize % (3 * N);
            let (lo, hi) = region.inputs[input / N][input % N];
            let entry = match input / N {
                0 => &mut state.q[input % N],
                1 => &mut state.qd[input % N],
                _ => &mut state.qdd[input % N],
            };
            let by = (hi - lo) * size * (2.0 * share(&mut random) - 1.0);
            *entry = clamped(f64::from(*entry) + by, (lo, hi));
        }
        let value = what(&state);
        if value > best.value {
            best = Found { value, state };
        }
    }
    best
}

/// Where a joint may stand: its limits, one turn where it has none; `None` for a slide without limits.
#[must_use]
pub fn positions(kind: JointKind, limits: (f64, f64)) -> Option<(f64, f64)> {
    match (kind, limits.0.is_finite(), limits.1.is_finite()) {
        (_, true, true) => Some(limits),
        (JointKind::Prismatic, ..) => None,
        (_, true, false) => Some((limits.0, limits.0 + TAU)),
        (_, false, true) => Some((limits.1 - TAU, limits.1)),
        (_, false, false) => Some((-PI, PI)),
    }
}
