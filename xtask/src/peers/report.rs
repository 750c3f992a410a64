//! Ratios and tables of the results.

use super::chip::{Count, Cycles};
use super::contestants::{Computation, Family, GENERATORS, ORDINARY, generated};
use super::desk::{Time, best};
use super::harness::source;
use super::install::CLANG;
use crate::machine::{processor, today};
use crate::process::output;
use crate::table::Table;
use anyhow::{Context as _, Result};
use std::process::Command;

/// Name of the markers around the tables in the document.
pub(super) const PLACE: &str = "peers";

/// Measurements of an arm.
pub(super) struct PeerMeasurements {
    pub(super) arm: &'static str,
    pub(super) desk: Vec<Time>,
    pub(super) chip: Vec<Count>,
}

/// The tables of the page.
pub(super) fn markdown(measured: &[PeerMeasurements]) -> Result<String> {
    let mut ratios =
        Table::new(&["what", "arm", "ours", "our build", "the strongest peer's", "peer, its build", "ratio"]);
    let mut text = String::new();
    for arm in measured {
        compare(arm, &mut ratios)?;
        text += &tables(arm)?;
    }
    Ok(format!("{}\n\n{}{text}", machine()?, ratios.0))
}

fn traced(family: Family) -> bool {
    GENERATORS.iter().any(|(generator, ..)| *generator == family)
}

fn at_run_time(family: Family) -> bool {
    matches!(family, Family::Pinocchio | Family::Kdl | Family::Dynibo)
}

fn regrouped(family: Family) -> bool {
    family == Family::Regrouped
}

fn recursion(family: Family) -> bool {
    family == Family::Generic
}

/// Compares our numbers with those of the strongest peer of the same kind: traced code with traced code, a model at run time with a model at run
/// time, many states per call with many states per call. Each contestant is represented by its best build.
fn compare(PeerMeasurements { arm, desk, chip }: &PeerMeasurements, table: &mut Table) -> Result<()> {
    type Kind = fn(Family) -> bool;
    let time = |kind: Kind, task, build: Option<&str>| {
        let wanted =
            |time: &Time| kind(time.family) && time.task == task && build.is_none_or(|build| build == time.build);
        best(desk, wanted).with_context(|| format!("{arm}: nobody measured {task:?}"))
    };
    let rows: [(&str, Kind, Computation, Kind, Option<&str>); 7] = [
        ("traced, torques", regrouped, Computation::Inverse, traced, None),
        ("traced, torques, our build for any processor", regrouped, Computation::Inverse, traced, Some(ORDINARY)),
        ("traced, torques, sine and cosine given", regrouped, Computation::Kernel, traced, None),
        ("traced, torques, many states a call", regrouped, Computation::Many, traced, None),
        ("traced, accelerations", regrouped, Computation::Forward, traced, None),
        ("model at run time, torques", recursion, Computation::Inverse, at_run_time, None),
        ("model at run time, accelerations", recursion, Computation::Forward, at_run_time, None),
    ];
    for (what, own, task, other, build) in rows {
        let (ours, peer) = (time(own, task, build)?, time(other, task, None)?);
        let strongest = format!("{}, {}", peer.family.name(), peer.build);
        let ratio = format!("{:.2}", ours.ns / peer.ns);
        let [own, other] = [ours.ns, peer.ns].map(|ns| format!("{ns:.1}"));
        table.put(&[&format!("{what}, ns"), arm, &own, &ours.build, &other, &strongest, &ratio]);
    }
    let rows = [
        ("chip, torques", Computation::Inverse, Computation::Inverse),
        ("chip, torques, everybody with our sine and cosine", Computation::Inverse, Computation::KernelAfterOurTrig),
        ("chip, torques, sine and cosine given", Computation::Kernel, Computation::Kernel),
    ];
    for (unit, value) in [("instructions", instructions as fn(&Count) -> f64), ("cycles", cycles)] {
        let least = |kind: Kind, task| {
            least(chip, |count| kind(count.family) && count.task == task, value).context("the chip counted too few")
        };
        for (what, own, other) in rows {
            let (ours, peer) = (least(regrouped, own)?, least(traced, other)?);
            let strongest = format!("{}, {}", peer.family.name(), peer.build);
            let ratio = format!("{:.2}", value(ours) / value(peer));
            let [own, other] = [ours, peer].map(|count| format!("{:.0}", value(count)));
            table.put(&[&format!("{what}, {unit}"), arm, &own, &ours.build, &other, &strongest, &ratio]);
        }
    }
    Ok(())
}

/// All contestants on one arm.
fn tables(PeerMeasurements { arm, desk, chip }: &PeerMeasurements) -> Result<String> {
    const ON_CHIP: [Computation; 3] = [Computation::Inverse, Computation::KernelAfterOurTrig, Computation::Kernel];
    let mut times = Table::new(&[
        "",
        "torques, sine and cosine included",
        "the same, many states a call",
        "torques, sine and cosine given",
        "accelerations",
    ]);
    for family in families(desk.iter().map(|time| time.family)) {
        let cell = |task| match best(desk, |time| time.family == family && time.task == task) {
            Some(time) => format!("{:.1} ({})", time.ns, time.build),
            None => String::new(),
        };
        let [inverse, many, kernel, forward] =
            [Computation::Inverse, Computation::Many, Computation::Kernel, Computation::Forward].map(cell);
        times.put(&[&family.name(), &inverse, &many, &kernel, &forward]);
    }
    let mut counts = Table::new(&["", "sine and cosine included", "with ours", "given", "operations"]);
    let mut estimates = Table::new(&["", "sine and cosine included", "with ours", "given"]);
    for family in families(chip.iter().map(|count| count.family)) {
        let cell = |value, text: fn(&Count) -> String| {
            let of = |task| least(chip, |count| count.family == family && count.task == task, value);
            ON_CHIP.map(|task| of(task).map_or_else(String::new, text))
        };
        let operations = match GENERATORS.iter().find(|(generator, ..)| *generator == family) {
            Some((_, name, _)) => {
                let path = generated(arm, name, "kernel", "f32");
                let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
                operations(&text).to_string()
            }
            None => String::new(),
        };
        let [whole, after, given] = cell(instructions, Count::cell);
        counts.put(&[&family.name(), &whole, &after, &given, &operations]);
        let [whole, after, given] = cell(cycles, Count::cycles_cell);
        estimates.put(&[&family.name(), &whole, &after, &given]);
    }
    Ok(format!(
        "\n### {arm} on the desk\n\nns for one state in f64, each contestant's fastest build and that build.\n\n{}\
         \n### {arm} on the chip\n\nInstructions in f32, least to most over 64 states, and bytes of the function, of the build that takes fewest.\n\n{}\
         \nCycles in f32, estimated, likely and in brackets low to high: means over the states, from flash at 168 MHz with caches as another state left them, and from SRAM, of the build that is quickest from flash.\n\n{}",
        times.0, counts.0, estimates.0
    ))
}

fn instructions(count: &Count) -> f64 {
    count.instructions_mean
}

/// Likely cycles from flash.
fn cycles(count: &Count) -> f64 {
    count.flash.likely
}

/// Build with the smallest value among those for which `wanted` is true.
fn least(counts: &[Count], wanted: impl Fn(&Count) -> bool, value: fn(&Count) -> f64) -> Option<&Count> {
    counts.iter().filter(|count| wanted(count)).min_by(|a, b| value(a).total_cmp(&value(b)))
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

/// dynibo's name with its version, from the contestant's manifest.
fn dynibo() -> Option<String> {
    let text = std::fs::read_to_string(source("dynibo/Cargo.toml")).ok()?;
    let version = text.lines().find_map(|line| line.strip_prefix("dynibo = \"="))?;
    Some(format!("dynibo {}", version.trim_end_matches('"')))
}

/// Day, processor, compilers and peers.
fn machine() -> Result<String> {
    let version = |program: &str| {
        let text = output(Command::new(program).arg("--version")).with_context(|| format!("{program} is gone"))?;
        anyhow::Ok(text.lines().next().unwrap_or_default().to_owned())
    };
    let compilers = ["rustc", "gcc", "clang", "arm-none-eabi-gcc", CLANG].map(version);
    let compilers: Vec<String> = compilers.into_iter().collect::<Result<_>>()?;
    let kdl = output(Command::new("dpkg-query").args(["-W", "-f", "KDL ${Version}", "liborocos-kdl-dev"]));
    let file = source("requirements.txt");
    let packages = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let packages = packages.lines().filter(|line| line.contains("==")).map(|line| line.replace("==", " "));
    let peers: Vec<String> = packages.chain(kdl).chain(dynibo()).collect();
    let (day, processor) = (today(), processor());
    Ok(format!("{day}, {processor}, one thread. {}. Against {}.", compilers.join("; "), peers.join(", ")))
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
