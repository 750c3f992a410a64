//! Events of a run, and their times.

use crate::run::record::Record;
use crate::run::simulate::Run;
use dynamics_core::control::LimitFlags;
use robot_compiler::SceneFile;
use serde::Serialize;

/// Something that happened at an instant or over an interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Event {
    /// Start, s.
    pub(super) at: f64,
    /// End, s; `None` for an instant.
    pub(super) to: Option<f64>,
    /// `waypoint`, `limit`, `fault`, `push` or `reach`: the style sheet has a colour for each.
    pub(super) kind: &'static str,
    /// Joint, counted from 0; `None` for the whole arm.
    pub(super) joint: Option<usize>,
    /// Description.
    pub(super) text: String,
}

const LIMITS: [(LimitFlags, &str); 5] = [
    (LimitFlags::POSITION, "position limit"),
    (LimitFlags::VELOCITY, "velocity limit"),
    (LimitFlags::TORQUE, "torque limit"),
    (LimitFlags::TORQUE_RATE, "limit of the torque's rate"),
    (LimitFlags::COLLISION, "reaction to a collision"),
];

/// Most intervals of one limit on one joint. The rest of a limit that switches on and off more often is shown as one interval.
const STRETCHES_MAX: usize = 40;

/// All events, ordered by time.
pub(super) fn events(run: &Run, scene: &SceneFile) -> Vec<Event> {
    let record = &run.record;
    let period = run.summary.setting.period;
    let mut found: Vec<Event> = Vec::new();
    let moment = |at: f64, kind, joint, text: String| Event { at, to: None, kind, joint, text };
    for (index, at) in run.marks.waypoints.iter().enumerate() {
        found.push(moment(*at, "waypoint", None, format!("point {} of the motion", index + 1)));
    }
    for fault in &run.summary.faults {
        found.push(moment(fault.tick as f64 * period, "fault", None, fault.message.clone()));
    }
    if let Some(far) = &run.summary.supervision.out_of_reach {
        let text = format!("{} leaves its reach; the firmware would have held", record.joints()[far.joint - 1].name);
        found.push(moment(far.tick as f64 * period, "reach", Some(far.joint - 1), text));
    }
    if let Some(push) = &scene.plant.push {
        let text =
            format!("a push of {:.1} N and {:.2} N m at the tip", push.wrench.force.norm(), push.wrench.moment.norm());
        found.push(Event { at: push.at, to: Some(push.at + push.duration), kind: "push", joint: None, text });
    }
    for (joint, label) in record.joints().iter().enumerate() {
        for (flag, name) in LIMITS {
            for (at, to) in stretches(record, joint, flag) {
                let text = format!("{}: {name}", label.name);
                found.push(Event { at, to: Some(to + period), kind: "limit", joint: Some(joint), text });
            }
        }
    }
    let end = record.ticks() as f64 * period;
    found.retain(|event| event.at <= end);
    found.sort_by(|a, b| a.at.total_cmp(&b.at));
    found
}

/// Intervals in which a limit acts on a joint, from first to last tick, s.
fn stretches(record: &Record, joint: usize, flag: LimitFlags) -> Vec<(f64, f64)> {
    let mut spans: Vec<(f64, f64)> = Vec::new();
    let mut acted = false;
    for (at, sample) in record.time().iter().zip(record.joint(joint)) {
        let acts = sample.limits.contains(flag);
        let full = spans.len() >= STRETCHES_MAX;
        match spans.last_mut() {
            Some(span) if acts && (acted || full) => span.1 = *at,
            _ if acts => spans.push((*at, *at)),
            _ => {}
        }
        acted = acts;
    }
    spans
}
