//! A URDF as a model: the chain between two links, its joints, and the torques that hold it.
//!
//! ```console
//! $ cargo run -p robot-compiler --example urdf
//! ```

use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use robot_compiler::emit::urdf;
use robot_compiler::{Ends, FileError, Robot};

/// Two links that turn about y. Both point up at zero. The last link, `tip`, is fixed to the forearm.
const URDF: &str = r#"<robot name="two links">
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0 0 0.2"/><mass value="2.0"/>
      <inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.002"/></inertial>
  </link>
  <link name="fore">
    <inertial><origin xyz="0 0 0.15"/><mass value="1.0"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial>
  </link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" effort="20" velocity="3"/>
  </joint>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="tip"/><origin xyz="0 0 0.3"/></joint>
</robot>"#;

/// Torque of each joint that holds the arm at `q` (rad), N m.
fn holding(robot: &Robot, q: [f64; 2]) -> Result<[f64; 2], FileError> {
    let model = robot.model::<2>()?;
    let dynamics = Dynamics::new(model, Scene::with_gravity(robot.gravity(), &model));
    Ok(dynamics.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &[0.0; 2], &[0.0; 2], &Live::zero()))
}

fn main() -> Result<(), FileError> {
    let robot = Robot::from_urdf_str(URDF, "two_links.urdf", Ends::tip("tip"))?;
    println!("{}: {} joints", robot.source, robot.dof());
    for joint in &robot.joints {
        let limits = joint.spec.limits;
        println!("  {:<8} {:?} rad, up to {} N m", joint.name, limits.position, limits.torque);
    }

    let q = [0.5, 0.8];
    let torque = holding(&robot, q)?;
    println!("at {q:?} rad the joints hold {:.3} N m and {:.3} N m", torque[0], torque[1]);
    // A turn about y tips the arm forward, and its weight would turn it further: the torque is negative.
    let elbow = -9.81 * 1.0 * 0.15 * (q[0] + q[1]).sin();
    let shoulder = elbow - 9.81 * (2.0 * 0.2 + 1.0 * 0.4) * q[0].sin();
    assert!((torque[0] - shoulder).abs() < 1e-12 && (torque[1] - elbow).abs() < 1e-12);

    // Written as a URDF again, with made-up shapes for viewers, it is the same arm.
    let written = urdf(&robot);
    let again = Robot::from_urdf_str(&written, "written.urdf", Ends::default())?;
    let repeated = holding(&again, q)?;
    println!("written and read again: {} bytes, {:.3} N m and {:.3} N m", written.len(), repeated[0], repeated[1]);
    assert!((0..2).all(|i| (repeated[i] - torque[i]).abs() < 1e-12));

    // An error names file, line, field and remedy.
    if let Err(error) = Robot::from_urdf_str(URDF, "two_links.urdf", Ends::tip("tool")) {
        println!("{error}; expected {}", error.expected());
    }
    Ok(())
}
