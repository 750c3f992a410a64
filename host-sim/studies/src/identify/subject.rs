//! The arm and its maker's values, in the form that identification needs.

use super::record;
use board::session::frame_log::is_record;
use clap::Args;
use dynamics_core::{Inertia, JointKind};
use identification::arm::{Arm, Chain};
use identification::consistent::Maker;
use identification::correction::Correction;
use identification::hypotheses::{Fault, explain};
use identification::log::{ColumnNames, Log, Reading};
use identification::verdict::{Grade, Reason, Verdict};
use nalgebra::Vector3;
use robot_compiler::drive::JointDrive;
use robot_compiler::{Ends, JointFriction, Robot, with_dof};
use sim::failure::Failure;
use std::path::Path;

/// Speed at which the controller's friction feedforward saturates, rad/s: the default of a scene.
pub const SMOOTHING_SPEED: f64 = 0.05;

/// The arm of a log.
pub struct Subject {
    /// The robot file.
    pub robot: Robot,
    /// Torque as a linear function of parameters.
    pub arm: Box<dyn Arm>,
    /// All parameters from the maker's values, including the tool: ten of each link, then rotors.
    pub parameters: Vec<f64>,
    /// The same with links and tool separate, for the search for physically consistent bodies.
    pub maker: Maker,
}

/// Options for reading logs.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub struct LogOptions {
    /// Torque per ampere of each joint, or one for all, N m/A.
    #[arg(long, value_name = "K1,K2,..", value_delimiter = ',')]
    pub torque_per_ampere: Option<Vec<f64>>,
    /// The log's angles are in degrees and its velocities in degrees/s.
    #[arg(long)]
    pub degrees: bool,
    /// Names of the logs' columns. KEY is t, q, qd, tau or i (current). NAME is a list, or a pattern in which {} is the joint's number or name.
    #[arg(long, value_name = "KEY=NAME,..", value_parser = ColumnNames::parse)]
    pub columns: Option<ColumnNames>,
    /// Ticks a second, for a log that counts time in ticks.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub tick_rate: Option<f64>,
    /// Accept a log in which a joint never moves.
    #[arg(skip)]
    pub may_rest: bool,
    /// Correction of signs, scales, order and delay of the columns.
    #[arg(skip)]
    pub correction: Option<Correction>,
}

/// Largest distance of a corrected position beyond its limits, rad or m.
const BEYOND: f64 = 0.2;

impl Subject {
    /// Loads a robot file. `deviation` is the relative standard deviation of its masses.
    ///
    /// # Errors
    /// [`Failure::Input`]: the file cannot be read.
    pub fn load(path: &Path, ends: Ends<'_>, gravity: Vector3<f64>, deviation: f64) -> Result<Self, Failure> {
        let robot = Robot::load_between(path, ends).map_err(Failure::input)?;
        let n = robot.dof();
        let (arm, parameters): (Box<dyn Arm>, Vec<f64>) = with_dof!(n, N => {
            let chain = Chain::new(robot.model::<N>().map_err(Failure::input)?, gravity);
            let parameters = chain.parameters();
            (Box::new(chain), parameters)
        });
        let mut fixed = vec![[0.0; 10]; n];
        let tool = &robot.tool;
        let body = Inertia::from_mass_centre(tool.body.mass, &tool.body.com, &tool.body.inertia);
        if let (Some(last), Some(joint)) = (fixed.last_mut(), robot.joints.last()) {
            let link_from_body = joint.spec.frame.link_from_body();
            *last = body
                .in_parent(&tool.rotation, &tool.translation)
                .in_parent(&link_from_body.rotation, &link_from_body.translation)
                .parameters();
        }
        let own = |link: usize| core::array::from_fn(|k| parameters[10 * link + k] - fixed[link][k]);
        let links = (0..n).map(own).collect();
        let maker = Maker { links, fixed, rotors: parameters[10 * n..].to_vec(), deviation };
        Ok(Self { robot, arm, parameters, maker })
    }

    /// Reads and checks a log of this arm; adds remarks on its interpretation to `notes`.
    ///
    /// # Errors
    /// [`Failure::Input`] with file, line and column.
    pub fn log(&self, path: &Path, options: &LogOptions, notes: &mut Vec<String>) -> Result<Log, Failure> {
        let Some(correction) = &options.correction else { return self.read(path, options, true, notes) };
        let log = correction.apply(&self.read(path, options, false, notes)?);
        for (joint, q) in self.robot.joints.iter().zip(&log.q) {
            let (low, high) = joint.spec.limits.position;
            if let Some(far) = q.iter().find(|q| !(low - BEYOND..=high + BEYOND).contains(*q)) {
                return Err(Failure::Input(miette::miette!(
                    help = format!(
                        "expected positions from {low:.3} to {high:.3}: are the signs, the order and the scale right?"
                    ),
                    "{}: found {far:.4} for {} after the corrections",
                    path.display(),
                    joint.name
                )));
            }
        }
        Ok(log)
    }

    /// Searches for faults that explain a log with positions or torques that the arm cannot reach, and refuses the log with them. `None` if there are
    /// none, or if the fault is the unit of angles, because the message about the range names it.
    #[must_use]
    pub fn explained(&self, path: &Path, options: &LogOptions) -> Option<Verdict> {
        // If the user has given corrections, the range is theirs.
        let log = self.read(path, options, false, &mut Vec::new()).ok().filter(|_| options.correction.is_none())?;
        let findings = explain(self.arm.as_ref(), &self.maker, &[log]);
        let degrees = |fault: &Fault| matches!(fault, Fault::PositionScales(_));
        findings.explanations.first().filter(|one| !one.faults.iter().any(degrees))?;
        Some(Verdict { grade: Grade::Refused, reasons: vec![Reason::Explained(findings.explanations)] })
    }

    /// Reads a log, with or without the arm's limits.
    fn read(&self, path: &Path, options: &LogOptions, limited: bool, notes: &mut Vec<String>) -> Result<Log, Failure> {
        let joints = &self.robot.joints;
        let n = joints.len();
        let per_ampere = match &options.torque_per_ampere {
            Some(one) if one.len() == 1 => Some(vec![one[0]; n]),
            Some(all) if all.len() == n => Some(all.clone()),
            Some(other) => {
                return Err(Failure::Input(miette::miette!(
                    help = format!("expected {n} numbers, one for each joint, or one for all; N m/A"),
                    "--torque-per-ampere: found {} numbers",
                    other.len()
                )));
            }
            None => joints.iter().map(|joint| joint.drive.as_ref().and_then(per_ampere)).collect(),
        };
        let everywhere = (f64::NEG_INFINITY, f64::INFINITY);
        let reading = Reading {
            joints: joints.iter().map(|joint| joint.name.clone()).collect(),
            turns: joints.iter().map(|joint| joint.spec.kind == JointKind::Revolute).collect(),
            limits: joints.iter().map(|joint| if limited { joint.spec.limits.position } else { everywhere }).collect(),
            torque: joints.iter().map(|joint| if limited { joint.spec.limits.torque } else { f64::INFINITY }).collect(),
            degrees: options.degrees,
            per_ampere,
            tick_rate: options.tick_rate,
            may_rest: options.may_rest,
            currents_meant: options.torque_per_ampere.is_some(),
            columns: options.columns.clone(),
        };
        let text =
            std::fs::read(path).map_err(|error| Failure::Input(miette::miette!("{}: {error}", path.display())))?;
        let text = if is_record(&text) { record::text(text, path)? } else { text };
        let file = path.display().to_string();
        let (log, said) = Log::read_noted(&text, &file, &reading).map_err(|error| {
            Failure::Input(miette::miette!(help = format!("expected {}", error.expected), "{error}"))
        })?;
        notes.extend(said.into_iter().map(|note| format!("{file}: {note}")));
        Ok(log)
    }

    /// Friction of the robot file, as a controller compensates it, N m or N.
    #[must_use]
    pub fn friction(&self, joint: usize, qd: f64, load: f64) -> f64 {
        self.robot.joints[joint].friction.map_or(0.0, |friction| torque(&friction, qd, load))
    }
}

/// Friction as a controller compensates it, at the velocity `qd` (rad/s or m/s) under the torque `load`, N m or N.
#[must_use]
pub fn torque(friction: &JointFriction, qd: f64, load: f64) -> f64 {
    let plain = friction.feedforward(SMOOTHING_SPEED);
    if friction.has_terms() { plain.torque_with(&friction.terms(f64::INFINITY), qd, load) } else { plain.torque(qd) }
}

fn per_ampere(drive: &JointDrive) -> Option<f64> {
    match drive {
        JointDrive::Pwm(spec) => Some(spec.torque_constant * spec.ratio.abs()),
        JointDrive::Mit(_) => None,
    }
}
