//! `kernel`: the arm's dynamics as straight-line Rust, and what each rewrite and each term of the scene is worth.

use crate::cli::KernelArgs;
use crate::exit::{self, Failure};
use comfy_table::{CellAlignment, Table, presets};
use dynamics_core::{Model, Scene, Term};
use robot_compiler::emit::kernel::{Title, module};
use robot_compiler::kernel::functions::{Springs, live_inputs};
use robot_compiler::kernel::{
    Function, Level, Precision, Program, Rule, RuleSet, Step, compile, compile_with, compile_without,
};
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{Robot, SceneFile, with_dof};
use serde::Serialize;
use std::path::Path;

/// How much work one kernel is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Count {
    /// What it computes.
    pub function: &'static str,
    /// How it was simplified.
    pub level: &'static str,
    /// Multiplications.
    pub mul: usize,
    /// Additions.
    pub add: usize,
    /// Subtractions.
    pub sub: usize,
    /// Divisions.
    pub div: usize,
    /// Negations.
    pub neg: usize,
    /// Live inputs that it reads.
    pub live_inputs: usize,
    /// The most computed values alive at once.
    pub max_live: usize,
}

/// Print the source, the counts or the tables.
///
/// # Errors
/// A robot or a scene file that is wrong; a scene about another robot.
pub fn run(args: &KernelArgs) -> Result<(), Failure> {
    let file = scene_about(&args.robot, args.scene.as_deref())?;
    let text = with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>().map_err(Failure::input)?;
        let kernels = Kernels::new(args, &file, &model);
        if args.json {
            let counts: Vec<Count> = kernels.each(|function, level, program| Count::new(function, level, program, N));
            serde_json::to_string_pretty(&counts).map_err(|error| Failure::Output(error.into()))? + "\n"
        } else if args.table {
            kernels.tables()
        } else {
            kernels.source(args, &file)
        }
    });
    exit::print(&text)
}

/// The scene that is asked for, if it is about the robot that is asked for; a sensible one if none is.
pub(crate) fn scene_about(robot_file: &Path, scene_file: Option<&Path>) -> Result<SceneFile, Failure> {
    let robot = Robot::load(robot_file).map_err(Failure::input)?;
    let Some(path) = scene_file else { return Ok(SceneFile::default_for(robot)) };
    let file = SceneFile::load(path).map_err(Failure::input)?;
    // By what the files hold: the same file may be reached by many paths.
    if (Robot { path: file.robot.path.clone(), ..robot.clone() }) == file.robot {
        return Ok(file);
    }
    let (scene, asked) = (path.display(), robot_file.display());
    Err(Failure::Input(miette::miette!(
        help = "expected a scene whose `robot` is that file",
        "{scene} is a scene of another robot, {:?}; {asked} holds {:?}",
        file.robot.name,
        robot.name
    )))
}

impl Count {
    /// Of a kernel of an arm with so many joints.
    fn new(function: Function, level: Level, program: &Program, joints: usize) -> Self {
        let n = program.operations();
        Self {
            function: function.name(),
            level: level.name(),
            mul: n.mul,
            add: n.add,
            sub: n.sub,
            div: n.div,
            neg: n.neg,
            live_inputs: live_inputs(program, joints),
            max_live: program.live_max(),
        }
    }
}

/// An arm in a scene, and what of it is asked for.
struct Kernels<'a, const N: usize> {
    model: &'a Model<f64, N>,
    springs: Springs,
    scene: Scene<f64, N>,
    precision: Precision,
    functions: Vec<Function>,
    levels: Vec<Level>,
}

impl<'a, const N: usize> Kernels<'a, N> {
    fn new(args: &KernelArgs, file: &SceneFile, model: &'a Model<f64, N>) -> Self {
        let of_scene = match file.control.scalar {
            // The kernel of a mixed scene is the part of it in single precision.
            ScalarChoice::F32 | ScalarChoice::Mixed => Precision::Single,
            ScalarChoice::F64 => Precision::Double,
        };
        let springs = Springs::new(&file.controller_config(model).gains);
        let every = || Function::ALL.into_iter().chain([Function::ComputedTorque(springs)]).collect();
        Self {
            model,
            springs,
            scene: file.scene(model),
            precision: args.scalar.map_or(of_scene, Precision::from),
            functions: args.function.map_or_else(every, |name| vec![name.function(springs)]),
            levels: args.level.map_or_else(|| Level::ALL.to_vec(), |name| vec![name.into()]),
        }
    }

    fn source(&self, args: &KernelArgs, file: &SceneFile) -> String {
        let function = args.function.map_or(Function::InverseDynamics, |name| name.function(self.springs));
        let level = args.level.map_or(Level::Exact, Level::from);
        let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(self.model) };
        module(function, self.model, &self.scene, level, self.precision, &title)
    }

    /// Something about every kernel that is asked for.
    fn each<T>(&self, about: impl Fn(Function, Level, &Program) -> T) -> Vec<T> {
        let kernels = self.functions.iter().flat_map(|&f| self.levels.iter().map(move |&level| (f, level)));
        kernels.map(|(f, level)| about(f, level, &self.compile(f, &self.scene, level))).collect()
    }

    fn compile(&self, function: Function, scene: &Scene<f64, N>, level: Level) -> Program {
        compile(function, self.model, scene, level, self.precision)
    }

    fn tables(&self) -> String {
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
        let mut table = table(&["function", "level"]);
        table.add_rows(self.each(|function, level, program| {
            let names = [function.name(), level.name()].map(str::to_owned);
            names.into_iter().chain(work(program, N).map(|n| n.to_string())).collect::<Vec<_>>()
        }));
        table
    }

    fn rule_table(&self) -> Table {
        let mut table = table(&["function", "rewrite"]);
        for &function in &self.functions {
            let with = |rules| compile_with(function, self.model, &self.scene, rules, self.precision);
            let all = with(RuleSet::ALL);
            for rule in Rule::ALL {
                table.add_row(difference([function.name(), rule.name()], &with(RuleSet::ALL.without(rule)), &all, N));
            }
            table.add_row(difference([function.name(), "all of them"], &with(RuleSet::NONE), &all, N));
        }
        table
    }

    fn step_table(&self) -> Table {
        let mut table = table(&["function", "step"]);
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
        let mut table = table(&["function", "level", "term"]);
        for &function in &self.functions {
            // A term that the function does not have costs it nothing, and has no row.
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

/// A row: how much more work one program is than another.
fn difference<const K: usize>(names: [&str; K], more: &Program, less: &Program, joints: usize) -> Vec<String> {
    let signed = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    let counts = work(more, joints).into_iter().zip(work(less, joints));
    let differences = counts.map(|(more, less)| (signed(more) - signed(less)).to_string());
    names.into_iter().map(str::to_owned).chain(differences).collect()
}

/// Headers of the numbers in a table.
const WORK: [&str; 8] = ["mul", "add", "sub", "div", "neg", "live inputs", "alive, traced", "alive, scheduled"];

/// What stands under them.
fn work(program: &Program, joints: usize) -> [usize; 8] {
    let n = program.operations();
    let alive = [program.live_max_as_traced(), program.live_max()];
    [n.mul, n.add, n.sub, n.div, n.neg, live_inputs(program, joints), alive[0], alive[1]]
}

/// A table of some names and then numbers.
fn table(names: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(names.iter().chain(&WORK));
    for column in table.column_iter_mut().skip(names.len()) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The scene without one of its terms, for each that it has.
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
