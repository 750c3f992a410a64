//! Drives that go off by themselves, and drives without power.

use crate::rig::{ARMING, ENGAGES, H, INERTIA, Rig, WEIGHT};
use actuator_model::mit::Language;
use dynamics_core::control::Sensed;
use dynamics_core::drive::{Damiao, MiniCheetah, RobStride};
use dynamics_core::safety::{self, SafeAction};
use joint_io::can::WEAK_MAX;
use joint_io::frames::Frames;
use link::Request;
use session::readings::JointFaults;

/// An armed joint whose drive goes off by itself and answers on. Returns the ticks until it is seen, and how far the joint sinks until its brake
/// has engaged, rad.
fn trip<F: Frames>(language: Language) -> (u32, f64) {
    let mut rig = Rig::<F>::new(language, SafeAction::Brake).armed();
    let at = rig.q;
    let zero = rig.electronics(|it| {
        // Over-current: off, and nothing else. The frames are those of the board.
        let off = match language {
            Language::RobStride => actuator_model::bus::Frame { id: 4 << 24 | 1, extended: true, data: vec![0; 8] },
            _ => actuator_model::bus::Frame::standard(1, vec![0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfd]),
        };
        it.answer(&off, &actuator_model::mit::Shaft { position: at, velocity: 0.0 });
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

/// An armed joint whose drive loses its power for so many ticks, a turn of its motor away from its zero. Returns in how many ticks the zero was lost, and
/// how wrong the drive's position is then, rad.
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
    // Until the brake has engaged the joint has fallen.
    for _ in 0..ENGAGES {
        rig.tick();
    }
    let Sensed::State { q, .. } = rig.readings().sensed else { panic!("a state") };
    // Armed again without homing: only a drive that has kept its zero.
    rig.ask(Request::Clear);
    rig.ask(Request::Arm);
    let armed = rig.state() == safety::State::Arming;
    assert_eq!(armed, lost == 0, "{language:?} after {ticks} ticks: {:?}", rig.state());
    (lost, (f64::from(q[0]) - rig.q).abs())
}

#[test]
fn a_drive_that_was_without_power_has_lost_its_zero_unless_it_is_absolute() {
    for ticks in [12, 30, 175, 2000] {
        // A gear of 6: 1.2 rad are more than half a turn of the motor, and the drive comes back 60 degrees off.
        let (lost, wrong) = dark::<MiniCheetah>(Language::MiniCheetah, ticks, false);
        assert!(lost > 0 && (wrong - std::f64::consts::TAU / 6.0).abs() < 1e-3, "{ticks}: {lost}, {wrong}");
        // Within one turn of the shaft these know their angle.
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
