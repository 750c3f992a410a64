//! Output files of a turn or a motion: log, summary and report.

use super::run::{Moment, Run, RunSummary};
use super::turn::{Step, Turn, TurnSummary};
use report::{Block, Figure, Page, Series};
use sim::failure::{Failure, in_file};
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a turn's log, summary and report; returns their paths.
pub fn write_turn(folder: &Path, turn: &Turn, summary: &TurnSummary, json: &str) -> Result<Vec<PathBuf>, Failure> {
    write(folder, "driven.csv", &header(summary), turn.steps.iter().map(row), json, &turn_page(turn, summary))
}

/// Writes a motion's log, summary and report; returns their paths.
pub fn write_run(folder: &Path, run: &Run, summary: &RunSummary, json: &str) -> Result<Vec<PathBuf>, Failure> {
    let header = ["t", "crank_angle", "crank_speed", "kinetic_energy", "potential_energy", "work"].map(str::to_owned);
    let log = run.moments.iter().map(|m| vec![m.time, m.angle, m.speed, m.kinetic, m.potential, m.work]);
    write(folder, "free.csv", &header, log, json, &run_page(run, summary))
}

/// Writes log, summary and report; returns their paths.
fn write(
    folder: &Path,
    log: &str,
    header: &[String],
    rows: impl Iterator<Item = Vec<f64>>,
    json: &str,
    page: &Page,
) -> Result<Vec<PathBuf>, Failure> {
    let log = folder.join(log);
    let mut csv = csv::Writer::from_path(&log).map_err(|error| in_file(&log, &error))?;
    csv.write_record(header).map_err(|error| in_file(&log, &error))?;
    for row in rows {
        csv.write_record(row.iter().map(f64::to_string)).map_err(|error| in_file(&log, &error))?;
    }
    csv.flush().map_err(|error| in_file(&log, &error))?;
    let summary = folder.join("summary.json");
    fs::write(&summary, format!("{json}\n")).map_err(|error| in_file(&summary, &error))?;
    let report = folder.join("report.html");
    sim::pages::write(&report, page)?;
    Ok(vec![log, summary, report])
}

fn header(summary: &TurnSummary) -> Vec<String> {
    let output = if summary.follower_angle.is_some() { "follower_angle" } else { "slider_position" };
    let mut names = vec!["crank_angle".to_owned(), "coupler_angle".to_owned(), output.to_owned()];
    for link in 1..=3 {
        names.extend(["omega", "alpha", "vx", "vy", "ax", "ay"].map(|quantity| format!("{quantity}{link}")));
    }
    names.push("driving_moment".to_owned());
    for joint in 0..4 {
        names.extend(["x", "y"].map(|axis| format!("f{joint}{axis}")));
    }
    names.extend(["guide_moment", "shaking_force_x", "shaking_force_y", "shaking_moment"].map(str::to_owned));
    names
}

fn row(step: &Step) -> Vec<f64> {
    let mut values = vec![step.angle, step.coupler, step.output];
    for m in &step.motion {
        values.extend([m.omega, m.alpha, m.velocity.x, m.velocity.y, m.acceleration.x, m.acceleration.y]);
    }
    let forces = &step.forces;
    values.push(forces.driving_moment);
    values.extend(forces.joints.iter().flat_map(|force| [force.x, force.y]));
    let shaking = forces.shaking_force();
    values.extend([forces.guide_moment, shaking.x, shaking.y, forces.shaking_moment()]);
    values
}

fn turn_page(turn: &Turn, summary: &TurnSummary) -> Page {
    let figure = |caption: &str, ordinate: &str| Figure::new(caption, "crank angle / rad", ordinate);
    let line = |name: &str, value: fn(&Step) -> f64| Series::line(name, turn.curve(value));
    let moment = figure("Driving moment", "moment / (N m)").with(line("M_0", |step| step.forces.driving_moment));
    let force = figure("Shaking force F_3 - F_0", "force / N")
        .with(line("along x", |step| step.forces.shaking_force().x))
        .with(line("along y", |step| step.forces.shaking_force().y))
        .with(line("magnitude", |step| step.forces.shaking_force().norm()));
    let about = figure("Shaking moment about the crank's ground pivot", "moment / (N m)")
        .with(line("moment", |step| step.forces.shaking_moment()));
    Page {
        title: format!("{} at {} rad/s", summary.linkage, summary.speed),
        lead: Vec::new(),
        blocks: [moment, force, about].map(Block::Figure).into(),
    }
}

fn run_page(run: &Run, summary: &RunSummary) -> Page {
    let line = |name: &str, value: fn(&Moment) -> f64| {
        Series::line(name, run.moments.iter().map(|now| (now.time, value(now))))
    };
    let figure = |caption: &str, ordinate: &str| Figure::new(caption, "time / s", ordinate);
    let angle = figure("Angle of the crank", "angle / rad").with(line("crank", |now| now.angle));
    let speed = figure("Speed of the crank", "speed / (rad/s)").with(line("crank", |now| now.speed));
    let energy = figure("Energy, and work of the moment", "energy / J")
        .with(line("kinetic", |now| now.kinetic))
        .with(line("potential", |now| now.potential))
        .with(line("work", |now| now.work));
    Page {
        title: format!("{}, free", summary.linkage),
        lead: Vec::new(),
        blocks: [angle, speed, energy].map(Block::Figure).into(),
    }
}
