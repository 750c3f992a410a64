//! Speed against accuracy, measured: the cost of every choice on the chip, and its errors in newton-metres and radians.
//!
//! | module | holds |
//! |---|---|
//! | [`choice`] | the choices, and how a scene file states them |
//! | [`product`] | the set of choices to measure |
//! | [`baseline`] | the scene that choices are written into |
//! | [`mod@test_motions`] | the motions on which every choice is measured |
//! | [`measure`] | torque error against a computation in 31 digits, tracking error of the closed loop |
//! | `store` | measurements of earlier calls |
//! | [`mod@pareto_front`] | the choices on the Pareto front |
//! | [`simulator`] | errors of an integrator and its step |
//! | [`request`] | requirements on a choice, and the cheapest choice that meets them |
//! | [`report`] | tables, CSV, plot, Markdown |
//!
//! A choice is a scene file: the desk's simulation, the chip's program and the user read the same text.

pub mod baseline;
pub mod choice;
pub mod measure;
pub mod pareto_front;
pub mod product;
pub mod report;
pub mod request;
pub mod simulator;
mod store;
pub mod test_motions;

use crate::chip::cost;
use crate::failure::{Failure, in_file};
use crate::study::parallel::try_in_parallel;
use baseline::Baseline;
use choice::{Choice, Named};
use indicatif::ProgressBar;
use measure::{Exact, OnMotion, on_motion};
use robot_compiler::{SceneFile, with_dof};
use serde::{Deserialize, Serialize};
use simulator::MethodReport;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use store::{Store, digest, of_this_program};
use test_motions::{TestMotion, TestMotionReport, test_motions};

/// Cost of a tick on the chip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Mean number of instructions per tick.
    pub instructions: f64,
    /// Greatest number of instructions per tick.
    pub instructions_max: u64,
    /// Mean number of cycles per tick from flash: an estimate.
    pub cycles: f64,
    /// Greatest number of cycles per tick from flash: an estimate.
    pub cycles_max: f64,
    /// Code size of the tick and of everything it calls, bytes.
    pub flash: u64,
    /// State of the controller, bytes.
    pub ram: u64,
    /// Whether the chip's torques equal the desk's to the last bit.
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

/// Measure on the emulated chip, and install the tools that this needs. A tick that brakes is an error, and so is a
/// torque that differs from the desk's in any bit: the cost of such a tick would be meaningless.
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

/// Function that measures the costs of scene files on the chip, in their order.
pub type Costs<'a> = dyn Fn(&[PathBuf], &AtomicBool) -> Result<Vec<Cost>, Failure> + 'a;

/// A choice and its measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The choice, by the names of the command line.
    pub choice: Named,
    /// Command that repeats the measurement of this point.
    pub command: String,
    /// Cost on the chip.
    pub cost: Cost,
    /// Errors on each test motion.
    pub courses: Vec<OnMotion>,
    /// Greatest torque error over its joint's limit on any test motion; `None` if the controller braked.
    pub torque_of_limit: Option<f64>,
    /// Greatest tracking error of any joint on any test motion, rad or m; `None` if a loop ended early.
    pub tracking: Option<f64>,
    /// On the Pareto front of cycles and torque error: no other point takes fewer cycles with a smaller torque error.
    pub on_torque_front: bool,
    /// On the Pareto front of cycles and tracking error: no other point takes fewer cycles with a smaller tracking
    /// error.
    pub on_tracking_front: bool,
    #[serde(skip)]
    pub(crate) chosen: Choice,
}

/// A trade-off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trade {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// The test motions.
    pub courses: Vec<TestMotionReport>,
    /// The choice in the scene's own file.
    pub own: Named,
    /// Every choice, sorted by cycles, the fewest first.
    pub points: Vec<Point>,
    /// Integrators of the simulated arm and their steps.
    pub simulator: Vec<MethodReport>,
}

/// Working environment of a trade-off.
pub struct Workshop<'a> {
    /// Folder for the measurements and the scene of every choice.
    pub folder: &'a Path,
    /// Repeat measurements that are already stored.
    pub fresh: bool,
    /// Set by Ctrl-C.
    pub stop: &'a AtomicBool,
    /// Progress bar.
    pub progress: &'a ProgressBar,
}

/// Measure every choice.
///
/// # Errors
/// A choice that the scene does not allow; a chip that cannot be built or run; a file that cannot be written; an
/// interruption. After an interruption the next call resumes the work.
pub fn trade(
    base: &Baseline,
    named: &Path,
    choices: &[Choice],
    costs: &Costs<'_>,
    shop: &Workshop<'_>,
) -> Result<Trade, Failure> {
    with_dof!(base.file.robot.dof(), N => of_arm::<N>(base, named, choices, costs, shop))
}

/// A choice written as a scene.
struct Candidate {
    choice: Choice,
    text: String,
    file: SceneFile,
}

fn of_arm<const N: usize>(
    base: &Baseline,
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
    let courses = test_motions::<N>(&base.file, &model)?;
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
    pareto_front::mark(&mut points);
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

/// Torque and tracking errors of every candidate; stored measurements of the same text are reused.
fn on_desk<const N: usize>(
    candidates: &[Candidate],
    model: &dynamics_core::Model<f64, N>,
    base: &SceneFile,
    courses: &[TestMotion<N>; 3],
    store: &Store,
    key: &(impl Fn(&str, &str) -> String + Sync),
    shop: &Workshop<'_>,
) -> Result<Vec<Vec<OnMotion>>, Failure> {
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
                let found = each.map(|(course, exact)| on_motion(&candidate.file, model, course, exact, shop.stop));
                let found: Vec<OnMotion> = found.collect::<Result<_, _>>()?;
                store.put(&key, &found)?;
                found
            }
        };
        shop.progress.inc(1);
        Ok(done)
    })
}

/// Cost of every candidate; all missing costs are measured together.
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
    // Stored batch by batch, so that an interruption loses no finished batch.
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

/// Number of choices that are measured on the chip before they are stored.
const BATCH: usize = 8;
