//! Steps from 1 us to 50 ms, a million ticks, a slow encoder, and a whole day.

use super::{Cell, Outcome, planar, scalar_name};
use dynamics_core::control::TrackingObserver;
use dynamics_core::{Command, Measurement, Real, Sensed, Term};
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::{MotionSpec, ViaPoint};
use sim::failure::Failure;
use sim::plant::sensor::Sample;
use sim::run::closed_loop::World;
use sim::run::scene_world;
use sim::run::simulate;
use std::f64::consts::TAU;

const GROUP: &str = "time";

/// One million ticks.
const MANY: u64 = 1_000_000;

/// All cells of this group except the long ones.
///
/// # Errors
/// The shipped robot cannot be read.
pub(crate) fn cells() -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::new();
    phase_cells(&mut cells)?;
    for period in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 5e-2] {
        loop_cell(&mut cells, period)?;
        observer_cell::<f32>(&mut cells, period);
        observer_cell::<f64>(&mut cells, period);
    }
    slow_encoder_cells::<f32>(&mut cells);
    slow_encoder_cells::<f64>(&mut cells);
    Ok(cells)
}

/// The planar arm in a vertical plane, in a repeated back-and-forth motion.
fn swing(period: f64) -> Result<SceneFile, Failure> {
    let mut scene = SceneFile::default_for(planar()?);
    let gravity = Vector3::new(0.0, -9.81, 0.0);
    let point = |q: [f64; 2], duration| ViaPoint { q: q.to_vec(), duration, dwell: 0.0 };
    scene.model.gravity = Term::Constant(gravity);
    scene.plant.gravity = gravity;
    scene.plant.start = vec![-1.57, 0.0];
    scene.plant.step = period.min(1e-3);
    scene.control.rate = 1.0 / period;
    scene.control.natural_frequency = vec![10.0; 2];
    scene.motion = MotionSpec::Quintic {
        points: vec![point([-1.57, 0.0], None), point([-0.6, 0.8], Some(0.9)), point([-1.57, 0.0], Some(0.9))],
        acceleration: None,
        repeat: true,
    };
    Ok(scene)
}

/// Cells that compare ticks with time, and the phase of a repeated motion.
fn phase_cells(cells: &mut Vec<Cell>) -> Result<(), Failure> {
    let world = scene_world::world::<2>(&swing(1e-3)?)?;
    let (mut clock, mut summed, mut sum) = (0.0_f64, 0.0_f64, 0.0_f64);
    for tick in 0..=MANY {
        // 1000 is exact, so this is the floating-point number nearest to the time.
        let exact = tick as f64 / 1000.0;
        clock = clock.max((tick as f64 * world.period - exact).abs());
        summed = summed.max((sum - exact).abs());
        sum += world.period;
    }
    let done = "a million ticks of 1 ms, against ticks / 1000";
    cells.push(Cell::new(GROUP, "clock drift", done, Outcome::at_most(clock, 1e-12, "s"), "time drifts"));
    let done = "the same, had the loop added periods up: what it does not do";
    cells.push(Cell::new(GROUP, "clock drift, had it been summed", done, Outcome::record(summed, "s"), "time drifts"));
    let mut worst = 0.0_f64;
    for step in 0..MANY / 7 {
        let tick = step * 7;
        // One cycle has 1,800 ticks, computed in integers.
        let wanted = world.motion.sample((tick % 1800) as f64 / 1000.0);
        let found = world.reference(tick as f64 * world.period);
        worst = (0..2).fold(worst, |worst, i| worst.max((wanted.q[i] - found.q[i]).abs()));
    }
    let done = "reference of a motion of 1.8 s repeated for a million ticks, against the phase in whole ticks";
    cells.push(Cell::new(
        GROUP,
        "phase of a repeated motion",
        done,
        Outcome::at_most(worst, 1e-9, "rad"),
        "the phase drifts",
    ));
    Ok(())
}

/// Runs a loop; `each` receives the largest error of the state in every tick. Returns the reason if the run ended early.
fn run(
    world: &mut World<2>,
    scene: &SceneFile,
    ticks: u64,
    mut each: impl FnMut(f64),
) -> Result<Option<String>, Failure> {
    let model = scene.robot.model::<2>().map_err(Failure::input)?;
    let mut controller = simulate::desk::<f32, 2>(scene, &model);
    for tick in 0..ticks {
        let reference = world.reference(tick as f64 * world.period);
        let state = *world.plant.state();
        each((0..2).fold(0.0_f64, |worst, i| worst.max((reference.q[i] - state.q[i]).abs())));
        let reading = world.sensors.read(&state);
        let sensed = match reading.sample {
            Sample::State(state) => Sensed::State { q: state.q.map(|x| x as f32), qd: state.qd.map(|x| x as f32) },
            Sample::Counts(counts) => Sensed::Counts(counts),
        };
        match controller.tick(&reference.cast::<f32>(), &Measurement { sensed, age_ticks: reading.age_ticks }) {
            Command::Brake(fault) => return Ok(Some(fault.to_string())),
            Command::Drive { torque, .. } => {
                if let Err(diverged) = world.plant.drive(&torque.map(f64::from)) {
                    return Ok(Some(diverged.to_string()));
                }
            }
        }
    }
    Ok(None)
}

/// Cell of the closed loop at one period.
fn loop_cell(cells: &mut Vec<Cell>, period: f64) -> Result<(), Failure> {
    let scene = swing(period)?;
    let mut world = scene_world::world::<2>(&scene)?;
    // One cycle of the motion, or the part of it that the ticks cover.
    let ticks = libm::round(1.8 / period).min(4000.0) as u64;
    let mut worst = 0.0_f64;
    let ended = run(&mut world, &scene, ticks, |error| worst = worst.max(error))?;
    let outcome = match ended {
        None => Outcome::at_most(worst, 0.05, "rad"),
        Some(ended) => Outcome::words(ended, "the motion to its end"),
    };
    cells.push(Cell::new(
        GROUP,
        format!("loop with a period of {period:e} s"),
        format!("planar 2R swinging, f32, 10 rad/s, {ticks} ticks: largest tracking error"),
        outcome,
        "the loop is too slow for the motion",
    ));
    Ok(())
}

/// Cell of the observer at one period: the estimated speed of a joint that moves steadily at 0.1 rad/s near 1 rad.
fn observer_cell<S: Real>(cells: &mut Vec<Cell>, period: f64) {
    const SPEED: f64 = 0.1;
    const BANDWIDTH: f64 = 500.0;
    let observer = TrackingObserver::<S>::new(BANDWIDTH, period);
    // 30 time constants to settle, then 200 ticks.
    let settle = libm::ceil(30.0 / (BANDWIDTH * period)) as u32 + 10;
    let position = |tick: u32| S::literal(1.0 + SPEED * period * f64::from(tick));
    let (mut x, mut v) = (position(0), S::literal(0.0));
    let mut worst = 0.0_f64;
    for tick in 1..settle + 200 {
        (x, v) = observer.step(x, v, S::zero(), position(tick));
        if tick >= settle {
            worst = worst.max((v.to_f64() / SPEED - 1.0).abs());
        }
    }
    cells.push(Cell::new(
        GROUP,
        format!("observed speed with a period of {period:e} s, {}", scalar_name::<S>()),
        "0.1 rad/s about 1 rad, bandwidth 500 rad/s, after thirty time constants: largest error over the speed",
        Outcome::at_most(worst, 0.01, ""),
        "in f32 the last place of the position, 1.2e-7 rad, is as large as what 0.1 rad/s moves in a microsecond: the estimate \
         follows the rounding",
    ));
}

/// Cells of an encoder that advances by one count in 100 ticks.
fn slow_encoder_cells<S: Real>(cells: &mut Vec<Cell>) {
    const EVERY: u32 = 100;
    let (period, per_count) = (1e-3, TAU / 65_536.0);
    let observer = TrackingObserver::<S>::new(500.0, period);
    let speed = per_count / (f64::from(EVERY) * period);
    let (mut x, mut v) = (S::zero(), S::zero());
    let (mut sum, mut most, mut least) = (0.0_f64, 0.0_f64, 0.0_f64);
    const ROUNDS: u32 = 100;
    for tick in 0..EVERY * ROUNDS * 2 {
        let position = S::from_i32((tick / EVERY) as i32) * S::literal(per_count);
        (x, v) = observer.step(x, v, S::zero(), position);
        if tick >= EVERY * ROUNDS {
            let ratio = v.to_f64() / speed;
            sum += ratio;
            most = most.max(ratio);
            least = least.min(ratio);
        }
    }
    let scalar = scalar_name::<S>();
    let mean = sum / f64::from(EVERY * ROUNDS);
    let done = "one count of 65,536 a turn in 100 ticks of 1 ms, bandwidth 500 rad/s";
    let mut cell = |name: &str, what: &str, outcome, reason: &str| {
        cells.push(Cell::new(
            GROUP,
            format!("slow encoder, {name}, {scalar}"),
            format!("{done}: {what}"),
            outcome,
            reason,
        ));
    };
    cell("mean", "error of the mean over the speed", Outcome::at_most((mean - 1.0).abs(), 1e-3, ""), "the mean is off");
    let bare = f64::from(EVERY);
    let reason = "more than a bare difference of counts would give";
    cell("peak", "highest estimate over the speed", Outcome::between(most, 1.0, bare, ""), reason);
    cell(
        "trough",
        "lowest estimate over the speed",
        Outcome::between(least, -0.05, 1.0, ""),
        "the estimate turns back",
    );
}

/// Cells that take minutes: a million ticks of 1 us, and `hours` of simulated time at 1 kHz.
///
/// # Errors
/// The shipped robot cannot be read.
pub(crate) fn long_cells(hours: f64) -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::new();
    let scene = swing(1e-6)?;
    let mut world = scene_world::world::<2>(&scene)?;
    let mut worst = 0.0_f64;
    let ended = run(&mut world, &scene, MANY, |error| worst = worst.max(error))?;
    let outcome = ended.map_or(Outcome::at_most(worst, 0.05, "rad"), |ended| Outcome::words(ended, "a million ticks"));
    let done = "planar 2R swinging, f32, 10 rad/s, a million ticks of 1 us: largest tracking error";
    cells.push(Cell::new(GROUP, "loop over a million ticks", done, outcome, "the loop drifts"));
    hours_cells(&mut cells, hours)?;
    Ok(cells)
}

/// Cells of `hours` at 1 kHz, with an energy balance.
fn hours_cells(cells: &mut Vec<Cell>, hours: f64) -> Result<(), Failure> {
    let scene = swing(1e-3)?;
    let mut world = scene_world::world::<2>(&scene)?;
    world.plant.start_ledger();
    let ticks = libm::round(hours * 3600.0 / world.period) as u64;
    let (mut tick, mut first, mut last) = (0_u64, 0.0_f64, 0.0_f64);
    let round = 1800;
    let ended = run(&mut world, &scene, ticks, |error| {
        if (round..2 * round).contains(&tick) {
            first = first.max(error);
        } else if tick + round >= ticks {
            last = last.max(error);
        }
        tick += 1;
    })?;
    let arm = scene_world::arm::<2>(&scene)?;
    let (Some(ledger), None) = (world.plant.ledger(), &ended) else {
        let outcome = Outcome::words(ended.unwrap_or_default(), "the motion to its end");
        cells.push(Cell::new(GROUP, format!("{hours} h at 1 kHz"), "planar 2R swinging", outcome, "the run ended"));
        return Ok(());
    };
    let energy = |q: &[f64; 2], qd: &[f64; 2]| arm.kinetic(q, qd) + arm.potential(q);
    let gain = energy(&ledger.end.q, &ledger.end.qd) - energy(&ledger.start.q, &ledger.start.qd);
    let given: f64 = ledger.actuators.total().iter().sum();
    let meter = &ledger.actuators;
    let turnover: f64 = meter.positive().iter().chain(meter.negative()).map(|x| x.abs()).sum();
    let what = format!("planar 2R swinging, f32, {hours} h of simulated time at 1 kHz");
    let mut add = |name: &str, done: &str, value: f64, most: f64, unit, reason: &str| {
        let outcome = Outcome::at_most(value, most, unit);
        cells.push(Cell::new(GROUP, format!("{name}, {hours} h"), format!("{what}: {done}"), outcome, reason));
    };
    let closes = "the ledger does not close";
    add("energy ledger", "work less gain of energy, over all work", (given - gain).abs() / turnover, 1e-4, "", closes);
    add("work", "all of it, each sign counted as positive", turnover, f64::INFINITY, "J", "");
    add(
        "last round against the second",
        "largest tracking errors, relative difference",
        (last / first - 1.0).abs(),
        1e-3,
        "",
        "the motion drifts",
    );
    Ok(())
}
