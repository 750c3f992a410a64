//! Gaps between shapes, compared with closed forms.

use dynamics_core::geometry::from_rpy;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_4, PI};
use studies::clearance::shape::Shape;

fn at(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

fn sphere(centre: Vector3<f64>, radius: f64) -> Shape {
    Shape::hull(&[centre], radius).unwrap()
}

fn cube(rotation: Matrix3<f64>) -> Shape {
    Shape::cuboid(&rotation, &at(0.0, 0.0, 0.0), &at(2.0, 2.0, 2.0)).unwrap()
}

#[test]
fn gaps_are_those_of_closed_forms() {
    let straight = Matrix3::identity();
    let lying = Shape::capsule(at(-1.0, 0.0, 0.0), at(1.0, 0.0, 0.0), 0.1).unwrap();
    let crossed = Shape::capsule(at(0.3, -1.0, 0.7), at(0.3, 1.0, 0.7), 0.2).unwrap();
    let cylinder = Shape::cylinder(&straight, &at(0.0, 0.0, 0.0), 0.5, 2.0).unwrap();
    let cases = [
        ("two spheres", sphere(at(0.0, 0.0, 0.0), 0.3).distance(&sphere(at(3.0, 4.0, 0.0), 0.7)), 4.0),
        ("crossed capsules", lying.distance(&crossed), 0.4),
        ("parallel capsules", lying.distance(&Shape::capsule(at(0.5, 0.9, 0.0), at(5.0, 0.9, 0.0), 0.3).unwrap()), 0.5),
        ("end of a capsule", lying.distance(&sphere(at(1.0 + 3.0, 4.0, 0.0), 0.0)), 4.9),
        ("face of a box", cube(straight).distance(&sphere(at(0.4, -0.2, 2.5), 0.5)), 1.0),
        ("edge of a box", cube(straight).distance(&sphere(at(4.0, 5.0, 0.3), 0.0)), 5.0),
        ("corner of a box", cube(straight).distance(&sphere(at(2.0, 3.0, 3.0), 0.5)), 2.5),
        (
            "turned box",
            cube(from_rpy(0.0, 0.0, FRAC_PI_4)).distance(&sphere(at(3.0, 0.0, 0.0), 0.0)),
            3.0 - 2.0_f64.sqrt(),
        ),
        (
            "two boxes",
            cube(straight).distance(&Shape::cuboid(&straight, &at(3.0, 0.5, 0.2), &at(1.0, 1.0, 1.0)).unwrap()),
            1.5,
        ),
        (
            "line beside a box",
            cube(straight).distance(&Shape::capsule(at(-5.0, 2.0, 2.0), at(5.0, 2.0, 2.0), 0.1).unwrap()),
            2.0_f64.sqrt() - 0.1,
        ),
        ("lid of a cylinder", cylinder.distance(&sphere(at(0.2, 0.1, 2.0), 0.25)), 0.75),
    ];
    for (name, found, expected) in cases {
        assert!((found - expected).abs() < 1e-7, "{name}: {found}, {expected}");
    }
    // If the hulls overlap: the sum of the radii. If only the thickened parts overlap: the depth.
    assert!((lying.distance(&sphere(at(0.5, 0.0, 0.0), 0.2)) + 0.3).abs() < 1e-7);
    assert!((cube(straight).distance(&sphere(at(0.1, 0.2, 0.3), 0.2)) + 0.2).abs() < 1e-7);
    assert!((lying.distance(&sphere(at(0.5, 0.25, 0.0), 0.2)) + 0.05).abs() < 1e-7);
    // The prism that encloses a cylinder is up to 2 % wider, never narrower.
    let beside = cylinder.distance(&sphere(at(2.0 * (PI / 7.0).cos(), 2.0 * (PI / 7.0).sin(), 0.0), 0.0));
    assert!((1.49..1.5).contains(&beside), "{beside}");
}

#[test]
fn a_simplified_mesh_still_contains_all_of_its_points() {
    // A sphere approximated by 10,000 points, for which the true gap is known.
    let points: Vec<Vector3<f64>> = (0..10_000)
        .map(|k| {
            let z = 1.0 - (2 * k + 1) as f64 / 10_000.0;
            let (sin, cos) = (f64::from(k) * 2.4).sin_cos();
            let r = (1.0 - z * z).sqrt();
            0.1 * at(r * cos, r * sin, z)
        })
        .collect();
    let ball = Shape::hull(&points, 0.0).unwrap();
    for (k, direction) in [at(1.0, 0.0, 0.0), at(0.3, -0.8, 0.5), at(-0.2, 0.1, -0.9)].iter().enumerate() {
        let true_gap = 0.4 - 0.02;
        let found = ball.distance(&sphere(direction.normalize() * 0.5, 0.02));
        assert!(found <= true_gap + 1e-4 && found > true_gap - 0.003, "{k}: {found}, {true_gap}");
    }
    let farthest = points.iter().map(|p| ball.distance(&sphere(*p, 0.0))).fold(f64::MIN, f64::max);
    assert!(farthest <= 0.0, "a point lies outside by {farthest} m");
}

#[test]
fn numbers_that_are_none_make_no_shape() {
    assert!(Shape::hull(&[], 0.1).is_none());
    assert!(Shape::hull(&[at(f64::NAN, 0.0, 0.0)], 0.1).is_none());
    assert!(Shape::capsule(at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), -0.1).is_none());
    assert!(Shape::hull(&[at(0.0, 0.0, 0.0)], f64::INFINITY).is_none());
}
