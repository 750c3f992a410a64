//! Tests of the drives' communication timeouts: they are set before the drives are enabled, and they stop a drive if the board fails.

use crate::rig::Rig;
use actuator_model::mit::Language;
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::SafeAction;
use joint_io::JointIo as _;
use joint_io::frames::Frames;
use session::readings::JointFaults;

fn set<F: Frames>(language: Language) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    let before = rig.electronics(|it| it.first_timeout);
    let mut ticks = 0;
    while rig.joints.inner.timeouts() != [Some(1000)] {
        rig.tick();
        ticks += 1;
        assert!(ticks < 10, "{language:?}: not read back");
    }
    println!("{language:?}: {before} s before, set within {} ticks", ticks + 5);
    assert!((rig.electronics(|it| it.timeout) - 0.05).abs() < 1e-9);
    assert!(rig.readings().faults == [JointFaults::NONE]);
    // The written value is lost at power-off, and is written again.
    rig.powered = false;
    for _ in 0..50 {
        rig.tick();
    }
    rig.restart();
    assert_eq!(rig.electronics(|it| it.timeout), before);
    for _ in 0..10 {
        rig.tick();
    }
    assert!((rig.electronics(|it| it.timeout) - 0.05).abs() < 1e-9);
}

#[test]
fn a_timeout_is_read_set_and_read_back_before_the_arm_is_armed_and_after_each_loss_of_power() {
    set::<Damiao>(Language::Damiao);
    set::<RobStride>(Language::RobStride);
}

fn at_once<F: Frames>(language: Language) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    // The drive restarts while it is enabled: its timeout is again the maker's.
    let shaft = actuator_model::mit::Shaft { position: 0.0, velocity: 0.0 };
    rig.powered = false;
    for _ in 0..20 {
        rig.tick();
    }
    rig.electronics(|it| it.restart(&shaft));
    rig.powered = true;
    let joints = &mut rig.joints.inner;
    for _ in 0..30 {
        let readings = joints.measure().unwrap();
        let timeout = rig.wire.bus.borrow().actuators[0].electronics.timeout;
        assert!(!readings.on[0] || (timeout - 0.05).abs() < 1e-9, "{language:?}: on with a timeout of {timeout} s");
        if readings.on[0] {
            return;
        }
        joints.enable(SafeAction::Brake);
        rig.wire.bus.borrow_mut().unplugged = vec![];
        rig.wire.bus.borrow_mut().serve();
    }
    panic!("{language:?}: never on");
}

#[test]
fn a_drive_does_not_count_as_on_before_its_timeout_is_set() {
    at_once::<Damiao>(Language::Damiao);
    at_once::<RobStride>(Language::RobStride);
}

fn unset<F: Frames>(language: Language) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    rig.electronics(|it| it.has_no_settings = true);
    let shaft = actuator_model::mit::Shaft { position: 0.0, velocity: 0.0 };
    rig.electronics(|it| it.restart(&shaft));
    rig.powered = false;
    for _ in 0..20 {
        rig.tick();
    }
    rig.powered = true;
    for _ in 0..60 {
        rig.tick();
        assert!(!rig.readings().on[0] && !rig.brake.0.get());
    }
    assert!(rig.fault().is_some() && rig.readings().faults == [JointFaults::TIMEOUT], "{language:?}");
}

#[test]
fn a_timeout_that_is_not_confirmed_is_a_fault_of_the_joint() {
    unset::<Damiao>(Language::Damiao);
    unset::<RobStride>(Language::RobStride);
}

/// The board of an armed joint without brakes fails during a push. Returns the number of ticks for which the drive goes on, at most 2000, and how
/// far the joint has moved by then, rad.
fn dead<F: Frames>(language: Language) -> (u32, f64) {
    let mut rig = Rig::<F>::new(language, SafeAction::Off).armed();
    rig.brakeless = true;
    rig.ticking = false;
    let at = rig.q;
    let mut ticks = 0;
    while rig.electronics(|it| it.torque()) != 0.0 && ticks < 2000 {
        rig.tick();
        ticks += 1;
    }
    (ticks, (rig.q - at).abs())
}

#[test]
fn a_drive_whose_board_has_died_gives_no_torque_after_its_timeout() {
    for (language, (ticks, way)) in [
        (Language::MiniCheetah, dead::<MiniCheetah>(Language::MiniCheetah)),
        (Language::Damiao, dead::<Damiao>(Language::Damiao)),
        (Language::RobStride, dead::<RobStride>(Language::RobStride)),
    ] {
        println!("{language:?}: torque for {ticks} ms after its board's end, {way:.5} rad until then");
        // The mini-cheetah's timeout is 0.1 s in the model; it cannot be read.
        let most = if language == Language::MiniCheetah { 101 } else { 51 };
        assert!(ticks <= most, "{language:?}: {ticks}");
    }
}

/// Without a timeout the last command acts for ever. With the drive's own (0xB3, in its ROM) the board need not know of it.
#[test]
fn a_myactuator_goes_on_for_ever_unless_its_owner_has_set_a_timeout() {
    let (ticks, _) = dead::<MyActuator>(Language::MyActuator);
    assert_eq!(ticks, 2000, "the model has no timeout");
    let mut rig = Rig::<MyActuator>::new(Language::MyActuator, SafeAction::Off);
    let shaft = actuator_model::mit::Shaft::default();
    // 100 ms.
    let frame = actuator_model::frame::Frame::standard(0x141, vec![0xb3, 0, 0, 0, 100, 0, 0, 0]);
    let answer = rig.electronics(|it| it.answer(&frame, &shaft));
    assert_eq!(answer, Some(actuator_model::frame::Frame::standard(0x241, frame.data.clone())));
    rig = rig.armed();
    (rig.brakeless, rig.ticking) = (true, false);
    for _ in 0..101 {
        rig.tick();
    }
    assert!(!rig.electronics(|it| it.gives_torque()), "it gives no torque after its own timeout");
    // It says so in a frame of its own, and that is a fault once the board runs again.
    for _ in 0..1000 {
        rig.tick();
    }
    (rig.brakeless, rig.ticking) = (false, true);
    rig.tick();
    assert!(rig.fault().is_some() && rig.readings().faults[0].contains(JointFaults::DRIVE));
    assert_eq!(MyActuator::error_text(rig.readings().errors[0]), "commands stayed out");
}
