//! Writes the measured kernels as modules, and each arm's numbers for the chip.

#[path = "../xtask/src/bench/plain.rs"]
#[allow(unreachable_pub, reason = "a module of the library, read here too")]
mod plain;

use robot_compiler::emit::arm_module;
use robot_compiler::emit::modules::Modules;
use robot_compiler::kernel::{Function, Level, Precision};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=../robots");
    let mut modules = Modules::new(PathBuf::from(std::env::var("OUT_DIR")?));
    for arm in plain::ARMS {
        let scene = plain::scene(arm)?;
        modules.module(&format!("{arm}_arm"), &arm_module(&scene, &scene.robot.model::<6>()?))?;
        modules.generic_kernel(&scene, Function::InverseDynamics, Level::Regrouped)?;
        modules.kernel(&scene, Function::ForwardDynamics, Level::Regrouped, Precision::Double)?;
        for precision in [Precision::Single, Precision::Double] {
            for level in Level::ALL {
                for function in [Function::InverseDynamics, Function::Gravity, Function::MassMatrix] {
                    modules.kernel(&scene, function, level, precision)?;
                }
            }
        }
    }
    modules.finish("")
}
