//! Time scaling: up to the bound, never beyond it.

use crate::trajectory::support::{moments, sampled_peaks};
use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, SweepSpec, Timing, Waypoint};

const VELOCITY: [f64; 2] = [1.3, 2.1];
const GENTLE: [f64; 2] = [3.0, 0.9];

/// The greatest share of a bound that a motion may use: the stated margin, except for the rounding of a double.
const INSIDE: f64 = 1.0 - 0.999 * Bounds::<f64, 2>::MARGIN;

fn bounds() -> Bounds<f64, 2> {
    Bounds { velocity: VELOCITY, ..Bounds::none() }
}

fn points() -> [Waypoint<f64, 2>; 4] {
    [[0.0, 0.0], [1.0, 0.5], [1.7, 2.0], [1.2, 2.2]].map(Waypoint::through)
}

fn motions() -> [Motion<f64, 2>; 3] {
    let none = Bounds::none();
    let spec = SweepSpec { centre: [0.0; 2], amplitude: [0.3, 0.4], from: 0.2, to: 2.0, duration: 9.0, ramp: 1.5 };
    [
        Motion::quintic(&points(), Timing::Durations(&[1.0, 2.0, 0.5]), &none).unwrap(),
        Motion::trapezoid_in([0.0, 1.0], [2.0, -2.0], 3.0, 0.2, &none).unwrap(),
        Motion::sweep(&spec, &none).unwrap(),
    ]
}

/// Share of its tightest bound that a motion uses, by sampling.
fn used(motion: &Motion<f64, 2>, bounds: &Bounds<f64, 2>) -> f64 {
    let (velocity, acceleration) = sampled_peaks(motion, 50_000);
    (0..2).fold(0.0, |most, i| {
        most.max(velocity[i] / bounds.velocity[i]).max((acceleration[i] / bounds.acceleration[i]).sqrt())
    })
}

#[test]
fn a_motion_without_durations_is_as_fast_as_the_bounds_allow() {
    for bounds in [bounds(), bounds().with_acceleration(GENTLE)] {
        let motion = Motion::quintic(&points(), Timing::Fastest, &bounds).unwrap();
        let used = used(&motion, &bounds);
        assert!((0.99998..=INSIDE).contains(&used), "{used}");
        for fitted in motions().map(|motion| motion.fastest(&bounds).unwrap()) {
            let used = self::used(&fitted, &bounds);
            assert!((0.99..=INSIDE).contains(&used), "{used} of {fitted:?}");
            assert!((fitted.time_scale(&bounds).unwrap() - 1.0).abs() < 1.1 * Bounds::<f64, 2>::MARGIN);
        }
    }
}

#[test]
fn an_acceleration_bound_makes_a_motion_slower() {
    let fast = Motion::quintic(&points(), Timing::Fastest, &bounds()).unwrap();
    let gentle = Motion::quintic(&points(), Timing::Fastest, &bounds().with_acceleration(GENTLE)).unwrap();
    assert!(gentle.duration() > 1.1 * fast.duration());
}

#[test]
fn stretching_keeps_the_path() {
    for motion in motions() {
        for k in [0.25, 3.0] {
            let stretched = motion.stretched(k).unwrap();
            assert!((stretched.duration() - k * motion.duration()).abs() < 1e-12);
            for t in moments(motion.duration(), 1000).skip(1) {
                let (a, b) = (motion.sample(t), stretched.sample(k * t));
                for i in 0..2 {
                    assert!((a.q[i] - b.q[i]).abs() < 1e-11);
                    assert!((a.qd[i] - k * b.qd[i]).abs() < 1e-9);
                }
            }
            for i in 0..2 {
                let (a, b) = (motion.peaks(), stretched.peaks());
                assert!((a.velocity[i] / b.velocity[i] - k).abs() < 1e-9);
                assert!((a.acceleration[i] / b.acceleration[i] - k * k).abs() < 1e-9);
            }
            let back = stretched.with_duration(motion.duration()).unwrap();
            assert!((back.duration() - motion.duration()).abs() < 1e-12);
        }
    }
}

#[test]
fn rounded_to_single_precision_it_stays_inside_every_bound() {
    let limits = bounds().velocity.map(|v| v as f32);
    let double = motions().map(|motion| motion.fastest(&bounds()).unwrap());
    for motion in &double {
        for t in moments(motion.duration(), 50_000) {
            let r = motion.sample(t).cast::<f32>();
            assert!((0..2).all(|i| r.qd[i].abs() <= limits[i]), "at {t}");
        }
    }
    // Computed in single precision from the start.
    let points = points().map(|p| Waypoint::through(p.q.map(|q| q as f32)));
    let bounds = Bounds { velocity: limits, position: [(0.0, 1.7), (0.0, 2.2)], ..Bounds::none() };
    let single = Motion::quintic(&points, Timing::Fastest, &bounds).unwrap();
    let mut fastest = 0.0_f32;
    for i in 0..=50_000_u16 {
        let r = single.sample(single.duration() * f32::from(i) / 50_000.0);
        for i in 0..2 {
            fastest = fastest.max(r.qd[i].abs() / limits[i]);
            assert!(r.q[i] >= bounds.position[i].0 && r.q[i] <= bounds.position[i].1);
        }
    }
    assert!((0.9999..=1.0).contains(&fastest), "{fastest}");
}

#[test]
fn what_has_no_bound_or_does_not_move_has_no_fastest() {
    let [quintic, ..] = motions();
    assert_eq!(quintic.time_scale(&Bounds::none()), Err(MotionError::Unbounded { segment: 0 }));
    let hold = Motion::hold([0.0; 2], 1.0, &bounds()).unwrap();
    assert_eq!(hold.fastest(&bounds()), Err(MotionError::Standstill { segment: 0 }));
    assert_eq!(hold.stretched(2.0).unwrap().duration(), 2.0);
}
