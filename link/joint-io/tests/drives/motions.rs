//! Motion of a joint without brakes after a fault, for each kind of drive. The safe action is a damped stop, as for `newtau drive`.
//!
//! `docs/safety/drives.md` has this table. The joint is held where its weight pulls most: 2 kg at 0.5 m, with a damping of 4 N m s/rad at the drive.

use crate::rig::Rig;
use actuator_model::bus::Fate;
use actuator_model::mit::Language;
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::SafeAction;
use joint_io::frames::Frames;

/// A fault that begins while the joint is held.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trouble {
    /// The drive's replies are lost; it hears everything.
    NoReplies,
    /// The drive hears nothing and says nothing for so many ticks.
    Unplugged(u32),
    /// The drive has no power for so many ticks.
    Dark(u32),
    /// The controller is off the bus.
    BusOff,
    /// The program does nothing for so many ticks.
    Stalls(u32),
}

/// Ticks after the beginning of the fault in which the joint is watched.
const SOON: u32 = 250;
const LATER: u32 = 1000;

/// Number of a fault's ticks that never ends.
const EVER: u32 = u32::MAX;

const TROUBLES: [(&str, Trouble); 10] = [
    ("its replies are lost; it hears everything", Trouble::NoReplies),
    ("its cable is open for 2 ticks", Trouble::Unplugged(2)),
    ("its cable is cut", Trouble::Unplugged(EVER)),
    ("it loses power for 20 ms", Trouble::Dark(20)),
    ("it loses power", Trouble::Dark(EVER)),
    ("the bus is off, or the adapter is unplugged", Trouble::BusOff),
    ("the program stalls for 5 ms", Trouble::Stalls(5)),
    ("the program stalls for 50 ms", Trouble::Stalls(50)),
    ("the program stalls for 500 ms", Trouble::Stalls(500)),
    ("the program is killed", Trouble::Stalls(EVER)),
];

/// Largest fall, rad, in the first quarter of a second, and largest speed, rad/s, in the first second.
fn motion<F: Frames>(language: Language, trouble: Trouble) -> (f64, f64) {
    let mut rig = Rig::<F>::new(language, SafeAction::DampedStop);
    rig.brakeless = true;
    // The stand that holds the arm until it is armed.
    rig.home();
    rig.ask(link::Request::Arm);
    for _ in 0..250 {
        (rig.q, rig.qd) = (0.0, 0.0);
        rig.tick();
    }
    assert_eq!(rig.state(), dynamics_core::safety::State::Armed, "{language:?}");
    for _ in 0..200 {
        rig.tick();
    }
    let at = rig.q;
    let (mut fall, mut speed) = (0.0_f64, 0.0_f64);
    for tick in 0..LATER {
        match trouble {
            Trouble::NoReplies => rig.wire.bus.borrow_mut().fates = vec![(1, Fate::Lost); 4],
            Trouble::Unplugged(ticks) => rig.unplugged = tick < ticks,
            Trouble::Dark(ticks) if tick == ticks => rig.restart(),
            Trouble::Dark(ticks) => rig.powered = tick > ticks,
            Trouble::BusOff => rig.wire.bus.borrow_mut().off = true,
            Trouble::Stalls(ticks) => {
                if tick == ticks {
                    // As the loop of the program does: the tick is late.
                    rig.session.overrun();
                }
                rig.ticking = tick >= ticks;
            }
        }
        rig.tick();
        if tick < SOON {
            fall = fall.max(at - rig.q);
        }
        speed = speed.max(rig.qd.abs());
    }
    (fall, speed)
}

#[test]
fn the_table_of_the_page_has_the_measured_motions() {
    let mut rows = Vec::new();
    for (text, trouble) in TROUBLES {
        let all = [
            motion::<Damiao>(Language::Damiao, trouble),
            motion::<RobStride>(Language::RobStride, trouble),
            motion::<MiniCheetah>(Language::MiniCheetah, trouble),
            motion::<MyActuator>(Language::MyActuator, trouble),
        ];
        let cells = all.map(|(fall, speed)| format!("{fall:.2} rad, {speed:.1} rad/s"));
        rows.push(format!("| {text} | {} |", cells.join(" | ")));
    }
    let page = include_str!("../../../../docs/safety/drives.md");
    for row in &rows {
        assert!(page.contains(row.as_str()), "not in docs/safety/drives.md; the rows are now:\n{}", rows.join("\n"));
    }
}
