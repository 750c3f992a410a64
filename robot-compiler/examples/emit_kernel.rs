//! From a robot file to Rust source: the inverse dynamics of one arm as straight-line code, and its operation count.
//!
//! ```console
//! $ cargo run -p robot-compiler --example emit_kernel
//! ```

use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use robot_compiler::emit::kernel::{Title, module_of};
use robot_compiler::kernel::inputs::input_values;
use robot_compiler::kernel::{Function, Level, Precision, compile};
use robot_compiler::{FileError, Robot};

const ROBOT: &str = r#"
name = "planar"
source = "two slender rods"

[[joint]]
name = "shoulder"
type = "revolute"
dh = { a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 2.0
com = [-0.5, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.167, zz = 0.167 }

[[joint]]
name = "elbow"
type = "revolute"
dh = { a = 0.8, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 1.5
com = [-0.4, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.08, zz = 0.08 }
"#;

fn main() -> Result<(), FileError> {
    let robot = Robot::from_toml_str(ROBOT, "planar.toml")?;
    // The joint count is a type parameter; `with_dof!` chooses it at run time.
    let model = robot.model::<2>()?;
    // The arm swings in a vertical plane: gravity acts along -y of the base, m/s^2.
    let scene = Scene::with_gravity([0.0, -9.81, 0.0].into(), &model);

    let (function, precision) = (Function::InverseDynamics, Precision::Double);
    let exact = compile(function, &model, &scene, Level::Exact, precision);
    let fewest = compile(function, &model, &scene, Level::Regrouped, precision);

    let title = Title { robot: &robot.name, scene: "vertical plane", hash: 0 };
    let source = module_of(&fewest, function, &scene, Level::Regrouped, precision, &title);
    let lines: Vec<&str> = source.lines().collect();
    println!("{}\n... {} lines\n", lines[..24.min(lines.len())].join("\n"), lines.len());

    for (level, program) in [(Level::Exact, &exact), (Level::Regrouped, &fewest)] {
        let count = program.operations();
        println!("{:<10} {} multiplications, {} in all", level.name(), count.mul, count.total());
    }
    assert!(fewest.operations().total() < exact.operations().total());

    // Both programs against the recursion from which they were traced, N m.
    let (q, qd, qdd, live) = ([0.3, 0.7], [1.0, -2.0], [0.5, 0.1], Live::zero());
    let turn = Libm.sin_cos_all(&q);
    let inputs = input_values(&turn, &q, &qd, &qdd, &live);
    let torque = Dynamics::new(model, scene).inverse_dynamics(&turn, &q, &qd, &qdd, &live);
    println!("torque     {:.4} N m, {:.4} N m", torque[0], torque[1]);
    assert_eq!(exact.evaluate(&inputs), torque, "level exact gives the same bits");
    for (ours, theirs) in fewest.evaluate(&inputs).iter().zip(&torque) {
        assert!((ours - theirs).abs() < 1e-12, "level regrouped differs by {} N m", ours - theirs);
    }
    Ok(())
}
