//! Margins of a scene: how far each of its numbers can change before the arm is lost.
//!
//! The arm counts as lost in a run if the run ends in a fault, if the simulation diverges, or if a joint leaves its reference by more than `reach` of
//! the scene's `[safety]`, where the firmware would hold. Each number is moved away from its own value in steps of a factor of `sqrt(2)` until the
//! arm is lost. The limit between the last two values is then bisected to 3 %.

use crate::numbers::digits;
use indicatif::ProgressBar;
use robot_compiler::{JointFriction, SceneFile};
use serde::Serialize;
use sim::failure::Failure;
use sim::parallel::try_in_parallel;
use sim::run::closed_loop::End;
use sim::run::simulate::Run;
use sim::run::simulation;
use sim::table::table;
use std::sync::atomic::{AtomicBool, Ordering};

/// A number of a scene whose true value may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum VariedNumber {
    /// Delay of the torque, ticks: `actuators.delay`.
    Delay,
    /// Mass at the tip that the controller does not know, kg.
    Payload,
    /// Ratio of the true masses of all links to those of the robot file: `plant.masses`.
    Masses,
    /// Ratio of the true friction to that of the scene: `plant.friction`.
    Friction,
    /// Ratio of the natural frequency to the scene's: `control.natural_frequency`. The stiffness of a drive's loop grows with its square.
    Gain,
    /// Rate of the loop, Hz: `control.rate`, decreased.
    Rate,
    /// Ratio of the encoders' counts per turn to the robot file's, decreased.
    Encoder,
}

/// Largest exponent of 2 by which a number is changed.
const FARTHEST: f64 = 8.0;
/// Step of the search, and the width to which the limit is bisected, as exponents of 2.
const STEP: f64 = 0.5;
const WIDTH: f64 = 0.04;
/// Scale of the unknown mass at the tip, kg.
const MASS: f64 = 0.4;

impl VariedNumber {
    /// All numbers, in the order of the table.
    pub const ALL: [Self; 7] =
        [Self::Delay, Self::Payload, Self::Masses, Self::Friction, Self::Gain, Self::Rate, Self::Encoder];

    /// Name and unit in the table.
    #[must_use]
    pub const fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Delay => ("delay of the torque", "ms"),
            Self::Payload => ("unknown mass at the tip", "kg"),
            Self::Masses => ("masses of all links", "times"),
            Self::Friction => ("friction", "times"),
            Self::Gain => ("natural frequency", "times"),
            Self::Rate => ("rate", "Hz"),
            Self::Encoder => ("counts of the encoders", "times"),
        }
    }

    /// Reason why the scene has no such number.
    fn missing(self, scene: &SceneFile) -> Option<&'static str> {
        let drives = scene.robot.joints.iter().any(|joint| joint.drive.is_some()) && !scene.actuators.ideal;
        match self {
            Self::Delay | Self::Encoder if drives => {
                Some("the simulated drives have their own: `actuators.ideal = true` replaces them")
            }
            Self::Friction if friction(scene).is_none() => Some("no friction in [plant]"),
            Self::Encoder if !scene.sensors.encoder => Some("no encoders in [sensors]"),
            _ => None,
        }
    }

    /// The value at an exponent of 2, in the unit of the table.
    fn value(self, scene: &SceneFile, exponent: f64) -> f64 {
        let factor = exponent.exp2();
        match self {
            Self::Delay => 1e3 * f64::from(ticks(scene, exponent)) / scene.control.rate,
            Self::Payload => MASS * (factor - 1.0),
            Self::Masses | Self::Friction | Self::Gain => factor,
            Self::Rate => scene.control.rate / factor,
            Self::Encoder => 1.0 / factor,
        }
    }

    /// The scene with the number changed by an exponent of 2.
    fn moved(self, scene: &SceneFile, exponent: f64) -> SceneFile {
        let factor = exponent.exp2();
        let mut moved = scene.clone();
        match self {
            Self::Delay => moved.actuators.delay = ticks(scene, exponent),
            Self::Payload => {
                // The mass is at the tip's origin, so the common centre moves towards it.
                let mass = self.value(scene, exponent);
                let mut body = scene.plant.payload.unwrap_or_else(dynamics_core::Body::massless);
                let total = body.mass + mass;
                if total > 0.0 {
                    let r = body.com;
                    let reduced = body.mass * mass / total;
                    body.inertia += (nalgebra::Matrix3::identity() * r.norm_squared() - r * r.transpose()) * reduced;
                    body.com = r * (body.mass / total);
                    body.mass = total;
                    moved.plant.payload = Some(body);
                }
            }
            Self::Masses => moved.plant.masses.iter_mut().for_each(|mass| *mass *= factor),
            Self::Friction => {
                let scaled = |law: &JointFriction| JointFriction {
                    viscous: factor * law.viscous,
                    coulomb: factor * law.coulomb,
                    coulomb_load: factor * law.coulomb_load,
                    breakaway: law.breakaway.map(|rise| robot_compiler::Breakaway {
                        torque: factor * rise.torque,
                        load: factor * rise.load,
                        ..rise
                    }),
                    asymmetry: factor * law.asymmetry,
                    offset: law.offset,
                };
                moved.plant.friction_law = friction(scene).map(|laws| laws.iter().map(scaled).collect());
            }
            Self::Gain => {
                moved.control.natural_frequency.iter_mut().for_each(|frequency| *frequency *= factor);
                let stiffness = moved.control.stiffness.iter_mut().flatten();
                stiffness.for_each(|stiffness| *stiffness *= factor * factor);
            }
            Self::Rate => {
                moved.control.rate = scene.control.rate / factor;
                let period = 1.0 / moved.control.rate;
                moved.plant.step = period / (period / scene.plant.step).ceil();
            }
            Self::Encoder => {
                for encoder in moved.robot.joints.iter_mut().filter_map(|joint| joint.encoder.as_mut()) {
                    encoder.counts_per_turn = (encoder.counts_per_turn / factor).round().max(1.0);
                }
            }
        }
        moved
    }
}

/// Delay at an exponent of 2 in the search, ticks: the scene's own plus `2^exponent - 1`, rounded down.
fn ticks(scene: &SceneFile, exponent: f64) -> u32 {
    scene.actuators.delay + exponent.exp2() as u32 - 1
}

/// Friction of the simulated joints; `None` if they have none.
fn friction(scene: &SceneFile) -> Option<Vec<JointFriction>> {
    let own = || scene.robot.joints.iter().map(|joint| joint.friction.unwrap_or_default()).collect();
    let laws: Vec<JointFriction> = scene.plant.friction_law.clone().unwrap_or_else(own);
    (scene.plant.friction && laws.iter().any(|law| *law != JointFriction::default())).then_some(laws)
}

/// Margin of one number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margin {
    /// The number.
    pub quantity: VariedNumber,
    /// Unit of the values.
    pub unit: &'static str,
    /// The scene's own value.
    pub own: f64,
    /// The farthest value at which the arm was not lost.
    pub kept: Option<f64>,
    /// The nearest value at which it was lost; `None` if it never was.
    pub lost: Option<f64>,
    /// Cause of the loss; `None` if it was never lost.
    pub why: Option<String>,
    /// Reason why nothing was tried.
    pub missing: Option<&'static str>,
}

/// The margins of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// Name of the scene.
    pub scene: String,
    /// One row for each number.
    pub margins: Vec<Margin>,
}

/// Cause of the arm's loss in a run; `None` if it was not lost.
fn lost(run: &Run) -> Option<String> {
    let joint = |number: usize| run.record.joints().get(number - 1).map_or("", |joint| joint.name.as_str()).to_owned();
    match (&run.end, run.summary.faults.first(), &run.summary.supervision.out_of_reach) {
        (End::Diverged(_), ..) => Some("the simulation diverged".to_owned()),
        (_, Some(fault), _) => Some(fault.message.clone()),
        (_, _, Some(far)) => Some(format!("{} left its reach in tick {}", joint(far.joint), far.tick)),
        _ => None,
    }
}

/// Searches the margins of a scene, all numbers in parallel.
///
/// # Errors
/// [`Failure::Input`]: the scene cannot be run, or the arm is lost in the unchanged scene. [`Failure::Interrupted`]: after `stop`.
pub fn margins(scene: &SceneFile, stop: &AtomicBool, progress: &ProgressBar) -> Result<Margins, Failure> {
    let hidden = ProgressBar::hidden();
    let outcome = |scene: &SceneFile| -> Result<Option<String>, Failure> {
        let run = simulation::run(scene, stop, &hidden)?;
        progress.inc(1);
        if stop.load(Ordering::Relaxed) { Err(Failure::Interrupted) } else { Ok(lost(&run)) }
    };
    if let Some(why) = outcome(scene)? {
        return Err(Failure::Input(miette::miette!(
            help = "expected a scene in which the arm follows its motion: `newtau run` shows what goes wrong",
            "{}: the arm is lost as the scene is: {why}",
            scene.path.display()
        )));
    }
    let found = try_in_parallel(VariedNumber::ALL.len(), |number| margin(scene, VariedNumber::ALL[number], &outcome))?;
    Ok(Margins { scene: scene.name.clone(), margins: found })
}

fn margin(
    scene: &SceneFile,
    quantity: VariedNumber,
    outcome: &impl Fn(&SceneFile) -> Result<Option<String>, Failure>,
) -> Result<Margin, Failure> {
    let (_, unit) = quantity.name();
    let value = |exponent| quantity.value(scene, exponent);
    let mut margin = Margin { quantity, unit, own: value(0.0), kept: None, lost: None, why: None, missing: None };
    margin.missing = quantity.missing(scene);
    if margin.missing.is_some() {
        return Ok(margin);
    }
    // A value for which the scene is invalid is beyond the margin, too.
    let tried = |exponent| match outcome(&quantity.moved(scene, exponent)) {
        Err(Failure::Input(report)) => Ok(Some(format!("refused: {report}"))),
        other => other,
    };
    let (mut kept, mut beyond) = (0.0, None);
    while kept < FARTHEST && beyond.is_none() {
        match tried(kept + STEP)? {
            None => kept += STEP,
            Some(why) => beyond = Some((kept + STEP, why)),
        }
    }
    while let Some((exponent, _)) = &beyond
        && exponent - kept > WIDTH
    {
        let middle = 0.5 * (kept + exponent);
        match tried(middle)? {
            None => kept = middle,
            Some(why) => beyond = Some((middle, why)),
        }
    }
    margin.kept = Some(value(kept));
    (margin.lost, margin.why) = beyond.map(|(exponent, why)| (value(exponent), why)).unzip();
    Ok(margin)
}

impl Margins {
    /// The table for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut rows = table(["number", "scene's own", "kept up to", "lost at", "how"], 1);
        if let Some(column) = rows.column_mut(4) {
            column.set_cell_alignment(comfy_table::CellAlignment::Left);
        }
        for margin in &self.margins {
            let (name, unit) = margin.quantity.name();
            let number = |value: f64| format!("{} {unit}", digits(value));
            let optional = |value: Option<f64>| value.map_or("-".to_owned(), number);
            let why = margin.missing.map(str::to_owned).or_else(|| margin.why.clone());
            let why = why.unwrap_or_else(|| "not lost as far as was tried".to_owned());
            rows.add_row([name.to_owned(), number(margin.own), optional(margin.kept), optional(margin.lost), why]);
        }
        format!("{}: how far each number may go before the arm is lost\n{rows}\n", self.scene)
    }
}
