//! Drive of a joint, as a robot file describes it: in the units of data sheets.

use dynamics_core::drive::{DataRate, PositionMemory};

pub use dynamics_core::drive::Protocol;

/// Counts per turn of the magnetic encoder.
pub(crate) const ENCODER_COUNTS: u16 = 1 << 14;

/// The drive of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointDrive {
    /// An actuator on CAN that takes MIT-mode frames.
    Mit(MitSpec),
    /// An H-bridge and a magnetic encoder.
    Pwm(PwmSpec),
}

impl JointDrive {
    /// Kind of wiring that it needs on a board: `"mit"` for any drive on CAN, `"pwm"` for an H-bridge.
    #[must_use]
    pub const fn family(&self) -> &'static str {
        match self {
            Self::Mit(_) => "mit",
            Self::Pwm(_) => "pwm",
        }
    }

    /// Name of the kind in a robot file.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Mit(spec) => spec.protocol.facts().name,
            Self::Pwm(_) => "pwm",
        }
    }

    /// The actuator, if it takes MIT-mode frames.
    #[must_use]
    pub const fn mit(&self) -> Option<MitSpec> {
        match self {
            Self::Mit(spec) => Some(*spec),
            Self::Pwm(_) => None,
        }
    }
}

/// An actuator of `robot-compiler/actuators.toml`. Its ranges are symmetric, except those of `kp` and `kd`, which begin at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Its name in a robot file.
    pub name: String,
    /// Its frames.
    pub protocol: Protocol,
    /// Highest position of its frames, rad.
    pub position: f64,
    /// Highest velocity of its frames, rad/s.
    pub velocity: f64,
    /// Highest torque of its frames, N m.
    pub torque: f64,
    /// Highest stiffness of its frames, N m/rad.
    pub kp: f64,
    /// Highest damping of its frames, N m s/rad.
    pub kd: f64,
    /// Continuous torque, N m, if known.
    pub rated: Option<f64>,
    /// Peak torque for a short time, N m, if known.
    pub peak: Option<f64>,
    /// Thermal time constant of its winding, s, if known.
    pub time_constant: Option<f64>,
    /// Rotor inertia at the output shaft, kg m^2, if known.
    pub rotor: Option<f64>,
    /// Rotor turns per turn of the output shaft, if known.
    pub gear: Option<f64>,
    /// Torque constant at the output shaft, N m per A (rms) of a phase, if known.
    pub torque_constant: Option<f64>,
    /// The part of its position that survives a loss of power, if known for this model. Restarts are judged by its kind's
    /// [`DriveFacts::memory`](dynamics_core::drive::DriveFacts::memory).
    pub memory: Option<PositionMemory>,
    /// Speed without load, rad/s at the output shaft, and the supply voltage for which it is stated, V, if known.
    pub no_load: Option<(f64, f64)>,
    /// Source of the numbers.
    pub source: String,
}

/// An actuator on CAN that takes MIT-mode frames. Ranges are `(lowest, highest)`, at its shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MitSpec {
    /// Its frames.
    pub protocol: Protocol,
    /// The bus, 1 to 3.
    pub bus: u8,
    /// Bit rate of the data of its FD frames; `None` for classic frames.
    pub data_rate: Option<DataRate>,
    /// Identifier of its commands.
    pub id: u8,
    /// Identifier of its replies.
    pub reply_id: u16,
    /// Bytes of a reply, 6 to 8.
    pub reply_bytes: u8,
    /// Temperature of code 0 in a reply with a temperature, degrees Celsius.
    pub temperature_offset: Option<f64>,
    /// Shaft radians per joint radian or metre; negative if shaft and joint turn in opposite directions.
    pub ratio: f64,
    /// Position of the shaft at `q = 0`, rad.
    pub zero: f64,
    /// Position range, rad.
    pub position: (f64, f64),
    /// Velocity range, rad/s.
    pub velocity: (f64, f64),
    /// Stiffness range, N m/rad.
    pub kp: (f64, f64),
    /// Damping range, N m s/rad.
    pub kd: (f64, f64),
    /// Torque range, N m.
    pub torque: (f64, f64),
    /// Damping of a damped stop, N m s/rad.
    pub damping: f64,
}

/// An H-bridge, its motor, and a magnetic encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PwmSpec {
    /// The board's channel, counted from 1.
    pub channel: u8,
    /// Motor radians per joint radian or metre; negative if motor and joint turn in opposite directions.
    pub ratio: f64,
    /// Encoder reading at `q = 0`, counts.
    pub encoder_zero: u16,
    /// True if the encoder counts down as the joint moves up.
    pub encoder_reversed: bool,
    /// Torque constant, N m/A; also the back-EMF constant, V s/rad.
    pub torque_constant: f64,
    /// Resistance, ohm.
    pub resistance: f64,
    /// Supply voltage, V.
    pub supply: f64,
    /// Greatest current, A.
    pub current_max: f64,
}
