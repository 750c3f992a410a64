//! Feedforward of viscous and Coulomb friction: its curve, and a joint that it keeps at constant speed.
//!
//! ```console
//! $ cargo run -p dynamics-core --example friction
//! ```

use dynamics_core::control::{Friction, FrictionTerms, Rise};

/// Moment of inertia that the joint moves, kg m^2.
const INERTIA: f64 = 0.2;

fn main() {
    // Below 0.05 rad/s the Coulomb torque fades, so the torque does not jump when the joint turns back.
    let smoothing_speed = 0.05;
    let friction = Friction { viscous: 0.8, coulomb: 2.5, per_smoothing_speed: 1.0 / smoothing_speed };
    // Stribeck: near rest the joint needs 0.7 N m more; at 0.2 rad/s, 1/e of this is left.
    let terms = FrictionTerms { rise: Some(Rise { torque: 0.7, per_speed: 1.0 / 0.2 }), ..FrictionTerms::NONE };

    println!("   rad/s  friction (N m)  with Stribeck's rise (N m)");
    for speed in [-1.0_f64, -0.05, 0.0, 0.01, 0.025, 0.05, 0.1, 0.2, 1.0] {
        let (plain, stribeck) = (friction.torque(speed), friction.torque_with(&terms, speed, 0.0));
        println!("{speed:8.3}  {plain:14.4}  {stribeck:14.4}");
        // An odd function, zero at rest.
        assert!((plain + friction.torque(-speed)).abs() < 1e-12);
        // Above the smoothing speed it is `b qd + c`.
        if speed >= smoothing_speed {
            assert!((plain - (0.8 * speed + 2.5)).abs() < 1e-12);
            let bell = 0.7 * (-(speed / 0.2).powi(2)).exp();
            assert!((stribeck - plain - bell).abs() < 0.7 * 6e-4);
        }
        assert!(stribeck.abs() <= terms.bound(&friction, speed));
    }

    // A joint that starts at 1 rad/s, with this friction and no other load, for 1 s.
    let run = |compensated: bool| {
        let (mut speed, step) = (1.0_f64, 1e-3);
        for _ in 0..1000 {
            let torque = if compensated { friction.torque(1.0) } else { 0.0 };
            speed += step * (torque - friction.torque(speed)) / INERTIA;
        }
        speed
    };
    let (with, without) = (run(true), run(false));
    println!("speed after 1 s: {with:.3} rad/s with feedforward, {without:.3} rad/s without");
    assert!((with - 1.0).abs() < 1e-12 && without.abs() < 1e-3);
}
