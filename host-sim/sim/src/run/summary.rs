//! A run in a few numbers: a table for people, JSON for programs.

use crate::run::closed_loop::{End, Timing};
use crate::run::joint_label::JointLabel;
use crate::run::load::{ClosestLimit, MotorLoad, Work, closest_limit, motor_loads, work};
use crate::run::numbers::{engineering, peak, ratio, rms};
use crate::run::quality::{OutOfReach, Supervision, at_rest, chatter, last_rest};
use crate::run::record::Record;
use crate::run::summary_parts::{
    FaultEvent, Instructions, LimitCounts, ModelTicks, Setting, SimulatedDrives, count_limits, fault_events,
};
use crate::run::target::Parity;
use crate::table::table;
use robot_compiler::SceneFile;
use serde::Serialize;

/// A run in numbers. Errors and torques cover the ticks before a fault, because a braked arm follows no reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Scene, robot, target and settings.
    #[serde(flatten)]
    pub setting: Setting,
    /// Ticks run.
    pub ticks: usize,
    /// Simulated time, s.
    pub duration: f64,
    /// Reason for an early end: `interrupted`, or the failure of the plant or the target. `None` if the run was complete.
    pub stopped: Option<String>,
    /// Per joint, root mean square of reference minus actual position, rad or m.
    pub tracking_rms: Vec<f64>,
    /// Per joint, greatest magnitude of this error, rad or m.
    pub tracking_max: Vec<f64>,
    /// Per joint, root mean square of the commanded torque, N m or N.
    pub torque_rms: Vec<f64>,
    /// Per joint, greatest magnitude of this torque, N m or N.
    pub torque_peak: Vec<f64>,
    /// Per joint, chatter of the commanded torque: root mean square of its change from one tick to the next, N m or N. With encoders, most of it
    /// results from single counts, which the velocity gain turns into torque.
    pub torque_chatter: Vec<f64>,
    /// Per joint, root mean square of the estimated external torque, N m or N. Without an external force it is noise and model error. `None` if it is
    /// not estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external_rms: Option<Vec<f64>>,
    /// Per joint, rest error: reference minus actual position in the last tick of the last interval in which all references are at rest, rad or m.
    /// `None` without such an interval.
    pub rest_error: Vec<Option<f64>>,
    /// Length of that interval, s. `None` without one.
    pub rest_time: Option<f64>,
    /// Per joint, error within which it counts as settled, rad or m: 2 % of its last move, and at least its `resolution` in the scene's `[safety]`.
    /// `None` without such an interval.
    pub settling_band: Vec<Option<f64>>,
    /// Per joint, settling time, s: from the start of that interval (the end of the motion) until the error is within the band and stays there.
    /// `None` without such an interval, or if the joint is outside its band at the end.
    pub settling_time: Vec<Option<f64>>,
    /// Per joint, ticks in which each limit acted.
    pub limits: Vec<LimitCounts>,
    /// The limit that any joint came nearest to, and the used share of it; `None` without limits.
    pub closest_limit: Option<ClosestLimit>,
    /// Mechanical work of the commanded torques, J.
    pub work: Work,
    /// Per joint, load of its motor; `None` if its continuous torque is not known. The whole list is `None` if none is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motors: Option<Vec<Option<MotorLoad>>>,
    /// Each fault with the tick in which it occurred.
    pub faults: Vec<FaultEvent>,
    /// Result with regard to the firmware's safety state machine.
    pub supervision: Supervision,
    /// Simulated time over wall-clock time.
    pub realtime_factor: f64,
    /// Mean wall-clock time of one controller tick, s.
    pub seconds_per_tick: f64,
    /// Bitwise comparison of desk and chip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parity: Option<Parity>,
    /// Instructions per tick on the chip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instructions_per_tick: Option<Instructions>,
    #[serde(skip)]
    joints: Vec<JointLabel>,
}

impl Summary {
    /// Summarises a run of a scene. The scene gives the joints' limits, reach and resolution.
    #[must_use]
    pub fn new(setting: Setting, scene: &SceneFile, record: &Record, end: End, timing: Timing) -> Self {
        let (ticks, safety) = (record.ticks(), &scene.safety);
        let driven = record.faults().iter().take_while(|fault| fault.is_none()).count();
        let each = |f: &dyn Fn(usize) -> f64| (0..record.joints().len()).map(f).collect::<Vec<f64>>();
        let errors = |joint| record.joint(joint).take(driven).map(|s| s.error());
        let torques = |joint| record.joint(joint).take(driven).map(|s| s.torque);
        let duration = ticks as f64 * setting.period;
        let rest = last_rest(record, driven);
        let resolution = |i: usize| safety.resolution.get(i).copied().unwrap_or(0.0);
        let rests: Vec<_> = (0..record.joints().len())
            .map(|i| rest.as_ref().map(|rest| at_rest(record, i, rest, resolution(i), setting.period)))
            .collect();
        Self {
            ticks,
            duration,
            stopped: match end {
                End::Complete => None,
                End::Interrupted => Some("interrupted".to_owned()),
                End::Diverged(why) => Some(why.to_string()),
                End::TargetFailed => Some("the target failed".to_owned()),
            },
            tracking_rms: each(&|i| rms(errors(i))),
            tracking_max: each(&|i| peak(errors(i))),
            torque_rms: each(&|i| rms(torques(i))),
            torque_peak: each(&|i| peak(torques(i))),
            torque_chatter: each(&|i| chatter(torques(i))),
            external_rms: record.estimates().then(|| each(&|i| rms(record.external(i).take(driven)))),
            rest_error: rests.iter().map(|rest| rest.as_ref().map(|rest| rest.error)).collect(),
            rest_time: rest.as_ref().map(|rest| rest.len() as f64 * setting.period),
            settling_band: rests.iter().map(|rest| rest.as_ref().map(|rest| rest.band)).collect(),
            settling_time: rests.iter().map(|rest| rest.as_ref().and_then(|rest| rest.settled)).collect(),
            limits: (0..record.joints().len()).map(|i| count_limits(record, i)).collect(),
            closest_limit: closest_limit(record, driven, &scene.robot),
            work: work(record, driven),
            motors: Some(motor_loads(record, driven, &scene.robot, setting.period))
                .filter(|loads| loads.iter().any(Option::is_some)),
            faults: fault_events(record),
            supervision: Supervision::of(record, driven, safety),
            realtime_factor: ratio(duration, timing.whole.as_secs_f64()),
            seconds_per_tick: ratio(timing.ticks.as_secs_f64(), ticks as f64),
            parity: None,
            instructions_per_tick: None,
            joints: record.joints().to_vec(),
            setting,
        }
    }

    /// The table and the lines below it, for people.
    #[must_use]
    pub fn table(&self) -> String {
        let columns = [
            "joint",
            "error rms",
            "error max",
            "at rest, settles in",
            "torque rms",
            "torque peak",
            "chatter",
            "limits (ticks)",
        ];
        let mut table = table(columns, 1);
        for (i, joint) in self.joints.iter().enumerate() {
            let (position, torque) = (joint.position_unit(), joint.torque_unit());
            table.add_row([
                joint.name.clone(),
                engineering(self.tracking_rms[i], position),
                engineering(self.tracking_max[i], position),
                self.rest(i, position),
                engineering(self.torque_rms[i], torque),
                engineering(self.torque_peak[i], torque),
                engineering(self.torque_chatter[i], torque),
                self.limits[i].describe(),
            ]);
        }
        let Setting { scene, robot, target, scalar, law, trig, .. } = &self.setting;
        let lines: Vec<String> = self.lines().iter().map(|(name, text)| format!("{name:<20}{text}")).collect();
        format!("{scene}: {robot}, {law}, {target}, {scalar}, {trig} trig\n{table}\n{}", lines.join("\n"))
    }

    /// Rest error and settling time of a joint.
    fn rest(&self, joint: usize, unit: &str) -> String {
        self.rest_error[joint].map_or("no rest".to_owned(), |error| {
            let settled = self.settling_time[joint].map_or_else(|| self.unsettled(), |time| engineering(time, "s"));
            format!("{}, {settled}", engineering(error, unit))
        })
    }

    /// Text in place of a settling time: how long the arm rested without the joint settling.
    pub(super) fn unsettled(&self) -> String {
        format!("not in {}", engineering(self.rest_time.unwrap_or(0.0), "s"))
    }

    /// Text about the safety state machine.
    fn supervision(&self) -> String {
        let Some(OutOfReach { tick, joint }) = &self.supervision.out_of_reach else {
            return "no state machine; no joint left its reach".to_owned();
        };
        let name = &self.joints[joint - 1].name;
        let at = engineering(*tick as f64 * self.setting.period, "s");
        format!("no state machine; the firmware would have held at tick {tick} ({at}): reach, {name}")
    }

    /// The motor that is loaded most, and the hottest one.
    fn motors(&self, loads: &[Option<MotorLoad>]) -> Option<String> {
        let known = || loads.iter().zip(&self.joints).filter_map(|(load, joint)| Some((load.as_ref()?, joint)));
        let (load, joint) = known().max_by(|(a, _), (b, _)| a.continuous.total_cmp(&b.continuous))?;
        let over = if load.continuous > 1.0 { ": it overheats if this goes on" } else { "" };
        let rated = engineering(load.rated, joint.torque_unit());
        let text = format!("{} gives {:.0} % of its {rated} rated (rms){over}", joint.name, 100.0 * load.continuous);
        let hottest =
            known().filter_map(|(load, joint)| Some((load.heat?, joint))).max_by(|(a, _), (b, _)| a.total_cmp(b));
        Some(match hottest {
            None => text + "; heat unknown: no time constants",
            Some((heat, joint)) => {
                format!("{text}; {} reaches {:.0} % of its continuous heat", joint.name, 100.0 * heat)
            }
        })
    }

    /// Lines about the whole arm: name and text.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let period = self.setting.period;
        let ticks = format!("{} of {}: {}", self.ticks, engineering(period, "s"), engineering(self.duration, "s"));
        let mut lines = vec![
            ("ticks", ticks),
            ("time per tick", engineering(self.seconds_per_tick, "s")),
            ("faster than real", format!("{:.1} times", self.realtime_factor)),
        ];
        if let Some(ClosestLimit { joint, limit, used, tick }) = &self.closest_limit {
            let (at, name) = (engineering(*tick as f64 * period, "s"), &self.joints[joint - 1].name);
            lines.push(("closest limit", format!("{:.0} % of the {limit} limit of {name}, at {at}", 100.0 * used)));
        }
        let [given, back] = [&self.work.given, &self.work.taken_back].map(|each| engineering(each.iter().sum(), "J"));
        lines.push(("work of the torques", format!("{given} given, {back} taken back")));
        lines.extend(self.motors.as_deref().and_then(|loads| self.motors(loads)).map(|text| ("motors", text)));
        if let Some(ModelTicks { every, between }) = &self.setting.model {
            lines.push(("model", format!("every {every} ticks, {between} between")));
        }
        if let Some(SimulatedDrives { kind, loop_rate, .. }) = &self.setting.drives {
            let rate = engineering(*loop_rate, "Hz");
            lines.push(("drives", format!("simulated: {kind}, replies a tick old, own loop {rate}")));
        }
        if let Some(Instructions { min, max }) = self.instructions_per_tick {
            lines.push(("instructions", format!("{min} to {max} per tick")));
        }
        if let Some(Parity { ticks, mismatches }) = self.parity {
            lines.push(("parity", format!("{mismatches} of {ticks} ticks differ from the desk")));
        }
        if let Some(external) = &self.external_rms {
            let each = external.iter().zip(&self.joints).map(|(x, joint)| engineering(*x, joint.torque_unit()));
            lines.push(("from outside", format!("{} rms", each.collect::<Vec<_>>().join(", "))));
        }
        if self.faults.is_empty() {
            lines.push(("faults", "none".to_owned()));
        }
        let after = self.setting.drives.as_ref().map_or("the brakes held", |drives| drives.after_fault);
        for fault in &self.faults {
            let at = engineering(fault.tick as f64 * period, "s");
            lines.push(("faults", format!("{} at tick {} ({at}); {after} from then on", fault.message, fault.tick)));
        }
        lines.push(("safety", self.supervision()));
        lines.extend(
            self.stopped.iter().map(|why| ("stopped", format!("{why} after {}", engineering(self.duration, "s")))),
        );
        lines
    }
}
