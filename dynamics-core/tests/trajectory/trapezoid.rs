//! Trapezoidal motions.

use crate::trajectory::support::{check_ends, moments, slope_errors};
use dynamics_core::control::trajectory::{Bounds, Motion};

const MARGIN: f64 = 1.0 + Bounds::<f64, 1>::MARGIN;

fn bounds<const N: usize>(velocity: [f64; N], acceleration: [f64; N]) -> Bounds<f64, N> {
    Bounds { velocity, ..Bounds::none() }.with_acceleration(acceleration)
}

#[test]
fn it_speeds_up_cruises_and_slows_down() {
    // 10 m at 2 m/s and 1 m/s^2: 2 s of acceleration, 3 s at constant speed, 2 s of deceleration.
    let motion = Motion::trapezoid([1.0], [11.0], &bounds([2.0], [1.0])).unwrap();
    assert!((motion.duration() - 7.0 * MARGIN).abs() < 1e-12);
    check_ends(&motion, [1.0], [11.0]);
    let close = |t: f64, q: f64, qd: f64, qdd: f64| {
        let r = motion.sample(t * MARGIN);
        let error = (r.q[0] - q).abs().max((r.qd[0] * MARGIN - qd).abs()).max((r.qdd[0] * MARGIN * MARGIN - qdd).abs());
        assert!(error < 1e-12, "at {t}: {r:?}");
    };
    close(1.0, 1.5, 1.0, 1.0);
    close(1.999, 1.0 + 0.5 * 1.999 * 1.999, 1.999, 1.0);
    close(2.001, 3.002, 2.0, 0.0);
    close(3.5, 6.0, 2.0, 0.0);
    close(4.999, 8.998, 2.0, 0.0);
    close(6.0, 10.5, 1.0, -1.0);
}

#[test]
fn a_short_way_makes_a_triangle() {
    // 1 m at 1 m/s^2: 1 s of acceleration, 1 s of deceleration, at most 1 m/s, with 2 m/s allowed.
    let motion = Motion::trapezoid([0.0], [-1.0], &bounds([2.0], [1.0])).unwrap();
    assert!((motion.duration() - 2.0 * MARGIN).abs() < 1e-12);
    check_ends(&motion, [0.0], [-1.0]);
    let peaks = motion.peaks();
    assert!((peaks.velocity[0] - 1.0 / MARGIN).abs() < 1e-12);
    assert!((peaks.acceleration[0] - 1.0 / (MARGIN * MARGIN)).abs() < 1e-12);
    assert!((motion.sample(MARGIN).q[0] + 0.5).abs() < 1e-12);
    // Without a velocity bound it is the same.
    assert_eq!(Motion::trapezoid([0.0], [-1.0], &bounds([f64::INFINITY], [1.0])).unwrap(), motion);
}

#[test]
fn joints_keep_to_one_line_and_the_tightest_bounds_rule() {
    let limits = bounds([1.0, 1.0, 5.0], [2.0, 2.0, 0.5]);
    let (from, to) = ([0.0, 1.0, 0.0], [2.0, 0.0, 0.25]);
    let motion = Motion::trapezoid(from, to, &limits).unwrap();
    check_ends(&motion, from, to);
    for t in moments(motion.duration(), 300) {
        let r = motion.sample(t);
        for i in 0..3 {
            assert!(r.qd[i].abs() <= limits.velocity[i] && r.qdd[i].abs() <= limits.acceleration[i]);
            let share = (r.q[i] - from[i]) / (to[i] - from[i]);
            assert!((share - r.q[0] / 2.0).abs() < 1e-12);
        }
    }
    // Joint 1 is at its velocity bound; no other joint is: 0.5, 1 and 20 times its distance per second.
    let peaks = motion.peaks();
    assert!(peaks.velocity[0] > 0.99999 && peaks.velocity[1] < 0.51 && peaks.acceleration[0] > 1.9999);
}

#[test]
fn its_slopes_are_what_it_says_between_the_jumps_of_acceleration() {
    let motion = Motion::trapezoid_in([0.0, 0.4], [3.0, -1.0], 5.0, 0.25, &Bounds::none()).unwrap();
    let (qd, qdd) = slope_errors(&motion, &[0.0, 1.25, 3.75, 5.0]);
    assert!(qd < 1e-9 && qdd < 1e-9, "{qd} {qdd}");
    // The jumps are real: if they are not excluded, the test finds them.
    let near_a_jump = motion.sample(1.25 - 1e-9).qdd[0] - motion.sample(1.25 + 1e-9).qdd[0];
    assert!((near_a_jump - motion.peaks().acceleration[0]).abs() < 1e-9);
}

#[test]
fn a_given_duration_is_kept() {
    for share in [0.1, 0.3, 0.5_f64] {
        let motion = Motion::trapezoid_in([0.0], [1.0], 4.0, share, &Bounds::none()).unwrap();
        assert_eq!(motion.duration(), 4.0);
        let Motion::Trapezoid(profile) = &motion else { panic!("a trapezoid") };
        assert!((profile.ramp() - 4.0 * share).abs() < 1e-15);
        assert!((motion.peaks().velocity[0] - 1.0 / (4.0 * (1.0 - share))).abs() < 1e-15);
    }
}
