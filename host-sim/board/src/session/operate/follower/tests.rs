#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test that fails should stop there; an arm at rest is at its target"
)]
use super::{BadTarget, Follower, JointBounds, MEAN};
use proptest::prelude::*;

const H: f64 = 0.01;
const BOUNDS: JointBounds = JointBounds { position: (-3.0, 3.0), velocity: 1.5, acceleration: 8.0 };

fn points(follower: &mut Follower, count: usize) -> Vec<[f64; 3]> {
    let of = |joints: &link::Joints<f32>| f64::from(joints[0]);
    (0..count)
        .map(|_| {
            let point = follower.next_point();
            [of(&point.q), of(&point.qd), of(&point.qdd)]
        })
        .collect()
}

#[test]
fn a_distant_target_is_reached_at_rest_in_little_more_than_the_shortest_time() {
    let mut follower = Follower::new(&[0.0], &[BOUNDS], H).unwrap();
    follower.go_to(&[2.0]).unwrap();
    let all = points(&mut follower, 400);
    let arrived = all.iter().position(|point| *point == [2.0, 0.0, 0.0]).unwrap();
    // At full acceleration and speed: V / A + distance / V, and the delay of the mean.
    let shortest = (BOUNDS.velocity / BOUNDS.acceleration + 2.0 / BOUNDS.velocity) / H + MEAN as f64;
    assert!((arrived as f64) < shortest + 3.0, "{arrived} points, {shortest}");
    assert!(all[arrived..].iter().all(|point| *point == [2.0, 0.0, 0.0]), "it stays there");
    assert!(all.iter().any(|point| (point[1] - BOUNDS.velocity).abs() < 1e-6), "it uses its speed");
}

#[test]
fn what_is_outside_the_limits_or_no_number_is_refused_and_changes_nothing() {
    let mut follower = Follower::new(&[0.0, 0.0], &[BOUNDS; 2], H).unwrap();
    for (target, joint) in [([0.0, 3.1], 2), ([f64::NAN, 0.0], 1), ([f64::NEG_INFINITY, 0.0], 1)] {
        let refused = follower.go_to(&target).unwrap_err();
        assert!(matches!(refused, BadTarget::Outside { joint: named, .. } if named == joint), "{refused}");
    }
    assert_eq!(follower.go_to(&[0.0]), Err(BadTarget::Joints { found: 1, expected: 2 }));
    assert_eq!(follower.next_point().qd.as_slice(), [0.0, 0.0]);
    let endless = JointBounds { velocity: f64::INFINITY, ..BOUNDS };
    assert!(Follower::new(&[0.0], &[endless], H).is_none());
}

#[test]
fn it_brakes_with_its_whole_acceleration_and_stays_at_rest() {
    let mut follower = Follower::new(&[0.0], &[BOUNDS], H).unwrap();
    follower.go_to(&[3.0]).unwrap();
    let moving = points(&mut follower, 60);
    follower.brake();
    let braked = points(&mut follower, 60);
    assert!(follower.has_stopped());
    let distance = braked[59][0] - moving[59][0];
    let shortest = 0.5 * BOUNDS.velocity.powi(2) / BOUNDS.acceleration;
    // The mean is late by half its length.
    let late = 0.5 * H * MEAN as f64 * BOUNDS.velocity;
    assert!((distance - shortest - late).abs() < 0.02 * shortest, "{distance}, {shortest} and {late}");
    let end = braked[59];
    follower.go_to(&[-3.0]).unwrap();
    assert_eq!(points(&mut follower, 5), [end; 5], "a target does not end the braking");
}

proptest! {
    /// Whatever the targets: bounds are kept, no target is passed that was there from rest, and between two points velocity and position are the
    /// integrals of an acceleration that is linear.
    #[test]
    fn bounds_are_kept_and_points_fit_together(
        targets in proptest::collection::vec((-3.0..3.0, 1_usize..40), 1..12),
        velocity in 0.01..10.0,
        acceleration in 0.1..100.0,
        step in 0.001..0.02,
    ) {
        let bounds = JointBounds { position: (-3.0, 3.0), velocity, acceleration };
        let mut follower = Follower::new(&[0.0], &[bounds], step).unwrap();
        let mut before = [0.0; 3];
        for (target, count) in targets {
            follower.go_to(&[target]).unwrap();
            for _ in 0..count {
                follower.joints[0].step(step, false);
                let now = follower.joints[0].mean(step);
                let [q, qd, qdd] = now;
                prop_assert!((-3.0 - 1e-9..=3.0 + 1e-9).contains(&q), "{q}");
                prop_assert!(qd.abs() <= velocity * (1.0 + 1e-9), "{qd}");
                prop_assert!(qdd.abs() <= acceleration * (1.0 + 1e-9), "{qdd}");
                let speed = before[1] + 0.5 * step * (before[2] + qdd);
                let place = before[0] + step * before[1] + step * step * (2.0 * before[2] + qdd) / 6.0;
                prop_assert!((qd - speed).abs() <= 1e-9 * (1.0 + velocity), "{qd}, {speed}");
                prop_assert!((q - place).abs() <= 1e-9, "{q}, {place}");
                before = now;
            }
        }
    }

    #[test]
    fn from_rest_no_target_is_passed(target in 0.0..3.0_f64, velocity in 0.01..10.0, acceleration in 0.1..100.0) {
        let bounds = JointBounds { position: (-3.0, 3.0), velocity, acceleration };
        let mut follower = Follower::new(&[0.0], &[bounds], H).unwrap();
        follower.go_to(&[target]).unwrap();
        for _ in 0..2000 {
            follower.joints[0].step(H, false);
            let (x, v) = follower.joints[0].now();
            prop_assert!(x <= target + 1e-12 && v >= 0.0, "{x} of {target}, {v}");
        }
    }
}
