//! A board with a deliberate fault, to show that the judge detects its effects.

use dynamics_core::Sensed;
use dynamics_core::control::Spring;
use dynamics_core::safety::SafeAction;
use joint_io::JointIo;
use link::StateCode;
use session::readings::Readings;
use sim::plant::drives::Drives;

/// The deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breakage {
    /// A drive counts as on as soon as its enable frame is packed, and the brakes open with the first torque.
    EnableCountsAsSent,
    /// The drives carry no load before the brakes open.
    NoPreload,
    /// A zero that may be lost is not reported.
    ZeroNeverLost,
    /// The brakes open when the drives are on, before they carry the arm.
    BrakesOpenEarly,
    /// The brakes stay open in the safe action.
    BrakesStayOpen,
    /// A request to hold never arrives.
    HoldLost,
    /// The host's silence is never detected.
    HostNeverMissed,
    /// A drive that goes off is not noticed.
    OffUnnoticed,
    /// The safe action of an arm without brakes switches the drives off.
    NoDamping,
    /// The last torque continues in the safe action.
    TorqueGoesOn,
    /// Torque is half of what it should be.
    HalfTorque,
    /// Brakes that are engaged slip under any load.
    BrakesSlip,
    /// Brakes engage one second after their line closes.
    BrakesLate,
    /// A drive that receives no frames never ends its torque by its own timeout.
    TimeoutNeverActs,
    /// The readings of a holding arm drift, so that the arm follows the drift.
    HoldCreeps,
    /// Torque ends in the tick in which the brakes lose their power.
    NoBrakeDelay,
}

/// Delay of late brakes, s.
const LATE: f64 = 1.0;

/// Drift of a reading per tick, rad, and the tick of a hold in which it begins.
const CREEP: f32 = 1.2e-4;
const CREEP_FROM: u32 = 300;

/// The board's joints, with or without a deliberate fault.
pub(super) struct Faulty<'a, J: ?Sized, const N: usize> {
    /// The joints.
    pub(super) joints: &'a mut J,
    /// The deliberate fault.
    pub(super) breakage: Option<Breakage>,
    /// State that lasts from tick to tick.
    pub(super) memory: &'a mut Memory<N>,
}

/// State of a board with a deliberate fault.
#[derive(Clone, Copy, Debug)]
pub(super) struct Memory<const N: usize> {
    /// The last torque, N m or N.
    torque: Option<[f32; N]>,
    /// True if torque has been commanded on open brakes since the last safe action.
    drove: bool,
    /// The last good readings.
    readings: Option<Readings<N>>,
    /// True if the deliberate fault holds the brakes open, regardless of the board's line.
    pub(super) opens: bool,
    /// Ticks since the brakes were open.
    closed: u32,
    /// Ticks of the hold.
    held: u32,
}

impl<const N: usize> Memory<N> {
    /// Initial state.
    pub(super) const NONE: Self =
        Self { torque: None, drove: false, readings: None, opens: false, closed: u32::MAX, held: 0 };

    /// Begins a tick in this state of the machine.
    pub(super) fn begin(&mut self, state: StateCode) {
        self.held = if state == StateCode::Holding { self.held.saturating_add(1) } else { 0 };
    }

    /// True if the brakes do not hold the arm although their line is closed. Call it once per tick; `period` in s.
    pub(super) fn slips(&mut self, breakage: Option<Breakage>, open: bool, period: f64) -> bool {
        self.closed = if open { 0 } else { self.closed.saturating_add(1) };
        match breakage {
            Some(Breakage::BrakesSlip) => true,
            Some(Breakage::BrakesLate) => f64::from(self.closed) * period < LATE,
            _ => false,
        }
    }
}

/// Removes the timeout from every drive that has received nothing in this tick. The board has set it and read it back correctly.
pub(super) fn without_timeouts<const N: usize>(drives: &mut Drives<N>) {
    for joint in 0..N {
        if let Some(it) = drives.electronics(joint).filter(|it| it.silent_for() > 0.0) {
            it.timeout = f64::INFINITY;
        }
    }
}

impl<const N: usize, J: JointIo<N> + ?Sized> JointIo<N> for Faulty<'_, J, N> {
    fn measure(&mut self) -> Option<Readings<N>> {
        let mut readings = self.joints.measure()?;
        match self.breakage {
            Some(Breakage::EnableCountsAsSent) => readings.on = [true; N],
            Some(Breakage::ZeroNeverLost) => readings.zero_lost = false,
            Some(Breakage::HoldCreeps) => {
                if let Sensed::State { q, .. } = &mut readings.sensed {
                    let drift = CREEP * self.memory.held.saturating_sub(CREEP_FROM) as f32;
                    q.iter_mut().for_each(|q| *q += drift);
                }
            }
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
