//! `energy`: run a scene and account for the energy.

use crate::cli::EnergyArgs;
use crate::cli::run::{exit_code, file_name, in_file, set_duration};
use crate::failure::Failure;
use crate::plant::ledger::Ledger;
use crate::plant::{Arm, State};
use crate::run::plot;
use crate::run::simulate::{self, Run};
use crate::run::summary::{FaultEvent, engineering};
use comfy_table::{CellAlignment, Table, presets};
use indicatif::ProgressBar;
use robot_compiler::{SceneFile, with_dof};
use serde::Serialize;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Where the energy of a run came from and went, until its end or a fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Account {
    /// The scene's name.
    pub scene: String,
    /// The robot's name.
    pub robot: String,
    /// Time accounted for, s.
    pub duration: f64,
    /// Every joint, base first.
    pub joints: Vec<JointWork>,
    /// Work of what pushes at the tip, J.
    pub contact: f64,
    /// `1/2 qd^T D qd`, J.
    pub kinetic: Change,
    /// `-sum m g . r`, J.
    pub potential: Change,
    /// Work of actuators, friction and contact, less the gain of kinetic and potential energy, J.
    pub residual: f64,
    /// The same over all work, each sign counted as positive; zero where there was none.
    pub residual_relative: f64,
    /// Each fault at the tick in which it came.
    pub faults: Vec<FaultEvent>,
    /// Whether the run ended early, and why.
    pub stopped: Option<String>,
}

/// Work on a joint, J.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointWork {
    /// Its name.
    pub name: String,
    /// What the actuator gave.
    pub positive: f64,
    /// What the actuator took back; not above zero.
    pub negative: f64,
    /// Both together.
    pub total: f64,
    /// What friction took; not above zero.
    pub friction: f64,
    /// Greatest magnitude of the commanded torque times the velocity, W.
    pub power_peak: f64,
}

/// An energy before and after, J.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Before.
    pub start: f64,
    /// After.
    pub end: f64,
}

impl Change {
    /// What has been gained, J.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.end - self.start
    }
}

/// Run a scene and account for it; returns the exit code.
///
/// # Errors
/// A scene that is wrong, a file that cannot be written.
pub fn run(args: &EnergyArgs, stop: &AtomicBool) -> Result<u8, Failure> {
    let mut scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    set_duration(&mut scene, args.duration)?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&scene.name)));
    // Better now than after the run.
    fs::create_dir_all(&folder).map_err(|error| in_file(&folder, &error))?;
    let (run, account) = with_dof!(scene.robot.dof(), N => account::<N>(&scene, stop))?;
    let json = serde_json::to_string_pretty(&account).map_err(|error| Failure::Output(error.into()))?;
    let file = folder.join("energy.json");
    fs::write(&file, format!("{json}\n")).map_err(|error| in_file(&file, &error))?;
    let power = plot::write_power(&run.record, &scene.name, &folder).map_err(|error| in_file(&folder, &error))?;
    match show(args.json, &json, &account, &[file, power]) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        Ok(()) | Err(_) => Ok(exit_code(&run)),
    }
}

fn show(as_json: bool, json: &str, account: &Account, files: &[PathBuf]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if as_json {
        return writeln!(out, "{json}");
    }
    writeln!(out, "{}", account.table())?;
    for (index, file) in files.iter().enumerate() {
        let name = if index == 0 { "files" } else { "" };
        writeln!(out, "{name:<20}{}", file.display())?;
    }
    Ok(())
}

/// Run a scene on the desk, and where its energy came from and went.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run.
pub fn account<const N: usize>(scene: &SceneFile, stop: &AtomicBool) -> Result<(Run, Account), Failure> {
    if scene.plant.elasticity.is_some() {
        return Err(Failure::Input(miette::miette!(
            help = "expected a scene without `elasticity` in [plant]",
            "{}: energy in the springs of elastic joints is not accounted for",
            scene.path.display()
        )));
    }
    let arm = simulate::arm::<N>(scene)?;
    let mut world = simulate::world::<N>(scene)?;
    world.plant = world.plant.with_ledger();
    let run = simulate::on_desk_in::<N>(&mut world, scene, stop, &ProgressBar::hidden())?;
    let Some(ledger) = world.plant.ledger() else {
        return Err(Failure::Input(miette::miette!("{}: nothing was accounted for", scene.path.display())));
    };
    let driven = run.record.faults().iter().take_while(|fault| fault.is_none()).count();
    let account = Account::new(&run, scene, &arm, ledger, driven as f64 * scene.period());
    Ok((run, account))
}

impl Account {
    fn new<const N: usize>(run: &Run, scene: &SceneFile, arm: &Arm<N>, ledger: &Ledger<N>, duration: f64) -> Self {
        let (total, friction) = (ledger.actuators.total(), ledger.friction.total());
        let joints: Vec<JointWork> = (0..N)
            .map(|i| JointWork {
                name: run.record.joints()[i].name.clone(),
                positive: ledger.actuators.positive()[i],
                negative: ledger.actuators.negative()[i],
                total: total[i],
                friction: friction[i],
                power_peak: run.record.joint(i).fold(0.0, |most, s| f64::max(most, (s.torque * s.qd).abs())),
            })
            .collect();
        let change =
            |energy: &dyn Fn(&State<N>) -> f64| Change { start: energy(&ledger.start), end: energy(&ledger.end) };
        let kinetic = change(&|state| arm.kinetic(&state.q, &state.qd));
        let potential = change(&|state| arm.potential(&state.q));
        let contact: f64 = ledger.contact.total().iter().sum();
        let given = total.iter().chain(&friction).sum::<f64>() + contact;
        let residual = given - kinetic.gain() - potential.gain();
        let meters = [&ledger.actuators, &ledger.friction, &ledger.contact];
        let turnover: f64 = meters.iter().flat_map(|m| m.positive().iter().chain(m.negative())).map(|x| x.abs()).sum();
        Self {
            scene: scene.name.clone(),
            robot: scene.robot.name.clone(),
            duration,
            joints,
            contact,
            kinetic,
            potential,
            residual,
            residual_relative: if turnover > 0.0 { residual / turnover } else { 0.0 },
            faults: run.summary.faults.clone(),
            stopped: run.summary.stopped.clone(),
        }
    }

    /// The table and the lines below it, as a person reads them.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::UTF8_FULL_CONDENSED);
        table.set_header(["joint", "given", "taken back", "together", "friction", "power peak"]);
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
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
