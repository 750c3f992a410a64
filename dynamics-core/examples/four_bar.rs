//! A four-bar linkage over one turn of its crank: follower angle, motor torque and joint force, checked by power and work.
//!
//! ```console
//! $ cargo run -p dynamics-core --example four_bar
//! ```

use dynamics_core::Trig;
use dynamics_core::linkage::{Branch, FourBar, FourBarLengths, Grashof, Linkage, LinkageError, PlanarBody};
use dynamics_core::nalgebra::Vector2;
use dynamics_core::trig::Libm;
use std::f64::consts::TAU;

/// Crank speed, rad/s.
const SPEED: f64 = 10.0;

/// A slender uniform rod of this length (m), 1 kg per metre.
fn rod(length: f64) -> PlanarBody<f64> {
    PlanarBody { mass: length, centre: Vector2::new(0.5 * length, 0.0), inertia: length.powi(3) / 12.0 }
}

fn main() -> Result<(), LinkageError<f64>> {
    let lengths = FourBarLengths { ground: 0.4, crank: 0.1, coupler: 0.35, follower: 0.25 };
    let linkage = FourBar::new(lengths, [rod(lengths.crank), rod(lengths.coupler), rod(lengths.follower)])?;
    println!("{}", linkage.class());
    assert_eq!(linkage.class(), Grashof::CrankRocker);
    assert!(linkage.crank_range().is_full_turn());

    let gravity = Vector2::new(0.0, -9.81);
    let (steps, mut work) = (3600, 0.0);
    println!("crank (deg)  follower (deg)  motor (N m)  force on the crank (N)");
    for step in 0..steps {
        let angle = TAU * f64::from(step) / f64::from(steps);
        let posture = linkage.posture(&Libm.sin_cos(angle), Branch::Open)?;
        // Derivatives of all positions by the crank's angle, then the motion at constant crank speed.
        let motion = posture.coefficients()?.map(|link| link.motion(SPEED, 0.0));
        let forces = posture.forces(&motion, &gravity)?;

        // Power of the motor: it accelerates the links and lifts them.
        let power: f64 = posture
            .links
            .iter()
            .zip(&motion)
            .map(|(link, motion)| {
                let linear = (motion.acceleration - gravity).dot(&motion.velocity) * link.mass;
                linear + link.inertia * motion.alpha * motion.omega
            })
            .sum();
        assert!((forces.driving_moment * SPEED - power).abs() < 1e-9);
        work += forces.driving_moment * TAU / f64::from(steps);

        if step % 600 == 0 {
            let follower = posture.links[2].direction;
            println!(
                "{:11.0}  {:14.2}  {:11.4}  {:22.3}",
                angle.to_degrees(),
                follower.y.atan2(follower.x).to_degrees(),
                forces.driving_moment,
                forces.joints[0].norm()
            );
            // The loop closes: coupler and follower meet in one point, at their own lengths.
            assert!(((posture.links[2].outer - posture.links[1].outer).norm() - lengths.follower).abs() < 1e-14);
        }
    }
    println!("work of a whole turn: {work:.1e} J");
    // Nothing dissipates energy, so the motor does no work over a turn.
    assert!(work.abs() < 1e-9);
    Ok(())
}
