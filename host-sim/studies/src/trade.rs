//! Speed against accuracy, measured: the cost of every choice on the chip, and its errors in torque and position.
//!
//! A choice is a scene file, so that the desk's simulation, the chip's program and the user read the same text.

pub mod baseline;
pub mod chip;
pub mod choice;
mod drive_comparison;
pub mod drive_step;
mod files;
pub mod measure;
mod page;
pub mod pareto_front;
mod points;
pub mod product;
pub mod report;
pub mod request;
pub mod simulator;
mod store;
pub mod test_motions;

use baseline::Baseline;
use chip::{Chip, Cost, InterruptCost};
use choice::Choice;
use drive_step::drive_steps;
use indicatif::ProgressBar;
use measure::{Exact, OnMotion, on_motion};
pub use points::{Trade, TradePoint};
use robot_compiler::{SceneFile, with_dof};
use sim::failure::{Failure, in_file};
use sim::parallel::try_in_parallel;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use store::{Store, digest, of_this_program};
use test_motions::{TestMotion, test_motions};

/// Working environment of a trade-off.
pub struct Workshop<'a> {
    /// Folder for the measurements and the scene of every choice.
    pub folder: &'a Path,
    /// True to repeat measurements that are already stored.
    pub fresh: bool,
    /// Set by Ctrl-C.
    pub stop: &'a AtomicBool,
    /// Progress bar.
    pub progress: &'a ProgressBar,
}

/// Measures every choice.
///
/// # Errors
/// The scene does not allow a choice, the chip's program cannot be built or run, a file cannot be written, or the work is interrupted. After an
/// interruption the next call resumes the work.
pub fn trade(
    base: &Baseline,
    named: &Path,
    choices: &[Choice],
    chip: &dyn Chip,
    shop: &Workshop<'_>,
) -> Result<Trade, Failure> {
    with_dof!(base.file.robot.dof(), N => of_arm::<N>(base, named, choices, chip, shop))
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
    chip: &dyn Chip,
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
    let costs = on_chip(&candidates, &points, chip, &store, &key, shop)?;
    let surroundings = surroundings(base, (&candidates, &costs), &points, chip, &store, &key, shop)?;
    shop.progress.finish_and_clear();

    let points = candidates.iter().zip(desk).zip(costs).map(|((candidate, courses), cost)| {
        let faultless = courses.iter().all(|course| course.fault.is_none());
        let mut torque = courses.iter().map(|course| course.torque_of_limit);
        let tracking = courses.iter().flat_map(|course| &course.tracking.max).fold(0.0, |most, x| f64::max(most, *x));
        TradePoint {
            choice: candidate.choice,
            command: report::command(named, &candidate.choice),
            cost,
            interrupt: surroundings.around(&cost, candidate.choice.rate),
            torque_of_limit: torque.try_fold(0.0, |most: f64, x| Some(most.max(x?))),
            tracking: faultless.then_some(tracking),
            courses,
            on_torque_front: false,
            on_tracking_front: false,
        }
    });
    let mut points: Vec<TradePoint> = points.collect();
    points.sort_by(|a, b| a.cost.cycles.total_cmp(&b.cost.cycles));
    pareto_front::mark(&mut points);
    Ok(Trade {
        scene: base.file.name.clone(),
        robot: base.file.robot.name.clone(),
        joints: base.file.robot.joints.iter().map(|joint| joint.name.clone()).collect(),
        drives: drive_steps(&base.file, &model),
        courses: courses.iter().map(|course| course.report(&base.file, &model)).collect(),
        own: base.own(),
        surroundings,
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
    chip: &dyn Chip,
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
        for (&i, cost) in batch.iter().zip(chip.controllers(&paths, shop.stop)?) {
            store.put(&keys[i], &cost)?;
            found[i] = Some(cost);
            shop.progress.inc(1);
        }
    }
    let all: Option<Vec<Cost>> = found.into_iter().collect();
    all.ok_or_else(|| Failure::Target(miette::miette!("the chip's program did not measure every choice")))
}

/// Cost of the interrupt around the controller, from the firmware of [`Baseline::firmware`].
fn surroundings(
    base: &Baseline,
    (candidates, costs): (&[Candidate], &[Cost]),
    folder: &Path,
    chip: &dyn Chip,
    store: &Store,
    key: &impl Fn(&str, &str) -> String,
    shop: &Workshop<'_>,
) -> Result<InterruptCost, Failure> {
    let text = base.with(&base.firmware());
    let key = key("interrupt", &text);
    if let Some(known) = store.get(&key) {
        return Ok(known);
    }
    let path = folder.join(format!("{key}.toml"));
    fs::write(&path, &text).map_err(|error| in_file(&path, &error))?;
    let known = candidates.iter().position(|candidate| candidate.text == text).and_then(|at| costs.get(at));
    shop.progress.set_message("the interrupt");
    let found = InterruptCost::measure(&path, known, chip, shop.stop)?;
    store.put(&key, &found)?;
    Ok(found)
}

/// Number of choices that are measured on the chip before they are stored.
const BATCH: usize = 8;
