//! Energy balance of a run.

use indicatif::ProgressBar;
use report::{Block, Figure, Page, Series};
use robot_compiler::SceneFile;
use serde::Serialize;
use sim::failure::Failure;
use sim::run::numbers::engineering;
use sim::run::record::Record;
use sim::run::simulate::Run;
use sim::run::simulation::{EnergyBalance, Options, simulation};
use sim::run::summary_parts::FaultEvent;
use sim::table::table;
use std::sync::atomic::AtomicBool;

/// Energy balance of a run, until its end or a fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Account {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// Time covered, s.
    pub duration: f64,
    /// Every joint, base first.
    pub joints: Vec<JointWork>,
    /// Work of the external wrench at the tip, J.
    pub contact: f64,
    /// Kinetic energy `1/2 qd^T D qd`, J.
    pub kinetic: Change,
    /// Potential energy `-sum m g . r`, J.
    pub potential: Change,
    /// Work of actuators, friction and contact, minus the gain of kinetic and potential energy, J.
    pub residual: f64,
    /// [`Account::residual`] divided by the sum of the magnitudes of all work; zero without any work.
    pub residual_relative: f64,
    /// Each fault with its tick.
    pub faults: Vec<FaultEvent>,
    /// Reason why the run ended early; `None` if it did not.
    pub stopped: Option<String>,
}

/// Work on a joint, J.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointWork {
    /// Name of the joint.
    pub name: String,
    /// Positive work of the actuator, J.
    pub positive: f64,
    /// Negative work of the actuator, J; not above zero.
    pub negative: f64,
    /// Sum of positive and negative work, J.
    pub total: f64,
    /// Work of friction, J; not above zero.
    pub friction: f64,
    /// Greatest magnitude of the commanded torque times the velocity, W.
    pub power_peak: f64,
}

/// An energy at the start and at the end, J.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Energy at the start, J.
    pub start: f64,
    /// Energy at the end, J.
    pub end: f64,
}

impl Change {
    /// Gain of energy, J.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.end - self.start
    }
}

/// Runs a scene on the desk and computes its energy balance.
///
/// # Errors
/// [`Failure::Input`] if the scene cannot be run.
pub fn account(scene: &SceneFile, stop: &AtomicBool) -> Result<(Run, Account), Failure> {
    let left_out = [
        (scene.plant.elasticity.is_some(), "elasticity", "in the springs of elastic joints"),
        (scene.plant.rotor_coupling, "rotor_coupling", "of the coupling of rotors with their links"),
    ];
    if let Some((_, key, place)) = left_out.iter().find(|(is_there, ..)| *is_there) {
        return Err(Failure::Input(miette::miette!(
            help = format!("expected a scene without `{key}` in [plant]"),
            "{}: energy {place} is not accounted for",
            scene.path.display()
        )));
    }
    let mut simulation = simulation(scene, Options::default())?;
    simulation.record_work();
    let run = simulation.run(scene, stop, &ProgressBar::hidden())?;
    let Some(work) = simulation.work() else {
        return Err(Failure::Input(miette::miette!("{}: nothing was accounted for", scene.path.display())));
    };
    let driven = run.record.faults().iter().take_while(|fault| fault.is_none()).count();
    let account = Account::new(&run, scene, &work, driven as f64 * scene.period());
    Ok((run, account))
}

impl Account {
    fn new(run: &Run, scene: &SceneFile, work: &EnergyBalance, duration: f64) -> Self {
        let EnergyBalance { actuators, friction, contact, .. } = work;
        let joints: Vec<JointWork> = (0..run.record.joints().len())
            .map(|i| JointWork {
                name: run.record.joints()[i].name.clone(),
                positive: actuators.positive[i],
                negative: actuators.negative[i],
                total: actuators.total(i),
                friction: friction.total(i),
                power_peak: run.record.joint(i).fold(0.0, |most, s| f64::max(most, (s.torque * s.qd).abs())),
            })
            .collect();
        let change = |[start, end]: [f64; 2]| Change { start, end };
        let (kinetic, potential) = (change(work.kinetic), change(work.potential));
        let given = actuators.sum() + friction.sum() + contact.sum();
        let residual = given - kinetic.gain() - potential.gain();
        let turnover = actuators.turnover() + friction.turnover() + contact.turnover();
        Self {
            scene: scene.name.clone(),
            robot: scene.robot.name.clone(),
            duration,
            joints,
            contact: contact.sum(),
            kinetic,
            potential,
            residual,
            residual_relative: if turnover > 0.0 { residual / turnover } else { 0.0 },
            faults: run.summary.faults.clone(),
            stopped: run.summary.stopped.clone(),
        }
    }

    /// The balance, and the power of every joint over time, as a page.
    #[must_use]
    pub fn page(&self, record: &Record) -> Page {
        let figure = Figure::new("Power of the commanded torques", "time / s", "power / W");
        let power = self.joints.iter().enumerate().fold(figure, |figure, (i, joint)| {
            let power = record.joint(i).map(|sample| sample.torque * sample.qd);
            figure.with(Series::line(&joint.name, record.time().iter().copied().zip(power)))
        });
        Page {
            title: format!("{}: {}, work of every joint", self.scene, self.robot),
            lead: Vec::new(),
            blocks: vec![Block::Terminal(self.table()), Block::Figure(power)],
        }
    }

    /// The table and the lines below it for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(["joint", "given", "taken back", "together", "friction", "power peak"], 1);
        for joint in &self.joints {
            let work = [joint.positive, joint.negative, joint.total, joint.friction].map(|x| engineering(x, "J"));
            let row = [joint.name.clone()].into_iter().chain(work).chain([engineering(joint.power_peak, "W")]);
            table.add_row(row);
        }
        let sum = |f: fn(&JointWork) -> f64| engineering(self.joints.iter().map(f).sum(), "J");
        let change = |change: &Change| {
            let [start, end, gain] = [change.start, change.end, change.gain()].map(|x| engineering(x, "J"));
            format!("{gain}, from {start} to {end}")
        };
        let mut lines = vec![
            ("duration", engineering(self.duration, "s")),
            ("actuators", sum(|joint| joint.total)),
            ("friction", sum(|joint| joint.friction)),
            ("contact", engineering(self.contact, "J")),
            ("gain of kinetic", change(&self.kinetic)),
            ("gain of potential", change(&self.potential)),
            ("residual", format!("{}, {:.1e} of all work", engineering(self.residual, "J"), self.residual_relative)),
        ];
        lines.extend(self.faults.iter().map(|fault| ("faults", format!("{}; the account ends there", fault.message))));
        lines.extend(self.stopped.iter().map(|why| ("stopped", why.clone())));
        let lines: Vec<String> = lines.iter().map(|(name, text)| format!("{name:<20}{text}")).collect();
        format!("{}: {}, work of every joint\n{table}\n{}", self.scene, self.robot, lines.join("\n"))
    }
}
