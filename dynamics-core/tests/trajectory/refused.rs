//! Impossible motions are rejected by name.

use dynamics_core::Limits;
use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, POINTS_MAX, SweepSpec, Timing, Waypoint};

const NAN: f64 = f64::NAN;
const INF: f64 = f64::INFINITY;

fn bounds() -> Bounds<f64, 2> {
    let limits = Limits { position: (-1.0, 2.0), velocity: 3.0, ..Limits::none() };
    Bounds::from_limits(&[limits; 2]).with_acceleration([20.0; 2])
}

fn quintic(points: &[[f64; 2]], durations: &[f64]) -> String {
    let points: Vec<_> = points.iter().map(|q| Waypoint::through(*q)).collect();
    message(Motion::quintic(&points, Timing::Durations(durations), &bounds()))
}

fn fastest(points: &[[f64; 2]], bounds: &Bounds<f64, 2>) -> String {
    let points: Vec<_> = points.iter().map(|q| Waypoint::through(*q)).collect();
    message(Motion::quintic(&points, Timing::Fastest, bounds))
}

fn message(outcome: Result<Motion<f64, 2>, MotionError>) -> String {
    match outcome {
        Ok(motion) => format!("ok, {} s", motion.duration()),
        Err(error) => error.to_string(),
    }
}

#[test]
fn points() {
    assert_eq!(quintic(&[], &[]), "a motion needs at least 2 points, not 0");
    assert_eq!(quintic(&[[0.0; 2]], &[]), "a motion needs at least 2 points, not 1");
    let many = [[0.0; 2]; POINTS_MAX + 1];
    assert_eq!(quintic(&many, &[1.0; POINTS_MAX]), "a motion has at most 16 points, not 17");
    assert_eq!(quintic(&many[1..], &[1.0; POINTS_MAX - 1]), "ok, 15 s");
    assert_eq!(quintic(&[[0.0; 2], [0.0, NAN]], &[1.0]), "position of joint 2 at point 2 is not a finite number");
    assert_eq!(quintic(&[[-INF, 0.0], [0.0; 2]], &[1.0]), "position of joint 1 at point 1 is not a finite number");
    assert_eq!(quintic(&[[0.0; 2], [2.5, 0.0]], &[1.0]), "joint 1 at point 2 is at 2.5, outside its limits -1 to 2");
    assert_eq!(quintic(&[[-1.0; 2], [2.0; 2]], &[4.0]), "ok, 4 s");
}

#[test]
fn durations_and_dwells() {
    let points = [[0.0; 2], [1.0; 2]];
    assert_eq!(
        quintic(&points, &[1.0, 2.0]),
        "2 durations given, but 1 are needed: one between each point and the next"
    );
    for (bad, shown) in [(0.0, "0"), (-1.0, "-1"), (NAN, "NaN"), (INF, "inf")] {
        assert_eq!(quintic(&points, &[bad]), format!("duration is {shown}, but must be above zero and finite"));
    }
    assert_eq!(quintic(&points, &[0.5]), "joint 1 would reach speed 3.75, above 3: 1.250 times the time would do");
    let wide = Bounds { velocity: [INF; 2], ..bounds() };
    let points = points.map(Waypoint::through);
    let steep = message(Motion::quintic(&points, Timing::Durations(&[0.5]), &wide));
    assert!(
        steep.starts_with("joint 1 would reach acceleration 23.09") && steep.ends_with("1.075 times the time would do")
    );
    for (bad, shown) in [(-0.1, "-0.1"), (NAN, "NaN"), (INF, "inf")] {
        let points = [points[0], Waypoint { dwell: bad, ..points[1] }];
        let outcome = message(Motion::quintic(&points, Timing::Durations(&[1.0]), &bounds()));
        assert_eq!(outcome, format!("dwell is {shown}, but must be finite and not negative"));
    }
}

#[test]
fn a_fastest_that_does_not_exist() {
    let points = [[0.0; 2], [1.0, 0.0], [1.0, 1.0]];
    let free = |joint: usize| {
        let mut bounds = bounds();
        (bounds.velocity[joint], bounds.acceleration[joint]) = (INF, INF);
        bounds
    };
    assert!(fastest(&points, &bounds()).starts_with("ok"));
    let unbounded = "no bound limits the speed on segment";
    assert_eq!(fastest(&points, &free(0)), format!("{unbounded} 1: give its duration, or bounds"));
    assert_eq!(fastest(&points, &free(1)), format!("{unbounded} 2: give its duration, or bounds"));
    assert_eq!(
        fastest(&[points[0], points[1], points[1]], &bounds()),
        "no joint moves on segment 2: give its duration, or a dwell"
    );
}

#[test]
fn bounds_that_cannot_be() {
    let with = |change: &dyn Fn(&mut Bounds<f64, 2>)| {
        let mut bounds = bounds();
        change(&mut bounds);
        fastest(&[[0.0; 2], [1.0; 2]], &bounds)
    };
    for bad in [0.0, -1.0, NAN] {
        assert_eq!(with(&|b| b.velocity[1] = bad), "velocity bound of joint 2 cannot be");
        assert_eq!(with(&|b| b.acceleration[0] = bad), "acceleration bound of joint 1 cannot be");
    }
    for bad in [(1.0, -1.0), (NAN, 1.0), (-1.0, NAN)] {
        assert_eq!(with(&|b| b.position[1] = bad), "position bound of joint 2 cannot be");
    }
}

#[test]
fn trapezoids() {
    let (from, to) = ([0.0; 2], [1.0, 0.0]);
    let bounded = bounds();
    let unbounded = Bounds { acceleration: [INF; 2], ..bounded };
    assert_eq!(
        message(Motion::trapezoid(from, to, &unbounded)),
        "no bound limits the speed on segment 1: give its duration, or bounds"
    );
    assert_eq!(
        message(Motion::trapezoid(from, from, &bounded)),
        "no joint moves on segment 1: give its duration, or a dwell"
    );
    assert_eq!(
        message(Motion::trapezoid(from, [0.0, 3.0], &bounded)),
        "joint 2 at point 2 is at 3, outside its limits -1 to 2"
    );
    for (bad, shown) in [(0.0, "0"), (0.6, "0.6"), (NAN, "NaN")] {
        assert_eq!(
            message(Motion::trapezoid_in(from, to, 1.0, bad, &bounded)),
            format!("ramp share is {shown}, but must be above 0 and at most 1/2")
        );
    }
    assert_eq!(
        message(Motion::trapezoid_in(from, to, 0.5, 0.5, &bounded)),
        "joint 1 would reach speed 4, above 3: 1.333 times the time would do"
    );
    assert_eq!(
        message(Motion::trapezoid_in(from, to, 0.0, 0.5, &bounded)),
        "duration is 0, but must be above zero and finite"
    );
}

#[test]
fn sweeps() {
    let good = SweepSpec { centre: [0.5; 2], amplitude: [0.2; 2], from: 0.1, to: 1.0, duration: 10.0, ramp: 2.0 };
    let try_with = |change: &dyn Fn(&mut SweepSpec<f64, 2>)| {
        let mut spec = good;
        change(&mut spec);
        message(Motion::sweep(&spec, &bounds()))
    };
    assert_eq!(try_with(&|_| {}), "ok, 10 s");
    assert_eq!(
        try_with(&|s| s.amplitude[1] = -1.75),
        "joint 2 would sweep from -1.25 to 2.25, outside its limits -1 to 2"
    );
    assert_eq!(try_with(&|s| (s.amplitude[1], s.to) = (1.5, 0.1)), "ok, 10 s");
    assert!(try_with(&|s| s.amplitude[0] = 1.5).starts_with("joint 1 would reach speed"));
    assert_eq!(try_with(&|s| s.amplitude[1] = NAN), "amplitude of joint 2 at point 1 is not a finite number");
    assert_eq!(try_with(&|s| s.ramp = 5.1), "ramp is 5.1, but must be at most half the duration");
    assert_eq!(try_with(&|s| s.ramp = 0.0), "ramp is 0, but must be above zero and finite");
    assert_eq!(try_with(&|s| s.duration = NAN), "duration is NaN, but must be above zero and finite");
    assert_eq!(try_with(&|s| s.from = -1.0), "frequency is -1, but must be finite and not negative");
    assert_eq!(try_with(&|s| (s.from, s.to) = (0.0, 0.0)), "highest frequency is 0, but must be above zero and finite");
    assert_eq!(try_with(&|s| s.to = 1001.0), "duration in periods is 10010, but must be at most 10000");
}

#[test]
fn times() {
    let hold = |duration| Motion::hold([0.0; 2], duration, &bounds());
    for bad in [0.0, -1.0, NAN, INF] {
        assert!(matches!(hold(bad), Err(MotionError::OutOfRange { what: "duration", .. })));
        assert!(matches!(hold(1.0).unwrap().stretched(bad), Err(MotionError::OutOfRange { what: "time factor", .. })));
    }
    let points = [[0.0; 2], [1.0; 2]].map(|q| Waypoint { q, dwell: 0.5 });
    let motion = Motion::quintic(&points, Timing::Durations(&[2.0]), &bounds()).unwrap();
    assert_eq!(message(motion.with_duration(5.0)), "ok, 5 s");
    assert_eq!(message(motion.with_duration(1.0)), "time factor is 0, but must be above zero and finite");
}
