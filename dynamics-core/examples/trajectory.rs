//! A quintic motion through three points as fast as the joints allow: samples, peaks, and the same path at half the speed.
//!
//! ```console
//! $ cargo run -p dynamics-core --example trajectory
//! ```

use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, Timing, Waypoint};

fn main() -> Result<(), MotionError> {
    // rad, rad/s, rad/s^2
    let bounds = Bounds { position: [(-2.0, 2.0); 2], velocity: [1.5, 3.0], acceleration: [6.0, 12.0] };
    let points = [
        Waypoint::through([0.0, 0.0]),
        Waypoint::through([1.0, 0.5]),
        // A dwell: the arm rests here for 0.2 s.
        Waypoint { q: [1.5, 2.0], dwell: 0.2 },
    ];
    let motion = Motion::quintic(&points, Timing::Fastest, &bounds)?;
    let duration = motion.duration();

    println!("   s     q (rad)           qd (rad/s)        qdd (rad/s^2)");
    for sample in 0..=8 {
        let t = duration * f64::from(sample) / 8.0;
        let at = motion.sample(t);
        println!("{t:6.3}  {:7.3?}  {:7.3?}  {:7.3?}", at.q, at.qd, at.qdd);
    }

    // It passes through the points, and starts and ends at rest.
    let arrival = motion.arrival(1).unwrap_or_default();
    let middle = motion.sample(arrival).q;
    println!("reaches {middle:.3?} rad at {arrival:.3} s");
    assert!((middle[0] - 1.0).abs() < 1e-12 && (middle[1] - 0.5).abs() < 1e-12);
    assert_eq!((motion.sample(0.0), motion.sample(duration)), (motion.start(), motion.end()));

    // Some joint just touches a bound, and none breaks one. The margin is for rounding to single precision.
    let peaks = motion.peaks();
    println!("peaks: {:.3?} rad/s, {:.3?} rad/s^2", peaks.velocity, peaks.acceleration);
    let share = |peak: [f64; 2], bound: [f64; 2]| f64::max(peak[0] / bound[0], peak[1] / bound[1]);
    let most = f64::max(share(peaks.velocity, bounds.velocity), share(peaks.acceleration, bounds.acceleration));
    assert!((1.0 - 1e-5..=1.0).contains(&most), "{most}");

    // The same path in twice the time: half the speed, a quarter of the acceleration.
    let slow = motion.stretched(2.0)?;
    let (fast, slow) = (motion.sample(0.5), slow.sample(1.0));
    for i in 0..2 {
        assert!((slow.q[i] - fast.q[i]).abs() < 1e-12 && (slow.qd[i] - fast.qd[i] / 2.0).abs() < 1e-12);
        assert!((slow.qdd[i] - fast.qdd[i] / 4.0).abs() < 1e-12);
    }

    // A request that no joint can fulfil is an error with a sentence.
    let too_short = Motion::quintic(&points, Timing::Durations(&[0.1, 0.1]), &bounds);
    match too_short {
        Err(problem @ MotionError::TooFast { .. }) => println!("0.1 s a segment: {problem}"),
        other => assert!(other.is_err(), "a motion that is too fast was accepted"),
    }
    Ok(())
}
