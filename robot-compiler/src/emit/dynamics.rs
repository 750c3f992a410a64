//! The arm's inverse dynamics.

use super::fields::item;
use super::kernel::{Title, module};
use crate::describe::scene::{ControlSpec, ScalarChoice, SceneFile};
use crate::kernel::{Function, Precision};
use dynamics_core::Model;

impl ScalarChoice {
    /// Precision of the kernels for this scalar.
    #[must_use]
    pub const fn precision(self) -> Precision {
        match self {
            Self::F32 => Precision::Single,
            Self::F64 => Precision::Double,
        }
    }
}

/// Rust source of a module with the arm's inverse dynamics, for use together with [`arm_module`](super::arm_module).
///
/// | item | meaning |
/// |---|---|
/// | `Arm` | a type that implements `InverseDynamics<f32, N>`: the scene's kernel or the recursion, in the ticks that the scene sets |
/// | `arm()` | its value |
#[must_use]
pub fn dynamics_module<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    dynamics_module_in(file, model, ScalarChoice::F32)
}

/// As [`dynamics_module`], with another scalar than `f32`.
#[must_use]
pub fn dynamics_module_in<const N: usize>(file: &SceneFile, model: &Model<f64, N>, scalar: ScalarChoice) -> String {
    let precision = scalar.precision();
    let (text, inner) = match file.control.kernel.level() {
        None => (
            "//! The recursion itself, with the model at run time.\n\nuse dynamics_core::Dynamics;\n".to_owned(),
            Inner {
                kind: format!("Dynamics<{}, {N}>", precision.name()),
                value: "Dynamics::new(super::arm::model(), super::arm::scene())".to_owned(),
                constant: false,
            },
        ),
        Some(level) => {
            let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(model) };
            let (function, scene) = (Function::InverseDynamics, file.scene(model));
            let kernel = module(function, model, &scene, level, precision, &title);
            (kernel, Inner { kind: "Kernel".to_owned(), value: "Kernel".to_owned(), constant: true })
        }
    };
    match file.friction_terms::<N>() {
        None => text + "\n" + &arm_items::<N>(file, inner, precision.name()),
        Some(terms) => {
            let terms = match scalar {
                ScalarChoice::F32 => item(&terms.map(|terms| terms.cast::<f32>())),
                ScalarChoice::F64 => item(&terms.map(|terms| terms.cast::<f64>())),
            };
            let items = arm_items::<N>(file, inner, precision.name());
            // Imported under another name inside, because `Arm` is the outer type.
            let items = items
                .replace("pub type Arm ", "type Frictionless ")
                .replace("fn arm() -> Arm", "fn frictionless() -> Frictionless");
            let items = items.replace("pub const fn", "const fn").replace("pub fn", "fn");
            text + "\n" + &items + "\n" + &with_friction(N, precision.name(), &terms.print(8))
        }
    }
}

/// The type `Arm` of an arm with friction terms beyond viscous and Coulomb friction. The terms are constants of the program.
fn with_friction(joints: usize, real: &str, terms: &str) -> String {
    let call = |name: &str, turn: &str, this: &str| {
        format!(
            "    #[inline]\n    fn {name}(\n        {this},\n        turn: {turn},\n        q: &[{real}; {joints}],\n        \
             qd: &[{real}; {joints}],\n        qdd: &[{real}; {joints}],\n        live: &dynamics_core::Live<{real}, {joints}>,\n    \
             ) -> [{real}; {joints}] {{\n        self.0.{name}(turn, q, qd, qdd, live)\n    }}\n\n"
        )
    };
    let sines = format!("[dynamics_core::SinCos<{real}>; {joints}]");
    format!(
        "/// The arm's inverse dynamics, and the terms of its friction.\n#[derive(Clone, Copy, Debug, PartialEq)]\n\
         pub struct Arm(Frictionless);\n\nimpl dynamics_core::InverseDynamics<{real}, {joints}> for Arm {{\n{}{}    \
         #[inline]\n    fn forget(&mut self) {{\n        \
         dynamics_core::InverseDynamics::<{real}, {joints}>::forget(&mut self.0);\n    }}\n\n    #[inline]\n    \
         fn friction_terms(&self) -> Option<&[dynamics_core::control::FrictionTerms<{real}>; {joints}]> {{\n        \
         #[allow(unused_imports, reason = \"what any arm may need\")]\n        \
         use dynamics_core::control::{{FrictionTerms, LoadGrowth, Rise}};\n        \
         Some(const {{ &{terms} }})\n    }}\n}}\n\n/// The arm's inverse dynamics.\npub fn arm() -> Arm {{\n    \
         Arm(frictionless())\n}}\n",
        call("inverse_dynamics", &format!("&{sines}"), "&self"),
        call("tick", &format!("impl FnOnce() -> {sines}"), "&mut self"),
    )
    // Methods of the trait are called by path, because the recursion's module does not import it.
    .replace("self.0.inverse_dynamics(", "dynamics_core::InverseDynamics::inverse_dynamics(&self.0, ")
    .replace("self.0.tick(", "dynamics_core::InverseDynamics::tick(&mut self.0, ")
}

/// The dynamics of an emitted module: its type, its value, and whether a `const fn` can return it.
struct Inner {
    kind: String,
    value: String,
    constant: bool,
}

/// `Arm` and `arm()`: the inner dynamics themselves. If the scene evaluates its model only in some ticks, they are
/// wrapped in [`dynamics_core::control::EveryNth`].
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
