//! Lowering without a host, on simulated joints: one hits a stop, one is held by a hand, one carries an undeclared payload.

use crate::safety::support::*;
use dynamics_core::control::{ControlLaw, Controller, ControllerOf, Fault};
use dynamics_core::safety::{Actuation, Inputs, Protected, SafeAction, State};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Reference, Sensed};

/// Torque limit, N m: far above what any bound here allows.
const STRONG: f32 = 200.0;
/// Longest hold without a host, ticks; also the longest wait.
const HOLD: u32 = 300;
/// Position in which the arm is left, and the pose to which it is lowered, rad.
const FROM: [f32; 2] = [1.0, 0.5];
const TO: [f32; 2] = [-0.5, 0.0];
/// Speed of lowering, rad/s, and its duration without an obstacle, ticks.
const SPEED: f32 = 0.2;
const NOMINAL: u32 = 7_540;
/// Stiffness of the control law on unit masses, N m/rad, and its damping, N m s/rad.
const STIFFNESS: f32 = 400.0;
const DAMPING: f32 = 40.0;

/// Two unit masses, each under its weight, and everything that acts on the first of them.
struct World {
    machine: Machine,
    inside: ControllerOf<f32, 2, Weights, Polynomial, Protected<f32, 2>>,
    q: [f64; 2],
    qd: [f64; 2],
    /// Torque of an undeclared payload, with the arm horizontal, N m.
    payload: f64,
    /// Position of the stop below which the first joint cannot go, rad.
    stop: f64,
    /// True if a hand holds the first joint where it is.
    held: bool,
    reference: Reference<f32, 2>,
    /// Greatest torque with which the first joint has pushed against a stop or a hand, N m.
    push: f64,
    /// Greatest speed upwards, rad/s.
    up: f64,
    tick: u32,
}

impl World {
    /// An armed arm that has just heard its host for the last time.
    fn left_alone(change: impl FnOnce(&mut Protected<f32, 2>)) -> Self {
        let mut config = config();
        assert_eq!(config.control.law, ControlLaw::ComputedTorque);
        for limits in &mut config.control.limits {
            limits.torque = STRONG;
        }
        config.rules.rest = Some(TO);
        config.rules.hold_max = HOLD;
        config.rules.safe_action = SafeAction::DampedStop;
        change(&mut config);
        let mut world = Self {
            machine: Machine::new(config),
            inside: Controller::new(config, Weights, Polynomial),
            q: FROM.map(f64::from),
            qd: [0.0; 2],
            payload: 0.0,
            stop: f64::NEG_INFINITY,
            held: true,
            reference: Reference::at_rest(FROM),
            push: 0.0,
            up: 0.0,
            tick: 0,
        };
        // Something holds the arm until it is armed.
        for request in TO_ARMED {
            world.step(Some(request), true);
        }
        while world.machine.state() == State::Arming {
            world.step(None, true);
        }
        assert_eq!(world.machine.state(), State::Armed);
        (world.held, world.push, world.up) = (false, 0.0, 0.0);
        world
    }

    fn step(&mut self, request: Option<dynamics_core::safety::Request>, host: bool) {
        self.tick += 1;
        let heartbeat_age = if host { 0 } else { HEARTBEAT_MAX + 1 };
        let (q, qd) = (self.q.map(|x| x as f32), self.qd.map(|x| x as f32));
        let told = Inputs { request, heartbeat_age, sensed: Sensed::State { q, qd }, ..calm(q) };
        let Self { machine, inside, reference, .. } = self;
        let output = machine.tick(&told, |ask| {
            *reference = *ask.reference;
            ask.of(inside)
        });
        let torque = match output.actuation {
            Actuation::Drive { torque, .. } => Some(torque),
            _ => None,
        };
        let engaged = matches!(
            output.actuation,
            Actuation::Preload { .. } | Actuation::Enable(SafeAction::Brake) | Actuation::Safe(SafeAction::Brake)
        );
        if engaged {
            self.qd = [0.0; 2];
            return;
        }
        for i in 0..2 {
            for _ in 0..10 {
                let given = torque.map_or(-DAMPING as f64 * self.qd[i], |torque| f64::from(torque[i]));
                let carried = if i == 0 { self.payload * self.q[i].cos() } else { 0.0 };
                let net = given - f64::from(WEIGHT) - carried;
                self.qd[i] += net * 1e-4;
                self.q[i] += self.qd[i] * 1e-4;
                if i == 0 && self.held {
                    (self.q[i], self.qd[i]) = (self.q[i] - self.qd[i] * 1e-4, 0.0);
                    self.push = self.push.max(net.abs());
                } else if i == 0 && self.q[i] <= self.stop {
                    (self.q[i], self.qd[i]) = (self.stop, self.qd[i].max(0.0));
                    self.push = self.push.max(-net);
                }
                if i == 0 {
                    self.up = self.up.max(self.qd[i]);
                }
            }
        }
    }

    /// Number of ticks without a host until torque ends, and the fault that ends it.
    fn until_let_go(&mut self) -> (u32, Fault) {
        let began = self.tick;
        loop {
            self.step(None, false);
            if let State::Fault(fault) = self.machine.state() {
                return (self.tick - began, fault);
            }
            assert!(self.tick - began < 70_000, "it never ends");
        }
    }
}

/// Number of ticks of holding before the arm is lowered.
const BEFORE: u32 = HOLD + 2;

#[test]
fn an_arm_with_nothing_in_its_way_is_lowered_in_the_nominal_time() {
    let mut world = World::left_alone(|_| {});
    let (ticks, fault) = world.until_let_go();
    assert_eq!(fault, Fault::HeartbeatLost);
    assert!((NOMINAL - 20..NOMINAL + 200).contains(&(ticks - BEFORE)), "{ticks}");
    assert!((world.q[0] - f64::from(TO[0])).abs() < 0.01 && world.up < 1e-3, "{:?}, {}", world.q, world.up);
}

/// The torque against an obstacle follows from a lag of half of `reach`, the distance in which the reference comes to rest, and the
/// speed that the joint lost at the stop.
#[test]
fn an_obstacle_is_pushed_with_a_bounded_torque_for_a_bounded_time() {
    for stop in [0.95, 0.5, 0.0, -0.3] {
        let mut world = World::left_alone(|_| {});
        world.stop = stop;
        let (ticks, fault) = world.until_let_go();
        let (way, slowing) = (0.5 * REACH, SPEED * SPEED / DECELERATION);
        let bound = f64::from(STIFFNESS * (way + slowing) + DAMPING * SPEED);
        println!("stop at {stop}: {:.1} of {bound:.1} N m, {} ticks", world.push, ticks - BEFORE);
        assert_eq!(fault, Fault::FollowingError { joint: 0 }, "{stop}");
        assert!(world.push <= bound && world.push > 0.5 * bound, "{stop}: {} N m of {bound}", world.push);
        // The path to the stop, half a reach at half the pace or more, and the wait.
        let path = (f64::from(FROM[0]) - stop + f64::from(REACH)) / f64::from(SPEED);
        let most = (path * 1000.0) as u32 + HOLD + 100;
        assert!(ticks - BEFORE <= most, "{stop}: {ticks} of {most}");
        // After torque ends, the joint rests on the stop.
        for _ in 0..500 {
            world.step(None, false);
        }
        assert!((world.q[0] - stop).abs() < 1e-6, "{stop}: {}", world.q[0]);
    }
}

#[test]
fn an_arm_that_a_hand_holds_waits_and_goes_on_when_it_lets_go() {
    for (from, ticks, goes_on) in [(2_000, 500, true), (5_000, 700, true), (2_000, 2_000, false)] {
        let mut world = World::left_alone(|_| {});
        let mut fastest = 0.0_f32;
        let mut last = world.reference.q[0];
        let end = loop {
            let since = world.tick;
            world.held = (from..from + ticks).contains(&since);
            world.step(None, false);
            // The last two ticks' path is one step.
            if world.machine.state() == State::Lowering && world.reference.q[0] != TO[0] {
                fastest = fastest.max((world.reference.q[0] - last).abs() / PERIOD);
                last = world.reference.q[0];
            }
            if let State::Fault(fault) = world.machine.state() {
                break fault;
            }
            assert!(world.tick < 60_000);
        };
        // The joint comes back to its reference, which never exceeds its speed.
        assert!(fastest <= SPEED * 1.01, "{fastest} rad/s");
        if goes_on {
            assert_eq!(end, Fault::HeartbeatLost, "{from}, {ticks}");
            let most = 2 * NOMINAL + HOLD;
            assert!((world.q[0] - f64::from(TO[0])).abs() < 0.01 && world.tick < most, "{:?}, {}", world.q, world.tick);
        } else {
            assert_eq!(end, Fault::FollowingError { joint: 0 });
        }
    }
}

/// A hand holds the arm for this many ticks, and lets go. Returns the greatest speed after that, rad/s, the torque against
/// the hand when it lets go, N m, and the fault at the end.
fn let_go_after(ticks: u32, change: impl FnOnce(&mut Protected<f32, 2>)) -> (f64, f64, Fault) {
    let mut world = World::left_alone(change);
    let (mut fastest, mut push) = (0.0_f64, 0.0);
    loop {
        world.held = (2_000..2_000 + ticks).contains(&world.tick);
        if world.held {
            world.push = 0.0;
        }
        world.step(None, false);
        if world.held {
            push = world.push;
        } else if world.tick > 2_000 {
            fastest = fastest.max(world.qd[0].abs());
        }
        if let State::Fault(fault) = world.machine.state() {
            return (fastest, push, fault);
        }
    }
}

/// The reference is drawn back to a third of `reach`: from there the arm follows with the speed of a critically damped joint, `lag w / e`.
#[test]
fn an_arm_that_waited_does_not_lurch_when_the_obstacle_goes() {
    let (frequency, third) = (f64::from(STIFFNESS).sqrt(), f64::from(REACH) / 3.0);
    let bound = third * frequency / core::f64::consts::E + f64::from(SPEED);
    for ticks in [760, 800] {
        let (fastest, push, end) = let_go_after(ticks, |_| {});
        println!("{ticks}: {fastest:.3} of {bound:.3} rad/s, {push:.1} N m");
        assert_eq!(end, Fault::HeartbeatLost, "{ticks}");
        assert!(fastest < bound, "{ticks}: {fastest} of {bound} rad/s");
        assert!(push < 1.02 * f64::from(STIFFNESS) * third, "{ticks}: {push} N m");
    }
}

/// The speed limit of the first motion does not drop an arm that is lowered, because the arm follows its own slow reference.
#[test]
fn an_arm_in_its_first_motion_is_lowered_after_an_obstacle_too() {
    // This is below the speed with which the arm comes back to its reference.
    let first = |config: &mut Protected<f32, 2>| {
        config.rules.first_motion = Some(0.2);
        for guard in &mut config.control.guard {
            guard.velocity_max = 1.5;
        }
    };
    for ticks in [500, 780] {
        let (fastest, _, end) = let_go_after(ticks, first);
        assert!(fastest > 0.2 * 1.5, "{ticks}: {fastest} rad/s is no case");
        assert_eq!(end, Fault::HeartbeatLost, "{ticks}");
    }
}

/// Waits add up: holding the arm again and again does not keep it in the air.
#[test]
fn all_waits_together_have_an_end() {
    let mut world = World::left_alone(|_| {});
    let end = loop {
        world.held = world.tick % 1_000 > 300 && world.tick > 1_000;
        world.step(None, false);
        if let State::Fault(fault) = world.machine.state() {
            break fault;
        }
    };
    assert_eq!(end, Fault::FollowingError { joint: 0 });
    assert!(world.tick < 2 * NOMINAL + HOLD, "{}", world.tick);
}

/// An undeclared payload makes the joint lag by its torque over the stiffness. With a lag up to half of `reach` the arm reaches its rest pose.
#[test]
fn an_undeclared_payload_is_lowered_or_let_go_in_time_without_a_bounce() {
    for (payload, end) in [
        // 1 kg at 0.5 m.
        (5.0, Fault::HeartbeatLost),
        (30.0, Fault::HeartbeatLost),
        // A lag of 0.15 rad with the arm horizontal.
        (60.0, Fault::FollowingError { joint: 0 }),
        (110.0, Fault::FollowingError { joint: 0 }),
    ] {
        let mut world = World::left_alone(|_| {});
        // The payload is applied slowly, while the arm holds.
        while world.machine.state() != State::Lowering {
            world.payload = payload * f64::from(world.tick.min(200)) / 200.0;
            world.step(None, false);
        }
        world.up = 0.0;
        let (ticks, fault) = world.until_let_go();
        println!("{payload} N m: {fault:?} after {ticks} ticks at {:.3} rad, up at {:.4} rad/s", world.q[0], world.up);
        assert_eq!(fault, end, "{payload}");
        assert!(ticks <= 2 * NOMINAL + 2 * HOLD, "{payload}: {ticks}");
        assert!(world.up < 0.02, "{payload}: up at {} rad/s", world.up);
    }
}

/// A payload beyond the torque limit moves ahead of the reference: torque ends, and the arm is damped, before the joint is fast.
#[test]
fn a_payload_that_is_too_heavy_ends_in_the_safe_action_without_a_bounce() {
    let mut world = World::left_alone(|config| {
        for limits in &mut config.control.limits {
            limits.torque = 20.0;
        }
    });
    // At 1 rad it takes 17.3 N m, at 0.9 rad more than 20.
    while world.machine.state() != State::Lowering {
        world.payload = 21.0 * f64::from(world.tick.min(200)) / 200.0;
        world.step(None, false);
    }
    (world.up, world.qd) = (0.0, [0.0; 2]);
    let (ticks, fault) = world.until_let_go();
    println!(
        "{fault:?} after {ticks} ticks at {:.3} rad and {:.3} rad/s, up at {:.4} rad/s",
        world.q[0], world.qd[0], world.up
    );
    assert_eq!(fault, Fault::FollowingError { joint: 0 });
    // It falls by one and a half times its reach, with at most 7 N m missing.
    let fall = (2.0 * 7.0 * 1.5 * f64::from(REACH)).sqrt();
    assert!(ticks < 2 * NOMINAL + HOLD && world.up < 0.02 && world.qd[0] > -fall);
    let fastest = world.qd[0];
    for _ in 0..300 {
        world.step(None, false);
        assert!(world.qd[0] <= 0.0 && world.qd[0] >= fastest - 0.1, "{}", world.qd[0]);
    }
}

/// At a high rate, the first step of a joint with a low deceleration is less than a rounding error. This must not count as being at the rest pose.
#[test]
fn a_first_step_that_is_too_small_does_not_end_in_a_jump_to_the_rest_pose() {
    let mut world = World::left_alone(|config| {
        for joint in &mut config.rules.joints {
            (joint.deceleration, joint.lowering_speed) = (0.05, 0.2);
        }
    });
    let mut last = FROM[0];
    for _ in 0..2_000 {
        world.step(None, false);
        let now = world.reference.q[0];
        assert!((now - last).abs() <= SPEED * PERIOD * 1.01, "from {last} to {now}");
        last = now;
    }
    assert_eq!(world.machine.state(), State::Lowering);
}

/// However long the arm may hold without a host, it presses against an obstacle for only half a second.
#[test]
fn an_arm_without_a_host_presses_for_half_a_second_at_most() {
    for hold in [100, 499, 5_000, 60_000] {
        let mut world = World::left_alone(|config| config.rules.hold_max = hold);
        while world.machine.state() != State::Lowering {
            world.step(None, false);
            world.tick = 0;
        }
        world.stop = 0.5;
        let mut pressed = 0;
        let end = loop {
            world.push = 0.0;
            world.step(None, false);
            pressed += u32::from(world.push > f64::from(STIFFNESS * REACH) / 3.2);
            if let State::Fault(fault) = world.machine.state() {
                break fault;
            }
            assert!(world.tick < 20_000, "{hold}");
        };
        assert_eq!(end, Fault::FollowingError { joint: 0 }, "{hold}");
        // Plus the time in which the reference goes to half of the reach, at a falling pace.
        assert!(pressed <= hold.min(500) + 400 && pressed > 100, "{hold}: {pressed}");
    }
}

/// An arm that is held just above its rest pose does not settle there.
#[test]
fn an_arm_that_does_not_settle_at_its_rest_pose_is_let_go_after_half_a_second() {
    let mut world = World::left_alone(|config| config.rules.hold_max = 5_000);
    world.stop = f64::from(TO[0]) + 0.2 * f64::from(REACH);
    let (ticks, fault) = world.until_let_go();
    assert_eq!(fault, Fault::HeartbeatLost);
    assert!(ticks < 5_000 + NOMINAL + 600, "{ticks}");
}

/// A hold request during a wait of lowering. Returns the torque against the stop some time later, N m, and the motion of the reference then, rad.
fn held_on_a_stop(payload: f64) -> (f64, f32) {
    let mut world = World::left_alone(|_| {});
    while world.machine.state() != State::Lowering {
        world.payload = payload * f64::from(world.tick.min(200)) / 200.0;
        world.step(None, false);
    }
    world.stop = if payload > 0.0 { f64::NEG_INFINITY } else { 0.5 };
    let lags = |world: &World| (f64::from(world.reference.q[0]) - world.q[0]).abs() > 0.48 * f64::from(REACH);
    while !lags(&world) {
        world.step(None, false);
    }
    assert_eq!(world.machine.state(), State::Lowering);
    world.step(Some(dynamics_core::safety::Request::Hold), true);
    let from = world.reference.q[0];
    for _ in 0..20_000 {
        world.push = 0.0;
        world.step(None, true);
    }
    assert!(matches!(world.machine.state(), State::Holding(_)), "{:?}", world.machine.state());
    (world.push, world.reference.q[0] - from)
}

#[test]
fn a_hold_while_lowering_waits_relieves_the_obstacle_and_does_not_creep() {
    let (push, moved) = held_on_a_stop(0.0);
    println!("{push:.1} N m, {moved:.3} rad");
    assert!(push < 1.02 * f64::from(STIFFNESS * REACH) / 3.0 && moved > 0.0, "{push} N m, {moved} rad");
    // A joint that sags under its payload by more than a third of the reach: it sinks for as long as lowering waits, and no farther.
    let (_, moved) = held_on_a_stop(65.0);
    println!("{moved:.3} rad");
    assert!(moved.abs() <= SPEED * PERIOD * HOLD as f32 * 1.1, "{moved} rad");
}

/// An arm with brakes that meets an obstacle while it is lowered is also held by torque until the brakes have engaged.
#[test]
fn an_arm_with_brakes_that_waited_for_too_long_is_held_until_they_have_engaged() {
    let mut world = World::left_alone(|config| {
        config.rules.safe_action = SafeAction::Brake;
        config.rules.brake_delay = 100;
    });
    world.stop = 0.5;
    let mut states: Vec<(State, u32)> = Vec::new();
    while !matches!(states.last(), Some((State::Fault(_), _))) {
        world.step(None, false);
        let state = world.machine.state();
        if states.last().is_none_or(|(last, _)| *last != state) {
            states.push((state, 0));
        }
        states.last_mut().unwrap().1 += 1;
        assert!(world.tick < 20_000, "{states:?}");
    }
    assert_eq!(states[1].0, State::Lowering, "{states:?}");
    assert_eq!(states[2..], [(State::Disarming, 100), (State::Fault(Fault::FollowingError { joint: 0 }), 1)]);
}

/// A tip speed that is too low for single precision: 5e-8 rad a tick, while half a rounding step at 1 rad is 6e-8 rad.
#[test]
fn lowering_that_cannot_move_its_reference_has_an_end() {
    for hold in [0, HOLD, 60_000] {
        let mut world = World::left_alone(|config| {
            config.rules.hold_max = hold;
            config.rules.rest = Some([1.5, FROM[1]]);
            for joint in &mut config.rules.joints {
                joint.lowering_speed = 5e-5;
            }
        });
        let (ticks, fault) = world.until_let_go();
        assert_eq!(fault, Fault::HeartbeatLost, "{hold}");
        assert!(ticks < hold + 600, "{hold}: {ticks}");
        assert!((world.reference.q[0] - FROM[0]).abs() < 1e-6, "{:?}", world.reference);
    }
}
