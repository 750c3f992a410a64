//! Speed for accuracy, measured: every choice of a set, what it costs on the chip and what it costs in newton-metres and radians.
//!
//! | module | holds |
//! |---|---|
//! | [`choice`] | what can be chosen, and what of a scene file says so |
//! | [`product`] | which choices are measured |
//! | [`base`] | the scene that choices are written into |
//! | [`mod@courses`] | the motions that every choice is measured on |
//! | [`measure`] | torque error against 31 digits, tracking of the closed loop |
//! | `store` | what has been measured already |
//! | [`mod@front`] | which choices nothing beats |
//! | [`simulator`] | what an integrator and its step are wrong by |
//! | [`request`] | what is asked of a choice, and the cheapest that meets it |
//! | [`report`] | tables, CSV, plot, Markdown |
//!
//! A choice is a scene file: the desk's simulation, the chip's program and the person who takes it read the same text.

pub mod base;
pub mod choice;
pub mod courses;
pub mod front;
pub mod measure;
pub mod product;
pub mod report;
pub mod request;
pub mod simulator;
mod store;

use crate::chip::cost;
use crate::failure::{Failure, in_file};
use crate::study::parallel::try_in_parallel;
use base::Base;
use choice::{Choice, Named};
use courses::{Course, CourseReport, courses};
use indicatif::ProgressBar;
use measure::{Exact, OnCourse, on_course};
use robot_compiler::{SceneFile, with_dof};
use serde::{Deserialize, Serialize};
use simulator::MethodReport;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use store::{Store, digest, of_this_program};

/// What a tick takes on the chip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Mean instructions of a tick.
    pub instructions: f64,
    /// Most instructions of a tick.
    pub instructions_max: u64,
    /// Mean cycles of a tick from flash: an estimate.
    pub cycles: f64,
    /// Most cycles of a tick from flash: an estimate.
    pub cycles_max: f64,
    /// Bytes of the tick and of all that it reaches.
    pub flash: u64,
    /// Bytes that the controller remembers.
    pub ram: u64,
    /// Whether the chip's torques were the desk's to the last bit.
    pub matches_desk: bool,
}

impl From<cost::Cost> for Cost {
    fn from(cost: cost::Cost) -> Self {
        let cost::Cost { instructions, cycles, flash_bytes, ram_bytes, matches_desk, .. } = cost;
        Self {
            instructions: instructions.mean,
            instructions_max: instructions.max,
            cycles: cycles.mean,
            cycles_max: cycles.max,
            flash: flash_bytes,
            ram: ram_bytes,
            matches_desk,
        }
    }
}

/// Measure on the emulated chip; installs what that needs. A tick that brakes, and a torque that is not the desk's to the last bit,
/// is an error: a cost that was counted on something else is none.
///
/// # Errors
/// As [`cost::measure`].
pub fn on_the_chip(paths: &[PathBuf], stop: &AtomicBool) -> Result<Vec<Cost>, Failure> {
    let costs = cost::measure(paths, stop, &ProgressBar::hidden())?;
    for (path, cost) in paths.iter().zip(&costs) {
        if let Some(braked) = cost.fault {
            let fault = braked.fault().map_or_else(|| format!("fault {}", braked.code), |fault| fault.to_string());
            return Err(Failure::Target(miette::miette!("{}: tick {} braked: {fault}", path.display(), braked.tick)));
        }
        if !cost.matches_desk {
            return Err(Failure::Target(miette::miette!("{}: the chip's torques are not the desk's", path.display())));
        }
    }
    Ok(costs.into_iter().map(Cost::from).collect())
}

/// Measures costs of scene files on the chip, in their order.
pub type Costs<'a> = dyn Fn(&[PathBuf], &AtomicBool) -> Result<Vec<Cost>, Failure> + 'a;

/// A choice and everything that was measured of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The choice, by the names of the command line.
    pub choice: Named,
    /// What measures this point again.
    pub command: String,
    /// On the chip.
    pub cost: Cost,
    /// On each course.
    pub courses: Vec<OnCourse>,
    /// Greatest torque error over its joint's limit on any course; none where the controller braked.
    pub torque_of_limit: Option<f64>,
    /// Greatest tracking error of any joint on any course, rad or m; none where a loop ended early.
    pub tracking: Option<f64>,
    /// No other point takes fewer cycles with a smaller torque error.
    pub on_torque_front: bool,
    /// No other point takes fewer cycles with a smaller tracking error.
    pub on_tracking_front: bool,
    #[serde(skip)]
    pub(crate) chosen: Choice,
}

/// A trade-off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trade {
    /// The scene's name.
    pub scene: String,
    /// The robot's name.
    pub robot: String,
    /// The joints' names.
    pub joints: Vec<String>,
    /// The motions.
    pub courses: Vec<CourseReport>,
    /// What the scene's own file chooses.
    pub own: Named,
    /// Every choice, the fewest cycles first.
    pub points: Vec<Point>,
    /// Integrators of the simulated arm and their steps.
    pub simulator: Vec<MethodReport>,
}

/// Where a trade-off is worked out.
pub struct Workshop<'a> {
    /// What was measured, and the scene of every choice.
    pub folder: &'a Path,
    /// Measure again what is known.
    pub fresh: bool,
    /// Set by Ctrl-C.
    pub stop: &'a AtomicBool,
    /// How far it is.
    pub progress: &'a ProgressBar,
}

/// Measure every choice.
///
/// # Errors
/// A choice that the scene cannot have; a chip that cannot be built or run; a file that cannot be written; an interruption,
/// after which the next call goes on.
pub fn trade(
    base: &Base,
    named: &Path,
    choices: &[Choice],
    costs: &Costs<'_>,
    shop: &Workshop<'_>,
) -> Result<Trade, Failure> {
    with_dof!(base.file.robot.dof(), N => of_arm::<N>(base, named, choices, costs, shop))
}

/// A choice as a scene.
struct Candidate {
    choice: Choice,
    text: String,
    file: SceneFile,
}

fn of_arm<const N: usize>(
    base: &Base,
    named: &Path,
    choices: &[Choice],
    costs: &Costs<'_>,
    shop: &Workshop<'_>,
) -> Result<Trade, Failure> {
    let points = shop.folder.join("points");
    fs::create_dir_all(&points).map_err(|error| in_file(&points, &error))?;
    let candidates = choices.iter().map(|choice| {
        let text = base.with(choice);
        Ok(Candidate { choice: *choice, file: base.read(&text, named)?, text })
    });
    let candidates: Vec<Candidate> = candidates.collect::<Result<_, Failure>>()?;
    let store = Store::open(&shop.folder.join("measured.jsonl"), shop.fresh)?;
    let robot = fs::read(&base.file.robot.path).unwrap_or_default();
    let program = of_this_program();
    let key = |what: &str, text: &str| format!("{what}-{:016x}", digest(&(program, &robot, text)));

    let model = base.file.robot.model::<N>().map_err(Failure::input)?;
    let courses = courses::<N>(&base.file, &model)?;
    shop.progress.set_length(2 * candidates.len() as u64);
    let desk = on_desk(&candidates, &model, &base.file, &courses, &store, &key, shop)?;
    let chip = on_chip(&candidates, &points, costs, &store, &key, shop)?;
    shop.progress.finish_and_clear();

    let points = candidates.iter().zip(desk).zip(chip).map(|((candidate, courses), cost)| {
        let faultless = courses.iter().all(|course| course.fault.is_none());
        let mut torque = courses.iter().map(|course| course.torque_of_limit);
        let tracking = courses.iter().flat_map(|course| &course.tracking.max).fold(0.0, |most, x| f64::max(most, *x));
        Point {
            choice: candidate.choice.named(),
            command: report::command(named, &candidate.choice),
            cost,
            torque_of_limit: torque.try_fold(0.0, |most: f64, x| Some(most.max(x?))),
            tracking: faultless.then_some(tracking),
            courses,
            on_torque_front: false,
            on_tracking_front: false,
            chosen: candidate.choice,
        }
    });
    let mut points: Vec<Point> = points.collect();
    points.sort_by(|a, b| a.cost.cycles.total_cmp(&b.cost.cycles));
    front::mark(&mut points);
    Ok(Trade {
        scene: base.file.name.clone(),
        robot: base.file.robot.name.clone(),
        joints: base.file.robot.joints.iter().map(|joint| joint.name.clone()).collect(),
        courses: courses.iter().map(|course| course.report(&base.file, &model)).collect(),
        own: base.own().named(),
        points,
        simulator: simulator::methods(&base.file, shop.stop)?,
    })
}

/// Torque and tracking errors of every candidate; those of a text that is known are not measured again.
fn on_desk<const N: usize>(
    candidates: &[Candidate],
    model: &dynamics_core::Model<f64, N>,
    base: &SceneFile,
    courses: &[Course<N>; 3],
    store: &Store,
    key: &(impl Fn(&str, &str) -> String + Sync),
    shop: &Workshop<'_>,
) -> Result<Vec<Vec<OnCourse>>, Failure> {
    let mut exact: HashMap<u64, Vec<Exact<N>>> = HashMap::new();
    for candidate in candidates {
        let period = candidate.file.period();
        exact
            .entry(period.to_bits())
            .or_insert_with(|| courses.iter().map(|course| Exact::new(base, model, course, period)).collect());
    }
    try_in_parallel(candidates.len(), |number| {
        let candidate = &candidates[number];
        let key = key("desk", &candidate.text);
        if shop.stop.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
        let known = store.get(&key);
        let done = match known {
            Some(known) => known,
            None => {
                let exact = &exact[&candidate.file.period().to_bits()];
                let each = courses.iter().zip(exact);
                let found = each.map(|(course, exact)| on_course(&candidate.file, model, course, exact, shop.stop));
                let found: Vec<OnCourse> = found.collect::<Result<_, _>>()?;
                store.put(&key, &found)?;
                found
            }
        };
        shop.progress.inc(1);
        Ok(done)
    })
}

/// Costs of every candidate, those that are not known measured together.
fn on_chip(
    candidates: &[Candidate],
    folder: &Path,
    costs: &Costs<'_>,
    store: &Store,
    key: &impl Fn(&str, &str) -> String,
    shop: &Workshop<'_>,
) -> Result<Vec<Cost>, Failure> {
    let keys: Vec<String> = candidates.iter().map(|candidate| key("chip", &candidate.text)).collect();
    let mut found: Vec<Option<Cost>> = keys.iter().map(|key| store.get(key)).collect();
    shop.progress.inc(found.iter().flatten().count() as u64);
    let missing: Vec<usize> = (0..found.len()).filter(|&i| found[i].is_none()).collect();
    // Written down batch by batch: what is done stays done.
    for batch in missing.chunks(BATCH) {
        if shop.stop.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
        let paths = batch.iter().map(|&i| {
            let path = folder.join(format!("{}.toml", keys[i]));
            fs::write(&path, &candidates[i].text).map_err(|error| in_file(&path, &error))?;
            Ok(path)
        });
        let paths: Vec<PathBuf> = paths.collect::<Result<_, Failure>>()?;
        shop.progress.set_message("on the chip");
        for (&i, cost) in batch.iter().zip(costs(&paths, shop.stop)?) {
            store.put(&keys[i], &cost)?;
            found[i] = Some(cost);
            shop.progress.inc(1);
        }
    }
    let all: Option<Vec<Cost>> = found.into_iter().collect();
    all.ok_or_else(|| Failure::Target(miette::miette!("the chip's program did not measure every choice")))
}

/// Choices that are measured on the chip before they are written down.
const BATCH: usize = 8;
