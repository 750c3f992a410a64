//! `linkage`: a closed loop driven round, or let run.

use crate::cli::LinkageArgs;
use crate::cli::run::{file_name, in_file};
use crate::failure::{self, Failure};
use crate::run::plot::{self, Chart, Line, Panel};
use crate::run::summary::engineering;
use crate::study::linkage_run::{self, Run, RunSummary, Start};
use crate::study::linkage_turn::{self, Range, Spread, Step, Turn, TurnSummary, branch_name};
use comfy_table::{CellAlignment, Table, presets};
use dynamics_core::linkage::{Linkage, LinkageError};
use robot_compiler::LinkageFile;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// Steps that a simulation may have: each is a line of the log.
const STEPS_MAX: f64 = 1e6;

/// Speed of a driven crank if none is given, rad/s.
const SPEED: f64 = 10.0;

/// Drive or simulate; returns the exit code.
///
/// # Errors
/// A file or an option that is wrong, a result that cannot be written.
pub fn run(args: &LinkageArgs) -> Result<u8, Failure> {
    let linkage = LinkageFile::load(&args.linkage).map_err(Failure::input)?;
    let given = [("--speed", args.speed), ("--simulate", args.simulate), ("--angle", args.angle)];
    for (option, number) in given.into_iter().filter_map(|(option, number)| Some((option, number?))) {
        // Squares of what is far beyond any machine still have to be numbers.
        if number.is_nan() || number.abs() > 1e9 {
            return Err(Failure::Input(miette::miette!("{option} {number}: expected a number up to 1e9")));
        }
    }
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&linkage.name)));
    match args.simulate {
        None => drive(args, &linkage, &folder),
        Some(moment) => simulate(args, &linkage, moment, &folder),
    }
}

fn drive(args: &LinkageArgs, linkage: &LinkageFile, folder: &Path) -> Result<u8, Failure> {
    let (branch, speed) = (args.branch.into(), args.speed.unwrap_or(SPEED));
    let turn = linkage_turn::turn(linkage, branch, speed, args.steps);
    let summary = turn.summary(linkage, branch, speed);
    if turn.steps.is_empty() {
        let (steps, range) = (args.steps, describe_range(&summary.crank_range));
        return Err(Failure::Input(miette::miette!(
            help = "more steps, or other lengths",
            "{}: at none of the {steps} steps of a turn can the crank be driven: {range}",
            args.linkage.display()
        )));
    }
    let json = json(&summary)?;
    let log = turn.steps.iter().map(row);
    let header = header(&summary);
    let files = write(folder, "driven.csv", &header, log, &json, &turn_charts(&turn, &summary))?;
    show(args.json, &json, || turn_table(&summary), &files)?;
    Ok(0)
}

fn simulate(args: &LinkageArgs, linkage: &LinkageFile, moment: f64, folder: &Path) -> Result<u8, Failure> {
    let steps = (args.duration / args.time_step).ceil();
    if !(args.duration > 0.0 && args.time_step > 0.0 && steps <= STEPS_MAX) {
        let (duration, step) = (args.duration, args.time_step);
        return Err(Failure::Input(miette::miette!(
            "--duration {duration} --time-step {step}: expected times in s above zero that make at most {STEPS_MAX} steps"
        )));
    }
    let branch = args.branch.into();
    let range = linkage_turn::range(&linkage.mechanism.crank_range());
    let start = Start {
        branch,
        moment,
        angle: args.angle.unwrap_or_else(|| range.middle(&linkage.mechanism, branch)),
        speed: args.speed.unwrap_or(0.0),
        steps: steps as u32,
        time_step: args.time_step,
    };
    let run = linkage_run::run(linkage, &start).map_err(|error| no_start(args, &start, &range, error))?;
    let summary = run.summary(linkage, &start);
    let json = json(&summary)?;
    let header = ["t", "crank_angle", "crank_speed", "kinetic_energy", "potential_energy", "work"].map(str::to_owned);
    let log = run.moments.iter().map(|m| vec![m.time, m.angle, m.speed, m.kinetic, m.potential, m.work]);
    let files = write(folder, "free.csv", &header, log, &json, &run_charts(&run, &summary))?;
    show(args.json, &json, || run_table(&summary), &files)?;
    Ok(if run.stopped.is_some() { failure::FAULT } else { 0 })
}

/// What keeps the linkage from starting, and where it could.
fn no_start(args: &LinkageArgs, start: &Start, range: &Range, error: LinkageError<f64>) -> Failure {
    let (file, angle, branch) = (args.linkage.display(), start.angle, branch_name(start.branch));
    let help = describe_range(range);
    Failure::Input(miette::miette!(
        help = help,
        "{file}: the linkage cannot start at a crank angle of {angle} rad on the {branch} branch: {error}"
    ))
}

fn describe_range(range: &Range) -> String {
    if range.full_turn {
        return "the crank turns fully".to_owned();
    }
    let ends: Vec<String> = range.ends.iter().map(|end| format!("{end:.4} rad")).collect();
    format!("the crank does not turn fully: dead points at {}", ends.join(", "))
}

fn json(summary: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(summary).map_err(|error| Failure::Output(error.into()))
}

/// Log, summary and plots; returns the files.
fn write(
    folder: &Path,
    log: &str,
    header: &[String],
    rows: impl Iterator<Item = Vec<f64>>,
    json: &str,
    charts: &[(&str, Chart)],
) -> Result<Vec<PathBuf>, Failure> {
    fs::create_dir_all(folder).map_err(|error| in_file(folder, &error))?;
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

fn show(as_json: bool, json: &str, table: impl Fn() -> String, files: &[PathBuf]) -> Result<(), Failure> {
    let mut text = if as_json { json.to_owned() } else { table() };
    if !as_json {
        for (index, file) in files.iter().enumerate() {
            text += &format!("\n{:<20}{}", if index == 0 { "files" } else { "" }, file.display());
        }
    }
    failure::print(&format!("{text}\n"))
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
    let chart =
        |title: &str, panels| Chart { title: format!("{title}: {}", summary.linkage), abscissa: ABSCISSA, panels };
    let line = |name, value: fn(&Step) -> f64| Line { name, pieces: turn.pieces(value) };
    let moment = Panel {
        caption: format!("at {} rad/s", summary.speed),
        quantity: "moment",
        unit: "N m",
        lines: vec![line("M_0", |step| step.forces.driving_moment)],
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
    };
    let about = Panel {
        caption: "about the crank's ground pivot".to_owned(),
        quantity: "moment",
        unit: "N m",
        lines: vec![line("moment", |step| step.forces.shaking_moment())],
    };
    vec![
        ("driving_moment.svg", chart("Driving moment", vec![moment])),
        ("shaking_force.svg", chart("Shaking force", vec![force])),
        ("shaking_moment.svg", chart("Shaking moment", vec![about])),
    ]
}

fn run_charts(run: &Run, summary: &RunSummary) -> Vec<(&'static str, Chart)> {
    let line = |name, value: fn(&linkage_run::Moment) -> f64| Line {
        name,
        pieces: vec![run.moments.iter().map(|now| (now.time, value(now))).collect()],
    };
    let chart =
        |title: &str, panels| Chart { title: format!("{title}: {}", summary.linkage), abscissa: "time / s", panels };
    let panel = |caption: &str, quantity, unit, lines| Panel { caption: caption.to_owned(), quantity, unit, lines };
    let angle = panel("crank", "angle", "rad", vec![line("crank", |now| now.angle)]);
    let speed = panel("crank", "speed", "rad/s", vec![line("crank", |now| now.speed)]);
    let energy =
        vec![line("kinetic", |now| now.kinetic), line("potential", |now| now.potential), line("work", |now| now.work)];
    vec![
        ("motion.svg", chart("Crank", vec![angle, speed])),
        ("energy.svg", chart("Energy", vec![panel("energy and the moment's work", "energy", "J", energy)])),
    ]
}

fn lines(rows: &[(&str, String)]) -> String {
    rows.iter().map(|(name, text)| format!("\n{name:<20}{text}")).collect()
}

fn turn_table(summary: &TurnSummary) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(["", "min", "max", "mean", "rms"]);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut add = |name: &str, unit: &str, spread: &Spread| {
        let Spread { min, max, mean, rms } = *spread;
        let mut row = vec![name.to_owned()];
        // A mean of rounding errors is shown as what it is.
        let mean = if mean.abs() < 1e-12 * rms { 0.0 } else { mean };
        row.extend([min, max, mean, rms].map(|value| engineering(value, unit)));
        table.add_row(row);
    };
    add("driving moment M_0", "N m", &summary.driving_moment);
    for (joint, force) in summary.joint_forces.iter().enumerate() {
        add(&format!("joint force F_{joint}"), "N", force);
    }
    if let Some(guide) = &summary.guide_moment {
        add("guide moment M_3", "N m", guide);
    }
    add("shaking force F_3 - F_0", "N", &summary.shaking_force);
    add("shaking moment", "N m", &summary.shaking_moment);
    add(if summary.slider_position.is_some() { "rod angle" } else { "coupler angle" }, "rad", &summary.coupler_angle);
    if let Some(angle) = &summary.follower_angle {
        add("follower angle", "rad", angle);
    }
    if let Some(position) = &summary.slider_position {
        add("slider position", "m", position);
    }
    let TurnSummary { linkage, kind, branch, speed, steps, .. } = summary;
    let mut rows = Vec::new();
    if let Some(class) = &summary.class {
        rows.push(("class", class.clone()));
    }
    rows.push(("crank", describe_range(&summary.crank_range)));
    let moved = steps - summary.steps_open - summary.steps_dead;
    if moved < *steps {
        rows.push(("", format!("driven at {moved} steps; the forces grow without bound towards the dead points")));
    }
    if summary.crank_range.full_turn {
        let met = match summary.steps_dead {
            0 => "none".to_owned(),
            steps => format!("at {steps} of the steps"),
        };
        rows.push(("dead points", met));
    }
    let standing = if summary.slider_position.is_some() { "slider" } else { "follower" };
    for centre in &summary.dead_centres {
        let how = if centre.stretched { "stretched out" } else { "folded" };
        rows.push((
            "dead centre",
            format!(
                "{:.4} rad: crank and {} in line, {how}; the {standing} stands still",
                centre.angle,
                coupler_word(summary)
            ),
        ));
    }
    rows.push(("transmission angle", format!("at least {}", engineering(summary.transmission_angle_min, "rad"))));
    format!("{linkage}: {kind}, {branch} branch, {speed} rad/s, {steps} steps a turn\n{table}{}", lines(&rows))
}

fn coupler_word(summary: &TurnSummary) -> &'static str {
    if summary.slider_position.is_some() { "rod" } else { "coupler" }
}

fn run_table(summary: &RunSummary) -> String {
    let RunSummary { linkage, kind, branch, moment, .. } = summary;
    let span = |from: f64, to: f64, unit: &str| format!("{} to {}", engineering(from, unit), engineering(to, unit));
    let mut rows = vec![
        ("time", format!("{} in steps of {}", engineering(summary.duration, "s"), engineering(summary.time_step, "s"))),
        ("crank angle", span(summary.angle_start, summary.angle_end, "rad")),
        (
            "crank speed",
            format!(
                "{}; between {} and {}",
                span(summary.speed_start, summary.speed_end, "rad/s"),
                engineering(summary.speed_min, "rad/s"),
                engineering(summary.speed_max, "rad/s")
            ),
        ),
        ("work", engineering(summary.work, "J")),
        ("gain of energy", engineering(summary.energy_gain, "J")),
        (
            "balance",
            format!(
                "off by {} at most, {:.1e} of the greatest energy",
                engineering(summary.balance_error, "J"),
                summary.balance_error_relative
            ),
        ),
    ];
    if let Some(why) = &summary.stopped {
        rows.push(("stopped", format!("{why} after {}", engineering(summary.duration, "s"))));
    }
    format!("{linkage}: {kind}, {branch} branch, {moment} N m on the crank{}", lines(&rows))
}
