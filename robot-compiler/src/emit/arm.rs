//! The arm, its scene and its controller.

use super::expression::{Float, literal};
use super::fields::item;
use super::items::{model_item, scene_item};
use crate::describe::scene::{ScalarChoice, SceneFile};
use dynamics_core::safety::Rules;
use dynamics_core::trig::Method;
use dynamics_core::{ControllerConfig, Model, Scene, Term};

/// Rust source of a module with the arm, its scene and its controller, for a crate without std.
///
/// | item | type | meaning |
/// |---|---|---|
/// | `N` | `usize` | joints |
/// | `NAME`, `ROBOT` | `&str` | the scene's and the robot's name |
/// | `HASH` | `u64` | [`SceneFile::hash`] |
/// | `RATE_HZ` | `f32` | control rate |
/// | `TRIG` | `Trig` | sine and cosine; an alias of a type of `dynamics_core::trig` and its value |
/// | `model()` | `Model<f32, N>` | the arm |
/// | `scene()` | `Scene<f32, N>` | the loads on it |
/// | `config()` | `ControllerConfig<f32, N>` | the controller |
/// | `rules()` | `Rules<f32, N>` | the safety state machine around it |
///
/// The text is formatted as rustfmt would format it at a width of 120.
#[must_use]
pub fn arm_module<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    arm_module_in(file, model, ScalarChoice::F32)
}

/// As [`arm_module`], with another scalar than `f32`.
#[must_use]
pub fn arm_module_in<const N: usize>(file: &SceneFile, model: &Model<f64, N>, scalar: ScalarChoice) -> String {
    match scalar {
        ScalarChoice::F32 => arm_text::<f32, N>(file, model),
        ScalarChoice::F64 => arm_text::<f64, N>(file, model),
    }
}

fn arm_text<S: Float, const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    let real = S::NAME;
    let trig = match file.control.trig {
        Method::Polynomial => "Polynomial",
        Method::Polynomial5 => "Polynomial5",
        Method::Polynomial3 => "Polynomial3",
        Method::Table => "Table",
        Method::Libm => "Libm",
    };
    let scene = file.scene(model).cast::<S>();
    let config = file.controller_config(model).cast::<S>();
    let rules = file.safety_rules(model).cast::<S>();
    let mut text =
        String::from("//! Generated from a robot and a scene file. Do not edit: change the files instead.\n\n");
    text += &imports(&scene, &config, &rules, trig);
    text += &format!("\n/// The type of [`TRIG`].\npub type Trig = {trig};\n");
    let constants = [
        ("Which sine and cosine.", "TRIG", "Trig", trig.to_owned()),
        ("Joints.", "N", "usize", N.to_string()),
        ("The scene.", "NAME", "&str", format!("{:?}", file.name)),
        ("The robot.", "ROBOT", "&str", format!("{:?}", file.robot.name)),
        ("Hash of everything that decides the bits of a tick.", "HASH", "u64", hexadecimal(file.hash(model))),
        ("Control rate, Hz.", "RATE_HZ", real, literal(S::literal(file.control.rate))),
    ];
    for (doc, name, kind, value) in constants {
        text += &format!("\n/// {doc}\npub const {name}: {kind} = {value};\n");
    }
    let functions = [
        ("The arm.", "model", "Model", model_item(&model.cast::<S>())),
        ("Gravity, payload, wrench at the tip, and the terms of the model.", "scene", "Scene", scene_item(&scene)),
        ("Its controller.", "config", "ControllerConfig", item(&config)),
        ("The safety state machine around it.", "rules", "Rules", item(&rules)),
    ];
    for (doc, name, kind, body) in functions {
        text += &format!("\n/// {doc}\npub const fn {name}() -> {kind}<{real}, N> {{\n    {}\n}}\n", body.print(4));
    }
    text
}

/// `0x0123_4567_89ab_cdef`.
fn hexadecimal(hash: u64) -> String {
    let part = |shift: u32| (hash >> shift) & 0xffff;
    format!("0x{:04x}_{:04x}_{:04x}_{:04x}", part(48), part(32), part(16), part(0))
}

/// Imports of the items in use, in rustfmt's order.
fn imports<S: Float, const N: usize>(
    scene: &Scene<S, N>,
    config: &ControllerConfig<S, N>,
    rules: &Rules<S, N>,
    trig: &str,
) -> String {
    let heat = if rules.heat.is_some() { "use dynamics_core::safety::heat::HeatRules;\n" } else { "" };
    let friction = if config.friction.is_some() { "Friction, " } else { "" };
    let integral = if config.integral.is_some() { "Integral, " } else { "" };
    let teach = if config.teach.is_some() { "Teach, " } else { "" };
    let wrench = if matches!(scene.tip_wrench, Term::Constant(_)) { ", Wrench" } else { "" };
    format!(
        "use dynamics_core::control::{{ControlLaw, Encoder, {friction}Gains, Guard, {integral}{teach}TrackingObserver}};\n\
         use dynamics_core::model::{{Link, Placement}};\n\
         {heat}use dynamics_core::safety::{{JointRules, Rules, SafeAction}};\n\
         use dynamics_core::trig::{trig};\n\
         use dynamics_core::{{ControllerConfig, Inertia, InertiaBounds, JointKind, Limits, Model, Scene, Term{wrench}}};\n\
         use nalgebra::{{Matrix3, Vector3}};\n"
    )
}
