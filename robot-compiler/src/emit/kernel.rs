//! A program as Rust that a person can read: `no_std`, without `unsafe`, as rustfmt leaves it.

use super::expression::{Item, list, record, word};
use crate::kernel::functions::{argument, live_inputs};
use crate::kernel::{Function, Level, Precision, Program, compile};
use dynamics_core::{Model, Scene, Term};
use std::collections::HashSet;

mod writer;

use writer::Writer;

/// What the head of the text says.
#[derive(Clone, Copy, Debug)]
pub struct Title<'a> {
    /// The robot.
    pub robot: &'a str,
    /// The scene.
    pub scene: &'a str,
    /// Hash of everything that decides the bits of a tick; see [`crate::SceneFile::hash`].
    pub hash: u64,
}

/// Rust source of a module that computes a function of an arm in a scene.
///
/// | function | item |
/// |---|---|
/// | inverse dynamics | `Kernel`, a type that implements `InverseDynamics<S, N>` |
/// | momentum | `Kernel`, a type that implements `GeneralizedMomentum<S, N>` |
/// | any other | `fn NAME(turn, q, qd, qdd, live) -> [S; M]`, with the arguments that it reads |
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

/// As [`module`], of a program that was compiled from these before.
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

/// As [`module`], for every scalar: one text runs on `f64` and on lanes of them, with the same bits in every lane.
///
/// | function | item |
/// |---|---|
/// | inverse dynamics | `Kernel`, a type that implements `InverseDynamics<S, N>` for every `S: Scalar` |
/// | momentum | `Kernel`, a type that implements `GeneralizedMomentum<S, N>` for every `S: Scalar` |
/// | any other | `fn NAME<S: Scalar>(turn, q, qd, qdd, live) -> [S; M]`, with the arguments that it reads |
///
/// What divides asks for `S: Field`.
///
/// Numbers are folded in `precision` and read through `Scalar::literal`: the bits are the recursion's where the scalar
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

/// What a text is written for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scalars {
    /// The float in which its numbers were folded.
    One,
    /// Every `S: Scalar`.
    Every,
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
        | Function::ComputedTorque(_) => text.function(),
    };
    head + &item
}

/// What the text is made from.
struct Text<'a> {
    function: Function,
    program: &'a Program,
    joints: usize,
    precision: Precision,
    title: &'a Title<'a>,
    scalars: Scalars,
}

/// A trait of one function that a kernel implements.
struct Trait {
    /// Its name.
    name: &'static str,
    /// Where it is, if not at the root of `dynamics_core`, and what stands there beside it.
    module: Option<(&'static str, &'static str)>,
    /// The function.
    function: &'static str,
    arguments: &'static [&'static str],
    /// The type of the result, for a scalar and so many joints.
    result: fn(&str, usize) -> String,
    /// The result, from the outputs.
    value: fn(Vec<Item>) -> Item,
}

const INVERSE_DYNAMICS: Trait = Trait {
    name: "InverseDynamics",
    module: None,
    function: "inverse_dynamics",
    arguments: &["turn", "q", "qd", "qdd", "live"],
    result: |real, joints| format!("[{real}; {joints}]"),
    value: list,
};

const MOMENTUM: Trait = Trait {
    name: "GeneralizedMomentum",
    module: Some(("momentum", "Momentum")),
    function: "momentum",
    arguments: &["turn", "q", "qd", "live"],
    result: |real, joints| format!("Momentum<{real}, {joints}>"),
    value: |mut momentum| {
        let rate = momentum.split_off(momentum.len() / 2);
        record("Momentum", vec![("momentum", list(momentum)), ("rate", list(rate))])
    },
};

/// The arguments in their order.
const ARGUMENTS: [&str; 6] = ["turn", "q", "qd", "qdd", "tau", "live"];

impl Text<'_> {
    /// The float in which numbers were folded.
    fn folded(&self) -> &'static str {
        self.precision.name()
    }

    /// The scalar of the arguments and results.
    fn real(&self) -> &'static str {
        match self.scalars {
            Scalars::One => self.folded(),
            Scalars::Every => "S",
        }
    }

    fn divides(&self) -> bool {
        self.program.operations().div > 0
    }

    /// What declares the scalar.
    fn parameters(&self) -> &'static str {
        match self.scalars {
            Scalars::One => "",
            Scalars::Every if self.divides() => "<S: Field>",
            Scalars::Every => "<S: Scalar>",
        }
    }

    /// What the text names of `dynamics_core`, in rustfmt's order.
    fn imports(&self, names: &[&str]) -> String {
        let scalar = match self.scalars {
            Scalars::One => None,
            Scalars::Every if self.divides() => Some("Field"),
            Scalars::Every => Some("Scalar"),
        };
        let mut names: Vec<&str> = names.iter().copied().chain(scalar).collect();
        names.sort_unstable();
        match names.as_slice() {
            [] => String::new(),
            [one] => format!("use dynamics_core::{one};\n\n"),
            several => format!("use dynamics_core::{{{}}};\n\n", several.join(", ")),
        }
    }

    /// The arguments that the program reads.
    fn read(&self) -> HashSet<&'static str> {
        self.program.inputs().iter().map(|&number| argument(number, self.joints)).collect()
    }

    fn kind(&self, name: &str) -> String {
        let (real, joints) = (self.real(), self.joints);
        match name {
            "turn" => format!("&[SinCos<{real}>; {joints}]"),
            "live" => format!("&Live<{real}, {joints}>"),
            "reference" => format!("&Reference<{real}, {joints}>"),
            _ => format!("&[{real}; {joints}]"),
        }
    }

    fn head<const N: usize>(&self, scene: &Scene<f64, N>, level: Level) -> String {
        let operations = self.program.operations();
        let scalars = match self.scalars {
            Scalars::One => self.folded().to_owned(),
            Scalars::Every => format!("any scalar, numbers folded in {}", self.folded()),
        };
        // Only forward dynamics divides.
        let (div_head, div_rule, div) = match operations.div {
            0 => ("", "", String::new()),
            div => (" div |", "---|", format!(" {div} |")),
        };
        format!(
            "//! {} of {} in the scene {}: level {}, {}.\n//!\n\
             //! Generated by running the generic recursion once on a scalar that writes down what is done to it. Do not edit.\n//!\n\
             //! | source hash | mul | add | sub |{div_head} neg | live inputs | values alive at most |\n//! |---|---|---|---|{div_rule}---|---|---|\n\
             //! | {:016x} | {} | {} | {} |{div} {} | {} | {} |\n//!\n\
             //! | gravity | payload | tip wrench | rotors | velocity terms |\n//! |---|---|---|---|---|\n\
             //! | {} | {} | {} | {} | {} |\n\n",
            name(self.function),
            self.title.robot,
            self.title.scene,
            level.name(),
            scalars,
            self.title.hash,
            operations.mul,
            operations.add,
            operations.sub,
            operations.neg,
            live_inputs(self.program, N),
            self.program.live_max(),
            presence(&scene.gravity),
            presence(&scene.payload),
            presence(&scene.tip_wrench),
            presence(&scene.rotor),
            presence(&scene.coriolis),
        )
    }

    /// The body of a function that makes `value` of the outputs, indented by `indent`.
    fn body(&self, indent: usize, value: fn(Vec<Item>) -> Item) -> String {
        let hoisted = self.scalars == Scalars::Every;
        let writer = Writer::new(self.program, self.joints, self.precision, hoisted);
        let pad = " ".repeat(indent);
        let outputs = value(self.program.outputs().iter().map(|&e| word(&writer.value(e))).collect());
        format!("{}{pad}{}\n", writer.statements(&pad), outputs.print(indent))
    }

    fn kernel(&self, implemented: &Trait) -> String {
        let (read, real, joints) = (self.read(), self.real(), self.joints);
        let Trait { name, module, function, arguments, result, value } = implemented;
        let mut text = match module {
            None => self.imports(&[name, "Live", "SinCos"]),
            Some((module, beside)) => {
                format!("use dynamics_core::{module}::{{{name}, {beside}}};\n") + &self.imports(&["Live", "SinCos"])
            }
        };
        text +=
            &format!("/// {} of {} in the scene {}.\n", self::name(self.function), self.title.robot, self.title.scene);
        text += "#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]\npub struct Kernel;\n\n";
        text += &format!("impl{} {name}<{real}, {joints}> for Kernel {{\n    #[inline]\n", self.parameters());
        let named = arguments.iter().map(|&name| {
            let unread = if read.contains(name) { "" } else { "_" };
            format!("{unread}{name}: {}", self.kind(name))
        });
        let parameters: Vec<String> = std::iter::once("&self".to_owned()).chain(named).collect();
        let signature = signature(4, &format!("fn {function}"), &parameters, &result(real, joints));
        text + &format!("{signature}{}    }}\n}}\n", self.body(8, *value))
    }

    fn function(&self) -> String {
        let read = self.read();
        let arguments: Vec<&str> =
            ARGUMENTS.into_iter().chain(["reference"]).filter(|name| read.contains(name)).collect();
        let types = [("live", "Live"), ("reference", "Reference"), ("turn", "SinCos")];
        let named: Vec<&str> =
            types.into_iter().filter(|(name, _)| read.contains(name)).map(|(_, kind)| kind).collect();
        let imports = self.imports(&named);
        let rust_name = self.function.name().replace('-', "_") + self.parameters();
        let result = format!("[{}; {}]", self.real(), self.program.outputs().len());
        let parameters: Vec<String> = arguments.iter().map(|name| format!("{name}: {}", self.kind(name))).collect();
        let signature = signature(0, &format!("pub fn {rust_name}"), &parameters, &result);
        format!(
            "{imports}{}#[inline]\n#[must_use]\n{signature}{}}}\n",
            documentation(self.function, self.title),
            self.body(4, list)
        )
    }
}

/// The head of a function, indented, on one line where it fits.
fn signature(indent: usize, function: &str, parameters: &[String], result: &str) -> String {
    let pad = " ".repeat(indent);
    let flat = format!("{pad}{function}({}) -> {result} {{\n", parameters.join(", "));
    if flat.trim_end().len() <= 120 {
        return flat;
    }
    let parameters = parameters.join(&format!(",\n{pad}    "));
    format!("{pad}{function}(\n{pad}    {parameters},\n{pad}) -> {result} {{\n")
}

/// What it is called in a sentence.
const fn name(function: Function) -> &'static str {
    match function {
        Function::InverseDynamics => "Inverse dynamics",
        Function::Gravity => "Gravity torques",
        Function::Coriolis => "Velocity torques",
        Function::MassMatrix => "Mass matrix",
        Function::JointWrenches => "Joint wrenches",
        Function::Momentum => "Generalised momentum",
        Function::ForwardDynamics => "Forward dynamics",
        Function::ComputedTorque(_) => "Computed torque",
    }
}

/// Equation, order of the outputs and units.
fn documentation(function: Function, title: &Title<'_>) -> String {
    let meaning = match function {
        Function::InverseDynamics => "`tau = D(q) qdd + C(q, qd) qd + G(q) - J^T w`, one per joint, N m or N.",
        Function::Gravity => "`G(q)`, what holds the arm still: one per joint, N m or N.",
        Function::Coriolis => "`C(q, qd) qd`: one per joint, N m or N.",
        Function::MassMatrix => {
            "`D(q)`, the upper triangle row by row, `D[0][0], D[0][1], ..`: kg m^2, kg m or kg, with the rotors."
        }
        Function::JointWrenches => {
            "What each link exerts on the next, base first, `fx, fy, fz, mx, my, mz` in the frame of the next link, about its\n\
             /// joint's origin: N and N m."
        }
        Function::Momentum => {
            "`p = D(q) qd`, one per joint, kg m^2/s or kg m/s; then `C(q, qd)^T qd - G(q) + J^T w`, one per joint, N m or N."
        }
        Function::ForwardDynamics => {
            "`qdd = D(q)^-1 (tau - C(q, qd) qd - G(q) + J^T w)`, one per joint, rad/s^2 or m/s^2; then the inertia that each joint\n\
             /// feels with the joints beyond it free, kg m^2 or kg. One of these that is not above zero says that `D` cannot be\n\
             /// inverted: the accelerations, finite or not, then mean nothing."
        }
        Function::ComputedTorque(_) => {
            "`tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`, before friction and limits: one per joint, N m or N."
        }
    };
    format!("/// {} of {} in the scene {}.\n///\n/// {meaning}\n", name(function), title.robot, title.scene)
}

fn presence<T>(term: &Term<T>) -> &'static str {
    match term {
        Term::Absent => "absent",
        Term::Constant(_) => "constant",
        Term::Live => "live",
    }
}
