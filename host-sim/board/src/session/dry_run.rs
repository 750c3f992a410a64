//! Dry runs: the firmware under its safety state machine, tick by tick, with this program in place of board and joints. The session runs either on
//! the desk, with the same code as in the chip, or in the emulated chip.
//!
//! ```text
//! hello {dry run}, then for every tick:
//! requests, lines, points, live inputs ... ->    a refusal for each that is refused
//! measurement {tick}                       ->    status {tick}: state, torque or safe action, limits, cost
//! ```
//!
//! Both sides answer frame by frame with the same bits, except for the cost of a tick ([`without_cost`]).

use crate::chip::{Chip, ChipError, hello};
use dynamics_core::control::{BuildOf, EveryNth};
use dynamics_core::safety::Protected;
use dynamics_core::trig::Method;
use dynamics_core::{ControllerConfig, Model};
use link::codec::Received;
use link::{Cost, Frame, Hello, Pacing};
use robot_compiler::SceneFile;
use robot_compiler::choose::ArmDynamics;
use session::black_box::Report;
use session::meter::{Counter, Meter};
use session::{Reaction, Session};
use sim::run::simulate::{Watch, desk};

/// A target of a dry run.
pub trait DryRun {
    /// Sends a frame that starts no tick. Its answers come with the next tick.
    ///
    /// # Errors
    /// The target cannot be reached.
    fn send(&mut self, frame: &Frame) -> Result<(), ChipError>;

    /// Sends a measurement. Returns all answers since the previous tick; the last is the status of this tick.
    ///
    /// # Errors
    /// The target cannot be reached, or sends an unexpected answer.
    fn tick(&mut self, measurement: &link::Measurement) -> Result<Vec<Frame>, ChipError>;

    /// Returns the black box after [`Frame::Dump`]. Call this before the next tick, which would change the black box.
    ///
    /// # Errors
    /// As [`DryRun::tick`].
    fn dumped(&mut self) -> Result<Vec<Frame>, ChipError>;
}

/// The firmware's session with the desk's controller.
pub type DeskSession<const N: usize> = Session<N, DeskBuild<N>>;

/// The parts of the desk's controller.
pub type DeskBuild<const N: usize> =
    BuildOf<EveryNth<ArmDynamics<f32, N>, f32, N>, Method, ControllerConfig<f32, N>, Watch<f32, N>, Protected<f32, N>>;

/// The session of a scene's firmware on the desk, waiting for a hello.
#[must_use]
pub fn desk_session<const N: usize>(scene: &SceneFile, model: &Model<f64, N>) -> DeskSession<N> {
    let control = scene.controller_config(model).cast();
    let protected = Protected { control, rules: scene.safety_rules(model).cast() };
    Session::new(hello(scene, model, Pacing::LockStep), desk(scene, model), protected)
        .with_tuning(scene.control.tunable)
}

/// A counter that always reads zero: the cost of a tick on the desk is not comparable with instructions of the chip.
#[derive(Clone, Copy, Debug)]
pub struct Uncounted;

impl Counter for Uncounted {
    fn now(&self) -> u32 {
        0
    }

    fn cost(count: u32) -> Cost {
        Cost::Instructions(count)
    }

    fn exercise(&self) {}
}

/// A dry run on the desk.
pub struct OnDesk<const N: usize> {
    session: DeskSession<N>,
    meter: Meter<Uncounted>,
    answers: Vec<Frame>,
}

impl<const N: usize> OnDesk<N> {
    /// Starts a dry run: sends a hello to the session of a scene.
    #[must_use]
    pub fn start(scene: &SceneFile, model: &Model<f64, N>) -> Self {
        Self::paced(scene, model, Pacing::DryRun)
    }

    /// As [`OnDesk::start`], in lock step without supervision: every tick with a reference evaluates the control law.
    #[must_use]
    pub fn bench(scene: &SceneFile, model: &Model<f64, N>) -> Self {
        Self::paced(scene, model, Pacing::LockStep)
    }

    fn paced(scene: &SceneFile, model: &Model<f64, N>, pacing: Pacing) -> Self {
        let mut desk = Self { session: desk_session(scene, model), meter: Meter::new(Uncounted), answers: Vec::new() };
        desk.take(Frame::Hello(hello(scene, model, pacing)));
        desk
    }

    /// The session.
    #[must_use]
    pub fn session(&self) -> &DeskSession<N> {
        &self.session
    }

    /// Gives the session a frame and keeps its answers. Returns true if the frame starts a tick.
    fn take(&mut self, frame: Frame) -> bool {
        match self.session.receive(Ok(Received { frame, missed: 0 })) {
            Reaction::Tick => return true,
            Reaction::Reply(frame) => self.answers.push(frame),
            Reaction::Stop(hello, refusal) => self.answers.extend([hello, refusal]),
            // The hello in this reaction is not an answer of a tick.
            Reaction::Start(..) | Reaction::Resume(_) | Reaction::None => {}
        }
        false
    }
}

impl<const N: usize> DryRun for OnDesk<N> {
    fn send(&mut self, frame: &Frame) -> Result<(), ChipError> {
        self.take(frame.clone());
        Ok(())
    }

    fn tick(&mut self, measurement: &link::Measurement) -> Result<Vec<Frame>, ChipError> {
        if self.take(Frame::Measurement(measurement.clone())) {
            self.session.tick(&self.meter);
            let said = core::iter::from_fn(|| self.session.say()).map(Report::frame);
            self.answers.extend(said);
        }
        Ok(core::mem::take(&mut self.answers))
    }

    fn dumped(&mut self) -> Result<Vec<Frame>, ChipError> {
        Ok(core::iter::from_fn(|| self.session.say()).map(Report::frame).collect())
    }
}

/// A dry run in the emulated chip.
#[derive(Debug)]
pub struct OnChip(Chip);

impl OnChip {
    /// Begins a dry run on a chip that has already agreed on a hello.
    ///
    /// # Errors
    /// As [`Chip::start`].
    pub fn start(mut chip: Chip, expect: Hello) -> Result<Self, ChipError> {
        chip.change_pacing(Hello { pacing: Pacing::DryRun, ..expect })?;
        Ok(Self(chip))
    }

    /// The chip.
    #[must_use]
    pub fn chip(&self) -> &Chip {
        &self.0
    }
}

impl DryRun for OnChip {
    fn send(&mut self, frame: &Frame) -> Result<(), ChipError> {
        self.0.send(frame)
    }

    fn tick(&mut self, measurement: &link::Measurement) -> Result<Vec<Frame>, ChipError> {
        self.0.send(&Frame::Measurement(measurement.clone()))?;
        let mut answers = Vec::new();
        loop {
            let frame = self.0.receive("the status of a tick")?;
            let last = matches!(&frame, Frame::Status(status) if status.tick == measurement.tick);
            answers.push(frame);
            if last {
                return Ok(answers);
            }
        }
    }

    fn dumped(&mut self) -> Result<Vec<Frame>, ChipError> {
        let mut answers = Vec::new();
        while answers.last() != Some(&Frame::Past(None)) {
            answers.push(self.0.receive("the black box")?);
        }
        Ok(answers)
    }
}

/// The same answer without the cost.
#[must_use]
pub fn without_cost(frame: Frame) -> Frame {
    match frame {
        Frame::Status(status) => Frame::Status(link::Status { cost: None, ..status }),
        Frame::Past(Some(status)) => Frame::Past(Some(link::Status { cost: None, ..status })),
        other => other,
    }
}
