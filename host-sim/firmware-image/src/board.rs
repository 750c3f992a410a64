//! The boards that the firmware runs on, and their chips.

use std::fmt;

/// The default scene.
pub const SCENE_DEFAULT: &str = "scenes/puma560_pick.toml";

/// The target of every board's chip: a Cortex-M4 with a single-precision unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// A board that the firmware runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Board {
    /// The emulated one
    Netduinoplus2,
    /// ODrive v3 and its like
    OdriveV3,
    /// A bare STM32F405 with MIT-mode actuators on two CAN buses
    F405Can,
    /// A bare STM32F405 with H-bridges on PWM and magnetic encoders
    F405Pwm,
    /// An STM32G474 with MIT-mode actuators on three CAN FD buses
    G474Fdcan,
}

impl Board {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Netduinoplus2, Self::OdriveV3, Self::F405Can, Self::F405Pwm, Self::G474Fdcan];

    /// The name of its Cargo feature and of the board.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Netduinoplus2 => "netduinoplus2",
            Self::OdriveV3 => "odrive-v3",
            Self::F405Can => "f405-can",
            Self::F405Pwm => "f405-pwm",
            Self::G474Fdcan => "g474-fdcan",
        }
    }

    /// The default scene of the board: its robot has drives of the kind that the board has lines for.
    pub const fn scene(self) -> &'static str {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 => SCENE_DEFAULT,
            Self::F405Can => "scenes/examples/mit6_wave.toml",
            Self::F405Pwm => "scenes/examples/pwm2_swing.toml",
            Self::G474Fdcan => "scenes/examples/mit6_fd_wave.toml",
        }
    }

    /// The kind of drives that the board has lines for, as a robot file names it. `None` for a board that only talks to
    /// its host and so takes any arm. Another kind would not compile; this check reports it before the compiler starts.
    pub const fn drives(self) -> Option<&'static str> {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 => None,
            Self::F405Can | Self::G474Fdcan => Some("mit"),
            Self::F405Pwm => Some("pwm"),
        }
    }

    /// Its CAN controllers; `None` for a board without.
    pub(crate) const fn can_buses(self) -> Option<CanBuses> {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 | Self::F405Pwm => None,
            Self::F405Can => Some(CanBuses { count: 2, fd: false }),
            Self::G474Fdcan => Some(CanBuses { count: 3, fd: true }),
        }
    }

    /// Its chip.
    pub const fn chip(self) -> Chip {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 | Self::F405Can | Self::F405Pwm => Chip::F405,
            Self::G474Fdcan => Chip::G474,
        }
    }
}

/// The CAN controllers of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanBuses {
    /// Number of controllers.
    pub count: u8,
    /// True if they support FD frames.
    pub fd: bool,
}

/// A microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// STM32F405.
    F405,
    /// STM32G474.
    G474,
}

impl Chip {
    /// Its name for probe-rs.
    pub const fn probe_name(self) -> &'static str {
        match self {
            Self::F405 => "STM32F405RGTx",
            Self::G474 => "STM32G474RETx",
        }
    }

    /// Address of the link key's page, as the chip's `chip_memory.x` has it; a test compares both.
    pub const fn key_page(self) -> &'static str {
        match self {
            Self::F405 => "0x080e0000",
            Self::G474 => "0x0807f000",
        }
    }

    /// Clock of its core as the boards set it, Hz.
    pub const fn clock_hz(self) -> f64 {
        match self {
            Self::F405 => 168e6,
            Self::G474 => 170e6,
        }
    }
}

impl fmt::Display for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Whom a firmware lets talk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// A host with the key in the board's key page.
    #[default]
    Key,
    /// Anybody on the wire.
    Anybody,
}

impl Trust {
    /// The choice of `--insecure`.
    pub const fn insecure(insecure: bool) -> Self {
        if insecure { Self::Anybody } else { Self::Key }
    }

    /// Part of a program's file name.
    pub(crate) const fn suffix(self) -> &'static str {
        match self {
            Self::Key => "",
            Self::Anybody => "-insecure",
        }
    }
}
