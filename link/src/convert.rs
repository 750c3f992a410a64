//! Conversions between frames and the types of the control loop, which have the joint count as a type parameter.

use crate::frame::{self, Joints};
use core::fmt;
use dynamics_core::control::LimitFlags;
use dynamics_core::safety::{Actuation, Refusal, Request, SafeAction};
use dynamics_core::{Command, Fault, Inertia, Live, Measurement, Reference, Sensed, Wrench};
use nalgebra::{Matrix3, Vector3};

/// Error: a frame has values for another number of joints than the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointCountMismatch {
    /// Number of joints of the controller.
    pub expected: usize,
    /// Number of joints in the frame.
    pub found: usize,
}

impl fmt::Display for JointCountMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame has values for {} joints, expected {}", self.found, self.expected)
    }
}

impl core::error::Error for JointCountMismatch {}

impl From<JointCountMismatch> for frame::Refusal {
    fn from(JointCountMismatch { expected, found }: JointCountMismatch) -> Self {
        let short = |count| u8::try_from(count).unwrap_or(u8::MAX);
        Self::JointCount { expected: short(expected), found: short(found) }
    }
}

/// Error: a payload's inertia tensor is not symmetric to the last bit. A frame carries six of the nine entries, so the chip would compute with
/// other entries than the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AsymmetricInertia {
    /// The entry above the diagonal that differs from the one below: `"xy"`, `"xz"` or `"yz"`.
    pub entry: &'static str,
}

impl fmt::Display for AsymmetricInertia {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the live payload's inertia is not symmetric in {}, expected the very same bits on both sides",
            self.entry
        )
    }
}

impl core::error::Error for AsymmetricInertia {}

/// Converts an array to a joint vector. The compiler checks that `N` is at most [`crate::JOINTS_MAX`].
#[must_use]
pub fn joints<T: Clone, const N: usize>(values: &[T; N]) -> Joints<T> {
    const { assert!(N <= crate::JOINTS_MAX, "a frame carries at most six joints") };
    Joints::from_slice(values).unwrap_or_default()
}

/// Converts a joint vector to an array.
///
/// # Errors
/// [`JointCountMismatch`] if it has values for another number of joints.
pub fn array<T: Copy, const N: usize>(values: &Joints<T>) -> Result<[T; N], JointCountMismatch> {
    values.as_slice().try_into().map_err(|_| JointCountMismatch { expected: N, found: values.len() })
}

impl frame::Measurement {
    /// Creates the frame that carries a measurement for tick number `tick`.
    #[must_use]
    pub fn new<const N: usize>(tick: u32, measurement: &Measurement<f32, N>) -> Self {
        Self { tick, age_ticks: measurement.age_ticks, sensed: frame::Sensed::new(&measurement.sensed) }
    }

    /// Converts to the controller's type.
    ///
    /// # Errors
    /// [`JointCountMismatch`] if the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Measurement<f32, N>, JointCountMismatch> {
        Ok(Measurement { sensed: self.sensed.to_core()?, age_ticks: self.age_ticks })
    }
}

impl frame::Sensed {
    /// Creates the part of a frame that carries a reading.
    #[must_use]
    pub fn new<const N: usize>(sensed: &Sensed<f32, N>) -> Self {
        match sensed {
            Sensed::State { q, qd } => Self::State { q: joints(q), qd: joints(qd) },
            Sensed::Counts(counts) => Self::Counts(joints(counts)),
        }
    }

    /// Converts to the controller's type.
    ///
    /// # Errors
    /// [`JointCountMismatch`] if the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Sensed<f32, N>, JointCountMismatch> {
        Ok(match self {
            Self::State { q, qd } => Sensed::State { q: array(q)?, qd: array(qd)? },
            Self::Counts(counts) => Sensed::Counts(array(counts)?),
        })
    }
}

impl frame::Reference {
    /// Creates the frame that carries a reference.
    #[must_use]
    pub fn new<const N: usize>(reference: &Reference<f32, N>) -> Self {
        Self { q: joints(&reference.q), qd: joints(&reference.qd), qdd: joints(&reference.qdd) }
    }

    /// Converts to the controller's type.
    ///
    /// # Errors
    /// [`JointCountMismatch`] if the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Reference<f32, N>, JointCountMismatch> {
        Ok(Reference { q: array(&self.q)?, qd: array(&self.qd)?, qdd: array(&self.qdd)? })
    }
}

impl frame::Live {
    /// Creates the frame that carries the live inputs of a scene.
    ///
    /// # Errors
    /// [`AsymmetricInertia`] if the payload's tensor is not symmetric to the last bit. Rounding after a rotation causes that; see
    /// [`Inertia::symmetric`].
    pub fn new<const N: usize>(live: &Live<f32, N>) -> Result<Self, AsymmetricInertia> {
        let Live { gravity, payload, tip_wrench: Wrench { force, moment }, rotor } = live;
        let tensor = &payload.about_origin;
        for (entry, i, j) in [("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)] {
            if tensor[(i, j)].to_bits() != tensor[(j, i)].to_bits() {
                return Err(AsymmetricInertia { entry });
            }
        }
        Ok(Self {
            gravity: (*gravity).into(),
            tip_wrench: [force.x, force.y, force.z, moment.x, moment.y, moment.z],
            payload: frame::Payload {
                mass: payload.mass,
                first_moment: payload.first_moment.into(),
                inertia: [tensor.m11, tensor.m22, tensor.m33, tensor.m12, tensor.m13, tensor.m23],
            },
            rotor: joints(rotor),
        })
    }

    /// Converts to the controller's type.
    ///
    /// # Errors
    /// [`JointCountMismatch`] if the frame is for another number of joints.
    pub fn to_core<const N: usize>(&self) -> Result<Live<f32, N>, JointCountMismatch> {
        let [fx, fy, fz, mx, my, mz] = self.tip_wrench;
        let [xx, yy, zz, xy, xz, yz] = self.payload.inertia;
        Ok(Live {
            gravity: self.gravity.into(),
            payload: Inertia {
                mass: self.payload.mass,
                first_moment: self.payload.first_moment.into(),
                about_origin: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            },
            tip_wrench: Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) },
            rotor: array(&self.rotor)?,
        })
    }

    /// True if all numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let Self { gravity, tip_wrench, payload: frame::Payload { mass, first_moment, inertia }, rotor } = self;
        let mut all = gravity.iter().chain(tip_wrench).chain([mass]).chain(first_moment).chain(inertia).chain(rotor);
        all.all(|x| x.is_finite())
    }
}

impl frame::Frame {
    /// Creates the answer to tick number `tick`: a command frame, or a fault frame if the controller brakes.
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

impl frame::Request {
    /// Requests that the safety state machine decides on: all but the release of the black box, which the session handles.
    pub const OF_THE_MACHINE: [Self; 9] = [
        Self::Stop,
        Self::FullRange,
        Self::Home,
        Self::Confirm,
        Self::Arm,
        Self::Disarm,
        Self::Run,
        Self::Hold,
        Self::Clear,
    ];

    /// Each request with its name, as users enter it.
    pub const NAMES: [(Self, &'static str); 10] = [
        (Self::Home, "home"),
        (Self::Confirm, "confirm"),
        (Self::Arm, "arm"),
        (Self::Disarm, "disarm"),
        (Self::Run, "run"),
        (Self::Hold, "hold"),
        (Self::Clear, "clear"),
        (Self::Stop, "stop"),
        (Self::FullRange, "full-range"),
        (Self::Release, "release"),
    ];

    /// Converts to the safety state machine's type; `None` for [`Self::Release`], which is for the black box.
    #[must_use]
    pub const fn to_core(self) -> Option<Request> {
        Some(match self {
            Self::Home => Request::Home,
            Self::Confirm => Request::Confirm,
            Self::Arm => Request::Arm,
            Self::Disarm => Request::Disarm,
            Self::Run => Request::Run,
            Self::Hold => Request::Hold,
            Self::Clear => Request::Clear,
            Self::Stop => Request::Stop,
            Self::FullRange => Request::FullRange,
            Self::Release => return None,
        })
    }
}

impl frame::Denial {
    /// Creates the part of a frame that carries a refusal.
    #[must_use]
    pub const fn new(refusal: Refusal) -> Self {
        let (fault, joint) = match refusal {
            Refusal::Fault(fault) | Refusal::Implausible(fault) => (fault.code(), fault.joint()),
            Refusal::NoRoom { joint } | Refusal::OutOfReach { joint } | Refusal::FirstMotion { joint } => {
                (0, Some(joint))
            }
            Refusal::WrongState
            | Refusal::NotHomed
            | Refusal::NotZeroed
            | Refusal::NotAtRest
            | Refusal::HeartbeatLost
            | Refusal::NoReference
            | Refusal::ChangePending
            | Refusal::MissingInput(_)
            | Refusal::StaleInput(_)
            | Refusal::Unread => (0, None),
        };
        let input = match refusal {
            Refusal::MissingInput(input) | Refusal::StaleInput(input) => input.code(),
            _ => 0,
        };
        Self { code: refusal.code(), fault, joint, input }
    }
}

impl frame::Actuation {
    /// Creates the part of a frame that carries the action of the drives.
    #[must_use]
    pub fn new<const N: usize>(actuation: &Actuation<f32, N>) -> Self {
        match actuation {
            Actuation::Drive { torque, limits } => {
                Self::Drive { torque: joints(torque), limits: joints(&limits.map(LimitFlags::bits)) }
            }
            Actuation::Safe(SafeAction::Brake) => Self::Brake,
            Actuation::Safe(SafeAction::DampedStop) => Self::DampedStop,
            Actuation::Safe(SafeAction::Off) => Self::Off,
            Actuation::Enable(_) => Self::Enable,
            Actuation::Preload { torque, limits } => {
                Self::Preload { torque: joints(torque), limits: joints(&limits.map(LimitFlags::bits)) }
            }
        }
    }
}

impl frame::Command {
    /// Converts to the controller's type.
    ///
    /// # Errors
    /// [`JointCountMismatch`] if the frame is for another number of joints.
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
