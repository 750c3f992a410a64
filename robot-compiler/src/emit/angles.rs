//! Roll, pitch and yaw of a rotation, with the fewest digits that reproduce its matrix.

use dynamics_core::geometry::from_rpy;
use nalgebra::Matrix3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Most decimals that are tried.
const DECIMALS: usize = 16;
/// Rounding errors of a matrix entry, with a margin for its computation.
const ROUNDING: f64 = 2e-15;

/// Angles `r, p, y`, rad, for which `Rz(y) Ry(p) Rx(r)` is the matrix. If none of the angles tried reproduces its bits exactly, returns
/// those that come nearest.
///
/// Angles computed from a matrix have errors in their last digits. Each angle is tried as computed, with as few decimals as it may
/// have had in a file, and changed by a few units in the last place.
pub(super) fn roll_pitch_yaw(rotation: &Matrix3<f64>) -> [f64; 3] {
    let (across, down) = (rotation.m11.hypot(rotation.m21), -rotation.m31);
    let pitch = down.atan2(across);
    // Pitched straight up or down, roll and yaw turn about the same axis: all of the turn becomes roll.
    let straight = across < ROUNDING;
    let [roll, yaw] = if straight {
        [down.signum() * rotation.m12.atan2(rotation.m22), 0.0]
    } else {
        [rotation.m32.atan2(rotation.m33), rotation.m21.atan2(rotation.m11)]
    };
    let pitch = if straight { down.signum() * FRAC_PI_2 } else { pitch };
    let slack = if straight { ROUNDING } else { (ROUNDING / across).min(1e-4) };
    // The same rotation, pitched over the top.
    let over = [opposite(roll), PI.copysign(pitch) - pitch, opposite(yaw)];
    let mut best = ([roll, pitch, yaw], f64::INFINITY);
    for [roll, pitch, yaw] in [[roll, pitch, yaw], over] {
        let pitches = candidates(pitch, ROUNDING.sqrt().min(slack));
        for (&r, &p, &y) in product(&candidates(roll, slack), &pitches, &candidates(yaw, slack)) {
            let off = (from_rpy(r, p, y) - rotation).amax();
            if off < best.1 {
                best = ([r, p, y], off);
            }
        }
    }
    best.0
}

fn opposite(angle: f64) -> f64 {
    angle - PI.copysign(angle)
}

fn product<'a>(a: &'a [f64], b: &'a [f64], c: &'a [f64]) -> impl Iterator<Item = (&'a f64, &'a f64, &'a f64)> {
    a.iter().flat_map(move |a| b.iter().flat_map(move |b| c.iter().map(move |c| (a, b, c))))
}

/// Angles that this one may stand for; near half a turn, also those with the other sign.
fn candidates(angle: f64, slack: f64) -> Vec<f64> {
    let mut all = near(angle, slack);
    if angle.abs() > 3.0 {
        all.extend(near(angle - TAU.copysign(angle), slack));
    }
    all
}

/// An angle with the fewest decimals within the slack, a fraction of half a turn, the angle itself, and its neighbours.
fn near(angle: f64, slack: f64) -> Vec<f64> {
    let rounded = (0..=DECIMALS).filter_map(|decimals| format!("{angle:.decimals$}").parse::<f64>().ok());
    // Adding zero removes the sign of a rounded -0.
    let mut all: Vec<f64> = rounded.filter(|short| (short - angle).abs() <= slack).map(|short| short + 0.0).collect();
    all.truncate(3);
    let parts = (angle / PI * 12.0).round() * PI / 12.0;
    if (parts - angle).abs() <= slack {
        all.push(parts);
    }
    all.push(angle);
    let (mut up, mut down) = (angle, angle);
    for _ in 0..2 {
        (up, down) = (up.next_up(), down.next_down());
        all.extend([up, down]);
    }
    all
}
