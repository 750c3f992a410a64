//! Source of the kernels that are counted on the chip, and their list.
//!
//! Each kernel is in a separate module, so that it has one caller and is inlined into it, as in the firmware.

use dynamics_core::{Body, Model, Scene, Term};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::SceneFile;
use robot_compiler::emit::arm_module;
use robot_compiler::emit::kernel::{Title, module_of};
use robot_compiler::emit::modules::Modules;
use robot_compiler::kernel::inputs::{argument, live_inputs};
use robot_compiler::kernel::{Function, Level, Precision, compile};
use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;

#[allow(unreachable_pub, reason = "a public module of the package that measures on the desk, which reads it too")]
#[path = "plain.rs"]
mod plain;

/// Writes the kernels and their list into a folder.
pub(crate) fn write(folder: PathBuf) -> Result<(), Box<dyn Error>> {
    let mut cases = Cases { modules: Modules::new(folder), functions: String::new(), list: Vec::new() };
    for name in plain::ARMS {
        let file = plain::scene(name)?;
        let arm = Arm { model: file.robot.model()?, file };
        cases.modules.module(&format!("{name}_arm"), &arm_module(&arm.file, &arm.model))?;
        let plain = arm.file.scene(&arm.model);
        for level in Level::ALL {
            let label = level.name();
            let dynamics = Function::InverseDynamics;
            cases.add(&arm, &plain, dynamics, level, &format!("{name}_{label}"))?;
            cases.add(&arm, &plain, dynamics, level, &format!("{name}_{label}{WITH_TRIG}"))?;
            cases.add(&arm, &plain, dynamics, level, &format!("{name}_{label}{AS_TRACED}"))?;
            cases.add(&arm, &plain, Function::Gravity, level, &format!("{name}_gravity_{label}"))?;
            cases.add(&arm, &plain, Function::MassMatrix, level, &format!("{name}_mass_matrix_{label}"))?;
        }
        for (term, scene) in without_each(&everything(&arm)) {
            let name = format!("{name}_terms_{term}");
            cases.add(&arm, &scene, Function::InverseDynamics, Level::Regrouped, &name)?;
        }
    }
    let Cases { modules, functions, list, .. } = cases;
    let count = list.len();
    modules.finish(&format!(
        "{functions}\n/// Every kernel.\npub(crate) const KERNELS: [Case; {count}] = [\n{}];\n",
        list.concat()
    ))
}

/// Suffix for kernels that compute sine and cosine too.
const WITH_TRIG: &str = "_with_trig";
/// Suffix for kernels with their statements in traced order.
const AS_TRACED: &str = "_as_traced";

struct Arm {
    file: SceneFile,
    model: Model<f64, 6>,
}

/// A scene with every term: gravity, rotors, a payload, a live wrench at the tip, velocity terms.
fn everything(arm: &Arm) -> Scene<f64, 6> {
    let payload = Body {
        mass: 2.0,
        com: Vector3::new(0.02, -0.01, 0.05),
        inertia: Matrix3::new(4e-3, 1e-4, -2e-4, 1e-4, 5e-3, 3e-4, -2e-4, 3e-4, 3e-3),
    };
    let mut file = arm.file.clone();
    file.model.rotor = Term::Constant(());
    file.model.payload = Term::Constant(payload);
    file.model.tip_wrench = Term::Live;
    file.scene(&arm.model)
}

/// The scene, and the scene without each of its terms.
fn without_each(all: &Scene<f64, 6>) -> [(&'static str, Scene<f64, 6>); 6] {
    [
        ("all", *all),
        ("gravity", Scene { gravity: Term::Absent, ..*all }),
        ("payload", Scene { payload: Term::Absent, ..*all }),
        ("tip_wrench", Scene { tip_wrench: Term::Absent, ..*all }),
        ("rotors", Scene { rotor: Term::Absent, ..*all }),
        ("velocity", Scene { coriolis: Term::Absent, ..*all }),
    ]
}

struct Cases {
    modules: Modules,
    functions: String,
    list: Vec<String>,
}

impl Cases {
    fn add(
        &mut self,
        arm: &Arm,
        scene: &Scene<f64, 6>,
        function: Function,
        level: Level,
        name: &str,
    ) -> Result<(), Box<dyn Error>> {
        let Arm { file, model } = arm;
        let precision = Precision::Single;
        let title = Title { robot: &file.robot.name, scene: name, hash: file.hash(model) };
        let scheduled = compile(function, model, scene, level, precision);
        let program = if name.ends_with(AS_TRACED) { scheduled.as_traced() } else { scheduled };
        self.modules.module(name, &module_of(&program, function, scene, level, precision, &title))?;
        let turn = if name.ends_with(WITH_TRIG) { "Polynomial.sin_cos_all(&i.q)" } else { "i.turn" };
        let call = if function == Function::InverseDynamics {
            format!("Kernel.inverse_dynamics(&{turn}, &i.q, &i.qd, &i.qdd, &i.live)")
        } else {
            let read: Vec<&str> = program.inputs().iter().map(|&number| argument(number, 6)).collect();
            let arguments: Vec<String> = ["turn", "q", "qd", "qdd", "live"]
                .into_iter()
                .filter(|name| read.contains(name))
                .map(|name| format!("&i.{name}"))
                .collect();
            format!("{}({})", function.name().replace('-', "_"), arguments.join(", "))
        };
        writeln!(
            self.functions,
            "#[inline(never)]\nfn run_{name}(i: &Inputs, out: &mut Outputs) {{\n    put({name}::{call}, out);\n}}"
        )?;
        let n = program.operations();
        let work = [n.total(), n.neg, live_inputs(&program, 6), program.live_max()];
        self.list.push(format!("    Case {{ name: {name:?}, run: run_{name}, work: {work:?} }},\n"));
        Ok(())
    }
}
