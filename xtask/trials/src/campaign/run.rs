//! One run: brings a machine to a state, injects a fault for a while, and judges every tick.

use super::case::{Case, Situation};
use super::fault::FaultKind;
use super::host::Host;
use super::injection::Injection;
use super::judge::{Heard, Judge, SafetyProperty, Trust, Unsafe};
use super::machine::{Machine, MachineError, TickInputs, TickOutput};
use super::outcome::{Finished, Motion, Number};
use super::random::Random;
use super::script::{Script, Stop, finish};
use super::stage::Stage;
use dynamics_core::Reference;
use dynamics_core::safety::SafeAction;
use link::codec::FrameTooLong;
use link::{Frame, Hello, Status};
use robot_compiler::scene::Push;
use session::Drives;
use sim::failure::Failure;
use sim::plant::Diverged;
use sim::run::sensing::measurement;
use sim::run::world::World;

/// Does one run. The machine may be in any state before; it starts again.
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
    let seal = machine.begin().map_err(|error| Failure::Target(miette::Report::from_err(error)))?;
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
    /// The active fault of this run.
    injection: Option<(FaultKind, Injection<N>)>,
    tick: u32,
    status: Option<Status>,
    /// Ticks along the trajectory.
    along: u32,
    /// Ticks in which the drives have moved the arm.
    driven: u32,
}

/// The active fault, for one tick.
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
    /// Runs one tick: sensors, host, machine, judge, arm.
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
        if self.machine.pacing() == link::Pacing::DryRun {
            told.age_ticks = [told.oldest(); N];
        }
        if feeds {
            self.feed()?;
        }
        let dry_run = self.machine.pacing() == link::Pacing::DryRun;
        let sent = self.host.finish(dry_run.then_some(&told), wire.map(|kind| (kind, &mut self.random)), mute)?;
        let said = match self.machine.tick(&sent.bytes, &told) {
            Ok(said) => said,
            Err(MachineError::Differs(what)) => {
                return Err(Stop::Unsafe { broken: None, what, inputs: format!("{told:?}\n{sent:?}") });
            }
            Err(error) => return Err(Stop::Machine(error)),
        };
        let heard = Heard { requests: &sent.requests, spoke: sent.spoke, exact: false };
        if let Err(broken) = self.judge.watch(&told, &heard, &said) {
            let what = format!("{:?}: {}", broken.law, broken.what);
            let inputs = format!("told {told:?}\nsent {sent:?}\nsaid {said:?}\nbefore {:?}", self.status);
            return Err(Stop::Unsafe { broken: Some(broken), what, inputs });
        }
        self.move_arm(&said).map_err(|diverged| {
            let broken = Unsafe { law: SafetyProperty::RanAway, what: diverged.to_string() };
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
    fn calm(&mut self) -> TickInputs<N> {
        let measured = measurement::<f32, N>(&self.world.sensors.read(self.world.plant.measured()));
        TickInputs {
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

    /// Sends the trajectory points that are due.
    fn feed(&mut self) -> Result<(), FrameTooLong> {
        let (world, period) = (&self.world, self.world.period);
        self.host.feed(self.along, |ticks| world.reference(f64::from(ticks) * period))
    }

    /// Moves the arm as the drives command.
    fn move_arm(&mut self, said: &TickOutput<N>) -> Result<(), Diverged> {
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
