//! One run: bring a machine to a state, inject a fault for a while, and judge every tick.

use super::case::{Case, FaultKind, Situation};
use super::host::Host;
use super::injection::{Injection, JointScale};
use super::judge::{Heard, Judge, Law, Trust, Unsafe};
use super::machine::{Machine, Said, Told, Trouble};
use super::random::Random;
use crate::chip::hello;
use crate::failure::Failure;
use crate::plant::Diverged;
use crate::run::simulate;
use crate::run::world::{World, measurement};
use crate::session::states::ARMING;
use dynamics_core::safety::{Rules, SafeAction};
use dynamics_core::{ControllerConfig, Live, Reference};
use link::codec::FrameTooLong;
use link::{Frame, Hello, Request, Status};
use robot_compiler::SceneFile;
use robot_compiler::scene::Push;
use serde::Serialize;
use session::Drives;
use std::path::PathBuf;

/// Data shared by all runs of a scene.
pub struct Stage<const N: usize> {
    /// Name of the scene, and its file.
    scene: (String, PathBuf),
    world: World<N>,
    hello: Hello,
    config: ControllerConfig<f64, N>,
    pub(super) rules: Rules<f64, N>,
    live: Frame,
    /// The live inputs as they should be.
    pub(super) truth: Live<f32, N>,
    pub(super) scales: [JointScale; N],
    /// Normal supply voltage and temperature.
    calm: (Option<f32>, Option<f32>),
}

impl<const N: usize> Stage<N> {
    /// Prepare the runs of a scene.
    ///
    /// # Errors
    /// The scene cannot be run.
    pub fn new(scene: &SceneFile) -> Result<Self, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let (config, rules) = (scene.controller_config(&model), scene.safety_rules(&model));
        let arm = simulate::arm::<N>(scene)?;
        let scale = |i: usize| {
            let per_count = if scene.sensors.encoder { config.encoder[i].per_count } else { 0.0 };
            JointScale::new(&arm.joints[i], rules.joints[i].jump_step, per_count)
        };
        let truth = simulate::live_inputs(scene, &model);
        let live = link::Live::new(&truth)
            .map_err(|error| Failure::Input(miette::miette!("{}: {error}", scene.path.display())))?;
        let middle = |(low, high): (f64, f64), or: f32| {
            let middle = (0.5 * (low + high)) as f32;
            Some(if middle.is_finite() { middle } else { or })
        };
        Ok(Self {
            scene: (scene.name.clone(), scene.path.clone()),
            // Drives would stand between the injected readings and the machine.
            world: simulate::ideal_world(scene)?,
            hello: hello(scene, &model, link::Pacing::LockStep),
            live: Frame::Live(live),
            truth,
            scales: core::array::from_fn(scale),
            calm: (middle(rules.supply, 24.0), middle(rules.temperature, 30.0)),
            config,
            rules,
        })
    }
}

/// Effect of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The machine entered the fault state with this code.
    Fault(u8),
    /// The machine held, with this cause.
    Held(u8),
    /// The machine followed a request.
    Asked,
    /// The machine carried on.
    Unaffected,
}

/// A run with an unsafe command, and the data to reproduce and understand it.
#[derive(Clone, Debug, Serialize)]
pub struct Counterexample {
    /// Name of the scene.
    pub scene: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
    /// Tick of the unsafe command.
    pub tick: u32,
    /// The fault and the state.
    pub case: Case,
    /// The law that is broken; `None` if chip and desk differ.
    pub law: Option<Law>,
    /// Description of the violation.
    pub what: String,
    /// Inputs and outputs of the machine in that tick.
    pub inputs: String,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The fault and the state.
    pub case: Case,
    /// Effect of the fault.
    pub outcome: Outcome,
    /// Number of ticks, all of them judged.
    pub ticks: u32,
    /// The unsafe command that ended the run.
    pub counterexample: Option<Counterexample>,
}

/// Reason why a run ended early.
#[derive(Debug)]
enum Stop {
    Unsafe {
        broken: Option<Unsafe>,
        what: String,
        inputs: String,
    },
    Trouble(Trouble),
    /// The machine did not reach the state of the case.
    NotReached(Box<Status>),
}

impl From<FrameTooLong> for Stop {
    fn from(error: FrameTooLong) -> Self {
        Self::Trouble(Trouble::Chip(error.into()))
    }
}

/// Identification of a run: campaign and number.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
}

/// Do one run. The machine may have done anything before, because the run begins with a hello.
///
/// # Errors
/// [`Failure::Target`] if the chip fails; [`Failure::Input`] if the scene's machine does not reach the state.
pub fn run<const N: usize>(
    stage: &Stage<N>,
    machine: &mut dyn Machine<N>,
    case: Case,
    number: Number,
) -> Result<Finished, Failure> {
    let hello = Hello { pacing: machine.pacing(), ..stage.hello };
    let seal = machine.begin().map_err(|trouble| Failure::Target(miette::Report::from_err(trouble)))?;
    let host = Host::new(hello, seal).map_err(|error| Failure::Target(miette::Report::from_err(error)))?;
    let trust = if case.fault.leaves_the_loop_intact() { Trust::Loop } else { Trust::Arm };
    let judge = Judge::new(&stage.config, &stage.rules, trust);
    let mut bench = Bench {
        stage,
        machine,
        host,
        judge,
        world: stage.world.clone(),
        random: Random::new(number.seed, number.run),
        tick: 0,
        status: None,
        along: 0,
        driven: 0,
    };
    let Number { seed, run } = number;
    let (outcome, counterexample) = match bench.play(case) {
        Ok(outcome) => (outcome, None),
        Err(Stop::Trouble(trouble)) => return Err(Failure::Target(miette::Report::from_err(trouble))),
        Err(Stop::NotReached(status)) => {
            return Err(Failure::Input(miette::miette!(
                help = "expected a scene whose arm stands at the start of its motion and can be driven from there",
                "{}: with --seed {seed} --run {run} the machine does not come to the state `{}`: {status:?}",
                stage.scene.1.display(),
                case.situation.name()
            )));
        }
        Err(Stop::Unsafe { broken, what, inputs }) => {
            let law = broken.map(|broken| broken.law);
            let scene = stage.scene.0.clone();
            let found = Counterexample { scene, seed, run, tick: bench.tick, case, law, what, inputs };
            (Outcome::Unaffected, Some(found))
        }
    };
    Ok(Finished { case, outcome, ticks: bench.tick, counterexample })
}

/// A run in progress.
struct Bench<'a, const N: usize> {
    stage: &'a Stage<N>,
    machine: &'a mut dyn Machine<N>,
    host: Host<N>,
    judge: Judge<N>,
    world: World<N>,
    random: Random,
    tick: u32,
    status: Option<Status>,
    /// Ticks along the trajectory.
    along: u32,
    /// Ticks in which the drives have moved the arm.
    driven: u32,
}

/// The fault in a tick.
struct Wrong<'a, const N: usize> {
    kind: FaultKind,
    injection: &'a mut Injection<N>,
    /// Ticks since the fault began.
    k: u32,
}

impl<const N: usize> Bench<'_, N> {
    fn play(&mut self, case: Case) -> Result<Outcome, Stop> {
        self.approach(case.situation)?;
        let before = (self.state(), self.cause());
        if before.0 != case.situation.state() {
            return Err(self
                .status
                .clone()
                .map_or(Stop::Trouble(Trouble::Unreported(0)), |s| Stop::NotReached(Box::new(s))));
        }
        let mut injection = Injection::new(case.fault, self.stage, &mut self.random);
        let (least, most) = case.fault.ticks();
        let mut ticks = self.random.whole(least, most);
        if case.fault == FaultKind::HostSilent {
            ticks += self.stage.rules.heartbeat_max.saturating_add(self.stage.rules.hold_max).min(5000);
        }
        let mut outcome = Outcome::Unaffected;
        for k in 0..ticks {
            // Simulate a host that clears faults without looking.
            if case.fault != FaultKind::Nothing && self.random.chance(0.05) {
                self.host.ask(Request::Clear)?;
            }
            self.pass(Some(Wrong { kind: case.fault, injection: &mut injection, k }))?;
            outcome = self.came_of(outcome, before);
        }
        for _ in 0..self.random.whole(5, 40) {
            self.pass(None)?;
            outcome = self.came_of(outcome, before);
        }
        if case.fault != FaultKind::Nothing && self.random.chance(0.5) {
            self.recover()?;
        }
        Ok(outcome)
    }

    /// Effect of the fault so far: the first fault counts, otherwise the first hold.
    fn came_of(&self, so_far: Outcome, before: (u8, u8)) -> Outcome {
        let now = (self.state(), self.cause());
        match (so_far, now) {
            (Outcome::Fault(_), _) => so_far,
            (_, (5, code)) if before.0 != 5 => Outcome::Fault(code),
            (Outcome::Held(_), _) => so_far,
            (_, (4, cause)) if before.0 != 4 => Outcome::Held(cause),
            _ if now != before => Outcome::Asked,
            _ => so_far,
        }
    }

    /// Bring the machine to a state and wait there.
    fn approach(&mut self, situation: Situation) -> Result<(), Stop> {
        let live = self.stage.live.clone();
        self.host.send(&live)?;
        self.wait(3, 10)?;
        let requests: &[Request] = match situation {
            Situation::Idle => &[],
            Situation::Homing => &[Request::Home],
            Situation::Homed => &[Request::Home, Request::Confirm],
            Situation::Armed | Situation::Running | Situation::Holding | Situation::Fault => {
                &[Request::Home, Request::Confirm, Request::Arm]
            }
        };
        for request in requests {
            self.host.ask(*request)?;
            self.pass(None)?;
            while self.state() == ARMING {
                self.pass(None)?;
            }
        }
        match situation {
            Situation::Running | Situation::Holding => {
                self.wait(30, 60)?;
                let start = self.motion(0);
                self.host.start(&start)?;
                self.along = 0;
                self.feed()?;
                self.host.ask(Request::Run)?;
                self.wait(1, 400)?;
            }
            Situation::Fault => {
                self.wait(0, 40)?;
                self.stop()?;
            }
            _ => {}
        }
        if situation == Situation::Holding {
            self.host.ask(Request::Hold)?;
        }
        self.wait(1, 60)
    }

    /// Ask to clear the fault and to go on to torque, whether or not the machine grants it.
    fn recover(&mut self) -> Result<(), Stop> {
        for request in [Request::Clear, Request::Home, Request::Confirm, Request::Arm, Request::Run, Request::Hold] {
            self.host.ask(request)?;
            self.wait(1, 8)?;
            while self.state() == ARMING {
                self.pass(None)?;
            }
        }
        Ok(())
    }

    fn wait(&mut self, least: u32, most: u32) -> Result<(), Stop> {
        for _ in 0..self.random.whole(least, most) {
            self.pass(None)?;
        }
        Ok(())
    }

    /// Run a tick with the emergency stop pressed.
    fn stop(&mut self) -> Result<(), Stop> {
        let mut press = Injection::new(FaultKind::EmergencyStop, self.stage, &mut self.random);
        self.pass(Some(Wrong { kind: FaultKind::EmergencyStop, injection: &mut press, k: 0 }))
    }

    /// Run one tick: sensors, host, machine, judge, arm.
    fn pass(&mut self, wrong: Option<Wrong<'_, N>>) -> Result<(), Stop> {
        self.tick += 1;
        let mut told = self.calm();
        let (mut mute, mut wire) = (false, None);
        let mut feeds = self.state() == Situation::Running.state();
        if let Some(Wrong { kind, injection, k }) = wrong {
            injection.tell(k, &mut told, &mut self.random);
            feeds &= !injection.talk(k, &mut self.host, &mut self.random)?;
            mute = kind == FaultKind::HostSilent;
            wire = kind.is_of_the_link().then_some(kind);
            if let Some(wrench) = injection.push().filter(|_| k == 0) {
                let (at, duration) = (f64::from(self.driven) * self.world.period, 40.0 * self.world.period);
                self.world.plant = self.world.plant.clone().with_push(Some(Push { at, duration, wrench }));
            }
        }
        if self.machine.pacing() == link::Pacing::Drill {
            told.age_ticks = [told.oldest(); N];
        }
        if feeds {
            self.feed()?;
        }
        let sent = self.host.finish(&told, wire.map(|kind| (kind, &mut self.random)), mute)?;
        let said = match self.machine.tick(&sent.bytes, &told) {
            Ok(said) => said,
            Err(Trouble::Differs(what)) => {
                return Err(Stop::Unsafe { broken: None, what, inputs: format!("{told:?}\n{sent:?}") });
            }
            Err(trouble) => return Err(Stop::Trouble(trouble)),
        };
        let heard = Heard { requests: &sent.requests, spoke: sent.spoke, exact: false };
        if let Err(broken) = self.judge.watch(&told, &heard, &said) {
            let what = format!("{:?}: {}", broken.law, broken.what);
            let inputs = format!("told {told:?}\nsent {sent:?}\nsaid {said:?}\nbefore {:?}", self.status);
            return Err(Stop::Unsafe { broken: Some(broken), what, inputs });
        }
        self.move_arm(&said).map_err(|diverged| {
            let broken = Unsafe { law: Law::RanAway, what: diverged.to_string() };
            let inputs = format!("told {told:?}\nsaid {said:?}");
            Stop::Unsafe { what: broken.what.clone(), broken: Some(broken), inputs }
        })?;
        if said.status.state == Situation::Running.state() {
            self.along += 1;
        }
        self.status = Some(said.status);
        Ok(())
    }

    /// Sensor readings and lines without a fault.
    fn calm(&mut self) -> Told<N> {
        let measured = measurement::<f32, N>(&self.world.sensors.read(self.world.plant.measured()));
        Told {
            tick: self.tick,
            sensed: measured.sensed,
            age_ticks: [measured.age_ticks; N],
            emergency_stop: false,
            overrun: false,
            zeroed: true,
            drive_fault: [false; N],
            supply: self.stage.calm.0,
            temperature: self.stage.calm.1,
        }
    }

    /// Reference of the scene's motion `ticks` after its start.
    fn motion(&self, ticks: u32) -> Reference<f64, N> {
        self.world.reference(f64::from(ticks) * self.world.period)
    }

    /// Send the trajectory points that are due.
    fn feed(&mut self) -> Result<(), FrameTooLong> {
        let (world, period) = (&self.world, self.world.period);
        self.host.feed(self.along, |ticks| world.reference(f64::from(ticks) * period))
    }

    /// Move the arm as the drives command.
    fn move_arm(&mut self, said: &Said<N>) -> Result<(), Diverged> {
        let plant = &mut self.world.plant;
        let torque = match &said.drives {
            Drives::Drive(torque) => torque.map(f64::from),
            Drives::Safe(SafeAction::Brake) | Drives::Preload(_) | Drives::Enable(SafeAction::Brake) => {
                plant.brake();
                return Ok(());
            }
            Drives::Safe(SafeAction::DampedStop) | Drives::Enable(SafeAction::DampedStop) => {
                let qd = plant.measured().qd;
                let damping = |i: usize| {
                    let limit = self.stage.config.limits[i].torque;
                    (-self.stage.rules.joints[i].damping * qd[i]).clamp(-limit, limit)
                };
                core::array::from_fn(damping)
            }
            Drives::Safe(SafeAction::Off) | Drives::Enable(SafeAction::Off) => [0.0; N],
        };
        self.driven += 1;
        plant.drive(&torque)
    }

    fn state(&self) -> u8 {
        self.status.as_ref().map_or(0, |status| status.state)
    }

    fn cause(&self) -> u8 {
        self.status.as_ref().map_or(0, |status| status.cause)
    }
}
