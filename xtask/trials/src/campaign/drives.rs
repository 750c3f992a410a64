//! Runs whose joints are drives on simulated CAN buses: the session, the board's own drivers of the joints, the drives, and the arm that they
//! carry.
//!
//! ```text
//! host -> frames -> session -> joint-io -> buses -> drives -> arm under gravity, brakes, stops
//!                      ^           ^         |
//!                      |           +-- fault +-> replies          the judge looks at the arm and at the drives
//! ```
//!
//! | module | holds |
//! |---|---|
//! | `injection` | one fault of drives, buses or host |
//! | `judge` | the safety of the motion, written from docs/safety.md |
//! | `broken` | boards that are broken on purpose |
//!
//! Every tick is the firmware's own [`joint_io::run_tick`]. Each joint has a stop at either limit: an arm without brakes lies on those of its
//! rest pose until it is armed, and falls onto them.

mod broken;
mod injection;
mod judge;

pub use broken::Breakage;

use super::case::{Case, FaultKind, Situation};
use super::host::Host;
use super::judge::{Law, Unsafe};
use super::machine::Desk;
use super::outcome::{Finished, Number, Outcome};
use super::random::Random;
use super::script::{Script, Stop, finish};
use super::stage::Stage;
use actuator_model::mit::Shaft;
use board::chip::hello;
use board::session::states::{ARMING, HOMING, RUNNING};
use broken::{Faulty, Memory, without_timeouts};
use dynamics_core::Reference;
use dynamics_core::safety::SafeAction;
use injection::{Board, Injection};
use judge::{Judge, Known, Truth};
use link::codec::FrameTooLong;
use link::{Frame, Hello, Pacing, Status};
use robot_compiler::SceneFile;
use robot_compiler::drive::Protocol;
use session::readings::Lines;
use sim::failure::Failure;
use sim::plant::{Arm, Diverged, State};
use sim::run::simulate;
use sim::run::world::World;

/// Depth, rad, to which a joint's greatest torque presses it into its stop.
const STOP_DEPTH: f64 = 0.02;

/// Time that the simulated brakes need to engage after they lose power, s; they open at once.
pub const BRAKES_ENGAGE: f64 = 0.08;

/// Time in which the host leads the arm from where it stands to the scene's motion, s.
const BLEND: f64 = 0.2;

/// Time, s, by which an undisturbed hold may last longer than other faults: any stop, the time to settle, and some rest.
const RESTS: f64 = 1.0;

/// Longest time in which an arm without brakes comes to rest on its stops before a run, s, and the speed of rest, rad/s.
const SETTLING: f64 = 10.0;
const RESTING: f64 = 1e-3;

/// Data shared by all runs of a scene.
pub struct DrivesStage<const N: usize> {
    stage: Stage<N>,
    world: World<N>,
    arm: Arm<N>,
    known: [Known; N],
    /// Turns of a drive's shaft for one of its joint.
    ratios: [f64; N],
    tells_state: bool,
    brakes: bool,
    stops: [JointStop; N],
    /// Ticks of arming, and most ticks of lowering.
    arming: u32,
    lowering: u32,
}

/// Stops at the ends of a joint's range.
#[derive(Clone, Copy, Debug)]
struct JointStop {
    range: (f64, f64),
    stiffness: f64,
    damping: f64,
}

impl JointStop {
    /// True if the joint is at a stop or close to it.
    fn is_near(&self, q: f64) -> bool {
        q < self.range.0 + STOP_DEPTH || q > self.range.1 - STOP_DEPTH
    }

    /// Torque of the stops, N m: they push, and never pull.
    fn torque(&self, q: f64, qd: f64) -> f64 {
        let Self { range: (low, high), stiffness, damping } = *self;
        if q < low {
            (stiffness * (low - q) - damping * qd).max(0.0)
        } else if q > high {
            (stiffness * (high - q) - damping * qd).min(0.0)
        } else {
            0.0
        }
    }
}

impl<const N: usize> DrivesStage<N> {
    /// Prepare the runs of a scene.
    ///
    /// # Errors
    /// The scene cannot be run, or its robot has no drives on CAN.
    pub fn new(scene: &SceneFile) -> Result<Self, Failure> {
        let stage = Stage::<N>::new(scene)?;
        let Some((specs, wires)) = scene.simulated_drives::<N>() else {
            return Err(Failure::Input(miette::miette!(
                help = "expected a robot with [joint.drive] on CAN at every joint, and no `actuators.ideal`",
                "{}: no drives to simulate",
                scene.path.display()
            )));
        };
        let frictions = if scene.plant.friction { Some(simulate::friction_laws::<N>(scene)) } else { None };
        let known = |i: usize| {
            let ratio = specs[i].ratio.abs();
            let friction = frictions.map_or((0.0, 0.0), |frictions| (frictions[i].viscous, frictions[i].coulomb));
            Known { damping: ratio * ratio * f64::from(wires[i].damping), torque: ratio * specs[i].torque.1, friction }
        };
        let stop = |i: usize| {
            let limits = &stage.config.limits[i];
            let stiffness = limits.torque / STOP_DEPTH;
            let inertia = stage.config.gains[i].inertia;
            JointStop { range: limits.position, stiffness, damping: 1.4 * (stiffness * inertia).sqrt() }
        };
        let mut world = simulate::world::<N>(scene)?;
        world.ask();
        let brakes = scene.safety.safe_action == SafeAction::Brake;
        let stops = core::array::from_fn(stop);
        if !brakes {
            // The drives are off.
            for tick in 0..(SETTLING / world.period) as u32 {
                if tick > 100 && world.plant.state().qd.iter().all(|qd| qd.abs() < RESTING) {
                    break;
                }
                pass(&mut world, &stops).map_err(|diverged| Failure::Input(miette::miette!("{diverged}")))?;
            }
        }
        let far = |i: usize| {
            let rest = stage.rules.rest.map_or(0.0, |rest| rest[i]);
            let points = (0..=10).map(|k| world.reference(0.1 * f64::from(k) * world.motion.duration()).q[i]);
            points.map(|q| (q - rest).abs()).fold(0.0, f64::max) / stage.rules.joints[i].lowering_speed
        };
        let lowering = stage.rules.rest.map_or(0.0, |_| 1.2) * (0..N).map(far).fold(0.0, f64::max) + 0.3;
        let mut stage = Self {
            arm: simulate::arm(scene)?,
            known: core::array::from_fn(known),
            ratios: specs.map(|spec| spec.ratio),
            tells_state: scene.protocol() != Some(Protocol::MiniCheetah),
            brakes,
            stops,
            arming: 0,
            lowering: (lowering / world.period) as u32,
            stage,
            world,
        };
        stage.arming = stage.arming_ticks(scene)?;
        Ok(stage)
    }

    /// The same runs with a board that was built from another scene. The host greets that board; the judge knows this scene.
    ///
    /// # Errors
    /// The other scene cannot be run.
    pub fn with_board_of(mut self, other: &SceneFile) -> Result<Self, Failure> {
        let model = other.robot.model::<N>().map_err(Failure::input)?;
        self.stage.hello = hello(other, &model, Pacing::LockStep);
        Ok(self)
    }

    /// Fewest ticks of an undisturbed arming, among some.
    fn arming_ticks(&self, scene: &SceneFile) -> Result<u32, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let mut desk = Desk::new(scene, &model, Pacing::Live);
        let case = Case { fault: FaultKind::Nothing, situation: Situation::Armed };
        let mut least = u32::MAX;
        for run in 0..8 {
            let number = Number { seed: 0, run };
            let mut bench = Bench::new(self, &mut desk, number, None)?;
            let armed = bench.approach(case.situation).map(|()| Outcome::Unaffected);
            least = least.min(bench.armed_in);
            let done = finish(&self.stage.scene, case, number, bench.tick, bench.judge.motion, armed)?;
            if let Some(found) = done.counterexample {
                return Err(Failure::Input(miette::miette!("{}: {}", scene.path.display(), found.what)));
            }
        }
        Ok(least)
    }
}

/// Let a period pass without brakes.
fn pass<const N: usize>(world: &mut World<N>, stops: &[JointStop; N]) -> Result<(), Diverged> {
    let World { plant, drives: Some(drives), .. } = world else { return Ok(()) };
    let q = plant.state().q;
    let near = (0..N).any(|i| stops[i].is_near(q[i]));
    let turns = if near { drives.turns().max(10) } else { drives.turns() };
    plant.drive_renewed(turns, |state, dt| {
        let torque = drives.torque(state, dt);
        core::array::from_fn(|i| torque[i] + stops[i].torque(state.q[i], state.qd[i]))
    })
}

/// Do one run. `pair` is the number of the pair of requests, where there is one; `breakage` breaks the board on purpose.
///
/// # Errors
/// [`Failure::Input`] if the scene's machine does not reach the state.
pub fn run<const N: usize>(
    stage: &DrivesStage<N>,
    desk: &mut Desk<N>,
    (case, pair): (Case, u64),
    number: Number,
    breakage: Option<Breakage>,
) -> Result<Finished, Failure> {
    let mut bench = Bench::new(stage, desk, number, breakage)?;
    bench.pair = pair;
    let played = bench.play(case);
    let (tick, motion) = (bench.tick, bench.judge.motion);
    finish(&stage.stage.scene, case, number, tick, motion, played)
}

/// A run in progress.
struct Bench<'a, const N: usize> {
    stage: &'a DrivesStage<N>,
    desk: &'a mut Desk<N>,
    breakage: Option<Breakage>,
    memory: Memory<N>,
    host: Host<N>,
    judge: Judge<'a, N>,
    world: World<N>,
    random: Random,
    pair: u64,
    /// Ticks for which the brakes are still open after their line closes.
    engaging: u32,
    /// The fault of this run, while it lasts.
    injection: Option<Injection>,
    /// The host is silent until the fault ends, or for good.
    mute: bool,
    tick: u32,
    status: Option<Status>,
    /// Ticks along the trajectory, and where the arm was at its beginning, less where the scene's motion begins.
    along: u32,
    offset: [f64; N],
    /// Ticks of arming so far.
    armed_in: u32,
}

impl<const N: usize> Script<N> for Bench<'_, N> {
    fn host(&mut self) -> &mut Host<N> {
        &mut self.host
    }

    fn random(&mut self) -> &mut Random {
        &mut self.random
    }

    fn status(&self) -> Option<&Status> {
        self.status.as_ref()
    }

    fn live(&self) -> Frame {
        self.stage.stage.live.clone()
    }

    fn limits_first_motion(&self) -> bool {
        self.stage.stage.rules.first_motion.is_some()
    }

    fn step(&mut self) -> Result<(), Stop> {
        self.pass(Board::default())
    }

    fn press(&mut self) -> Result<(), Stop> {
        self.pass(Board { emergency_stop: true, ..Board::default() })
    }

    fn begin_motion(&mut self) -> Result<(), Stop> {
        let (q, from) = (self.world.plant.state().q, self.world.reference(0.0).q);
        self.offset = core::array::from_fn(|i| q[i] - from[i]);
        self.along = 0;
        let start = self.motion(0);
        self.host.start(&start)?;
        Ok(self.feed()?)
    }

    fn begin_fault(&mut self, case: Case) -> Result<u32, Stop> {
        let injection = Injection::new::<N>(case.fault, self.pair, &mut self.random);
        let Stage { config, rules, .. } = &self.stage.stage;
        let silence = rules.heartbeat_max.saturating_add(rules.hold_max).min(5000);
        if matches!(case.fault, FaultKind::HostSilent | FaultKind::HostGone) {
            self.lose_host();
        }
        let (least, most) = injection.ticks(config.age_max, silence, self.stage.lowering);
        self.injection = Some(injection);
        // An undisturbed hold lasts until the arm is to rest, and longer.
        let undisturbed = (case.fault, case.situation) == (FaultKind::Nothing, Situation::Holding);
        let more = if undisturbed { (RESTS / self.world.period) as u32 } else { 0 };
        Ok(self.random.whole(least, most + more))
    }

    fn disturbed(&mut self, k: u32) -> Result<(), Stop> {
        let Some(injection) = self.injection else { return self.step() };
        let Self { world, host, random, .. } = self;
        let state = *world.plant.measured();
        let Some(drives) = &mut world.drives else { return self.step() };
        let board = injection.act(k, (drives, &state), host, random)?;
        self.pass(board)
    }

    fn end_fault(&mut self) {
        let Some(injection) = self.injection.take() else { return };
        let World { plant, drives: Some(drives), .. } = &mut self.world else { return };
        injection.end(drives, plant.measured());
        self.mute = injection.kind == FaultKind::HostGone;
        self.host.gone &= self.mute;
    }

    fn lose_host(&mut self) {
        self.mute = true;
        self.host.gone = self.breakage != Some(Breakage::HostNeverMissed);
    }

    fn homes_again(&mut self) -> bool {
        self.random.chance(0.5)
    }

    fn arming(&self) -> u32 {
        self.stage.arming
    }

    fn disarming(&self) -> u32 {
        self.stage.stage.rules.brake_delay
    }
}

impl<'a, const N: usize> Bench<'a, N> {
    fn new(
        stage: &'a DrivesStage<N>,
        desk: &'a mut Desk<N>,
        Number { seed, run }: Number,
        breakage: Option<Breakage>,
    ) -> Result<Self, Failure> {
        desk.restart();
        let Stage { config, rules, hello, .. } = &stage.stage;
        let hello = Hello { pacing: Pacing::Live, ..*hello };
        let target = |error: FrameTooLong| Failure::Target(miette::Report::from_err(error));
        let mut host = Host::new(hello, None).map_err(target)?;
        host.deaf_to = (breakage == Some(Breakage::HoldLost)).then_some(link::Request::Hold);
        let arm = (&stage.arm, &stage.known);
        Ok(Self {
            judge: Judge::new(arm, rules, (config.age_max, stage.tells_state), stage.world.plant.state().q),
            stage,
            desk,
            breakage,
            memory: Memory::NONE,
            host,
            world: stage.world.clone(),
            random: Random::new(seed, run),
            pair: 0,
            engaging: 0,
            injection: None,
            mute: false,
            tick: 0,
            status: None,
            along: 0,
            offset: [0.0; N],
            armed_in: 0,
        })
    }

    /// Run one tick: host, board, buses, arm, judge.
    fn pass(&mut self, board: Board) -> Result<(), Stop> {
        self.tick += 1;
        if self.state() == RUNNING && !self.host.gone {
            self.feed()?;
        }
        let sent = self.host.finish(None, None, false)?;
        let requests = sent.requests;
        let (supply, _) = self.stage.stage.calm;
        let lines = Lines { emergency_stop: board.emergency_stop, supply, temperature: None };
        let state = self.state();
        let Self { world, desk, memory, breakage, engaging, .. } = &mut *self;
        let Some(drives) = &mut world.drives else { return Ok(()) };
        memory.begin(state);
        let carried = core::array::from_fn(|i| drives.given(i));
        let late = core::cell::Cell::new(board.late == Some(true));
        let is_due = || late.replace(board.late.is_some());
        let mut joints = Faulty { joints: drives.board(), breakage: *breakage, memory };
        let status = desk.on_board(&sent.bytes, &mut joints, lines, is_due).map_err(Stop::Trouble)?;
        drives.serve(&world.sensors.disturbed(world.plant.measured()));
        let heard = core::array::from_fn(|i| drives.electronics(i).is_some_and(|it| it.silent_for() == 0.0));
        if *breakage == Some(Breakage::TimeoutNeverActs) {
            without_timeouts(drives);
        }
        let released = !drives.brakes_hold() || memory.opens;
        let open = released || *engaging > 0;
        *engaging = if released { (BRAKES_ENGAGE / world.period).ceil() as u32 } else { engaging.saturating_sub(1) };
        let slips = memory.slips(*breakage, open, world.period);
        self.move_arm(open || slips).map_err(|diverged| {
            let broken = Unsafe { law: Law::RanAway, what: diverged.to_string() };
            Stop::Unsafe { what: broken.what.clone(), broken: Some(broken), inputs: format!("{status:?}") }
        })?;
        self.judge(Seen { board, status, requests, spoke: sent.spoke && !self.mute, carried, heard, released, open })
    }

    /// Move the arm for a period.
    fn move_arm(&mut self, open: bool) -> Result<(), Diverged> {
        if open || !self.stage.brakes {
            return pass(&mut self.world, &self.stage.stops);
        }
        if let World { plant, drives: Some(drives), .. } = &mut self.world {
            drives.rest(plant.measured());
            plant.brake();
        }
        Ok(())
    }

    /// Give the judge the truth of this tick.
    fn judge(&mut self, seen: Seen<N>) -> Result<(), Stop> {
        let Seen { board, status, requests, spoke, carried, heard, released, open } = seen;
        let State { q, qd } = *self.world.plant.state();
        let Some(drives) = &mut self.world.drives else { return Ok(()) };
        let (mut torque, mut told) = ([0.0; N], [0.0; N]);
        let (mut on, mut powered, mut told_off, mut zero) = ([false; N], [false; N], [false; N], [0.0; N]);
        for i in 0..N {
            torque[i] = drives.given(i);
            if let Some(it) = drives.electronics(i) {
                (on[i], powered[i], told_off[i]) = (it.gives_torque(), it.powered, it.was_told_off());
                told[i] = it.told().torque * self.stage.ratios[i];
                zero[i] = it.zero() / self.stage.ratios[i];
            }
            torque[i] = if powered[i] { torque[i] } else { 0.0 };
        }
        let (world, along, offset) = (&self.world, self.along, self.offset);
        let motion = |ticks: u32| blended(world, along + ticks, &offset);
        let truth = Truth {
            state: (status.state, status.cause),
            homed: status.homed,
            q,
            qd,
            carried,
            torque,
            told,
            on,
            powered,
            heard,
            told_off,
            zero,
            released,
            open,
            motion: &motion,
            requests: &requests,
            spoke,
        };
        let judged = self.judge.watch(&truth);
        if let Err(broken) = judged {
            let what = format!("{:?}: {}", broken.law, broken.what);
            let inputs = format!(
                "{board:?}, requests {requests:?}\nsaid {status:?}\nq {q:?}\nqd {qd:?}\ntorque {torque:?}, before {carried:?}\non {on:?}, power {powered:?}, heard {heard:?}, brakes open {open}\nreference {:?}",
                motion(0)
            );
            return Err(Stop::Unsafe { broken: Some(broken), what, inputs });
        }
        if status.state == HOMING && !self.mute {
            // The operator sets the zeros of the drives that have power.
            for i in 0..N {
                let electronics = self.world.drives.as_mut().and_then(|drives| drives.electronics(i));
                if let Some(it) = electronics.filter(|it| it.powered) {
                    it.set_zero(&Shaft::default());
                }
            }
        }
        self.along += u32::from(status.state == RUNNING);
        self.armed_in += u32::from(status.state == ARMING);
        self.status = Some(status);
        Ok(())
    }

    /// The host's reference `ticks` after the start of its motion.
    fn motion(&self, ticks: u32) -> Reference<f64, N> {
        blended(&self.world, ticks, &self.offset)
    }

    /// Send the trajectory points that are due.
    fn feed(&mut self) -> Result<(), FrameTooLong> {
        let (world, offset) = (&self.world, self.offset);
        self.host.feed(self.along, |ticks| blended(world, ticks, &offset))
    }
}

/// A tick before it is judged.
struct Seen<const N: usize> {
    board: Board,
    status: Status,
    requests: Vec<link::Request>,
    spoke: bool,
    carried: [f64; N],
    heard: [bool; N],
    released: bool,
    open: bool,
}

/// The scene's motion, from an arm that stands by `offset` beside its beginning.
fn blended<const N: usize>(world: &World<N>, ticks: u32, offset: &[f64; N]) -> Reference<f64, N> {
    let t = f64::from(ticks) * world.period;
    let mut reference = world.reference(t);
    let x = t / BLEND;
    if x < 1.0 {
        let left = 1.0 - x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
        let speed = -30.0 * x * x * (1.0 - 2.0 * x + x * x) / BLEND;
        let acceleration = -60.0 * x * (1.0 - 3.0 * x + 2.0 * x * x) / (BLEND * BLEND);
        for i in 0..N {
            reference.q[i] += left * offset[i];
            reference.qd[i] += speed * offset[i];
            reference.qdd[i] += acceleration * offset[i];
        }
    }
    reference
}
