//! Generated from a robot and a scene file. Do not edit: change the files instead.

use dynamics_core::drive::{Drives, Gearing, MitDrive, MitRanges, Range};

/// How the joints are reached.
pub const fn drives() -> Drives<6> {
    Drives::Mit([
        MitDrive {
            bus: 0,
            id: 1,
            reply_id: 0,
            reply_bytes: 6,
            temperature_offset: None,
            ranges: MitRanges {
                position: Range { min: -12.5, max: 12.5 },
                velocity: Range { min: -8.0, max: 8.0 },
                kp: Range { min: 0.0, max: 500.0 },
                kd: Range { min: 0.0, max: 5.0 },
                torque: Range { min: -60.0, max: 60.0 },
            },
            gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.0 },
            damping: 4.0,
        },
        MitDrive {
            bus: 0,
            id: 2,
            reply_id: 0,
            reply_bytes: 6,
            temperature_offset: None,
            ranges: MitRanges {
                position: Range { min: -12.5, max: 12.5 },
                velocity: Range { min: -8.0, max: 8.0 },
                kp: Range { min: 0.0, max: 500.0 },
                kd: Range { min: 0.0, max: 5.0 },
                torque: Range { min: -60.0, max: 60.0 },
            },
            gearing: Gearing { ratio: -1.0, per_ratio: -1.0, zero: 0.35 },
            damping: 4.0,
        },
        MitDrive {
            bus: 0,
            id: 3,
            reply_id: 0,
            reply_bytes: 6,
            temperature_offset: None,
            ranges: MitRanges {
                position: Range { min: -12.5, max: 12.5 },
                velocity: Range { min: -8.0, max: 8.0 },
                kp: Range { min: 0.0, max: 500.0 },
                kd: Range { min: 0.0, max: 5.0 },
                torque: Range { min: -60.0, max: 60.0 },
            },
            gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: -0.2 },
            damping: 4.0,
        },
        MitDrive {
            bus: 1,
            id: 4,
            reply_id: 0,
            reply_bytes: 6,
            temperature_offset: None,
            ranges: MitRanges {
                position: Range { min: -12.5, max: 12.5 },
                velocity: Range { min: -50.0, max: 50.0 },
                kp: Range { min: 0.0, max: 500.0 },
                kd: Range { min: 0.0, max: 5.0 },
                torque: Range { min: -18.0, max: 18.0 },
            },
            gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.1 },
            damping: 1.0,
        },
        MitDrive {
            bus: 1,
            id: 5,
            reply_id: 0,
            reply_bytes: 6,
            temperature_offset: None,
            ranges: MitRanges {
                position: Range { min: -12.5, max: 12.5 },
                velocity: Range { min: -50.0, max: 50.0 },
                kp: Range { min: 0.0, max: 500.0 },
                kd: Range { min: 0.0, max: 5.0 },
                torque: Range { min: -18.0, max: 18.0 },
            },
            gearing: Gearing { ratio: -1.0, per_ratio: -1.0, zero: 0.0 },
            damping: 1.0,
        },
        MitDrive {
            bus: 1,
            id: 6,
            reply_id: 0,
            reply_bytes: 6,
            temperature_offset: None,
            ranges: MitRanges {
                position: Range { min: -12.5, max: 12.5 },
                velocity: Range { min: -50.0, max: 50.0 },
                kp: Range { min: 0.0, max: 500.0 },
                kd: Range { min: 0.0, max: 5.0 },
                torque: Range { min: -18.0, max: 18.0 },
            },
            gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 1.2 },
            damping: 1.0,
        },
    ])
}
