//! The tracking observer: its poles, its lag, and encoder counts that wrap.

use crate::control::support::{Desk, UnitMasses, config, controller, driven};
use dynamics_core::control::{ControlLaw, Encoder, TrackingObserver};
use dynamics_core::{Controller, Measurement, Reference, Sensed};

const BANDWIDTH: f64 = 150.0;
const PERIOD: f64 = 1e-3;

/// Error of position and velocity after `steps` under a constant acceleration; `told` is the acceleration that the observer
/// gets.
fn error_after(steps: u32, acceleration: f64, told: f64) -> (f64, f64) {
    let observer = TrackingObserver::<f64>::new(BANDWIDTH, PERIOD);
    let truth = |n: u32| {
        let t = f64::from(n) * PERIOD;
        (0.2 - 0.3 * t + 0.5 * acceleration * t * t, -0.3 + acceleration * t)
    };
    let (mut x, mut v) = truth(0);
    for n in 1..=steps {
        (x, v) = observer.step(x, v, told, truth(n).0);
    }
    (truth(steps).0 - x, truth(steps).1 - v)
}

#[test]
fn an_acceleration_that_it_is_told_leaves_no_lag() {
    for steps in [1, 10, 100, 1000] {
        let (x, v) = error_after(steps, 40.0, 40.0);
        assert!(x.abs() < 1e-13 && v.abs() < 1e-11, "after {steps}: {x}, {v}");
    }
}

#[test]
fn an_acceleration_that_it_is_not_told_leaves_the_stated_lag() {
    let p = (-BANDWIDTH * PERIOD).exp();
    let a = 40.0;
    let velocity_lag = a * PERIOD * ((1.0 + p) / (1.0 - p) - 0.5);
    let position_lag = a * PERIOD * PERIOD * p * p / ((1.0 - p) * (1.0 - p));
    let (x, v) = error_after(1000, a, 0.0);
    assert!((v / velocity_lag - 1.0).abs() < 1e-9, "velocity {v}, stated {velocity_lag}");
    assert!((x / position_lag - 1.0).abs() < 1e-9, "position {x}, stated {position_lag}");
    // The approximations in its documentation, with the terms that they omit.
    assert!((v / (2.0 * a / BANDWIDTH) - 1.0).abs() < 0.5 * BANDWIDTH * PERIOD);
    assert!((x / (a / (BANDWIDTH * BANDWIDTH)) - 1.0).abs() < BANDWIDTH * PERIOD);
}

#[test]
fn both_poles_of_the_error_lie_where_the_bandwidth_puts_them() {
    // The error for a joint at rest at 0 is the observer's own state; this gives its matrix, column by column.
    for bandwidth in [10.0, 150.0, 900.0] {
        let observer = TrackingObserver::<f64>::new(bandwidth, PERIOD);
        let (a, c) = observer.step(1.0, 0.0, 0.0, 0.0);
        let (b, d) = observer.step(0.0, 1.0, 0.0, 0.0);
        let pole = (-bandwidth * PERIOD).exp();
        assert!((a + d - 2.0 * pole).abs() < 1e-12, "sum of the poles");
        assert!((a * d - b * c - pole * pole).abs() < 1e-12, "product of the poles");
    }
}

#[test]
fn gains_survive_the_trip_through_numbers() {
    let observer = TrackingObserver::<f64>::new(BANDWIDTH, PERIOD);
    let [period, half, g, k] = observer.gains();
    assert_eq!(TrackingObserver::from_gains(period, half, g, k), observer);
    let single = TrackingObserver::<f32>::new(BANDWIDTH, PERIOD).gains();
    assert_eq!(single, [period, half, g, k].map(|x| x as f32));
}

#[test]
fn counts_wrap_without_a_step_in_position() {
    let zero = i32::MAX - 10;
    let encoder = Encoder { zero, per_count: 0.5_f64 };
    for offset in -20..=20 {
        assert_eq!(encoder.position(zero.wrapping_add(offset)), f64::from(offset) * 0.5);
    }
    // The offset did cross the end of the integer range.
    assert!(zero.wrapping_add(20) < 0);
}

#[test]
fn counts_of_a_position_are_the_inverse() {
    for zero in [0, -70_001, i32::MAX - 5] {
        let (single, double) = (Encoder { zero, per_count: 3.835e-4_f32 }, Encoder { zero, per_count: -1.7e-5_f64 });
        for offset in [0, 1, -1, 2, 16_383, -65_536, 8_388_606, -8_388_607] {
            let counts = zero.wrapping_add(offset);
            assert_eq!(single.counts(single.position(counts)), counts);
        }
        for offset in [0, 1, -1, 123_456_789, i32::MAX, i32::MIN] {
            let counts = zero.wrapping_add(offset);
            assert_eq!(double.counts(double.position(counts)), counts);
        }
    }
}

#[test]
fn counts_round_to_nearest_and_keep_within_the_integers() {
    let encoder = Encoder { zero: 100, per_count: 0.5_f64 };
    for (position, counts) in [(0.24, 100), (0.25, 101), (0.74, 101), (-0.24, 100), (-0.25, 99), (1e3, 2100)] {
        assert_eq!(encoder.counts(position), counts, "{position}");
    }
    let from_zero = Encoder { zero: 0, ..encoder };
    assert_eq!([1e300, -1e300, f64::NAN].map(|q| from_zero.counts(q)), [i32::MAX, i32::MIN, 0]);
}

#[test]
fn the_controller_sees_no_jump_in_velocity_when_counts_wrap() {
    let velocity_of = |zero: i32| {
        let mut settings = config(ControlLaw::ComputedTorque);
        settings.encoder = [Encoder { zero, per_count: 1e-4 }; 2];
        let mut controller = controller(settings);
        let mut torques = Vec::new();
        for tick in 0..200 {
            let counts = zero.wrapping_add(tick * 8);
            let measurement = Measurement { sensed: Sensed::Counts([counts; 2]), age_ticks: 0 };
            torques.push(driven(controller.tick(&Reference::at_rest([0.0; 2]), &measurement)).0);
        }
        torques
    };
    assert_eq!(velocity_of(i32::MAX - 700), velocity_of(0));
}

#[test]
fn counts_give_the_torque_of_the_position_and_velocity_that_they_mean() {
    let q = [0.3, -0.8];
    let counts = q.map(|q: f64| (q * 1e4).round() as i32);
    let reference = Reference { q: [0.4, -0.9], qd: [0.0; 2], qdd: [0.0; 2] };
    let mut by_counts = controller(config(ControlLaw::ComputedTorque));
    let mut by_state = controller(config(ControlLaw::ComputedTorque));
    let fresh = |sensed| Measurement { sensed, age_ticks: 0 };
    for _ in 0..50 {
        let (counted, _) = driven(by_counts.tick(&reference, &fresh(Sensed::Counts(counts))));
        let (stated, _) = driven(by_state.tick(&reference, &fresh(Sensed::State { q, qd: [0.0; 2] })));
        for i in 0..2 {
            assert!((counted[i] - stated[i]).abs() < 1e-9, "{counted:?} {stated:?}");
        }
    }
}

#[test]
fn counts_after_a_measured_state_start_the_observer_afresh() {
    let fresh = |sensed| Measurement { sensed, age_ticks: 0 };
    let still = Reference::at_rest([1.0; 2]);
    let mut switched = controller(config(ControlLaw::ComputedTorque));
    driven(switched.tick(&still, &fresh(Sensed::Counts([0; 2]))));
    driven(switched.tick(&still, &fresh(Sensed::State { q: [1.0; 2], qd: [0.0; 2] })));
    let after = driven(switched.tick(&still, &fresh(Sensed::Counts([10_000; 2]))));
    let mut new = controller(config(ControlLaw::ComputedTorque));
    assert_eq!(after, driven(new.tick(&still, &fresh(Sensed::Counts([10_000; 2])))));
}

#[test]
fn the_controller_tells_the_observer_what_its_reference_asks_for() {
    // A joint that follows a constant acceleration exactly: without lag, feedback contributes nothing.
    let per_count = 1e-9;
    let mut settings = config(ControlLaw::ComputedTorque);
    settings.encoder = [Encoder { zero: 0, per_count }];
    let mut controller = Controller::new(settings, UnitMasses::default(), Desk);
    let acceleration = 3.0;
    for tick in 0..200 {
        let t = f64::from(tick) * PERIOD;
        let reference = Reference { q: [0.5 * acceleration * t * t], qd: [acceleration * t], qdd: [acceleration] };
        let counts = Sensed::Counts([(reference.q[0] / per_count).round() as i32]);
        let (torque, _) = driven(controller.tick(&reference, &Measurement { sensed: counts, age_ticks: 0 }));
        // Without the acceleration as input, this observer would lag by 2 a / 200 in velocity, and Kd = 36 makes that a torque of 1.
        assert!((torque[0] - acceleration).abs() < 1e-3, "torque {} in tick {tick}", torque[0]);
    }
}
