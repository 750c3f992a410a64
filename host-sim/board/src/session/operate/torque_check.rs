//! Check of torque units: compares the actual torque of each drive with the commanded torque.
//!
//! ```text
//! acted = ID(q, qd, qdd)      from the arm's motion, by the scene's model
//! told  = mean of the commanded torques
//! factor = acted / told       1 if drive, gear and model are right
//! ```
//!
//! A least-squares parabola through some 0.1 s of positions gives `q`, `qd` and `qdd`. So the check also works while an arm settles or is thrown by a
//! wrong unit. Friction is taken into account. A joint without a gravity torque gives no information at rest. So `check-torque` moves it slightly
//! back and forth and fits `commanded = s acted + c sign(qd)`; its factor is `1 / s`.

use super::arm::Arm;
use super::samples::{SAMPLES_MIN, Sample, WINDOW};
use super::torque_cause::common;
use super::{Operator, Stop};
use link::StateCode;

/// Time from arming to the first judged sample, s. By then the drives are on, and most arms have settled.
const RISE: f64 = 0.3;

/// A factor (or its inverse) beyond the first value is reported. Beyond the second, or with the wrong sign, no motion begins.
const NAMED: f64 = 1.15;
const REFUSED: f64 = 2.0;

/// Distance that `check-torque` moves a joint, rad or m.
const REACH: f64 = 0.2;

/// Greatest standard deviation of a factor that is reported.
const DOUBT: f64 = 0.1;

/// Actual and commanded torque of each joint, N m or N, in the middle of these samples; and velocities, rad/s or m/s.
#[derive(Clone, Debug, PartialEq)]
struct TorqueSample {
    acted: Vec<f64>,
    told: Vec<f64>,
    qd: Vec<f64>,
}

/// Computes the torques from samples; `None` for too few samples.
fn acted<'a>(samples: impl Iterator<Item = &'a Sample> + Clone, arm: &Arm) -> Option<TorqueSample> {
    let (mut count, mut middle) = (0_usize, 0.0);
    let first = samples.clone().next()?.tick;
    let time = |sample: &Sample| f64::from(sample.tick.wrapping_sub(first)) * arm.period;
    samples.clone().for_each(|sample| {
        count += 1;
        middle += time(sample);
    });
    if count < SAMPLES_MIN {
        return None;
    }
    middle /= count as f64;
    let joints = arm.joints.len();
    let [mut q, mut qd, mut qdd, mut told] = [const { Vec::new() }; 4];
    for joint in 0..joints {
        let points = samples.clone().map(|sample| (time(sample) - middle, sample.q.get(joint).copied().unwrap_or(0.0)));
        let [place, speed, acceleration] = parabola(points);
        q.push(place);
        qd.push(speed);
        qdd.push(acceleration);
        told.push(samples.clone().filter_map(|sample| sample.torque.get(joint)).sum::<f64>() / count as f64);
    }
    Some(TorqueSample { acted: arm.model.inverse_dynamics(&q, &qd, &qdd, arm.payload), told, qd })
}

/// Value, first and second derivative at zero of the least-squares parabola through these points. The mean of their arguments must be zero.
fn parabola(points: impl Iterator<Item = (f64, f64)> + Clone) -> [f64; 3] {
    let sum = |f: &dyn Fn(f64, f64) -> f64| points.clone().map(|(t, x)| f(t, x)).sum::<f64>();
    let [n, t2, t3, t4] = [sum(&|_, _| 1.0), sum(&|t, _| t * t), sum(&|t, _| t * t * t), sum(&|t, _| t * t * t * t)];
    let [x, tx, ttx] = [sum(&|_, x| x), sum(&|t, x| t * x), sum(&|t, x| t * t * x)];
    let normal = nalgebra::Matrix3::new(n, 0.0, t2, 0.0, t2, t3, t2, t3, t4);
    let solved = normal.lu().solve(&nalgebra::Vector3::new(x, tx, ttx));
    solved.map_or([x / n, 0.0, 0.0], |a| [a.x, a.y, 2.0 * a.z])
}

/// A joint whose actual torque differs from the commanded torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Finding {
    joint: usize,
    /// Actual over commanded torque; negative if they have opposite signs.
    factor: f64,
    acted: f64,
    told: f64,
}

impl Finding {
    fn is_grave(&self) -> bool {
        !(1.0 / REFUSED..=REFUSED).contains(&self.factor)
    }
}

/// Joints whose factor exceeds what friction and noise explain.
fn findings(seen: &TorqueSample, arm: &Arm) -> Vec<Finding> {
    let judge = |(joint, ((&acted, &told), &hidden)): (usize, ((&f64, &f64), &f64))| {
        let finding = Finding { joint, factor: acted / told, acted, told };
        if acted.abs() < 2.0 * hidden || told.abs() < hidden {
            return None;
        }
        let (low, high) = ((acted.abs() - hidden) / told.abs(), (acted.abs() + hidden) / told.abs());
        (acted * told < 0.0 || low > NAMED || high < 1.0 / NAMED).then_some(finding)
    };
    seen.acted.iter().zip(&seen.told).zip(&arm.hidden).enumerate().filter_map(judge).collect()
}

/// Error of the gravity model on one joint of an arm at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GravityError {
    pub(super) joint: usize,
    /// Torque by the model less the commanded torque, N m or N.
    pub(super) error: f64,
    /// Part of the error that friction and noise explain, N m or N.
    pub(super) friction: f64,
}

impl GravityError {
    /// True if this joint would drift when only gravity is compensated.
    pub(super) fn drifts(&self) -> bool {
        self.error.abs() > self.friction
    }
}

impl Operator {
    /// Error of the gravity model on each joint, from the last ticks; `None` for too few of them.
    pub(super) fn gravity_errors(&self) -> Option<Vec<GravityError>> {
        let seen = acted(self.samples.all.iter(), &self.arm)?;
        let error = |(joint, ((acted, told), friction)): (usize, ((&f64, &f64), &f64))| GravityError {
            joint,
            error: acted - told,
            friction: *friction,
        };
        Some(seen.acted.iter().zip(&seen.told).zip(&self.arm.hidden).enumerate().map(error).collect())
    }

    /// Describes the torque differences, with true if one of them blocks motion. `None` if no joint is suspicious, or there are too few
    /// samples.
    pub(super) fn torque_in_words(&self) -> Option<(String, bool)> {
        let found = findings(&acted(self.samples.all.iter(), &self.arm)?, &self.arm);
        let grave = found.iter().any(Finding::is_grave);
        let factors: Vec<f64> = found.iter().map(|finding| finding.factor).collect();
        let same = common(&factors);
        let words = found.iter().map(|finding| self.finding_in_words(finding, same)).collect::<Vec<_>>();
        (!words.is_empty()).then(|| (words.join("\n"), grave))
    }

    fn finding_in_words(&self, finding: &Finding, common: bool) -> String {
        let Finding { joint, factor, acted, told } = *finding;
        let (name, _, unit) = self.arm.joint(joint);
        let what = if factor < 0.0 {
            "has the opposite sign of the commanded torque".to_owned()
        } else {
            format!("is {factor:.2} times the commanded torque")
        };
        let cause = self.arm.drives.get(joint).map(|drive| drive.cause(factor, common)).unwrap_or_default();
        // The load cannot cause a wrong sign.
        let load = match factor {
            ..0.0 => "",
            0.0..1.0 => "the arm is heavier here than its model: an undeclared payload, or too small masses; or ",
            _ => {
                "the arm is lighter here than its model: a declared payload that is not there, or too large masses; or "
            }
        };
        format!(
            "torque of {name} {what}: {acted:.2} {unit} by the model, {told:.2} {unit} commanded; likely cause: {load}{cause}"
        )
    }

    /// Judges the torques before the first motion after arming. Returns true if the arm may move.
    pub(super) fn torque_is_believed(&mut self) -> Result<bool, Stop> {
        if self.judged || !matches!(self.state(), Some(StateCode::Armed | StateCode::Holding)) {
            return Ok(true);
        }
        let missing = RISE + WINDOW - self.samples.since;
        if missing > 0.0 {
            self.watch(1)?;
            self.wait(missing)?;
            self.watch_as_needed()?;
        }
        self.judged = true;
        let Some((text, grave)) = self.torque_in_words() else { return Ok(true) };
        if !grave {
            self.say("torque", &text)?;
            return Ok(true);
        }
        self.refused = true;
        self.say(
            "torque",
            &format!(
                "{text}\nmotion rejected: `disarm`, correct it, and arm again; or repeat the command to move anyway"
            ),
        )?;
        Ok(false)
    }

    /// Moves one joint, or each in turn, slightly back and forth, and reports the ratio of actual to commanded torque.
    pub(super) fn check_torque(&mut self, joint: Option<usize>) -> Result<(), Stop> {
        if !self.may_test("check-torque")? {
            return Ok(());
        }
        let joints = joint.map_or(0..self.arm.joints.len(), |joint| joint..joint + 1);
        let mut lines = Vec::new();
        for joint in joints {
            let line = self.check_one(joint)?;
            lines.push(format!("  {:<12} {line}", self.arm.joint(joint).0));
            if !self.drives() {
                break;
            }
        }
        self.say("check-torque", &format!("check-torque: actual over commanded torque\n{}", lines.join("\n")))
    }

    fn check_one(&mut self, joint: usize) -> Result<String, Stop> {
        let here = self.here()?;
        let (low, high) = self.arm.range.get(joint).copied().unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let at = here.get(joint).copied().unwrap_or(0.0);
        let (below, above) = (at - low, high - at);
        let step = if above >= below { (0.5 * above).min(REACH) } else { -(0.5 * below).min(REACH) };
        let mut there = here.clone();
        if let Some(q) = there.get_mut(joint) {
            *q += step;
        }
        let time = self.way("check-torque", &here, &there, None)?.0.duration();
        self.samples.keep((4.0 * time / self.arm.period) as usize + SAMPLES_MIN);
        self.watch(1)?;
        let denial = self.back_and_forth("check-torque", here, there, time)?;
        let line = self.factor_of(joint);
        self.watch_as_before()?;
        if let Some(denial) = denial {
            return Ok(super::messages::rejection(&denial));
        }
        Ok(match (self.drives(), line) {
            (true, Some(line)) => line,
            (true, None) => "moved too little to tell; give it room, or a payload".into(),
            (false, _) => self.status.as_ref().map(super::messages::doing).unwrap_or_default(),
        })
    }

    /// Restores the reporting interval and the number of samples kept.
    pub(super) fn watch_as_before(&mut self) -> Result<(), Stop> {
        self.samples.keep(0);
        self.watch_as_needed()
    }

    /// Fits `commanded = s acted + c sign(qd)` over the last motion. Returns `1 / s` and its standard deviation as text; `None` if the motion is not
    /// informative enough.
    fn factor_of(&self, joint: usize) -> Option<String> {
        let all: Vec<&Sample> = self.samples.all.iter().collect();
        let width = ((0.03 / self.arm.period) as usize).max(SAMPLES_MIN);
        let rows = all.chunks(width).filter_map(|chunk| acted(chunk.iter().copied(), &self.arm)).filter_map(|seen| {
            Some(nalgebra::Vector3::new(*seen.acted.get(joint)?, seen.qd.get(joint)?.signum(), *seen.told.get(joint)?))
        });
        let rows: Vec<_> = rows.collect();
        let mut normal = nalgebra::Matrix2::zeros();
        let mut right = nalgebra::Vector2::zeros();
        for row in &rows {
            normal += row.xy() * row.xy().transpose();
            right += row.xy() * row.z;
        }
        let inverse = normal.try_inverse()?;
        let solved: nalgebra::Vector2<f64> = inverse * right;
        let spare = rows.len().checked_sub(2).filter(|&spare| spare > 0)? as f64;
        let error = rows.iter().map(|row| (row.z - solved.dot(&row.xy())).powi(2)).sum::<f64>() / spare;
        let (share, deviation) = (solved.x, (error * inverse.m11).sqrt());
        if !(share.is_finite() && deviation <= DOUBT * share.abs()) {
            return None;
        }
        let (_, _, unit) = self.arm.joints.get(joint)?;
        let wrong = match (1.0 / NAMED..=NAMED).contains(&share) {
            true => String::new(),
            false => {
                let cause = self.arm.drives.get(joint).map(|drive| drive.cause(1.0 / share, false)).unwrap_or_default();
                format!("  WRONG; likely cause, if masses and payload are right: {cause}")
            }
        };
        Some(format!(
            "{:.2} +- {:.2}, friction {:.2} {unit}{wrong}",
            1.0 / share,
            deviation / (share * share),
            solved.y.abs()
        ))
    }
}

#[cfg(test)]
mod tests;
