//! Approximate shapes of links, from their joints and centres of mass alone.

use super::cell::Part;
use super::shape::Shape;
use dynamics_core::Model;
use nalgebra::Vector3;

/// Default radius of a link, as a share of the arm's length.
const RADIUS: f64 = 0.06;

/// Length of the arm, m: from the base to the tip through all joints and centres of mass.
#[must_use]
pub fn length<const N: usize>(model: &Model<f64, N>) -> f64 {
    (0..=N).map(|frame| skeleton(model, frame).windows(2).map(|line| (line[1] - line[0]).norm()).sum::<f64>()).sum()
}

/// Default radius of a link, m: 6 % of the arm's length.
#[must_use]
pub fn usual_radius<const N: usize>(model: &Model<f64, N>) -> f64 {
    RADIUS * length(model)
}

/// Capsules along a link: from its joint through its centre of mass to the next joint, or to the tip.
///
/// `frame` 0 is the base, from the origin of the base frame to the first joint. A centre of mass that is nearer to the straight line than half the
/// radius is ignored.
#[must_use]
pub fn capsules<const N: usize>(model: &Model<f64, N>, frame: usize, name: &str, radius: f64) -> Vec<Part> {
    let mut line = skeleton(model, frame);
    if let [start, centre, end] = line[..]
        && off_line(&centre, &start, &end) < 0.5 * radius
    {
        line = vec![start, end];
    }
    let part = |ends: &[Vector3<f64>]| Some(Part::link(name, frame, Shape::capsule(ends[0], ends[1], radius)?));
    line.windows(2).filter_map(part).collect()
}

/// Joint, centre of mass if there is one, and next joint, in the link's frame.
fn skeleton<const N: usize>(model: &Model<f64, N>, frame: usize) -> Vec<Vector3<f64>> {
    let end = model.links().get(frame).map_or(model.tip().translation, |next| next.translation);
    let body = frame.checked_sub(1).map(|link| model.links()[link].inertia).filter(|body| body.mass > 0.0);
    let centre = body.map(|body| body.first_moment / body.mass);
    std::iter::once(Vector3::zeros()).chain(centre).chain(std::iter::once(end)).collect()
}

fn off_line(point: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let along = b - a;
    let share = if along.norm_squared() > 0.0 { (point - a).dot(&along) / along.norm_squared() } else { 0.0 };
    (point - (a + along * share.clamp(0.0, 1.0))).norm()
}
