//! One run: bring a machine to a state, inject a fault for a while, and judge every tick.

use super::case::{Case, FaultKind, Situation};
use super::host::Host;
use super::injection::{Injection, JointScale};
use super::judge::{Heard, Judge, Law, Trust, Unsafe};
use super::machine::{Machine, Said, Told, Trouble};
use super::random::Random;
use super::script::{Script, Stop, finish};
use board::chip::hello;
use dynamics_core::safety::{Rules, SafeAction};
use dynamics_core::{ControllerConfig, Live, Reference};
use link::codec::FrameTooLong;
use link::{Frame, Hello, Status};
use robot_compiler::SceneFile;
use robot_compiler::scene::Push;
use serde::Serialize;
use session::Drives;
use sim::failure::Failure;
use sim::plant::Diverged;
use sim::run::simulate;
use sim::run::world::{World, measurement};
use std::path::PathBuf;

/// Data shared by all runs of a scene.
pub struct Stage<const N: usize> {
    /// Name of the scene, and its file.
    pub(super) scene: (String, PathBuf),
    world: World<N>,
    pub(super) hello: Hello,
    pub(super) config: ControllerConfig<f64, N>,
    pub(super) rules: Rules<f64, N>,
    pub(super) live: Frame,
    /// The live inputs as they should be.
    pub(super) truth: Live<f32, N>,
    pub(super) scales: [JointScale; N],
    /// Normal supply voltage and temperature.
    pub(super) calm: (Option<f32>, Option<f32>),
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
    /// Motion of the joints, for runs with drives.
    pub motion: Motion,
    /// The unsafe command that ended the run.
    pub counterexample: Option<Counterexample>,
}

/// Motion of an arm on real drives in a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Greatest distance of a joint from where it should be while torque is to hold it, rad or m.
    pub worst: f64,
    /// Exemptions that occurred: one bit for each of [`Exemption::NAMES`].
    pub exempt: u8,
}

/// Motion that no program can prevent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exemption {
    /// An arm without brakes falls at a joint whose drive is off or has no power.
    NoDrive = 1,
    /// A drive that hears nothing gives its last torque until its own timeout.
    Unheard = 2,
    /// A drive that is off below the torque at which its replies could show it: the arm may leave its place by its `reach`.
    Invisible = 4,
}

impl Exemption {
    /// All of them, in words.
    pub const NAMES: [(Self, &'static str); 3] = [
        (Self::NoDrive, "an arm without brakes falls at a drive that is off"),
        (Self::Unheard, "a drive that hears nothing gives its last torque until its own timeout"),
        (Self::Invisible, "a drive is off below the torque that its replies can show"),
    ];
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
        injection: None,
        tick: 0,
        status: None,
        along: 0,
        driven: 0,
    };
    let played = bench.play(case);
    finish(&stage.scene, case, number, bench.tick, Motion::default(), played)
}

/// A run in progress.
struct Bench<'a, const N: usize> {
    stage: &'a Stage<N>,
    machine: &'a mut dyn Machine<N>,
    host: Host<N>,
    judge: Judge<N>,
    world: World<N>,
    random: Random,
    /// The fault of this run, while it lasts.
    injection: Option<(FaultKind, Injection<N>)>,
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
        self.stage.live.clone()
    }

    fn limits_first_motion(&self) -> bool {
        self.stage.rules.first_motion.is_some()
    }

    fn step(&mut self) -> Result<(), Stop> {
        self.pass(None)
    }

    fn press(&mut self) -> Result<(), Stop> {
        let mut press = Injection::new(FaultKind::EmergencyStop, self.stage, &mut self.random);
        self.pass(Some(Wrong { kind: FaultKind::EmergencyStop, injection: &mut press, k: 0 }))
    }

    fn begin_motion(&mut self) -> Result<(), Stop> {
        let start = self.motion(0);
        self.host.start(&start)?;
        self.along = 0;
        Ok(self.feed()?)
    }

    fn begin_fault(&mut self, case: Case) -> Result<u32, Stop> {
        self.injection = Some((case.fault, Injection::new(case.fault, self.stage, &mut self.random)));
        let (least, most) = case.fault.ticks();
        let ticks = self.random.whole(least, most);
        let rules = &self.stage.rules;
        let silence = rules.heartbeat_max.saturating_add(rules.hold_max).min(5000);
        Ok(if case.fault == FaultKind::HostSilent { ticks + silence } else { ticks })
    }

    fn disturbed(&mut self, k: u32) -> Result<(), Stop> {
        let Some((kind, mut injection)) = self.injection.take() else { return self.pass(None) };
        let passed = self.pass(Some(Wrong { kind, injection: &mut injection, k }));
        self.injection = Some((kind, injection));
        passed
    }
}

impl<const N: usize> Bench<'_, N> {
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
        let drill = self.machine.pacing() == link::Pacing::Drill;
        let sent = self.host.finish(drill.then_some(&told), wire.map(|kind| (kind, &mut self.random)), mute)?;
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
}
