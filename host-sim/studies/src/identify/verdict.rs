//! Text of a verdict: reasons, and the options that correct a log.

use super::subject::Subject;
use identification::hypotheses::{Explanation, Fault};
use identification::verdict::{Grade, Reason, Verdict};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Factors that correct a torque, and the unit or convention that each may come from.
const UNITS: [(f64, &str); 11] = [
    (1e-3, "mN m or mA"),
    (1e-2, "N cm"),
    (0.098_066_5, "kgf cm"),
    (0.112_985, "lbf in"),
    (0.007_061_55, "ozf in"),
    (1.355_818, "lbf ft"),
    (9.806_65, "kgf m"),
    (0.1, "dN m, or a factor of 10"),
    (100.0, "torque before a gear of 100"),
    (50.0, "torque before a gear of 50"),
    (1e3, "kN m"),
];
/// Largest ratio between a factor and a unit that it may mean.
const NEAR: f64 = 1.35;

/// The verdict as text: a line for the grade and one for each reason.
#[must_use]
pub fn text(verdict: &Verdict, subject: &Subject) -> String {
    let mut lines = vec![format!("verdict             {}", verdict.grade.name())];
    for reason in &verdict.reasons {
        lines.extend(words(reason, subject).into_iter().map(|line| format!("                    {line}")));
    }
    lines.join("\n") + "\n"
}

/// The verdict as JSON: `{grade, reasons: [{kind, grade, text, options}]}`.
#[must_use]
pub fn json(verdict: &Verdict, subject: &Subject) -> Value {
    let reason = |reason: &Reason| {
        let options: Vec<Value> = match reason {
            Reason::Explained(all) | Reason::ExplainedThere(all) => all.iter().map(|one| json!(options(one))).collect(),
            _ => Vec::new(),
        };
        json!({
            "kind": kind(reason),
            "grade": reason.grade().name(),
            "text": words(reason, subject).join("; "),
            "options": options,
        })
    };
    json!({
        "grade": verdict.grade.name(),
        "reasons": verdict.reasons.iter().map(reason).collect::<Vec<_>>(),
    })
}

/// Message at the end of a run that writes no robot file.
#[must_use]
pub fn refusal(verdict: &Verdict, subject: &Subject) -> String {
    let first = verdict.reasons.first().map(|reason| words(reason, subject).join("; ")).unwrap_or_default();
    match verdict.grade {
        Grade::Doubtful => format!("doubtful: {first}. No robot file is written; --accept-doubtful writes it"),
        _ => format!("refused: {first}. No robot file is written"),
    }
}

const fn kind(reason: &Reason) -> &'static str {
    match reason {
        Reason::Explained(_) => "explained",
        Reason::ExplainedThere(_) => "explained_in_validation",
        Reason::LittleMotion(_) => "little_motion",
        Reason::Unexcited(..) => "unexcited",
        Reason::NoBetter(..) => "no_better",
        Reason::Worse(..) => "worse",
        Reason::Missed(..) => "missed",
        Reason::OtherThere(..) => "other_in_validation",
        Reason::Heavier(_) => "heavier",
        Reason::Mass(..) => "mass",
        Reason::Drives(..) => "friction_drives",
        Reason::Impossible(_) => "impossible_bodies",
        Reason::FollowsFile(_) => "follows_file",
    }
}

fn joint(subject: &Subject, joint: usize) -> String {
    format!("joint {} ({})", joint + 1, subject.robot.joints[joint].name)
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn words(reason: &Reason, subject: &Subject) -> Vec<String> {
    let one = match reason {
        Reason::Explained(all) | Reason::ExplainedThere(all) => {
            let there = matches!(reason, Reason::ExplainedThere(_));
            let first = if there { "in the logs for validation: " } else { "" };
            return all
                .iter()
                .enumerate()
                .map(|(k, one)| format!("{}{}", if k == 0 { first } else { "or: " }, explanation(one, subject)))
                .collect();
        }
        Reason::LittleMotion(condition) => format!(
            "the motion does not separate the parameters: condition number {condition:.0}, expected below 200; record a motion of \
             `newtau identify excite`"
        ),
        Reason::Unexcited(at, open) => format!(
            "the log leaves {} of the uncertainty about {} in other motions; move it further or faster",
            percent(*open),
            joint(subject, *at)
        ),
        Reason::NoBetter(before, after) => format!(
            "torques are missed by {} on average, by the robot file as it was {}: nothing is gained",
            percent(*after),
            percent(*before)
        ),
        Reason::Worse(at, before, after) => format!(
            "{}: {} of its torque is missed, by the robot file as it was {}",
            joint(subject, *at),
            percent(*after),
            percent(*before)
        ),
        Reason::Missed(at, after) => format!(
            "{}: {} of its torque is missed, and it is no noise; a spring, a cable, contact, backlash or a wrong geometry?",
            joint(subject, *at),
            percent(*after)
        ),
        Reason::OtherThere(at, after, held_out) => format!(
            "{}: {} of its torque is missed in the logs for validation, {} in blocks held out of the others; was the arm the same?",
            joint(subject, *at),
            percent(*after),
            percent(*held_out)
        ),
        Reason::Heavier(times) => format!(
            "all masses together would be {times:.2} times the maker's: torque constant, unit or gear? Or are the maker's masses wrong?"
        ),
        Reason::Mass(at, times) => {
            format!("the mass of {} would be {times:.2} times the maker's", joint(subject, *at))
        }
        Reason::Drives(at, deviations) => format!(
            "friction drives {} instead of braking it ({deviations:.1} standard deviations): sign of its torque or position?",
            joint(subject, *at)
        ),
        Reason::Impossible(deviations) => format!(
            "least squares wants bodies that cannot exist: the nearest possible ones are {deviations:.1} standard deviations away"
        ),
        Reason::FollowsFile(most) => format!(
            "the torques follow the robot file's own model to {:.2} %: are they commanded by it rather than measured?",
            100.0 * most
        ),
    };
    vec![one]
}

/// Faults, the options that correct them, and the remaining error.
fn explanation(found: &Explanation, subject: &Subject) -> String {
    let faults: Vec<String> = found.faults.iter().map(|one| fault(one, subject)).collect();
    let worst = found.score.left.iter().fold(0.0_f64, |a, b| a.max(*b));
    format!(
        "{} [{}]; with this, {} of torque is missed at most",
        faults.join(", and "),
        options(found).join(" "),
        percent(worst)
    )
}

fn fault(found: &Fault, subject: &Subject) -> String {
    let named = |order: &[usize]| -> String {
        let names = |k: &usize| format!("{} ({})", k + 1, subject.robot.joints[*k].name);
        order.iter().map(names).collect::<Vec<_>>().join(", ")
    };
    let exchanged = |order: &[usize], what: &str| {
        let moved: Vec<usize> = (0..order.len()).filter(|k| order[*k] != *k).collect();
        match moved[..] {
            _ if order.len() > 2 && order.iter().rev().copied().eq(0..order.len()) => {
                let ends = if order.len() == 3 { ": joints 1 and 3 are exchanged" } else { "" };
                format!("{what} are in the reversed order{ends}")
            }
            [a, b] => format!("{what} of {} and {} are exchanged", joint(subject, a), joint(subject, b)),
            _ => format!("{what} of joints 1 to {} are in columns {}", order.len(), named(order)),
        }
    };
    match found {
        Fault::TorqueSign(at) => format!("torque of {} has the opposite sign", joint(subject, *at)),
        Fault::TorqueSigns => "all torques have the opposite sign".to_owned(),
        Fault::PositionSign(at) => format!("position of {} has the opposite sign", joint(subject, *at)),
        Fault::PositionSigns => "all positions have the opposite sign".to_owned(),
        Fault::TorqueScale(at, by) => format!(
            "torque of {} is {} times what the other joints expect: {}",
            joint(subject, *at),
            number(by.recip()),
            unit(*by)
        ),
        Fault::TorqueScales(by) => {
            format!("every mass would be {} times the maker's: {}", number(by.recip()), unit(*by))
        }
        Fault::PositionScales(by) => format!("all positions: {}", angle(*by)),
        Fault::TorqueOrder(order) => exchanged(order, "torques"),
        Fault::PositionOrder(order) => exchanged(order, "positions"),
        Fault::Order(order) => exchanged(order, "positions and torques"),
        Fault::Gravity(direction) => {
            let along = direction.normalize();
            let mounted = match (along - Vector3::z()).norm() < 0.1 {
                true => "the arm hangs upside down",
                false if along.z.abs() < 0.1 => "the arm is mounted on a wall",
                false => "the arm is mounted at an angle",
            };
            format!("gravity acts along {:.2}, {:.2}, {:.2} of the base: {mounted}", along.x, along.y, along.z)
        }
        Fault::NoGravity => {
            "the torques hold no weight: the robot has removed gravity before it recorded them".to_owned()
        }
    }
}

/// The units from which a torque factor may come.
fn unit(by: f64) -> String {
    let near = UNITS.iter().filter(|(factor, _)| (by / factor).max(factor / by) < NEAR);
    let near: Vec<String> = near.map(|(factor, name)| format!("{name}: {}", number(*factor))).collect();
    match near.is_empty() {
        true => "unit? gear? torque constant?".to_owned(),
        false => format!("unit? gear? torque constant? ({})", near.join("; ")),
    }
}

fn angle(by: f64) -> String {
    let near = |other: f64| (by / other - 1.0).abs() < 0.01;
    if near(1f64.to_radians()) {
        "degrees recorded as radians".to_owned()
    } else if near(std::f64::consts::TAU) {
        "turns recorded as radians".to_owned()
    } else {
        format!("{} times what the arm turns", number(by.recip()))
    }
}

/// Formats with three digits.
fn number(x: f64) -> String {
    let digits = (2.0 - x.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The options of `identify` that apply this correction.
fn options(found: &Explanation) -> Vec<String> {
    let (correction, n) = (&found.correction, found.correction.torque.len());
    let own: Vec<usize> = (0..n).collect();
    let list = |values: &[String]| values.join(",");
    let order = |from: &[usize]| list(&from.iter().map(|k| (k + 1).to_string()).collect::<Vec<_>>());
    let mut all = Vec::new();
    let (positions, torques) = (&correction.positions_from, &correction.torques_from);
    if positions == torques && *positions != own {
        all.push(format!("--permute {}", order(positions)));
    } else {
        if *positions != own {
            all.push(format!("--permute-position {}", order(positions)));
        }
        if *torques != own {
            all.push(format!("--permute-torque {}", order(torques)));
        }
    }
    for (what, factors) in [("torque", &correction.torque), ("position", &correction.position)] {
        let negative: Vec<String> = (0..n).filter(|k| factors[*k] < 0.0).map(|k| (k + 1).to_string()).collect();
        match negative.len() {
            0 => {}
            all_of if all_of == n && n > 1 => all.push(format!("--negate-{what} all")),
            _ => all.push(format!("--negate-{what} {}", list(&negative))),
        }
        let sizes: Vec<String> = factors.iter().map(|x| number(x.abs())).collect();
        if factors.iter().any(|x| (x.abs() - 1.0).abs() > 1e-9) {
            let same = sizes.iter().all(|size| *size == sizes[0]);
            if same && what == "position" && (factors[0].abs() - 1f64.to_radians()).abs() < 1e-6 {
                all.push("--degrees".to_owned());
            } else {
                let value = if same { sizes[0].clone() } else { list(&sizes) };
                all.push(format!("--{what}-scale {value}"));
            }
        }
    }
    let moved = |fault: &Fault| matches!(fault, Fault::Gravity(_) | Fault::NoGravity);
    if found.faults.iter().any(moved) {
        let short = |x: f64| format!("{:.3}", if x.abs() < 1e-9 { 0.0 } else { x });
        let bare = |text: String| text.trim_end_matches('0').trim_end_matches('.').to_owned();
        all.push(format!("--gravity {}", <[f64; 3]>::from(found.gravity).map(|x| bare(short(x))).join(",")));
    }
    all
}
