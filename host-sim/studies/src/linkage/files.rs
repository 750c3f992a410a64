//! A turn or a motion as files: log, summary and plots.

use super::run::{Moment, Run, RunSummary};
use super::turn::{Step, Turn, TurnSummary};
use sim::failure::{Failure, in_file};
use sim::run::plot::{self, Chart, Layout, Line, Panel};
use std::fs;
use std::path::{Path, PathBuf};

/// Write a turn's log, summary and plots; returns their paths.
pub fn write_turn(folder: &Path, turn: &Turn, summary: &TurnSummary, json: &str) -> Result<Vec<PathBuf>, Failure> {
    write(folder, "driven.csv", &header(summary), turn.steps.iter().map(row), json, &turn_charts(turn, summary))
}

/// Write a motion's log, summary and plots; returns their paths.
pub fn write_run(folder: &Path, run: &Run, summary: &RunSummary, json: &str) -> Result<Vec<PathBuf>, Failure> {
    let header = ["t", "crank_angle", "crank_speed", "kinetic_energy", "potential_energy", "work"].map(str::to_owned);
    let log = run.moments.iter().map(|m| vec![m.time, m.angle, m.speed, m.kinetic, m.potential, m.work]);
    write(folder, "free.csv", &header, log, json, &run_charts(run, summary))
}

/// Write log, summary and plots; returns their paths.
fn write(
    folder: &Path,
    log: &str,
    header: &[String],
    rows: impl Iterator<Item = Vec<f64>>,
    json: &str,
    charts: &[(&str, Chart)],
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
    let mut files = vec![log, summary];
    for (name, chart) in charts {
        let path = folder.join(name);
        plot::write_chart(chart, &path).map_err(|error| in_file(&path, &error))?;
        files.push(path);
    }
    Ok(files)
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

fn turn_charts(turn: &Turn, summary: &TurnSummary) -> Vec<(&'static str, Chart)> {
    const ABSCISSA: &str = "crank angle / rad";
    let chart = |title: &str, panels| Chart {
        title: format!("{title}: {}", summary.linkage),
        abscissa: ABSCISSA,
        range: None,
        layout: Layout::Stacked,
        panels,
    };
    let line = |name, value: fn(&Step) -> f64| Line { name, pen: None, pieces: turn.pieces(value) };
    let moment = Panel {
        caption: format!("at {} rad/s", summary.speed),
        quantity: "moment",
        unit: "N m",
        lines: vec![line("M_0", |step| step.forces.driving_moment)],
        marks: vec![],
        bounds: vec![],
        limited: vec![],
    };
    let force = Panel {
        caption: "F_3 - F_0".to_owned(),
        quantity: "force",
        unit: "N",
        lines: vec![
            line("along x", |step| step.forces.shaking_force().x),
            line("along y", |step| step.forces.shaking_force().y),
            line("magnitude", |step| step.forces.shaking_force().norm()),
        ],
        marks: vec![],
        bounds: vec![],
        limited: vec![],
    };
    let about = Panel {
        caption: "about the crank's ground pivot".to_owned(),
        quantity: "moment",
        unit: "N m",
        lines: vec![line("moment", |step| step.forces.shaking_moment())],
        marks: vec![],
        bounds: vec![],
        limited: vec![],
    };
    vec![
        ("driving_moment.svg", chart("Driving moment", vec![moment])),
        ("shaking_force.svg", chart("Shaking force", vec![force])),
        ("shaking_moment.svg", chart("Shaking moment", vec![about])),
    ]
}

fn run_charts(run: &Run, summary: &RunSummary) -> Vec<(&'static str, Chart)> {
    let line = |name, value: fn(&Moment) -> f64| Line {
        name,
        pen: None,
        pieces: vec![run.moments.iter().map(|now| (now.time, value(now))).collect()],
    };
    let chart = |title: &str, panels| Chart {
        title: format!("{title}: {}", summary.linkage),
        abscissa: "time / s",
        range: None,
        layout: Layout::Stacked,
        panels,
    };
    let panel = |caption: &str, quantity, unit, lines| Panel {
        caption: caption.to_owned(),
        quantity,
        unit,
        lines,
        marks: vec![],
        bounds: vec![],
        limited: vec![],
    };
    let angle = panel("crank", "angle", "rad", vec![line("crank", |now| now.angle)]);
    let speed = panel("crank", "speed", "rad/s", vec![line("crank", |now| now.speed)]);
    let energy =
        vec![line("kinetic", |now| now.kinetic), line("potential", |now| now.potential), line("work", |now| now.work)];
    vec![
        ("motion.svg", chart("Crank", vec![angle, speed])),
        ("energy.svg", chart("Energy", vec![panel("energy and the moment's work", "energy", "J", energy)])),
    ]
}
