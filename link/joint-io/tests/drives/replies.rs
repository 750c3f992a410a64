//! Tests with replies that do not match the commands.

use crate::rig::Rig;
use actuator_model::bus::Fate;
use actuator_model::frame::Frame;
use actuator_model::mit::Language;
use dynamics_core::control::Sensed;
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::SafeAction;
use joint_io::frames::Frames;
use link::Request;

#[test]
fn a_damiaos_answer_about_a_register_is_no_position() {
    let mut rig = Rig::<Damiao>::new(Language::Damiao, SafeAction::Brake).armed();
    let Sensed::State { q: at, .. } = rig.readings().sensed else { panic!("a state") };
    // A reply is outstanding, and this answer arrives instead: register 21 has the value 12.5.
    rig.wire.bus.borrow_mut().fates.push((1, actuator_model::bus::Fate::Lost));
    rig.tick();
    rig.wire.bus.borrow_mut().inject(Frame::standard(0x11, vec![0x01, 0x00, 0x33, 0x15, 0x00, 0x00, 0x48, 0x41]));
    rig.tick();
    let Sensed::State { q, .. } = rig.readings().sensed else { panic!("a state") };
    assert!((q[0] - at[0]).abs() < 1e-3, "{} rad", q[0]);
    assert_eq!(rig.readings().age_ticks, [1], "nothing has come");
    assert_eq!(rig.fault(), None);
}

#[test]
fn a_robstrides_version_is_no_position() {
    let mut rig = Rig::<RobStride>::new(Language::RobStride, SafeAction::Brake).armed();
    rig.wire.bus.borrow_mut().fates.push((1, actuator_model::bus::Fate::Lost));
    rig.tick();
    let id = 2 << 24 | 2 << 22 | 1 << 8 | 0x11;
    let data = vec![0x00, 0xc4, 0x56, 0x00, 0x01, 0x02, 0x03, 0x00];
    rig.wire.bus.borrow_mut().inject(Frame { id, extended: true, data });
    rig.tick();
    assert_eq!((rig.readings().age_ticks, rig.fault()), ([1], None));
}

/// A drive of another kind than the board expects never counts as on, and the brakes stay closed.
fn strange<F: Frames>(board: Language, drive: Language, reply_bytes: usize) {
    let mut rig = Rig::<F>::new(board, SafeAction::Brake);
    let reply_id = rig.electronics(|it| it.reply_id);
    rig.electronics(|it| {
        *it = it.clone().speaking(drive);
        (it.reply_id, it.reply_bytes) = (reply_id, reply_bytes);
    });
    for _ in 0..20 {
        rig.tick();
    }
    rig.home();
    rig.ask(Request::Arm);
    for _ in 0..100 {
        rig.tick();
        assert!(!rig.readings().on[0] && !rig.brake.0.get(), "{board:?} with the drive of a {drive:?}");
    }
}

#[test]
fn a_drive_of_another_kind_never_counts_as_on() {
    strange::<MiniCheetah>(Language::MiniCheetah, Language::Damiao, 8);
    strange::<MiniCheetah>(Language::MiniCheetah, Language::RobStride, 8);
    strange::<Damiao>(Language::Damiao, Language::MiniCheetah, 6);
    strange::<Damiao>(Language::Damiao, Language::MiniCheetah, 8);
    strange::<Damiao>(Language::Damiao, Language::RobStride, 8);
    strange::<RobStride>(Language::RobStride, Language::MiniCheetah, 6);
    strange::<RobStride>(Language::RobStride, Language::Damiao, 8);
    for drive in [Language::MiniCheetah, Language::Damiao, Language::RobStride] {
        strange::<MyActuator>(Language::MyActuator, drive, 8);
    }
    strange::<MiniCheetah>(Language::MiniCheetah, Language::MyActuator, 8);
    strange::<Damiao>(Language::Damiao, Language::MyActuator, 8);
    strange::<RobStride>(Language::RobStride, Language::MyActuator, 8);
}

/// An arm without brakes: its drive receives all frames, but its replies are lost for `ticks` ticks. The drive must go on damping.
fn damps_unheard<F: Frames>(language: Language, ticks: u32) {
    // Something else holds the arm until it is armed.
    let mut rig = Rig::<F>::new(language, SafeAction::DampedStop).armed();
    rig.brakeless = true;
    for tick in 0..ticks + 30 {
        if tick < ticks {
            rig.wire.bus.borrow_mut().fates = vec![(1, Fate::Lost)];
        }
        rig.tick();
        assert!(rig.electronics(|it| it.gives_torque()), "{language:?}: off in tick {tick} of {ticks} without a reply");
    }
    assert!(rig.fault().is_some() && rig.qd < 0.0);
    let torque = rig.electronics(|it| it.torque());
    assert!((torque + 4.0 * rig.qd).abs() < 0.3, "{language:?}: {torque} N m at {} rad/s", rig.qd);
}

#[test]
fn a_drive_that_is_not_heard_goes_on_damping_an_arm_without_brakes() {
    for ticks in [5, 10, 11, 12, 20, 100] {
        damps_unheard::<MiniCheetah>(Language::MiniCheetah, ticks);
        damps_unheard::<Damiao>(Language::Damiao, ticks);
        damps_unheard::<RobStride>(Language::RobStride, ticks);
        damps_unheard::<MyActuator>(Language::MyActuator, ticks);
    }
}
