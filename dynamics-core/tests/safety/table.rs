//! Every transition: every state, every combination of boolean inputs, every request, every edge of every counter,
//! every kind of reading, reference and command, against a table.

use crate::safety::support::*;
use crate::safety::watch::Watch;
use dynamics_core::control::LimitFlags;
use dynamics_core::safety::{Actuation, HoldCause, Inputs, Request, SafeAction, State};
use dynamics_core::{Command, Fault, Reference, Sensed};
use std::collections::BTreeSet;

/// Position of the arm: near the limit, so that it can cross it without a jump.
const AT: [f32; 2] = [0.5, 1.9];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Measured {
    Resting,
    Moving,
    NotANumber,
    Jumped,
    Outside,
    Fast,
    Pushed,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Wanted {
    Nothing,
    Near,
    OtherSpeed,
    Far,
    NotANumber,
    NoRoom,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Answer {
    Torque,
    Brake,
    NotANumber,
}

/// One case, in the terms of the table.
#[derive(Clone, Copy, Debug)]
struct Case {
    from: State,
    homed: bool,
    alone: u32,
    /// True if the brakes of this machine need time to engage.
    slow_brakes: bool,
    /// State in which disarming ends in this tick.
    ends_in: Option<State>,
    request: Option<Request>,
    emergency_stop: bool,
    overrun: bool,
    drive_fault: bool,
    supply_bad: bool,
    temperature_bad: bool,
    zeroed: bool,
    measured: Measured,
    age: u32,
    heartbeat: u32,
    wanted: Wanted,
    answer: Answer,
}

// The conditions that the table uses.
impl Case {
    fn in_fault(&self) -> bool {
        is_fault(self.from)
    }
    fn driving(&self) -> bool {
        self.from.drives()
    }
    fn disarming(&self) -> bool {
        self.from == State::Disarming
    }
    fn arming(&self) -> bool {
        self.from == State::Arming
    }
    fn external(&self) -> Option<Fault> {
        let all = [
            (self.emergency_stop, Fault::EmergencyStop),
            (self.overrun, Fault::Overrun),
            (self.drive_fault, Fault::DriveFault { joint: 1 }),
            (self.supply_bad, Fault::SupplyOutOfBounds),
            (self.temperature_bad, Fault::TemperatureOutOfBounds),
            (self.request == Some(Request::Stop), Fault::EmergencyStop),
        ];
        all.into_iter().find(|(is, _)| *is).map(|(_, fault)| fault)
    }
    /// True if the reading of joint 2 jumped: it is one tick younger than the last, or there was no time to move at all.
    fn jumped(&self) -> bool {
        let away = matches!(self.measured, Measured::Outside | Measured::Pushed);
        self.measured == Measured::Jumped || (away && self.age > 0)
    }
    fn implausible(&self) -> Option<Fault> {
        let joint = 1;
        let all = [
            (self.age > AGE_MAX, Fault::StaleMeasurement),
            (self.measured == Measured::NotANumber, Fault::NonFiniteMeasurement { joint }),
            (self.jumped(), Fault::ImpossibleJump { joint }),
            (self.measured == Measured::Outside, Fault::PositionOutOfBounds { joint }),
            (self.measured == Measured::Fast, Fault::VelocityOutOfBounds { joint }),
        ];
        all.into_iter().find(|(is, _)| *is).map(|(_, fault)| fault)
    }
    fn resting(&self) -> bool {
        !matches!(self.measured, Measured::Moving | Measured::Fast)
    }
    fn still_homed(&self) -> bool {
        self.homed && !self.jumped()
    }
    /// True if reference and arm are out of reach of each other, because either of them is elsewhere.
    fn far(&self) -> bool {
        (self.wanted == Wanted::Far) != (self.measured == Measured::Pushed)
    }
    fn silent(&self) -> bool {
        self.heartbeat > HEARTBEAT_MAX
    }
    fn too_long_alone(&self) -> bool {
        self.driving() && self.silent() && self.alone + 1 > HOLD_MAX
    }
}

/// The expected result. A refusal is given by its number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Expected {
    state: State,
    homed: bool,
    refused: Option<u8>,
}

/// Condition on a case.
type Holds = fn(&Case) -> bool;

/// A row: it applies if `from` and `when` hold and no earlier row applied.
struct Row {
    from: &'static [u8],
    request: Request,
    when: Holds,
    to: Result<State, u8>,
}

const IDLE: u8 = 0;
const HOMING: u8 = 1;
const ARMED: u8 = 2;
const RUNNING: u8 = 3;
const HOLDING: u8 = 4;
const ARMING: u8 = 6;
const DISARMING: u8 = 8;

const fn row(from: &'static [u8], request: Request, when: Holds, to: Result<State, u8>) -> Row {
    Row { from, request, when, to }
}

const NO_STATE: u8 = 1;
const NOT_HOMED: u8 = 3;
const NOT_ZEROED: u8 = 4;
const IMPLAUSIBLE: u8 = 5;
const NOT_AT_REST: u8 = 6;
const SILENT: u8 = 7;
const NO_REFERENCE: u8 = 8;
const NO_ROOM: u8 = 9;
const OUT_OF_REACH: u8 = 10;

/// Requests without a fault in force. A request that is not listed is rejected as wrong for the state.
const REQUESTS: [Row; 30] = [
    row(&[IDLE], Request::Home, |_| true, Ok(State::Homing)),
    row(&[HOMING], Request::Confirm, |c| !c.zeroed, Err(NOT_ZEROED)),
    row(&[HOMING], Request::Confirm, |c| c.implausible().is_some(), Err(IMPLAUSIBLE)),
    row(&[HOMING], Request::Confirm, |c| !c.resting(), Err(NOT_AT_REST)),
    row(&[HOMING], Request::Confirm, |_| true, Ok(State::Idle)),
    row(&[HOMING], Request::Disarm, |_| true, Ok(State::Idle)),
    row(&[IDLE], Request::Arm, |c| !c.still_homed(), Err(NOT_HOMED)),
    row(&[IDLE], Request::Arm, |c| c.implausible().is_some(), Err(IMPLAUSIBLE)),
    row(&[IDLE], Request::Arm, |c| !c.resting(), Err(NOT_AT_REST)),
    row(&[IDLE], Request::Arm, Case::silent, Err(SILENT)),
    row(&[IDLE], Request::Arm, |_| true, Ok(State::Arming)),
    row(&[ARMING], Request::Disarm, |_| true, Ok(State::Idle)),
    row(&[ARMING], Request::Hold, |_| true, Ok(State::Idle)),
    row(&[ARMED, HOLDING], Request::Disarm, |c| !c.resting(), Err(NOT_AT_REST)),
    row(&[ARMED, HOLDING], Request::Disarm, |c| c.slow_brakes, Ok(State::Disarming)),
    row(&[ARMED, HOLDING], Request::Disarm, |_| true, Ok(State::Idle)),
    row(&[ARMED, HOLDING], Request::Run, Case::silent, Err(SILENT)),
    row(&[ARMED, HOLDING], Request::Run, |c| c.wanted == Wanted::Nothing, Err(NO_REFERENCE)),
    row(&[ARMED, HOLDING], Request::Run, |c| c.wanted == Wanted::NotANumber, Err(IMPLAUSIBLE)),
    row(&[ARMED, HOLDING], Request::Run, |c| c.wanted == Wanted::NoRoom, Err(NO_ROOM)),
    row(&[ARMED, HOLDING], Request::Run, Case::far, Err(OUT_OF_REACH)),
    row(&[ARMED, HOLDING], Request::Run, |c| c.wanted == Wanted::OtherSpeed, Err(OUT_OF_REACH)),
    row(&[ARMED, HOLDING], Request::Run, |_| true, Ok(State::Running)),
    row(&[IDLE, ARMED, HOLDING], Request::FullRange, |c| !c.still_homed(), Err(NOT_HOMED)),
    row(&[ARMED, HOLDING], Request::FullRange, |c| !c.resting(), Err(NOT_AT_REST)),
    row(&[HOMING, ARMING, RUNNING, DISARMING], Request::FullRange, |_| true, Err(NO_STATE)),
    row(&[RUNNING], Request::Hold, |_| true, Ok(State::Holding(HoldCause::Requested))),
    row(&[RUNNING], Request::Disarm, |_| true, Err(NO_STATE)),
    row(&[IDLE, HOMING, ARMED, RUNNING, HOLDING], Request::Clear, |_| true, Err(NO_STATE)),
    row(&[IDLE, ARMED, RUNNING, HOLDING], Request::Confirm, |_| true, Err(NO_STATE)),
];

/// Transitions without a request, judged after the requests, while torque acts or is awaited (arming). The first row that holds is taken.
const EVENTS: [(u8, Holds, State); 8] = [
    (RUNNING, |c| c.wanted == Wanted::NotANumber, State::Fault(Fault::NonFiniteReference { joint: 1 })),
    (RUNNING, Case::silent, State::Holding(HoldCause::HeartbeatLost)),
    (RUNNING, |c| c.wanted == Wanted::Nothing, State::Holding(HoldCause::NoReference)),
    (RUNNING, |c| c.wanted == Wanted::NoRoom, State::Holding(HoldCause::NoRoom { joint: 1 })),
    (RUNNING, Case::far, State::Holding(HoldCause::OutOfReach { joint: 1 })),
    (ARMED, |c| !c.arming() && c.silent(), State::Holding(HoldCause::HeartbeatLost)),
    (ARMING, |c| c.arming() && c.silent(), State::Idle),
    (ARMING, |c| c.arming() && c.resting() && c.age == 0, State::Armed),
];

fn expected(c: &Case) -> Expected {
    let homed = c.still_homed();
    let stop = c.request == Some(Request::Stop);
    let refused_by_fault = if stop { None } else { c.request.map(|_| 2) };
    // Latched: only a clear leaves it, and only if the cause is gone.
    if c.in_fault() {
        let beyond_meaning = matches!(c.implausible(), Some(Fault::PositionOutOfBounds { .. })) && !homed;
        let stands = !stop && c.external().is_none() && (c.implausible().is_none() || beyond_meaning);
        return match (c.request, stands, c.resting()) {
            (Some(Request::Clear), true, true) => Expected { state: State::Idle, homed, refused: None },
            (Some(Request::Clear), true, false) => Expected { state: c.from, homed, refused: Some(NOT_AT_REST) },
            _ => Expected { state: c.from, homed, refused: refused_by_fault },
        };
    }
    // Faults before requests: external faults in every state, faults of the sensors and of the host while torque acts.
    let sensed = if c.driving() || c.disarming() { c.implausible() } else { None };
    let alone = (c.too_long_alone() && !c.slow_brakes).then_some(Fault::HeartbeatLost);
    if let Some(fault) = c.external().or(sensed).or(alone) {
        return Expected { state: State::Fault(fault), homed, refused: refused_by_fault };
    }
    // Without the host the brakes engage first.
    let from = if c.too_long_alone() { State::Disarming } else { c.from };
    let (mut state, mut refused) = (from, None);
    if let Some(request) = c.request {
        let applies = |row: &&Row| row.request == request && row.from.contains(&from.code()) && (row.when)(c);
        let as_it_is = if request == Request::FullRange { Ok(from) } else { Err(NO_STATE) };
        match REQUESTS.iter().find(applies).map_or(as_it_is, |row| row.to) {
            Ok(to) => state = to,
            Err(code) => refused = Some(code),
        }
    }
    let homed = match (c.from, state) {
        (State::Idle, State::Homing) => false,
        (State::Homing, State::Idle) => homed || c.request == Some(Request::Confirm),
        _ => homed,
    };
    // On engaged brakes the readings are judged unless arming has been ended.
    if c.arming() && state == State::Arming && !c.silent() {
        let pushed = (c.measured == Measured::Pushed).then_some(Fault::FollowingError { joint: 1 });
        if let Some(fault) = c.implausible().or(pushed) {
            return Expected { state: State::Fault(fault), homed, refused: refused_by_fault };
        }
    }
    if let Some((_, _, to)) = EVENTS.iter().find(|(from, when, _)| *from == state.code() && when(c)) {
        state = *to;
    }
    if c.disarming() {
        state = c.ends_in.unwrap_or(state);
    }
    // An arm that should be at rest, but is out of reach of its reference.
    let stands = matches!(state, State::Armed | State::Holding(_) | State::Disarming);
    // A stop along the path continues from the path's reference, if the arm can follow it.
    let along = c.from == State::Running
        && matches!(state, State::Holding(HoldCause::Requested | HoldCause::HeartbeatLost))
        && c.wanted == Wanted::Far;
    if (c.driving() || c.disarming()) && stands && !along && c.measured == Measured::Pushed {
        state = State::Fault(Fault::FollowingError { joint: 1 });
    }
    if state.has_torque() || state == State::Arming {
        match c.answer {
            Answer::Torque => {}
            Answer::Brake => state = State::Fault(Fault::NonFiniteTorque { joint: 0 }),
            Answer::NotANumber => state = State::Fault(Fault::NonFiniteTorque { joint: 1 }),
        }
    }
    if is_fault(state) {
        Expected { state, homed, refused: refused_by_fault }
    } else {
        Expected { state, homed, refused }
    }
}

fn inputs(c: &Case) -> Setpoint {
    let (mut q, mut qd) = (AT, [0.0; 2]);
    match c.measured {
        Measured::Resting => {}
        // Just faster than rest, and away from the limit: not yet too fast to stop.
        Measured::Moving => qd[1] = -REST.next_up(),
        Measured::NotANumber => q[1] = f32::NAN,
        Measured::Jumped => q[1] = 0.7,
        Measured::Outside => q[1] = 2.6,
        Measured::Fast => qd[1] = -6.0_f32.next_up(),
        // Farther from its reference than allowed during a stop, but without a jump.
        Measured::Pushed => q[1] = AT[1] - 1.5 * REACH - 0.01,
    }
    let mut reference = Reference::at_rest(AT);
    match c.wanted {
        Wanted::Nothing | Wanted::Near => {}
        Wanted::OtherSpeed => reference.qd[1] = -0.31 - REST,
        Wanted::Far => reference.q[1] = AT[1] - REACH - 0.01,
        Wanted::NotANumber => reference.qdd[1] = f32::INFINITY,
        Wanted::NoRoom => reference.qd[1] = 1.5,
    }
    Inputs {
        request: c.request,
        emergency_stop: c.emergency_stop,
        overrun: c.overrun,
        heartbeat_age: c.heartbeat,
        zeroed: c.zeroed,
        on: [true; 2],
        zero_lost: false,
        live_age: 0,
        sensed: Sensed::State { q, qd },
        age_ticks: [0, c.age],
        drive_fault: [false, c.drive_fault],
        supply: Some(if c.supply_bad { SUPPLY.1.next_up() } else { SUPPLY.1 }),
        temperature: Some(if c.temperature_bad { TEMPERATURE.0.next_down() } else { TEMPERATURE.0 }),
        reference: (c.wanted != Wanted::Nothing).then_some(reference),
    }
}

/// Machines whose brakes engage within three ticks: about to be disarmed, and being disarmed because of a request or a missing host, in the
/// first and in the last tick of disarming.
fn starts_with_slow_brakes() -> Vec<Start> {
    let mut protected = config();
    protected.rules.brake_delay = 3;
    let mut armed = Machine::new(protected);
    granted(&mut armed, &calm(AT));
    for request in TO_ARMED {
        granted(&mut armed, &asked(request, &calm(AT)));
        arm(&mut armed, AT);
    }
    let mut alone = armed;
    for _ in 0..HOLD_MAX {
        granted(&mut alone, &Inputs { heartbeat_age: HEARTBEAT_MAX + 1, ..calm(AT) });
    }
    let mut starts = vec![(armed, 0, None), (alone, HOLD_MAX, None)];
    let (mut disarmed, mut lost) = (armed, alone);
    granted(&mut disarmed, &asked(Request::Disarm, &calm(AT)));
    granted(&mut lost, &Inputs { heartbeat_age: HEARTBEAT_MAX + 1, ..calm(AT) });
    for (machine, end) in [(disarmed, State::Idle), (lost, State::Fault(Fault::HeartbeatLost))] {
        let mut last = machine;
        granted(&mut last, &calm(AT));
        granted(&mut last, &calm(AT));
        assert_eq!((machine.state(), last.state()), (State::Disarming, State::Disarming));
        starts.extend([(machine, 0, None), (last, 0, Some(end))]);
    }
    starts
}

/// A machine, the number of ticks for which it has held alone, and the state in which its disarming ends in the next tick.
type Start = (Machine, u32, Option<State>);

/// Every state, with every value that the machine's own counter can have there.
fn starts() -> Vec<Start> {
    let homed = [Request::Home, Request::Confirm];
    let mut starts: Vec<(Machine, u32)> = vec![
        (after(&[], AT), 0),
        (after(&homed, AT), 0),
        (after(&[Request::Home], AT), 0),
        (after(&TO_ARMED, AT), 0),
        (after(&TO_RUNNING, AT), 0),
        (after(&[Request::Home, Request::Confirm, Request::Arm, Request::Run, Request::Hold], AT), 0),
    ];
    // Holding without the host, for 1 tick up to the longest time.
    let mut alone = after(&TO_RUNNING, AT);
    for ticks in 1..=HOLD_MAX {
        granted(&mut alone, &Inputs { heartbeat_age: HEARTBEAT_MAX + 1, ..calm(AT) });
        assert_eq!(alone.state(), State::Holding(HoldCause::HeartbeatLost));
        starts.push((alone, ticks));
    }
    // Faults, homed and not homed: by a stop request, and by a jump that cleared the homing.
    for requests in [&homed[..], &[]] {
        let mut stopped = after(requests, AT);
        stopped.tick(&Inputs { emergency_stop: true, ..calm(AT) }, |_| wanting(0.0));
        starts.push((stopped, 0));
    }
    let mut arming = after(&homed, AT);
    granted(&mut arming, &asked(Request::Arm, &calm(AT)));
    // The tick after this one would open the brakes.
    let mut next = arming;
    while granted(&mut next, &calm(AT)).state == State::Arming {
        arming = next;
    }
    starts.push((arming, 0));
    let mut jumped = after(&TO_RUNNING, AT);
    jumped.tick(&calm([0.5, -1.9]), |_| wanting(0.0));
    jumped.tick(&calm(AT), |_| wanting(0.0));
    jumped.tick(&calm(AT), |_| wanting(0.0));
    starts.push((jumped, 0));
    let starts = starts.into_iter().map(|(machine, alone)| (machine, alone, None));
    starts.chain(starts_with_slow_brakes()).collect()
}

#[test]
fn every_transition_is_the_table_s_and_breaks_no_rule() {
    const BOTH: [bool; 2] = [false, true];
    let requests = [None]
        .into_iter()
        .chain([
            Some(Request::Home),
            Some(Request::Confirm),
            Some(Request::Arm),
            Some(Request::Disarm),
            Some(Request::Run),
            Some(Request::Hold),
            Some(Request::Clear),
            Some(Request::Stop),
            Some(Request::FullRange),
        ])
        .collect::<Vec<_>>();
    let measured = [
        Measured::Resting,
        Measured::Moving,
        Measured::NotANumber,
        Measured::Jumped,
        Measured::Outside,
        Measured::Fast,
        Measured::Pushed,
    ];
    let wanted = [Wanted::Nothing, Wanted::Near, Wanted::OtherSpeed, Wanted::Far, Wanted::NotANumber, Wanted::NoRoom];
    let edges = |limit: u32| [0, limit - 1, limit, limit + 1, u32::MAX];
    let (mut cases, mut reached, mut refusals) = (0_u64, BTreeSet::new(), BTreeSet::new());
    for (start, alone, ends_in) in starts() {
        for bits in 0..64_u32 {
            let bit = |i: u32| BOTH[(bits >> i & 1) as usize];
            for request in &requests {
                for measured in measured {
                    for age in edges(AGE_MAX) {
                        for heartbeat in edges(HEARTBEAT_MAX) {
                            for wanted in wanted {
                                for answer in [Answer::Torque, Answer::Brake, Answer::NotANumber] {
                                    let case = Case {
                                        from: start.state(),
                                        homed: start.homed(),
                                        alone,
                                        slow_brakes: start.rules().brake_delay > 0,
                                        ends_in,
                                        request: *request,
                                        emergency_stop: bit(0),
                                        overrun: bit(1),
                                        drive_fault: bit(2),
                                        supply_bad: bit(3),
                                        temperature_bad: bit(4),
                                        zeroed: bit(5),
                                        measured,
                                        age,
                                        heartbeat,
                                        wanted,
                                        answer,
                                    };
                                    let state = check(&start, &case, &mut refusals);
                                    reached.insert((case.from.code(), state.code()));
                                    cases += 1;
                                }
                            }
                        }
                    }
                }
            }
        }
    }
    // 13 starts and 6 with slow brakes, 64 combinations, 10 requests, 7 measurements, 5 ages, 5 silences, 6 references, 3 answers.
    assert_eq!(cases, (13 + 6) * 64 * 10 * 7 * 5 * 5 * 6 * 3);
    let from = |state: u8| reached.iter().filter(|(from, _)| *from == state).map(|(_, to)| *to).collect::<Vec<_>>();
    assert_eq!(from(IDLE), [0, 1, 5, 6]);
    assert_eq!(from(ARMING), [0, 2, 5, 6]);
    assert_eq!(from(HOMING), [0, 1, 5]);
    assert_eq!(from(ARMED), [0, 2, 3, 4, 5, 8]);
    assert_eq!(from(RUNNING), [3, 4, 5]);
    assert_eq!(from(HOLDING), [0, 3, 4, 5, 8]);
    assert_eq!(from(DISARMING), [0, 5, 8]);
    assert_eq!(from(5), [0, 5]);
    assert_eq!(refusals.into_iter().collect::<Vec<_>>(), (1..=10).collect::<Vec<_>>());
}

fn check(start: &Machine, case: &Case, refusals: &mut BTreeSet<u8>) -> State {
    let mut machine = *start;
    let inputs = inputs(case);
    let mut calls = 0;
    let output = machine.tick(&inputs, |_| {
        calls += 1;
        match case.answer {
            Answer::Torque => wanting(30.0),
            Answer::Brake => Command::Brake(Fault::NonFiniteTorque { joint: 0 }),
            Answer::NotANumber => Command::Drive { torque: [1.0, f32::NAN], limits: [LimitFlags::NONE; 2] },
        }
    });
    let found =
        Expected { state: output.state, homed: output.homed, refused: output.refused.map(|refusal| refusal.code()) };
    assert_eq!(found, expected(case), "{case:?}");
    assert_eq!((machine.state(), machine.homed()), (output.state, output.homed));
    // The controller is called once if torque may act, and not otherwise.
    let may = case.answer == Answer::Torque && (output.state.has_torque() || output.state == State::Arming);
    assert!(calls <= 1 && (!may || calls == 1), "{case:?}: asked {calls} times");
    let acts = start.state().has_torque() || start.state() == State::Arming;
    let acted = if acts { [1.0; 2] } else { [0.0; 2] };
    let mut watch = Watch::from(start, AT, acted, case.alone);
    assert_eq!(watch.broken(&inputs, &output), None, "{case:?}: {output:?}");
    if let Some(refusal) = output.refused {
        refusals.insert(refusal.code());
    }
    output.state
}

/// Every safe action is passed on as configured.
#[test]
fn the_safe_action_is_the_robot_s() {
    for action in [SafeAction::Brake, SafeAction::DampedStop, SafeAction::Off] {
        let mut protected = config();
        protected.rules.safe_action = action;
        let mut machine = Machine::new(protected);
        let output = machine.tick(&Inputs { emergency_stop: true, ..calm(AT) }, |_| panic!("asked for torque"));
        assert_eq!(output.actuation, Actuation::Safe(action));
        assert_eq!(output.state, State::Fault(Fault::EmergencyStop));
    }
}
