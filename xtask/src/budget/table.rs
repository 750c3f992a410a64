//! The table of `docs/measured/budget.md`, its rows in the README, and JSON.

use super::measure::Late;
use super::row::{Field, Row};
use crate::bench::{Table, thousands};
use anyhow::Result;
use serde_json::{Value, json};

/// Cycles of the core in a period of 4 kHz.
const PERIOD_4_KHZ: u64 = 168_000_000 / 4_000;

/// A line for each firmware.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        "scene",
        "board",
        "instructions of the controller",
        "supervised tick",
        "flash",
        "RAM",
        "stack: seen / bound",
        "masked",
        "per link byte",
        "cycles of the tick's interrupt, estimated: kernel in flash / SRAM",
        "share of 168 MHz at 4 kHz, estimated",
    ]);
    for row in rows {
        let cell = |field| row.number(field).map_or_else(|| "-".into(), thousands);
        table.row(&[
            format!("`{}`", row.scene),
            row.board.clone(),
            between(row, Field::Instructions, Field::InstructionsSpread),
            between(row, Field::Supervised, Field::SupervisedSpread),
            cell(Field::Flash),
            cell(Field::Ram),
            format!("{} / {}", cell(Field::StackPainted), cell(Field::StackBound)),
            cell(Field::Masked),
            cell(Field::LinkByte),
            format!("{} / {}", cell(Field::CyclesEstimate), cell(Field::CyclesEstimateSram)),
            row.number(Field::CyclesEstimate).map_or_else(|| "-".into(), share),
        ]);
    }
    table.0
}

/// Scenes in the README: the smallest arm, six joints, and six joints with collision detection.
const SHOWN: [&str; 3] = ["planar2r_sine", "puma560_pick", "puma560_collision"];

/// Three rows of the emulated board, for the README.
pub(crate) fn teaser(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        "scene",
        "instructions of the controller",
        "supervised tick",
        "flash",
        "RAM",
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

/// One number, or two if the least and the most differ.
fn between(row: &Row, most: Field, spread: Field) -> String {
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

/// All numbers as JSON, for other programs.
pub(crate) fn json(rows: &[Row], late: Option<&Late>) -> Result<String> {
    let rows: Vec<Value> = rows.iter().map(of_row).collect();
    Ok(serde_json::to_string_pretty(&json!({ "rows": rows, "tick_start": late }))?)
}

fn of_row(row: &Row) -> Value {
    let said = |path: &str| row.emulated.as_ref().and_then(|all| all.pointer(path)).cloned();
    let range = |path| said(path).map(|ticks| json!({ "min": ticks["min"], "max": ticks["max"] }));
    let (ticks, supervised) = (range("/ticks"), range("/ticks/supervised"));
    let cycles = said("/traced/cycles_estimate")
        .map(|flash| json!({ "kernel_in_flash": flash, "kernel_in_sram": said("/kernel_in_sram/cycles_estimate") }));
    json!({
        "robot": row.robot,
        "scene": row.scene,
        "board": row.board,
        "instructions_per_tick": ticks,
        "supervised_instructions_per_tick": supervised,
        "flash": row.number(Field::Flash),
        "ram": row.number(Field::Ram),
        "stack": { "painted": row.number(Field::StackPainted), "bound": row.number(Field::StackBound) },
        "masked_instructions": row.number(Field::Masked),
        "byte_interrupt_instructions": row.number(Field::ByteInterrupt),
        "instructions_per_link_byte": row.number(Field::LinkByte),
        "cycles_estimate": cycles,
    })
}

#[cfg(test)]
mod tests {
    use super::{json, markdown, teaser};
    use crate::budget::row::{Field, Row};
    use serde_json::{Value, json as value};

    fn row() -> Row {
        Row {
            robot: "puma560".into(),
            scene: "puma560_pick".into(),
            board: "netduinoplus2".into(),
            numbers: [
                (Field::Flash, 36_716),
                (Field::Instructions, 1322),
                (Field::InstructionsSpread, 0),
                (Field::CyclesEstimate, 4200),
            ]
            .into(),
            emulated: Some(value!({ "ticks": { "ticks": 9, "min": 1322, "max": 1322 },
                "traced": { "cycles_estimate": { "low": 4000, "likely": 4200, "high": 4500 } } })),
        }
    }

    #[test]
    fn a_row_shows_one_number_where_all_ticks_are_alike_and_a_dash_where_nothing_was_measured() {
        let table = markdown(&[
            row(),
            Row { numbers: [(Field::Instructions, 1340), (Field::InstructionsSpread, 752)].into(), ..row() },
        ]);
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(
            lines[0],
            "| `puma560_pick` | netduinoplus2 | 1,322 | - | 36,716 | - | - / - | - | - | 4,200 / - | 10.0 % |"
        );
        assert!(lines[1].contains("| 588 to 1,340 | - | - |"), "{}", lines[1]);
    }

    #[test]
    fn the_readme_shows_three_scenes_of_the_emulated_board_alone() {
        let sizes_only = Row { numbers: [(Field::Flash, 52_520)].into(), ..row() };
        let other = Row { scene: "ur5_wave".into(), ..row() };
        let table = teaser(&[other, row(), sizes_only]);
        assert_eq!(table.lines().skip(2).collect::<Vec<_>>(), ["| `puma560_pick` | 1,322 | - | 36,716 | - | 10.0 % |"]);
    }

    #[test]
    fn json_has_the_keys_that_other_programs_read() {
        let all: Value =
            json(&[row()], None).ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        let row = &all["rows"][0];
        assert_eq!((row["instructions_per_tick"]["min"].as_u64(), row["flash"].as_u64()), (Some(1322), Some(36_716)));
        assert_eq!(row["cycles_estimate"]["kernel_in_flash"]["likely"], 4200);
        assert!(row["ram"].is_null() && row["robot"] == "puma560" && row["stack"].is_object());
    }
}
