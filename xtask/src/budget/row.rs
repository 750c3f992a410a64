//! Numbers of one firmware: one scene on one board.

use super::image::Image;
use clap::ValueEnum;
use firmware_image::Board;
use std::collections::BTreeMap;
use std::path::Path;

/// The board that is emulated.
pub(crate) const EMULATED: Board = Board::Netduinoplus2;

/// Measured numbers, in the order of the file of bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(crate) enum Field {
    Flash,
    Ram,
    StackBound,
    StackPainted,
    Instructions,
    /// Most minus fewest instructions; zero if all ticks need the same number.
    InstructionsSpread,
    /// Instructions of trajectory, safety state machine and controller together, while the arm runs.
    Supervised,
    SupervisedSpread,
    /// Most instructions of a tick that accepts a request, which is the longest kind.
    SupervisedLongest,
    TickInterrupt,
    Masked,
    ByteInterrupt,
    LinkByte,
    CyclesEstimate,
    /// Cycles of the longest interrupt, in a tick that accepts a request.
    #[value(name = "cycles_estimate_longest")]
    CyclesLongest,
}

impl Field {
    /// Key in `firmware/budget.toml`.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    pub(crate) fn of(name: &str) -> Option<Self> {
        Self::from_str(name, false).ok()
    }

    /// True if the number is exactly reproducible: the emulator's counts for the same ticks of the same program.
    pub(crate) const fn repeats(self) -> bool {
        matches!(self, Self::Instructions | Self::InstructionsSpread)
    }

    pub(crate) const fn unit(self) -> &'static str {
        match self {
            Self::Flash | Self::Ram | Self::StackBound | Self::StackPainted => "bytes",
            Self::CyclesEstimate | Self::CyclesLongest => "cycles, estimated",
            _ => "instructions",
        }
    }
}

/// A firmware's numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct BudgetRow {
    pub(crate) scene: String,
    pub(crate) board: String,
    pub(crate) numbers: BTreeMap<Field, u64>,
}

impl BudgetRow {
    /// A row with the numbers of the linked program only.
    pub(crate) fn sizes(scene: &Path, board: Board, image: &Image) -> Self {
        let numbers =
            [(Field::Flash, image.flash), (Field::Ram, image.ram), (Field::StackBound, image.stack_bound)].into();
        Self { scene: stem(scene), board: board.name().into(), numbers }
    }

    pub(crate) fn number(&self, field: Field) -> Option<u64> {
        self.numbers.get(&field).copied()
    }

    /// `puma560_pick on netduinoplus2`
    pub(crate) fn name(&self) -> String {
        format!("{} on {}", self.scene, self.board)
    }
}

/// A file's name without folder and extension.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
