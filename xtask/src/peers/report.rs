//! Results: ratios, tables for people, JSON for programs.

use super::arm::Measured;
use super::chip::{Count, Cycles};
use super::contestants::{Family, GENERATORS, ORDINARY, Task, generated};
use super::desk::{Time, best};
use super::harness::source;
use super::install::CLANG;
use crate::process::output;
use anyhow::{Context as _, Result};
use serde::Serialize;
use std::path::Path;
use std::process::Command;

/// Name of the markers around the tables in the document.
pub(super) const PLACE: &str = "peers";

/// A number of ours and that of the strongest peer of the same kind: traced code against traced code, a model at run time against a model
/// at run time, many states a call against many states a call.
#[derive(Serialize)]
struct Ratio {
    arm: &'static str,
    what: &'static str,
    unit: &'static str,
    ours: f64,
    /// Our fastest build; every contestant is measured at its best.
    our_build: String,
    peer: f64,
    /// The strongest peer, and its build.
    strongest: String,
    ratio: f64,
}

/// All results, in the form of the JSON.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    machine: Machine,
    ratios: Vec<Ratio>,
    arms: Vec<Arm<'a>>,
}

#[derive(Serialize)]
struct Machine {
    date: String,
    processor: String,
    compilers: Vec<String>,
    peers: Vec<String>,
}

#[derive(Serialize)]
struct Arm<'a> {
    arm: &'static str,
    desk: &'a [Time],
    chip: &'a [Count],
    /// Multiplications, additions and subtractions in the generated C with given sine and cosine.
    operations: Vec<(Family, usize)>,
}

impl<'a> Report<'a> {
    /// Finds the strongest peer of every row, and the ratios.
    pub(super) fn new(measured: &'a [Measured]) -> Result<Self> {
        let mut ratios = Vec::new();
        let mut arms = Vec::new();
        for Measured { arm, desk, chip } in measured {
            ratios.extend(ratios_of(arm, desk, chip)?);
            let operations = GENERATORS.into_iter().map(|(family, name, _)| {
                let path = generated(arm, name, "kernel", "f32");
                let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
                Ok((family, operations(&text)))
            });
            arms.push(Arm { arm, desk, chip, operations: operations.collect::<Result<_>>()? });
        }
        Ok(Self { machine: Machine::this()?, ratios, arms })
    }

    /// Prints the tables on the terminal.
    pub(super) fn print(&self) {
        println!("{}", self.markdown());
    }

    /// Writes to a file, or to the terminal for `-`.
    pub(super) fn write_json(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        if path == Path::new("-") {
            print!("{text}");
            return Ok(());
        }
        std::fs::write(path, text).with_context(|| path.display().to_string())
    }

    pub(super) fn markdown(&self) -> String {
        let Machine { date, processor, compilers, peers } = &self.machine;
        let mut text =
            format!("{date}, {processor}, one thread. {}. Against {}.\n\n", compilers.join("; "), peers.join(", "));
        text += "| what | arm | ours | our build | the strongest peer's | peer, its build | ratio |\n|---|---|---|---|---|---|---|\n";
        for row in &self.ratios {
            let Ratio { what, arm, unit, ours, our_build, peer, strongest, ratio } = row;
            let digits = usize::from(*unit == "ns");
            text += &format!(
                "| {what}, {unit} | {arm} | {ours:.digits$} | {our_build} | {peer:.digits$} | {strongest} | {ratio:.2} |\n"
            );
        }
        for arm in &self.arms {
            text += &format!("\n### {} on the desk\n\n", arm.arm);
            text += "ns for one state in f64, each contestant's fastest build and that build.\n\n";
            text += "| | torques, sine and cosine included | the same, many states a call | torques, sine and cosine given | accelerations |\n";
            text += "|---|---|---|---|---|\n";
            for family in families(arm.desk.iter().map(|time| time.family)) {
                let cell = |task| match best(arm.desk, |time| time.family == family && time.task == task) {
                    Some(time) => format!("{:.1} ({})", time.ns, time.build),
                    None => String::new(),
                };
                let cells = [Task::Inverse, Task::Many, Task::Kernel, Task::Forward].map(cell);
                text += &format!("| {} | {} |\n", family.name(), cells.join(" | "));
            }
            text += &format!("\n### {} on the chip\n\n", arm.arm);
            text += "Instructions in f32, least to most over 64 states, and bytes of the function, of the build that takes fewest.\n\n";
            text += "| | sine and cosine included | with ours | given | operations |\n|---|---|---|---|---|\n";
            for family in families(arm.chip.iter().map(|count| count.family)) {
                let cell = |task| fewest(arm.chip, family, task).map_or_else(String::new, Count::cell);
                let cells = [Task::Inverse, Task::KernelAfterOurTrig, Task::Kernel].map(cell);
                let operations = arm.operations.iter().find(|(of, _)| *of == family);
                let operations = operations.map_or_else(String::new, |(_, count)| count.to_string());
                text += &format!("| {} | {} | {operations} |\n", family.name(), cells.join(" | "));
            }
            text += "\nCycles in f32, estimated, likely and in brackets low to high: means over the states, from flash at 168 MHz with caches as another state left them, and from SRAM, of the build that is quickest from flash.\n\n";
            text += "| | sine and cosine included | with ours | given |\n|---|---|---|---|\n";
            for family in families(arm.chip.iter().map(|count| count.family)) {
                let cell = |task| quickest(arm.chip, family, task).map_or_else(String::new, Count::cycles_cell);
                let cells = [Task::Inverse, Task::KernelAfterOurTrig, Task::Kernel].map(cell);
                text += &format!("| {} | {} |\n", family.name(), cells.join(" | "));
            }
        }
        text
    }
}

impl Count {
    fn cell(&self) -> String {
        let Self { instructions_min: min, instructions_max: max, code_bytes, build, .. } = self;
        let range = if min == max { max.to_string() } else { format!("{min} to {max}") };
        format!("{range}, {code_bytes} bytes ({build})")
    }

    fn cycles_cell(&self) -> String {
        let range = |Cycles { low, likely, high }: Cycles| format!("{likely:.0} ({low:.0} to {high:.0})");
        format!("{} from flash, {} from SRAM ({})", range(self.flash), range(self.sram), self.build)
    }
}

/// All ratios of an arm.
fn ratios_of(arm: &'static str, desk: &[Time], chip: &[Count]) -> Result<Vec<Ratio>> {
    let of_generator = |family| GENERATORS.iter().any(|(generator, ..)| *generator == family);
    let ours = |family, task| {
        best(desk, |time| time.family == family && time.task == task)
            .with_context(|| format!("{arm}: nobody measured {family:?}, {task:?}"))
    };
    let for_any_processor =
        best(desk, |time| time.family == Family::Regrouped && time.task == Task::Inverse && time.build == ORDINARY)
            .with_context(|| format!("{arm}: nobody measured the regrouped kernel of an ordinary build"))?;
    let generated =
        |task| best(desk, |time| of_generator(time.family) && time.task == task).context("no generated C was measured");
    let at_run_time = |task| {
        let peer = |family| matches!(family, Family::Pinocchio | Family::Kdl | Family::Dynibo);
        best(desk, |time| peer(time.family) && time.task == task).context("no peer with its model at run time")
    };
    let counted = |task| fewest(chip, Family::Regrouped, task).context("the chip counted too few");
    let on_chip = |task| {
        let found = GENERATORS.iter().filter_map(|(family, ..)| fewest(chip, *family, task));
        found.min_by(|a, b| a.instructions_mean.total_cmp(&b.instructions_mean)).context("no generated C on the chip")
    };
    let quick = |task| quickest(chip, Family::Regrouped, task).context("the chip counted too few");
    let quickest_on_chip = |task| {
        let found = GENERATORS.iter().filter_map(|(family, ..)| quickest(chip, *family, task));
        found.min_by(|a, b| a.flash.likely.total_cmp(&b.flash.likely)).context("no generated C on the chip")
    };
    let desk_row = |what, ours: &Time, peer: &Time| {
        row(arm, what, "ns", [ours.ns, peer.ns], [ours.build.to_owned(), strongest(peer.family, peer.build)])
    };
    let chip_row = |what, ours: &Count, peer: &Count| {
        let means = [ours.instructions_mean, peer.instructions_mean];
        row(arm, what, "instructions", means, [ours.build.clone(), strongest(peer.family, &peer.build)])
    };
    let cycle_row = |what, ours: &Count, peer: &Count| {
        let means = [ours.flash.likely, peer.flash.likely];
        row(arm, what, "cycles", means, [ours.build.clone(), strongest(peer.family, &peer.build)])
    };
    let (kernel, whole) = (ours(Family::Regrouped, Task::Inverse)?, generated(Task::Inverse)?);
    Ok(vec![
        desk_row("traced, torques", kernel, whole),
        desk_row("traced, torques, our build for any processor", for_any_processor, whole),
        desk_row(
            "traced, torques, sine and cosine given",
            ours(Family::Regrouped, Task::Kernel)?,
            generated(Task::Kernel)?,
        ),
        desk_row("traced, torques, many states a call", ours(Family::Regrouped, Task::Many)?, generated(Task::Many)?),
        desk_row("traced, accelerations", ours(Family::Regrouped, Task::Forward)?, generated(Task::Forward)?),
        desk_row("model at run time, torques", ours(Family::Generic, Task::Inverse)?, at_run_time(Task::Inverse)?),
        desk_row(
            "model at run time, accelerations",
            ours(Family::Generic, Task::Forward)?,
            at_run_time(Task::Forward)?,
        ),
        chip_row("chip, torques", counted(Task::Inverse)?, on_chip(Task::Inverse)?),
        chip_row(
            "chip, torques, everybody with our sine and cosine",
            counted(Task::Inverse)?,
            on_chip(Task::KernelAfterOurTrig)?,
        ),
        chip_row("chip, torques, sine and cosine given", counted(Task::Kernel)?, on_chip(Task::Kernel)?),
        cycle_row("chip, torques", quick(Task::Inverse)?, quickest_on_chip(Task::Inverse)?),
        cycle_row(
            "chip, torques, everybody with our sine and cosine",
            quick(Task::Inverse)?,
            quickest_on_chip(Task::KernelAfterOurTrig)?,
        ),
        cycle_row("chip, torques, sine and cosine given", quick(Task::Kernel)?, quickest_on_chip(Task::Kernel)?),
    ])
}

fn strongest(family: Family, build: &str) -> String {
    format!("{}, {build}", family.name())
}

fn row(
    arm: &'static str,
    what: &'static str,
    unit: &'static str,
    [ours, peer]: [f64; 2],
    [our_build, strongest]: [String; 2],
) -> Ratio {
    Ratio { arm, what, unit, ours, our_build, peer, strongest, ratio: ours / peer }
}

/// The build of a contestant with the fewest instructions.
fn fewest(counts: &[Count], family: Family, task: Task) -> Option<&Count> {
    let found = counts.iter().filter(|count| count.family == family && count.task == task);
    found.min_by(|a, b| a.instructions_mean.total_cmp(&b.instructions_mean))
}

/// The build of a contestant with the fewest cycles from flash.
fn quickest(counts: &[Count], family: Family, task: Task) -> Option<&Count> {
    let found = counts.iter().filter(|count| count.family == family && count.task == task);
    found.min_by(|a, b| a.flash.likely.total_cmp(&b.flash.likely))
}

/// Each family once, in the order of the enum.
fn families(all: impl Iterator<Item = Family>) -> Vec<Family> {
    let mut families: Vec<Family> = all.collect();
    families.sort();
    families.dedup();
    families
}

/// Multiplications, additions and subtractions in generated C: the operators between two operands on the right of an
/// assignment.
fn operations(text: &str) -> usize {
    text.lines().filter_map(|line| line.split_once('=')).map(|(_, right)| operators(right.as_bytes())).sum()
}

fn operators(right: &[u8]) -> usize {
    let binary = |at: usize| {
        let mut before = right[..at].iter().rev().skip_while(|byte| byte.is_ascii_whitespace());
        let (last, last_but_one) = (before.next(), before.next());
        let exponent =
            matches!(last, Some(b'e')) && last_but_one.is_some_and(|byte| matches!(byte, b'0'..=b'9' | b'.'));
        let operand = last.is_some_and(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b')' | b']' | b'.'));
        operand && !exponent
    };
    (0..right.len()).filter(|&at| matches!(right[at], b'*' | b'+' | b'-') && binary(at)).count()
}

/// dynibo with its version, as its contestant demands it.
fn dynibo() -> Option<String> {
    let text = std::fs::read_to_string(source("dynibo/Cargo.toml")).ok()?;
    let version = text.lines().find_map(|line| line.strip_prefix("dynibo = \"="))?;
    Some(format!("dynibo {}", version.trim_end_matches('"')))
}

impl Machine {
    fn this() -> Result<Self> {
        let version = |program: &str| {
            let text = output(Command::new(program).arg("--version")).with_context(|| format!("{program} is gone"))?;
            Ok(text.lines().next().unwrap_or_default().to_owned())
        };
        let date = output(Command::new("date").args(["-u", "+%F"])).context("no date")?;
        let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = information.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
        let compilers =
            ["rustc", "gcc", "clang", "arm-none-eabi-gcc", CLANG].map(version).into_iter().collect::<Result<_>>()?;
        let kdl = output(Command::new("dpkg-query").args(["-W", "-f", "KDL ${Version}", "liborocos-kdl-dev"]));
        let file = source("requirements.txt");
        let packages = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let packages = packages.lines().filter(|line| line.contains("==")).map(|line| line.replace("==", " "));
        Ok(Self {
            date,
            processor: name.map_or_else(|| "unknown processor".to_owned(), |(_, name)| name.to_owned()),
            compilers,
            peers: packages.chain(kdl).chain(dynibo()).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::operations;

    #[test]
    fn operators_are_counted_and_signs_and_exponents_are_not() {
        let text = "float const *const *in\na0=(1.5e-03*a1);\ny[0] = -v[3] * 2. - 1e+2 + f(-x);\n";
        assert_eq!(operations(text), 4);
    }
}
