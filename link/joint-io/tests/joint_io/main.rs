//! Tests of the joints' drivers against models of the devices at the other end of the wire.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]
#![allow(clippy::float_cmp, reason = "where a test asks for equality, the bits must be equal")]
#![allow(clippy::disallowed_types, reason = "the models and the bounds are in double precision")]

mod bus_time;
mod can;
mod encoder;
mod frames;
mod gearing;
mod mit;
mod pwm;
mod queued;

use dynamics_core::drive::{Gearing, MitDrive, MitRanges, Range};

/// Ranges of the mini-cheetah's actuator.
fn ranges() -> MitRanges {
    let symmetric = |max: f32| Range { min: -max, max };
    MitRanges {
        position: symmetric(12.5),
        velocity: symmetric(65.0),
        kp: Range { min: 0.0, max: 500.0 },
        kd: Range { min: 0.0, max: 5.0 },
        torque: symmetric(18.0),
    }
}

fn drive(bus: u8, id: u8) -> MitDrive {
    let gearing = Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.0 };
    MitDrive {
        bus,
        data_rate: None,
        id,
        reply_id: 0,
        reply_bytes: 6,
        temperature_offset: None,
        ranges: ranges(),
        gearing,
        damping: 1.0,
        timeout: 0,
        restart_ticks: 10,
        absolute: false,
    }
}

/// The same ranges in the model's type.
fn model_ranges() -> actuator_model::mit::Ranges {
    let pair = |range: Range| (f64::from(range.min), f64::from(range.max));
    let MitRanges { position, velocity, kp, kd, torque } = ranges();
    actuator_model::mit::Ranges {
        position: pair(position),
        velocity: pair(velocity),
        kp: pair(kp),
        kd: pair(kd),
        torque: pair(torque),
    }
}
