//! Kinds of drives on CAN that take position, velocity, stiffness, damping and torque in one frame.
//!
//! A kind is a type with the facts from its maker's document, [`DriveKind`], and a line of the registry at the end of this file. Its frames are
//! `joint_io::Frames`. The simulated drive is a `Language` of `actuator-model`, also written from the document.

use super::bus_time::Identifier;

/// The part of a drive's position that survives a loss of power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionMemory {
    /// All of it.
    Absolute,
    /// Its angle within one turn of the output shaft.
    OutputTurn,
    /// Its angle within one turn of the motor, before the gear: after a restart the output position may be wrong by whole motor turns.
    MotorTurn,
    /// Nothing: its position is zero at the start.
    Nothing,
}

/// Facts about a kind of drive, from its maker's document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveFacts {
    /// Name in robot files.
    pub name: &'static str,
    /// The part of its position that survives a loss of power.
    pub memory: PositionMemory,
    /// Shortest restart time, us. A drive that was silent for longer may have restarted.
    ///
    /// No maker states this time. A restart includes the power-on reset of the drive's microcontroller (STM32F4: 0.5 to 3 ms, data sheet,
    /// `t_RSTTEMPO`), the start of its clocks, and the calibration of its current sensors' offset. The 10 ms of every kind here are an assumption
    /// on the safe side: with a shorter time an arm only loses its homing more often.
    pub restart_us: u32,
    /// True if its own communication timeout can be read and set over the bus.
    pub has_timeout: bool,
    /// Identifiers of commands and replies.
    pub identifier: Identifier,
    /// Bits of the fields of velocity and torque.
    pub torque_bits: u32,
    /// True if the number of bytes of a reply differs between makers, so that the robot file gives it. Otherwise a reply has eight bytes.
    pub reply_varies: bool,
    /// True if the ranges of the frames depend on the drive's firmware and not on its model alone. Then a robot file must give them, and
    /// `robot-compiler/actuators.toml` has no actuator of this kind.
    pub ranges_vary: bool,
    /// True if a reply shows whether the drive is on. Otherwise only its torque shows that.
    pub reports_state: bool,
    /// Number of low bits of the drive's identifier that a reply carries.
    pub reply_id_bits: u32,
    /// Identifier of a reply minus the drive's own, if it is fixed. Otherwise the robot file gives the identifier of the replies.
    pub reply_offset: Option<u16>,
    /// Lowest and highest identifier that a drive can have.
    pub ids: (u8, u8),
    /// Offsets of the identifiers of its other modes' commands from its own identifier.
    pub other_modes: &'static [u16],
    /// Identifier with which the settings of all drives of this kind are read and written.
    pub settings_id: Option<u16>,
}

/// A kind of drive as a type, so that a firmware has the frames of one kind.
pub trait DriveKind {
    /// Its facts.
    const FACTS: DriveFacts;
}

/// Frames of the mini-cheetah's motor controller: standard identifiers; a reply carries only the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MiniCheetah;

impl DriveKind for MiniCheetah {
    const FACTS: DriveFacts = DriveFacts {
        name: "mit",
        // Its encoder is on the motor (B. Katz, mini-cheetah motor controller).
        memory: PositionMemory::MotorTurn,
        restart_us: 10_000,
        has_timeout: false,
        identifier: Identifier::Standard,
        torque_bits: 12,
        reply_varies: true,
        ranges_vary: false,
        reports_state: false,
        reply_id_bits: 8,
        reply_offset: None,
        ids: (0, 255),
        other_modes: &[],
        settings_id: None,
    };
}

/// Frames of Damiao's motors: the mini-cheetah's commands. A reply carries the motor's on/off state, its error, and two temperatures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Damiao;

impl DriveKind for Damiao {
    const FACTS: DriveFacts = DriveFacts {
        name: "damiao",
        // Types that end in `2EC` have a second encoder on the output shaft, absolute within its turn ("DM-J4310-2EC V1.2 Motor
        // Instruction Manual").
        memory: PositionMemory::OutputTurn,
        restart_us: 10_000,
        has_timeout: true,
        identifier: Identifier::Standard,
        torque_bits: 12,
        reply_varies: false,
        ranges_vary: false,
        reports_state: true,
        reply_id_bits: 4,
        reply_offset: None,
        ids: (0, 255),
        // Position and velocity; velocity; position and force.
        other_modes: &[0x100, 0x200, 0x300],
        settings_id: Some(0x7ff),
    };
}

/// Frames of RobStride's own protocol: extended identifiers, which carry the kind of a frame and the torque of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RobStride;

impl DriveKind for RobStride {
    const FACTS: DriveFacts = DriveFacts {
        name: "robstride",
        // After a start its position is within one turn of the output shaft (RS00 manual, parameter `zero_sta`).
        memory: PositionMemory::OutputTurn,
        restart_us: 10_000,
        has_timeout: true,
        identifier: Identifier::Extended,
        torque_bits: 16,
        reply_varies: false,
        ranges_vary: false,
        reports_state: true,
        reply_id_bits: 8,
        reply_offset: None,
        ids: (0, 255),
        other_modes: &[],
        settings_id: None,
    };
}

/// Frames of MyActuator's RMD drives in motion mode: the mini-cheetah's commands and replies, with identifiers of their own.
///
/// A reply carries only the state. Switching on, switching off and the drive's status have other identifiers and other answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MyActuator;

impl DriveKind for MyActuator {
    const FACTS: DriveFacts = DriveFacts {
        name: "myactuator",
        // Generation V2 has one encoder, on the motor; V3 and V4 have a second one on the output. No document says what the position of motion
        // mode is after a start, so the least is assumed.
        memory: PositionMemory::MotorTurn,
        // A reset was measured to take 1.12 s (almond-bot/axol, `myactuator.py`).
        restart_us: 10_000,
        // It can be written (0xB3), not read, and is kept without power.
        has_timeout: false,
        identifier: Identifier::Standard,
        torque_bits: 12,
        reply_varies: false,
        ranges_vary: true,
        reports_state: false,
        reply_id_bits: 8,
        reply_offset: Some(0x500),
        // The maker's range.
        ids: (1, 32),
        other_modes: &[],
        settings_id: None,
    };
}

macro_rules! registry {
    ($d:tt $($kind:ident),*) => {
        /// A kind of drive as a value, for programs that read robot files.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Protocol {
            $(
                #[doc = concat!("[`", stringify!($kind), "`](struct@", stringify!($kind), ").")]
                $kind,
            )*
        }

        impl Protocol {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// Its facts.
            #[must_use]
            pub const fn facts(self) -> DriveFacts {
                match self {
                    $(Self::$kind => <$kind as DriveKind>::FACTS,)*
                }
            }

            /// Name of its type.
            #[must_use]
            pub const fn type_name(self) -> &'static str {
                match self {
                    $(Self::$kind => stringify!($kind),)*
                }
            }
        }

        /// Calls a macro with the names of the types of all kinds: `with_drive_kinds!(name)` is `name! { Kind Kind .. }`.
        #[macro_export]
        macro_rules! with_drive_kinds {
            ($d name:ident) => {
                $d name! { $($kind)* }
            };
        }
    };
}

registry! { $ MiniCheetah, Damiao, RobStride, MyActuator }
