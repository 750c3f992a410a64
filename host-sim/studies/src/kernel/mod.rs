//! The arm's dynamics as straight-line Rust or C, and the operations saved by each rewrite and each term of the scene.

mod tables;

use clap::Args;
use dynamics_core::{Model, Scene};
use robot_compiler::emit::kernel_file::{Language, source};
use robot_compiler::kernel::functions::Springs;
use robot_compiler::kernel::inputs::live_inputs;
use robot_compiler::kernel::{Function, Level, Precision, Program, compile};
use robot_compiler::names::Named as _;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use serde::Serialize;
use sim::failure::Failure;
use sim::terminal::{json, named};

/// Kernels to compile. Without a function or a level, counts are of all of them.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct KernelRequest {
    /// Difference allowed from the operations of the recursion. Default: exact.
    #[arg(long, value_parser = named::<Level>())]
    pub level: Option<Level>,
    /// Function to compute. Default: inverse-dynamics.
    #[arg(long, value_parser = named::<Function>())]
    pub function: Option<Function>,
    /// Floating-point type. Without it, the scene's.
    #[arg(long, value_parser = named::<ScalarChoice>())]
    pub scalar: Option<ScalarChoice>,
}

/// Form of the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Source of one kernel.
    Source(Language),
    /// Operation counts as JSON.
    Counts,
    /// Tables of the operations that each rewrite and each term saves.
    Tables,
}

/// Compiles the requested kernels of the scene's arm and returns the text in the requested form.
///
/// # Errors
/// [`Failure::Input`] for a robot that is not possible.
pub fn text(request: &KernelRequest, file: &SceneFile, form: Form) -> Result<String, Failure> {
    with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>().map_err(Failure::input)?;
        let kernels = Kernels::new(request, file, &model);
        Ok(match form {
            Form::Source(language) => kernels.source(request, file, language),
            Form::Counts => json(&kernels.counts())? + "\n",
            Form::Tables => kernels.tables(),
        })
    })
}

/// Operation count of one kernel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KernelCost {
    /// Function that the kernel computes.
    pub function: &'static str,
    /// Level of simplification.
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
    /// Number of live inputs that the kernel reads.
    pub live_inputs: usize,
    /// Largest number of computed values that are alive at the same time.
    pub max_live: usize,
}

impl KernelCost {
    /// Counts the operations of a kernel for an arm with `joints` joints.
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

/// An arm in a scene, with the functions and levels to compute.
pub struct Kernels<'a, const N: usize> {
    model: &'a Model<f64, N>,
    scene: Scene<f64, N>,
    precision: Precision,
    functions: Vec<Function>,
    levels: Vec<Level>,
}

impl<'a, const N: usize> Kernels<'a, N> {
    /// Selects the requested kernels of an arm in a scene; all of them by default.
    pub fn new(request: &KernelRequest, file: &SceneFile, model: &'a Model<f64, N>) -> Self {
        let springs = Springs::new(&file.controller_config(model).gains);
        let every = || Function::NAMES.iter().map(|(.., function)| function.with(springs)).collect();
        Self {
            model,
            scene: file.scene(model),
            precision: request.scalar.unwrap_or(file.control.scalar).precision(),
            functions: request.function.map_or_else(every, |function| vec![function.with(springs)]),
            levels: request.level.map_or_else(|| Level::ALL.to_vec(), |level| vec![level]),
        }
    }

    /// Source of one kernel.
    pub fn source(&self, request: &KernelRequest, file: &SceneFile, language: Language) -> String {
        let function = request.function.map_or(Function::InverseDynamics, |_| self.functions[0]);
        let level = request.level.unwrap_or(Level::Exact);
        source(language, file, self.model, function, level, self.precision)
    }

    /// Operation counts of all requested kernels.
    pub fn counts(&self) -> Vec<KernelCost> {
        self.each(|function, level, program| KernelCost::new(function, level, program, N))
    }

    /// Applies `about` to every requested kernel.
    fn each<T>(&self, about: impl Fn(Function, Level, &Program) -> T) -> Vec<T> {
        let kernels = self.functions.iter().flat_map(|&f| self.levels.iter().map(move |&level| (f, level)));
        kernels.map(|(f, level)| about(f, level, &self.compile(f, &self.scene, level))).collect()
    }

    fn compile(&self, function: Function, scene: &Scene<f64, N>, level: Level) -> Program {
        compile(function, self.model, scene, level, self.precision)
    }
}
