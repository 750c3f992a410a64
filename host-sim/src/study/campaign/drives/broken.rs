//! A board that is broken on purpose, to show that the judge finds what then happens.

use dynamics_core::control::Spring;
use dynamics_core::safety::SafeAction;
use joint_io::JointIo;
use session::readings::Readings;

/// The deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breakage {
    /// A drive counts as on once its enable frame is packed, and the brakes open with the first torque.
    EnableCountsAsSent,
    /// Nothing carries the arm before the brakes open.
    NoPreload,
    /// Nobody hears of a zero that may be lost.
    ZeroNeverLost,
    /// The brakes open when the drives are on, before they carry the arm.
    BrakesOpenEarly,
    /// The brakes stay open in the safe action.
    BrakesStayOpen,
    /// A request to hold never arrives.
    HoldLost,
    /// The host is never missed.
    HostNeverMissed,
    /// A drive that goes off is not noticed.
    OffUnnoticed,
    /// The safe action of an arm without brakes switches the drives off.
    NoDamping,
    /// The last torque goes on in the safe action.
    TorqueGoesOn,
    /// Torque is half of what it should be.
    HalfTorque,
    /// Torque ends in the tick in which the brakes lose their power.
    NoBrakeDelay,
}

/// The board's joints, broken or not.
pub(super) struct Faulty<'a, J, const N: usize> {
    /// The joints.
    pub(super) joints: &'a mut J,
    /// The deliberate fault.
    pub(super) breakage: Option<Breakage>,
    /// Its memory from tick to tick.
    pub(super) memory: &'a mut Memory<N>,
}

/// Memory of a board with a deliberate fault.
#[derive(Clone, Copy, Debug)]
pub(super) struct Memory<const N: usize> {
    /// The last torque, N m or N.
    torque: Option<[f32; N]>,
    /// The brakes have been open since the last safe action.
    drove: bool,
    /// The last good readings.
    readings: Option<Readings<N>>,
    /// It holds the brakes open, whatever the board's line says.
    pub(super) opens: bool,
}

impl<const N: usize> Memory<N> {
    /// Nothing.
    pub(super) const NONE: Self = Self { torque: None, drove: false, readings: None, opens: false };
}

impl<const N: usize, J: JointIo<N>> JointIo<N> for Faulty<'_, J, N> {
    fn measure(&mut self) -> Option<Readings<N>> {
        let mut readings = self.joints.measure()?;
        match self.breakage {
            Some(Breakage::EnableCountsAsSent) => readings.on = [true; N],
            Some(Breakage::ZeroNeverLost) => readings.zero_lost = false,
            Some(Breakage::OffUnnoticed) => {
                if readings.on == [true; N] && readings.age_ticks == [0; N] {
                    self.memory.readings = Some(readings);
                } else if let Some(last) = self.memory.readings {
                    readings = last;
                }
            }
            _ => {}
        }
        Some(readings)
    }

    fn temperature(&self) -> Option<f32> {
        self.joints.temperature()
    }

    fn enable(&mut self, action: SafeAction) {
        self.memory.opens = false;
        self.joints.enable(action);
    }

    fn preload(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        self.memory.opens = self.breakage == Some(Breakage::BrakesOpenEarly);
        match self.breakage {
            Some(Breakage::NoPreload) => self.joints.preload(&[0.0; N], None),
            Some(Breakage::NoBrakeDelay) if self.memory.drove => self.joints.preload(&[0.0; N], None),
            _ => self.joints.preload(torque, springs),
        }
    }

    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        let torque = if self.breakage == Some(Breakage::HalfTorque) { torque.map(|it| 0.5 * it) } else { *torque };
        (self.memory.torque, self.memory.drove) = (Some(torque), true);
        self.memory.opens = matches!(
            self.breakage,
            Some(Breakage::EnableCountsAsSent | Breakage::OffUnnoticed | Breakage::BrakesStayOpen)
        );
        self.joints.drive(&torque, springs);
    }

    fn safe(&mut self, action: SafeAction) {
        self.memory.opens &= self.breakage == Some(Breakage::BrakesStayOpen);
        (self.memory.readings, self.memory.drove) = (None, false);
        match (self.breakage, self.memory.torque) {
            (Some(Breakage::NoDamping), _) => self.joints.safe(SafeAction::Off),
            (Some(Breakage::TorqueGoesOn), Some(torque)) => self.joints.drive(&torque, None),
            _ => self.joints.safe(action),
        }
    }

    fn clear(&mut self) {
        self.joints.clear();
    }
}
