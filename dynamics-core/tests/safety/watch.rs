//! Properties that must hold in every tick, for every action of the machine. An independent checker compares inputs and outputs, and
//! shares no code with the machine.

use crate::safety::support::{self, *};
use dynamics_core::safety::{Actuation, Request, State};
use dynamics_core::{Reference, Sensed};

/// The torque that acts, on open or on engaged brakes.
fn acting(output: &Said) -> Option<[f32; 2]> {
    match output.actuation {
        Actuation::Drive { torque, .. } | Actuation::Preload { torque, .. } => Some(torque),
        Actuation::Safe(_) | Actuation::Enable(_) => None,
    }
}

/// Memory of the checker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch {
    state: State,
    torque: [f32; 2],
    /// Position of each joint in the last tick with finite numbers, and the age of that reading in ticks.
    seen: [Option<(f32, u32)>; 2],
    confirmed: bool,
    silent: u32,
    /// Position at which the arm was armed, rad.
    armed: [f32; 2],
}

impl Watch {
    pub(crate) fn new() -> Self {
        Self { state: State::Idle, torque: [0.0; 2], seen: [None; 2], confirmed: false, silent: 0, armed: [0.0; 2] }
    }

    /// A checker that starts later, for a machine whose start it has not seen.
    pub(crate) fn from(machine: &Machine, q: [f32; 2], torque: [f32; 2], silent: u32) -> Self {
        let seen = q.map(|q| Some((q, 0)));
        Self { state: machine.state(), torque, seen, confirmed: machine.homed(), silent, armed: q }
    }

    /// The first rule that this tick breaks, by its number in `docs/safety/rules.md`.
    pub(crate) fn broken(&mut self, inputs: &Setpoint, output: &Said) -> Option<&'static str> {
        let before = core::mem::replace(&mut self.state, output.state);
        let torque = acting(output);
        let (acts, drives) = (torque.is_some(), support::torque(output).is_some());
        let Sensed::State { q, qd } = inputs.sensed else { panic!("the watchman reads positions") };

        let finite = |i: usize| q[i].is_finite() && qd[i].is_finite();
        let mut jumped = false;
        for i in 0..2 {
            let age = inputs.age_ticks[i];
            self.seen[i] = match self.seen[i] {
                Some((at, since)) if finite(i) => {
                    let elapsed = (u64::from(since) + 1).saturating_sub(u64::from(age));
                    jumped |= f64::from((q[i] - at).abs()) > f64::from(JUMP) * elapsed as f64 + 0.002;
                    Some((q[i], age))
                }
                None if finite(i) => Some((q[i], age)),
                Some((at, since)) => Some((at, since.saturating_add(1))),
                None => None,
            };
        }
        let believed = |i: usize| {
            finite(i) && inputs.age_ticks[i] <= AGE_MAX && q[i].abs() <= LIMIT + MARGIN && qd[i].abs() <= 6.0
        };
        self.confirmed &= !jumped;
        self.confirmed &= !(before == State::Idle && output.state == State::Homing);
        self.confirmed |= before == State::Homing && inputs.request == Some(Request::Confirm) && output.homed;
        let silent = inputs.heartbeat_age > HEARTBEAT_MAX;
        self.silent = if silent && before.drives() { self.silent + 1 } else { 0 };
        let last = core::mem::replace(&mut self.torque, torque.unwrap_or([0.0; 2]));

        // 16: torque on open brakes in four states and no other, on engaged brakes while arming and disarming, else the robot's own safe action.
        let safe = matches!(output.actuation, Actuation::Safe(_));
        if drives != output.state.drives()
            || (!drives && safe == matches!(output.state, State::Arming | State::Disarming))
            || (output.state == State::Disarming && !acts)
        {
            return Some("16");
        }
        if matches!(output.actuation, Actuation::Safe(action) if action != config().rules.safe_action) {
            return Some("16");
        }
        let stopped = inputs.emergency_stop || inputs.request == Some(Request::Stop);
        if stopped && (acts || !is_fault(output.state)) {
            return Some("10");
        }
        if inputs.overrun && acts {
            return Some("11");
        }
        if inputs.drive_fault.contains(&true) && acts {
            return Some("12");
        }
        let inside = |value: Option<f32>, (lo, hi): (f32, f32)| value.is_none_or(|x| x >= lo && x <= hi);
        if acts && !inside(inputs.supply, SUPPLY) {
            return Some("13");
        }
        if acts && !inside(inputs.temperature, TEMPERATURE) {
            return Some("14");
        }
        if is_fault(before) && output.state != before {
            let stands = inputs.request == Some(Request::Clear)
                && !inputs.emergency_stop
                && (0..2).all(|i| finite(i) && qd[i].abs() <= REST);
            if !(stands && output.state == State::Idle) {
                return Some("15");
            }
        }
        if jumped && (acts || output.homed) {
            return Some("3");
        }
        if (drives || output.state == State::Disarming) && !(0..2).all(believed) {
            return Some("2");
        }
        if acts && !(self.confirmed && output.homed) {
            return Some("1");
        }
        if !before.drives() && drives && !(0..2).all(|i| qd[i].abs() <= REST) {
            return Some("1");
        }
        if let Some(torque) = torque {
            if !torque.iter().all(|x| x.abs() <= TORQUE) {
                return Some("4");
            }
            let near = |i: usize| (torque[i] - last[i]).abs() <= STEP * 1.000_001;
            if !(near(0) && near(1)) {
                return Some(if before.drives() { "4" } else { "7" });
            }
        }
        if output.state == State::Running {
            let Some(reference) = inputs.reference else { return Some("9") };
            if silent {
                return Some("9");
            }
            if !(0..2).all(|i| has_room(&reference, i)) {
                return Some("6");
            }
            if !(0..2).all(|i| (reference.q[i] - q[i]).abs() <= REACH) {
                return Some("8");
            }
        }
        if output.state == State::Armed {
            if before != State::Armed {
                self.armed = q;
            }
            if !(0..2).all(|i| (self.armed[i] - q[i]).abs() <= REACH) {
                return Some("17");
            }
        }
        if self.silent > HOLD_MAX && drives {
            return Some("9");
        }
        None
    }
}

/// `v^2 / (2 a) + v t <= distance`, in the textbook's form, in double precision and with a margin for rounding.
fn has_room(reference: &Reference<f32, 2>, i: usize) -> bool {
    let (q, v) = (f64::from(reference.q[i]), f64::from(reference.qd[i]));
    let (a, t, limit) = (f64::from(DECELERATION), f64::from(LATENCY), f64::from(LIMIT));
    v == 0.0 || v * v / (2.0 * a) + v.abs() * t <= limit - v.signum() * q + 1e-5
}
