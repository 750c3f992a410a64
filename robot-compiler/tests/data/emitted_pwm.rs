//! Generated from a robot and a scene file. Do not edit: change the files instead.

use dynamics_core::drive::{Drives, Gearing, PwmDrive};

/// Drives of the joints.
pub const fn drives() -> Drives<2> {
    Drives::Pwm([
        PwmDrive {
            channel: 0,
            gearing: Gearing { ratio: 50.0, per_ratio: 0.02, zero: 0.0 },
            encoder_zero: 5000,
            encoder_reversed: false,
            jump_max: 21,
            speed_per_count: 19.174759,
            torque_constant: 0.045,
            per_torque_constant: 22.222221,
            resistance: 0.6,
            per_resistance: 1.6666666,
            supply: 24.0,
            per_supply: 0.041666668,
            current_max: 5.0,
        },
        PwmDrive {
            channel: 1,
            gearing: Gearing { ratio: -50.0, per_ratio: -0.02, zero: 0.0 },
            encoder_zero: 12000,
            encoder_reversed: false,
            jump_max: 25,
            speed_per_count: -19.174759,
            torque_constant: 0.045,
            per_torque_constant: 22.222221,
            resistance: 0.6,
            per_resistance: 1.6666666,
            supply: 24.0,
            per_supply: 0.041666668,
            current_max: 5.0,
        },
    ])
}
