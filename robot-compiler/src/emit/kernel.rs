//! A kernel as readable Rust source: `no_std`, without `unsafe`, in rustfmt's layout. [`source`] also writes it in C.

use crate::describe::scene::SceneFile;
use crate::kernel::{Function, Level, Precision, Program, compile};
use crate::names::Named;
use dynamics_core::{Model, Scene};
use text::{INVERSE_DYNAMICS, MOMENTUM, Scalars, Text};

pub(super) mod phrases;
mod text;
mod title;
pub(super) mod writer;

pub use title::Title;

/// Programming language of a kernel's source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// `no_std` Rust: [`module`].
    Rust,
    /// C99: [`kernel_source`](super::c::kernel_source).
    C,
}

impl Named for Language {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[("rust", "", Self::Rust), ("c", "", Self::C)];
}

/// Source of a function of an arm in a scene, with a head that names both. `newtau model kernel` and Python's `Arm.kernel` print it.
#[must_use]
pub fn source<const N: usize>(
    language: Language,
    file: &SceneFile,
    model: &Model<f64, N>,
    function: Function,
    level: Level,
    precision: Precision,
) -> String {
    let scene = file.scene(model);
    let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(model) };
    match language {
        Language::Rust => module(function, model, &scene, level, precision, &title),
        Language::C => {
            let program = compile(function, model, &scene, level, precision);
            super::c::kernel_source(function, &program, N, precision, level, &title)
        }
    }
}

/// Rust source of a module that computes a function of an arm in a scene.
///
/// | function | item |
/// |---|---|
/// | inverse dynamics | `Kernel`, a type that implements `InverseDynamics<S, N>` |
/// | momentum | `Kernel`, a type that implements `GeneralizedMomentum<S, N>` |
/// | any other | `fn NAME(turn, q, qd, qdd, live) -> [S; M]`, with only the arguments that the function reads |
///
/// `S` is `f32` or `f64`; the module depends on `dynamics-core` alone.
#[must_use]
pub fn module<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    level: Level,
    precision: Precision,
    title: &Title<'_>,
) -> String {
    module_of(&compile(function, model, scene, level, precision), function, scene, level, precision, title)
}

/// As [`module`], from a program that was already compiled from these inputs.
#[must_use]
pub fn module_of<const N: usize>(
    program: &Program,
    function: Function,
    scene: &Scene<f64, N>,
    level: Level,
    precision: Precision,
    title: &Title<'_>,
) -> String {
    text(program, function, scene, level, precision, title, Scalars::One)
}

/// As [`module`], for every scalar: one text runs on `f64` and on SIMD lanes of it, with the same bits in every lane.
///
/// | function | item |
/// |---|---|
/// | inverse dynamics | `Kernel`, a type that implements `InverseDynamics<S, N>` for every `S: Scalar` |
/// | momentum | `Kernel`, a type that implements `GeneralizedMomentum<S, N>` for every `S: Scalar` |
/// | any other | `fn NAME<S: Scalar>(turn, q, qd, qdd, live) -> [S; M]`, with only the arguments that the function reads |
///
/// Functions with a division need `S: Field`.
///
/// Numbers are folded in `precision` and read through `Scalar::literal`. The bits equal the recursion's if the scalar
/// computes in that precision.
#[must_use]
pub fn generic_module<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    level: Level,
    precision: Precision,
    title: &Title<'_>,
) -> String {
    let program = compile(function, model, scene, level, precision);
    text(&program, function, scene, level, precision, title, Scalars::Every)
}

fn text<const N: usize>(
    program: &Program,
    function: Function,
    scene: &Scene<f64, N>,
    level: Level,
    precision: Precision,
    title: &Title<'_>,
    scalars: Scalars,
) -> String {
    let text = Text { function, program, joints: N, precision, title, scalars };
    let head = text.head(&function.sees(scene), level);
    let item = match function {
        Function::InverseDynamics => text.kernel(&INVERSE_DYNAMICS),
        Function::Momentum => text.kernel(&MOMENTUM),
        Function::Gravity
        | Function::Coriolis
        | Function::MassMatrix
        | Function::JointWrenches
        | Function::ForwardDynamics
        | Function::Regressor
        | Function::ComputedTorque(_) => text.function(),
    };
    head + &item
}
