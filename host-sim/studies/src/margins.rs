//! Margins of a scene: how far each of its numbers may go before the arm is lost.
//!
//! The arm is lost in a run that ends in a fault, in which the simulation diverges, or in which a joint leaves its reference by
//! more than `reach` of the scene's `[safety]`, where the firmware would hold. A number goes away from its own value in steps of a
//! factor of `sqrt(2)` until the arm is lost, and between the last two values the border is bisected to 3 %.

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

/// A number of a scene that may be wrong in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum VariedNumber {
    /// Delay of the torque, ticks: `actuators.delay`.
    Delay,
    /// Mass at the tip that the controller does not know, kg.
    Payload,
    /// True masses of all links over those of the robot file: `plant.masses`.
    Masses,
    /// True friction over that of the scene: `plant.friction`.
    Friction,
    /// Natural frequency over the scene's: `control.natural_frequency`; a stiffness of the drive's loop grows with its square.
    Gain,
    /// Rate of the loop, Hz: `control.rate`, downwards.
    Rate,
    /// Counts per turn of the encoders over the robot file's, downwards.
    Encoder,
}

/// Exponents of 2 up to which a number is moved.
const FARTHEST: f64 = 8.0;
/// First steps, then the width to which the border is bisected, as exponents of 2.
const STEP: f64 = 0.5;
const WIDTH: f64 = 0.04;
/// Unit of the unknown mass at the tip, kg.
const MASS: f64 = 0.4;

impl VariedNumber {
    /// All of them, as the table has them.
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

    /// Why the scene has no such number.
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

    /// The value at an exponent, in the unit of the table.
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

    /// The scene with the number at an exponent.
    fn moved(self, scene: &SceneFile, exponent: f64) -> SceneFile {
        let factor = exponent.exp2();
        let mut moved = scene.clone();
        match self {
            Self::Delay => moved.actuators.delay = ticks(scene, exponent),
            Self::Payload => {
                // At the tip's origin: the common centre moves towards it.
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

/// Delay at an exponent: whole ticks beyond the scene's own.
fn ticks(scene: &SceneFile, exponent: f64) -> u32 {
    scene.actuators.delay + exponent.exp2() as u32 - 1
}

/// Friction of the simulated joints; `None` where they have none.
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
    /// The farthest value with which the arm was kept.
    pub kept: Option<f64>,
    /// The nearest value with which it was lost; `None` if it never was.
    pub lost: Option<f64>,
    /// Cause of the loss.
    pub why: Option<String>,
    /// Why nothing was tried.
    pub missing: Option<&'static str>,
}

/// The margins of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// Name of the scene.
    pub scene: String,
    /// A row for each number.
    pub margins: Vec<Margin>,
}

/// Cause of the arm's loss in a run; `None` if it was kept.
fn lost(run: &Run) -> Option<String> {
    let joint = |number: usize| run.record.joints().get(number - 1).map_or("", |joint| joint.name.as_str()).to_owned();
    match (&run.end, run.summary.faults.first(), &run.summary.supervision.out_of_reach) {
        (End::Diverged(_), ..) => Some("the simulation diverged".to_owned()),
        (_, Some(fault), _) => Some(fault.message.clone()),
        (_, _, Some(far)) => Some(format!("{} left its reach in tick {}", joint(far.joint), far.tick)),
        _ => None,
    }
}

/// Search the margins of a scene, all numbers at the same time.
///
/// # Errors
/// [`Failure::Input`]: the scene cannot be run, or the arm is lost in it as it is. [`Failure::Interrupted`]: after `stop`.
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
    // A value that makes no scene is beyond the margin too: the reader of scenes would refuse it.
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
