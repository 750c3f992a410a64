//! A live session in the emulated chip: its own timer, its own joints (which rest at zero), and a host that falls silent.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{Chip, build_firmware, hello};
use link::{Frame, Pacing, Parts, Request, Status, Watch};
use robot_compiler::SceneFile;
use std::path::Path;

/// The next status in one of these states; the others on the way are left out.
fn until(chip: &mut Chip, wanted: impl Fn(&Status) -> bool) -> Status {
    for _ in 0..100_000 {
        match chip.receive("a status").unwrap() {
            Frame::Status(status) if wanted(&status) => return status,
            Frame::Status(status) => assert_eq!(status.refused, None, "{status:?}"),
            Frame::Answer(_) => {}
            other => panic!("{other:?}"),
        }
    }
    panic!("100,000 ticks without it");
}

/// The chip arms by its own timer and joints. Its host says nothing more: it holds, and at last stops, each in its tick.
#[test]
fn a_live_arm_whose_host_falls_silent_holds_and_then_stops_in_the_stated_ticks() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml");
    let scene = SceneFile::load(&path).unwrap();
    let model = scene.robot.model::<2>().unwrap();
    let rules = scene.safety_rules::<2>(&model);
    let mut chip = Chip::start(&build_firmware(&path).unwrap(), hello(&scene, &model, Pacing::LockStep)).unwrap();
    chip.change_pacing(hello(&scene, &model, Pacing::Live)).unwrap();
    chip.send(&Frame::Live(link::Live::new(&scene.live::<2>(&model).cast::<f32>()).unwrap())).unwrap();
    chip.send(&Frame::Watch(Watch { every: 1, parts: Parts::TORQUE })).unwrap();
    for (request, state, homed) in [(Request::Home, 1, false), (Request::Confirm, 0, true), (Request::Arm, 2, true)] {
        chip.send(&Frame::request(state, request)).unwrap();
        let status = until(&mut chip, |status| (status.state, status.homed) == (state, homed));
        assert_eq!(status.refused, None, "{request:?}");
        if state == 2 {
            // That tick was told by the last thing that the host said.
            let holds = until(&mut chip, |status| status.state == 4);
            assert_eq!((holds.tick - status.tick, holds.cause), (rules.heartbeat_max + 1, 2));
            let stops = until(&mut chip, |status| status.state == 5);
            assert_eq!((stops.tick - holds.tick, stops.cause), (rules.hold_max, 10));
        }
    }
}
