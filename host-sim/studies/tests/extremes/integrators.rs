//! The plant's integration methods: their order, their energy errors, and the time until two scalar types disagree about a chaotic arm.
//!
//! A method is a row of `METHODS`; every row is tested on the same falls.

use super::{Cell, Outcome, joints, planar, puma};
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointSpec, Real, Tool, Trig};
use nalgebra::Vector3;
use robot_compiler::scene::Integrator;
use sim::failure::Failure;
use sim::plant::actuator::ActuatorSettings;
use sim::plant::dynamics::Mechanism;
use sim::plant::{Arm, Clock, Plant, State};

const GROUP: &str = "integrators";

/// Length of a tick, s.
const TICK: f64 = 1e-2;
/// Length of a tick for the adaptive method, s. A step cannot extend beyond a tick, and the adaptive steps are longer than the other methods' tick.
const LONG_TICK: f64 = 0.1;

/// Step size or tolerance of a method.
#[derive(Clone, Copy, Debug)]
struct Grain {
    name: &'static str,
    integrator: Integrator,
    clock: Clock,
    /// Step, s; for the adaptive method its tolerance.
    size: f64,
}

impl Grain {
    const fn steps(name: &'static str, integrator: Integrator, steps_per_tick: u32) -> Self {
        Self { name, integrator, clock: Clock { period: TICK, steps_per_tick }, size: TICK / steps_per_tick as f64 }
    }

    const fn tolerance(name: &'static str, tolerance: f64) -> Self {
        let integrator = Integrator::Adaptive { tolerance };
        Self { name, integrator, clock: Clock { period: LONG_TICK, steps_per_tick: 1 }, size: tolerance }
    }
}

/// An integration method of the plant and its expected accuracy.
struct Method {
    name: &'static str,
    /// Order of the position error after one second as a power of the step, and the smallest allowed order of the energy error. For the adaptive
    /// method the power refers to its tolerance.
    order: f64,
    /// Coarse and fine grain for one second.
    order_from: [Grain; 2],
    /// Largest change of energy in one second with the coarse grain, J.
    energy: f64,
    /// Grains for 100 s, with the largest change of energy, J.
    long: [(Grain, f64); 2],
    drift_reason: &'static str,
}

const RUNGE_KUTTA: Integrator = Integrator::RungeKutta;
const EULER: Integrator = Integrator::SemiImplicitEuler;
const LOST: &str = "energy is lost or won";

const METHODS: [Method; 3] = [
    Method {
        name: "Runge-Kutta",
        order: 4.0,
        order_from: [Grain::steps("steps of 2.5 ms", RUNGE_KUTTA, 4), Grain::steps("steps of 1.25 ms", RUNGE_KUTTA, 8)],
        energy: 1e-6,
        long: [
            (Grain::steps("steps of 1 ms", RUNGE_KUTTA, 10), 1e-4),
            (Grain::steps("steps of 2.5 ms", RUNGE_KUTTA, 4), 1e-2),
        ],
        drift_reason: LOST,
    },
    Method {
        name: "semi-implicit Euler",
        order: 1.0,
        order_from: [Grain::steps("steps of 0.16 ms", EULER, 64), Grain::steps("steps of 0.078 ms", EULER, 128)],
        energy: 1.0,
        long: [(Grain::steps("steps of 1 ms", EULER, 10), 1.0), (Grain::steps("steps of 2.5 ms", EULER, 4), 1.0)],
        drift_reason: "the method is symplectic only where the inertia does not change: of an arm that swings freely for a hundred \
                       seconds the energy drifts, the faster the longer the step; it is for seconds",
    },
    Method {
        name: "adaptive",
        order: 1.0,
        order_from: [Grain::tolerance("tolerance 1e-9", 1e-9), Grain::tolerance("tolerance 1e-11", 1e-11)],
        energy: 1e-6,
        long: [(Grain::tolerance("tolerance 1e-9", 1e-9), 1e-4), (Grain::tolerance("tolerance 1e-6", 1e-6), 1e-2)],
        drift_reason: LOST,
    },
];

/// Reference grain for the position errors of the others.
const NEAR: Grain = Grain::steps("steps of 0.16 ms", RUNGE_KUTTA, 64);

/// All cells of this group.
///
/// # Errors
/// A shipped robot cannot be read.
pub(crate) fn cells() -> Result<Vec<Cell>, Failure> {
    let rods = free(joints::<2>(&planar()?)?, Vector3::new(0.0, -9.81, 0.0));
    let six = free(joints::<6>(&puma()?)?, Vector3::new(0.0, 0.0, -9.81));
    let mut cells = Vec::new();
    for method in &METHODS {
        method_cells(&mut cells, method, "planar 2R", &rods, [0.3, 0.5]);
        method_cells(&mut cells, method, "Puma 560", &six, [0.1, 0.4, -0.3, 0.2, 0.5, 0.1]);
    }
    chaos_cells(&mut cells, &rods);
    Ok(cells)
}

fn free<const N: usize>(joints: [JointSpec; N], gravity: Vector3<f64>) -> Arm<N> {
    Arm { joints, tool: Tool::default(), payload: None, gravity, tip_wrench: None }
}

/// Result of a simulated fall.
struct Fall<const N: usize> {
    /// Largest change of energy between two ticks, J.
    energy: f64,
    state: State<N>,
}

/// Releases the arm from `start` and simulates `seconds`; `None` if the plant diverges.
fn fall<const N: usize>(grain: Grain, arm: &Arm<N>, start: [f64; N], seconds: f64) -> Option<Fall<N>> {
    let Grain { integrator, clock, .. } = grain;
    let mut plant = Plant::new(arm, None, ActuatorSettings::default(), clock, start).with_integrator(integrator);
    let energy = |state: &State<N>| arm.kinetic(&state.q, &state.qd) + arm.potential(&state.q);
    let before = energy(plant.state());
    let mut worst = 0.0_f64;
    for _ in 0..libm::round(seconds / clock.period) as u64 {
        plant.drive(&[0.0; N]).ok()?;
        worst = worst.max((energy(plant.state()) - before).abs());
    }
    Some(Fall { energy: worst, state: *plant.state() })
}

fn method_cells<const N: usize>(cells: &mut Vec<Cell>, method: &Method, arm_name: &str, arm: &Arm<N>, start: [f64; N]) {
    let name = format!("{arm_name}, {}", method.name);
    let [from, to] = method.order_from;
    let falls = [from, to, NEAR].map(|grain| fall(grain, arm, start, 1.0));
    let [Some(coarse), Some(fine), Some(near)] = &falls else {
        let outcome = Outcome::words("the plant gave up", "a fall of a second");
        cells.push(Cell::new(GROUP, name, "the free arm falls", outcome, "the plant gave up"));
        return;
    };
    let off = |fall: &Fall<N>| (0..N).fold(0.0_f64, |worst, i| worst.max((fall.state.q[i] - near.state.q[i]).abs()));
    let observed = |coarse: f64, fine: f64| libm::log(coarse / fine) / libm::log(from.size / to.size);
    let order = method.order;
    let mistake = "another order than the method's is a mistake in it";
    cells.push(Cell::new(
        GROUP,
        format!("energy of the free {name}"),
        format!("largest change in a fall of 1 s, {}", from.name),
        Outcome::at_most(coarse.energy, method.energy, "J"),
        LOST,
    ));
    cells.push(Cell::new(
        GROUP,
        format!("order of the energy, {name}"),
        format!("the same, from {} to {}", from.name, to.name),
        Outcome::between(observed(coarse.energy, fine.energy), order - 0.2, order + 1.2, ""),
        mistake,
    ));
    cells.push(Cell::new(
        GROUP,
        format!("order of the position, {name}"),
        format!("position after 1 s against Runge-Kutta's with {}, from {} to {}", NEAR.name, from.name, to.name),
        Outcome::between(observed(off(coarse), off(fine)), order - 0.2, order + 0.2, ""),
        mistake,
    ));
    for (grain, most) in method.long {
        let found = fall(grain, arm, start, 100.0);
        cells.push(Cell::new(
            GROUP,
            format!("energy over 100 s, {}, {name}", grain.name),
            "largest change while the free arm falls and swings",
            found.map_or_else(
                || Outcome::words("the plant gave up", "a hundred seconds"),
                |fall| Outcome::at_most(fall.energy, most, "J"),
            ),
            method.drift_reason,
        ));
    }
}

/// One step of the plant's method in a given scalar type.
fn step<S: Real>(mechanism: &Mechanism<2, S>, q: [S; 2], qd: [S; 2], h: f64) -> ([S; 2], [S; 2])
where
    Polynomial: Trig<S>,
{
    let half = S::literal(0.5 * h);
    let (whole, sixth, two) = (S::literal(h), S::literal(h / 6.0), S::literal(2.0));
    let slope = |q: &[S; 2], qd: &[S; 2]| mechanism.solution(&Polynomial.sin_cos_all(q), q, qd, &[S::zero(); 2]).qdd;
    let along = |x: &[S; 2], v: &[S; 2], h: S| core::array::from_fn(|i| x[i] + v[i] * h);
    let (v1, a1) = (qd, slope(&q, &qd));
    let v2 = along(&qd, &a1, half);
    let a2 = slope(&along(&q, &v1, half), &v2);
    let v3 = along(&qd, &a2, half);
    let a3 = slope(&along(&q, &v2, half), &v3);
    let v4 = along(&qd, &a3, whole);
    let a4 = slope(&along(&q, &v3, whole), &v4);
    let mix = |x: &[S; 2], k: [&[S; 2]; 4]| {
        core::array::from_fn(|i| x[i] + (k[0][i] + two * (k[1][i] + k[2][i]) + k[3][i]) * sixth)
    };
    (mix(&q, [&v1, &v2, &v3, &v4]), mix(&qd, [&a1, &a2, &a3, &a4]))
}

/// Joint angles after every step of 1 ms, rad.
fn path<S: Real>(mechanism: &Mechanism<2>, start: [f64; 2], steps: usize) -> Vec<[f64; 2]>
where
    Polynomial: Trig<S>,
{
    let (mechanism, mut q, mut qd) = (mechanism.cast(), start.map(S::literal), [S::zero(); 2]);
    let mut path = Vec::with_capacity(steps);
    for _ in 0..steps {
        (q, qd) = step(&mechanism, q, qd, 1e-3);
        path.push(q.map(|x| x.to_f64()));
    }
    path
}

/// First time, s, at which two paths differ by `apart` rad; infinite if they never do.
fn parting(one: &[[f64; 2]], other: &[[f64; 2]], apart: f64) -> f64 {
    let near = |a: &[f64; 2], b: &[f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < apart);
    one.iter().zip(other).position(|(a, b)| !near(a, b)).map_or(f64::INFINITY, |step| 1e-3 * (step + 1) as f64)
}

/// Cells of a chaotic fall: the two rods are released level and almost stretched, and so with high potential energy.
fn chaos_cells(cells: &mut Vec<Cell>, arm: &Arm<2>) {
    let mechanism = arm.mechanism();
    // Numbers that single precision represents exactly, so that both scalar types start in the same state.
    let start = [1.25, 0.75];
    let double = path::<f64>(&mechanism, start, 60_000);
    let mut cell = |name: &str, done: &str, time: f64| {
        cells.push(Cell::new(GROUP, name, done, Outcome::record(time, "s"), ""));
    };
    let single = path::<f32>(&mechanism, start, 60_000);
    let done = "let go from (1.25, 0.75) rad, steps of 1 ms, until an angle differs by 0.1 rad";
    cell("chaotic 2R, f32 and f64 part", done, parting(&double, &single, 0.1));
    let beside = path::<f64>(&mechanism, [start[0] * (1.0 + f64::EPSILON), start[1]], 60_000);
    cell(
        "chaotic 2R, one last place apart",
        "the same in f64, one start a last place beside the other",
        parting(&double, &beside, 0.1),
    );
}
