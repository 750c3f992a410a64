//! The page that a person reads: one file, its pictures in it.

use super::outcome::{Judged, Outcome};
use super::subject::{Subject, law};
use crate::failure::{Failure, in_file};
use crate::run::plot::{Chart, Line, Panel, Pen, write_chart};
use dynamics_core::JointKind;
use identification::friction::Direction;
use std::fmt::Write as _;
use std::path::Path;

/// Points of a friction curve to either side of rest.
const POINTS: usize = 120;

/// Write `index.html` with everything in it, and the pictures beside it.
///
/// # Errors
/// [`Failure::Output`]: a file cannot be written.
pub fn write(outcome: &Outcome, subject: &Subject, payload: Option<&str>, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| in_file(folder, &error))?;
    let mut pictures = String::new();
    for (index, judged) in outcome.judged.iter().enumerate() {
        let title = format!("Torque, measured and predicted: {}", judged.file);
        picture(&mut pictures, &torque(judged, subject, title), folder, &format!("torque{}.svg", index + 1))?;
    }
    picture(&mut pictures, &friction(outcome, subject), folder, "friction.svg")?;
    let held = payload.map_or_else(String::new, |text| format!("<h2>Payload</h2><pre>{}</pre>", escaped(text)));
    let page = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{name}: identified</title>\n<style>\
         body{{font:15px/1.45 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}}\
         table{{border-collapse:collapse;margin:1em 0}}td,th{{border:1px solid #bbb;padding:.2em .6em;text-align:right}}\
         td:first-child,th:first-child{{text-align:left}}svg{{width:100%;height:auto}}</style>\n\
         <h1>{name}: identified from logs</h1>\n{summary}{errors}{links}{base}{tried}{held}<h2>Pictures</h2>\n{pictures}</html>\n",
        name = escaped(&subject.robot.name),
        summary = summary(outcome),
        errors = errors(outcome, subject),
        links = links(outcome, subject),
        base = base(outcome, subject),
        tried = tried(outcome, subject),
    );
    let path = folder.join("index.html");
    std::fs::write(&path, page).map_err(|error| in_file(&path, &error))
}

fn picture(page: &mut String, chart: &Chart, folder: &Path, name: &str) -> Result<(), Failure> {
    let path = folder.join(name);
    write_chart(chart, &path).map_err(|error| in_file(&path, &error))?;
    let text = std::fs::read_to_string(&path).map_err(|error| in_file(&path, &error))?;
    let start = text.find("<svg").unwrap_or(0);
    page.push_str(&text[start..]);
    page.push('\n');
    Ok(())
}

fn unit(subject: &Subject, joint: usize) -> &'static str {
    if subject.robot.joints[joint].spec.kind == JointKind::Prismatic { "N" } else { "N m" }
}

fn panel(subject: &Subject, joint: usize, quantity: &'static str, lines: Vec<Line>) -> Panel {
    Panel {
        caption: subject.robot.joints[joint].name.clone(),
        quantity,
        unit: unit(subject, joint),
        lines,
        marks: Vec::new(),
        bound: None,
        limited: Vec::new(),
    }
}

fn torque(judged: &Judged, subject: &Subject, title: String) -> Chart {
    let prediction = &judged.prediction;
    let line = |name, pen, series: &[f64]| Line {
        name,
        pen,
        pieces: vec![prediction.time.iter().copied().zip(series.iter().copied()).collect()],
    };
    let of = |joint: usize| {
        let lines = vec![
            line("measured", Some(Pen::BROAD), &prediction.measured[joint]),
            line("predicted", Some(Pen::BLUE), &prediction.model[joint]),
        ];
        panel(subject, joint, "torque", lines)
    };
    Chart { title, abscissa: "time / s", range: None, panels: (0..prediction.measured.len()).map(of).collect() }
}

/// Friction over speed, each way in steady motion without load, up to the greatest speed of the judged logs.
fn friction(outcome: &Outcome, subject: &Subject) -> Chart {
    let found = &outcome.found;
    let fastest = |joint: usize| {
        let speeds = outcome.judged.iter().flat_map(|judged| &judged.prediction.qd[joint]);
        speeds.fold(1e-3_f64, |most, qd| most.max(qd.abs()))
    };
    let of = |joint: usize| {
        let (most, law_of) = (fastest(joint), &found.laws[joint]);
        let curve = |tau: &dyn Fn(f64) -> f64| -> Vec<Vec<(f64, f64)>> {
            let speed = |k: usize| most * k as f64 / POINTS as f64;
            let half = |sign: f64| (1..=POINTS).map(|k| sign * speed(k)).map(|qd| (qd, tau(qd))).collect::<Vec<_>>();
            let mut back = half(-1.0);
            back.reverse();
            vec![back, half(1.0)]
        };
        let identified = |qd: f64| -> f64 {
            let s = match law_of.direction {
                Direction::Hysteresis(_) => qd.signum(),
                Direction::Smooth(speed) => (qd / speed).tanh(),
            };
            law_of.terms.iter().zip(&found.friction[joint]).skip(1).map(|(term, c)| c * term.value(s, qd, 0.0)).sum()
        };
        let rub = outcome.numbers.friction[joint];
        let lines = vec![
            Line { name: "identified", pen: Some(Pen::BROAD), pieces: curve(&identified) },
            Line {
                name: "robot file",
                pen: Some(Pen::BLUE),
                pieces: curve(&|qd| law(rub.viscous, rub.coulomb).torque(qd)),
            },
        ];
        panel(subject, joint, "friction", lines)
    };
    Chart {
        title: "Friction over speed, without load".to_owned(),
        abscissa: "speed / (rad/s)",
        range: None,
        panels: (0..found.base.joints).map(of).collect(),
    }
}

fn summary(outcome: &Outcome) -> String {
    let found = &outcome.found;
    let judged: Vec<String> = outcome.judged.iter().map(|judged| escaped(&judged.file)).collect();
    let how = if outcome.held_out { "logs that were held out" } else { "the logs that it was identified from" };
    format!(
        "<p>Judged on {how}: {}. Torques, measured and predicted, are compared behind the same low-pass of {:.1} Hz without delay; motions \
         behind one of {:.1} Hz, chosen by the error in blocks held out. {} base parameters of {}; the singular values on both sides of the \
         gap are {:.1e} and {:.1e} of the largest. Condition number {:.0}.</p>\n",
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

/// A table: the head, then rows of cells.
fn table(title: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!("<h2>{title}</h2>\n<table><tr>");
    for cell in head {
        let _ = write!(text, "<th>{}</th>", escaped(cell));
    }
    for row in rows {
        text += "</tr>\n<tr>";
        for cell in row {
            let _ = write!(text, "<td>{}</td>", escaped(cell));
        }
    }
    text + "</tr></table>\n"
}

fn errors(outcome: &Outcome, subject: &Subject) -> String {
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

fn links(outcome: &Outcome, subject: &Subject) -> String {
    let rows: Vec<Vec<String>> = outcome
        .numbers
        .links
        .iter()
        .enumerate()
        .map(|(joint, link)| {
            let three = |v: &nalgebra::Vector3<f64>| format!("{:.4}, {:.4}, {:.4}", v.x, v.y, v.z);
            let (rotor, rub) = (outcome.numbers.rotors[joint], outcome.numbers.friction[joint]);
            let i = &link.inertia;
            let seen = |index: usize| if link.seen[index] { "" } else { " (not seen)" };
            vec![
                subject.robot.joints[joint].name.clone(),
                format!("{:.4} ± {:.1e}{}", link.mass.0, link.mass.1, seen(0)),
                format!("{}{}", three(&link.com.0), seen(1)),
                format!("{:.2e}, {:.2e}, {:.2e}{}", i.m11, i.m22, i.m33, seen(2)),
                format!("{:.4} ± {:.1e}", rotor.0, rotor.1),
                format!("{:.4}, {:.4}", rub.viscous, rub.coulomb),
            ]
        })
        .collect();
    let head = ["link", "mass, kg", "mass centre, m", "xx, yy, zz, kg m^2", "rotor, kg m^2", "viscous, Coulomb"];
    table("The robot file", &head, &rows)
}

fn base(outcome: &Outcome, subject: &Subject) -> String {
    let found = &outcome.found;
    let before = found.base.of_parameters(&subject.parameters);
    let rows: Vec<Vec<String>> = (0..found.base.len())
        .map(|k| {
            let numbers = [before[k], found.free[k], found.bodies.beta[k], found.covariance[(k, k)].max(0.0).sqrt()];
            std::iter::once(found.base.name(k)).chain(numbers.iter().map(|x| format!("{x:.4e}"))).collect()
        })
        .collect();
    let head = ["base parameter", "before", "least squares", "possible bodies", "deviation"];
    let mut text = table("Base parameters, kg, kg m, kg m^2", &head, &rows);
    let rows: Vec<Vec<String>> = (0..found.base.joints)
        .flat_map(|joint| {
            let name = subject.robot.joints[joint].name.clone();
            outcome.terms(joint).map(move |(term, value, deviation)| {
                vec![format!("{name}: {term}"), format!("{value:.4}"), format!("{deviation:.1e}")]
            })
        })
        .collect();
    text += &table("Friction", &["joint and term", "coefficient", "deviation"], &rows);
    text
}

fn tried(outcome: &Outcome, subject: &Subject) -> String {
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

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
