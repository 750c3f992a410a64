//! Tables of the operations saved by each rewrite and each term of the scene.

use super::Kernels;
use comfy_table::Table;
use dynamics_core::{Scene, Term};
use robot_compiler::kernel::inputs::live_inputs;
use robot_compiler::kernel::{Level, Program, RewriteRule, RuleSet, Step, compile_with, compile_without};
use sim::table::table;

impl<const N: usize> Kernels<'_, N> {
    /// All tables as text.
    pub fn tables(&self) -> String {
        let work = self.work_table();
        let mut text = format!("Work; values alive at most, in the order traced and as scheduled:\n{work}\n");
        if self.levels.contains(&Level::Exact) {
            text += &format!("\nWhat each rewrite saves of level exact:\n{}\n", self.rule_table());
        }
        if self.levels.contains(&Level::Regrouped) {
            text += &format!("\nWhat each step of level regrouped saves:\n{}\n", self.step_table());
        }
        text + &format!("\nWhat each term of the scene costs:\n{}\n", self.term_table())
    }

    fn work_table(&self) -> Table {
        let mut table = work_of(&["function", "level"]);
        table.add_rows(self.each(|function, level, program| {
            let names = [function.name(), level.name()].map(str::to_owned);
            names.into_iter().chain(work(program, N).map(|n| n.to_string())).collect::<Vec<_>>()
        }));
        table
    }

    fn rule_table(&self) -> Table {
        let mut table = work_of(&["function", "rewrite"]);
        for &function in &self.functions {
            let with = |rules| compile_with(function, self.model, &self.scene, rules, self.precision);
            let all = with(RuleSet::ALL);
            for rule in RewriteRule::ALL {
                table.add_row(difference([function.name(), rule.name()], &with(RuleSet::ALL.without(rule)), &all, N));
            }
            table.add_row(difference([function.name(), "all of them"], &with(RuleSet::NONE), &all, N));
        }
        table
    }

    fn step_table(&self) -> Table {
        let mut table = work_of(&["function", "step"]);
        for &function in &self.functions {
            let all = self.compile(function, &self.scene, Level::Regrouped);
            for step in Step::ALL {
                let without = compile_without(step, function, self.model, &self.scene, self.precision);
                table.add_row(difference([function.name(), step.name()], &without, &all, N));
            }
            let exact = self.compile(function, &self.scene, Level::Exact);
            table.add_row(difference([function.name(), "all of them"], &exact, &all, N));
        }
        table
    }

    fn term_table(&self) -> Table {
        let mut table = work_of(&["function", "level", "term"]);
        for &function in &self.functions {
            // A term that the function does not use costs nothing and has no row.
            let scene = function.sees(&self.scene);
            for &level in &self.levels {
                let all = self.compile(function, &scene, level);
                for (term, without) in without_each_term(&scene) {
                    let names = [function.name(), level.name(), term];
                    table.add_row(difference(names, &all, &self.compile(function, &without, level), N));
                }
            }
        }
        table
    }
}

/// A row: the operations that one program has in excess of another.
fn difference<const K: usize>(names: [&str; K], more: &Program, less: &Program, joints: usize) -> Vec<String> {
    let signed = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    let counts = work(more, joints).into_iter().zip(work(less, joints));
    let differences = counts.map(|(more, less)| (signed(more) - signed(less)).to_string());
    names.into_iter().map(str::to_owned).chain(differences).collect()
}

/// Headers of the operation counts.
const WORK: [&str; 8] = ["mul", "add", "sub", "div", "neg", "live inputs", "alive, traced", "alive, scheduled"];

/// Operation counts under those headers.
fn work(program: &Program, joints: usize) -> [usize; 8] {
    let n = program.operations();
    let alive = [program.live_max_as_traced(), program.live_max()];
    [n.mul, n.add, n.sub, n.div, n.neg, live_inputs(program, joints), alive[0], alive[1]]
}

/// A table of names and operation counts.
fn work_of(names: &[&str]) -> Table {
    table(names.iter().chain(&WORK), names.len())
}

/// The scene without each one of its terms in turn.
fn without_each_term<const N: usize>(scene: &Scene<f64, N>) -> Vec<(&'static str, Scene<f64, N>)> {
    fn present<T>(term: &Term<T>) -> bool {
        !matches!(term, Term::Absent)
    }
    let Scene { gravity, payload, tip_wrench, rotor, coriolis } = scene;
    [
        ("gravity", present(gravity), Scene { gravity: Term::Absent, ..*scene }),
        ("payload", present(payload), Scene { payload: Term::Absent, ..*scene }),
        ("tip wrench", present(tip_wrench), Scene { tip_wrench: Term::Absent, ..*scene }),
        ("rotors", present(rotor), Scene { rotor: Term::Absent, ..*scene }),
        ("velocity terms", present(coriolis), Scene { coriolis: Term::Absent, ..*scene }),
    ]
    .into_iter()
    .filter_map(|(name, present, without)| present.then_some((name, without)))
    .collect()
}
