//! Friction of an identified arm, in the form of a robot file.

use super::subject::{Subject, torque};
use identification::choose::WITHOUT_OFFSET;
use identification::friction::{FrictionLaw, JointLaw, Term};
use identification::identify::Identified;
use identification::log::Log;
use identification::prediction::difference;
use robot_compiler::{Breakaway, JointFriction};
use serde_json::{Map, Value as Json, json};

/// Lowest Stribeck velocity in a robot file, rad/s or m/s.
const STRIBECK_SPEED_MIN: f64 = 5e-3;

/// An offset is written if it is larger than this many standard deviations. On a joint that carries weight, a shorter log cannot separate offset and
/// weight.
const SURE: f64 = 3.0;

/// Friction of one joint for a robot file.
pub struct Written {
    /// Values of the friction law.
    pub law: JointFriction,
    /// Standard deviation of each key; `None` if the values only approximate the identified law.
    deviations: Option<Vec<(&'static str, f64)>>,
}

impl Written {
    /// Keys of the robot file with their values and standard deviations; absent terms are left out.
    pub(super) fn entries(&self) -> Vec<(&'static str, f64, Option<f64>)> {
        let law = &self.law;
        let deviation = |key: &str| self.deviations.as_ref()?.iter().find(|(name, _)| *name == key).map(|(_, x)| *x);
        let mut all = vec![("viscous", law.viscous), ("coulomb", law.coulomb)];
        let given = |key: &'static str, x: f64| (x != 0.0).then_some((key, x));
        all.extend(given("coulomb_load", law.coulomb_load));
        if let Some(Breakaway { torque, speed, load }) = law.breakaway {
            all.extend([("breakaway", torque), ("stribeck_speed", speed)]);
            // If `breakaway_load` is not given, it equals the Coulomb torque's.
            all.extend((load.to_bits() != law.coulomb_load.to_bits()).then_some(("breakaway_load", load)));
        }
        all.extend([given("asymmetry", law.asymmetry), given("offset", law.offset)].into_iter().flatten());
        all.into_iter().map(|(key, x)| (key, x, deviation(key))).collect()
    }

    /// Comment for the robot file.
    pub(super) fn note(&self, viscous: &str, force: &str) -> String {
        let units = format!("{viscous}, {force}");
        match &self.deviations {
            None => format!("nearest to the identified law; {units}"),
            Some(all) => {
                let each: Vec<String> = all.iter().map(|(key, x)| format!("{x:.1e} {key}")).collect();
                format!("+- {}; {units}", each.join(", "))
            }
        }
    }

    pub(super) fn json(&self) -> Json {
        let each = self.entries().into_iter();
        let of = |(key, value, deviation): (&str, f64, Option<f64>)| {
            (key.to_owned(), json!({ "value": value, "deviation": deviation }))
        };
        Json::Object(each.map(of).collect::<Map<_, _>>())
    }
}

/// Friction of every joint: the identified law if a robot file can express it, otherwise the best approximation by viscous and Coulomb friction.
pub(super) fn friction(subject: &Subject, found: &Identified, logs: &[Log]) -> Vec<Written> {
    let nearest = nearest(subject, found, logs);
    let of = |(joint, nearest): (usize, JointFriction)| {
        itself(found, joint).unwrap_or(Written { law: nearest, deviations: None })
    };
    nearest.into_iter().enumerate().map(of).collect()
}

/// The identified law of a joint, if it has more than viscous and Coulomb friction and a robot file can express it.
fn itself(found: &Identified, joint: usize) -> Option<Written> {
    let (law, coefficients) = (&found.laws[joint], &found.friction[joint]);
    let by = law.by_joint(coefficients)?;
    let tried = found.tried.iter().find(|tried| tried.what == WITHOUT_OFFSET);
    let sure = law.terms.iter().zip(&found.friction_deviations[joint]).find(|(term, _)| **term == Term::Offset);
    let sure = sure.is_some_and(|(_, deviation)| by.offset.abs() > SURE * deviation);
    let earned = sure && tried.is_some_and(|tried| !tried.kept[joint]);
    // An offset larger than the Coulomb torque would move the joint without a command. It is an error of the torque's zero, and not a property of the
    // joint.
    let offset = if earned && by.offset.abs() <= by.coulomb { by.offset } else { 0.0 };
    let breakaway = (by.stribeck_speed > 0.0).then(|| Breakaway {
        torque: by.coulomb + by.rise.0,
        speed: by.stribeck_speed.max(STRIBECK_SPEED_MIN),
        load: by.coulomb_load + by.rise.1,
    });
    let JointLaw { viscous, coulomb, coulomb_load, asymmetry, .. } = by;
    let friction = JointFriction { viscous, coulomb, coulomb_load, breakaway, asymmetry, offset };
    friction.has_terms().then(|| Written { law: friction, deviations: Some(deviations(found, joint, law, offset)) })
}

/// Standard deviations of the written values, by key. That of `breakaway` is the rise's, because the rise is the peak above the Coulomb torque.
fn deviations(found: &Identified, joint: usize, law: &FrictionLaw, offset: f64) -> Vec<(&'static str, f64)> {
    let key = |term: &Term| match term {
        Term::Viscous => Some("viscous"),
        Term::Coulomb => Some("coulomb"),
        Term::Load => Some("coulomb_load"),
        Term::Stribeck(_) => Some("breakaway"),
        Term::StribeckLoad(_) => Some("breakaway_load"),
        Term::Asymmetric => Some("asymmetry"),
        Term::Offset => (offset != 0.0).then_some("offset"),
        Term::Root | Term::Nothing => None,
    };
    let all = law.terms.iter().zip(&found.friction_deviations[joint]);
    all.filter_map(|(term, deviation)| Some((key(term)?, *deviation))).collect()
}

/// Viscous and Coulomb friction of the controller's law, not negative, that minimise the residual after the torque of the bodies.
fn nearest(subject: &Subject, found: &Identified, logs: &[Log]) -> Vec<JointFriction> {
    let n = found.base.joints;
    let mut sums = vec![[0.0_f64; 5]; n];
    let offset = |joint: usize| found.friction[joint].first().copied().unwrap_or(0.0);
    let mut bodies = found.bodies.parameters.clone();
    bodies.iter_mut().zip(subject.maker.fixed.iter().flatten()).for_each(|(sum, x)| *sum += x);
    let unit = JointFriction { coulomb: 1.0, ..JointFriction::default() };
    for log in logs {
        let prediction = found.predict(subject.arm.as_ref(), log);
        let rest = found.predict_by(subject.arm.as_ref(), log, &bodies, &|_, _, _| 0.0);
        for (joint, left) in difference(&prediction.measured, &rest).iter().enumerate() {
            for ((tau, qd), held) in left.iter().zip(&prediction.qd[joint]).zip(&prediction.held[joint]) {
                if *held {
                    continue;
                }
                let (a, b, y) = (*qd, torque(&unit, *qd, 0.0), tau - offset(joint));
                let more = [a * a, a * b, b * b, a * y, b * y];
                sums[joint].iter_mut().zip(more).for_each(|(sum, x)| *sum += x);
            }
        }
    }
    let solve = |[aa, ab, bb, ay, by]: [f64; 5]| {
        let det = aa * bb - ab * ab;
        let (viscous, coulomb) = ((ay * bb - by * ab) / det, (aa * by - ab * ay) / det);
        let (viscous, coulomb) = if coulomb < 0.0 {
            ((ay / aa.max(1e-300)).max(0.0), 0.0)
        } else if viscous >= 0.0 && det > 1e-12 * aa * bb {
            (viscous, coulomb)
        } else {
            (0.0, (by / bb.max(1e-300)).max(0.0))
        };
        JointFriction { viscous, coulomb, ..JointFriction::default() }
    };
    sums.into_iter().map(solve).collect()
}
