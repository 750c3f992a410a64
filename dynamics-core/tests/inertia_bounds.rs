//! A payload that is set at run time: it is accepted if and only if some mass distribution inside a ball could have it, in single precision
//! too.

use dynamics_core::{Inertia, InertiaBounds};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const BOUNDS: InertiaBounds<f64> = InertiaBounds { mass: 4.0, radius: 0.3 };

fn points(all: &[(f64, Vector3<f64>)]) -> Inertia<f64> {
    all.iter().fold(Inertia::zero(), |sum, (mass, at)| sum + Inertia::from_mass_centre(*mass, at, &Matrix3::zeros()))
}

/// Both precisions must agree: the tested bodies are farther from the bounds than the rounding of an f32.
fn is_within(body: &Inertia<f64>) -> bool {
    let (double, single) = (body.is_within(&BOUNDS), body.cast::<f32>().is_within(&BOUNDS.cast()));
    assert_eq!(double, single, "{body:?}");
    double
}

/// A mass, and a position in a ball of this radius.
fn place(radius: f64) -> impl Strategy<Value = (f64, Vector3<f64>)> {
    (0.001..1.0, prop::array::uniform3(-1.0..1.0_f64)).prop_filter_map("outside the ball", move |(mass, at)| {
        let at = Vector3::from(at);
        (at.norm() <= 1.0).then(|| (mass, at * radius))
    })
}

proptest! {
    #[test]
    fn whatever_lies_in_the_ball_is_taken_down_to_a_single_point(all in prop::collection::vec(place(BOUNDS.radius), 1..5)) {
        let body = points(&all);
        prop_assume!(body.mass <= BOUNDS.mass);
        prop_assert!(is_within(&body));
    }

    #[test]
    fn a_body_all_outside_or_too_heavy_is_not(direction in place(1.0), far in 1.001..10.0_f64, heavy in 1.000_01..10.0_f64) {
        let (mass, at) = direction;
        prop_assume!(at.norm() > 0.01);
        let at = at.normalize() * BOUNDS.radius;
        prop_assert!(!is_within(&points(&[(mass, at * far)])));
        prop_assert!(!is_within(&points(&[(BOUNDS.mass * heavy, at * 0.5)])));
    }

    /// A mass centre farther out than all of the mass, and principal moments with a largest one that no mass distribution can have.
    #[test]
    fn what_no_matter_has_is_not(all in prop::collection::vec(place(0.2), 4..7), axis in 0..3_usize) {
        let body = points(&all);
        let spread = body.about_origin.trace() * 0.5 - body.about_origin[(axis, axis)];
        prop_assume!(spread > 0.01 * body.mass * BOUNDS.radius.powi(2));
        // The moment about this axis exceeds the sum of the other two.
        let mut wide = body;
        wide.about_origin[(axis, axis)] += 2.1 * spread;
        prop_assert!(!is_within(&wide));
        let mut moved = body;
        moved.first_moment[axis] = (spread * body.mass).sqrt() * 1.1;
        prop_assert!(!is_within(&moved));
    }
}

#[test]
fn nothing_is_something_that_can_be_and_moments_without_mass_are_not() {
    let zero = Inertia::<f64>::zero();
    assert!(is_within(&zero));
    assert!(!is_within(&Inertia { first_moment: Vector3::new(0.0, 0.0, 0.1), ..zero }));
    assert!(!is_within(&Inertia { about_origin: Matrix3::from_diagonal(&Vector3::new(0.1, -0.1, 0.0)), ..zero }));
}

#[test]
fn a_ball_a_rod_and_a_plate_are_taken() {
    let diagonal = |x, y, z| Matrix3::from_diagonal(&Vector3::new(x, y, z));
    let (m, r) = (2.0, 0.29);
    for moments in [
        diagonal(0.4 * m * r * r, 0.4 * m * r * r, 0.4 * m * r * r),
        diagonal(0.0, m * r * r / 3.0, m * r * r / 3.0),
        diagonal(m * r * r / 4.0, m * r * r / 4.0, m * r * r / 2.0),
    ] {
        assert!(is_within(&Inertia::from_mass_centre(m, &Vector3::zeros(), &moments)));
    }
}

#[test]
fn numbers_that_are_none_and_less_than_nothing_are_not() {
    let body = points(&[(1.0, Vector3::new(0.1, 0.0, 0.0)), (1.0, Vector3::new(0.0, 0.1, 0.1))]);
    assert!(is_within(&body));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
        assert!(!is_within(&Inertia { mass: bad, ..body }), "mass {bad}");
        for (row, column) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let mut broken = body;
            broken.about_origin[(row, column)] = bad;
            broken.about_origin[(column, row)] = bad;
            assert!(!is_within(&broken), "entry {row}, {column}: {bad}");
        }
        for axis in 0..3 {
            let mut broken = body;
            broken.first_moment[axis] = bad;
            assert!(!is_within(&broken), "first moment {axis}: {bad}");
        }
    }
}
