//! A board that is broken on purpose: each mutant disables one protection from outside its code, to show that the search finds the consequence.

use dynamics_core::control::Spring;
use dynamics_core::safety::SafeAction;
use joint_io::JointIo;
use session::readings::Readings;

/// The deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mutant {
    /// A drive counts as on without confirmation, even while it is silent, and the brakes open with the first torque.
    BlindToDrives,
    /// A possible loss of a zero is not reported.
    ZeroNeverLost,
    /// No torque carries the arm before the brakes open.
    NoPreload,
    /// Of several requests for one period only the last is taken.
    LastRequestWins,
    /// The trajectory is kept after faults, stops, disarming and homing.
    OldTrajectory,
    /// The answer to a superseded request is not sent.
    NoAnswer,
    /// Answers are sent twice.
    TwoAnswers,
    /// The board does not know the arm's rest pose.
    NoRestPose,
}

/// The board's joints, with or without a deliberate fault.
#[derive(Debug)]
pub struct Faulty<'a, J> {
    /// The joints.
    pub joints: &'a mut J,
    /// The deliberate fault.
    pub mutant: Option<Mutant>,
}

impl<const N: usize, J: JointIo<N>> JointIo<N> for Faulty<'_, J> {
    fn measure(&mut self) -> Option<Readings<N>> {
        let mut readings = self.joints.measure()?;
        match self.mutant {
            Some(Mutant::BlindToDrives) => (readings.on, readings.age_ticks) = ([true; N], [0; N]),
            Some(Mutant::ZeroNeverLost) => readings.zero_lost = false,
            _ => {}
        }
        Some(readings)
    }

    fn temperature(&self) -> Option<f32> {
        self.joints.temperature()
    }

    fn enable(&mut self, action: SafeAction) {
        self.joints.enable(action);
    }

    fn preload(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        match self.mutant {
            Some(Mutant::NoPreload) => self.joints.preload(&[0.0; N], None),
            _ => self.joints.preload(torque, springs),
        }
    }

    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        self.joints.drive(torque, springs);
    }

    fn safe(&mut self, action: SafeAction) {
        self.joints.safe(action);
    }

    fn clear(&mut self) {
        self.joints.clear();
    }
}
