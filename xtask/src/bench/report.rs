//! Tables of `docs/measured/kernels.md`. They go between markers; the text around them is written by hand.

use super::baseline;
use super::chip::{CountRow, Counted};
use super::desk::Times;
use crate::machine::{cores, processor, today};
use crate::measured::write_into;
use crate::process::output;
use crate::table::{Table, thousands};
use anyhow::{Context as _, Result};
use std::collections::BTreeMap;
use std::process::Command;

/// Counted values, which are the same in every run.
pub(crate) struct Counts {
    /// Counts of the emulated chip.
    pub(crate) chip: Counted,
    /// Counts of callgrind, for all states together.
    pub(crate) desk: baseline::BaselineCounts,
    /// The desk's compiler.
    pub(crate) rustc: String,
}

/// Measured times, which vary between runs.
pub(crate) struct Clock {
    /// Times per state, ns: of the default build, and of the build for this processor.
    pub(crate) times: [Times; 2],
    /// Run times of the kernel compiler, ms by level.
    pub(crate) compile: BTreeMap<String, f64>,
}

/// Number of states in callgrind's counts (`bench/benches/counts.rs`).
const COUNTED_STATES: u64 = 64;

pub(super) const ARMS: [(&str, &str); 3] = [("ur5", "UR5"), ("puma560", "Puma 560"), ("stanford", "Stanford")];
pub(super) const LEVELS: [&str; 2] = ["exact", "regrouped"];

/// Puts tables into `docs/measured/kernels.md`, each between the markers of its name.
pub(crate) fn write(tables: &[(&str, String)]) -> Result<()> {
    write_into("docs/measured/kernels.md", tables)
}

/// One number, or two if least and most differ.
fn instructions(row: &CountRow) -> String {
    if row.least == row.most {
        thousands(row.most)
    } else {
        format!("{} to {}", thousands(row.least), thousands(row.most))
    }
}

fn difference(more: u64, less: u64) -> String {
    (i128::from(more) - i128::from(less)).to_string()
}

impl Counts {
    /// The tables, each with the name of its markers.
    pub(crate) fn tables(&self) -> Result<Vec<(&'static str, String)>> {
        Ok(vec![
            ("machine", self.machine()),
            ("chip", self.chip_table()?),
            ("spills", self.spill_table()?),
            ("terms", self.term_table()?),
            ("gravity", self.gravity_table()?),
            ("callgrind", self.count_table()),
        ])
    }

    fn machine(&self) -> String {
        let says = |program: &str| output(Command::new(program).arg("--version")).unwrap_or_default();
        let first = |text: String| text.lines().next().unwrap_or("unknown").to_owned();
        let mut table = Table::new(&["what", "which"]);
        table.put(&[&"date", &today()]);
        table.put(&[&"processor", &format!("{}, {} cores", processor(), cores())]);
        table.put(&[&"desk's compiler", &self.rustc]);
        table.put(&[&"chip's compiler", &self.chip.rustc]);
        table.put(&[&"emulator", &first(says("qemu-system-arm"))]);
        table.put(&[&"callgrind", &first(says("valgrind"))]);
        table.0
    }

    fn chip_table(&self) -> Result<String> {
        let mut table = Table::new(&["arm", "what", "operations", "instructions", "with sine and cosine", "bytes"]);
        let row = |name: String| self.chip.row(&name);
        for (arm, label) in ARMS {
            let with_trig = instructions(row(format!("{arm}_generic_with_trig"))?);
            let alone = instructions(row(format!("{arm}_generic"))?);
            table.put(&[&label, &"recursion", &"-", &alone, &with_trig, &"-"]);
            for level in LEVELS {
                let with_trig = instructions(row(format!("{arm}_{level}_with_trig"))?);
                let alone = row(format!("{arm}_{level}"))?;
                let bytes = thousands(alone.code.bytes);
                table.put(&[&label, &level, &alone.operations, &instructions(alone), &with_trig, &bytes]);
            }
            let matrix = row(format!("{arm}_mass_matrix_regrouped"))?;
            let (count, bytes) = (instructions(matrix), thousands(matrix.code.bytes));
            table.put(&[&label, &"mass matrix, regrouped", &matrix.operations, &count, &"-", &bytes]);
        }
        for (name, label) in
            [("trig_polynomial", "six sines and cosines, our own"), ("trig_libm", "six sines and cosines, libm's")]
        {
            table.put(&[&"any", &label, &"-", &"-", &instructions(self.chip.row(name)?), &"-"]);
        }
        Ok(table.0)
    }

    fn spill_table(&self) -> Result<String> {
        let mut table = Table::new(&[
            "arm",
            "level",
            "values alive at most",
            "stores to the stack",
            "loads from it",
            "instructions",
            "bytes",
        ]);
        for (arm, label) in ARMS {
            for level in LEVELS {
                let (ours, traced) =
                    (self.chip.row(&format!("{arm}_{level}"))?, self.chip.row(&format!("{arm}_{level}_as_traced"))?);
                let both =
                    |of: &dyn Fn(&CountRow) -> u64| format!("{} / {}", thousands(of(traced)), thousands(of(ours)));
                let [alive, most] = [both(&|row| row.alive), both(&|row| row.most)];
                let (stores, loads) = (both(&|row| row.code.stores as u64), both(&|row| row.code.loads as u64));
                table.put(&[&label, &level, &alive, &stores, &loads, &most, &both(&|row| row.code.bytes)]);
            }
        }
        Ok(table.0)
    }

    fn term_table(&self) -> Result<String> {
        let mut table = Table::new(&["term", "UR5", "Puma 560", "Stanford"]);
        let terms = [
            ("all", "everything"),
            ("gravity", "gravity"),
            ("payload", "payload, constant"),
            ("tip_wrench", "wrench at the tip, live"),
            ("rotors", "rotors, constant"),
            ("velocity", "velocity terms"),
        ];
        for (term, label) in terms {
            let mut cells = vec![label.to_owned()];
            for (arm, _) in ARMS {
                let (all, without) =
                    (self.chip.row(&format!("{arm}_terms_all"))?, self.chip.row(&format!("{arm}_terms_{term}"))?);
                cells.push(if term == "all" {
                    format!("{} / {} / {}", all.operations, thousands(all.most), thousands(all.code.bytes))
                } else {
                    let pairs = [
                        (all.operations, without.operations),
                        (all.most, without.most),
                        (all.code.bytes, without.code.bytes),
                    ];
                    pairs.map(|(more, less)| difference(more, less)).join(" / ")
                });
            }
            table.row(&cells);
        }
        Ok(table.0)
    }

    fn gravity_table(&self) -> Result<String> {
        let mut table = Table::new(&["arm", "gravity alone", "operations", "instructions", "bytes"]);
        let mut row = |label: &str, what: &str, row: &CountRow| {
            table.put(&[&label, &what, &row.operations, &instructions(row), &thousands(row.code.bytes)]);
        };
        for (arm, label) in ARMS {
            for level in LEVELS {
                row(label, level, self.chip.row(&format!("{arm}_gravity_{level}"))?);
            }
            if arm == "puma560" {
                row(label, "by hand", self.chip.row("puma560_gravity_by_hand")?);
            }
        }
        Ok(table.0)
    }

    fn count_table(&self) -> String {
        let mut table = Table::new(&["what", "instructions a state"]);
        for (name, count) in &self.desk {
            table.row(&[format!("`{name}`"), thousands((count + COUNTED_STATES / 2) / COUNTED_STATES)]);
        }
        table.0
    }
}

impl Clock {
    /// The tables, each with the name of its markers.
    pub(crate) fn tables(&self) -> Result<Vec<(&'static str, String)>> {
        Ok(vec![("desk", self.time_table()?), ("compiler", self.compile_table())])
    }

    fn time_table(&self) -> Result<String> {
        let mut table = Table::new(&["what", "UR5", "Puma 560", "Stanford"]);
        let time = |name: &str| -> Result<String> {
            let [default, native] = &self.times;
            let of = |times: &Times| times.get(name).copied().with_context(|| format!("{name} was not measured"));
            Ok(format!("{:.0} / {:.0}", of(default)?, of(native)?))
        };
        let mut of_arms = |label: String, kind: &str| -> Result<()> {
            let [ur5, puma560, stanford] = ARMS.map(|(arm, _)| time(&format!("{arm}_{kind}")));
            table.put(&[&label, &ur5?, &puma560?, &stanford?]);
            Ok(())
        };
        for scalar in ["f64", "f32"] {
            for (kind, label) in [("generic", "recursion"), ("exact", "exact"), ("regrouped", "regrouped")] {
                for (trig, with) in
                    [("", ""), ("_with_trig", ", with our sine and cosine"), ("_with_libm", ", with libm's")]
                {
                    of_arms(format!("{label}, {scalar}{with}"), &format!("{kind}_{scalar}{trig}"))?;
                }
            }
        }
        for scalar in ["f64", "f32"] {
            let label = format!("regrouped, {scalar}, with our sine and cosine, a state of a batch of 1,024");
            of_arms(label, &format!("batch_{scalar}"))?;
        }
        for (kind, label) in
            [("forward_dynamics", "forward dynamics"), ("gravity", "gravity alone"), ("mass_matrix", "mass matrix")]
        {
            of_arms(format!("{label}, regrouped, f64"), &format!("{kind}_f64"))?;
        }
        for (trig, label) in [("polynomial", "our own"), ("libm", "libm's")] {
            for scalar in ["f64", "f32"] {
                let any = time(&format!("trig_{trig}_{scalar}"))?;
                table.row(&[format!("six sines and cosines, {label}, {scalar}"), any.clone(), any.clone(), any]);
            }
        }
        Ok(table.0)
    }

    fn compile_table(&self) -> String {
        let mut table = Table::new(&["level", "ms"]);
        for (level, ms) in &self.compile {
            table.row(&[level.clone(), format!("{ms:.1}")]);
        }
        table.0
    }
}
