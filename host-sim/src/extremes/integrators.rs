//! The plant's Runge-Kutta method: its order, the energy it keeps, and how long two scalars agree about a chaotic arm.

use super::{Cell, Outcome, joints, planar, puma};
use crate::exit::Failure;
use crate::plant::actuator::ActuatorSettings;
use crate::plant::dynamics::Mechanism;
use crate::plant::{Arm, Clock, Plant, State};
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointSpec, Real, Tool, Trig};
use nalgebra::Vector3;

const GROUP: &str = "integrators";

/// Every cell.
///
/// # Errors
/// A shipped robot cannot be read.
pub fn cells() -> Result<Vec<Cell>, Failure> {
    let rods = free(joints::<2>(&planar()?)?, Vector3::new(0.0, -9.81, 0.0));
    let six = free(joints::<6>(&puma()?)?, Vector3::new(0.0, 0.0, -9.81));
    let mut cells = Vec::new();
    order_cells(&mut cells, "planar 2R", &rods, [0.3, 0.5]);
    order_cells(&mut cells, "Puma 560", &six, [0.1, 0.4, -0.3, 0.2, 0.5, 0.1]);
    chaos_cells(&mut cells, &rods);
    Ok(cells)
}

fn free<const N: usize>(joints: [JointSpec; N], gravity: Vector3<f64>) -> Arm<N> {
    Arm { joints, tool: Tool::default(), payload: None, gravity, tip_wrench: None }
}

fn plant<const N: usize>(arm: &Arm<N>, steps: u32, start: [f64; N]) -> Plant<N> {
    Plant::new(arm, None, ActuatorSettings::default(), Clock { period: 1e-2, steps_per_tick: steps }, start)
}

/// Largest change of energy (J) and the state after a fall of one second; `None` where the plant gives up.
fn fall<const N: usize>(arm: &Arm<N>, steps: u32, start: [f64; N], ticks: u32) -> Option<(f64, State<N>)> {
    let mut plant = plant(arm, steps, start);
    let energy = |state: &State<N>| arm.kinetic(&state.q, &state.qd) + arm.potential(&state.q);
    let before = energy(plant.state());
    let mut worst = 0.0_f64;
    for _ in 0..ticks {
        plant.drive(&[0.0; N]).ok()?;
        worst = worst.max((energy(plant.state()) - before).abs());
    }
    Some((worst, *plant.state()))
}

fn order_cells<const N: usize>(cells: &mut Vec<Cell>, name: &str, arm: &Arm<N>, start: [f64; N]) {
    let falls: Option<Vec<_>> = [4, 8, 64].into_iter().map(|steps| fall(arm, steps, start, 100)).collect();
    let Some([(coarse, at_coarse), (fine, at_fine), (_, near)]) =
        falls.and_then(|falls| <[_; 3]>::try_from(falls).ok())
    else {
        let outcome = Outcome::words("the plant gave up", "a fall of a second");
        cells.push(Cell::new(GROUP, name, "the free arm falls", outcome, "the plant gave up"));
        return;
    };
    let off = |at: &State<N>| (0..N).fold(0.0_f64, |worst, i| worst.max((at.q[i] - near.q[i]).abs()));
    let order = |coarse: f64, fine: f64| libm::log2(coarse / fine);
    let fourth = "the method is of fourth order; another order is a mistake in it";
    cells.push(Cell::new(
        GROUP,
        format!("energy of the free {name}"),
        "largest change in a fall of 1 s, steps of 2.5 ms",
        Outcome::at_most(coarse, 1e-6, "J"),
        "energy is lost or won",
    ));
    cells.push(Cell::new(
        GROUP,
        format!("order of the energy, {name}"),
        "the same, from steps of 2.5 to 1.25 ms",
        Outcome::between(order(coarse, fine), 3.8, 5.2, ""),
        fourth,
    ));
    cells.push(Cell::new(
        GROUP,
        format!("order of the position, {name}"),
        "position after 1 s against steps of 0.16 ms, from steps of 2.5 to 1.25 ms",
        Outcome::between(order(off(&at_coarse), off(&at_fine)), 3.8, 4.2, ""),
        fourth,
    ));
    let long = fall(arm, 10, start, 1000).map_or(f64::NAN, |(worst, _)| worst);
    cells.push(Cell::new(
        GROUP,
        format!("energy of the free {name}, 10 s"),
        "largest change in a fall of 10 s, steps of 1 ms",
        Outcome::at_most(long, 1e-4, "J"),
        "energy is lost or won",
    ));
}

/// A state in a scalar, one step of the plant's method on.
fn step<S: Real>(mechanism: &Mechanism<2>, q: [S; 2], qd: [S; 2], h: f64) -> ([S; 2], [S; 2])
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

/// Joint angles after every step of a millisecond.
fn path<S: Real>(mechanism: &Mechanism<2>, start: [f64; 2], steps: usize) -> Vec<[f64; 2]>
where
    Polynomial: Trig<S>,
{
    let (mut q, mut qd) = (start.map(S::literal), [S::zero(); 2]);
    let mut path = Vec::with_capacity(steps);
    for _ in 0..steps {
        (q, qd) = step(mechanism, q, qd, 1e-3);
        path.push(q.map(|x| x.to_f64()));
    }
    path
}

/// First time, s, at which two paths are `apart` rad from each other; infinite if never.
fn parting(one: &[[f64; 2]], other: &[[f64; 2]], apart: f64) -> f64 {
    let near = |a: &[f64; 2], b: &[f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < apart);
    one.iter().zip(other).position(|(a, b)| !near(a, b)).map_or(f64::INFINITY, |step| 1e-3 * (step + 1) as f64)
}

/// The two rods let go level and stretched, a little bent: all of their energy for a chaotic fall.
fn chaos_cells(cells: &mut Vec<Cell>, arm: &Arm<2>) {
    let mechanism = arm.mechanism();
    // What single precision holds, so that both start in the same state.
    let start = [1.25, 0.75];
    let double = path::<f64>(&mechanism, start, 60_000);
    let mut cell = |name: &str, done: &str, time: f64, least: f64| {
        let outcome = Outcome::between(time, least, f64::INFINITY, "s");
        cells.push(Cell::new(GROUP, name, done, outcome, "two computations part sooner than rounding explains"));
    };
    let single = path::<f32>(&mechanism, start, 60_000);
    let done = "let go from (1.25, 0.75) rad, steps of 1 ms, until an angle differs by 0.1 rad";
    cell("chaotic 2R, f32 and f64 part", done, parting(&double, &single, 0.1), 1.0);
    let beside = path::<f64>(&mechanism, [start[0] * (1.0 + f64::EPSILON), start[1]], 60_000);
    cell(
        "chaotic 2R, one last place apart",
        "the same in f64, one start a last place beside the other",
        parting(&double, &beside, 0.1),
        5.0,
    );
}
