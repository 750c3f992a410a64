//! `cargo xtask firmware cost`: measures the cost of a control tick on the emulated chip for each of many scenes. Prints one JSON object per line.

use crate::bench::cycles::COUNTER;
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result, bail, ensure};
use chip_image::Program;
use chip_image::cycles::{Memory, calls};
use firmware_image::build::{keep, lock};
use firmware_image::emitted::{fnv1a, written};
use robot_compiler::emit;
use serde::Serialize;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The tick's symbol in the measuring program.
const TICK: &str = "tick_0";

/// Cost of a function that only returns a fault, in instructions. The program's own count leaves it out, so the trace has this many more.
const EMPTY: RangeInclusive<u64> = 0..=16;

/// The cost of a scene's tick: a line of the output.
#[derive(Debug, Serialize)]
struct Cost {
    tick: Tick,
    /// Size of the controller in RAM, bytes.
    controller_bytes: u64,
    /// Bytes of the tick, of all functions that it calls, and of their constants.
    flash_bytes: u64,
    ticks: Vec<Ticked>,
}

/// Location of the tick.
#[derive(Debug, Serialize)]
struct Tick {
    symbol: &'static str,
    address: u32,
    /// Length of the function alone.
    bytes: u64,
    program: PathBuf,
}

/// One call of the tick.
#[derive(Debug, Serialize)]
struct Ticked {
    instructions: u64,
    /// Estimated cycles, from SRAM. The caches of what runs from flash are in the state that the ticks before left.
    cycles: u64,
    /// Command in the format of `firmware/probe/src/bin/probe-cost/main.rs`: `drive,TORQUE..,LIMITS..` or `brake,CODE,JOINT`.
    command: String,
}

/// Measures the tick of each scene of a list, one path per line, and prints each cost as soon as it is known.
pub(crate) fn print(list: &Path) -> Result<()> {
    firmware_image::install::qemu()?;
    let text = std::fs::read_to_string(list).with_context(|| format!("no list of scene files {}", list.display()))?;
    for scene in text.lines().filter(|line| !line.trim().is_empty()) {
        let cost = measure(&build(Path::new(scene))?).with_context(|| format!("the ticks of {scene}"))?;
        println!("{}", serde_json::to_string(&cost)?);
    }
    Ok(())
}

/// Builds the program that measures a scene's tick. Returns the path of a copy that later builds do not overwrite.
fn build(scene: &Path) -> Result<PathBuf> {
    let scene = scene.canonicalize().with_context(|| format!("no scene file {}", scene.display()))?;
    let toolchain = Toolchain::find_or_install()?;
    let folder = toolchain::target_directory();
    let _lock = lock(&folder)?;
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--package", "probe", "--features", "cost"]).env(
        "NEWTAU_COST",
        written("cost", |folder| emit::cost::write_program_of(std::slice::from_ref(&scene), folder))?,
    );
    let built = toolchain::build(&mut cargo, toolchain::product("probe-cost"))
        .with_context(|| format!("the program that measures {}", scene.display()))?;
    let text = std::fs::read(&built)?;
    // The name contains a hash of the contents, because an emulator or a reader may still use an earlier build of the same file.
    let copy = folder.join(format!("cost-{:08x}.elf", fnv1a(0x811c_9dc5, &text)));
    keep(&text, copy)
}

/// Runs the program, then traces it again, instruction by instruction. Every counted instruction must be in the trace.
fn measure(elf: &Path) -> Result<Cost> {
    let SceneOutput { address, controller_bytes, ticks } = SceneOutput::parse(&crate::qemu::semihosted(elf)?)?;
    let program = Program::parse(&std::fs::read(elf)?)?;
    let reached = program.reached_from(address)?;
    let mut traced = calls(elf, &program, COUNTER, &[address & !1], [Memory::of(&program)])?;
    let traced = traced.pop().unwrap_or_default();
    ensure!(traced.len() == ticks.len(), "{} ticks were traced, {} counted", traced.len(), ticks.len());
    let ticks = ticks.into_iter().zip(traced).map(|((instructions, command), [traced])| {
        let more = traced.instructions.checked_sub(instructions);
        let same = command.starts_with("brake,") || more.is_some_and(|more| EMPTY.contains(&more));
        ensure!(same, "{} instructions of a tick were traced, {instructions} counted", traced.instructions);
        Ok(Ticked { instructions, cycles: traced.cycles.likely, command })
    });
    Ok(Cost {
        tick: Tick {
            symbol: TICK,
            address: address & !1,
            bytes: program.function(address)?.bytes,
            program: elf.to_owned(),
        },
        controller_bytes,
        flash_bytes: reached.flash_bytes(),
        ticks: ticks.collect::<Result<_>>()?,
    })
}

/// The program's output for its one scene.
#[derive(Debug, PartialEq, Eq)]
struct SceneOutput {
    address: u32,
    controller_bytes: u64,
    /// Instructions and command of each tick.
    ticks: Vec<(u64, String)>,
}

impl SceneOutput {
    fn parse(text: &str) -> Result<Self> {
        let Some(head) = text.lines().find_map(|line| line.strip_prefix("scene,0,")) else {
            bail!("the measuring program does not say where its tick is");
        };
        let (address, controller_bytes) = head.split_once(',').with_context(|| head.to_owned())?;
        let ticks = text.lines().filter_map(|line| line.strip_prefix("tick,0,")).map(|line| {
            let mut fields = line.splitn(3, ',').skip(1);
            let count = fields.next().and_then(|count| count.parse().ok());
            count.zip(fields.next().map(str::to_owned)).with_context(|| format!("no count or no command: {line}"))
        });
        Ok(Self {
            address: address.parse().with_context(|| head.to_owned())?,
            controller_bytes: controller_bytes.parse().with_context(|| head.to_owned())?,
            ticks: ticks.collect::<Result<_>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::SceneOutput;

    #[test]
    fn a_scene_and_its_ticks_are_read_and_other_lines_left() {
        let text =
            "scene,1,5,6\nscene,0,134217729,200\ntick,0,0,7,drive,1,0\ntick,0,1,9,brake,3,\ntick,1,0,1,drive,1,0\n";
        let ticks = vec![(7, "drive,1,0".to_owned()), (9, "brake,3,".to_owned())];
        let said = SceneOutput::parse(text).unwrap();
        assert_eq!(said, SceneOutput { address: 0x0800_0001, controller_bytes: 200, ticks });
    }

    #[test]
    fn a_program_that_says_nonsense_is_an_error() {
        for text in [
            "",
            "tick,0,0,7,drive,1\n",
            "scene,0,x,200\n",
            "scene,0,8,2\ntick,0,0,x,drive,1\n",
            "scene,0,8,2\ntick,0,0,7\n",
        ] {
            assert!(SceneOutput::parse(text).is_err(), "{text}");
        }
    }
}
