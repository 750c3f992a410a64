//! Random sequences of thousands of ticks with every possible disturbance, and machines with one broken rule. The independent checker must find
//! nothing in the first, and the broken rule in each of the others.

use crate::safety::support::*;
use crate::safety::watch::Watch;
use dynamics_core::control::LimitFlags;
use dynamics_core::safety::{Actuation, HoldCause, Inputs, Protected, Request, SafeAction, State};
use dynamics_core::{Command, Fault, Reference, Sensed};
use proptest::prelude::{Just, Strategy, any, prop_oneof};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

/// Event of one tick, for a host that wants to run and an arm that follows.
#[derive(Clone, Copy, Debug)]
enum Event {
    Nothing,
    Ask(Request),
    EmergencyStop,
    Overrun,
    Silence(u32),
    Age(usize, u32),
    Position(usize, f32),
    Velocity(usize, f32),
    Shift(usize, f32),
    DriveFault(usize),
    Supply(f32),
    Temperature(f32),
    NotZeroed,
    NoReference,
    Reference(usize, usize, f32),
    Speed(usize, f32),
    Torque(f32),
    Brake(u8),
}

fn wild() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => any::<u32>().prop_map(f32::from_bits),
        3 => -3.0_f32..3.0,
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::NEG_INFINITY),
    ]
}

fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        Just(Request::Home),
        Just(Request::Confirm),
        Just(Request::Arm),
        Just(Request::Disarm),
        Just(Request::Run),
        Just(Request::Hold),
        Just(Request::Clear),
        Just(Request::Stop),
        Just(Request::FullRange),
    ]
}

fn event() -> impl Strategy<Value = Event> {
    let rare = prop_oneof![
        3 => request().prop_map(Event::Ask),
        1 => Just(Event::EmergencyStop),
        1 => Just(Event::Overrun),
        3 => prop_oneof![1..20_u32, any::<u32>()].prop_map(Event::Silence),
        2 => (0..2_usize, prop_oneof![0..5_u32, any::<u32>()]).prop_map(|(i, age)| Event::Age(i, age)),
        2 => (0..2_usize, wild()).prop_map(|(i, x)| Event::Position(i, x)),
        2 => (0..2_usize, prop_oneof![wild(), -8.0_f32..8.0]).prop_map(|(i, x)| Event::Velocity(i, x)),
        2 => (0..2_usize, -1.5_f32..1.5).prop_map(|(i, x)| Event::Shift(i, x)),
        1 => (0..2_usize).prop_map(Event::DriveFault),
        1 => prop_oneof![wild(), 15.0_f32..35.0].prop_map(Event::Supply),
        1 => prop_oneof![wild(), -50.0_f32..150.0].prop_map(Event::Temperature),
        3 => Just(Event::NotZeroed),
        1 => Just(Event::NoReference),
        3 => (0..3_usize, 0..2_usize, wild()).prop_map(|(row, i, x)| Event::Reference(row, i, x)),
        3 => (0..2_usize, -4.0_f32..4.0).prop_map(|(i, v)| Event::Speed(i, v)),
        4 => prop_oneof![wild(), -20.0_f32..20.0].prop_map(Event::Torque),
        1 => (1..8_u8).prop_map(Event::Brake),
    ];
    prop_oneof![40 => Just(Event::Nothing), 1 => rare]
}

/// A rule that is broken on purpose, in a wrapper around a correct machine.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Broken {
    /// None: the machine unchanged.
    No,
    Homing,
    Rest,
    Measurement,
    Age,
    Jump,
    TorqueLimit,
    TorqueRate,
    Ramp,
    Room,
    Reach,
    Standing,
    Silence,
    HoldTime,
    EmergencyStop,
    Overrun,
    DriveFault,
    Supply,
    Temperature,
    Latch,
    IdleDrives,
    OtherAction,
}

/// Each broken rule, and the numbers of the rules of which the checker must find one first.
const BROKEN: [(Broken, &[&str]); 21] = [
    (Broken::Homing, &["1"]),
    (Broken::Rest, &["1", "15"]),
    (Broken::Measurement, &["2", "15"]),
    (Broken::Age, &["2"]),
    (Broken::Jump, &["3"]),
    (Broken::TorqueLimit, &["4"]),
    (Broken::TorqueRate, &["4", "7"]),
    (Broken::Ramp, &["7"]),
    (Broken::Room, &["6"]),
    (Broken::Reach, &["8", "17"]),
    (Broken::Standing, &["17"]),
    (Broken::Silence, &["9"]),
    (Broken::HoldTime, &["9"]),
    (Broken::EmergencyStop, &["10"]),
    (Broken::Overrun, &["11"]),
    (Broken::DriveFault, &["12"]),
    (Broken::Supply, &["13"]),
    (Broken::Temperature, &["14"]),
    (Broken::Latch, &["15"]),
    (Broken::IdleDrives, &["16"]),
    (Broken::OtherAction, &["16"]),
];

/// The machine's numbers, without the one that the broken rule compares with.
fn numbers(broken: Broken) -> Protected<f32, 2> {
    let mut p = config();
    for joint in &mut p.rules.joints {
        match broken {
            Broken::Rest => joint.rest_speed = f32::MAX,
            Broken::Jump => joint.jump_step = f32::MAX,
            Broken::Room => joint.deceleration = 1e9,
            Broken::Reach => joint.reach = f32::MAX,
            _ => {}
        }
    }
    match broken {
        Broken::Age => p.control.age_max = u32::MAX,
        Broken::TorqueLimit => p.control.limits.iter_mut().for_each(|limits| limits.torque = f32::INFINITY),
        Broken::TorqueRate => p.control.torque_step = [f32::INFINITY; 2],
        Broken::Silence => p.rules.heartbeat_max = u32::MAX,
        Broken::HoldTime => p.rules.hold_max = u32::MAX,
        Broken::Supply => p.rules.supply = (f32::NEG_INFINITY, f32::INFINITY),
        Broken::Temperature => p.rules.temperature = (f32::NEG_INFINITY, f32::INFINITY),
        Broken::OtherAction => p.rules.safe_action = SafeAction::Off,
        _ => {}
    }
    p
}

struct World {
    machine: Machine,
    broken: Broken,
    watch: Watch,
    q: [f32; 2],
    reference: Reference<f32, 2>,
    speed: [f32; 2],
    silent_for: u32,
    armed: [f32; 2],
}

impl World {
    fn new(broken: Broken) -> Self {
        let q = [0.3, -0.4];
        Self {
            machine: Machine::new(numbers(broken)),
            broken,
            watch: Watch::new(),
            q,
            reference: Reference::at_rest(q),
            speed: [0.0; 2],
            silent_for: 0,
            armed: q,
        }
    }

    /// Request of a host that wants the arm to run.
    fn next(&self) -> Option<Request> {
        match self.machine.state() {
            State::Idle if self.machine.homed() => Some(Request::Arm),
            State::Idle => Some(Request::Home),
            State::Homing => Some(Request::Confirm),
            State::Armed | State::Holding(_) => Some(Request::Run),
            State::Running | State::Arming | State::Lowering | State::Disarming => None,
            State::Fault(_) => Some(Request::Clear),
        }
    }

    /// Inputs of a tick and the controller's answer.
    fn inputs(&mut self, tick: usize, event: Event) -> (Setpoint, Command<f32, 2>) {
        let (mut q, mut qd) = (self.q, self.reference.qd);
        let mut told = calm(q);
        let mut answer = wanting((tick as f32 * 0.05).sin() * 12.0);
        // The host sends requests slowly, so that every state lasts a while.
        told.request = if tick % 4 == 3 { self.next() } else { None };
        self.silent_for = self.silent_for.saturating_sub(1);
        let mut reference = Some(self.reference);
        match event {
            Event::Nothing => {}
            Event::Ask(request) => told.request = Some(request),
            Event::EmergencyStop => told.emergency_stop = true,
            Event::Overrun => told.overrun = true,
            Event::Silence(age) => self.silent_for = age.min(15),
            Event::Age(i, age) => told.age_ticks[i] = age,
            Event::Position(i, x) => q[i] = x,
            Event::Velocity(i, x) => qd[i] = x,
            // From now on the arm really is there: it was moved, or its encoder slipped.
            Event::Shift(i, x) => {
                self.q[i] = (self.q[i] + x).clamp(-2.4, 2.4);
                q = self.q;
            }
            Event::DriveFault(i) => told.drive_fault[i] = true,
            Event::Supply(x) => told.supply = Some(x),
            Event::Temperature(x) => told.temperature = Some(x),
            Event::NotZeroed => told.zeroed = false,
            Event::NoReference => reference = None,
            Event::Reference(row, i, x) => {
                let mut odd = self.reference;
                [&mut odd.q, &mut odd.qd, &mut odd.qdd][row][i] = x;
                reference = Some(odd);
            }
            Event::Speed(i, v) => self.speed[i] = v,
            Event::Torque(x) => answer = Command::Drive { torque: [1.0, x], limits: [LimitFlags::NONE; 2] },
            Event::Brake(code) => answer = Command::Brake(Fault::from_code(code, 1).unwrap()),
        }
        told.heartbeat_age = if self.silent_for > 0 { HEARTBEAT_MAX + 1 } else { tick as u32 % (HEARTBEAT_MAX + 1) };
        told.sensed = Sensed::State { q, qd };
        told.reference = reference;
        (told, answer)
    }

    /// Moves the arm to where the host wants it while the machine runs; otherwise it stays.
    fn move_on(&mut self, state: State) {
        for i in 0..2 {
            let wanted = if state == State::Running { self.speed[i] } else { 0.0 };
            let change = (wanted - self.reference.qd[i]).clamp(-0.05, 0.05);
            self.reference.qd[i] = if state == State::Running { self.reference.qd[i] + change } else { 0.0 };
            self.q[i] = (self.q[i] + PERIOD * self.reference.qd[i]).clamp(-2.4, 2.4);
            // The host turns back near a limit.
            if self.q[i].abs() > 1.9 && state != State::Running {
                self.speed[i] = -self.q[i].signum();
                self.q[i] = 1.5 * self.q[i].signum();
            }
        }
        self.reference.q = self.q;
    }

    /// One tick of a machine that may be broken.
    fn tick(&mut self, told: &Setpoint, answer: Command<f32, 2>) -> Said {
        let mut inner = *told;
        match self.broken {
            Broken::EmergencyStop => inner.emergency_stop = false,
            Broken::Overrun => inner.overrun = false,
            Broken::DriveFault => inner.drive_fault = [false; 2],
            Broken::Measurement => {
                let Sensed::State { mut q, qd } = told.sensed else { panic!("positions") };
                for i in 0..2 {
                    if !q[i].is_finite() {
                        q[i] = self.q[i];
                    }
                }
                inner.sensed = Sensed::State { q, qd };
            }
            Broken::Homing if !self.machine.homed() => {
                // A machine that homes the joints by itself whenever they are not homed.
                for request in [Request::Disarm, Request::Home, Request::Confirm] {
                    self.machine.tick(&Inputs { request: Some(request), zeroed: true, ..*told }, |_| answer);
                }
            }
            // A machine that clears every fault at once, even if its cause persists.
            Broken::Latch if is_fault(self.machine.state()) => {
                self.machine.tick(&asked(Request::Clear, &calm(self.q)), |_| answer);
            }
            // A machine that treats any arm at rest as one that rests where it was armed.
            Broken::Standing if self.machine.state() == State::Armed && inner.request.is_none() => {
                let Sensed::State { q, qd } = told.sensed else { panic!("positions") };
                // A plausible reading, without a jump from another plausible one.
                let near = (0..2).all(|i| (q[i] - self.armed[i]).abs() < 0.45 * JUMP && qd[i].abs() <= 6.0);
                if near && told.age_ticks == [0; 2] {
                    inner.sensed = Sensed::State { q: self.armed, qd: [0.0; 2] };
                }
            }
            _ => {}
        }
        let mut said = self.machine.tick(&inner, |_| answer);
        if said.state != State::Armed {
            self.armed = self.q;
        }
        match (self.broken, answer) {
            (Broken::Ramp, Command::Drive { torque: wanted, .. }) => {
                if let Actuation::Preload { torque, .. } = &mut said.actuation {
                    // Only from the start on: as if no torque had acted before.
                    if told.request == Some(Request::Arm) {
                        *torque = wanted.map(|x| if x.abs() <= TORQUE { x } else { 0.0 });
                    }
                }
            }
            (Broken::IdleDrives, Command::Drive { .. }) if said.state == State::Idle => {
                said.actuation = Actuation::Drive { torque: [0.0; 2], limits: [LimitFlags::NONE; 2] };
            }
            _ => {}
        }
        said
    }
}

#[derive(Debug, Default)]
struct Reached {
    states: BTreeSet<u8>,
    faults: BTreeSet<u8>,
    causes: BTreeSet<u8>,
    refusals: BTreeSet<u8>,
    limits: BTreeSet<u8>,
    ticks: u64,
    running: u64,
}

/// The broken rule that was found, if any.
fn play(events: &[Event], broken: Broken, reached: &RefCell<Reached>) -> Option<&'static str> {
    let mut world = World::new(broken);
    for (tick, event) in events.iter().enumerate() {
        let (told, answer) = world.inputs(tick, *event);
        let said = world.tick(&told, answer);
        if let Some(rule) = world.watch.broken(&told, &said) {
            return Some(rule);
        }
        let mut reached = reached.borrow_mut();
        reached.ticks += 1;
        reached.states.insert(said.state.code());
        reached.running += u64::from(said.state == State::Running);
        if let State::Fault(fault) = said.state {
            reached.faults.insert(fault.code());
        }
        if let State::Holding(cause) = said.state {
            reached.causes.insert(cause.code());
        }
        if let Some(refusal) = said.refused {
            reached.refusals.insert(refusal.code());
        }
        if let Actuation::Drive { limits, .. } = said.actuation {
            reached.limits.extend(limits.map(LimitFlags::bits));
        }
        world.move_on(said.state);
    }
    None
}

/// The same sequences every time, so that their coverage can be asserted.
fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

#[test]
fn no_sequence_of_thousands_of_ticks_breaks_a_rule() {
    let reached = RefCell::new(Reached::default());
    let outcome = runner(300).run(&proptest::collection::vec(event(), 1000..5000), |events| {
        match play(&events, Broken::No, &reached) {
            None => Ok(()),
            Some(rule) => Err(TestCaseError::fail(format!("rule {rule} is broken"))),
        }
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    // The sequences reached every state, fault, cause, refusal and limit: the checks were not vacuous.
    let reached = reached.into_inner();
    let all = |set: &BTreeSet<u8>| set.iter().copied().collect::<Vec<_>>();
    assert!(reached.ticks > 500_000 && reached.running > reached.ticks / 5, "{reached:?}");
    assert_eq!(all(&reached.states), [0, 1, 2, 3, 4, 5, 6]);
    // All but a collision, which the controller raises.
    assert_eq!(all(&reached.faults), (1..=15).filter(|code| *code != 14).collect::<Vec<_>>());
    assert_eq!(all(&reached.causes), [1, 2, 3, 4, 5]);
    assert_eq!(all(&reached.refusals), (1..=10).collect::<Vec<_>>());
    assert!([0, 1, 2, 4, 8, 12].iter().all(|limit| reached.limits.contains(limit)), "{reached:?}");
}

#[test]
fn every_broken_rule_is_found_under_its_number() {
    for (broken, rules) in BROKEN {
        let found = RefCell::new(BTreeSet::new());
        let reached = RefCell::new(Reached::default());
        let cases = Cell::new(0);
        let outcome = runner(400).run(&proptest::collection::vec(event(), 1000..5000), |events| {
            cases.set(cases.get() + 1);
            // At least sixty sequences, and more only until the fault has been found.
            if cases.get() > 60 && !found.borrow().is_empty() {
                return Ok(());
            }
            found.borrow_mut().extend(play(&events, broken, &reached));
            Ok(())
        });
        assert!(outcome.is_ok());
        let found = found.into_inner();
        assert!(!found.is_empty(), "{broken:?} was not found in {} ticks", reached.borrow().ticks);
        assert!(found.iter().all(|rule| rules.contains(rule)), "{broken:?} was found under {found:?}");
    }
}

#[test]
fn a_stop_without_the_host_ends_in_the_safe_action_after_the_stated_time() {
    let mut machine = after(&TO_RUNNING, [0.0; 2]);
    let silent = Inputs { heartbeat_age: HEARTBEAT_MAX + 1, ..calm([0.0; 2]) };
    for _ in 0..HOLD_MAX {
        assert_eq!(granted(&mut machine, &silent).state, State::Holding(HoldCause::HeartbeatLost));
    }
    let output = machine.tick(&silent, |_| panic!("asked for torque"));
    assert_eq!(output.state, State::Fault(Fault::HeartbeatLost));
    assert_eq!(output.actuation, Actuation::Safe(SafeAction::Brake));
}
