//! A whole session of `newtau drive` with a simulated arm behind a simulated adapter, in this process.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::channel::GsUsb;
use super::simulated::SimulatedUsb;
use crate::can::adapter_name::AdapterName;
use crate::can::host_bus::HostBus;
use crate::can::simulated::SimulatedArm;
use crate::session::drive::arm::Wiring;
use crate::session::frame_log::Head;
use crate::session::operate::console::Console;
use crate::session::operate::converse::converse;
use crate::session::operate::report::Report;
use crate::session::operate::screen::Screen;
use crate::session::operate::{Operator, Presses, Stop};
use embedded_can::Frame as _;
use robot_compiler::SceneFile;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A folder that is deleted at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("newtau-gs_usb-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).ok();
    }
}

/// The scene with one bus, at 100 Hz, so that a busy machine begins no tick too late.
fn scene(folder: &Folder) -> (PathBuf, SceneFile) {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = fs::read_to_string(top.join("scenes/yam_one_bus.toml")).unwrap();
    let text = text
        .replace("rate = 400", "rate = 100")
        .replace("natural_frequency = 40.0", "natural_frequency = 20.0")
        .replace("../robots", &top.join("robots").display().to_string());
    let path = folder.0.join("scene.toml");
    fs::write(&path, text).unwrap();
    let scene = SceneFile::load(&path).unwrap_or_else(|error| panic!("{error}"));
    (path, scene)
}

/// Executes these commands with an arm at the adapter. Returns the end of the session, and true if no request was rejected.
fn session(name: &str, script: &str, prepare: impl FnOnce(&SimulatedUsb, &SimulatedArm)) -> (Result<(), Stop>, bool) {
    let folder = Folder::new(name);
    let (path, scene) = scene(&folder);
    let arm = SimulatedArm::new(&scene).unwrap_or_else(|why| panic!("{why:?}"));
    let at_bus = arm.clone();
    let usb = SimulatedUsb::new(move |frame| at_bus.deliver(frame));
    prepare(&usb, &arm);
    let adapter = Box::new(GsUsb::start(usb.clone(), 0).unwrap());
    let buses = [HostBus::new(adapter), HostBus::none(), HostBus::none()];
    let wiring = Wiring::new(&scene, &[AdapterName::GsUsb(None, 0)], false).unwrap_or_else(|why| panic!("{why:?}"));
    let presses = Presses::default();
    let device = wiring.start_at(buses, &scene, Arc::clone(&presses)).unwrap_or_else(|why| panic!("{why:?}"));
    let lines = folder.0.join("script.txt");
    fs::write(&lines, script).unwrap();
    let model = scene.robot.model::<6>().unwrap();
    let head = Head { hash: scene.hash(&model), scene: path, text: String::new() };
    let report = Report::new(false, Screen::default());
    let mut operator = Operator::new(Box::new(device), (&scene, &scene), head, report, presses).unwrap();
    operator.begin().unwrap();
    let ended = converse(&mut operator, &mut Console::script(&lines).unwrap());
    let content = operator.is_content();
    drop(operator);
    assert!(usb.state().on.is_none() || usb.state().unplugged, "{name}: the channel is reset at the end");
    (ended, content)
}

#[test]
fn a_session_over_gs_usb_moves_the_arm_and_parks_it() {
    let mut seen = None;
    let script = "home\nconfirm\narm\nfull-range\njog wrist_pitch -0.3 1.0\nwait\npark\n";
    let (ended, content) =
        session("moves", script, |usb, arm| seen = Some((usb.clone(), arm.clone(), arm.positions())));
    assert!(ended.is_ok() && content, "{ended:?}");
    let (usb, arm, before) = seen.unwrap();
    let moved = arm.positions();
    assert!(moved.iter().zip(&before).all(|(q, other)| (q - other).abs() < 0.1), "{moved:?} and {before:?}");
    let state = usb.state();
    let enabled = |frame: &&super::super::frame::CanFrame| frame.data().ends_with(&[0xFF, 0xFF, 0xFF, 0xFC]);
    assert!(state.on_bus.iter().filter(enabled).count() >= 6, "every drive was enabled");
    for id in 1..=6 {
        let last = state.on_bus.iter().rev().find(|frame| frame.raw_id() == id).unwrap();
        assert_eq!(last.data()[7], 0xFD, "motor {id} was switched off");
    }
}

#[test]
fn a_session_whose_adapter_is_unplugged_ends_with_a_fault() {
    let script = "home\nconfirm\narm\nstatus\nwait 5\n";
    let (ended, content) = session("unplugged", script, |usb, _| {
        let usb = usb.clone();
        std::thread::spawn(move || {
            // After the arm was enabled.
            for _ in 0..2000 {
                std::thread::sleep(std::time::Duration::from_millis(5));
                if usb.state().on_bus.iter().any(|frame| frame.data().ends_with(&[0xFF, 0xFF, 0xFF, 0xFC])) {
                    break;
                }
            }
            usb.state().unplugged = true;
        });
    });
    assert!(ended.is_err() || !content, "{ended:?}");
}
