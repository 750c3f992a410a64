//! Vectors in the plane of a linkage.

use crate::scalar::Real;
use nalgebra::Vector2;

/// `a x b`, its part along z.
pub(crate) fn cross<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> S {
    a.x * b.y - a.y * b.x
}

/// `z x a`: the vector turned by a quarter turn.
pub(crate) fn quarter_turn<S: Real>(a: &Vector2<S>) -> Vector2<S> {
    Vector2::new(-a.y, a.x)
}

/// Inner product; nalgebra's own goes through a general kernel.
pub(crate) fn dot<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> S {
    a.x * b.x + a.y * b.y
}

/// A point of a link's frame whose x lies along the unit vector `direction`.
pub(super) fn placed<S: Real>(direction: &Vector2<S>, point: &Vector2<S>) -> Vector2<S> {
    direction * point.x + quarter_turn(direction) * point.y
}
