//! Placement of a frame: `<origin>`.

use super::markup::Markup;
use crate::describe::diagnostics::FileError;
use dynamics_core::geometry::from_rpy;
use dynamics_core::model::Placement;
use nalgebra::{Matrix3, Vector3};
use roxmltree::Node;
use std::f64::consts::FRAC_PI_2;

/// The identity placement.
pub(super) fn here() -> Placement<f64> {
    Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() }
}

/// The placement of an `<origin>`; the identity if there is none.
pub(super) fn origin<'a>(
    markup: &Markup<'a>,
    element: Option<&Node<'a, 'a>>,
    label: &str,
) -> Result<Placement<f64>, FileError> {
    let Some(element) = element else { return Ok(here()) };
    let xyz = markup.finite(element, "xyz", label)?.unwrap_or([0.0; 3]);
    let [roll, pitch, yaw] = rpy(markup, element, label)?;
    Ok(Placement { rotation: from_rpy(roll, pitch, yaw), translation: Vector3::from(xyz) })
}

/// Roll, pitch and yaw; from version 1.1 on, a quaternion may replace them.
fn rpy<'a>(markup: &Markup<'a>, element: &Node<'a, 'a>, label: &str) -> Result<[f64; 3], FileError> {
    const QUATERNION: &str = "quat_xyzw";
    let angles = markup.finite(element, "rpy", label)?;
    // Before version 1.1 the attribute is ignored, like any unknown one.
    if markup.version < (1, 1) || !element.has_attribute(QUATERNION) {
        return Ok(angles.unwrap_or([0.0; 3]));
    }
    if angles.is_some() {
        let field = format!("{label}.origin.{QUATERNION}");
        return Err(markup.error(element, field, "given beside `rpy`", "one of `rpy` and `quat_xyzw`"));
    }
    Ok(markup.finite(element, QUATERNION, label)?.map_or([0.0; 3], angles_of))
}

/// Roll, pitch and yaw of a quaternion of any length, as `urdf::Rotation::getRPY` of urdfdom_headers gives them.
fn angles_of(quaternion: [f64; 4]) -> [f64; 3] {
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z, w] = if norm > 0.0 { quaternion.map(|x| x / norm) } else { [0.0, 0.0, 0.0, 1.0] };
    let sin_pitch = -2.0 * (x * z - w * y);
    if sin_pitch <= -0.99999 {
        [0.0, -FRAC_PI_2, 2.0 * x.atan2(-y)]
    } else if sin_pitch >= 0.99999 {
        [0.0, FRAC_PI_2, 2.0 * (-x).atan2(y)]
    } else {
        let (xx, yy, zz, ww) = (x * x, y * y, z * z, w * w);
        [
            (2.0 * (y * z + w * x)).atan2(ww - xx - yy + zz),
            sin_pitch.asin(),
            (2.0 * (x * y + w * z)).atan2(ww + xx - yy - zz),
        ]
    }
}
