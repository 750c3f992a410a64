//! Limits of `firmware/budget.toml` that apply regardless of the blessed ranges.

use super::row::{BudgetRow, Field};
use std::collections::BTreeMap;

/// Limits that apply regardless of the blessed ranges.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Targets {
    /// Largest flash of any firmware, bytes.
    pub(super) flash: u64,
    /// Largest RAM of any firmware, including the bound of its stack, bytes.
    pub(super) ram_with_stack: u64,
    /// The same limit for boards that need more RAM, by board name.
    #[serde(default)]
    pub(super) ram_with_stack_of: BTreeMap<String, u64>,
    /// Largest number of instructions for which the tick's interrupt may be masked.
    pub(super) masked: u64,
    /// Scene with a limit on the tick's share of the time.
    pub(super) share_scene: String,
    /// Tick rate for that limit, Hz.
    pub(super) share_rate_hz: u64,
    /// Clock of the core for that limit, Hz.
    pub(super) share_clock_hz: u64,
    /// Largest estimated cycles of the tick for that limit, percent of a period.
    pub(super) share_percent: u64,
}

impl Targets {
    pub(super) fn hold(&self, row: &BudgetRow) -> Vec<String> {
        let name = row.name();
        let mut lines = Vec::new();
        let mut below = |what: &str, found: Option<u64>, most: u64, unit: &str| {
            if let Some(found) = found.filter(|found| *found > most) {
                lines.push(format!("{name}: {what}: {found} {unit} found, expected at most {most}: a target"));
            }
        };
        below("flash", row.number(Field::Flash), self.flash, "bytes");
        let ram = row.number(Field::Ram).zip(row.number(Field::StackBound)).map(|(ram, stack)| ram + stack);
        let most = self.ram_with_stack_of.get(&row.board).copied().unwrap_or(self.ram_with_stack);
        below("ram with stack", ram, most, "bytes");
        below("masked", row.number(Field::Masked), self.masked, "instructions");
        if row.scene == self.share_scene {
            let most = self.share_clock_hz * self.share_percent / (100 * self.share_rate_hz.max(1));
            below("cycles_estimate", row.number(Field::CyclesEstimate), most, "cycles, estimated,");
        }
        lines
    }
}
