//! A kernel as readable Rust source: `no_std`, without `unsafe`, in rustfmt's layout.

use crate::kernel::{Function, Level, Precision, Program, compile};
use dynamics_core::{Model, Scene};
use text::{INVERSE_DYNAMICS, MOMENTUM, Scalars, Text};

pub(super) mod phrases;
mod text;
mod title;
pub(super) mod writer;

pub use title::Title;

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
