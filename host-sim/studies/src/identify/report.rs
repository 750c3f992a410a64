//! The HTML report of an identification.

use super::outcome::{JudgedLog, Outcome};
use super::subject::{Subject, torque as friction_torque};
use identification::friction::Direction;
use report::{Block, Cell, Figure, Page, Series, Table};
use sim::failure::{Failure, in_file};
use sim::run::joint_label::JointLabel;
use std::path::Path;

/// Points of a friction curve on each side of rest.
const POINTS: usize = 120;

/// Writes `index.html`.
///
/// # Errors
/// [`Failure::Output`]: the file cannot be written.
pub fn write(outcome: &Outcome, subject: &Subject, payload: Option<&str>, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| in_file(folder, &error))?;
    let path = folder.join("index.html");
    sim::pages::write(&path, &page(outcome, subject, payload))
}

fn page(outcome: &Outcome, subject: &Subject, payload: Option<&str>) -> Page {
    let verdict = Block::Terminal(super::verdict::text(&outcome.verdict, subject));
    let mut blocks = vec![verdict, links(outcome, subject), errors(outcome, subject), Block::Words(summary(outcome))];
    blocks.extend(base(outcome, subject));
    blocks.push(tried(outcome, subject));
    if let Some(text) = payload {
        blocks.extend([Block::Heading("Payload".to_owned()), Block::Terminal(text.to_owned())]);
    }
    for judged in &outcome.judged {
        blocks.push(Block::Heading(format!("Torque, measured and predicted: {}", judged.file)));
        blocks.extend((0..judged.prediction.measured.len()).map(|joint| torque(judged, subject, joint)));
    }
    blocks.push(Block::Heading("Friction over speed, without load".to_owned()));
    blocks.extend((0..outcome.found.base.joints).map(|joint| friction(outcome, subject, joint)));
    Page { title: format!("{}: identified from logs", subject.robot.name), lead: lead(outcome, subject), blocks }
}

/// A sentence about the joint with the largest relative error.
fn lead(outcome: &Outcome, subject: &Subject) -> Vec<String> {
    let errors = outcome.errors();
    let worst = errors.iter().enumerate().max_by(|a, b| a.1.relative.total_cmp(&b.1.relative));
    let said = worst.map(|(joint, error)| {
        format!(
            "Joint {} ({}) is missed most: {:.1} % of its torque is left, of {:.1} % before.",
            joint + 1,
            subject.robot.joints[joint].name,
            100.0 * error.relative,
            100.0 * error.before
        )
    });
    said.into_iter().collect()
}

fn unit(subject: &Subject, joint: usize) -> &'static str {
    JointLabel::from(&subject.robot.joints[joint]).torque_unit()
}

fn torque(judged: &JudgedLog, subject: &Subject, joint: usize) -> Block {
    let prediction = &judged.prediction;
    let line =
        |name: &str, values: &[f64]| Series::line(name, prediction.time.iter().copied().zip(values.iter().copied()));
    let name = subject.robot.joints[joint].name.clone();
    let figure = Figure::new(name, "time / s", format!("torque / ({})", unit(subject, joint)));
    let measured = line("measured", &prediction.measured[joint]);
    Block::Figure(figure.with(measured).with(line("predicted", &prediction.model[joint])))
}

/// Friction over speed, in steady motion in both directions without load, up to the greatest speed of the judged logs.
fn friction(outcome: &Outcome, subject: &Subject, joint: usize) -> Block {
    let law_of = &outcome.found.laws[joint];
    let speeds = outcome.judged.iter().flat_map(|judged| &judged.prediction.qd[joint]);
    let most = speeds.fold(1e-3_f64, |most, qd| most.max(qd.abs()));
    let curve = |name: &str, tau: &dyn Fn(f64) -> f64| {
        let count = POINTS as i32;
        let speed = |k: i32| most * f64::from(k) / f64::from(count);
        // At rest there is no direction, so the line has a gap there.
        let point = |k: i32| (speed(k), if k == 0 { f64::NAN } else { tau(speed(k)) });
        Series::line(name, (-count..=count).map(point).collect::<Vec<_>>())
    };
    let identified = |qd: f64| -> f64 {
        let s = match law_of.direction {
            Direction::Hysteresis(_) => qd.signum(),
            Direction::Smooth(speed) => (qd / speed).tanh(),
        };
        let terms = law_of.terms.iter().zip(&outcome.found.friction[joint]).skip(1);
        terms.map(|(term, c)| c * term.value(s, qd, 0.0)).sum()
    };
    let law = outcome.numbers.friction[joint].law;
    let name = subject.robot.joints[joint].name.clone();
    let figure = Figure::new(name, "speed / (rad/s)", format!("friction / ({})", unit(subject, joint)));
    let file = curve("robot file", &|qd| friction_torque(&law, qd, 0.0));
    Block::Figure(figure.with(curve("identified", &identified)).with(file))
}

fn summary(outcome: &Outcome) -> String {
    let found = &outcome.found;
    let judged: Vec<String> = outcome.judged.iter().map(|judged| judged.file.clone()).collect();
    let how = if outcome.held_out { "logs that were held out" } else { "the logs that it was identified from" };
    format!(
        "Judged on {how}: {}. Torques, measured and predicted, are compared behind the same low-pass of {:.1} Hz without delay; motions \
         behind one of {:.1} Hz, chosen by the error in blocks held out. {} base parameters of {}; the singular values on both sides of the \
         gap are {:.1e} and {:.1e} of the largest. Condition number {:.0}.",
        judged.join(", "),
        found.filters.torque,
        found.filters.motion,
        found.base.len(),
        found.base.regroup.ncols(),
        found.base.gap.0,
        found.base.gap.1,
        found.condition,
    )
}

/// Creates a table block from its head and rows of cells.
fn table(title: &str, head: &[&str], rows: &[Vec<String>]) -> Block {
    let mut table = Table::new(title, head);
    for row in rows {
        table.row(row.iter().map(|cell| Cell::from(cell.as_str())).collect());
    }
    Block::Table(table)
}

fn errors(outcome: &Outcome, subject: &Subject) -> Block {
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    let row = |(joint, error): (usize, &super::outcome::JointError)| {
        vec![
            subject.robot.joints[joint].name.clone(),
            percent(error.before),
            percent(error.relative),
            percent(error.file),
            format!("{:.3} {}", error.rms, unit(subject, joint)),
        ]
    };
    let rows: Vec<Vec<String>> = outcome.errors().iter().enumerate().map(row).collect();
    let head = ["joint", "before", "identified", "by the robot file", "rms left"];
    table("What torques miss, root mean square over that of the measured torque", &head, &rows)
}

fn links(outcome: &Outcome, subject: &Subject) -> Block {
    let rows: Vec<Vec<String>> = outcome
        .numbers
        .links
        .iter()
        .enumerate()
        .map(|(joint, link)| {
            let three = |v: &nalgebra::Vector3<f64>| format!("{:.4}, {:.4}, {:.4}", v.x, v.y, v.z);
            let (rotor, law) = (outcome.numbers.rotors[joint], &outcome.numbers.friction[joint]);
            let i = &link.inertia;
            let seen = |index: usize| if link.seen[index] { "" } else { " (not seen)" };
            vec![
                subject.robot.joints[joint].name.clone(),
                format!("{:.4}", subject.maker.links[joint][0]),
                format!("{:.4} ± {:.1e}{}", link.mass.0, link.mass.1, seen(0)),
                format!("{}{}", three(&link.com.0), seen(1)),
                format!("{:.2e}, {:.2e}, {:.2e}{}", i.m11, i.m22, i.m33, seen(2)),
                format!("{:.4} ± {:.1e}", rotor.0, rotor.1),
                law.entries().iter().map(|(key, x, _)| format!("{key} {x:.4}")).collect::<Vec<_>>().join(", "),
            ]
        })
        .collect();
    let head =
        ["link", "mass before, kg", "mass, kg", "mass centre, m", "xx, yy, zz, kg m^2", "rotor, kg m^2", "friction"];
    table("The robot file", &head, &rows)
}

fn base(outcome: &Outcome, subject: &Subject) -> [Block; 2] {
    let found = &outcome.found;
    let before = found.base.of_parameters(&subject.parameters);
    let rows: Vec<Vec<String>> = (0..found.base.len())
        .map(|k| {
            let numbers = [before[k], found.free[k], found.bodies.beta[k], found.covariance[(k, k)].max(0.0).sqrt()];
            std::iter::once(found.base.name(k)).chain(numbers.iter().map(|x| format!("{x:.4e}"))).collect()
        })
        .collect();
    let head = ["base parameter", "before", "least squares", "possible bodies", "deviation"];
    let parameters = table("Base parameters, kg, kg m, kg m^2", &head, &rows);
    let rows: Vec<Vec<String>> = (0..found.base.joints)
        .flat_map(|joint| {
            let name = subject.robot.joints[joint].name.clone();
            outcome.terms(joint).map(move |(term, value, deviation)| {
                vec![format!("{name}: {term}"), format!("{value:.4}"), format!("{deviation:.1e}")]
            })
        })
        .collect();
    [parameters, table("Friction", &["joint and term", "coefficient", "deviation"], &rows)]
}

fn tried(outcome: &Outcome, subject: &Subject) -> Block {
    let rows: Vec<Vec<String>> = outcome
        .found
        .tried
        .iter()
        .map(|tried| {
            let cell = |(error, kept): (&f64, &bool)| format!("{error:.4}{}", if *kept { " *" } else { "" });
            std::iter::once(tried.what.clone()).chain(tried.held_out.iter().zip(&tried.kept).map(cell)).collect()
        })
        .collect();
    let head: Vec<&str> =
        std::iter::once("tried").chain(subject.robot.joints.iter().map(|joint| joint.name.as_str())).collect();
    table("Terms of friction: rms left in blocks held out, and * where one was kept", &head, &rows)
}
