//! Machine under test: the firmware's session on the desk, or the emulated chip together with the desk.

use super::frames::difference;
use board::chip::{Chip, ChipError};
use board::session::dry_run::{DeskSession, Uncounted, desk_session, without_cost};
use dynamics_core::safety::SafeAction;
use dynamics_core::{Model, Sensed};
use joint_io::{JointIo, run_tick};
use link::seal::SealKey;
use link::{Actuation, Decoder, Frame, Pacing, Refusal, Status};
use robot_compiler::SceneFile;
use session::black_box::Report;
use session::meter::Meter;
use session::readings::Lines;
use session::readings::{JointFaults, Readings};
use session::{Drives, Reaction};

/// Sensor readings and lines of one tick.
#[derive(Clone, Debug)]
pub struct TickInputs<const N: usize> {
    /// Number of the tick.
    pub tick: u32,
    /// Reading of the sensors.
    pub sensed: Sensed<f32, N>,
    /// Age of the reading of each joint, ticks.
    pub age_ticks: [u32; N],
    /// True if the emergency stop is pressed.
    pub emergency_stop: bool,
    /// True if the previous tick had not ended when this one was due.
    pub overrun: bool,
    /// True if every joint knows its zero position.
    pub zeroed: bool,
    /// Fault reports of the joints' drives.
    pub drive_fault: [bool; N],
    /// Supply voltage, V; `None` if it is not measured.
    pub supply: Option<f32>,
    /// Temperature, degrees Celsius; `None` if it is not measured.
    pub temperature: Option<f32>,
}

impl<const N: usize> TickInputs<N> {
    /// Lines for a dry run, in which the host sends them.
    pub(super) fn lines(&self) -> link::Lines {
        link::Lines {
            emergency_stop: self.emergency_stop,
            overrun: self.overrun,
            zeroed: self.zeroed,
            drive_fault: self.drive_fault.iter().rev().fold(0, |bits, &fault| bits << 1 | u8::from(fault)),
            supply: self.supply,
            temperature: self.temperature,
            ..link::Lines::CALM
        }
    }

    /// Greatest age of a joint's reading, ticks.
    pub(super) fn oldest(&self) -> u32 {
        self.age_ticks.iter().fold(0, |oldest, age| oldest.max(*age))
    }

    fn readings(&self) -> Readings<N> {
        let drive = |fault| if fault { JointFaults::DRIVE } else { JointFaults::NONE };
        let lost = if self.zeroed { JointFaults::NONE } else { JointFaults::LOST };
        Readings {
            sensed: self.sensed,
            torque: [0.0; N],
            age_ticks: self.age_ticks,
            faults: self.drive_fault.map(|fault| drive(fault) | lost),
            errors: [0; N],
            on: [true; N],
            zero_lost: false,
        }
    }
}

/// Output of the machine in one tick.
#[derive(Clone, Debug, PartialEq)]
pub struct TickOutput<const N: usize> {
    /// Command to the drives.
    pub drives: Drives<N>,
    /// Status that the machine reports.
    pub status: Status,
}

/// Reason why a run cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// The chip failed.
    #[error(transparent)]
    Chip(#[from] ChipError),
    /// Chip and desk give different answers.
    #[error("chip and desk differ: {0}")]
    Differs(String),
    /// A tick was not reported.
    #[error("tick {0} was not reported")]
    Unreported(u32),
}

/// A machine under test, tick by tick.
pub trait Machine<const N: usize> {
    /// Pacing of its ticks: [`Pacing::Live`] with the lines and readings of a board, or [`Pacing::DryRun`].
    fn pacing(&self) -> Pacing;

    /// Begins a run. Returns the key with which the host's packets must be sealed, if there is one.
    ///
    /// # Errors
    /// [`MachineError`] if the machine fails.
    fn begin(&mut self) -> Result<Option<SealKey>, MachineError> {
        Ok(None)
    }

    /// Runs one tick after these bytes arrived over the link. In a dry run the bytes contain `told`, and the measurement comes last.
    ///
    /// # Errors
    /// [`MachineError`] if the machine fails, or does not report the tick.
    fn tick(&mut self, bytes: &[u8], told: &TickInputs<N>) -> Result<TickOutput<N>, MachineError>;
}

/// The firmware's session on the desk.
pub struct Desk<const N: usize> {
    session: DeskSession<N>,
    /// A copy of the session before its first hello. A run starts from it, because a hello does not end a session that drives the arm.
    new: DeskSession<N>,
    meter: Meter<Uncounted>,
    decoder: Decoder,
    pacing: Pacing,
    answers: Vec<Frame>,
}

impl<const N: usize> Desk<N> {
    /// Creates the session of a scene.
    #[must_use]
    pub fn new(scene: &SceneFile, model: &Model<f64, N>, pacing: Pacing) -> Self {
        let new = desk_session(scene, model);
        Self {
            session: new.clone(),
            new,
            meter: Meter::new(Uncounted),
            decoder: Decoder::new(),
            pacing,
            answers: Vec::new(),
        }
    }

    /// Starts again, as after a reset of the board.
    pub(super) fn restart(&mut self) {
        self.session.clone_from(&self.new);
        self.decoder = Decoder::new();
        self.answers.clear();
    }

    /// Feeds received bytes to the session.
    fn receive(&mut self, bytes: &[u8]) {
        for received in bytes.iter().filter_map(|byte| self.decoder.push(*byte)) {
            // A board itself answers a packet that it cannot open; its session does not receive it.
            if received.is_err() {
                continue;
            }
            match self.session.receive(received) {
                Reaction::Reply(frame) | Reaction::Start(_, frame) | Reaction::Resume(frame) => {
                    self.answers.push(frame)
                }
                Reaction::Stop(hello, refusal) => self.answers.extend([hello, refusal]),
                // The tick follows in `answers`, because a dry run's measurement comes last.
                Reaction::Tick | Reaction::None => {}
            }
        }
    }

    /// Runs one tick of a board that accesses the joints itself, after these bytes arrived over the link.
    ///
    /// # Errors
    /// The tick was not reported.
    pub(super) fn on_board(
        &mut self,
        bytes: &[u8],
        joints: &mut impl JointIo<N>,
        lines: Lines,
        is_due: impl Fn() -> bool,
    ) -> Result<Status, MachineError> {
        self.receive(bytes);
        run_tick(&mut self.session, joints, &self.meter, || lines, is_due);
        self.answers.extend(core::iter::from_fn(|| self.session.say()).map(Report::frame));
        status(core::mem::take(&mut self.answers), 0, Pacing::Live)
    }

    /// Runs a tick; returns all frames of the session and the command to the drives.
    fn answers(&mut self, bytes: &[u8], told: &TickInputs<N>) -> (Vec<Frame>, Drives<N>) {
        self.receive(bytes);
        let lines = Lines { emergency_stop: told.emergency_stop, supply: told.supply, temperature: told.temperature };
        self.session.sense(Some(&told.readings()), &lines);
        if told.overrun && self.pacing == Pacing::Live {
            self.session.overrun();
        }
        let drives = self.session.tick(&self.meter);
        self.answers.extend(core::iter::from_fn(|| self.session.say()).map(Report::frame));
        (core::mem::take(&mut self.answers), drives)
    }
}

impl<const N: usize> Machine<N> for Desk<N> {
    fn pacing(&self) -> Pacing {
        self.pacing
    }

    fn begin(&mut self) -> Result<Option<SealKey>, MachineError> {
        self.restart();
        Ok(None)
    }

    fn tick(&mut self, bytes: &[u8], told: &TickInputs<N>) -> Result<TickOutput<N>, MachineError> {
        let (answers, drives) = self.answers(bytes, told);
        let status = status(answers, told.tick, self.pacing)?;
        // A dry run drives nothing; the status contains the command that would act.
        let drives = if self.pacing == Pacing::Live { drives } else { played(&status) };
        Ok(TickOutput { drives, status })
    }
}

/// The emulated chip in a dry run, and the desk on the same bytes.
pub struct Both<const N: usize> {
    chip: Chip,
    desk: Desk<N>,
}

impl<const N: usize> Both<N> {
    /// Creates a pair from a chip that runs the scene's firmware.
    pub fn new(chip: Chip, scene: &SceneFile, model: &Model<f64, N>) -> Self {
        Self { chip, desk: Desk::new(scene, model, Pacing::DryRun) }
    }
}

impl<const N: usize> Machine<N> for Both<N> {
    fn pacing(&self) -> Pacing {
        Pacing::DryRun
    }

    fn begin(&mut self) -> Result<Option<SealKey>, MachineError> {
        let key = self.chip.join_anew()?;
        if let Some(key) = &key {
            self.desk.decoder.seal_with(key.clone());
        }
        Ok(key)
    }

    fn tick(&mut self, bytes: &[u8], told: &TickInputs<N>) -> Result<TickOutput<N>, MachineError> {
        self.chip.write(bytes)?;
        let (desk, _) = self.desk.answers(bytes, told);
        let mut chip = Vec::new();
        loop {
            let frame = self.chip.receive("the status of a tick")?;
            let last = matches!(&frame, Frame::Status(status) if status.tick == told.tick);
            // This answer comes from the channel, not from the session.
            if !matches!(frame, Frame::Refusal(Refusal::Unauthentic { .. } | Refusal::Undecodable(_))) {
                chip.push(without_cost(frame));
            }
            if last {
                break;
            }
        }
        if let Some(what) = difference(&chip, &desk) {
            return Err(MachineError::Differs(format!("tick {}: {what}", told.tick)));
        }
        let status = status(chip, told.tick, Pacing::DryRun)?;
        Ok(TickOutput { drives: played(&status), status })
    }
}

/// Finds the status of this tick among the answers.
fn status(answers: Vec<Frame>, tick: u32, pacing: Pacing) -> Result<Status, MachineError> {
    let statuses = answers.into_iter().filter_map(|frame| match frame {
        Frame::Status(status) => Some(status),
        _ => None,
    });
    // Without measurements over the link, the session counts its ticks itself.
    let mut statuses = statuses.filter(|status| pacing == Pacing::Live || status.tick == tick);
    statuses.next_back().ok_or(MachineError::Unreported(tick))
}

/// Command to the drives that would act outside a dry run.
pub(super) fn played<const N: usize>(status: &Status) -> Drives<N> {
    let all = |torque: &link::Joints<f32>| core::array::from_fn(|i| torque.get(i).copied().unwrap_or(f32::NAN));
    match &status.actuation {
        Some(Actuation::Drive { torque, .. }) => Drives::Drive(all(torque)),
        Some(Actuation::Preload { torque, .. }) => Drives::Preload(all(torque)),
        Some(Actuation::Enable) => Drives::Enable(SafeAction::Brake),
        Some(Actuation::DampedStop) => Drives::Safe(SafeAction::DampedStop),
        Some(Actuation::Off) => Drives::Safe(SafeAction::Off),
        Some(Actuation::Brake) | None => Drives::Safe(SafeAction::Brake),
    }
}
