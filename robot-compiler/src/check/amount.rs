//! Numbers in findings.

use crate::describe::robot::RobotJoint;
use dynamics_core::JointKind;

/// Three digits, with an exponent for tiny or huge numbers.
pub(super) fn digits(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{x:.2e}");
    }
    let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
    format!("{x:.decimals$}")
}

/// Three digits and a unit.
pub(super) fn amount(x: f64, unit: &str) -> String {
    format!("{} {unit}", digits(x))
}

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share))
}

/// Units of a joint.
#[derive(Clone, Copy)]
pub(super) struct Units {
    pub(super) torque: &'static str,
    pub(super) velocity: &'static str,
    pub(super) position: &'static str,
    pub(super) inertia: &'static str,
}

impl Units {
    pub(super) const fn of(joint: &RobotJoint) -> Self {
        match joint.spec.kind {
            JointKind::Revolute => Self { torque: "N m", velocity: "rad/s", position: "rad", inertia: "kg m^2" },
            JointKind::Prismatic => Self { torque: "N", velocity: "m/s", position: "m", inertia: "kg" },
        }
    }
}

/// "a, b and c".
pub(super) fn names<'a>(joints: impl IntoIterator<Item = &'a RobotJoint>) -> String {
    let names: Vec<&str> = joints.into_iter().map(|joint| joint.name.as_str()).collect();
    match names.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => names.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_have_three_digits() {
        let found = [0.0, 0.007, 0.4698, 13.44, 123.4, 1234.5, 1.26e-4, 2e6, f64::INFINITY].map(digits);
        assert_eq!(found, ["0", "0.00700", "0.470", "13.4", "123", "1234", "1.26e-4", "2.00e6", "inf"]);
    }
}
