//! `explain`: what each term of a scene's model costs, and what goes wrong without it.

use crate::cli::ExplainArgs;
use crate::closed_loop::End;
use crate::exit::{self, Failure};
use crate::run_command::{file_name, in_file};
use crate::simulate;
use crate::summary::engineering;
use crate::trade::base::Base;
use crate::trade::{Cost, Costs};
use comfy_table::{CellAlignment, Table, presets};
use dynamics_core::{JointKind, Term};
use indicatif::ProgressBar;
use robot_compiler::choose::{Along, LoopGain, TorqueError};
use robot_compiler::kernel::Operations;
use robot_compiler::scene::ModelTerm;
use robot_compiler::{SceneFile, with_dof};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The tolerance where neither scene nor command line gives one: a share of each joint's torque limit.
pub const TOLERANCE: f64 = 0.002;

/// What a scene's model computes, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// The scene's name.
    pub scene: String,
    /// The robot's name.
    pub robot: String,
    /// The control law.
    pub law: &'static str,
    /// Level of the kernel whose operations are counted.
    pub level: &'static str,
    /// Every joint, base first.
    pub joints: Vec<Joint>,
    /// Share of each joint's torque limit that the terms are held against.
    pub tolerance: f64,
    /// Operations of a tick's inverse dynamics and friction feedforward with every term.
    pub operations: Count,
    /// What a tick of the chip takes with every term, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<Cost>,
    /// The closed loop with every term.
    pub tracking: Tracking,
    /// Each term.
    pub terms: Vec<TermReport>,
    /// The fewest terms that keep the tolerance.
    pub fewest: Fewest,
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// `N m` or `N`.
    pub torque_unit: &'static str,
    /// `rad` or `m`.
    pub position_unit: &'static str,
    /// Greatest torque or force; none where there is no limit.
    pub torque_limit: Option<f64>,
}

/// Operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Count {
    /// Multiplications.
    pub mul: i64,
    /// Additions.
    pub add: i64,
    /// Subtractions.
    pub sub: i64,
}

/// What one term is worth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermReport {
    /// Its name.
    pub term: &'static str,
    /// `absent`, `constant`, `live`, or `given up` by `terms = "auto"`.
    pub state: &'static str,
    /// Where that was said.
    pub why: String,
    /// What dropping it does; none where it is absent.
    pub dropped: Option<Dropped>,
}

/// What dropping terms does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dropped {
    /// Operations less.
    pub operations: Count,
    /// What a tick of the chip takes less; where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<ChipSaving>,
    /// Torque that the model then leaves out on the reference motion.
    pub torque_error: Error,
    /// The closed loop with that model, in the same world.
    pub tracking: Tracking,
    /// Whether the torque error keeps the tolerance.
    pub within_tolerance: bool,
    /// Least loop gain along the motion, where the full model has 1.
    pub loop_gain: f64,
    /// The joint that moves most in the mode of that loop gain; none where it is 1.
    pub weakest_joint: Option<usize>,
    /// Whether both allow it to go.
    pub may_go: bool,
}

/// What a tick of the chip takes less without a term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChipSaving {
    /// Instructions, mean.
    pub instructions: f64,
    /// Cycles, mean: an estimate.
    pub cycles: f64,
    /// Bytes of the tick and all that it reaches.
    pub flash: i64,
}

/// A torque error per joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Error {
    /// Greatest magnitude, N m or N.
    pub max: Vec<f64>,
    /// Root mean square, N m or N.
    pub rms: Vec<f64>,
    /// Greatest magnitude over the torque limit.
    pub of_limit: Vec<Option<f64>>,
}

/// How a closed loop went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tracking {
    /// Per joint, greatest error, rad or m.
    pub max: Vec<f64>,
    /// Per joint, root mean square of it.
    pub rms: Vec<f64>,
    /// What ended it early, or braked it.
    pub fault: Option<String>,
}

/// The fewest terms that keep the tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fewest {
    /// Whether the scene asks for them: `terms = "auto"`, at this tolerance.
    pub chosen: bool,
    /// What goes.
    pub given_up: Vec<&'static str>,
    /// What that does, all together.
    pub dropped: Dropped,
}

/// Explain a scene.
///
/// # Errors
/// A scene that is wrong or cannot be run; a tolerance that is none.
pub fn run(args: &ExplainArgs, costs: &Costs<'_>, stop: &AtomicBool) -> Result<(), Failure> {
    let file = SceneFile::load(&args.scene).map_err(Failure::input)?;
    if let Some(tolerance) = args.tolerance.filter(|tolerance| !(0.0..=0.5).contains(tolerance)) {
        return Err(Failure::Input(miette::miette!(
            "--tolerance {tolerance}: expected a share of each joint's torque limit, 0 to 0.5"
        )));
    }
    let mut explanation = with_dof!(file.robot.dof(), N => explain::<N>(&file, args.tolerance, stop))?;
    if args.chip {
        explanation.measure(&args.scene, costs, stop)?;
    }
    let text = if args.json {
        serde_json::to_string_pretty(&explanation).map_err(|error| Failure::Output(error.into()))? + "\n"
    } else {
        explanation.text()
    };
    exit::print(&text)
}

/// What the scene's model computes, and why.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run, [`Failure::Interrupted`].
pub fn explain<const N: usize>(
    file: &SceneFile,
    tolerance: Option<f64>,
    stop: &AtomicBool,
) -> Result<Explanation, Failure> {
    let model = file.robot.model::<N>().map_err(Failure::input)?;
    let along = Along::new(file, &model)
        .map_err(|error| Failure::Input(miette::miette!("{}: the motion cannot be: {error}", file.path.display())))?;
    let asked = file.model.auto.as_ref().map(|auto| auto.tolerance);
    let tolerance = tolerance.or(asked).unwrap_or(TOLERANCE);
    let lab = Lab { file, along, tolerance, stop };
    let full = file.model.full();
    let terms = ModelTerm::ALL.into_iter().map(|term| {
        let present = full.state(term) != Term::Absent;
        let dropped = if present { Some(lab.dropped(&[term])?) } else { None };
        let (state, why) = state(file, term);
        Ok(TermReport { term: term.name(), state, why, dropped })
    });
    let fewest = lab.along.fewest_terms(tolerance).given_up;
    Ok(Explanation {
        scene: file.name.clone(),
        robot: file.robot.name.clone(),
        law: file.control.names().0,
        level: file.control.kernel.level().unwrap_or(robot_compiler::kernel::Level::Exact).name(),
        joints: file.robot.joints.iter().map(Joint::new).collect(),
        tolerance,
        operations: Count::less(&lab.along.operations_without(&[]), &Operations::default()),
        chip: None,
        tracking: lab.tracking(&[])?,
        terms: terms.collect::<Result<_, Failure>>()?,
        fewest: Fewest {
            chosen: asked == Some(tolerance),
            given_up: fewest.iter().map(|term| term.name()).collect(),
            dropped: lab.dropped(&fewest)?,
        },
    })
}

/// What a term is in the scene, and where that was said.
fn state(file: &SceneFile, term: ModelTerm) -> (&'static str, String) {
    let name = |state: Term<()>| match state {
        Term::Absent => "absent",
        Term::Constant(()) => "constant",
        Term::Live => "live",
    };
    let line = |table, key| file.line_of(table, key).map(|line| format!("line {line}"));
    if file.model.auto.is_some() {
        let (full, now) = (file.model.full().state(term), file.model.state(term));
        let state = if full == now { name(now) } else { "given up" };
        // What acts stands in [plant]; the rest is the robot's, or always there.
        let world = match term {
            ModelTerm::Rotors | ModelTerm::VelocityTerms => None,
            _ => line("plant", term.key()),
        };
        let auto = line("model", "terms").unwrap_or_default();
        let why =
            if full == now && full == Term::Absent { world.unwrap_or_else(default) } else { format!("auto, {auto}") };
        return (state, why);
    }
    (name(file.model.state(term)), line("model", term.key()).unwrap_or_else(default))
}

fn default() -> String {
    "default".to_owned()
}

/// A scene, to try models in.
struct Lab<'a, const N: usize> {
    file: &'a SceneFile,
    along: Along<'a, N>,
    tolerance: f64,
    stop: &'a AtomicBool,
}

impl<const N: usize> Lab<'_, N> {
    fn dropped(&self, terms: &[ModelTerm]) -> Result<Dropped, Failure> {
        let error = self.along.error_without(terms);
        let [with, without] = [&[], terms].map(|terms| self.along.operations_without(terms));
        let loop_gain = self.along.loop_gain_without(terms);
        let within_tolerance = error.worst_of_limit() <= self.tolerance;
        Ok(Dropped {
            operations: Count::less(&with, &without),
            chip: None,
            within_tolerance,
            loop_gain: loop_gain.least,
            weakest_joint: (loop_gain.least < 1.0).then_some(loop_gain.joint),
            may_go: within_tolerance && !loop_gain.is_too_weak(),
            torque_error: Error::from(error),
            tracking: self.tracking(terms)?,
        })
    }

    /// The loop with the full model less these terms, in the world and along the motion of the scene.
    fn tracking(&self, terms: &[ModelTerm]) -> Result<Tracking, Failure> {
        let mut world = simulate::world::<N>(self.file)?;
        let mut scene = self.file.clone();
        scene.model = self.file.model.full().without(terms);
        let run = simulate::on_desk_in::<N>(&mut world, &scene, self.stop, &ProgressBar::hidden())?;
        if run.end == End::Interrupted {
            return Err(Failure::Interrupted);
        }
        let fault = run.summary.faults.first().map(|fault| fault.message.clone());
        Ok(Tracking {
            fault: fault.or(run.summary.stopped),
            max: run.summary.tracking_max,
            rms: run.summary.tracking_rms,
        })
    }
}

impl Joint {
    fn new(joint: &robot_compiler::RobotJoint) -> Self {
        let limit = joint.spec.limits.torque;
        let (torque_unit, position_unit) = match joint.spec.kind {
            JointKind::Revolute => ("N m", "rad"),
            JointKind::Prismatic => ("N", "m"),
        };
        let torque_limit = limit.is_finite().then_some(limit);
        Self { name: joint.name.clone(), torque_unit, position_unit, torque_limit }
    }
}

impl Count {
    fn less(more: &Operations, less: &Operations) -> Self {
        let signed = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
        Self {
            mul: signed(more.mul) - signed(less.mul),
            add: signed(more.add) - signed(less.add),
            sub: signed(more.sub) - signed(less.sub),
        }
    }
}

impl From<TorqueError> for Error {
    fn from(TorqueError { max, rms, of_limit }: TorqueError) -> Self {
        Self { max, rms, of_limit }
    }
}

impl Error {
    /// The joint that is worst off, by its share of the limit, or where no joint has one by the torque.
    fn worst(&self) -> usize {
        let by = |i: &usize| (self.of_limit[*i].unwrap_or(0.0), self.max[*i]);
        let worse = |a: &usize, b: &usize| by(a).partial_cmp(&by(b)).unwrap_or(core::cmp::Ordering::Equal);
        (0..self.max.len()).max_by(worse).unwrap_or(0)
    }
}

impl Explanation {
    /// Measure the tick of the chip with every term and without each.
    fn measure(&mut self, scene: &Path, costs: &Costs<'_>, stop: &AtomicBool) -> Result<(), Failure> {
        let base = Base::load(scene)?;
        let folder = Path::new("out/explain").join(file_name(&self.scene));
        fs::create_dir_all(&folder).map_err(|error| in_file(&folder, &error))?;
        let term = |name: &str| ModelTerm::ALL.into_iter().find(|term| term.name() == name);
        let mut sets: Vec<Vec<ModelTerm>> = vec![Vec::new()];
        sets.extend(
            self.terms
                .iter()
                .filter(|report| report.dropped.is_some())
                .map(|report| term(report.term).into_iter().collect()),
        );
        sets.push(self.fewest.given_up.iter().filter_map(|name| term(name)).collect());
        let paths = sets.iter().map(|terms| {
            let names: Vec<&str> = terms.iter().map(|term| term.key()).collect();
            let path = folder.join(format!(
                "without_{}.toml",
                if names.is_empty() { "nothing".to_owned() } else { names.join("_") }
            ));
            fs::write(&path, base.without(terms)).map_err(|error| in_file(&path, &error))?;
            Ok(path)
        });
        let paths: Vec<PathBuf> = paths.collect::<Result<_, Failure>>()?;
        let found = costs(&paths, stop)?;
        let Some((full, rest)) = found.split_first() else { return Ok(()) };
        let saving = |cost: &Cost| ChipSaving {
            instructions: full.instructions - cost.instructions,
            cycles: full.cycles - cost.cycles,
            flash: full.flash as i64 - cost.flash as i64,
        };
        let each = self.terms.iter_mut().filter_map(|report| report.dropped.as_mut());
        for (dropped, cost) in each.chain(core::iter::once(&mut self.fewest.dropped)).zip(rest) {
            dropped.chip = Some(saving(cost));
        }
        self.chip = Some(*full);
        Ok(())
    }

    /// The tables, as a person reads them.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { scene, robot, law, level, operations: Count { mul, add, sub }, .. } = self;
        let mut text = format!("{scene}: {robot}, {law}, kernel {level}: {mul} mul, {add} add, {sub} sub\n");
        if let Some(Cost { instructions, cycles, flash, ram, .. }) = self.chip {
            text += &format!(
                "a tick of the chip: {instructions:.0} instructions, {cycles:.0} cycles (estimate), {flash} bytes of flash, {ram} of RAM\n"
            );
        }
        text += &format!("{}\n", self.cost_table());
        let torques = self.joint_table(None, |i, dropped| {
            let (unit, error) = (self.joints[i].torque_unit, &dropped.torque_error);
            format!("{} ({})", engineering(error.max[i], unit), engineering(error.rms[i], unit))
        });
        let most = |i: usize, tracking: &Tracking| match tracking.fault {
            Some(_) => "fault".to_owned(),
            None => engineering(tracking.max[i], self.joints[i].position_unit),
        };
        let baseline = |i: usize| most(i, &self.tracking);
        let tracking = self.joint_table(Some(&baseline), |i, dropped| most(i, &dropped.tracking));
        text += &format!("\nTorque left out without, on the reference motion: most (root mean square)\n{torques}\n");
        text += &format!("\nGreatest tracking error of the closed loop without, in the scene's world\n{tracking}\n");
        text + "\n" + &self.fewest_lines()
    }

    fn cost_table(&self) -> Table {
        let mut head = vec!["term", "is", "because of", "mul", "add", "sub"];
        if self.chip.is_some() {
            head.extend(["instructions", "cycles, est.", "flash"]);
        }
        head.extend(["torque error", "of the limit", "joint", "loop gain", "may go"]);
        let mut table = table(&head, 3);
        for report in &self.terms {
            let names = [report.term, report.state, &report.why].map(str::to_owned);
            let Some(dropped) = &report.dropped else {
                let empty = core::iter::repeat_n("-".to_owned(), head.len() - 3);
                table.add_row(names.into_iter().chain(empty).collect::<Vec<_>>());
                continue;
            };
            let Dropped { operations: Count { mul, add, sub }, chip, torque_error, may_go, .. } = dropped;
            let worst = torque_error.worst();
            let joint = &self.joints[worst];
            let share = torque_error.of_limit[worst].map_or_else(|| "no limit".to_owned(), percent);
            let most = engineering(torque_error.max[worst], joint.torque_unit);
            let may_go = if *may_go { "yes" } else { "no" };
            let counts = [mul, add, sub].map(i64::to_string);
            let on_chip = chip.iter().flat_map(|chip| {
                [format!("{:.0}", chip.instructions), format!("{:.0}", chip.cycles), chip.flash.to_string()]
            });
            let rest = [most, share, joint.name.clone(), self.loop_gain(dropped), may_go.to_owned()];
            table.add_row(names.into_iter().chain(counts).chain(on_chip).chain(rest).collect::<Vec<_>>());
        }
        table
    }

    /// The least loop gain, and the joint that feels it.
    fn loop_gain(&self, dropped: &Dropped) -> String {
        dropped.weakest_joint.map_or_else(
            || "1".to_owned(),
            |joint| format!("{} {}", percent(dropped.loop_gain), self.joints[joint].name),
        )
    }

    /// A row per joint; a column without anything dropped, where that is given, one per term that is not absent, and one for all
    /// that can go together.
    fn joint_table(
        &self,
        nothing: Option<&dyn Fn(usize) -> String>,
        cell: impl Fn(usize, &Dropped) -> String,
    ) -> Table {
        let each = self.terms.iter().filter_map(|report| Some((report.term, report.dropped.as_ref()?)));
        let together = (self.fewest.given_up.len() > 1).then_some(("all that may go", &self.fewest.dropped));
        let columns: Vec<(&str, &Dropped)> = each.chain(together).collect();
        let head =
            core::iter::once("joint").chain(nothing.map(|_| "nothing")).chain(columns.iter().map(|(name, _)| *name));
        let mut table = table(&head.collect::<Vec<_>>(), 1);
        for (i, joint) in self.joints.iter().enumerate() {
            let cells = columns.iter().map(|(_, dropped)| cell(i, dropped));
            let cells = core::iter::once(joint.name.clone()).chain(nothing.map(|cell| cell(i))).chain(cells);
            table.add_row(cells.collect::<Vec<_>>());
        }
        table
    }

    fn fewest_lines(&self) -> String {
        let Fewest { chosen, given_up, dropped } = &self.fewest;
        let share = dropped.torque_error.of_limit[dropped.torque_error.worst()].map_or("nothing".to_owned(), percent);
        let Count { mul, add, sub } = dropped.operations;
        let what = if given_up.is_empty() {
            "nothing".to_owned()
        } else {
            let gain = self.loop_gain(dropped);
            let names = given_up.join(", ");
            format!("{names}: {share} of a limit at most, loop gain {gain}, {mul} mul, {add} add, {sub} sub less")
        };
        let verb = if *chosen { "given up" } else { "could go" };
        let mut lines = vec![
            ("tolerance", format!("{} of each joint's torque limit", percent(self.tolerance))),
            ("least loop gain", format!("{} of the full model's", LoopGain::LEAST)),
            (verb, what),
        ];
        let faults = self.terms.iter().filter_map(|report| {
            let fault = report.dropped.as_ref()?.tracking.fault.as_ref()?;
            Some(format!("{}: {fault}", report.term))
        });
        lines.extend(faults.map(|fault| ("fault without", fault)));
        if self.law == "pd" {
            lines.push(("law", "pd computes no inverse dynamics: in its loop only friction is felt".to_owned()));
        }
        lines.iter().fold(String::new(), |text, (name, line)| text + &format!("{name:<20}{line}\n"))
    }
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

/// A table whose first columns are words and the others numbers.
fn table(head: &[&str], words: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(head);
    for column in table.column_iter_mut().skip(words) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
