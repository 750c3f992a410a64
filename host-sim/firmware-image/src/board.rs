//! The boards that the firmware runs on, and their chips.

use std::fmt;

/// The default scene.
pub const SCENE_DEFAULT: &str = "scenes/puma560_pick.toml";

/// The target of every board's chip: a Cortex-M4 with a single-precision unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Properties of a board that a build needs.
#[derive(Clone, Copy, Debug)]
struct Properties {
    name: &'static str,
    chip: Chip,
    scene: &'static str,
    drives: Option<&'static str>,
    can_buses: Option<CanBuses>,
}

macro_rules! boards {
    ($($(#[$text:meta])* $board:ident $properties:expr;)*) => {
        /// A board that the firmware runs on.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
        pub enum Board {
            $($(#[$text])* $board,)*
        }

        impl Board {
            /// All of them.
            pub const ALL: [Self; [$(stringify!($board)),*].len()] = [$(Self::$board),*];

            const fn properties(self) -> Properties {
                match self {
                    $(Self::$board => $properties,)*
                }
            }
        }
    };
}

boards! {
    /// The emulated one
    Netduinoplus2 Properties {
        name: "netduinoplus2", chip: Chip::F405, scene: SCENE_DEFAULT, drives: None, can_buses: None,
    };
    /// ODrive v3 and its like
    OdriveV3 Properties {
        name: "odrive-v3", chip: Chip::F405, scene: SCENE_DEFAULT, drives: None, can_buses: None,
    };
    /// A bare STM32F405 with MIT-mode actuators on two CAN buses
    F405Can Properties {
        name: "f405-can",
        chip: Chip::F405,
        scene: "scenes/examples/mit6_wave.toml",
        drives: Some("mit"),
        can_buses: Some(CanBuses { count: 2, fd: false, actuators: Some(3) }),
    };
    /// A bare STM32F405 with H-bridges on PWM and magnetic encoders
    F405Pwm Properties {
        name: "f405-pwm",
        chip: Chip::F405,
        scene: "scenes/examples/pwm2_swing.toml",
        drives: Some("pwm"),
        can_buses: None,
    };
    /// An STM32G474 with MIT-mode actuators on three CAN FD buses
    G474Fdcan Properties {
        name: "g474-fdcan",
        chip: Chip::G474,
        scene: "scenes/examples/mit6_fd_wave.toml",
        drives: Some("mit"),
        can_buses: Some(CanBuses { count: 3, fd: true, actuators: None }),
    };
}

impl Board {
    /// The name of the board, which is also that of its Cargo feature.
    pub const fn name(self) -> &'static str {
        self.properties().name
    }

    /// The default scene of the board: its robot has the kind of drives that the board has connections for.
    pub const fn scene(self) -> &'static str {
        self.properties().scene
    }

    /// The kind of drives that the board has connections for, as a robot file names it. `None` for a board that only talks to its host and so accepts
    /// any arm. A scene with another kind would not compile; this lets a check report it before the compiler starts.
    pub const fn drives(self) -> Option<&'static str> {
        self.properties().drives
    }

    /// Its CAN controllers; `None` for a board without CAN.
    pub(crate) const fn can_buses(self) -> Option<CanBuses> {
        self.properties().can_buses
    }

    /// Its chip.
    pub const fn chip(self) -> Chip {
        self.properties().chip
    }
}

/// The CAN controllers of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanBuses {
    /// Number of controllers.
    pub count: u8,
    /// True if they support FD frames.
    pub fd: bool,
    /// Most actuators on a bus, if fewer than an arm has: a bxCAN has three transmit mailboxes, and its receiver holds three replies.
    pub actuators: Option<usize>,
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

    /// Address of the link key's page, as in the chip's `chip_memory.x`; a test compares both.
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

/// Hosts that a firmware accepts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// Only a host with the key in the board's key page.
    #[default]
    Key,
    /// Any host on the link.
    Anybody,
}

impl Trust {
    /// The value for the option `--insecure`.
    pub const fn insecure(insecure: bool) -> Self {
        if insecure { Self::Anybody } else { Self::Key }
    }

    /// Suffix for a program's file name.
    pub(crate) const fn suffix(self) -> &'static str {
        match self {
            Self::Key => "",
            Self::Anybody => "-insecure",
        }
    }
}
