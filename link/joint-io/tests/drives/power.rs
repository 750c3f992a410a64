//! Tests with drives that switch themselves off, and with drives that lose power.

use crate::rig::{ARMING, ENGAGES, H, INERTIA, Rig, WEIGHT};
use actuator_model::bus::{CommandFate, Disturbance, Fate};
use actuator_model::frame::Order;
use actuator_model::mit::{Language, Shaft};
use dynamics_core::control::{Fault, Sensed};
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::{self, SafeAction};
use joint_io::JointIo as _;
use joint_io::can::WEAK_MAX;
use joint_io::frames::Frames;
use link::Request;
use session::readings::JointFaults;

/// The drive of an armed joint switches itself off but still answers. Returns the number of ticks until the fault, and how far the joint sinks
/// until its brake has engaged, rad.
fn trip<F: Frames>(language: Language) -> (u32, f64) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake).armed();
    let at = rig.q;
    let zero = rig.electronics(|it| {
        // Stands for an over-current trip: the drive is off and reports no error. The board did not send this frame.
        let off = match language {
            Language::RobStride => actuator_model::frame::Frame { id: 4 << 24 | 1, extended: true, data: vec![0; 8] },
            // The next command would switch a MyActuator drive on again.
            Language::MyActuator => panic!("it does not stay off"),
            _ => actuator_model::frame::Frame::standard(1, vec![0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfd]),
        };
        it.answer(&off, &Shaft { position: at, velocity: 0.0 });
        it.is_enabled()
    });
    assert!(!zero);
    let mut seen = None;
    for tick in 1..=200 {
        rig.tick();
        if seen.is_none() && rig.readings().on == [false] {
            assert!(rig.readings().zero_lost, "it may have restarted");
            let torque = rig.readings().faults[0].contains(JointFaults::TORQUE);
            assert_eq!(torque, language == Language::MiniCheetah);
            assert!(rig.fault().is_some() && !rig.brake.0.get(), "in the same tick");
            seen = Some(tick);
        }
    }
    (seen.unwrap(), at - rig.q)
}

#[test]
fn a_drive_that_goes_off_by_itself_is_seen_and_the_brakes_hold_the_joint() {
    for (language, most, (ticks, sank)) in [
        // The tick in which the torque is missing, and its reply in the tick after.
        (Language::MiniCheetah, u32::from(WEAK_MAX) + 2, trip::<MiniCheetah>(Language::MiniCheetah)),
        (Language::Damiao, 2, trip::<Damiao>(Language::Damiao)),
        (Language::RobStride, 2, trip::<RobStride>(Language::RobStride)),
    ] {
        println!("{language:?}: seen after {ticks} ticks, sank {sank:.6} rad");
        let time = f64::from(most + ENGAGES) * H;
        let falls = 0.5 * WEIGHT / INERTIA * time * time;
        assert!(ticks <= most && sank < falls, "{language:?}: {ticks} ticks, {sank} rad of {falls}");
    }
}

/// The drive of an armed joint loses power for `ticks` ticks, a turn of its motor away from its zero. Returns the number of ticks that report a
/// lost zero, and the error of the drive's position afterwards, rad.
fn dark<F: Frames>(language: Language, ticks: u32, absolute: bool) -> (u32, f64) {
    let mut rig = Rig::<F>::with(language, SafeAction::Brake, |drive| drive.absolute = absolute);
    rig.q = 1.2;
    for _ in 0..ARMING {
        rig.tick();
    }
    rig.home();
    rig.ask(Request::Arm);
    for _ in 0..50 {
        rig.tick();
    }
    assert!(rig.brake.0.get());
    let mut lost = 0;
    (rig.stop, rig.powered) = (true, false);
    for _ in 0..ticks {
        rig.tick();
        lost += u32::from(rig.readings().zero_lost);
    }
    rig.restart();
    rig.stop = false;
    for _ in 0..10 {
        rig.tick();
        lost += u32::from(rig.readings().zero_lost);
    }
    // The joint falls until the brake has engaged.
    for _ in 0..ENGAGES {
        rig.tick();
    }
    let Sensed::State { q, .. } = rig.readings().sensed else { panic!("a state") };
    // Only a drive that has kept its zero can be armed again without homing.
    rig.ask(Request::Clear);
    rig.ask(Request::Arm);
    let armed = rig.state() == safety::State::Arming;
    assert_eq!(armed, lost == 0, "{language:?} after {ticks} ticks: {:?}", rig.state());
    (lost, (f64::from(q[0]) - rig.q).abs())
}

#[test]
fn a_drive_that_was_without_power_has_lost_its_zero_unless_it_is_absolute() {
    for ticks in [12, 30, 175, 2000] {
        // With a gear ratio of 6, 1.2 rad are more than half a turn of the motor: after the restart the position is off by 60 degrees.
        let (lost, wrong) = dark::<MiniCheetah>(Language::MiniCheetah, ticks, false);
        assert!(lost > 0 && (wrong - std::f64::consts::TAU / 6.0).abs() < 1e-3, "{ticks}: {lost}, {wrong}");
        let (lost, wrong) = dark::<MyActuator>(Language::MyActuator, ticks, false);
        assert!(lost > 0 && (wrong - std::f64::consts::TAU / 6.0).abs() < 1e-3, "{ticks}: {lost}, {wrong}");
        // These drives know their angle within one turn of the shaft.
        for absolute in [false, true] {
            let (lost, wrong) = dark::<Damiao>(Language::Damiao, ticks, absolute);
            assert!((lost == 0) == absolute && wrong < 1e-3, "{ticks}: {lost}, {wrong}");
            let (lost, wrong) = dark::<RobStride>(Language::RobStride, ticks, absolute);
            assert!((lost == 0) == absolute && wrong < 1e-3, "{ticks}: {lost}, {wrong}");
        }
    }
}

#[test]
fn replies_that_are_missing_for_less_than_a_restart_leave_the_zero() {
    for ticks in [1, 3, 9] {
        let mut rig = Rig::<MiniCheetah>::new(Language::MiniCheetah, SafeAction::Brake);
        rig.powered = false;
        let mut lost = false;
        for tick in 0..ticks + 10 {
            rig.powered = tick >= ticks;
            rig.tick();
            lost |= rig.readings().zero_lost;
        }
        assert!(!lost, "{ticks}");
    }
}

/// Creates a joint without brakes; its drive damps after an emergency stop and replies in every tick.
fn damping<F: Frames>(language: Language, absolute: bool) -> Rig<F> {
    // Until it is armed something holds the arm.
    let mut rig = Rig::<F>::with(language, SafeAction::DampedStop, |drive| drive.absolute = absolute).armed();
    rig.brakeless = true;
    rig.stop = true;
    for _ in 0..20 {
        rig.tick();
        assert!(rig.electronics(|it| it.gives_torque()) && !rig.readings().zero_lost, "{language:?}");
    }
    assert!(rig.session.homed());
    rig
}

/// A drive that damps restarts within `dark` ticks without replies.
fn restarts_while_it_damps<F: Frames>(language: Language, dark: u32, absolute: bool) {
    let name = format!("{language:?}, not heard for {dark} ticks, absolute: {absolute}");
    let mut rig = damping::<F>(language, absolute);
    rig.powered = dark == 0;
    for _ in 0..dark {
        rig.tick();
        assert!(!rig.readings().zero_lost, "{name}: nothing is known yet");
    }
    rig.restart();
    assert!(rig.electronics(|it| it.timeout) != 0.05, "{name}: the maker's");
    let mut lost = 0;
    let mut forgotten = false;
    for _ in 0..3 {
        rig.tick();
        lost += u32::from(rig.readings().zero_lost);
        forgotten |= rig.joints.inner.timeouts() == [None];
    }
    assert_eq!((lost > 0, rig.session.homed()), (!absolute, absolute), "{name}");
    assert!(forgotten, "{name}: its timeout is not what was confirmed");
    for _ in 0..20 {
        rig.tick();
    }
    assert!((rig.electronics(|it| it.timeout) - 0.05).abs() < 1e-9, "{name}: set again");
    rig.brakeless = false;
    (rig.stop, rig.qd) = (false, 0.0);
    rig.tick();
    rig.ask(Request::Clear);
    rig.ask(Request::Arm);
    assert_eq!(rig.state() == safety::State::Arming, absolute, "{name}: {:?}", rig.state());
}

#[test]
fn a_drive_that_restarts_while_it_damps_has_lost_its_zero_and_its_timeout() {
    for dark in [0, 1, 2, 5, 9] {
        for absolute in [false, true] {
            restarts_while_it_damps::<Damiao>(Language::Damiao, dark, absolute);
            restarts_while_it_damps::<RobStride>(Language::RobStride, dark, absolute);
        }
    }
}

/// A drive restarts `after` ticks after its enable frame.
fn restarts_while_it_is_enabled<F: Frames>(language: Language, after: u32) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake);
    rig.home();
    rig.ask(Request::Arm);
    while !rig.electronics(|it| it.is_enabled()) {
        rig.tick();
    }
    for _ in 0..after {
        rig.tick();
    }
    assert_eq!(rig.state(), safety::State::Arming, "{language:?}, {after} ticks");
    rig.restart();
    for _ in 0..4 {
        rig.tick();
    }
    assert_eq!(rig.fault(), Some(Fault::ZeroLost), "{language:?}, {after} ticks");
    assert!(!rig.session.homed(), "{language:?}, {after} ticks");
}

#[test]
fn a_drive_that_restarts_while_it_is_enabled_has_lost_its_zero() {
    for after in 0..4 {
        restarts_while_it_is_enabled::<Damiao>(Language::Damiao, after);
        restarts_while_it_is_enabled::<RobStride>(Language::RobStride, after);
    }
}

/// Commands a drive off while its exit frames and its replies have these fates for `ticks` ticks; that must not count as a restart.
fn is_commanded_off<F: Frames>(
    language: Language,
    action: SafeAction,
    command: Option<CommandFate>,
    reply: Fate,
    ticks: u32,
) {
    let mut rig = Rig::<F>::new(language, action).armed();
    for again in 0..3 {
        let name = format!("{language:?}, {action:?}, {command:?}, {reply:?} for {ticks} ticks, {again}");
        // The first tick is the last one that drives: its reply may arrive after the exit frame was sent.
        for tick in 0..20 {
            rig.stop = tick > 0;
            let disturbed = tick <= ticks;
            {
                let mut bus = rig.wire.bus.borrow_mut();
                let order = Some(Order::Disable);
                bus.disturbance = command.filter(|_| disturbed).map(|fate| Disturbance { id: None, order, fate });
                bus.fates = if disturbed { vec![(1, reply)] } else { vec![] };
            }
            rig.tick();
            // Something else holds the arm here: it has no brakes, or they have not engaged.
            (rig.q, rig.qd) = (0.0, 0.0);
            assert!(!rig.readings().zero_lost, "{name}: in tick {tick}");
        }
        assert!(!rig.electronics(|it| it.is_enabled()), "{name}");
        rig.stop = false;
        rig.tick();
        rig.ask(Request::Clear);
        rig.ask(Request::Arm);
        for _ in 0..50 {
            rig.tick();
            (rig.q, rig.qd) = (0.0, 0.0);
            assert!(!rig.readings().zero_lost, "{name}: while it is armed again");
        }
        assert_eq!(rig.state(), safety::State::Armed, "{name}");
    }
}

#[test]
fn a_drive_that_is_commanded_off_has_not_restarted() {
    let commands =
        [None, Some(CommandFate::Lost), Some(CommandFate::Late), Some(CommandFate::Refused), Some(CommandFate::Twice)];
    for command in commands {
        for reply in [Fate::Arrives, Fate::Lost, Fate::Late, Fate::Twice] {
            for ticks in 1..=6 {
                for action in [SafeAction::Brake, SafeAction::Off] {
                    is_commanded_off::<Damiao>(Language::Damiao, action, command, reply, ticks);
                    is_commanded_off::<RobStride>(Language::RobStride, action, command, reply, ticks);
                }
            }
        }
    }
}

/// A drive that damps latches an error, is commanded off, and its error is cleared, while exit and clear frames and replies have these fates.
fn error_is_cleared<F: Frames>(language: Language, command: Option<CommandFate>, reply: Fate, ticks: u32) {
    let name = format!("{language:?}, {command:?}, {reply:?} for {ticks} ticks");
    let mut rig = damping::<F>(language, false);
    // Something else holds the arm here.
    let at = rig.q;
    rig.stop = false;
    // The drive is too hot.
    rig.electronics(|it| it.error = if language == Language::Damiao { 0xb } else { 4 });
    for tick in 0..60 {
        if matches!(tick, 10 | 30) {
            rig.ask(Request::Clear);
        } else {
            rig.tick();
        }
        (rig.q, rig.qd) = (at, 0.0);
        assert!(!rig.readings().zero_lost, "{name}: in tick {tick}");
        let disturbed = tick % 20 < ticks;
        let mut bus = rig.wire.bus.borrow_mut();
        bus.disturbance = command.filter(|_| disturbed).map(|fate| Disturbance { id: None, order: None, fate });
        bus.fates = if disturbed { vec![(1, reply)] } else { vec![] };
    }
    assert!(rig.session.homed(), "{name}");
    assert_eq!(rig.electronics(|it| it.error), 0, "{name}");
    assert_eq!(rig.state(), safety::State::Idle, "{name}");
}

#[test]
fn a_drive_whose_error_is_cleared_has_not_restarted() {
    for command in [None, Some(CommandFate::Lost), Some(CommandFate::Late), Some(CommandFate::Twice)] {
        for reply in [Fate::Arrives, Fate::Lost, Fate::Late, Fate::Twice] {
            for ticks in 0..=4 {
                error_is_cleared::<Damiao>(Language::Damiao, command, reply, ticks);
                error_is_cleared::<RobStride>(Language::RobStride, command, reply, ticks);
            }
        }
    }
}

/// Uses the drivers alone, with every reply a tick late. The drive is on; then one tick differs (`once`), and commands follow again. Nothing of
/// this must count as a restart.
fn in_one_tick<F: Frames>(
    language: Language,
    name: &str,
    once: impl FnOnce(&mut Rig<F>),
    again: SafeAction,
    enables: bool,
) {
    let mut rig = Rig::<F>::new(language, again).armed();
    let step = |rig: &mut Rig<F>, order: &mut dyn FnMut(&mut Rig<F>)| {
        let readings = rig.joints.inner.measure().unwrap();
        assert!(!readings.zero_lost, "{language:?}: {name}");
        order(rig);
        let mut bus = rig.wire.bus.borrow_mut();
        bus.fates = vec![(1, Fate::Late)];
        bus.serve();
    };
    let mut goes_on = |rig: &mut Rig<F>| match enables {
        true => rig.joints.inner.enable(again),
        false => rig.joints.inner.safe(again),
    };
    for _ in 0..10 {
        step(&mut rig, &mut goes_on);
    }
    assert!(rig.electronics(|it| it.is_enabled()), "{language:?}: {name}");
    let mut once = Some(once);
    step(&mut rig, &mut |rig| once.take().unwrap()(rig));
    rig.electronics(|it| it.error = 0);
    for _ in 0..20 {
        step(&mut rig, &mut goes_on);
    }
}

#[test]
fn a_late_reply_from_before_the_drive_was_commanded_off_makes_no_restart() {
    fn each<F: Frames>(language: Language) {
        let exit = |rig: &mut Rig<F>| rig.joints.inner.safe(SafeAction::Brake);
        in_one_tick::<F>(language, "off for a tick, then enabled", exit, SafeAction::Brake, true);
        in_one_tick::<F>(language, "off for a tick, then damped", exit, SafeAction::DampedStop, false);
        // One reply shows an error. The drive is commanded off, or its error is cleared, and the next reply shows it on.
        for (again, enables) in
            [(SafeAction::DampedStop, false), (SafeAction::DampedStop, true), (SafeAction::Brake, true)]
        {
            let error = |rig: &mut Rig<F>| {
                rig.electronics(|it| it.error = 0xb);
                match enables {
                    true => rig.joints.inner.enable(again),
                    false => rig.joints.inner.safe(again),
                }
            };
            in_one_tick::<F>(language, "an error in one reply", error, again, enables);
        }
    }
    each::<Damiao>(Language::Damiao);
    each::<RobStride>(Language::RobStride);
}
