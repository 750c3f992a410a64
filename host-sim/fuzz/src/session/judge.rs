//! What `docs/safety.md` says of a tick, held to what the machine said and what the drives do, without a line of the machine.
//!
//! It keeps its own account of homing, latched faults, acting torque and the host's silence. Bounds that the machine computes
//! are judged in f64, and only what is beyond them by more than the rounding of f32 counts.

use dynamics_core::control::{ControllerConfig, Sensed};
use dynamics_core::safety::{Rules, SafeAction};
use host_sim::session::states::{self, ARMED, FAULT, HOLDING, HOMING, IDLE, RUNNING};
use link::{Actuation, Pacing, Request, Status};
use session::Drives;

/// All that the machine is told in a tick.
#[derive(Clone, Debug)]
pub(super) struct Told<const N: usize> {
    pub(super) sensed: Sensed<f32, N>,
    pub(super) age_ticks: [u32; N],
    pub(super) drive_fault: [bool; N],
    pub(super) zeroed: bool,
    pub(super) emergency_stop: bool,
    pub(super) overrun: bool,
    pub(super) supply: Option<f32>,
    pub(super) temperature: Option<f32>,
    /// The last of the requests since the tick before.
    pub(super) asked: Option<Request>,
    /// Ticks since a frame was taken.
    pub(super) silent: u32,
}

impl<const N: usize> Told<N> {
    /// Nobody has said anything.
    pub(super) const fn nothing() -> Self {
        Self {
            sensed: Sensed::State { q: [0.0; N], qd: [0.0; N] },
            age_ticks: [u32::MAX; N],
            drive_fault: [false; N],
            zeroed: false,
            emergency_stop: false,
            overrun: false,
            supply: None,
            temperature: None,
            asked: None,
            silent: u32::MAX,
        }
    }

    /// A tick has passed, and nothing new has come.
    pub(super) fn age(&mut self) {
        (self.asked, self.overrun) = (None, false);
        self.silent = self.silent.saturating_add(1);
        self.age_ticks = self.age_ticks.map(|age| age.saturating_add(1));
    }
}

/// The judge of one session, from one hello to the next.
#[derive(Clone, Debug)]
pub(super) struct Judge<const N: usize> {
    config: ControllerConfig<f32, N>,
    rules: Rules<f32, N>,
    /// State and cause of the tick before.
    before: (u8, u8),
    homed: bool,
    /// The torque that acted in the tick before.
    torque: [f32; N],
    /// Positions of the tick before, of the joints whose reading was fresh and a number.
    fresh: [Option<f64>; N],
}

impl<const N: usize> Judge<N> {
    pub(super) fn new(config: &ControllerConfig<f32, N>, rules: &Rules<f32, N>) -> Self {
        Self { config: *config, rules: *rules, before: (IDLE, 0), homed: false, torque: [0.0; N], fresh: [None; N] }
    }

    /// A hello takes everything away.
    pub(super) fn reset(&mut self) {
        *self = Self::new(&self.config, &self.rules);
    }

    /// Judge a tick under supervision: its status with all its parts, and what the drives do.
    pub(super) fn watch(&mut self, pacing: Pacing, told: &Told<N>, status: &Status, drives: &Drives<N>) {
        let acts = self.actuation(pacing, status, drives);
        self.moved(told, status);
        self.board(told, status, acts.is_some());
        self.readings(told, status, acts.is_some());
        self.silence(told, status, acts.is_some());
        if status.state == RUNNING {
            self.reference(told, status);
        }
        let torque = acts.unwrap_or([0.0; N]);
        for i in 0..N {
            let (tau, last) = (torque[i], self.torque[i]);
            assert!(
                tau.is_finite() && tau.abs() <= self.config.limits[i].torque,
                "rule 4: joint {i}, {tau}: {status:?}"
            );
            assert!(
                acts.is_none() || !beyond((f64::from(tau) - f64::from(last)).abs(), self.config.torque_step[i]),
                "rules 4, 7: {last} to {tau}"
            );
        }
        self.torque = torque;
        self.before = (status.state, status.cause);
    }

    /// Rules 1 and 16, and what the pacing says of drives: the torque that acts, or would in a drill.
    fn actuation(&self, pacing: Pacing, status: &Status, drives: &Drives<N>) -> Option<[f32; N]> {
        let reported = status.actuation.as_ref().unwrap();
        let safe = match self.rules.safe_action {
            SafeAction::Brake => Actuation::Brake,
            SafeAction::DampedStop => Actuation::DampedStop,
            SafeAction::Off => Actuation::Off,
        };
        let acts = matches!(status.state, ARMED | RUNNING | HOLDING);
        match (drives, reported) {
            (Drives::Drive(torque), Actuation::Drive { torque: said, .. }) => {
                assert!(pacing == Pacing::Live, "the drives are driven in {pacing:?}");
                assert!(
                    said.iter().map(|x| x.to_bits()).eq(torque.iter().map(|x| x.to_bits())),
                    "{said:?}, {torque:?}"
                );
            }
            (Drives::Safe(action), Actuation::Drive { .. }) => {
                assert!(pacing == Pacing::Drill && *action == self.rules.safe_action, "{drives:?} in {pacing:?}");
            }
            (Drives::Safe(action), reported) => {
                assert!(*action == self.rules.safe_action && *reported == safe, "rule 16")
            }
            (Drives::Drive(_), _) => panic!("torque, and {reported:?} is said"),
        }
        let Actuation::Drive { torque, .. } = reported else {
            assert!(!acts, "rule 16: no torque in state {}", status.state);
            return None;
        };
        assert!(acts, "rule 16: torque in state {}", status.state);
        assert!(status.homed, "rule 1: torque, and not homed");
        Some(core::array::from_fn(|i| torque[i]))
    }

    /// The diagram: no state is left but by a request or for a cause, a fault only by a clear, and a request is granted or
    /// refused.
    fn moved(&mut self, told: &Told<N>, status: &Status) {
        let asked = |request| told.asked == Some(request);
        let ((before, cause), now) = (self.before, status.state);
        let allowed = states::may_lead(self.before, status, asked);
        assert!(
            allowed,
            "rule 15 or the diagram: {before} ({cause}) to {now} ({}), asked {:?}",
            status.cause, told.asked
        );
        match (before, now) {
            (IDLE, HOMING) => self.homed = false,
            (HOMING, IDLE) if status.homed => self.homed |= asked(Request::Confirm) && told.zeroed,
            _ => {}
        }
        assert!(self.homed || !status.homed, "rule 1: it takes itself for homed");
        self.homed = status.homed;
        match (told.asked, &status.refused) {
            (None, refused) => assert!(refused.is_none(), "nothing was asked: {refused:?}"),
            (Some(request), None) => assert!(before != now, "{request:?} in state {before} did nothing"),
            (Some(request), Some(_)) => {
                let by_itself = now == before || now == FAULT || now == HOLDING;
                assert!(by_itself, "{request:?} was refused, and led from {before} to {now}");
            }
        }
    }

    /// Rules 10 to 14: in every state, and the first of the list is named.
    fn board(&self, told: &Told<N>, status: &Status, acts: bool) {
        let outside = |value: Option<f32>, (low, high): (f32, f32)| {
            value.is_some_and(|value| value.is_nan() || value < low || value > high)
        };
        let all = [
            (9, told.emergency_stop),
            (6, told.overrun),
            (11, told.drive_fault.contains(&true)),
            (12, outside(told.supply, self.rules.supply)),
            (13, outside(told.temperature, self.rules.temperature)),
        ];
        let first = all.iter().find(|(_, wrong)| *wrong).map(|(code, _)| *code);
        if let Some(code) = first {
            assert!(!acts && status.state == FAULT, "fault {code}, and state {}", status.state);
        }
        if status.state == FAULT && self.before.0 != FAULT {
            let named = Some(status.cause).filter(|cause| all.iter().any(|(code, _)| code == cause));
            assert!(named == first, "fault {} in place of {first:?}: {told:?}", status.cause);
        }
    }

    /// Rules 1, 2 and 3: what is read is a number, fresh, inside the guard, has not jumped, and rests where torque or homing
    /// begins.
    fn readings(&mut self, told: &Told<N>, status: &Status, acts: bool) {
        let (before, now) = (self.before.0, status.state);
        let begins = (before == IDLE && now == ARMED) || (before == HOMING && now == IDLE && status.homed);
        let mut stale = false;
        let mut wrong = false;
        for i in 0..N {
            let (q, qd) = match &told.sensed {
                Sensed::State { q, qd } => (f64::from(q[i]), Some(f64::from(qd[i]))),
                Sensed::Counts(counts) => {
                    let encoder = &self.config.encoder[i];
                    (f64::from(counts[i].wrapping_sub(encoder.zero)) * f64::from(encoder.per_count), None)
                }
            };
            let finite = q.is_finite() && qd.is_none_or(f64::is_finite);
            let age = told.age_ticks[i];
            stale |= age > self.config.age_max;
            wrong |= !finite;
            let (low, high) = self.config.limits[i].position;
            let margin = f64::from(self.config.guard[i].position_margin);
            let (low, high) = (f64::from(low) - margin, f64::from(high) + margin);
            let speed_max = self.config.guard[i].velocity_max;
            let rule = &self.rules.joints[i];
            let place = if finite && age == 0 { Some(q) } else { None };
            let jumped = match (self.fresh[i], place) {
                // Differences of large numbers are rounded as those are.
                (Some(last), Some(q)) => {
                    let rounding = 1e-6 * (q.abs() + last.abs());
                    beyond((q - last).abs(), f64::from(rule.jump_step) + f64::from(rule.resolution) + rounding)
                }
                _ => false,
            };
            self.fresh[i] = place;
            if jumped {
                assert!(!acts && !status.homed, "rule 3: joint {i} jumped to {q}: {status:?}");
            }
            if acts || begins {
                assert!(finite && age <= self.config.age_max, "rule 2: joint {i} at {q}, {qd:?}, age {age}");
                assert!(!beyond(q, high) && !beyond(low, q), "rule 2: joint {i} at {q}");
                assert!(qd.is_none_or(|qd| !beyond(qd.abs(), speed_max)), "rule 2: joint {i} at {qd:?}");
            }
            let rests = qd.is_none_or(|qd| !beyond(qd.abs(), rule.rest_speed));
            let leaves = matches!(before, ARMED | HOLDING | FAULT) && now == IDLE;
            assert!(rests || !(begins || leaves), "rules 1, 15: from {before} to {now} at {qd:?}");
        }
        if now == FAULT && before != FAULT {
            assert!(status.cause != 3 || stale, "stale out of nothing: {told:?}");
            assert!(status.cause != 1 || wrong, "no number out of nothing: {told:?}");
        }
    }

    /// Rule 9.
    fn silence(&self, told: &Told<N>, status: &Status, acts: bool) {
        let Rules { heartbeat_max, hold_max, .. } = self.rules;
        let silent = told.silent > heartbeat_max;
        assert!(!silent || !matches!(status.state, ARMED | RUNNING), "rule 9: {} after {}", status.state, told.silent);
        let alone = told.silent > heartbeat_max.saturating_add(hold_max);
        assert!(!(alone && acts), "rule 9: torque after {}", told.silent);
        let lost = status.state == FAULT && self.before.0 != FAULT && status.cause == 10;
        assert!(!lost || silent, "rule 9: the host is there");
    }

    /// Rules 6 and 8.
    fn reference(&self, told: &Told<N>, status: &Status) {
        let reference = status.reference.as_ref().unwrap_or_else(|| panic!("it runs after nothing: {status:?}"));
        for i in 0..N {
            let [q, qd, qdd] = [&reference.q, &reference.qd, &reference.qdd].map(|list| f64::from(list[i]));
            assert!(q.is_finite() && qd.is_finite() && qdd.is_finite(), "reference {q}, {qd}, {qdd}");
            let rule = &self.rules.joints[i];
            if let Sensed::State { q: at, .. } = &told.sensed {
                let at = f64::from(at[i]);
                assert!(!beyond((q - at).abs(), rule.reach), "rule 8: joint {i}, reference {q}, arm {at}");
            }
            let (low, high) = self.config.limits[i].position;
            let (low, high) = (f64::from(low), f64::from(high));
            let room = if qd > 0.0 { high - q } else { q - low };
            let way = qd.abs() * f64::from(self.rules.latency) + qd * qd / (2.0 * f64::from(rule.deceleration));
            assert!(qd.abs() < 1e-4 || !beyond(way, room), "rule 6: joint {i} needs {way} to stop, has {room}");
        }
    }
}

/// Beyond a bound, whatever was rounded on the way: 80 times the rounding of f32.
fn beyond(value: f64, bound: impl Into<f64>) -> bool {
    let bound = bound.into();
    value > bound + 1e-5 * (1.0 + bound.abs())
}
