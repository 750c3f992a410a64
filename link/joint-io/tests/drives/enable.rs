//! Tests that a drive counts as on only when it has confirmed it, and that brakes open only then.

use crate::rig::{ARMING, Rig};
use actuator_model::bus::Fate;
use actuator_model::mit::Language;
use dynamics_core::control::Fault;
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::{self, SafeAction};
use joint_io::frames::Frames;
use link::Request;

/// Fate of the frames in the given number of ticks after arming.
#[derive(Clone, Copy, Debug)]
enum Loss {
    Nothing,
    /// The transmitter is full.
    Refused,
    /// Queued, and dropped a tick later.
    Swallowed,
    /// Sent, but the drive does not receive it.
    Unplugged,
    /// The drive receives it, but its reply is lost.
    Unanswered,
    /// The reply arrives a tick late.
    Late,
    /// The reply arrives twice.
    Twice,
}

const LOSSES: [Loss; 7] =
    [Loss::Nothing, Loss::Refused, Loss::Swallowed, Loss::Unplugged, Loss::Unanswered, Loss::Late, Loss::Twice];

/// Arms while the frames of `ticks` ticks are disturbed, beginning with tick `from`. Returns how far the joint sinks, rad, and the tick in which
/// the brakes open.
fn arm<F: Frames>(language: Language, loss: Loss, from: u32, ticks: u32) -> (f64, Option<u32>) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    for _ in 0..ARMING {
        rig.tick();
    }
    rig.home();
    let (mut open_at, at) = (None, rig.q);
    for tick in 0..300 {
        let lost = (from..from + ticks).contains(&tick);
        match loss {
            Loss::Nothing => {}
            Loss::Refused => rig.wire.refuse.set(u32::from(lost)),
            Loss::Swallowed => rig.wire.swallow.set(lost),
            Loss::Unplugged => rig.powered = !lost,
            Loss::Unanswered | Loss::Late | Loss::Twice if lost => {
                let fate = match loss {
                    Loss::Unanswered => Fate::Lost,
                    Loss::Late => Fate::Late,
                    _ => Fate::Twice,
                };
                rig.wire.bus.borrow_mut().fates.push((1, fate));
            }
            Loss::Unanswered | Loss::Late | Loss::Twice => {}
        }
        if tick == 0 {
            rig.ask(Request::Arm)
        } else {
            rig.tick()
        }
        if rig.brake.0.get() {
            assert!(
                rig.electronics(|it| it.is_enabled()),
                "{language:?} {loss:?} {from} {ticks}: open on a drive that is off"
            );
            open_at = open_at.or(Some(tick));
        }
    }
    (at - rig.q, open_at)
}

#[test]
fn brakes_open_only_on_a_drive_that_has_shown_that_it_is_on() {
    let mut worst = (0.0_f64, String::new());
    for loss in LOSSES {
        for from in 0..4 {
            for ticks in [1, 2] {
                for (language, (sank, open)) in [
                    (Language::MiniCheetah, arm::<MiniCheetah>(Language::MiniCheetah, loss, from, ticks)),
                    (Language::Damiao, arm::<Damiao>(Language::Damiao, loss, from, ticks)),
                    (Language::RobStride, arm::<RobStride>(Language::RobStride, loss, from, ticks)),
                    (Language::MyActuator, arm::<MyActuator>(Language::MyActuator, loss, from, ticks)),
                ] {
                    let case =
                        format!("{language:?}, {loss:?}, {ticks} ticks from {from}: {sank:.5} rad, open in {open:?}");
                    assert!(open.is_some(), "never on: {case}");
                    if sank > worst.0 {
                        worst = (sank, case);
                    }
                }
            }
        }
    }
    println!("worst: {}", worst.1);
    assert!(worst.0 < 0.005, "{}", worst.1);
}

/// The reply to the command of tick `at` after arming arrives a tick late, and the drive loses its power in the next tick. Returns true if the
/// brakes open after that.
fn late_and_dark<F: Frames>(language: Language, at: u32) -> bool {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    for _ in 0..ARMING {
        rig.tick();
    }
    rig.home();
    rig.ask(Request::Arm);
    for _ in 0..at {
        rig.tick();
    }
    rig.wire.bus.borrow_mut().fates.push((1, Fate::Late));
    rig.tick();
    rig.powered = false;
    rig.tick();
    let was_open = rig.brake.0.get();
    rig.tick();
    !was_open && rig.brake.0.get()
}

#[test]
fn a_late_reply_does_not_open_the_brakes_on_a_drive_that_has_lost_its_power() {
    for at in 0..80 {
        for (language, opened) in [
            (Language::MiniCheetah, late_and_dark::<MiniCheetah>(Language::MiniCheetah, at)),
            (Language::Damiao, late_and_dark::<Damiao>(Language::Damiao, at)),
            (Language::RobStride, late_and_dark::<RobStride>(Language::RobStride, at)),
            (Language::MyActuator, late_and_dark::<MyActuator>(Language::MyActuator, at)),
        ] {
            assert!(!opened, "{language:?}, reply {at} ticks after arming late");
        }
    }
}

/// Arms a drive that ignores the frame that enables it. Returns the fault and its tick.
fn never<F: Frames>(language: Language) -> (Option<Fault>, u32) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    for _ in 0..ARMING {
        rig.tick();
    }
    rig.home();
    // The drive ignores only the frame that enables it.
    rig.electronics(|it| it.ignores_enable = true);
    rig.ask(Request::Arm);
    let mut ticks = 0;
    while rig.fault().is_none() && ticks < 1000 {
        rig.tick();
        ticks += 1;
        assert!(!rig.brake.0.get());
    }
    (rig.fault(), ticks)
}

#[test]
fn a_drive_that_never_comes_on_ends_in_a_fault_that_names_it_with_the_brakes_engaged() {
    for (language, (fault, ticks)) in [
        (Language::MiniCheetah, never::<MiniCheetah>(Language::MiniCheetah)),
        (Language::Damiao, never::<Damiao>(Language::Damiao)),
        (Language::RobStride, never::<RobStride>(Language::RobStride)),
        (Language::MyActuator, never::<MyActuator>(Language::MyActuator)),
    ] {
        assert_eq!(fault, Some(Fault::DriveNotOn { joint: 0 }), "{language:?}");
        assert!((295..=305).contains(&ticks), "{language:?}: {ticks}");
    }
}

fn again<F: Frames>(language: Language, action: SafeAction) -> bool {
    let mut rig = Rig::<F>::new(language, action);
    rig.home();
    rig.wire.refuse.set(1);
    rig.ask(Request::Arm);
    for _ in 0..300 {
        rig.tick();
        (rig.q, rig.qd) = (0.0, 0.0);
    }
    for _ in 0..3 {
        for request in [Request::Disarm, Request::Clear, Request::Home, Request::Confirm, Request::Arm] {
            (rig.q, rig.qd) = (0.0, 0.0);
            rig.ask(request);
            while rig.state() == safety::State::Disarming {
                rig.tick();
            }
        }
        for _ in 0..20 {
            (rig.q, rig.qd) = (0.0, 0.0);
            rig.tick();
        }
    }
    rig.electronics(|it| it.is_enabled()) && rig.brake.0.get()
}

#[test]
fn a_drive_that_missed_its_enable_frame_is_enabled_by_the_next_arming() {
    for action in [SafeAction::Brake, SafeAction::DampedStop] {
        assert!(again::<MiniCheetah>(Language::MiniCheetah, action), "{action:?}");
        assert!(again::<Damiao>(Language::Damiao, action), "{action:?}");
        assert!(again::<RobStride>(Language::RobStride, action), "{action:?}");
        assert!(again::<MyActuator>(Language::MyActuator, action), "{action:?}");
    }
}

/// The drive of an armed joint does not receive the first `lost` frames that switch it off.
fn exit_lost<F: Frames>(language: Language, lost: u32) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake).armed();
    rig.stop = true;
    rig.powered = false;
    // It receives nothing, and stays on.
    for _ in 0..lost {
        rig.tick();
        assert!(!rig.brake.0.get() && rig.electronics(|it| it.is_enabled()));
    }
    rig.powered = true;
    rig.tick();
    assert!(rig.is_off(), "{language:?}: not told again after {lost} ticks");
    rig.tick();
    assert_eq!(rig.readings().on, [false]);
}

#[test]
fn a_drive_that_did_not_hear_that_it_has_to_be_off_is_told_in_every_tick() {
    for lost in [1, 2, 3] {
        exit_lost::<MiniCheetah>(Language::MiniCheetah, lost);
        exit_lost::<Damiao>(Language::Damiao, lost);
        exit_lost::<RobStride>(Language::RobStride, lost);
        exit_lost::<MyActuator>(Language::MyActuator, lost);
    }
}

fn clears<F: Frames>(language: Language, action: SafeAction) -> u32 {
    let mut rig = Rig::<F>::new(language, action).armed();
    // The drive latches the error until it is cleared.
    rig.electronics(|it| it.error = 0xc);
    for _ in 0..20 {
        rig.tick();
        (rig.q, rig.qd) = (0.0, 0.0);
    }
    assert!(rig.fault().is_some());
    assert!(rig.readings().errors[0] != 0);
    for tick in 1..=20 {
        (rig.q, rig.qd) = (0.0, 0.0);
        rig.ask(Request::Clear);
        if rig.fault().is_none() {
            assert_eq!((rig.readings().errors, rig.electronics(|it| it.error)), ([0], 0));
            return tick;
        }
    }
    panic!("{language:?} {action:?}: never cleared");
}

#[test]
fn a_latched_error_of_a_drive_is_cleared_through_the_session_whatever_the_safe_action() {
    for action in [SafeAction::Brake, SafeAction::DampedStop, SafeAction::Off] {
        // The first request makes the drives clear the error and is rejected; at the second the error is gone.
        assert_eq!(clears::<Damiao>(Language::Damiao, action), 2, "{action:?}");
        assert_eq!(clears::<RobStride>(Language::RobStride, action), 2, "{action:?}");
    }
}

#[test]
fn nobody_clears_an_error_that_was_not_asked_for() {
    let mut rig = Rig::<Damiao>::new(Language::Damiao, SafeAction::Brake).armed();
    rig.electronics(|it| it.error = 0xc);
    for _ in 0..200 {
        rig.tick();
    }
    assert_eq!(rig.electronics(|it| it.error), 0xc);
}
