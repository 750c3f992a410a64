//! Tests of the conversion between joint and shaft, in both directions.

use dynamics_core::drive::Gearing;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn joint_to_drive_and_back_is_the_same_value(
        gear in 0.5..200.0_f32, reversed in any::<bool>(), zero in -6.3..6.3_f32, joint in -6.3..6.3_f32,
    ) {
        let ratio = if reversed { -gear } else { gear };
        let gearing = Gearing { ratio, per_ratio: 1.0 / ratio, zero };
        let drive = gearing.drive_position(joint);
        // Rounding of the drive's position, converted to the joint, and three more roundings.
        let bound = (drive.abs() / gear + 3.0 * joint.abs()) * f32::EPSILON;
        prop_assert!((gearing.joint_position(drive) - joint).abs() <= bound);
        let torque = joint * 10.0;
        prop_assert!((gearing.joint_torque(gearing.drive_torque(torque)) - torque).abs() <= 2.0 * f32::EPSILON * torque.abs());
        // Power is the same on both sides.
        let (v, tau_drive) = (drive, gearing.drive_torque(torque));
        let (power, same) = (tau_drive * v, torque * gearing.joint_velocity(v));
        prop_assert!((power - same).abs() <= 4.0 * f32::EPSILON * power.abs());
    }
}

#[test]
fn a_reversed_drive_turns_and_pushes_the_other_way() {
    let gearing = Gearing { ratio: -2.0, per_ratio: -0.5, zero: 1.0 };
    assert_eq!(gearing.drive_position(0.25), 0.5);
    assert_eq!(gearing.joint_position(0.5), 0.25);
    assert_eq!(gearing.joint_velocity(3.0), -1.5);
    assert_eq!(gearing.drive_torque(4.0), -2.0);
}
