//! The arm's dynamics as straight-line Rust, and what each rewrite and each term of the scene is worth.

mod tables;

use dynamics_core::{Model, Scene};
use robot_compiler::SceneFile;
use robot_compiler::emit::kernel::{Title, module};
use robot_compiler::kernel::functions::{Springs, live_inputs};
use robot_compiler::kernel::{Function, Level, Precision, Program, compile};
use robot_compiler::names::Named as _;
use serde::Serialize;

/// What is asked for.
pub(crate) struct Asked {
    /// Floating-point type; the scene's otherwise.
    pub(crate) precision: Option<Precision>,
    /// What it computes.
    pub(crate) function: Option<Function>,
    /// How it is simplified.
    pub(crate) level: Option<Level>,
}

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
pub(crate) struct Kernels<'a, const N: usize> {
    model: &'a Model<f64, N>,
    scene: Scene<f64, N>,
    precision: Precision,
    functions: Vec<Function>,
    levels: Vec<Level>,
}

impl<'a, const N: usize> Kernels<'a, N> {
    /// What is asked for of an arm in a scene; everything where nothing is.
    pub(crate) fn new(asked: &Asked, file: &SceneFile, model: &'a Model<f64, N>) -> Self {
        let springs = Springs::new(&file.controller_config(model).gains);
        let every = || Function::NAMES.iter().map(|(.., function)| function.with(springs)).collect();
        Self {
            model,
            scene: file.scene(model),
            precision: asked.precision.unwrap_or(file.control.scalar.precision()),
            functions: asked.function.map_or_else(every, |function| vec![function]),
            levels: asked.level.map_or_else(|| Level::ALL.to_vec(), |level| vec![level]),
        }
    }

    /// The source of one kernel.
    pub(crate) fn source(&self, asked: &Asked, file: &SceneFile) -> String {
        let function = asked.function.unwrap_or(Function::InverseDynamics);
        let level = asked.level.unwrap_or(Level::Exact);
        let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(self.model) };
        module(function, self.model, &self.scene, level, self.precision, &title)
    }

    /// How much work every kernel is that is asked for.
    pub(crate) fn counts(&self) -> Vec<Count> {
        self.each(|function, level, program| Count::new(function, level, program, N))
    }

    /// Something about every kernel that is asked for.
    fn each<T>(&self, about: impl Fn(Function, Level, &Program) -> T) -> Vec<T> {
        let kernels = self.functions.iter().flat_map(|&f| self.levels.iter().map(move |&level| (f, level)));
        kernels.map(|(f, level)| about(f, level, &self.compile(f, &self.scene, level))).collect()
    }

    fn compile(&self, function: Function, scene: &Scene<f64, N>, level: Level) -> Program {
        compile(function, self.model, scene, level, self.precision)
    }
}
