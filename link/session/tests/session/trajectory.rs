//! Tests of the trajectory: references between its points, and refusals.
#![allow(clippy::disallowed_types, reason = "what is expected is computed in double precision, on the desk")]

use dynamics_core::control::Reference;
use newtau_session::trajectory::{FinitePoint, NotTaken, Trajectory, WAYS};
use proptest::prelude::*;

const PERIOD: f32 = 0.001;

fn point(q: f32, qd: f32, qdd: f32) -> Reference<f32, 1> {
    Reference { q: [q], qd: [qd], qdd: [qdd] }
}

fn bits(reference: &Reference<f32, 1>) -> [u32; 3] {
    [reference.q[0], reference.qd[0], reference.qdd[0]].map(f32::to_bits)
}

/// A trajectory together with the reference that its caller holds.
struct Followed {
    trajectory: Trajectory<1>,
    now: Option<Reference<f32, 1>>,
}

impl Followed {
    fn new() -> Self {
        Self { trajectory: Trajectory::new(), now: None }
    }

    fn start(&mut self, point: &Reference<f32, 1>) -> Result<(), NotTaken> {
        let point = FinitePoint::new(*point)?;
        self.trajectory.start(&point, &mut self.now);
        Ok(())
    }

    fn push(&mut self, ticks: u16, point: &Reference<f32, 1>) -> Result<(), NotTaken> {
        self.trajectory.push(ticks, PERIOD, point)
    }

    fn room(&self) -> usize {
        self.trajectory.room()
    }

    /// References of the ticks from now on, until there is none, but at most `ticks` of them.
    fn follow(&mut self, ticks: usize) -> Vec<Reference<f32, 1>> {
        let mut all = Vec::new();
        while let (true, Some(now)) = (all.len() < ticks, self.now) {
            all.push(now);
            self.trajectory.advance(&mut self.now);
        }
        all
    }
}

proptest! {
    /// Between any two points of a fifth-degree polynomial the trajectory reproduces that polynomial; compared with f64.
    #[test]
    fn between_points_of_a_quintic_the_reference_is_that_quintic(
        c in proptest::array::uniform6(-1.0_f64..1.0),
        ticks in proptest::array::uniform3(2_u16..400),
    ) {
        let total = f64::from(ticks.iter().map(|&t| u32::from(t)).sum::<u32>());
        let at = |k: f64| {
            let (s, d) = (k / total, total * f64::from(PERIOD));
            let q = c.iter().rev().fold(0.0, |sum, c| sum * s + c);
            let qd = c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * (4.0 * c[4] + s * 5.0 * c[5])));
            let qdd = 2.0 * c[2] + s * (6.0 * c[3] + s * (12.0 * c[4] + s * 20.0 * c[5]));
            (q, qd / d, qdd / (d * d))
        };
        let exact = |k: f64| { let (q, qd, qdd) = at(k); point(q as f32, qd as f32, qdd as f32) };
        let mut trajectory = Followed::new();
        trajectory.start(&exact(0.0)).unwrap();
        let mut k = 0.0;
        for ticks in ticks {
            k += f64::from(ticks);
            trajectory.push(ticks, &exact(k)).unwrap();
        }
        let all = trajectory.follow(2000);
        prop_assert_eq!(all.len(), total as usize + 1);
        let shortest = f64::from(*ticks.iter().min().unwrap()) * f64::from(PERIOD);
        for (k, now) in all.iter().enumerate() {
            let (q, qd, qdd) = at(k as f64);
            // Positions of up to 6 rad are rounded to 2.4e-7 rad; a short segment multiplies that, and the velocities' rounding.
            let rounding = 5e-7 + 1e-7 * qd.abs() * shortest;
            prop_assert!((f64::from(now.q[0]) - q).abs() < 2e-5, "q {} {q}", now.q[0]);
            prop_assert!((f64::from(now.qd[0]) - qd).abs() < 1e-5 * qd.abs() + 10.0 * rounding / shortest, "qd {} {qd}", now.qd[0]);
            let allowed = 1e-5 * qdd.abs() + 60.0 * rounding / (shortest * shortest);
            prop_assert!((f64::from(now.qdd[0]) - qdd).abs() < allowed, "qdd {} {qdd}", now.qdd[0]);
        }
    }

    /// At the tick of a point the reference equals the point, to the bit.
    #[test]
    fn points_are_met_to_the_bit(points in proptest::collection::vec((1_u16..30, -2.0_f32..2.0, -1.0_f32..1.0), 1..WAYS)) {
        let mut trajectory = Followed::new();
        let start = point(0.1, 0.2, 0.3);
        trajectory.start(&start).unwrap();
        let mut expected = vec![(0, start)];
        for (ticks, q, qd) in points {
            let next = point(q, qd, -qd);
            trajectory.push(ticks, &next).unwrap();
            expected.push((expected.last().unwrap().0 + usize::from(ticks), next));
        }
        let all = trajectory.follow(2000);
        for (k, point) in expected {
            prop_assert_eq!(bits(&all[k]), bits(&point), "tick {}", k);
        }
    }
}

#[test]
fn behind_a_point_at_rest_the_reference_stays_and_more_points_can_follow() {
    let mut trajectory = Followed::new();
    trajectory.start(&point(1.0, 0.0, 0.0)).unwrap();
    assert!(trajectory.follow(10).iter().all(|now| *now == point(1.0, 0.0, 0.0)));
    trajectory.push(4, &point(2.0, 0.0, 0.0)).unwrap();
    let all = trajectory.follow(10);
    assert_eq!((all[0], all[9]), (point(1.0, 0.0, 0.0), point(2.0, 0.0, 0.0)));
    assert!((all[2].q[0] - 1.5).abs() < 1e-6, "the middle of a quintic from rest to rest: {:?}", all[2]);
}

#[test]
fn a_last_point_in_motion_is_an_underrun_and_a_new_start_is_needed() {
    for last in [point(2.0, 0.5, 0.0), point(2.0, 0.0, 0.5)] {
        let mut trajectory = Followed::new();
        trajectory.start(&point(1.0, 0.0, 0.0)).unwrap();
        trajectory.push(5, &last).unwrap();
        assert_eq!(trajectory.follow(100).len(), 6);
        assert_eq!(trajectory.push(5, &point(2.0, 0.0, 0.0)), Err(NotTaken::NoStart));
    }
}

#[test]
fn the_buffer_is_bounded_and_says_how_much_room_it_has() {
    let mut trajectory = Followed::new();
    assert_eq!(trajectory.push(1, &point(0.0, 0.0, 0.0)), Err(NotTaken::NoStart));
    trajectory.start(&point(0.0, 0.0, 0.0)).unwrap();
    for i in 0..WAYS {
        assert_eq!(trajectory.room(), WAYS - i);
        trajectory.push(2, &point(i as f32, 0.0, 0.0)).unwrap();
    }
    assert_eq!(trajectory.push(2, &point(0.0, 0.0, 0.0)), Err(NotTaken::Full));
    trajectory.follow(3);
    assert_eq!(trajectory.room(), 1);
}

#[test]
fn what_is_no_number_is_refused_and_changes_nothing() {
    let mut trajectory = Followed::new();
    trajectory.start(&point(1.0, 0.0, 0.0)).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for point in [point(bad, 0.0, 0.0), point(0.0, bad, 0.0), point(0.0, 0.0, bad)] {
            assert_eq!(trajectory.start(&point), Err(NotTaken::NonFinite));
            assert_eq!(trajectory.push(3, &point), Err(NotTaken::NonFinite));
        }
    }
    // The point is finite, but the segment to it is not.
    assert_eq!(trajectory.push(3, &point(f32::MAX, 0.0, 0.0)), Err(NotTaken::NonFinite));
    assert_eq!((trajectory.room(), trajectory.now.as_ref()), (WAYS, Some(&point(1.0, 0.0, 0.0))));
}
