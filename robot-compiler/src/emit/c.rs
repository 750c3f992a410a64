//! The dynamics of an arm in C99: one header and one source without dependencies, bit for bit equal to the Rust core.
//!
//! C compilers fuse a product with a sum unless something forbids it, and each in its own way. The guard at the head of every emitted source tells
//! GCC and Clang, and stops compilers whose settings change floating-point results. `PREFIX_conditions` checks the rest when it runs.

mod arm;
mod files;
mod golden;
mod header;
mod source;
mod trig;

use super::expression::Float;
use crate::describe::diagnostics::Message;
use crate::describe::scene::{ScalarChoice, SceneFile};
use crate::kernel::functions::Springs;
use crate::kernel::{Function, Level, Operations, Precision, Program, compile};
use crate::with_dof;
use arm::Arm;
use dynamics_core::control::ControlLaw;
use dynamics_core::trig::Method;
use dynamics_core::{Model, Trig};

pub use source::kernel_source;

/// Files of a C library, relative to its folder, with their text.
#[derive(Clone, Debug)]
pub struct CLibrary {
    /// Path and text of each file.
    pub files: Vec<(String, String)>,
    /// Operations of one evaluation of the inverse dynamics, without sine and cosine.
    pub operations: Operations,
    /// Prefix of every name in the library.
    pub prefix: String,
}

/// Writes a C library for the arm of a scene, in this scalar.
///
/// | file | content |
/// |---|---|
/// | `src/PREFIX.h`, `src/PREFIX.c` | sine and cosine, inverse dynamics, gravity, mass matrix, forward dynamics, the control law; C99 |
/// | `src/PREFIX.hpp` | the same for C++11, with `std::array` |
/// | `test/golden.c` | torques of eight states, to the last bit |
/// | `CMakeLists.txt`, `library.properties` | for CMake, and for the Arduino tools |
/// | `README.md` | use and cost |
///
/// A scene with the recursion instead of a kernel gets the exact kernel, whose results are equal. Limits, friction, observers, collision detection and
/// the safety state machine are not part of the library.
///
/// # Errors
/// An impossible arm, a motion that is not possible, or a sine and cosine that is not written in C (`table` and `libm`).
// `inline`: compiled for six joint counts by the packages that use it. `newtau run`, which a new user compiles first, does not.
#[inline]
pub fn c_library(file: &SceneFile, scalar: ScalarChoice) -> Result<CLibrary, Box<dyn std::error::Error>> {
    if matches!(file.control.trig, Method::Table | Method::Libm) {
        let (path, name) = (file.path.display(), crate::names::name(file.control.trig));
        return Err(Message(format!(
            "{path}: control.trig = \"{name}\" is not written in C; expected \"polynomial\", \"polynomial5\" or \"polynomial3\""
        ))
        .into());
    }
    with_dof!(file.robot.dof(), N => match scalar {
        ScalarChoice::F32 => of::<f32, N>(file, scalar),
        ScalarChoice::F64 => of::<f64, N>(file, scalar),
    })
}

fn of<S: Float + Into<f64>, const N: usize>(
    file: &SceneFile,
    scalar: ScalarChoice,
) -> Result<CLibrary, Box<dyn std::error::Error>>
where
    Method: Trig<S>,
{
    let model = file.robot.model::<N>()?;
    let arm = Arm {
        prefix: prefix(&file.name),
        file,
        joints: N,
        precision: scalar.precision(),
        live: file.model.live_inputs() > 0,
        kernels: kernels(file, &model, scalar.precision()),
    };
    let prefix = arm.prefix.clone();
    let files = vec![
        (format!("src/{prefix}.h"), header::header(&arm, &model)),
        (format!("src/{prefix}.c"), source::library(&arm)),
        (format!("src/{prefix}.hpp"), header::cpp(&arm)),
        ("test/golden.c".to_owned(), golden::golden::<S, N>(&arm, &model)?),
        ("CMakeLists.txt".to_owned(), files::cmake(&arm)),
        ("library.properties".to_owned(), files::arduino(&arm)),
        ("README.md".to_owned(), files::readme(&arm)),
    ];
    Ok(CLibrary { files, operations: arm.kernels[0].1.operations(), prefix })
}

fn kernels<const N: usize>(file: &SceneFile, model: &Model<f64, N>, precision: Precision) -> Vec<(Function, Program)> {
    let config = file.controller_config(model);
    let law = Function::ComputedTorque(Springs::new(&config.gains));
    let law = (config.law == ControlLaw::ComputedTorque).then_some(law);
    let level = file.control.kernel.level().unwrap_or(Level::Exact);
    [Function::InverseDynamics, Function::MassMatrix, Function::ForwardDynamics]
        .into_iter()
        .chain(law)
        .map(|function| (function, compile(function, model, &file.scene(model), level, precision)))
        .collect()
}

/// A name for C: lower-case letters, digits and single underscores, not starting with a digit. The ending keeps a scene called `math` or `int` apart
/// from headers and keywords.
fn prefix(scene: &str) -> String {
    let clean: String =
        scene.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    let clean: Vec<&str> = clean.split('_').filter(|part| !part.is_empty()).collect();
    let clean = clean.join("_");
    if clean.starts_with(|c: char| c.is_ascii_alphabetic()) { format!("{clean}_arm") } else { format!("arm_{clean}") }
}
