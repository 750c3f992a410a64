//! Tests with a drive that is on and gives too little torque.

use crate::rig::{Rig, WEIGHT};
use actuator_model::mit::Language;
use dynamics_core::control::Fault;
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::{SafeAction, State};
use joint_io::can::WEAK_MAX;
use joint_io::frames::Frames;
use link::Request;
use session::readings::JointFaults;

/// Full torque of the rig's drive, N m.
const FULL: f64 = 18.0;

/// If the drive cannot carry the arm, the brakes stay engaged and arming fails. Otherwise a reference could move ahead meanwhile, and the arm would
/// jerk after it when the drive recovers.
fn armed_weak<F: Frames>(language: Language) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    rig.electronics(|it| it.torque_max = 0.2 * WEIGHT);
    rig.home();
    rig.ask(Request::Arm);
    let at = rig.q;
    for _ in 0..400 {
        assert!(!rig.brake.0.get(), "{language:?}");
        rig.tick();
    }
    assert_eq!(rig.fault(), Some(Fault::DriveFault { joint: 0 }), "{language:?}");
    // When the drive recovers, nothing moves.
    rig.electronics(|it| it.torque_max = FULL);
    for _ in 0..300 {
        rig.tick();
        assert!(!rig.brake.0.get(), "{language:?}");
    }
    assert!((rig.q - at).abs() < 1e-4, "{language:?}: {} rad", rig.q - at);
    // The fault can be cleared.
    rig.ask(Request::Clear);
    rig.ask(Request::Arm);
    for _ in 0..100 {
        rig.tick();
    }
    assert_eq!(rig.state(), State::Armed, "{language:?}");
    assert!(rig.brake.0.get(), "{language:?}");
}

#[test]
fn an_arm_whose_drive_is_on_without_its_torque_is_not_armed() {
    armed_weak::<Damiao>(Language::Damiao);
    armed_weak::<RobStride>(Language::RobStride);
}

/// The drive loses torque while the brakes are open. Returns how far the joint moves until the fault, rad, and the number of ticks.
fn loses<F: Frames>(language: Language) -> (f64, u32) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake).armed();
    let (at, mut ticks) = (rig.q, 0);
    rig.electronics(|it| it.torque_max = 0.5);
    while rig.fault().is_none() {
        rig.tick();
        ticks += 1;
        assert!(ticks < 400, "{language:?}: it is never found");
    }
    assert_eq!(rig.fault(), Some(Fault::DriveFault { joint: 0 }), "{language:?}");
    assert!(rig.readings().faults[0].contains(JointFaults::TORQUE), "{language:?}: {:?}", rig.readings().faults);
    (at - rig.q, ticks)
}

#[test]
fn a_drive_that_loses_its_torque_and_stays_on_is_found_at_once() {
    for (language, (sank, ticks)) in [
        (Language::MiniCheetah, loses::<MiniCheetah>(Language::MiniCheetah)),
        (Language::Damiao, loses::<Damiao>(Language::Damiao)),
        (Language::RobStride, loses::<RobStride>(Language::RobStride)),
        (Language::MyActuator, loses::<MyActuator>(Language::MyActuator)),
    ] {
        println!("{language:?}: {sank:.5} rad, {ticks} ticks");
        assert!(ticks <= u32::from(WEAK_MAX) + 3 && sank < 0.001, "{language:?}: {sank} rad, {ticks} ticks");
    }
}
