//! The table of `docs/measured/budget.md`, and its rows in the README.

use super::row::{BudgetRow, Field};
use crate::table::{Table, thousands};
use chip_image::costs::{Late, LinkInterrupts, Runs, Ways};

/// Cycles of the core in one period at 4 kHz.
const PERIOD_4_KHZ: u64 = 168_000_000 / 4_000;

/// Table with a line for each firmware.
pub(crate) fn markdown(rows: &[BudgetRow]) -> String {
    let mut table = Table::new(&[
        "scene",
        "board",
        "instructions of the controller",
        "tick with safety state machine",
        "one that grants a request",
        "flash, bytes",
        "RAM, bytes",
        "stack: seen / bound",
        "masked",
        "per link byte",
        "cycles of the tick's interrupt, estimated: running / the longest",
        "share of 168 MHz at 4 kHz, estimated",
    ]);
    for row in rows {
        let cell = |field| row.number(field).map_or_else(|| "-".into(), thousands);
        table.row(&[
            format!("`{}`", row.scene),
            row.board.clone(),
            between(row, Field::Instructions, Field::InstructionsSpread),
            between(row, Field::Supervised, Field::SupervisedSpread),
            cell(Field::SupervisedLongest),
            cell(Field::Flash),
            cell(Field::Ram),
            format!("{} / {}", cell(Field::StackPainted), cell(Field::StackBound)),
            cell(Field::Masked),
            cell(Field::LinkByte),
            format!("{} / {}", cell(Field::CyclesEstimate), cell(Field::CyclesLongest)),
            row.number(Field::CyclesEstimate).map_or_else(|| "-".into(), share),
        ]);
    }
    table.0
}

/// Scenes in the README: the smallest arm, six joints, and six joints with collision detection.
const SHOWN: [&str; 3] = ["planar2r_sine", "puma560_pick", "puma560_collision"];

/// True if these rows include all of the README's.
pub(crate) fn shows(rows: &[BudgetRow]) -> bool {
    SHOWN.iter().all(|scene| rows.iter().any(|row| row.scene == *scene && row.number(Field::Instructions).is_some()))
}

/// The README's rows, all of the emulated board.
pub(crate) fn teaser(rows: &[BudgetRow]) -> String {
    let mut table = Table::new(&[
        "scene",
        "instructions of the controller",
        "tick with safety state machine",
        "flash, bytes",
        "RAM, bytes",
        "share of 168 MHz at 4 kHz, estimated",
    ]);
    for scene in SHOWN {
        for row in rows.iter().filter(|row| row.scene == scene && row.number(Field::Instructions).is_some()) {
            let cell = |field| row.number(field).map_or_else(|| "-".into(), thousands);
            table.row(&[
                format!("`{}`", row.scene),
                between(row, Field::Instructions, Field::InstructionsSpread),
                between(row, Field::Supervised, Field::SupervisedSpread),
                cell(Field::Flash),
                cell(Field::Ram),
                row.number(Field::CyclesEstimate).map_or_else(|| "-".into(), share),
            ]);
        }
    }
    table.0
}

/// One number, or two if least and most differ.
fn between(row: &BudgetRow, most: Field, spread: Field) -> String {
    match row.number(most).zip(row.number(spread)) {
        None => "-".into(),
        Some((most, 0)) => thousands(most),
        Some((most, spread)) => format!("{} to {}", thousands(most - spread), thousands(most)),
    }
}

fn share(cycles: u64) -> String {
    format!("{:.1} %", 100.0 * cycles as f64 / PERIOD_4_KHZ as f64)
}

/// Table of the flood's results.
pub(crate) fn late(late: &Late) -> String {
    let mut table =
        Table::new(&["ticks", "began late", "latest, instructions", "bytes to the chip", "bytes from the chip"]);
    table.row(&[late.ticks, late.delayed, late.most, late.bytes_to_chip, late.bytes_from_chip].map(thousands));
    table.0
}

/// Bytes per second in each direction at 1 Mbaud; a byte has ten bits on the wire.
const BYTES_A_SECOND: f64 = 100_000.0;

/// Clock of the core, Hz.
const CLOCK: f64 = 168e6;

/// Smallest number of cycles for the core's entry into an interrupt and its return.
const ENTRY_AND_RETURN: u64 = 24;

/// Table of the link's cost at its full rate in both directions.
pub(crate) fn ways(Ways { bytes, dma }: &Ways) -> String {
    let mut table = Table::new(&[
        "the link's bytes go",
        "interrupts above the tick, a second",
        "instructions a byte: above the tick / below",
        "cycles a byte, estimated: above the tick / below",
        "share of the processor, estimated: above the tick / below",
        "sending waits for the line",
    ]);
    // A transmitter without DMA must wait for each byte while the line is busy; at the full rate that is always.
    for (name, way, waits) in [("one at a time", bytes, "100 %"), ("by DMA", dma, "while the queue is full")] {
        let load = Load::of(way);
        let two = |[above, below]: [f64; 2]| format!("{above:.1} / {below:.1}");
        let [above, below] = load.cycles.map(|cycles| 100.0 * cycles * BYTES_A_SECOND / CLOCK);
        table.row(&[
            name.into(),
            thousands(load.interrupts.round() as u64),
            two(load.instructions),
            two(load.cycles),
            format!("{above:.2} % / {below:.1} %"),
            waits.into(),
        ]);
    }
    table.0
}

/// Cost of a received and a sent byte together. First in interrupts above the tick's priority, then in code below it.
struct Load {
    /// Interrupts above the tick per second.
    interrupts: f64,
    instructions: [f64; 2],
    /// Cycles, including interrupt entries and returns.
    cycles: [f64; 2],
}

impl Load {
    fn of(way: &LinkInterrupts) -> Self {
        let both = way.to_chip + way.from_chip;
        // `serve` handles a byte in and a byte out, so the per-byte cost counts twice.
        let per = |runs: &Runs, value: fn(&Runs) -> u64, bytes: u64| value(runs) as f64 / bytes.max(1) as f64;
        let sum = |value: fn(&Runs) -> u64| {
            let above = per(&way.receive, value, way.to_chip) + per(&way.half_filled, value, way.to_chip);
            [above, 2.0 * per(&way.serve, value, both) + per(&way.sent, value, way.from_chip)]
        };
        let [interrupts, _] = sum(|runs| runs.times).map(|times| times * BYTES_A_SECOND);
        let cycles = sum(|runs| runs.cycles.likely + ENTRY_AND_RETURN * runs.times);
        Self { interrupts, instructions: sum(|runs| runs.instructions), cycles }
    }
}

#[cfg(test)]
mod tests {
    use super::{markdown, teaser, ways};
    use crate::budget::row::{BudgetRow, Field};
    use chip_image::costs::{Cycles, LinkInterrupts, Runs, Ways};

    fn row() -> BudgetRow {
        BudgetRow {
            scene: "puma560_pick".into(),
            board: "netduinoplus2".into(),
            numbers: [
                (Field::Flash, 36_716),
                (Field::Instructions, 1322),
                (Field::InstructionsSpread, 0),
                (Field::CyclesEstimate, 4200),
            ]
            .into(),
        }
    }

    #[test]
    fn a_row_shows_one_number_where_all_ticks_are_alike_and_a_dash_where_nothing_was_measured() {
        let table = markdown(&[
            row(),
            BudgetRow { numbers: [(Field::Instructions, 1340), (Field::InstructionsSpread, 752)].into(), ..row() },
        ]);
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(
            lines[0],
            "| `puma560_pick` | netduinoplus2 | 1,322 | - | - | 36,716 | - | - / - | - | - | 4,200 / - | 10.0 % |"
        );
        assert!(lines[1].contains("| 588 to 1,340 | - | - | - |"), "{}", lines[1]);
    }

    #[test]
    fn the_readme_shows_three_scenes_of_the_emulated_board_alone() {
        let sizes_only = BudgetRow { numbers: [(Field::Flash, 52_520)].into(), ..row() };
        let other = BudgetRow { scene: "ur5_wave".into(), ..row() };
        let table = teaser(&[other, row(), sizes_only]);
        assert_eq!(table.lines().skip(2).collect::<Vec<_>>(), ["| `puma560_pick` | 1,322 | - | 36,716 | - | 10.0 % |"]);
    }

    #[test]
    fn the_link_s_load_is_of_a_byte_in_and_a_byte_out() {
        let runs =
            |times, instructions, likely| Runs { times, instructions, cycles: Cycles { likely, ..Cycles::default() } };
        let bytes = LinkInterrupts {
            to_chip: 100,
            from_chip: 300,
            receive: runs(100, 4_000, 6_000),
            serve: runs(4, 8_000, 15_904),
            ..LinkInterrupts::default()
        };
        let dma = LinkInterrupts {
            receive: runs(1, 10, 26),
            half_filled: runs(1, 20, 126),
            sent: runs(3, 300, 528),
            ..bytes
        };
        let table = ways(&Ways { bytes, dma });
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| one at a time | 100,000 | 40.0 / 40.0 | 84.0 / 80.0 | 5.00 % / 4.8 % | 100 % |",
                "| by DMA | 2,000 | 0.3 / 41.0 | 2.0 / 82.0 | 0.12 % / 4.9 % | while the queue is full |",
            ]
        );
    }
}
