//! Cycles on a flashed board, measured by `chip-budget` over its serial port.

use super::bounds::Budget;
use super::measure::chip_budget;
use super::row::{EMULATED, Field, stem};
use crate::process::root;
use crate::table::thousands;
use anyhow::{Context as _, Result, bail};
use firmware_image::{BadInput, Board, flash};
use robot_compiler::SceneFile;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

/// The requested measurement.
pub(super) struct Asked<'a> {
    /// The serial port of the board.
    pub(super) port: &'a str,
    /// The board's key file, if it has a key.
    pub(super) key: Option<&'a Path>,
    /// The board type that was flashed; the firmware does not report it.
    pub(super) board: Board,
    /// The flashed scene; empty means the board's example.
    pub(super) scenes: &'a [PathBuf],
    /// Number of ticks.
    pub(super) ticks: u32,
}

/// Measures and prints.
///
/// # Errors
/// [`BadInput`]: several scenes, an emulated board, drives that the board has no lines for, no such board on the port, or a counter that does not
/// count cycles. Any other failure, including a torque that differs from the desk's.
pub(super) fn run(asked: &Asked<'_>, json: bool) -> Result<()> {
    let scene = match asked.scenes {
        [] => PathBuf::from(asked.board.scene()),
        [scene] => scene.clone(),
        more => {
            let found = more.len();
            return Err(BadInput(format!(
                "--scene: found {found} scenes, expected the one that the board was flashed with"
            ))
            .into());
        }
    };
    let scene = flash::fitting(&root().join(scene), asked.board)?;
    let name = stem(&scene);
    let emulator = Emulator::of(&Budget::load()?, &name);
    eprintln!("budget: {name} on {} at {}, {} ticks", asked.board, asked.port, asked.ticks);
    let mut command = chip_budget("board", &scene);
    command.args(["--port", asked.port, "--ticks", &asked.ticks.to_string()]);
    if let Some(key) = asked.key {
        command.arg("--key").arg(std::path::absolute(key)?);
    }
    if let Some(fewest) = emulator.fewest {
        command.args(["--instructions", &fewest.to_string()]);
    }
    let output = command.stdin(Stdio::null()).output().with_context(|| format!("cannot start {command:?}"))?;
    let measured = BoardCycles { asked, scene, said: said(&output)?, emulator };
    print!("{}", if json { measured.json()? } else { measured.text()? });
    Ok(())
}

/// Ranges in `firmware/budget.toml` for the same scene on the emulated board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Emulator {
    /// Fewest instructions of the controller in any tick, with any compiler.
    fewest: Option<u64>,
    /// Most instructions of the controller in a tick.
    instructions: Option<(u64, u64)>,
    /// Estimated cycles of the whole interrupt of a supervised tick.
    interrupt: Option<(u64, u64)>,
}

impl Emulator {
    fn of(budget: &Budget, scene: &str) -> Self {
        Self {
            fewest: budget.fewest_instructions(scene, EMULATED),
            instructions: budget.range(scene, EMULATED, Field::Instructions),
            interrupt: budget.range(scene, EMULATED, Field::CyclesEstimate),
        }
    }
}

/// Output of `chip-budget`, or its error.
fn said(output: &Output) -> Result<Value> {
    if output.status.success() {
        return serde_json::from_slice(&output.stdout).context("what chip-budget prints");
    }
    let complaint = String::from_utf8_lossy(&output.stderr);
    // Warnings of the compiler may precede the error.
    let at = complaint.rfind("error: ").map_or(0, |at| at + "error: ".len());
    let why = match complaint[at..].trim() {
        "" => format!("chip-budget failed: {}", output.status),
        why => why.to_owned(),
    };
    if output.status.code() == Some(i32::from(BadInput::EXIT_CODE)) {
        return Err(BadInput(why).into());
    }
    bail!(why)
}

/// A board's cycles, and the values to compare them with.
struct BoardCycles<'a> {
    asked: &'a Asked<'a>,
    scene: PathBuf,
    said: Value,
    emulator: Emulator,
}

impl BoardCycles<'_> {
    fn number(&self, path: &str) -> Result<f64> {
        self.said.pointer(path).and_then(Value::as_f64).with_context(|| format!("no {path} in {}", self.said))
    }

    /// Share of a period, at the scene's rate, for a number of cycles.
    fn share(&self, cycles: f64) -> Result<f64> {
        Ok(cycles * self.number("/rate_hz")? / self.clock_hz())
    }

    fn clock_hz(&self) -> f64 {
        self.asked.board.chip().clock_hz()
    }

    fn json(&self) -> Result<String> {
        let range = |range: Option<(u64, u64)>| range.map(|(min, max)| json!({ "min": min, "max": max }));
        let [most, mean] = ["/cycles_per_tick/max", "/cycles_per_tick/mean"].map(|path| self.number(path));
        let all = json!({
            "robot": stem(&SceneFile::load(&self.scene)?.robot.path),
            "scene": stem(&self.scene),
            "board": self.asked.board.name(),
            "port": self.asked.port,
            "hash": self.said["hash"],
            "rate_hz": self.said["rate_hz"],
            "clock_hz": self.clock_hz(),
            "ticks": self.said["ticks"],
            "bits_differ": self.said["bits_differ"],
            "cycles_per_tick": self.said["cycles_per_tick"],
            "share_of_period": { "max": self.share(most?)?, "mean": self.share(mean?)? },
            "emulator": {
                "instructions_per_tick": range(self.emulator.instructions),
                "interrupt_cycles_estimate": range(self.emulator.interrupt),
            },
        });
        Ok(serde_json::to_string_pretty(&all)? + "\n")
    }

    fn text(&self) -> Result<String> {
        let [min, max, mean] = ["min", "max", "mean"].map(|key| self.number(&format!("/cycles_per_tick/{key}")));
        let (min, max, mean) = (min?, max?, mean?);
        let (rate, ticks) = (self.number("/rate_hz")?, self.number("/ticks")?);
        let whole = |number: f64| thousands(number.round() as u64);
        let mut text = format!(
            "{} on {}: {} ticks in lock step, no drive driven\n\
             cycles of the controller   fewest {}, most {}, mean {mean:.1}\n\
             share of a period          {:.2} % of {} cycles at {} Hz, by the most\n\
             torques                    the desk's to the last bit, in every tick\n",
            stem(&self.scene),
            self.asked.board,
            whole(ticks),
            whole(min),
            whole(max),
            100.0 * self.share(max)?,
            whole(self.clock_hz() / rate),
            whole(rate),
        );
        let mut beside = |range: Option<(u64, u64)>, what: &str| {
            if let Some((low, high)) = range {
                // Writing to a String cannot fail.
                let _ = writeln!(text, "emulator                   {} to {} {what}", thousands(low), thousands(high));
            }
        };
        beside(self.emulator.instructions, "instructions of the controller, counted");
        beside(
            self.emulator.interrupt,
            "cycles of the whole interrupt under supervision, estimated: more than is counted here",
        );
        if self.emulator == Emulator::default() {
            text += "emulator                   firmware/budget.toml has no row of this scene\n";
        }
        Ok(text)
    }
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{Asked, BadInput, BoardCycles, Budget, Emulator, said};
    use firmware_image::Board;
    use serde_json::{Value, json};
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::{ExitStatus, Output};

    const ASKED: Asked<'_> =
        Asked { port: "/dev/ttyACM0", key: None, board: Board::F405Can, scenes: &[], ticks: 10_000 };

    fn measured(emulator: Emulator) -> BoardCycles<'static> {
        let said = json!({ "hash": "25bb0af18768f6a5", "rate_hz": 4_000.0, "ticks": 10_000, "bits_differ": 0,
            "cycles_per_tick": { "min": 2_790, "max": 2_831, "mean": 2_805.25 } });
        let scene = crate::process::root().join("scenes/puma560_pick.toml");
        BoardCycles { asked: &ASKED, scene, said, emulator }
    }

    fn emulator() -> Emulator {
        Emulator { fewest: Some(1_229), instructions: Some((1_337, 1_393)), interrupt: Some((7_547, 7_857)) }
    }

    #[test]
    fn cycles_stand_beside_the_emulators_numbers_and_each_says_what_it_is() {
        let expected = "puma560_pick on f405-can: 10,000 ticks in lock step, no drive driven\n\
            cycles of the controller   fewest 2,790, most 2,831, mean 2805.2\n\
            share of a period          6.74 % of 42,000 cycles at 4,000 Hz, by the most\n\
            torques                    the desk's to the last bit, in every tick\n\
            emulator                   1,337 to 1,393 instructions of the controller, counted\n\
            emulator                   7,547 to 7,857 cycles of the whole interrupt under supervision, estimated: more than is counted here\n";
        assert_eq!(measured(emulator()).text().unwrap(), expected);
        let alone = measured(Emulator::default()).text().unwrap();
        assert!(alone.ends_with("has no row of this scene\n") && !alone.contains("estimated"), "{alone}");
    }

    #[test]
    fn json_has_the_keys_that_other_programs_read() {
        let all: Value = serde_json::from_str(&measured(emulator()).json().unwrap()).unwrap();
        let names = ["robot", "scene", "board", "hash"].map(|key| all[key].as_str().unwrap());
        assert_eq!(names, ["puma560", "puma560_pick", "f405-can", "25bb0af18768f6a5"]);
        assert_eq!(all["cycles_per_tick"], json!({ "min": 2_790, "max": 2_831, "mean": 2_805.25 }));
        assert_eq!((all["ticks"].as_u64(), all["bits_differ"].as_u64()), (Some(10_000), Some(0)));
        assert!((all["share_of_period"]["max"].as_f64().unwrap() - 2_831.0 / 42_000.0).abs() < 1e-12, "{all}");
        assert_eq!(all["emulator"]["interrupt_cycles_estimate"], json!({ "min": 7_547, "max": 7_857 }));
        let alone: Value = serde_json::from_str(&measured(Emulator::default()).json().unwrap()).unwrap();
        assert!(alone["emulator"]["instructions_per_tick"].is_null(), "{alone}");
    }

    #[test]
    fn a_key_that_is_missing_is_named() {
        let mut broken = measured(emulator());
        broken.said = json!({ "ticks": 3 });
        for why in [broken.text().unwrap_err(), broken.json().unwrap_err()] {
            assert!(why.to_string().starts_with("no /cycles_per_tick/m"), "{why}");
        }
    }

    #[test]
    fn what_chip_budget_complains_of_keeps_its_words_and_its_code() {
        let ended = |code: i32, out: &str, error: &str| {
            said(&Output { status: ExitStatus::from_raw(code << 8), stdout: out.into(), stderr: error.into() })
        };
        assert_eq!(ended(0, "{\"ticks\": 3}", "").unwrap(), json!({ "ticks": 3 }));
        for (code, complaint, told, bad_input) in [
            (2, "warning: unused\nerror: does not answer\nis it powered?\n", "does not answer\nis it powered?", true),
            (1, "error: serial port: the other end is gone\n", "serial port: the other end is gone", false),
            (101, "could not compile\n", "could not compile", false),
            (2, "", "chip-budget failed: exit status: 2", true),
        ] {
            let why = ended(code, "", complaint).unwrap_err();
            assert_eq!((why.to_string().as_str(), why.is::<BadInput>()), (told, bad_input), "{complaint}");
        }
        assert!(ended(0, "nonsense", "").is_err());
    }

    #[test]
    fn the_emulators_row_is_of_the_same_scene_and_its_fewest_is_below_its_most() {
        let budget = Budget::load().unwrap();
        let found = Emulator::of(&budget, "puma560_pick");
        let (fewest, (low, _)) = (found.fewest.unwrap(), found.instructions.unwrap());
        assert!(fewest < low && fewest > low / 2, "{found:?}");
        assert!(found.interrupt.unwrap().0 > low, "{found:?}");
        assert_eq!(Emulator::of(&budget, "no_such_scene"), Emulator::default());
    }
}
