//! Products of small matrices, written out.
//!
//! nalgebra's own matrix product goes through a general kernel that also multiplies by one; a counting or tracing scalar
//! would see those. Here one product is one product, in a fixed order, so bits and counts can be stated.

use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};

/// `M v`: 9 multiplications, 6 additions.
#[inline]
#[must_use]
pub fn apply<S: Scalar>(m: &Matrix3<S>, v: &Vector3<S>) -> Vector3<S> {
    Vector3::new(
        m.m11 * v.x + m.m12 * v.y + m.m13 * v.z,
        m.m21 * v.x + m.m22 * v.y + m.m23 * v.z,
        m.m31 * v.x + m.m32 * v.y + m.m33 * v.z,
    )
}

/// `M^T v`: 9 multiplications, 6 additions.
#[inline]
#[must_use]
pub fn apply_transposed<S: Scalar>(m: &Matrix3<S>, v: &Vector3<S>) -> Vector3<S> {
    Vector3::new(
        m.m11 * v.x + m.m21 * v.y + m.m31 * v.z,
        m.m12 * v.x + m.m22 * v.y + m.m32 * v.z,
        m.m13 * v.x + m.m23 * v.y + m.m33 * v.z,
    )
}

/// `A B`, column by column.
#[must_use]
pub fn compose<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    Matrix3::from_columns(&[
        apply(a, &b.column(0).into()),
        apply(a, &b.column(1).into()),
        apply(a, &b.column(2).into()),
    ])
}

/// Entries within 1e-15 of 0, 1 and -1 become exactly that: the cosine of a right angle is zero, not 6e-17.
///
/// Right angles in a robot's table then cost nothing in a traced kernel and add no rounding.
#[must_use]
pub fn snap(m: &Matrix3<f64>) -> Matrix3<f64> {
    m.map(snap_scalar)
}

fn snap_scalar(x: f64) -> f64 {
    const NEAR: f64 = 1e-15;
    if x.abs() < NEAR {
        0.0
    } else if (x - 1.0).abs() < NEAR {
        1.0
    } else if (x + 1.0).abs() < NEAR {
        -1.0
    } else {
        x
    }
}

/// Rotation by `angle` (rad) about x, right angles exact.
#[must_use]
pub fn about_x(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    snap(&Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c))
}

/// Rotation by `angle` (rad) about y, right angles exact.
#[must_use]
pub fn about_y(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    snap(&Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c))
}

/// Rotation by `angle` (rad) about z, right angles exact.
#[must_use]
pub fn about_z(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    snap(&Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0))
}

/// URDF's fixed-axis roll, pitch, yaw: `Rz(yaw) Ry(pitch) Rx(roll)`, rad.
#[must_use]
pub fn from_rpy(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
    snap(&(about_z(yaw) * about_y(pitch) * about_x(roll)))
}
