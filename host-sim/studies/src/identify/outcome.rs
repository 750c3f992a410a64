//! Torque errors on logs before and after identification, and their JSON.

use super::robot_file::Numbers;
use super::subject::{Subject, torque};
use super::verdict as words;
use identification::Series;
use identification::audit::{Audit, audit};
use identification::hypotheses::{Findings, explain};
use identification::identify::{Identified, Settings, identify};
use identification::log::Log;
use identification::prediction::{Prediction, difference, rms};
use identification::verdict::{self, Errors, Grade, Verdict, persistence};
use serde_json::{Value, json};

/// An identified arm and its torque errors.
pub struct Outcome {
    /// Identified model.
    pub found: Identified,
    /// Values for a robot file.
    pub numbers: Numbers,
    /// Comparison of the mass matrices of the new and the old robot file over all postures.
    pub audit: Audit,
    /// The judged logs, in the given order.
    pub judged: Vec<JudgedLog>,
    /// True if the judged logs were not used for identification.
    pub held_out: bool,
    /// Verdict on the model.
    pub verdict: Verdict,
}

/// A log on which the torque errors are judged: one for validation, or one of the identification if there is none for validation.
pub struct JudgedLog {
    /// Name of the file.
    pub file: String,
    /// Measured and predicted torque.
    pub prediction: Prediction,
    /// Torque predicted by the old robot file, N m or N.
    pub before: Series,
    /// Torque predicted by the new robot file, N m or N.
    pub file_model: Series,
}

/// Torque error of one joint over all judged logs: those for validation, or those of the identification if there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointError {
    /// Root mean square of the residual, N m or N.
    pub rms: f64,
    /// `rms` divided by the root mean square of the measured torque.
    pub relative: f64,
    /// Relative error of the old robot file.
    pub before: f64,
    /// Relative error of the new robot file.
    pub file: f64,
    /// Relative error of the identified model over all samples, including those in which friction holds the joint.
    pub all: f64,
    /// Share of the samples in which friction holds the joint.
    pub held: f64,
}

impl Outcome {
    /// Identifies the arm from `logs`, and judges it on `validation`, or on `logs` if `validation` is empty.
    #[must_use]
    pub fn of(subject: &Subject, logs: &[Log], validation: &[Log], settings: &Settings) -> Self {
        let found = identify(subject.arm.as_ref(), &subject.maker, logs, settings);
        let numbers = Numbers::of(subject, &found, logs);
        let limits: Vec<(f64, f64)> = subject.robot.joints.iter().map(|joint| joint.spec.limits.position).collect();
        let audit = audit(subject.arm.as_ref(), &subject.parameters, &numbers.parameters(subject), &limits);
        let held_out = !validation.is_empty();
        let judged = if held_out { validation } else { logs };
        let judge = |log: &Log| {
            let arm = subject.arm.as_ref();
            let by = |parameters: &[f64], friction: &dyn Fn(usize, f64, f64) -> f64| {
                found.predict_by(arm, log, parameters, friction)
            };
            let friction = |joint: usize, qd: f64, load: f64| torque(&numbers.friction[joint].law, qd, load);
            JudgedLog {
                file: log.file.clone(),
                prediction: found.predict(arm, log),
                before: by(&subject.parameters, &|joint, qd, load| subject.friction(joint, qd, load)),
                file_model: by(&numbers.parameters(subject), &friction),
            }
        };
        let judged: Vec<JudgedLog> = judged.iter().map(judge).collect();
        let findings = explain(subject.arm.as_ref(), &subject.maker, logs);
        let nothing = Verdict { grade: Grade::Trusted, reasons: Vec::new() };
        let mut outcome = Self { found, numbers, audit, judged, held_out, verdict: nothing };
        outcome.verdict = outcome.judge(subject, &findings);
        if held_out {
            let explained = || explain(subject.arm.as_ref(), &subject.maker, validation);
            outcome.verdict.explain_validation(explained);
        }
        outcome
    }

    fn judge(&self, subject: &Subject, findings: &Findings) -> Verdict {
        let found = &self.found;
        let (errors, n) = (self.errors(), found.base.joints);
        let sizes: Vec<f64> = (0..n).map(|joint| errors[joint].rms / errors[joint].relative.max(1e-300)).collect();
        let mut kept = vec![0.0; n];
        for judged in &self.judged {
            let of = persistence(&judged.prediction);
            kept.iter_mut().zip(of).for_each(|(sum, x)| *sum += x / self.judged.len() as f64);
        }
        let errors = Errors {
            before: errors.iter().map(|error| error.before).collect(),
            after: errors.iter().map(|error| error.relative).collect(),
            held_out: found.held_out.iter().zip(&sizes).map(|(error, size)| error / size.max(1e-300)).collect(),
            persistence: kept,
            others: self.held_out,
        };
        let mass = |link: usize| {
            let maker = subject.maker.links[link][0];
            (maker > 0.0 && self.numbers.links[link].seen[0]).then(|| (link, self.numbers.links[link].mass.0 / maker))
        };
        let masses: Vec<(usize, f64)> = (0..n).filter_map(mass).collect();
        verdict::verdict(found, findings, &errors, &masses, &found.open(subject.arm.as_ref()))
    }

    /// Error of every joint.
    #[must_use]
    pub fn errors(&self) -> Vec<JointError> {
        let joints = self.found.base.joints;
        let squares = |pick: &dyn Fn(&JudgedLog) -> Series| -> Vec<f64> {
            let (mut sums, mut count) = (vec![0.0; joints], 0usize);
            for judged in &self.judged {
                let series = pick(judged);
                let length = series.first().map_or(0, Vec::len);
                for (sum, rms) in sums.iter_mut().zip(rms(&series)) {
                    *sum += rms * rms * length as f64;
                }
                count += length;
            }
            sums.iter().map(|sum| (sum / count.max(1) as f64).sqrt()).collect()
        };
        let measured = squares(&|judged| judged.prediction.moving(&judged.prediction.measured));
        let left = squares(&|judged| judged.prediction.left(&judged.prediction.model));
        let before = squares(&|judged| judged.prediction.left(&judged.before));
        let file = squares(&|judged| judged.prediction.left(&judged.file_model));
        let measured_all = squares(&|judged| judged.prediction.measured.clone());
        let all = squares(&|judged| difference(&judged.prediction.measured, &judged.prediction.model));
        let held = self.held();
        (0..joints)
            .map(|joint| {
                let size = measured[joint].max(1e-300);
                JointError {
                    rms: left[joint],
                    relative: left[joint] / size,
                    before: before[joint] / size,
                    file: file[joint] / size,
                    all: all[joint] / measured_all[joint].max(1e-300),
                    held: held[joint],
                }
            })
            .collect()
    }

    /// Result for `--json`.
    #[must_use]
    pub fn json(&self, subject: &Subject) -> Value {
        let names = subject.robot.joints.iter().map(|joint| &joint.name);
        let joints: Vec<Value> = names
            .zip(self.errors())
            .enumerate()
            .map(|(joint, (name, error))| {
                let friction: Vec<Value> = self
                    .terms(joint)
                    .map(|(term, value, deviation)| json!({ "term": term, "value": value, "deviation": deviation }))
                    .collect();
                json!({
                    "name": name,
                    "relative_rms": error.relative,
                    "relative_rms_all": error.all,
                    "held": error.held,
                    "rms": error.rms,
                    "before": error.before,
                    "robot_file": error.file,
                    "direction": self.found.laws[joint].direction.name(),
                    "friction": friction,
                })
            })
            .collect();
        let found = &self.found;
        let base: Vec<Value> = (0..found.base.len())
            .map(|k| {
                json!({
                    "name": found.base.name(k),
                    "value": found.bodies.beta[k],
                    "least_squares": found.free[k],
                    "deviation": found.covariance[(k, k)].max(0.0).sqrt(),
                    "before": found.base.of_parameters(&subject.parameters)[k],
                })
            })
            .collect();
        json!({
            "robot": subject.robot.name,
            "verdict": words::json(&self.verdict, subject),
            "delay": found.delay,
            "delay_seen": found.delays.value,
            "delay_deviation": found.delays.deviation,
            "time_jitter": found.jitter,
            "held_out": self.held_out,
            "logs": self.judged.iter().map(|judged| &judged.file).collect::<Vec<_>>(),
            "joints": joints,
            "parameters": base,
            "links": self.numbers.json(subject),
            "tried": found.tried.iter().map(|tried| json!({
                "what": tried.what, "held_out": tried.held_out, "kept": tried.kept,
            })).collect::<Vec<_>>(),
            "condition": found.condition,
            "mass_matrix": {
                "smallest_eigenvalue": self.audit.smallest.value,
                "at": self.audit.smallest.q,
                "before": self.audit.smallest_before.value,
                "ratio": self.audit.ratio.as_ref().map(|(low, high)| [low.value, high.value]),
            },
            "rank": found.base.len(),
            "gap": [found.base.gap.0, found.base.gap.1],
            "motion_cutoff": found.filters.motion,
            "torque_cutoff": found.filters.torque,
        })
    }

    /// Terms of a joint's friction: name, coefficient, standard deviation.
    pub fn terms(&self, joint: usize) -> impl Iterator<Item = (String, f64, f64)> {
        let found = &self.found;
        let values = found.friction[joint].iter().zip(&found.friction_deviations[joint]);
        found.laws[joint].terms.iter().zip(values).map(|(term, (value, deviation))| (term.name(), *value, *deviation))
    }

    /// Share of the judged samples in which friction holds each joint.
    pub(super) fn held(&self) -> Vec<f64> {
        let samples: f64 = self.judged.iter().map(|judged| judged.prediction.time.len() as f64).sum();
        let mut shares = vec![0.0; self.found.base.joints];
        for judged in &self.judged {
            let weight = judged.prediction.time.len() as f64 / samples.max(1.0);
            shares.iter_mut().zip(judged.prediction.held_share()).for_each(|(sum, share)| *sum += weight * share);
        }
        shares
    }
}
