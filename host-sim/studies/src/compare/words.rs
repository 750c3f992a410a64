//! Comparison of two runs in sentences: main result, settings, events.

use super::Side;
use super::tables::change;
use report::Block;
use serde_json::Value;
use sim::run::numbers::engineering;

/// Settings in `summary.json`, and the unit of each.
const SETTINGS: [(&str, &str); 8] = [
    ("scene", ""),
    ("robot", ""),
    ("target", ""),
    ("scalar", ""),
    ("law", ""),
    ("trig", ""),
    ("period", "s"),
    ("duration", "s"),
];

/// Largest number of events that are listed one by one.
const LISTED: usize = 100;

/// The sentences with the most important results.
pub(super) fn lead(a: &Side, b: &Side) -> Vec<String> {
    let mut lines = vec![format!("A: {}. B: {}.", a.title(), b.title())];
    let [ends_a, ends_b] = [("A", a), ("B", b)].map(|(letter, side)| ends(letter, side));
    if ends_a.is_empty() && ends_b.is_empty() {
        lines.push("Neither faulted.".to_owned());
    }
    lines.extend(ends_a.into_iter().chain(ends_b));
    let durations = [a, b].map(|side| side.summary["duration"].as_f64().unwrap_or_default());
    if (durations[0] - durations[1]).abs() > 1e-9 {
        let [of_a, of_b] = durations.map(|duration| engineering(duration, "s"));
        lines.push(format!("A lasts {of_a}, B {of_b}: after its end a run has no values, and its arm is faint."));
    }
    lines.extend(greatest(a, b));
    lines
}

/// Faults of a run, and its early end.
fn ends(letter: &str, side: &Side) -> Vec<String> {
    let fault = |fault: &Value| {
        let (message, at) = (fault["message"].as_str()?, engineering(side.time(&fault["tick"]), "s"));
        Some(format!("{letter} faulted at {at}: {message}. Its numbers are those before."))
    };
    let mut lines: Vec<String> = faults(side).iter().filter_map(fault).collect();
    lines.extend(side.summary["stopped"].as_str().map(|why| format!("{letter} ended early: {why}.")));
    lines
}

fn faults(side: &Side) -> &[Value] {
    side.summary["faults"].as_array().map_or(&[], Vec::as_slice)
}

/// The joint with the greatest error in A, and its errors in both runs.
fn greatest(a: &Side, b: &Side) -> Option<String> {
    let of = |side: &Side, joint: usize| side.number("/tracking_max", joint);
    let all = (0..a.joints().len()).filter_map(|joint| Some((joint, of(a, joint)?)));
    let (joint, before) = all.max_by(|x, y| x.1.total_cmp(&y.1))?;
    let after = of(b, joint)?;
    let unit = a.joints()[joint]["position_unit"].as_str().unwrap_or_default();
    Some(format!(
        "Joint {} ({}) has the greatest error in A: {} at most; in B {}, {}.",
        joint + 1,
        a.name(joint),
        engineering(before, unit),
        engineering(after, unit),
        change(before, after)
    ))
}

/// Settings of both, their closest limits, and faults.
pub(super) fn settings(a: &Side, b: &Side) -> Vec<(String, String)> {
    let fact = |name: &str, said: [String; 2]| {
        let [of_a, of_b] = said;
        (name.to_owned(), if of_a == of_b { of_a } else { format!("A {of_a}, B {of_b}") })
    };
    let text = |value: &Value, unit: &str| match (value.as_f64(), value.as_str()) {
        (Some(x), _) => engineering(x, unit),
        (_, Some(text)) => text.to_owned(),
        _ => value.to_string(),
    };
    let mut facts: Vec<(String, String)> =
        SETTINGS.iter().map(|(key, unit)| fact(key, [a, b].map(|side| text(&side.summary[*key], unit)))).collect();
    facts.push(fact("closest limit", [a, b].map(closest)));
    let messages = |side: &Side| {
        let all: Vec<&str> = faults(side).iter().filter_map(|fault| fault["message"].as_str()).collect();
        if all.is_empty() { "none".to_owned() } else { all.join(", ") }
    };
    facts.push(fact("faults", [a, b].map(messages)));
    facts
}

/// The limit that a run came closest to.
fn closest(side: &Side) -> String {
    let found = &side.summary["closest_limit"];
    let said = || {
        let (used, limit) = (found["used"].as_f64()?, found["limit"].as_str()?);
        let joint = side.name((found["joint"].as_u64()? as usize).checked_sub(1)?);
        let at = engineering(side.time(&found["tick"]), "s");
        Some(format!("{:.0} % of the {limit} limit of {joint} at {at}", 100.0 * used))
    };
    said().unwrap_or_else(|| "none".to_owned())
}

/// Events of both runs in order of time, each with the letter of its run.
pub(super) fn events(a: &Side, b: &Side) -> Vec<Block> {
    let of = |letter: &'static str, side: &Side| -> Vec<(f64, String, String)> {
        let all = side.run["events"].as_array().map_or(&[][..], Vec::as_slice);
        let event = |event: &Value| {
            let (at, text) = (event["at"].as_f64()?, event["text"].as_str()?);
            let joint = event["joint"].as_u64().map_or(String::new(), |joint| format!("&joint={}", joint + 1));
            let until = event["to"].as_f64().map_or(String::new(), |to| format!(" to {}", engineering(to, "s")));
            Some((at, format!("#t={at}{joint}"), format!("{letter}, {}{until}: {text}", engineering(at, "s"))))
        };
        all.iter().filter_map(event).collect()
    };
    let mut all = of("A", a);
    all.extend(of("B", b));
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    if all.is_empty() {
        return vec![Block::Words("Nothing.".to_owned())];
    }
    let more = all.len().saturating_sub(LISTED);
    let listed = all.into_iter().take(LISTED).map(|(_, to, text)| (to, text)).collect();
    let mut blocks = vec![Block::Moments(listed)];
    blocks.extend((more > 0).then(|| Block::Words(format!("And {more} more."))));
    blocks
}
