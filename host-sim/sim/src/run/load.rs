//! Load of a run on the arm: the nearest limit, the work of the torques.

use crate::run::numbers::rms;
use crate::run::record::Record;
use robot_compiler::{Robot, RobotJoint};
use serde::Serialize;

/// The limit that a joint came nearest to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosestLimit {
    /// Joint, counted from 1.
    pub joint: usize,
    /// `position`, `velocity` or `torque`.
    pub limit: &'static str,
    /// Greatest used share of the limit; 1 at the limit. For a position: distance from the middle of the range over half of the range.
    pub used: f64,
    /// Tick of the greatest share, counted from 0.
    pub tick: usize,
}

/// Mechanical work of the commanded torques per joint, J: in each tick, `sum tau_k (q_{k+1} - q_k)` is added to the positive or negative work by its
/// sign. This is exact if the torque is constant over a tick, as with ideal drives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Work {
    /// Positive work.
    pub given: Vec<f64>,
    /// Negative work; not above zero.
    pub taken_back: Vec<f64>,
}

/// The nearest limit over the ticks before a fault; `None` if no joint has a limit.
pub(super) fn closest_limit(record: &Record, driven: usize, robot: &Robot) -> Option<ClosestLimit> {
    let mut closest: Option<ClosestLimit> = None;
    for (index, joint) in robot.joints.iter().enumerate() {
        let limits = joint.spec.limits;
        let (low, high) = limits.position;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        // Without a limit the share is zero, or NaN if both ends are infinite.
        let wholes = [("position", half), ("velocity", limits.velocity), ("torque", limits.torque)];
        // Greatest values so far: a smaller value has no greater share, so most ticks need no division.
        let mut greatest = wholes.map(|(_, whole)| if whole.is_finite() { -1.0 } else { f64::INFINITY });
        for (tick, sample) in record.joint(index).take(driven).enumerate() {
            let parts = [(sample.q - middle).abs(), sample.qd.abs(), sample.torque.abs()];
            for k in 0..parts.len() {
                let ((limit, whole), part) = (wholes[k], parts[k]);
                let used = if part > greatest[k] { part / whole } else { continue };
                if !used.is_finite() {
                    continue;
                }
                greatest[k] = part;
                if closest.as_ref().is_none_or(|closest| used > closest.used) {
                    closest = Some(ClosestLimit { joint: index + 1, limit, used, tick });
                }
            }
        }
    }
    closest
}

/// Work over the ticks before a fault.
pub(super) fn work(record: &Record, driven: usize) -> Work {
    let of = |joint: usize| {
        let samples = record.joint(joint).take(driven);
        let next = samples.clone().skip(1);
        samples.zip(next).map(|(now, next)| now.torque * (next.q - now.q)).fold((0.0, 0.0), |(given, back), work| {
            if work > 0.0 { (given + work, back) } else { (given, back + work) }
        })
    };
    let (given, taken_back) = (0..record.joints().len()).map(of).unzip();
    Work { given, taken_back }
}

/// Load of a joint's motor in a run, for a motor whose continuous torque is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotorLoad {
    /// Continuous torque of the motor, N m or N.
    pub rated: f64,
    /// Root mean square of the commanded torque, as a share of the rated torque. Above 1, the motor overheats if the run goes on for long.
    pub continuous: f64,
    /// Greatest heat of a motor that was cold at the start; 1 at the continuous limit. `None` if its time constant is not known.
    pub heat: Option<f64>,
}

/// Loads of the motors over the ticks before a fault, one per joint; `None` if the continuous torque is not known.
pub(super) fn motor_loads(record: &Record, driven: usize, robot: &Robot, period: f64) -> Vec<Option<MotorLoad>> {
    let of = |(index, joint): (usize, &RobotJoint)| {
        let rated = joint.heat.rated?;
        let torques = record.joint(index).take(driven).map(|sample| sample.torque);
        let heat = joint.heat.rules(period).map(|rules| {
            let step = |(heat, most): (f64, f64), torque| {
                let heat = rules.step(heat, torque);
                (heat, most.max(heat))
            };
            torques.clone().fold((0.0, 0.0), step).1
        });
        Some(MotorLoad { rated, continuous: rms(torques) / rated, heat })
    };
    robot.joints.iter().enumerate().map(of).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::{closest_limit, motor_loads, work};
    use crate::run::joint_label::JointLabel;
    use crate::run::record::{JointSample, Record};
    use dynamics_core::JointKind;
    use dynamics_core::control::LimitFlags;
    use robot_compiler::Robot;

    /// One joint: position, velocity, torque.
    fn record(ticks: &[(f64, f64, f64)]) -> Record {
        let mut record =
            Record::new(vec![JointLabel { name: "swing".to_owned(), kind: JointKind::Revolute }], ticks.len());
        for (tick, (q, qd, torque)) in ticks.iter().copied().enumerate() {
            let sample = JointSample { q_reference: q, q, qd_reference: qd, qd, torque, limits: LimitFlags::NONE };
            record.push(tick as f64 * 1e-3, [sample], None);
        }
        record
    }

    fn robot(limits: &str) -> Robot {
        let text = format!(
            "name = \"one\"\n[[joint]]\nname = \"swing\"\ntype = \"revolute\"\nmass = 1.0\ncom = [0.5, 0.0, 0.0]\n\
             dh = {{ a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }}\n{limits}\n"
        );
        Robot::from_toml_str(&text, "one.toml").unwrap()
    }

    #[test]
    fn the_nearest_limit_is_named_with_its_share_and_tick() {
        let record = record(&[(0.5, 0.0, 0.0), (0.0, -3.0, 1.0), (1.0, 0.0, -8.0), (3.0, 9.0, 9.0)]);
        let all = robot("limits = { position = [-1.0, 3.0], velocity = 5.0, torque = 10.0 }");
        let found = closest_limit(&record, 3, &all).unwrap();
        assert_eq!((found.joint, found.limit, found.tick), (1, "torque", 2));
        assert!((found.used - 0.8).abs() < 1e-15);
        let found = closest_limit(&record, 4, &all).unwrap();
        assert_eq!(
            (found.limit, found.tick),
            ("velocity", 3),
            "a tick after the fault counts only if it was requested"
        );
        assert_eq!(closest_limit(&record, 0, &all), None);
    }

    #[test]
    fn a_motor_is_loaded_by_the_root_mean_square_of_its_torque_and_heats_by_its_time_constant() {
        let record = record(&[(0.0, 0.0, 6.0); 2000]);
        let of = |heat: &str| motor_loads(&record, 2000, &robot(heat), 1e-3);
        assert_eq!(of(""), [None], "no rating is made up");
        let known = of("heat = { rated = 5.0, time_constant = 4.0 }")[0].clone().unwrap();
        assert!((known.continuous - 1.2).abs() < 1e-12);
        // 2 s with a time constant of 4 s.
        assert!((known.heat.unwrap() - 1.44 * (1.0 - (-0.5_f64).exp())).abs() < 1e-9, "{known:?}");
        assert_eq!(of("heat = { rated = 5.0 }")[0].clone().unwrap().heat, None);
    }

    #[test]
    fn work_is_torque_times_way_by_its_sign() {
        let found = work(&record(&[(0.0, 0.0, 2.0), (1.0, 0.0, -3.0), (3.0, 0.0, -3.0), (2.0, 0.0, 0.0)]), 4);
        // 2 * 1, -3 * 2, -3 * -1.
        assert_eq!((found.given, found.taken_back), (vec![5.0], vec![-6.0]));
    }
}
