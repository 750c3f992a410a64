//! The likely cause of a joint torque that differs from the commanded torque by a constant factor.
//!
//! | factor (actual over commanded torque) | likely cause |
//! |---|---|
//! | negative | direction of the drive, two swapped motor phases |
//! | `1 / gear` | the gear is counted twice |
//! | `gear` | the gear is not counted |
//! | another actuator's torque range over this one's | the drive is set to that range |
//! | 1.5, sqrt 2, sqrt 3, or an inverse of these | convention of the torque constant: peak or rms current, phase or line |
//! | the same on every joint | a unit common to all drives, for example current in place of torque |
//! | any other | torque constant of this drive, for example current in place of torque |

use robot_compiler::RobotJoint;
use robot_compiler::drive::JointDrive;

/// Relative error of a factor that still matches a cause. Friction alone explains a few percent.
const NEAR: f64 = 0.1;

/// Smallest gear ratio that a factor can reveal: below it, friction explains the difference.
const GEAR_MIN: f64 = 1.3;

/// Factors between conventions of the torque constant.
const CONVENTIONS: [(f64, &str); 3] = [
    (1.5, "the factor 3/2 of the phase transformation"),
    (std::f64::consts::SQRT_2, "peak current in place of rms current"),
    (1.732_050_807_568_877_2, "line values in place of phase values"),
];

/// Data of a joint's drive with which a factor is compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct DriveNumbers {
    /// Ratios of the gears between motor and joint, as magnitudes.
    gears: Vec<f64>,
    /// Torque range of its frames, N m.
    range: Option<f64>,
    /// Other actuators with the same frames: name and torque range, N m.
    others: Vec<(&'static str, f64)>,
}

impl DriveNumbers {
    /// Reads the data of a joint of a robot file.
    pub(super) fn of(joint: &RobotJoint) -> Self {
        let mut gears = vec![joint.spec.rotor.gear.abs()];
        let (mut range, mut others) = (None, Vec::new());
        match &joint.drive {
            Some(JointDrive::Mit(spec)) => {
                gears.push(spec.ratio.abs());
                range = Some(spec.torque.1);
                let same = robot_compiler::actuators().iter().filter(|other| other.protocol == spec.protocol);
                others.extend(same.map(|other| (other.name.as_str(), other.torque)));
            }
            Some(JointDrive::Pwm(spec)) => gears.push(spec.ratio.abs()),
            None => {}
        }
        gears.retain(|gear| gear.is_finite() && *gear >= GEAR_MIN);
        Self { gears, range, others }
    }

    /// The likely cause of a factor. `common` is true if at least two joints can be judged and all of them have this factor.
    pub(super) fn cause(&self, factor: f64, common: bool) -> String {
        if factor < 0.0 {
            return "the drive's direction (`direction` in the robot file), or two swapped motor phases".into();
        }
        for gear in &self.gears {
            if near(factor, 1.0 / gear) {
                return format!("the gear of {gear} is counted twice: in the drive and in the robot file");
            }
            if near(factor, *gear) {
                return format!(
                    "the gear of {gear} is not counted: the drive takes motor torque, the robot file says joint torque"
                );
            }
        }
        if let Some(range) = self.range {
            let set_to = |(_, other): &&(&str, f64)| !near(*other, range) && near(factor, other / range);
            if let Some((name, other)) = self.others.iter().find(set_to) {
                return format!(
                    "the torque range: the drive is set to +-{other} N m, as a {name} is; the robot file says +-{range} N m"
                );
            }
        }
        if common {
            return "a unit common to all drives: current (A) in place of torque (N m), or one wrong torque constant for all".into();
        }
        // The conventions' factors are close to each other: the nearest one counts.
        let off = |of: f64| (factor.ln() - of.ln()).abs().min((factor.ln() + of.ln()).abs());
        let nearest = CONVENTIONS.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
        let convention = nearest.filter(|(of, _)| near(factor, *of) || near(factor, 1.0 / of));
        match convention {
            Some((_, which)) => format!("the torque constant of this drive: {which}"),
            None => "the torque constant of this drive: a current (A) in place of a torque (N m), or another motor's constant; then its \
                     gear and torque range"
                .into(),
        }
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= NEAR * b.abs()
}

/// True if there are at least two factors, and all are about the same.
pub(super) fn common(factors: &[f64]) -> bool {
    factors.len() > 1 && factors.iter().all(|factor| factors.first().is_some_and(|first| near(*factor, *first)))
}

#[cfg(test)]
mod tests {
    use super::{DriveNumbers, common};

    #[test]
    fn a_factor_names_its_likely_cause() {
        let geared =
            DriveNumbers { gears: vec![4.0], range: Some(28.0), others: vec![("DM4310", 10.0), ("DM4340", 28.0)] };
        let plain = DriveNumbers::default();
        for (drive, factor, together, cause) in [
            (&geared, -1.0, false, "direction"),
            (&geared, 0.25, false, "the gear of 4 is counted twice"),
            (&geared, 4.0, false, "the gear of 4 is not counted"),
            (&geared, 10.0 / 28.0, false, "set to +-10 N m, as a DM4310 is"),
            (&plain, 0.25, true, "current (A) in place of torque"),
            (&plain, 4.0, true, "current (A) in place of torque"),
            (&plain, 0.25, false, "torque constant of this drive: a current"),
            (&plain, 1.5, false, "3/2"),
            (&plain, 0.707, false, "rms current"),
            (&plain, 1.73, false, "line values"),
        ] {
            let found = drive.cause(factor, together);
            assert!(found.contains(cause), "{factor}: {found}");
        }
    }

    #[test]
    fn one_factor_alone_is_not_common() {
        assert!(!common(&[4.0]) && common(&[4.0, 3.9]) && !common(&[4.0, 1.5]));
    }
}
