//! Friction feedforward: odd, smooth, and equal to the Coulomb and viscous torque beyond its smoothing speed.

use crate::control::support::{Desk, UnitMasses, config, driven, measured};
use dynamics_core::control::{ControlLaw, Friction};
use dynamics_core::{Controller, Reference};

const FRICTION: Friction<f64> = Friction { viscous: 0.7, coulomb: 3.0, per_smoothing_speed: 1.0 / 0.05 };

fn speeds() -> impl Iterator<Item = f64> {
    (-2000..=2000).map(|i| f64::from(i) * 1e-4)
}

#[test]
fn friction_is_odd_to_the_bit_and_zero_at_rest() {
    for qd in speeds() {
        assert_eq!(FRICTION.torque(-qd), -FRICTION.torque(qd));
    }
    assert_eq!(FRICTION.torque(0.0), 0.0);
}

#[test]
fn beyond_the_smoothing_speed_friction_is_coulomb_plus_viscous_and_within_it_the_cubic() {
    for qd in speeds() {
        let x = qd / 0.05;
        let sign = if x.abs() < 1.0 { 1.5 * x - 0.5 * x.powi(3) } else { x.signum() };
        let expected = 0.7 * qd + 3.0 * sign;
        assert!((FRICTION.torque(qd) - expected).abs() < 1e-14, "at {qd}");
    }
}

#[test]
fn the_slope_of_friction_is_continuous_and_never_negative() {
    let h = 1e-6;
    let slope = |qd: f64| (FRICTION.torque(qd + h) - FRICTION.torque(qd - h)) / (2.0 * h);
    // The second derivative is 3 c / v^2 at most, so slopes 1e-4 apart differ by no more than that times 1e-4.
    let steepest = 3.0 * 3.0 / (0.05 * 0.05);
    for qd in speeds() {
        let change = slope(qd + 1e-4) - slope(qd);
        assert!(change.abs() <= steepest * 1.0001e-4, "slope jumps by {change} at {qd}");
        assert!(slope(qd) >= 0.7 - 1e-6);
    }
    // A hard sign function fails this test by a large margin: its slope jumps by c / h.
    let hard = |qd: f64| if qd > 0.0 { 3.0 } else { -3.0 };
    assert!((hard(h) - hard(-h)) / (2.0 * h) > 1000.0 * steepest * 1e-4);
}

#[test]
fn the_controller_adds_friction_of_the_reference_velocity_to_every_law() {
    let reference = Reference { q: [0.1], qd: [0.4], qdd: [0.2] };
    // A hand-guided arm has no reference to follow.
    for law in ControlLaw::ALL.into_iter().filter(|law| *law != ControlLaw::Teach) {
        let plain = config::<1>(law);
        let mut with = plain;
        with.friction = Some([FRICTION]);
        let torque = |config| {
            // The measured velocity is different: friction must not follow it.
            driven(Controller::new(config, UnitMasses::default(), Desk).tick(&reference, &measured([0.1], [-0.3]))).0[0]
        };
        let added = torque(with) - torque(plain);
        assert!((added - FRICTION.torque(0.4)).abs() < 1e-12, "{law:?} adds {added}");
    }
}

#[test]
fn no_torque_is_minus_zero() {
    let reference = Reference { q: [-0.0], qd: [-0.0], qdd: [-0.0] };
    // The friction of -0 is -0, the torque of the law is -0, and so is their sum.
    assert_eq!(FRICTION.torque(-0.0).to_bits(), (-0.0_f64).to_bits());
    for friction in [None, Some([FRICTION])] {
        let settings = dynamics_core::ControllerConfig { friction, ..config(ControlLaw::ComputedTorque) };
        let mut controller = Controller::new(settings, UnitMasses::default(), Desk);
        let (torque, _) = driven(controller.tick(&reference, &measured([0.0], [0.0])));
        assert_eq!(torque[0].to_bits(), 0, "{friction:?}");
    }
}

#[test]
fn a_number_is_saturated_at_a_bound_of_its_sign_and_as_it_is_inside() {
    use dynamics_core::Real;
    let ends =
        [0.0, f32::MIN_POSITIVE, 1e-40, 0.5, 1.0_f32.next_down(), 1.0, 1.0_f32.next_up(), f32::MAX, f32::INFINITY];
    for x in ends.into_iter().flat_map(|x| [x, -x]) {
        assert_eq!(x.saturated(1.0).to_bits(), x.clamp(-1.0, 1.0).to_bits(), "{x}");
        let x = f64::from(x);
        assert_eq!(x.saturated(1.0).to_bits(), x.clamp(-1.0, 1.0).to_bits(), "{x}");
    }
    // The friction of NaN is still NaN.
    assert!(FRICTION.torque(f64::NAN).is_nan());
}
