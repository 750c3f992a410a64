//! A turn or a motion as a table.

use super::run::RunSummary;
use super::turn::{Range, Spread, TurnSummary};
use sim::run::numbers::engineering;
use sim::table::table;

/// Description of the crank's range.
pub fn describe_range(range: &Range) -> String {
    if range.full_turn {
        return "the crank turns fully".to_owned();
    }
    let ends: Vec<String> = range.ends.iter().map(|end| format!("{end:.4} rad")).collect();
    format!("the crank does not turn fully: dead points at {}", ends.join(", "))
}

fn lines(rows: &[(&str, String)]) -> String {
    rows.iter().map(|(name, text)| format!("\n{name:<20}{text}")).collect()
}

/// A turn as a table for the terminal.
pub fn turn_table(summary: &TurnSummary) -> String {
    let mut table = table(["", "min", "max", "mean", "rms"], 1);
    let mut add = |name: &str, unit: &str, spread: &Spread| {
        let Spread { min, max, mean, rms } = *spread;
        let mut row = vec![name.to_owned()];
        // Show a mean that is only rounding error as zero.
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
    let slides = summary.slider_position.is_some();
    let (standing, coupler) = if slides { ("slider", "rod") } else { ("follower", "coupler") };
    for centre in &summary.dead_centres {
        let how = if centre.stretched { "stretched out" } else { "folded" };
        let text = format!("{:.4} rad: crank and {coupler} in line, {how}; the {standing} stands still", centre.angle);
        rows.push(("dead centre", text));
    }
    rows.push(("transmission angle", format!("at least {}", engineering(summary.transmission_angle_min, "rad"))));
    format!("{linkage}: {kind}, {branch} branch, {speed} rad/s, {steps} steps a turn\n{table}{}", lines(&rows))
}

/// A motion as a table for the terminal.
pub fn run_table(summary: &RunSummary) -> String {
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
