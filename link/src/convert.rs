//! To and from the types of the control loop, whose joint count is part of the type.

use crate::frame::{self, Joints};
use core::fmt;
use dynamics_core::control::LimitFlags;
use dynamics_core::{Command, Fault, Measurement, Reference, Sensed};

/// A frame has values for another number of joints than the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointCountMismatch {
    /// What the controller was built for.
    pub expected: usize,
    /// What the frame holds.
    pub found: usize,
}

impl fmt::Display for JointCountMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame has values for {} joints, expected {}", self.found, self.expected)
    }
}

impl core::error::Error for JointCountMismatch {}

/// An array as a joint vector. No arm has more than [`crate::JOINTS_MAX`] joints; the compiler checks it.
fn joints<T: Clone, const N: usize>(values: &[T; N]) -> Joints<T> {
    const { assert!(N <= crate::JOINTS_MAX, "a frame carries at most six joints") };
    Joints::from_slice(values).unwrap_or_default()
}

fn array<T: Copy, const N: usize>(values: &Joints<T>) -> Result<[T; N], JointCountMismatch> {
    values.as_slice().try_into().map_err(|_| JointCountMismatch { expected: N, found: values.len() })
}

impl frame::Measurement {
    /// The frame that carries a measurement to tick number `tick`.
    #[must_use]
    pub fn new<const N: usize>(tick: u32, measurement: &Measurement<f32, N>) -> Self {
        let sensed = match &measurement.sensed {
            Sensed::State { q, qd } => frame::Sensed::State { q: joints(q), qd: joints(qd) },
            Sensed::Counts(counts) => frame::Sensed::Counts(joints(counts)),
        };
        Self { tick, age_ticks: measurement.age_ticks, sensed }
    }

    /// What the controller takes.
    ///
    /// # Errors
    /// [`JointCountMismatch`] when the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Measurement<f32, N>, JointCountMismatch> {
        let sensed = match &self.sensed {
            frame::Sensed::State { q, qd } => Sensed::State { q: array(q)?, qd: array(qd)? },
            frame::Sensed::Counts(counts) => Sensed::Counts(array(counts)?),
        };
        Ok(Measurement { sensed, age_ticks: self.age_ticks })
    }
}

impl frame::Reference {
    /// The frame that carries a reference.
    #[must_use]
    pub fn new<const N: usize>(reference: &Reference<f32, N>) -> Self {
        Self { q: joints(&reference.q), qd: joints(&reference.qd), qdd: joints(&reference.qdd) }
    }

    /// What the controller takes.
    ///
    /// # Errors
    /// [`JointCountMismatch`] when the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Reference<f32, N>, JointCountMismatch> {
        Ok(Reference { q: array(&self.q)?, qd: array(&self.qd)?, qdd: array(&self.qdd)? })
    }
}

impl frame::Frame {
    /// The answer to tick number `tick`: a command frame, or a fault frame when the controller brakes.
    #[must_use]
    pub fn answer<const N: usize>(tick: u32, command: &Command<f32, N>, cost: Option<frame::Cost>) -> Self {
        match command {
            Command::Drive { torque, limits } => Self::Command(frame::Command {
                tick,
                torque: joints(torque),
                limits: joints(&limits.map(LimitFlags::bits)),
                cost,
            }),
            Command::Brake(fault) => Self::Fault(frame::Fault { tick, code: fault.code(), joint: fault.joint() }),
        }
    }
}

impl frame::Command {
    /// What the control loop gave on the other side.
    ///
    /// # Errors
    /// [`JointCountMismatch`] when the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Command<f32, N>, JointCountMismatch> {
        Ok(Command::Drive { torque: array(&self.torque)?, limits: array(&self.limits)?.map(LimitFlags::from_bits) })
    }
}

impl frame::Fault {
    /// The fault with this number, if this version of the core knows it.
    #[must_use]
    pub fn to_core(&self) -> Option<Fault> {
        Fault::from_code(self.code, self.joint.unwrap_or(0))
    }
}
