//! Tests of MyActuator drives, whose replies carry neither state nor error: other frames do.

use crate::rig::{ARMING, ENGAGES, Rig};
use actuator_model::frame::Frame;
use actuator_model::mit::{Language, error};
use dynamics_core::control::{Fault, Sensed};
use dynamics_core::drive::{MitDrive, MyActuator};
use dynamics_core::safety::{SafeAction, State};
use joint_io::JointIo as _;
use joint_io::frames::Frames as _;
use link::Request;
use session::readings::JointFaults;

fn rig(action: SafeAction) -> Rig<MyActuator> {
    Rig::new(Language::MyActuator, action)
}

/// The drive sends its status by itself while it has an error: function 3 of 0x20, which its owner sets.
fn reporting(rig: Rig<MyActuator>) -> Rig<MyActuator> {
    rig.electronics(|it| it.reports_errors = true);
    rig
}

/// Number of frames with this identifier and first byte that the board has sent.
fn sent(rig: &Rig<MyActuator>, id: u32, first: u8) -> usize {
    let bus = rig.wire.bus.borrow();
    bus.sent.iter().filter(|frame| frame.id == id && frame.data[0] == first).count()
}

#[test]
fn an_enabled_drive_that_reports_an_error_is_a_fault_of_the_arm() {
    for action in [SafeAction::Brake, SafeAction::DampedStop, SafeAction::Off] {
        let mut rig = reporting(rig(action)).armed();
        // It still gives its torque: only the status shows the error.
        let bits = Frame::standard(0x241, vec![0x9a, 90, 80, 1, 0xe0, 0x01, 0x00, 0x10]);
        rig.wire.bus.borrow_mut().inject(bits);
        rig.tick();
        assert_eq!(rig.fault(), Some(Fault::DriveFault { joint: 0 }), "{action:?}");
        assert!(rig.readings().faults[0].contains(JointFaults::DRIVE) && rig.readings().on == [false]);
        assert_eq!(MyActuator::error_text(rig.readings().errors[0]), "motor too hot");
        // Its replies carry no error and do not end this one.
        for _ in 0..5 {
            rig.tick();
            assert!(action == SafeAction::Off || rig.fault().is_some());
        }
    }
}

#[test]
fn a_drive_that_loses_its_torque_through_an_error_is_found_by_its_status_or_by_its_torque() {
    for reports in [false, true] {
        let mut rig = rig(SafeAction::Brake).armed();
        rig.electronics(|it| (it.reports_errors, it.error) = (reports, error::HOT));
        let mut ticks = 0;
        while rig.fault().is_none() {
            rig.tick();
            ticks += 1;
            assert!(ticks < 20, "{reports}");
        }
        // The torque is found first. The drive's status is read once it is off, and names the cause.
        for _ in 0..10 {
            rig.tick();
        }
        assert_eq!(MyActuator::error_text(rig.readings().errors[0]), "motor too hot", "{reports}");
        assert!(!rig.brake.0.get());
    }
}

#[test]
fn a_drive_with_an_error_is_not_armed() {
    let mut rig = rig(SafeAction::Brake);
    for _ in 0..ARMING {
        rig.tick();
    }
    rig.home();
    // It reports nothing by itself: the board asks before the drive gets its first torque.
    rig.electronics(|it| it.error = error::UNDER_VOLTAGE);
    rig.ask(Request::Arm);
    for _ in 0..50 {
        rig.tick();
        assert!(!rig.readings().on[0] && !rig.brake.0.get());
    }
    assert_eq!(rig.fault(), Some(Fault::DriveFault { joint: 0 }));
    assert_eq!(MyActuator::error_text(rig.readings().errors[0]), "supply voltage too low");
}

#[test]
fn an_error_that_has_gone_can_be_cleared_and_one_that_remains_cannot() {
    for action in [SafeAction::Brake, SafeAction::DampedStop, SafeAction::Off] {
        // Without its torque it may as well have restarted: only an absolute drive stays homed.
        let change = |drive: &mut MitDrive| drive.absolute = true;
        let mut rig = reporting(Rig::with(Language::MyActuator, action, change)).armed();
        rig.electronics(|it| it.error = error::HOT);
        for _ in 0..150 {
            rig.tick();
            (rig.q, rig.qd) = (0.0, 0.0);
        }
        assert!(rig.readings().errors[0] != 0 && rig.fault().is_some(), "{action:?}");
        for gone in [false, true] {
            rig.electronics(|it| it.error = if gone { 0 } else { error::HOT });
            for _ in 0..20 {
                rig.ask(Request::Clear);
                (rig.q, rig.qd) = (0.0, 0.0);
            }
            assert_eq!((rig.fault().is_none(), rig.readings().errors[0] == 0), (gone, gone), "{action:?}");
        }
        assert!(rig.session.homed(), "{action:?}");
    }
}

/// The holding brake needs 120 ms until the drive confirms its release, and the drive replies to commands meanwhile.
#[test]
fn no_torque_acts_before_the_release_of_the_holding_brake_is_confirmed() {
    let mut rig = rig(SafeAction::Brake);
    for _ in 0..ARMING {
        rig.tick();
    }
    rig.home();
    rig.electronics(|it| it.ignores_enable = true);
    rig.ask(Request::Arm);
    for _ in 0..120 {
        rig.tick();
        let told = rig.electronics(|it| it.told().torque);
        assert!(told.abs() < 0.01 && !rig.readings().on[0] && !rig.brake.0.get(), "{told} N m");
        assert_eq!(rig.state(), State::Arming);
    }
    rig.electronics(|it| it.ignores_enable = false);
    let before = sent(&rig, 0x141, 0x77);
    for _ in 0..200 {
        rig.tick();
    }
    assert!(rig.state() == State::Armed && rig.brake.0.get(), "{:?}", rig.state());
    assert_eq!((before, sent(&rig, 0x141, 0x77)), (1, 2), "sent again once it counts as lost");
}

/// Ticks from the request to arm to the first frame that reads the status, which follows the confirmed release; `None` if there is none in 400.
fn confirmed_after(rig: &mut Rig<MyActuator>) -> Option<u32> {
    let before = sent(rig, 0x141, 0x9a);
    rig.ask(Request::Arm);
    (1..400).find(|_| {
        rig.tick();
        sent(rig, 0x141, 0x9a) > before
    })
}

#[test]
fn a_release_is_sent_once_and_its_answer_may_take_long() {
    for action in [SafeAction::Brake, SafeAction::DampedStop, SafeAction::Off] {
        let mut rig = rig(action);
        for _ in 0..ARMING {
            rig.tick();
        }
        rig.home();
        rig.electronics(|it| it.release_time = 0.12);
        let (releases, after) = (sent(&rig, 0x141, 0x77), confirmed_after(&mut rig).unwrap());
        assert!((115..130).contains(&after), "{action:?}: {after} ticks");
        assert_eq!(sent(&rig, 0x141, 0x77) - releases, 1, "{action:?}");
    }
}

#[test]
fn the_late_answer_to_an_earlier_release_confirms_nothing() {
    for action in [SafeAction::Brake, SafeAction::DampedStop] {
        let mut rig = rig(action);
        for _ in 0..ARMING {
            rig.tick();
        }
        rig.home();
        rig.electronics(|it| it.release_time = 0.12);
        rig.ask(Request::Arm);
        for _ in 0..40 {
            rig.tick();
        }
        rig.ask(Request::Disarm);
        assert_eq!(rig.state(), State::Idle);
        for _ in 0..5 {
            rig.tick();
        }
        let after = confirmed_after(&mut rig).unwrap();
        assert!((115..130).contains(&after), "{action:?}: its own answer comes after 120 ticks, not {after}");
    }
}

#[test]
fn an_error_that_nobody_has_seen_is_read_when_errors_are_cleared() {
    let mut rig = rig(SafeAction::DampedStop).armed();
    rig.electronics(|it| it.error = error::HOT);
    while rig.fault().is_none() {
        rig.tick();
    }
    assert_eq!(rig.readings().errors, [0], "its torque is missing, and nothing says why");
    rig.ask(Request::Clear);
    for _ in 0..10 {
        rig.tick();
    }
    assert_eq!(MyActuator::error_text(rig.readings().errors[0]), "motor too hot");
}

#[test]
fn the_last_frame_of_a_program_switches_the_drive_off() {
    for action in [SafeAction::DampedStop, SafeAction::Off] {
        let mut rig = rig(action).armed();
        for _ in 0..5 {
            rig.joints.safe(SafeAction::Off);
            rig.wire.bus.borrow_mut().serve();
            rig.joints.measure();
        }
        rig.joints.end();
        rig.wire.bus.borrow_mut().serve();
        let last = rig.wire.bus.borrow().sent.last().cloned().unwrap();
        assert_eq!((last.id, last.data[0]), (0x141, 0x80), "{action:?}");
        assert!(rig.electronics(|it| !it.is_enabled()), "{action:?}");
    }
}

/// A drive that neither confirms nor replies for 120 ms, because it releases its brake: it may as well have restarted.
#[test]
fn a_drive_that_is_silent_while_it_releases_its_brake_keeps_its_zero_only_if_it_is_absolute() {
    for absolute in [false, true] {
        let change = |drive: &mut MitDrive| drive.absolute = absolute;
        let mut rig = Rig::<MyActuator>::with(Language::MyActuator, SafeAction::Brake, change);
        for _ in 0..ARMING {
            rig.tick();
        }
        rig.home();
        rig.ask(Request::Arm);
        let before = sent(&rig, 0x141, 0x77);
        rig.powered = false;
        for _ in 0..120 {
            rig.tick();
            assert!(!rig.readings().on[0] && !rig.brake.0.get());
        }
        assert!(sent(&rig, 0x141, 0x77) - before <= 1, "once after the time of a restart, and not into the silence");
        rig.powered = true;
        for _ in 0..100 {
            rig.tick();
        }
        assert_eq!(rig.state() == State::Armed, absolute, "{:?}", rig.state());
        assert_eq!(rig.fault(), (!absolute).then_some(Fault::ZeroLost));
    }
}

#[test]
fn other_frames_of_the_drive_are_no_positions_and_no_replies() {
    for data in [
        // Confirmations, a status without an error, an answer with the angle, and a parameter.
        vec![0x77, 0, 0, 0, 0, 0, 0, 0],
        vec![0x80, 0, 0, 0, 0, 0, 0, 0],
        vec![0x9a, 30, 30, 1, 0xe0, 0x01, 0, 0],
        vec![0x92, 0, 0, 0, 0x10, 0x27, 0, 0],
        vec![0x01, 0, 0, 0, 0, 0, 0, 0],
        vec![0xb2],
    ] {
        let mut rig = rig(SafeAction::Brake).armed();
        let Sensed::State { q: at, .. } = rig.readings().sensed else { panic!("a state") };
        rig.wire.bus.borrow_mut().fates.push((1, actuator_model::bus::Fate::Lost));
        rig.tick();
        rig.wire.bus.borrow_mut().inject(Frame::standard(0x241, data.clone()));
        rig.tick();
        let Sensed::State { q, .. } = rig.readings().sensed else { panic!("a state") };
        assert!((q[0] - at[0]).abs() < 1e-3, "{data:?}: {} rad", q[0]);
        assert_eq!((rig.readings().age_ticks, rig.readings().on, rig.fault()), ([1], [true], None), "{data:?}");
    }
}

#[test]
fn a_drive_that_is_off_is_told_so_once_and_measured_from_then_on() {
    let mut rig = rig(SafeAction::Brake).armed();
    rig.ask(Request::Disarm);
    while rig.state() != State::Idle {
        rig.tick();
    }
    for _ in 0..2 * ENGAGES {
        rig.tick();
    }
    let [offs, asks] = [0x80, 0x9a].map(|first| sent(&rig, 0x141, first));
    for _ in 0..100 {
        rig.tick();
        assert_eq!(rig.readings().age_ticks, [0], "measured in every tick");
        assert!(rig.is_off());
    }
    assert_eq!([0x80, 0x9a].map(|first| sent(&rig, 0x141, first)), [offs, asks]);
    let last = rig.wire.bus.borrow().sent.last().cloned().unwrap();
    // Code 0x800 is half a step of torque, which is the nearest to none; stiffness and damping are exactly zero.
    assert_eq!((last.id, last.data), (0x401, vec![0x80, 0, 0x80, 0, 0, 0, 0x08, 0]));
}
