//! A checked arm and its controller as Rust source for the chip.
//!
//! The desk reads and checks the files; the chip gets numbers. Every literal is the shortest decimal that reads back as the
//! same number, so the chip computes with the very bits that the desk hashed. A firmware computes in single precision, whatever
//! the scene says of the desk; what only measures costs ([`cost`]) computes in the scene's own scalar.

use crate::describe::robot::Robot;
use crate::describe::scene::{ControlSpec, KernelMemory, ScalarChoice, SceneFile, UNREAD_MAX};
use crate::kernel::{Function, Level, Precision};
use crate::with_dof;
use dynamics_core::control::{CollisionConfig, Encoder, Friction, Gains, Guard};
use dynamics_core::model::{Link, Placement};
use dynamics_core::safety::{JointRules, Rules};
use dynamics_core::trig::Method;
use dynamics_core::{ControllerConfig, Inertia, JointKind, Limits, Model, Scene, Term, Wrench};
use nalgebra::{Matrix3, Vector3};
use std::path::Path;

pub mod cost;
mod drives;
mod expression;
pub mod kernel;
pub mod modules;

pub use drives::drives_module;

use expression::{Float, Item, call, integer, list, number, record, word};
use kernel::Title;

/// Rust source of a module with the arm, its scene and its controller, for a crate without std.
///
/// | item | type | what |
/// |---|---|---|
/// | `N` | `usize` | joints |
/// | `NAME`, `ROBOT` | `&str` | the scene's and the robot's name |
/// | `HASH` | `u64` | [`SceneFile::hash`] |
/// | `RATE_HZ` | `f32` | control rate |
/// | `TRIG` | `Trig` | which sine and cosine; an alias of a type of `dynamics_core::trig` and its value |
/// | `model()` | `Model<f32, N>` | the arm |
/// | `scene()` | `Scene<f32, N>` | what acts on it |
/// | `config()` | `ControllerConfig<f32, N>` | the controller |
/// | `rules()` | `Rules<f32, N>` | the safety state machine around it |
///
/// The text is as rustfmt would leave it at a width of 120.
#[must_use]
pub fn arm_module<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    arm_module_in(file, model, ScalarChoice::F32)
}

/// As [`arm_module`], in a scalar of choice in place of `f32`.
#[must_use]
pub fn arm_module_in<const N: usize>(file: &SceneFile, model: &Model<f64, N>, scalar: ScalarChoice) -> String {
    match scalar {
        ScalarChoice::F32 => arm_text::<f32, N>(file, model, false),
        ScalarChoice::F64 => arm_text::<f64, N>(file, model, false),
        ScalarChoice::Mixed => arm_text::<f64, N>(file, model, true),
    }
}

fn arm_text<S: Float, const N: usize>(file: &SceneFile, model: &Model<f64, N>, mixed: bool) -> String {
    let real = S::NAME;
    // Where both precisions are there, angles are narrow.
    let angle = if mixed { "f32" } else { real };
    let trig = match file.control.trig {
        Method::Polynomial => "Polynomial",
        Method::Polynomial5 => "Polynomial5",
        Method::Polynomial3 => "Polynomial3",
        Method::Table => "Table",
        Method::Rotation => "Rotation",
        Method::Libm => "Libm",
    };
    // What remembers is of a precision, and has no value without a call.
    let (kind, value) = match file.control.trig {
        Method::Rotation => (format!("{trig}<{angle}>"), format!("{trig}::<{angle}>::new()")),
        _ => (trig.to_owned(), trig.to_owned()),
    };
    let (kind, value) = if mixed { (format!("Reduced<{kind}>"), format!("Reduced({value})")) } else { (kind, value) };
    let scene = file.scene(model).cast::<S>();
    let config = file.controller_config(model).cast::<S>();
    let rules = file.safety_rules(model).cast::<S>();
    let mut text =
        String::from("//! Generated from a robot and a scene file. Do not edit: change the files instead.\n\n");
    text += &imports(&scene, &config, trig);
    if mixed {
        text += "use dynamics_core::mixed::Reduced;\n";
    }
    text += &format!("\n/// The type of [`TRIG`].\npub type Trig = {kind};\n");
    let constants = [
        ("Which sine and cosine.", "TRIG", "Trig", value),
        ("Joints.", "N", "usize", N.to_string()),
        ("The scene.", "NAME", "&str", format!("{:?}", file.name)),
        ("The robot.", "ROBOT", "&str", format!("{:?}", file.robot.name)),
        ("Hash of everything that decides the bits of a tick.", "HASH", "u64", hexadecimal(file.hash(model))),
        ("Control rate, Hz.", "RATE_HZ", real, expression::literal(S::literal(file.control.rate))),
    ];
    for (doc, name, kind, value) in constants {
        text += &format!("\n/// {doc}\npub const {name}: {kind} = {value};\n");
    }
    let functions = [
        ("The arm.", "model", "Model", model_item(&model.cast::<S>())),
        ("What acts on it.", "scene", "Scene", scene_item(&scene)),
        ("Its controller.", "config", "ControllerConfig", config_item(&config)),
        ("The safety state machine around it.", "rules", "Rules", rules_item(&rules)),
    ];
    for (doc, name, kind, body) in functions {
        text += &format!("\n/// {doc}\npub const fn {name}() -> {kind}<{real}, N> {{\n    {}\n}}\n", body.print(4));
    }
    text
}

/// Rust source of a module with the arm's inverse dynamics, for use beside [`arm_module`].
///
/// | item | what |
/// |---|---|
/// | `Arm` | a type that implements `InverseDynamics<f32, N>`: the kernel that the scene asks for, where it asks for it, or the recursion, in the ticks in which it is asked for |
/// | `arm()` | its value |
#[must_use]
pub fn dynamics_module<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    dynamics_module_in(file, model, ScalarChoice::F32)
}

/// As [`dynamics_module`], in a scalar of choice in place of `f32`; mixed: the kernel in f32, what is around it in f64.
#[must_use]
pub fn dynamics_module_in<const N: usize>(file: &SceneFile, model: &Model<f64, N>, scalar: ScalarChoice) -> String {
    let precision = match scalar {
        ScalarChoice::F32 | ScalarChoice::Mixed => Precision::Single,
        ScalarChoice::F64 => Precision::Double,
    };
    let (text, inner) = match file.control.kernel.level() {
        None => (
            "//! The recursion itself, with the model at run time.\n\nuse dynamics_core::Dynamics;\n".to_owned(),
            Inner {
                kind: format!("Dynamics<{}, {N}>", precision.name()),
                value: match scalar {
                    ScalarChoice::F32 | ScalarChoice::F64 => "Dynamics::new(super::arm::model(), super::arm::scene())",
                    ScalarChoice::Mixed => "Dynamics::new(super::arm::model().cast(), super::arm::scene().cast())",
                }
                .to_owned(),
                constant: false,
            },
        ),
        Some(level) => {
            let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(model) };
            let (function, scene) = (Function::InverseDynamics, file.scene(model));
            let kernel = kernel::module(function, model, &scene, level, precision, &title);
            let constant = |name: &str| Inner { kind: name.to_owned(), value: name.to_owned(), constant: true };
            match file.control.kernel_memory {
                KernelMemory::Flash => (kernel, constant("Kernel")),
                KernelMemory::Sram => (format!("{kernel}\n{}", in_sram(N, precision.name())), constant("InSram")),
            }
        }
    };
    let (text, inner) = match scalar {
        ScalarChoice::F32 | ScalarChoice::F64 => (text, inner),
        ScalarChoice::Mixed => (
            text + "use dynamics_core::mixed::Narrow;\n",
            Inner { kind: format!("Narrow<{}>", inner.kind), value: format!("Narrow({})", inner.value), ..inner },
        ),
    };
    let real = if matches!(scalar, ScalarChoice::F32) { "f32" } else { "f64" };
    text + "\n" + &arm_items::<N>(file, inner, real)
}

/// Rust source of a module with what watches the arm, for use beside [`arm_module`].
///
/// | item | what |
/// |---|---|
/// | `Protection` | a type that implements `Protection<f32, N>`: a watch for collisions where the scene asks for one, else nothing |
/// | `protection()` | its value |
#[must_use]
pub fn protection_module<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    let Some(config) = file.collision_config::<N>() else {
        return "//! Nothing watches the arm.\n\nuse dynamics_core::control::Unprotected;\n\n\
                /// Nothing.\npub type Protection = Unprotected;\n\n\
                /// Nothing.\npub const fn protection() -> Protection {\n    Unprotected\n}\n"
            .to_owned();
    };
    let (text, momentum, value) = match file.control.kernel.level() {
        None => (
            "//! Momentum by the recursion itself, with the model at run time.\n\nuse dynamics_core::Dynamics;\n"
                .to_owned(),
            format!("Dynamics<f32, {N}>"),
            "Dynamics::new(super::arm::model(), super::arm::scene())",
        ),
        // Exact whatever the level: the desk has the recursion.
        Some(_) => {
            let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(model) };
            let (scene, precision) = (file.scene(model), Precision::Single);
            let kernel = kernel::module(Function::Momentum, model, &scene, Level::Exact, precision, &title);
            (kernel, "Kernel".to_owned(), "Kernel")
        }
    };
    format!(
        "{text}\nuse dynamics_core::control::{{CollisionConfig, CollisionConfiguration, CollisionWatch, MomentumFilter, Reaction}};\n\n\
         /// When something has been hit, as constants of the program.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub struct Thresholds;\n\n\
         impl CollisionConfiguration<f32, {N}> for Thresholds {{\n    #[inline]\n    \
         fn get(&self) -> &CollisionConfig<f32, {N}> {{\n        const {{ &{} }}\n    }}\n}}\n\n\
         /// What watches the arm.\npub type Protection = CollisionWatch<f32, {N}, {momentum}, Thresholds>;\n\n\
         /// What watches the arm.\npub fn protection() -> Protection {{\n    CollisionWatch::new(Thresholds, {value})\n}}\n",
        collision_item(&config.cast()).print(8),
    )
}

fn collision_item<const N: usize>(config: &CollisionConfig<f32, N>) -> Item {
    let CollisionConfig { filter, threshold, released, ticks, release_ticks, reaction } = config;
    record(
        "CollisionConfig",
        vec![
            ("filter", call("MomentumFilter::from_numbers", filter.numbers().map(number).into())),
            ("threshold", numbers(threshold)),
            ("released", numbers(released)),
            ("ticks", integer(i64::from(*ticks))),
            ("release_ticks", integer(i64::from(*release_ticks))),
            ("reaction", word(&format!("Reaction::{reaction:?}"))),
        ],
    )
}

/// The dynamics of an emitted module: its type, its value, and whether that is one that a `const fn` can give.
struct Inner {
    kind: String,
    value: String,
    constant: bool,
}

/// `Arm` and `arm()`: the inner dynamics themselves or, where the scene evaluates its model in some ticks only, those in
/// [`dynamics_core::control::EveryNth`].
fn arm_items<const N: usize>(file: &SceneFile, inner: Inner, real: &str) -> String {
    let Inner { kind, value, constant } = inner;
    let ControlSpec { model_every, model_between, .. } = &file.control;
    if *model_every > 1 {
        return format!(
            "use dynamics_core::control::{{Between, EveryNth}};\n\n\
             /// The arm's inverse dynamics, evaluated once in {model_every} ticks.\n\
             pub type Arm = EveryNth<{kind}, {real}, {N}>;\n\n\
             /// The arm's inverse dynamics.\npub fn arm() -> Arm {{\n    let inner = {value};\n    \
             EveryNth::new(inner, {model_every}, Between::{model_between:?}, &const {{ super::arm::config().gains }})\n}}\n"
        );
    }
    let prefix = if constant { "const " } else { "" };
    format!(
        "/// The arm's inverse dynamics.\npub type Arm = {kind};\n\n\
         /// The arm's inverse dynamics.\npub {prefix}fn arm() -> Arm {{\n    {value}\n}}\n"
    )
}

/// The type `InSram`, whose one function holds the kernel and lies in static RAM.
fn in_sram(joints: usize, real: &str) -> String {
    format!(
        "/// The arm's inverse dynamics, run from static RAM.\n\
         #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]\npub struct InSram;\n\n\
         impl InverseDynamics<{real}, {joints}> for InSram {{\n    \
         #[allow(unsafe_code, reason = \"a function is placed where variables lie\")]\n    \
         // SAFETY: the start-up code copies the section to RAM before anything runs, and nothing writes to it.\n    \
         #[cfg_attr(target_os = \"none\", unsafe(link_section = \".data.kernel\"))]\n    \
         #[inline(never)]\n    fn inverse_dynamics(\n        &self,\n        \
         turn: &[SinCos<{real}>; {joints}],\n        q: &[{real}; {joints}],\n        qd: &[{real}; {joints}],\n        \
         qdd: &[{real}; {joints}],\n        live: &Live<{real}, {joints}>,\n    ) -> [{real}; {joints}] {{\n        \
         Kernel.inverse_dynamics(turn, q, qd, qdd, live)\n    }}\n}}\n"
    )
}

/// Variables of the environment that stand for a scene's own law, and sine and cosine, when a firmware is built.
pub const CHOICES: [&str; 2] = ["NEWTAU_LAW", "NEWTAU_TRIG"];

/// Slowest rate of the boards' timers, Hz: the emulated one has 16 bits at 1 MHz.
const RATE_MIN: f64 = 16.0;

/// Write `arm.rs`, `dynamics.rs`, `protection.rs` and `drives.rs` for a scene into a folder: the whole of a firmware's build script.
///
/// # Errors
/// A scene that cannot be read, a rate that the boards' timers do not have, or a folder that cannot be written to.
pub fn write_firmware(scene: &Path, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut file = SceneFile::load(scene)?;
    let chosen = CHOICES.map(|name| std::env::var(name).ok());
    file.control.choose(chosen[0].as_deref(), chosen[1].as_deref())?;
    let rate = file.control.rate;
    if rate.fract() != 0.0 || rate < RATE_MIN {
        let name = scene.display();
        return Err(
            format!("{name}: control.rate: {rate} Hz; expected whole hertz, {RATE_MIN} or more, for a chip").into()
        );
    }
    if let Some((joint, jump)) = file.too_fast_for_its_encoder() {
        let (name, label) = (scene.display(), Robot::joint_label(joint, &file.robot.joints[joint].name));
        return Err(format!(
            "{name}: control.rate: {rate} Hz, at which the encoder of {label} moves up to {jump} counts in a tick; \
             expected a rate at which it moves less than half a turn in {UNREAD_MAX} ticks, or a lower velocity limit"
        )
        .into());
    }
    let (arm, dynamics, protection, drives) = with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>()?;
        (
            arm_module(&file, &model),
            dynamics_module(&file, &model),
            protection_module(&file, &model),
            drives_module(&file.drives::<N>()),
        )
    });
    // A module's own documentation cannot stand in an included file.
    std::fs::write(folder.join("arm.rs"), arm.replace("//!", "//"))?;
    std::fs::write(folder.join("dynamics.rs"), dynamics.replace("//!", "//"))?;
    std::fs::write(folder.join("drives.rs"), drives.replace("//!", "//"))?;
    std::fs::write(folder.join("protection.rs"), protection.replace("//!", "//"))?;
    std::fs::write(folder.join("tuning.rs"), tuning_module(file.control.tunable))?;
    Ok(())
}

/// Where the controller finds its configuration: in RAM where it can be changed, else in the program.
fn tuning_module(tunable: bool) -> String {
    let (kind, value) = if tunable {
        ("dynamics_core::control::ControllerConfig<f32, { super::arm::N }>", "super::arm::config()")
    } else {
        ("crate::Settings", "crate::Settings")
    };
    format!(
        "/// Where the controller finds its configuration.\npub type Tuning = {kind};\n\n/// Its value.\npub const fn tuning() -> Tuning {{\n    {value}\n}}\n"
    )
}

/// `0x0123_4567_89ab_cdef`.
fn hexadecimal(hash: u64) -> String {
    let part = |shift: u32| (hash >> shift) & 0xffff;
    format!("0x{:04x}_{:04x}_{:04x}_{:04x}", part(48), part(32), part(16), part(0))
}

/// Only what the items use, in rustfmt's order.
fn imports<S: Float, const N: usize>(scene: &Scene<S, N>, config: &ControllerConfig<S, N>, trig: &str) -> String {
    let friction = if config.friction.is_some() { "Friction, " } else { "" };
    let wrench = if matches!(scene.tip_wrench, Term::Constant(_)) { ", Wrench" } else { "" };
    format!(
        "use dynamics_core::control::{{Encoder, {friction}Gains, Guard, Law, TrackingObserver}};\n\
         use dynamics_core::model::{{Link, Placement}};\n\
         use dynamics_core::safety::{{JointRules, Rules, SafeAction}};\n\
         use dynamics_core::trig::{trig};\n\
         use dynamics_core::{{ControllerConfig, Inertia, InertiaBounds, JointKind, Limits, Model, Scene, Term{wrench}}};\n\
         use nalgebra::{{Matrix3, Vector3}};\n"
    )
}

fn vector<S: Float>(v: &Vector3<S>) -> Item {
    call("Vector3::new", v.iter().map(|x| number(*x)).collect())
}

/// Row by row, as `Matrix3::new` takes them.
fn matrix<S: Float>(m: &Matrix3<S>) -> Item {
    call("Matrix3::new", m.transpose().iter().map(|x| number(*x)).collect())
}

fn numbers<S: Float>(all: &[S]) -> Item {
    list(all.iter().map(|x| number(*x)).collect())
}

fn term<T>(term: &Term<T>, constant: impl FnOnce(&T) -> Item) -> Item {
    match term {
        Term::Absent => word("Term::Absent"),
        Term::Constant(value) => call("Term::Constant", vec![constant(value)]),
        Term::Live => word("Term::Live"),
    }
}

fn model_item<S: Float, const N: usize>(model: &Model<S, N>) -> Item {
    let links = model.links().iter().map(|Link { kind, rotation, translation, inertia, rotor, limits }| {
        let kind = match kind {
            JointKind::Revolute => "JointKind::Revolute",
            JointKind::Prismatic => "JointKind::Prismatic",
        };
        record(
            "Link",
            vec![
                ("kind", word(kind)),
                ("rotation", matrix(rotation)),
                ("translation", vector(translation)),
                ("inertia", inertia_item(inertia)),
                ("rotor", number(*rotor)),
                ("limits", limits_item(limits)),
            ],
        )
    });
    let Placement { rotation, translation } = model.tip();
    let tip = record("Placement", vec![("rotation", matrix(rotation)), ("translation", vector(translation))]);
    call("Model::from_checked", vec![list(links.collect()), tip])
}

fn inertia_item<S: Float>(inertia: &Inertia<S>) -> Item {
    let Inertia { mass, first_moment, about_origin } = inertia;
    record(
        "Inertia",
        vec![("mass", number(*mass)), ("first_moment", vector(first_moment)), ("about_origin", matrix(about_origin))],
    )
}

fn wrench_item<S: Float>(Wrench { force, moment }: &Wrench<S>) -> Item {
    record("Wrench", vec![("force", vector(force)), ("moment", vector(moment))])
}

fn limits_item<S: Float>(limits: &Limits<S>) -> Item {
    let Limits { position: (lo, hi), velocity, torque, torque_rate } = limits;
    record(
        "Limits",
        vec![
            ("position", call("", vec![number(*lo), number(*hi)])),
            ("velocity", number(*velocity)),
            ("torque", number(*torque)),
            ("torque_rate", number(*torque_rate)),
        ],
    )
}

fn scene_item<S: Float, const N: usize>(scene: &Scene<S, N>) -> Item {
    let Scene { gravity, payload, tip_wrench, rotor, coriolis } = scene;
    record(
        "Scene",
        vec![
            ("gravity", term(gravity, vector)),
            ("payload", term(payload, inertia_item)),
            ("tip_wrench", term(tip_wrench, wrench_item)),
            ("rotor", term(rotor, |rotor| numbers(rotor))),
            ("coriolis", term(coriolis, |coriolis| numbers(coriolis))),
        ],
    )
}

fn config_item<S: Float, const N: usize>(config: &ControllerConfig<S, N>) -> Item {
    let ControllerConfig { law, gains, friction, limits, torque_step, guard, age_max, encoder, observer } = config;
    let gains = gains.iter().map(|Gains { position, velocity, inertia }| {
        let fields =
            vec![("position", number(*position)), ("velocity", number(*velocity)), ("inertia", number(*inertia))];
        record("Gains", fields)
    });
    let friction = friction.as_ref().map(|all| {
        let one = |Friction { viscous, coulomb, per_smoothing_speed }: &Friction<S>| {
            record(
                "Friction",
                vec![
                    ("viscous", number(*viscous)),
                    ("coulomb", number(*coulomb)),
                    ("per_smoothing_speed", number(*per_smoothing_speed)),
                ],
            )
        };
        call("Some", vec![list(all.iter().map(one).collect())])
    });
    let guard = guard.iter().map(|Guard { position_margin, velocity_max }| {
        let fields = vec![("position_margin", number(*position_margin)), ("velocity_max", number(*velocity_max))];
        record("Guard", fields)
    });
    let encoder = encoder.iter().map(|Encoder { zero, per_count }| {
        record("Encoder", vec![("zero", integer(i64::from(*zero))), ("per_count", number(*per_count))])
    });
    record(
        "ControllerConfig",
        vec![
            ("law", word(&format!("Law::{law:?}"))),
            ("gains", list(gains.collect())),
            ("friction", friction.unwrap_or_else(|| word("None"))),
            ("limits", list(limits.iter().map(limits_item).collect())),
            ("torque_step", numbers(torque_step)),
            ("guard", list(guard.collect())),
            ("age_max", integer(i64::from(*age_max))),
            ("encoder", list(encoder.collect())),
            ("observer", call("TrackingObserver::from_gains", observer.gains().map(number).into())),
        ],
    )
}

fn rules_item<S: Float, const N: usize>(rules: &Rules<S, N>) -> Item {
    let Rules { safe_action, heartbeat_max, hold_max, supply, temperature, period, rate, latency, payload, joints } =
        rules;
    let pair = |(lo, hi): &(S, S)| call("", vec![number(*lo), number(*hi)]);
    let joints = joints.iter().map(|joint| {
        let JointRules { rest_speed, jump_step, resolution, deceleration, reach, reach_speed, damping } = joint;
        record(
            "JointRules",
            vec![
                ("rest_speed", number(*rest_speed)),
                ("jump_step", number(*jump_step)),
                ("resolution", number(*resolution)),
                ("deceleration", number(*deceleration)),
                ("reach", number(*reach)),
                ("reach_speed", number(*reach_speed)),
                ("damping", number(*damping)),
            ],
        )
    });
    record(
        "Rules",
        vec![
            ("safe_action", word(&format!("SafeAction::{safe_action:?}"))),
            ("heartbeat_max", integer(i64::from(*heartbeat_max))),
            ("hold_max", integer(i64::from(*hold_max))),
            ("supply", pair(supply)),
            ("temperature", pair(temperature)),
            ("period", number(*period)),
            ("rate", number(*rate)),
            ("latency", number(*latency)),
            (
                "payload",
                record("InertiaBounds", vec![("mass", number(payload.mass)), ("radius", number(payload.radius))]),
            ),
            ("joints", list(joints.collect())),
        ],
    )
}
