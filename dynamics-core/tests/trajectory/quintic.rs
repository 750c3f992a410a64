//! Quintic motions through points.

use crate::trajectory::support::{check_ends, moments, sampled_peaks, slope_errors};
use dynamics_core::control::trajectory::{Bounds, Motion, Timing, Waypoint};
use proptest::prelude::{Strategy, prop_assert, proptest};

fn through(points: &[[f64; 2]], durations: &[f64]) -> Motion<f64, 2> {
    let points: Vec<_> = points.iter().map(|q| Waypoint::through(*q)).collect();
    Motion::quintic(&points, Timing::Durations(durations), &Bounds::none()).unwrap()
}

#[test]
fn rest_to_rest_is_the_textbook_quintic() {
    let motion = through(&[[1.0, 0.0], [3.0, -1.0]], &[4.0]);
    check_ends(&motion, [1.0, 0.0], [3.0, -1.0]);
    for t in moments(4.0, 100) {
        let s: f64 = t / 4.0;
        let r = motion.sample(t);
        let way = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        let speed = 30.0 * s * s * (1.0 - s) * (1.0 - s) / 4.0;
        let acceleration = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / 16.0;
        for (i, d) in [2.0, -1.0].into_iter().enumerate() {
            assert!((r.q[i] - [1.0, 0.0][i] - d * way).abs() < 1e-14);
            assert!((r.qd[i] - d * speed).abs() < 1e-14);
            assert!((r.qdd[i] - d * acceleration).abs() < 1e-14);
        }
    }
    let peaks = motion.peaks();
    assert!((peaks.velocity[0] - 15.0 / 8.0 * 2.0 / 4.0).abs() < 1e-14);
    assert!((peaks.acceleration[0] - 10.0 / 3.0_f64.sqrt() * 2.0 / 16.0).abs() < 1e-14);
}

#[test]
fn it_meets_every_point_when_it_should_and_is_smooth_there() {
    let points = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.2], [2.5, -1.0], [2.5, -1.5]];
    let durations = [1.0, 0.7, 1.3, 0.9];
    let motion = through(&points, &durations);
    check_ends(&motion, points[0], points[4]);
    let mut time = 0.0;
    for (k, duration) in durations.into_iter().enumerate() {
        time += duration;
        let (before, here, after) = (motion.sample(time - 1e-9), motion.sample(time), motion.sample(time + 1e-9));
        for i in 0..2 {
            assert!((here.q[i] - points[k + 1][i]).abs() < 1e-12);
            for (x, y) in [(before.q, after.q), (before.qd, after.qd), (before.qdd, after.qdd)] {
                assert!((x[i] - y[i]).abs() < 1e-6, "joint {i} steps by {} at {time}", x[i] - y[i]);
            }
            assert!(here.qdd[i].abs() < 1e-9);
        }
    }
    let (qd, qdd) = slope_errors(&motion, &[]);
    assert!(qd < 1e-7 && qdd < 1e-7, "{qd} {qdd}");
}

#[test]
fn the_velocity_at_a_point_is_the_mean_slope_twice_the_lesser_or_zero() {
    let at_middle = |points, durations: &[f64; 2]| through(points, durations).sample(durations[0]).qd;
    // Slopes 1 and 2: the mean. Slopes 1 and -1: the joint turns back, so zero.
    assert_eq!(at_middle(&[[0.0, 0.0], [1.0, 1.0], [3.0, 0.0]], &[1.0, 1.0]), [1.5, 0.0]);
    // Slopes 1 and 10: twice the lesser. Slopes -10 and -1: likewise.
    assert_eq!(at_middle(&[[0.0, 0.0], [1.0, -10.0], [11.0, -11.0]], &[1.0, 1.0]), [2.0, -2.0]);
    // The joint does not move in one of the segments: zero.
    assert_eq!(at_middle(&[[0.0, 1.0], [0.0, 2.0], [1.0, 2.0]], &[1.0, 1.0]), [0.0, 0.0]);
    // Slopes are per time, not per segment: 2 / 2 and 3 / 1.
    assert_eq!(at_middle(&[[0.0, 0.0], [2.0, 0.0], [5.0, 0.0]], &[2.0, 1.0]), [2.0, 0.0]);
}

#[test]
fn a_dwell_stands_still_for_its_time() {
    let dwelling = |q, dwell| Waypoint { q: [q], dwell };
    let points = [dwelling(0.0, 0.5), dwelling(1.0, 0.25), dwelling(2.0, 1.0)];
    let motion = Motion::quintic(&points, Timing::Durations(&[1.0, 2.0]), &Bounds::none()).unwrap();
    assert_eq!(motion.duration(), 4.75);
    let resting = |t: f64, q: f64| {
        let r = motion.sample(t);
        r.q == [q] && r.qd == [0.0] && r.qdd == [0.0]
    };
    assert!(resting(0.25, 0.0) && resting(0.499, 0.0) && !resting(0.6, 0.0));
    assert!(resting(1.51, 1.0) && resting(1.74, 1.0) && !resting(1.4, 1.0) && !resting(1.8, 1.0));
    assert!(resting(3.76, 2.0) && resting(4.7, 2.0));
    let slower = motion.stretched(2.0).unwrap();
    assert_eq!(slower.duration(), 7.75, "the dwells keep their length");
    assert_eq!(motion.with_duration(7.75).unwrap(), slower);
}

/// Up to six points of two joints with durations and dwells.
fn tour() -> impl Strategy<Value = (Vec<Waypoint<f64, 2>>, Vec<f64>)> {
    let point = (proptest::array::uniform2(-2.0..2.0), proptest::option::weighted(0.2, 0.01..0.5))
        .prop_map(|(q, dwell)| Waypoint { q, dwell: dwell.unwrap_or(0.0) });
    (2..=6_usize).prop_flat_map(move |n| {
        (proptest::collection::vec(point.clone(), n), proptest::collection::vec(0.05..2.0, n - 1))
    })
}

proptest! {
    #![proptest_config(proptest::test_runner::Config { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_joint_leaves_the_range_between_a_point_and_the_next((points, durations) in tour()) {
        let motion = Motion::quintic(&points, Timing::Durations(&durations), &Bounds::none()).unwrap();
        let mut start = 0.0;
        for (pair, duration) in points.windows(2).zip(&durations) {
            start += pair[0].dwell;
            for t in moments(*duration, 64) {
                let r = motion.sample(start + t);
                for i in 0..2 {
                    let (from, to) = (pair[0].q[i], pair[1].q[i]);
                    // By rounding, a sample just after the segment may be in the next one.
                    let slack = 1e-12;
                    prop_assert!(r.q[i] >= from.min(to) - slack && r.q[i] <= from.max(to) + slack);
                    // Not only because of the clamp: the velocity itself never changes its sign.
                    let peak = motion.peaks().velocity[i];
                    prop_assert!(r.qd[i] * (to - from).signum() >= -1e-12 * peak, "{} of {}", r.qd[i], to - from);
                }
            }
            start += duration;
        }
    }

    #[test]
    fn peaks_are_exact((points, durations) in tour()) {
        let motion = Motion::quintic(&points, Timing::Durations(&durations), &Bounds::none()).unwrap();
        let peaks = motion.peaks();
        let (velocity, acceleration) = sampled_peaks(&motion, 20_000);
        for i in 0..2 {
            for (peak, sampled) in [(peaks.velocity[i], velocity[i]), (peaks.acceleration[i], acceleration[i])] {
                prop_assert!(sampled <= peak * (1.0 + 1e-12) && sampled >= peak * 0.999, "{} sampled {}", peak, sampled);
            }
        }
    }

    #[test]
    fn velocity_and_acceleration_are_the_slopes_that_they_say((points, durations) in tour()) {
        let motion = Motion::quintic(&points, Timing::Durations(&durations), &Bounds::none()).unwrap();
        let (qd, qdd) = slope_errors(&motion, &[]);
        // The jerk jumps at points: there, the second difference has an error of half a time step.
        prop_assert!(qd < 1e-5 && qdd < 2e-2, "{} {}", qd, qdd);
    }
}
