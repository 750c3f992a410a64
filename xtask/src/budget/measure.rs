//! Run-time costs of a firmware, measured by `chip-budget` in the emulator.

use super::image::Image;
use super::row::{BudgetRow, EMULATED, Field};
use super::variant;
use crate::process::root;
use crate::trials;
use anyhow::{Context as _, Result, bail};
use chip_image::costs::{Late, Ways};
use firmware_image::child_process::ChildProcess;
use firmware_image::{Board, Build};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Extent of the measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(super) ticks: u32,
    traced: u32,
}

impl Extent {
    pub(crate) const FULL: Self = Self { ticks: 2_000, traced: 24 };
    pub(crate) const SHORT: Self = Self { ticks: 300, traced: 24 };
}

/// Settings for the flood. The tick period is 20,000 instructions, which is shorter than the chip needs for the bytes that are sent at once, so ticks
/// interrupt the link's work. `age_max` allows old measurements, because the host waits until the chip has read the bytes. The firmware is for the
/// bench only and reaches no drive.
const FLOOD: [(&str, &str); 3] = [("rate", "50000.0"), ("age_max", "100000"), ("safety.bench_only", "true")];

/// Processor time after which a measurement is killed.
const LONGEST: Duration = Duration::from_secs(3600);

/// Number of ticks under the flood.
const FLOOD_TICKS: u32 = 400;

/// Sizes of the linked program.
pub(crate) fn sizes(scene: &Path, board: Board) -> Result<BudgetRow> {
    let scene = root().join(scene);
    Ok(BudgetRow::sizes(&scene, board, &Image::measure(&build(&scene, board)?)?))
}

/// All numbers of a scene on the emulated board.
pub(crate) fn row(scene: &Path, extent: Extent) -> Result<BudgetRow> {
    firmware_image::install::qemu()?;
    let scene = root().join(scene);
    let elf = build(&scene, EMULATED)?;
    let mut row = BudgetRow::sizes(&scene, EMULATED, &Image::measure(&elf)?);
    let mut command = chip_budget("ticks", &scene);
    command.arg("--elf").arg(&elf).args(["--ticks", &extent.ticks.to_string(), "--traced", &extent.traced.to_string()]);
    let said: Value = serde_json::from_str(&output(&mut command)?)?;
    row.numbers.extend(numbers(&said)?);
    let [seen, bound] = [Field::StackPainted, Field::StackBound].map(|field| row.number(field).unwrap_or(0));
    if seen > bound {
        bail!("{}: a stack of {seen} bytes was seen, and {bound} are said to be enough", row.name());
    }
    Ok(row)
}

/// Traces the ticks of a program of this scene in the emulator, for any build settings.
pub(super) fn supervised_trace(scene: &Path, elf: &Path) -> Result<Value> {
    firmware_image::install::qemu()?;
    let mut command = chip_budget("ticks", &root().join(scene));
    command.arg("--elf").arg(elf).args(["--ticks", TRACED, "--traced", TRACED]);
    Ok(serde_json::from_str(&output(&mut command)?)?)
}

/// Number of ticks of [`interrupt`]; all of them are traced.
const TRACED: &str = "24";

/// Trace of a scene's supervised ticks on the emulated board, in the format of `trials::budget::report::Traced`.
pub(crate) fn interrupt(scene: &Path) -> Result<Value> {
    Ok(supervised_trace(scene, &build(&root().join(scene), EMULATED)?)?["traced"].take())
}

/// Lateness of a scene's ticks under a flood of the link.
pub(crate) fn flood(scene: &Path) -> Result<Late> {
    let variant = variant::write(scene, "flood", &FLOOD)?;
    let elf = build(&variant, EMULATED)?;
    let mut command = chip_budget("flood", &variant);
    command.arg("--elf").arg(&elf).args(["--ticks", &FLOOD_TICKS.to_string()]);
    Ok(serde_json::from_str(&output(&mut command)?)?)
}

/// Cost of the link in a scene's supervised ticks, byte by byte and by DMA. The DMA interrupts are those of `board`.
pub(crate) fn ways(scene: &Path, board: Board) -> Result<Ways> {
    firmware_image::install::qemu()?;
    let scene = root().join(scene);
    let mut command = chip_budget("ways", &scene);
    command.arg("--elf").arg(build(&scene, EMULATED)?);
    command.arg("--dma").arg(Build { dma_stand_in: true, ..Build::of(&scene, Board::Netduinoplus2) }.run()?);
    command.arg("--board").arg(build(&root().join(board.scene()), board)?).args(["--ticks", TRACED]);
    Ok(serde_json::from_str(&output(&mut command)?)?)
}

/// Converts the output of `chip-budget` to [`Field`]s.
fn numbers(said: &Value) -> Result<Vec<(Field, u64)>> {
    let number =
        |path: &str| said.pointer(path).and_then(Value::as_u64).with_context(|| format!("no {path} in {said}"));
    let (min, max) = (number("/ticks/min")?, number("/ticks/max")?);
    let (least, most) = (number("/ticks/supervised/min")?, number("/ticks/supervised/max")?);
    Ok(vec![
        (Field::Supervised, most),
        (Field::SupervisedSpread, most - least),
        (Field::SupervisedLongest, number("/ticks/supervised/granting")?),
        (Field::StackPainted, number("/ticks/stack")?),
        (Field::Instructions, max),
        (Field::InstructionsSpread, max - min),
        (Field::TickInterrupt, number("/traced/running/instructions")?),
        (Field::Masked, number("/traced/masked")?),
        (Field::ByteInterrupt, number("/traced/byte_interrupt")?),
        (Field::LinkByte, number("/traced/link_byte")?),
        (Field::CyclesEstimate, number("/traced/running/cycles/likely")?),
        (Field::CyclesLongest, number("/traced/longest/cycles/likely")?),
    ])
}

fn build(scene: &Path, board: Board) -> Result<PathBuf> {
    Build::of(scene, board).run()
}

/// Command that runs `chip-budget` for a scene.
pub(super) fn chip_budget(what: &str, scene: &Path) -> Command {
    let mut command = trials::program("chip-budget");
    command.args([what, "--scene"]).arg(scene);
    command
}

/// Standard output of a command; its standard error goes to ours.
fn output(command: &mut Command) -> Result<String> {
    let output = ChildProcess::output(command, LONGEST, false).with_context(|| format!("cannot start {command:?}"))?;
    if !output.status.success() {
        bail!("chip-budget failed: {}", output.status);
    }
    Ok(String::from_utf8(output.stdout)?)
}

#[cfg(test)]
mod tests {
    use super::{Field, numbers};
    use serde_json::json;

    #[test]
    fn what_is_said_becomes_fields_and_what_is_missing_is_named() {
        let mut said = json!({
            "ticks": { "ticks": 10, "min": 1300, "max": 1322, "stack": 700,
                "supervised": { "ticks": 10, "min": 2900, "max": 3000, "granting": 3100 } },
            "traced": { "masked": 20, "byte_interrupt": 30, "link_byte": 90,
                "running": { "instructions": 1500, "cycles": { "low": 1, "likely": 2, "high": 3 } },
                "longest": { "instructions": 1600, "cycles": { "low": 2, "likely": 3, "high": 4 } } },
        });
        let found = numbers(&said).unwrap_or_default();
        assert!(found.contains(&(Field::InstructionsSpread, 22)) && found.contains(&(Field::CyclesEstimate, 2)));
        said["traced"]["masked"] = json!("many");
        assert!(numbers(&said).is_err_and(|why| why.to_string().starts_with("no /traced/masked in")));
    }
}
