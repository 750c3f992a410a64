//! A dry run as a device: the scene's simulated arm in place of the joints. This program also simulates the board's input lines.
//!
//! Time is simulated. It passes only while the operator waits, one control period at a time, so that a script has the same result on every machine.
//! For a person at a terminal it passes at the pace of the clock.
//!
//! With ideal drives, the simulated arm is driven while torque acts and braked otherwise, for any safe action. Simulated drives begin switched off,
//! are switched on by the first torque, and otherwise do the safe action. Their faults and temperature are sent to the target together with the
//! operator's lines.

use super::device::{Device, DeviceError, Pace, Tap};
use crate::chip::ChipError;
use crate::session::dry_run::DryRun;
use joint_io::higher;
use link::convert::array;
use link::{Actuation, DriveFaultReport, Frame, Lines, Pacing, Sensed};
use sim::run::sensing::Sensing;
use sim::run::world::World;
use std::time::Duration;

/// A dry run with a simulated arm.
#[derive(Debug)]
pub struct DryRunDevice<const N: usize, D> {
    target: D,
    world: World<N>,
    tick: u32,
    reading: Option<Sensed>,
    /// The operator's lines, and the lines last sent to the target.
    lines: (Lines, Lines),
    /// Frames of the black box that were received before the next tick.
    past: Vec<Frame>,
    /// Last report of a simulated drive with a fault.
    drive_fault: Option<DriveFaultReport>,
    pace: Pace,
    tap: Tap,
}

impl<const N: usize, D: DryRun> DryRunDevice<N, D> {
    /// A target that has agreed on a hello, and the simulated arm for it.
    #[must_use]
    pub fn new(target: D, mut world: World<N>, pace: Pace) -> Self {
        world.ask();
        let lines = (Lines::CALM, Lines::CALM);
        let (past, tap) = (Vec::new(), Tap::default());
        Self { target, world, tick: 0, reading: None, lines, past, drive_fault: None, pace, tap }
    }

    /// Applies the last status's torque or safe action to the simulated arm.
    fn act(&mut self, answers: &[Frame]) -> Result<(), DeviceError> {
        let status = answers.iter().rev().find_map(|frame| match frame {
            Frame::Status(status) => status.actuation.as_ref(),
            _ => None,
        });
        match status {
            Some(Actuation::Drive { torque, .. }) => {
                let torque: [f32; N] = array(torque).map_err(ChipError::from)?;
                self.world.drive(&torque.map(f64::from)).map_err(DeviceError::Diverged)
            }
            _ => self.world.stop().map_err(DeviceError::Diverged),
        }
    }

    /// Sends the target the operator's lines combined with the simulated drives' faults and temperature, when these change.
    fn report(&mut self, sensing: &Sensing<f32, N>) -> Result<(), DeviceError> {
        let (own, told) = self.lines;
        let bits = (0..N).fold(0, |bits, joint| bits | u8::from(sensing.drive_fault[joint]) << joint);
        let temperature = higher(own.temperature, sensing.temperature);
        self.drive_fault = sensing.fault_report.or(self.drive_fault);
        let lines = Lines { drive_fault: own.drive_fault | bits, temperature, ..own };
        if lines == told {
            return Ok(());
        }
        self.lines.1 = lines;
        let frame = Frame::Lines(lines);
        self.tap.hear_sent(self.now(), &frame)?;
        Ok(self.target.send(&frame)?)
    }
}

impl<const N: usize, D: DryRun> Device for DryRunDevice<N, D> {
    fn pacing(&self) -> Pacing {
        Pacing::DryRun
    }

    fn send(&mut self, frame: &Frame) -> Result<(), DeviceError> {
        self.tap.hear_sent(self.now(), frame)?;
        self.target.send(frame)?;
        if let Frame::Lines(lines) = frame {
            self.lines = (*lines, *lines);
        }
        if matches!(frame, Frame::Dump) {
            self.past = self.target.dumped()?;
            let now = self.now();
            for frame in &self.past {
                self.tap.hear_received(0, now, frame)?;
            }
        }
        Ok(())
    }

    fn pass(&mut self) -> Result<Vec<Frame>, DeviceError> {
        let sensing = self.world.sense::<f32>();
        self.tick = self.tick.wrapping_add(1);
        if self.world.drives.is_some() {
            self.report(&sensing)?;
        }
        let measurement = link::Measurement::new(self.tick, &sensing.measurement);
        self.reading = Some(measurement.sensed.clone());
        self.tap.hear_sent(self.now(), &Frame::Measurement(measurement.clone()))?;
        let answers = self.target.tick(&measurement)?;
        let now = self.now();
        for frame in &answers {
            self.tap.hear_received(0, now, frame)?;
        }
        self.act(&answers)?;
        let mut past = core::mem::take(&mut self.past);
        past.extend(answers);
        self.pace.keep(now);
        Ok(past)
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(f64::from(self.tick) * self.world.period)
    }

    fn drive_fault(&self) -> Option<DriveFaultReport> {
        self.drive_fault
    }

    fn reading(&self) -> Option<&Sensed> {
        self.reading.as_ref()
    }

    fn tap(&mut self) -> &mut Tap {
        &mut self.tap
    }
}
