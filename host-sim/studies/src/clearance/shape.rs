//! Convex shapes: hulls of points, thickened by a radius.

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::math::{Matrix, Pose, Rotation, Vector};
use parry3d_f64::query::details::closest_points_segment_segment_with_locations;
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::{Segment, SupportMap};
use std::f64::consts::PI;

/// Largest number of points of a shape. A mesh with more is simplified, and its radius grows by the distance of the points that are left outside.
const POINTS: usize = 160;
/// Corners of the prism that encloses a cylinder.
const CORNERS: usize = 16;
/// Subtracted from every distance to allow for rounding, m.
const ROUNDING: f64 = 1e-9;

/// Convex hull of points, thickened by a radius. A sphere has one point, a capsule two, a box eight.
#[derive(Clone, Debug)]
pub struct Shape {
    hull: Hull,
    radius: f64,
    /// Centre and radius of a ball that contains the shape.
    ball: (Vector, f64),
}

#[derive(Clone, Debug)]
struct Hull(Vec<Vector>);

impl SupportMap for Hull {
    fn local_support_point(&self, along: Vector) -> Vector {
        let mut best = (f64::NEG_INFINITY, Vector::ZERO);
        for point in &self.0 {
            let far = point.dot(along);
            if far > best.0 {
                best = (far, *point);
            }
        }
        best.1
    }
}

impl Hull {
    /// Segment of a capsule or a sphere; `None` for other shapes.
    fn line(&self) -> Option<Segment> {
        match self.0.as_slice() {
            [a] => Some(Segment::new(*a, *a)),
            [a, b] => Some(Segment::new(*a, *b)),
            _ => None,
        }
    }
}

fn to_parry(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Pose of a frame in base axes.
#[must_use]
pub(crate) fn pose(rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Pose {
    let column = |k: usize| to_parry(&rotation.column(k).into_owned());
    let turned = Rotation::from_mat3(&Matrix::from_cols(column(0), column(1), column(2)));
    Pose::from_parts(to_parry(translation), turned)
}

impl Shape {
    /// Creates the hull of points (m), thickened by `radius`, m. `None` without points, or if a number is not finite.
    ///
    /// If there are more than 160 points, keeps the farthest point along each of 160 directions. The radius then grows by the distance of the
    /// farthest point outside, so that the shape still contains all of them.
    #[must_use]
    pub fn hull(points: &[Vector3<f64>], radius: f64) -> Option<Self> {
        let good = radius >= 0.0 && radius.is_finite() && points.iter().all(|p| p.iter().all(|x| x.is_finite()));
        if points.is_empty() || !good {
            return None;
        }
        let all: Vec<Vector> = points.iter().map(to_parry).collect();
        let mut shape = Self::of(all.clone(), radius);
        if all.len() > POINTS {
            let whole = Hull(all);
            let mut kept: Vec<Vector> = directions().map(|along| whole.local_support_point(along)).collect();
            kept.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap_or(std::cmp::Ordering::Equal));
            kept.dedup();
            let simple = Hull(kept);
            let outside = whole.0.iter().map(|p| upper(&simple, &Hull(vec![*p]))).fold(0.0, f64::max);
            shape = Self::of(simple.0, radius + outside);
        }
        Some(shape)
    }

    fn of(points: Vec<Vector>, radius: f64) -> Self {
        let (mut low, mut high) = (Vector::splat(f64::INFINITY), Vector::splat(f64::NEG_INFINITY));
        for point in &points {
            (low, high) = (low.min(*point), high.max(*point));
        }
        let centre = 0.5 * (low + high);
        let ball = points.iter().map(|p| (*p - centre).length()).fold(0.0, f64::max) + radius;
        Self { hull: Hull(points), radius, ball: (centre, ball) }
    }

    /// Creates the segment from `a` to `b` (m), thickened by `radius`, m. `None` if a number is not finite.
    #[must_use]
    pub fn capsule(a: Vector3<f64>, b: Vector3<f64>, radius: f64) -> Option<Self> {
        Self::hull(&[a, b], radius)
    }

    /// Creates a box about the origin with these edges, m, rotated by `rotation` and moved to `centre`, m. `None` if a number is not finite.
    #[must_use]
    pub fn cuboid(rotation: &Matrix3<f64>, centre: &Vector3<f64>, edges: &Vector3<f64>) -> Option<Self> {
        let half = 0.5 * edges;
        let corner = |k: usize| {
            let sign = |bit: usize| if k & bit == 0 { -1.0 } else { 1.0 };
            centre + rotation * Vector3::new(sign(1) * half.x, sign(2) * half.y, sign(4) * half.z)
        };
        Self::hull(&(0..8).map(corner).collect::<Vec<_>>(), 0.0)
    }

    /// Creates a prism of 16 sides that encloses a cylinder along the local z axis, up to 2 % wider. `None` if a number is not finite.
    #[must_use]
    pub fn cylinder(rotation: &Matrix3<f64>, centre: &Vector3<f64>, radius: f64, length: f64) -> Option<Self> {
        let wide = radius / (PI / CORNERS as f64).cos();
        let corner = |k: usize| {
            let (sin, cos) = (2.0 * PI * (k / 2) as f64 / CORNERS as f64).sin_cos();
            let z = if k.is_multiple_of(2) { 0.5 } else { -0.5 } * length;
            centre + rotation * Vector3::new(wide * cos, wide * sin, z)
        };
        Self::hull(&(0..2 * CORNERS).map(corner).collect::<Vec<_>>(), 0.0)
    }

    /// Distance of the farthest point from the frame's origin, m.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.hull.0.iter().map(|p| p.length()).fold(0.0, f64::max) + self.radius
    }

    /// Gap to another shape in the same frame, m: exact up to rounding, and never too large. If the hulls overlap, minus the sum of both radii.
    #[must_use]
    pub fn distance(&self, other: &Self) -> f64 {
        self.gap(&Pose::IDENTITY, other, &Pose::IDENTITY)
    }

    /// Lower bound on the gap to another shape, m, from enclosing balls; cheap to compute.
    pub(crate) fn gap_of_balls(&self, here: &Pose, other: &Self, there: &Pose) -> f64 {
        let between = here.transform_point(self.ball.0) - there.transform_point(other.ball.0);
        between.length() - self.ball.1 - other.ball.1 - ROUNDING
    }

    /// Same as [`Shape::distance`], with a separate frame for each shape.
    pub(crate) fn gap(&self, here: &Pose, other: &Self, there: &Pose) -> f64 {
        let relative = here.inv_mul(there);
        lower(&self.hull, &other.hull, &relative) - self.radius - other.radius - ROUNDING
    }

    /// Height of the lowest point above a plane, m.
    pub(crate) fn above(&self, here: &Pose, up: Vector, height: f64) -> f64 {
        let down = self.hull.local_support_point(here.inverse_transform_vector(-up));
        here.transform_point(down).dot(up) - self.radius - height - ROUNDING
    }
}

/// Directions that are spread evenly over a sphere, along a golden spiral.
fn directions() -> impl Iterator<Item = Vector> {
    (0..POINTS).map(|k| {
        let z = 1.0 - (2 * k + 1) as f64 / POINTS as f64;
        let (sin, cos) = (k as f64 * PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector::new(r * cos, r * sin, z)
    })
}

/// Nearest points of two hulls in the frame of the first; `None` if they overlap.
fn nearest(a: &Hull, b: &Hull, a_from_b: &Pose) -> Option<(Vector, Vector)> {
    let mut simplex = VoronoiSimplex::new();
    let towards = a_from_b.transform_point(b.0[0]) - a.0[0];
    let start = if towards.length_squared() > 0.0 { towards.normalize() } else { Vector::X };
    simplex.reset(CsoPoint::from_shapes(a_from_b, a, b, start));
    match closest_points(a_from_b, a, b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(p, q, _) => Some((p, q)),
        _ => None,
    }
}

/// Distance of two hulls, m, never too large.
///
/// The search for the nearest points may stop early. The extents of both hulls along the line between the found points give a gap that is valid for
/// any such points.
fn lower(a: &Hull, b: &Hull, a_from_b: &Pose) -> f64 {
    if let (Some(one), Some(other)) = (a.line(), b.line()) {
        let (s, t) = closest_points_segment_segment_with_locations(a_from_b, &one, &other);
        return (one.point_at(&s) - a_from_b.transform_point(other.point_at(&t))).length();
    }
    let Some((p, q)) = nearest(a, b, a_from_b) else { return 0.0 };
    let Some(along) = (q - p).try_normalize() else { return 0.0 };
    let far = a.local_support_point(along).dot(along);
    let near = b.local_support_point(a_from_b.inverse_transform_vector(-along));
    (a_from_b.transform_point(near).dot(along) - far).max(0.0)
}

/// Distance of two hulls in the same frame, up to rounding, m.
fn upper(a: &Hull, b: &Hull) -> f64 {
    nearest(a, b, &Pose::IDENTITY).map_or(0.0, |(p, q)| (p - q).length())
}
