//! Tests with a brake that needs 80 ms to engage, on a joint that carries a weight.

use crate::rig::{BRAKE_DELAY, ENGAGES, FALL, H, INERTIA, Rig, WEIGHT, rules};
use actuator_model::mit::Language;
use dynamics_core::control::{ControlLaw, Fault};
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::{SafeAction, State};
use joint_io::frames::Frames;
use link::Request;

/// Disarms a joint on a board with a brake delay of `delay` ticks. Returns the number of ticks for which torque goes on, and how far the joint
/// sinks, rad.
fn disarm<F: Frames>(language: Language, delay: u32) -> (u32, f64) {
    let mut rules = rules(SafeAction::Brake);
    rules.brake_delay = delay;
    let mut rig = Rig::<F>::with_rules(language, (ControlLaw::ComputedTorque, rules), |_| {}).armed();
    let (at, mut ticks) = (rig.q, 0);
    rig.ask(Request::Disarm);
    for _ in 0..2 * BRAKE_DELAY {
        assert!(!rig.brake.0.get(), "{language:?}: its line is closed from the request on");
        ticks += u32::from(rig.joints.torque.is_some());
        rig.tick();
    }
    assert_eq!(rig.state(), State::Idle, "{language:?}");
    assert!(rig.is_off(), "{language:?}");
    (ticks, at - rig.q)
}

fn each(delay: u32) -> [(Language, (u32, f64)); 4] {
    [
        (Language::MiniCheetah, disarm::<MiniCheetah>(Language::MiniCheetah, delay)),
        (Language::Damiao, disarm::<Damiao>(Language::Damiao, delay)),
        (Language::RobStride, disarm::<RobStride>(Language::RobStride, delay)),
        (Language::MyActuator, disarm::<MyActuator>(Language::MyActuator, delay)),
    ]
}

#[test]
fn a_joint_that_is_disarmed_is_carried_until_its_brake_has_engaged() {
    for (language, (ticks, sank)) in each(BRAKE_DELAY) {
        println!("{language:?}: sank {sank:.6} rad");
        assert_eq!(ticks, BRAKE_DELAY, "{language:?}");
        assert!(sank.abs() < 0.001, "{language:?}: sank {sank} rad");
    }
    // With no delay or one that is too short, the joint falls for the rest of the time that the brake needs.
    for delay in [0, 40] {
        let left = f64::from(ENGAGES - delay) * H;
        let falls = 0.5 * WEIGHT / INERTIA * left * left;
        for (language, (_, sank)) in each(delay) {
            assert!((0.8 * falls..1.1 * falls).contains(&sank), "{language:?}, {delay}: sank {sank} rad of {falls}");
        }
    }
}

/// Presses the emergency stop, `after` ticks into disarming if that is not 0. Returns how far the joint sinks, rad.
fn stop<F: Frames>(language: Language, after: u32) -> f64 {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake).armed();
    let at = rig.q;
    if after > 0 {
        rig.ask(Request::Disarm);
        (1..after).for_each(|_| rig.tick());
    }
    rig.stop = true;
    for _ in 0..2 * BRAKE_DELAY {
        rig.tick();
        assert!(rig.joints.torque.is_none() && rig.fault() == Some(Fault::EmergencyStop), "{language:?}");
    }
    at - rig.q
}

/// After a fault no torque acts: the brake alone stops the joint, and the weight moves it until then.
#[test]
fn a_fault_lets_the_joint_fall_until_the_brake_has_engaged_and_no_farther() {
    for after in [0, 1, 30, 79] {
        for (language, sank) in [
            (Language::MiniCheetah, stop::<MiniCheetah>(Language::MiniCheetah, after)),
            (Language::Damiao, stop::<Damiao>(Language::Damiao, after)),
            (Language::RobStride, stop::<RobStride>(Language::RobStride, after)),
            (Language::MyActuator, stop::<MyActuator>(Language::MyActuator, after)),
        ] {
            let left = f64::from(ENGAGES - after) * H;
            let falls = FALL * left * left / (f64::from(ENGAGES) * H).powi(2);
            println!("{language:?}, after {after} ticks: sank {sank:.5} rad");
            assert!(
                sank < 1.05 * falls + 0.001 && sank > 0.8 * falls - 0.001,
                "{language:?}, {after}: {sank} of {falls}"
            );
        }
    }
}

/// The host is lost, and the arm has no rest pose. Returns how far the joint sinks, rad.
fn lose_host<F: Frames>(language: Language) -> f64 {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake).armed();
    let at = rig.q;
    rig.host_gone = true;
    let mut disarms = 0;
    for _ in 0..1000 {
        rig.tick();
        disarms += u32::from(rig.state() == State::Disarming);
    }
    assert_eq!((rig.fault(), disarms), (Some(Fault::HeartbeatLost), BRAKE_DELAY), "{language:?}");
    at - rig.q
}

#[test]
fn a_joint_whose_host_is_gone_is_carried_until_its_brake_has_engaged() {
    for (language, sank) in [
        (Language::MiniCheetah, lose_host::<MiniCheetah>(Language::MiniCheetah)),
        (Language::Damiao, lose_host::<Damiao>(Language::Damiao)),
        (Language::RobStride, lose_host::<RobStride>(Language::RobStride)),
        (Language::MyActuator, lose_host::<MyActuator>(Language::MyActuator)),
    ] {
        assert!(sank.abs() < 0.001, "{language:?}: sank {sank} rad");
    }
}

/// With the law `split` the drives' springs keep holding the arm while its brakes engage.
#[test]
fn the_drives_own_springs_hold_the_joint_until_its_brake_has_engaged() {
    let rules = rules(SafeAction::Brake);
    let mut rig = Rig::<Damiao>::with_rules(Language::Damiao, (ControlLaw::Split, rules), |_| {}).armed();
    let stiffness = rig.electronics(|it| it.told().kp);
    assert!(stiffness > 100.0, "{stiffness}");
    rig.ask(Request::Disarm);
    for _ in 1..BRAKE_DELAY {
        assert_eq!(rig.electronics(|it| it.told().kp), stiffness);
        rig.tick();
    }
    rig.tick();
    assert_eq!(rig.state(), State::Idle);
}
