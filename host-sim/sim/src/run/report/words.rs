//! A run, described in sentences and tables.

use super::events::Event;
use crate::run::joint_label::JointLabel;
use crate::run::numbers::engineering;
use crate::run::simulate::Run;
use report::{Block, Cell, Table};

/// A number with three digits, followed by all of its digits.
fn number(value: f64, unit: &str) -> Cell {
    Cell::number(engineering(value, unit), value)
}

/// The most important results, in sentences.
pub(super) fn lead(run: &Run) -> Vec<String> {
    let (summary, joints) = (&run.summary, run.record.joints());
    let setting = &summary.setting;
    let mut lines = vec![format!(
        "{} ticks of {}, {} in all: law {}, {} on {}, sine and cosine by {}.",
        summary.ticks,
        engineering(setting.period, "s"),
        engineering(summary.duration, "s"),
        setting.law,
        setting.scalar,
        setting.target,
        setting.trig,
    )];
    let most = |values: &[f64], of: &dyn Fn(&JointLabel) -> bool| {
        let all = values.iter().enumerate().filter(|(k, _)| of(&joints[*k]));
        all.max_by(|a, b| a.1.total_cmp(b.1)).map(|(joint, value)| (joint, *value))
    };
    // Angles and lengths are not compared with each other.
    for unit in ["rad", "m"] {
        if let Some((joint, error)) = most(&summary.tracking_max, &|label| label.position_unit() == unit) {
            lines.push(format!(
                "Joint {} ({}) has the greatest error: {} at most, {} rms.",
                joint + 1,
                joints[joint].name,
                engineering(error, unit),
                engineering(summary.tracking_rms[joint], unit)
            ));
        }
    }
    if let Some(closest) = &summary.closest_limit {
        lines.push(format!(
            "Joint {} ({}) comes nearest to a limit: {:.0} % of its {} limit at {}.",
            closest.joint,
            joints[closest.joint - 1].name,
            100.0 * closest.used,
            closest.limit,
            engineering(closest.tick as f64 * setting.period, "s")
        ));
    }
    let after = setting.drives.as_ref().map_or("the brakes held", |drives| drives.after_fault);
    lines.extend(summary.faults.iter().map(|fault| {
        let at = engineering(fault.tick as f64 * setting.period, "s");
        let mut message = fault.message.clone();
        message[..1].make_ascii_uppercase();
        format!("{message} at {at}; {after} from then on.")
    }));
    lines.extend(summary.stopped.iter().map(|why| format!("The run ended early: {why}.")));
    if summary.faults.is_empty() && summary.stopped.is_none() {
        lines.push("No fault.".to_owned());
    }
    lines
}

/// Errors of every joint.
pub(super) fn quality(run: &Run) -> Table {
    let summary = &run.summary;
    let mut table = Table::new(
        "How well the joints follow",
        &["joint", "error rms", "error max", "rest error", "settling time", "limits acted in"],
    );
    for (i, joint) in run.record.joints().iter().enumerate() {
        let unit = joint.position_unit();
        let limits = summary.limits[i].describe();
        let acted = limits != "none";
        table.row(vec![
            joint.name.clone().into(),
            number(summary.tracking_rms[i], unit),
            number(summary.tracking_max[i], unit),
            summary.rest_error[i].map_or("no rest".into(), |error| number(error, unit)),
            match (summary.rest_error[i], summary.settling_time[i]) {
                (None, _) => "no rest".into(),
                (Some(_), None) => Cell::from(summary.unsettled()).warning(true),
                (Some(_), Some(time)) => number(time, "s"),
            },
            Cell::from(if acted { format!("{limits} ticks") } else { limits }).warning(acted),
        ]);
    }
    table
}

/// Torques and work of every joint.
pub(super) fn loads(run: &Run) -> Table {
    let summary = &run.summary;
    let mut head = vec!["joint", "torque rms", "torque peak", "of its limit", "chatter", "work given", "taken back"];
    if summary.external_rms.is_some() {
        head.push("from outside, rms");
    }
    let mut table = Table::new("How hard the drives work", &head);
    for (i, joint) in run.record.joints().iter().enumerate() {
        let unit = joint.torque_unit();
        let limit = run.marks.limits.get(i).map(|limits| limits.torque).filter(|limit| limit.is_finite());
        let share = limit.map(|limit| summary.torque_peak[i] / limit);
        let mut row = vec![
            joint.name.clone().into(),
            number(summary.torque_rms[i], unit),
            number(summary.torque_peak[i], unit),
            share.map_or("no limit".into(), |share| Cell::number(format!("{:.0} %", 100.0 * share), share)),
            number(summary.torque_chatter[i], unit),
            number(summary.work.given[i], "J"),
            number(summary.work.taken_back[i], "J"),
        ];
        row.extend(summary.external_rms.as_ref().map(|external| number(external[i], unit)));
        table.row(row);
    }
    table
}

/// Lines about the whole run, as the command line has them.
pub(super) fn settings(run: &Run) -> Vec<(String, String)> {
    run.summary.lines().into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

/// Most events that are listed one by one.
const LISTED: usize = 100;

/// List of the events; each entry links to its instant.
pub(super) fn events(events: &[Event], run: &Run) -> Vec<Block> {
    let at = |event: &Event| match event.to {
        None => engineering(event.at, "s"),
        Some(to) => format!("{} to {}", engineering(event.at, "s"), engineering(to.min(run.summary.duration), "s")),
    };
    let moment = |event: &Event| {
        let joint = event.joint.map_or(String::new(), |joint| format!("&joint={}", joint + 1));
        (format!("#t={}{joint}", event.at), format!("{}: {}", at(event), event.text))
    };
    if events.is_empty() {
        return vec![Block::Words("Nothing.".to_owned())];
    }
    let mut blocks = vec![Block::Moments(events.iter().take(LISTED).map(moment).collect())];
    let more = events.len().saturating_sub(LISTED);
    blocks.extend((more > 0).then(|| Block::Words(format!("And {more} more."))));
    blocks
}

/// Explanation of the page's keys, for this number of joints.
pub fn keys(joints: usize) -> String {
    // The page has keys for nine joints.
    let choose = match joints.min(9) {
        0 | 1 => "1 chooses the joint".to_owned(),
        last => format!("1 to {last} choose a joint"),
    };
    format!(
        "Keys: space plays, arrows step (with shift ten times as far), Home and End jump, + and - zoom the time axis about the cursor, \
         < and > change the speed, {choose}, a shows all, v turns the view."
    )
}

/// Explanation of the keys, and of how the data were thinned.
pub(super) fn reading(run: &Run, stride: u64) -> Vec<String> {
    let kept = if stride == 1 {
        "Every tick is in this page.".to_owned()
    } else {
        let apart = engineering(stride as f64 * run.summary.setting.period, "s");
        format!(
            "Every {stride}th tick ({apart}) is in this page, as it was. Of error, torque and torque from outside, a band shows the lowest \
             and the highest value of all ticks between; the log has every tick."
        )
    };
    vec![
        keys(run.record.joints().len()),
        "Press or drag on a curve, or use the slider, to set the time. #t=0.4&joint=2 behind the address opens there; an event of the list leads there.".to_owned(),
        "Terms of the model: each computed alone, at the arm's state and the reference's acceleration. Feedback and the rest: the commanded \
         torque less all of them."
            .to_owned(),
        "Links are drawn from joint to joint: the robot file holds no shapes. A payload is a ball of steel of its mass.".to_owned(),
        kept,
        "Numbers of the tables are those of summary.json, all digits on hover; the page holds that file, and curves as f32.".to_owned(),
    ]
}
