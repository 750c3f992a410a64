//! Runs of a scene, and the figures that are kept of each.

use super::draw::Draw;
use robot_compiler::SceneFile;
use robot_compiler::study::{Drawn, Experiment, Figure, Metric, Study, Template};
use sim::failure::Failure;
use sim::run::batch::Kernels;
use sim::run::closed_loop::End;
use sim::run::simulate::{self, Run};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Titles of the columns after the figures.
pub(super) const ENDINGS: [&str; 2] = ["end", "pass"];

/// Ending of a run whose figures cover its full duration.
pub(super) const COMPLETE: &str = "complete";

/// Ending of a run with values that make no valid scene.
pub(super) const REFUSED: &str = "refused";

/// A scene whose keys vary.
#[derive(Debug)]
pub(super) struct SceneRuns {
    experiment: Experiment,
    template: Template,
    draw: Draw,
    kernels: Kernels,
    pub(super) scene_name: String,
    /// Unit of each figure, for the arm of the first run; empty if it has none.
    pub(super) units: Vec<String>,
}

impl SceneRuns {
    /// Reads the scene, and checks its first run.
    ///
    /// # Errors
    /// [`Failure::Input`]: the scene cannot be read, a key does not exist, the first run is invalid, or a figure names a joint that the arm does not
    /// have.
    pub(super) fn new(study: &Study) -> Result<Self, Failure> {
        let template = Template::load(study).map_err(Failure::input)?;
        let draw = Draw::new(&study.runs, study.experiment.vary.len());
        let (scene_name, units) = (String::new(), Vec::new());
        let experiment = study.experiment.clone();
        let mut runs = Self { experiment, template, draw, kernels: Kernels::default(), scene_name, units };
        let scene = runs.template.check(study, &runs.values(0)).map_err(Failure::input)?;
        let dof = scene.robot.dof();
        let kinds: Vec<_> = scene.robot.joints.iter().map(|joint| joint.spec.kind).collect();
        runs.units = runs.experiment.metrics.iter().map(|metric| metric.unit(&kinds)).collect();
        runs.scene_name = scene.name;
        match runs.experiment.metrics.iter().find(|metric| metric.joint.is_some_and(|joint| joint > dof)) {
            None => Ok(runs),
            Some(metric) => Err(Failure::Input(miette::miette!(
                help = format!("expected a joint from 1 to {dof}"),
                "{}: metric `{}`: the arm has {dof} joints",
                study.path.display(),
                metric.title
            ))),
        }
    }

    /// Titles of the columns after the index.
    pub(super) fn columns(&self) -> Vec<String> {
        let keys = self.experiment.vary.iter().map(|vary| vary.key.name.clone());
        let metrics = self.experiment.metrics.iter().map(|metric| metric.title.clone());
        keys.chain(metrics).chain(ENDINGS.map(str::to_owned)).collect()
    }

    /// Reason why the values of a run make no valid scene, without paths of this machine.
    pub(super) fn refusal(&self, index: u64) -> Option<String> {
        let error = self.template.scene(&self.values(index)).err()?;
        Some(format!("{}: {}, expected {}", error.field(), error.problem(), error.expected()))
    }

    /// Values of a run.
    pub(super) fn values(&self, index: u64) -> Vec<Drawn<'_>> {
        self.draw.values(&self.experiment.vary, index)
    }

    /// The texts of a run's scene, and of its robot if the run changes it.
    pub(super) fn texts(&self, index: u64) -> (String, Option<String>) {
        self.template.texts(&self.values(index))
    }

    /// Returns the scene of a run.
    ///
    /// # Errors
    /// [`Failure::Input`] for values that make the scene impossible.
    pub(super) fn scene(&self, index: u64) -> Result<SceneFile, Failure> {
        self.template.scene(&self.values(index)).map_err(Failure::input)
    }

    /// Does the runs with these indices; returns the cells of each.
    ///
    /// # Errors
    /// [`Failure::Interrupted`] after `stop`.
    pub(super) fn rows(&self, indices: Range<u64>, stop: &AtomicBool) -> Result<Vec<Vec<String>>, Failure> {
        let drawn: Vec<(u64, Vec<Drawn<'_>>)> = indices.map(|index| (index, self.values(index))).collect();
        let scenes: Vec<_> =
            drawn.iter().map(|(_, values)| self.template.scene(values).map_err(Failure::input)).collect();
        let endings = self.on_desk(scenes, stop);
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
        drawn.iter().zip(endings).map(|((index, values), ending)| self.row(*index, values, ending)).collect()
    }

    /// Cells after the values of each scene; all scenes have the same number of joints.
    fn on_desk(&self, scenes: Vec<Result<SceneFile, Failure>>, stop: &AtomicBool) -> Vec<Result<Vec<String>, Failure>> {
        simulate::on_desk_side_by_side(&self.kernels, scenes, stop, |run| self.ending(&run))
    }

    /// Cells after the values of a run.
    fn ending(&self, run: &Run) -> Vec<String> {
        let metrics = &self.experiment.metrics;
        let figures: Vec<f64> = metrics.iter().map(|metric| figure(metric, run)).collect();
        let end = ending(run);
        let pass = end == COMPLETE && metrics.iter().zip(&figures).all(|(metric, x)| metric.passes(*x));
        let figures = figures.into_iter().map(number);
        figures.chain([end, if pass { "1" } else { "0" }.to_owned()]).collect()
    }

    fn row(
        &self,
        index: u64,
        values: &[Drawn<'_>],
        ending: Result<Vec<String>, Failure>,
    ) -> Result<Vec<String>, Failure> {
        let mut cells: Vec<String> = core::iter::once(index.to_string()).chain(values.iter().map(cell)).collect();
        match ending {
            Ok(ending) => cells.extend(ending),
            Err(Failure::Input(_)) => {
                cells.extend(self.experiment.metrics.iter().map(|_| String::new()));
                cells.extend([REFUSED.to_owned(), String::new()]);
            }
            Err(other) => return Err(other),
        }
        Ok(cells)
    }
}

/// Formats a number for a cell: the shortest text that reads back exactly.
fn number(x: f64) -> String {
    // Drop the signs of NaN and zero, which may differ between processors and between runs in a batch.
    if x.is_nan() { "nan".to_owned() } else { format!("{:?}", x + 0.0) }
}

fn cell(value: &Drawn<'_>) -> String {
    match value {
        Drawn::Number(x) => number(*x),
        Drawn::Whole(x) => x.to_string(),
        Drawn::Listed(listed) => listed.cell.clone(),
    }
}

/// Ending of a run: `complete`, `fault N` with the first fault's number, or `diverged`.
fn ending(run: &Run) -> String {
    match (&run.end, run.summary.faults.first()) {
        (End::Diverged(_), _) => "diverged".to_owned(),
        (_, Some(fault)) => format!("fault {}", fault.code),
        _ => COMPLETE.to_owned(),
    }
}

/// A figure of a run: for one joint, or the largest over all joints.
fn figure(metric: &Metric, run: &Run) -> f64 {
    let summary = &run.summary;
    let record = &run.record;
    let joints = record.joints().len();
    let one = |joint: usize| match metric.figure {
        Figure::TrackingRms => summary.tracking_rms[joint],
        Figure::TrackingMax => summary.tracking_max[joint],
        Figure::TorqueRms => summary.torque_rms[joint],
        Figure::TorquePeak => summary.torque_peak[joint],
        Figure::TorqueChatter => summary.torque_chatter[joint],
        Figure::ExternalRms => summary.external_rms.as_ref().map_or(f64::NAN, |external| external[joint]),
        Figure::RestError => summary.rest_error[joint].map_or(f64::NAN, f64::abs),
        Figure::SettlingTime => summary.settling_time[joint].unwrap_or(f64::INFINITY),
        Figure::LimitedTicks => {
            let counts = &summary.limits[joint];
            (counts.position + counts.velocity + counts.torque + counts.torque_rate) as f64
        }
        Figure::Drift => {
            let (first, last) = (record.joint(joint).next(), record.joint(joint).last());
            first.zip(last).map_or(f64::NAN, |(first, last)| (last.q - first.q).abs())
        }
        Figure::SpeedMax => record.joint(joint).map(|sample| sample.qd.abs()).fold(0.0, f64::max),
        Figure::Faults => summary.faults.len() as f64,
        Figure::OutOfReach => f64::from(u8::from(summary.supervision.out_of_reach.is_some())),
    };
    match metric.joint {
        Some(joint) => one(joint - 1),
        None if !metric.figure.is_per_joint() => one(0),
        // If the figure of any joint is NaN, the result is NaN.
        None => (0..joints).map(one).fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most }),
    }
}
