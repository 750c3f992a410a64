//! `drive`: the firmware's session in the program, with a simulated arm in the program and behind adapters on pseudo-terminals.
//!
//! The scene has 100 Hz, so that a busy machine begins no tick too late.

use crate::can_adapter::{Adapter, Kind};
use crate::program::{at_the_top, told};
use embedded_can::Frame as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

pub(crate) fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The scene with one bus, slower.
pub(crate) fn scene(name: &str) -> PathBuf {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let text = std::fs::read_to_string(top.join("scenes/yam_one_bus.toml")).unwrap();
    let text = text
        .replace("rate = 400", "rate = 100")
        .replace("natural_frequency = 40.0", "natural_frequency = 20.0")
        .replace("../robots", &top.join("robots").display().to_string());
    let path = file(&format!("drive_{name}.toml"));
    std::fs::write(&path, text).unwrap();
    path
}

pub(crate) fn drive(scene: &Path, adapter: &str, script: &str) -> Command {
    let lines = scene.with_extension("txt");
    std::fs::write(&lines, script).unwrap();
    let mut program = at_the_top();
    program.arg("drive").arg(scene).args(["--can", adapter, "--script"]).arg(lines);
    program
}

/// Message at the end of a session in which the arm had torque.
const ENDING: &str = "the arm is brought to rest before the program ends; Ctrl-C: emergency stop\n";

fn is_near(q: &[f64], other: &[f64], distance: f64) -> bool {
    q.iter().zip(other).all(|(q, other)| (q - other).abs() < distance)
}

/// Commands before the first motion.
pub(crate) const FIRST: &str = "home\nconfirm\narm\nfull-range\n";

/// Enable, of the mini-cheetah's frames.
const ENABLE: u8 = 0xFC;

#[test]
fn a_simulated_arm_runs_its_motion_and_parks_and_the_times_of_the_ticks_are_printed() {
    let scene = scene("simulated");
    let (code, out, error) = told(drive(&scene, "simulated", &format!("{FIRST}run\nwait\npark\n")).output().unwrap());
    assert!(code == 0 && (error.is_empty() || error == ENDING), "{code}: {out}{error}");
    assert!(out.starts_with("simulated: 6 drives, bus at least 83 % free at 100 Hz; up to 561 Hz\n"), "{out}");
    for part in ["control thread: ", "arm: armed", "wait: arrived", "park: ", " ticks; late: p50 "] {
        assert!(out.contains(part), "{part}: {out}");
    }
    assert!(out.trim_end().ends_with("0 ended too late"), "{out}");
}

#[test]
fn adapters_on_a_serial_port_carry_a_session_and_no_drive_is_enabled_before_it_is_asked_for() {
    for kind in [Kind::Slcan, Kind::Damiao] {
        let scene = scene(kind.name());
        let adapter = Adapter::new(kind, &scene);
        let before = adapter.arm.positions();
        let (code, out, error) = told(drive(&scene, &adapter.name, "home\nconfirm\nstatus\n").output().unwrap());
        assert_eq!((code, error.as_str()), (0, ""), "{out}");
        assert!(adapter.first(ENABLE).is_none(), "{kind:?}: no drive is enabled");
        assert!(is_near(&adapter.arm.positions(), &before, 1e-3), "{kind:?}: nothing moves");
        let script = format!("{FIRST}jog wrist_pitch -0.3 1.0\nwait\nstatus\npark\n");
        let (code, out, error) = told(drive(&scene, &adapter.name, &script).output().unwrap());
        assert!(code == 0 && (error.is_empty() || error == ENDING), "{code}: {out}{error}");
        assert!(adapter.first(ENABLE).is_some() && out.contains("wait: arrived"), "{out}");
        let moved = adapter.arm.positions();
        assert!(is_near(&moved, &before, 0.1), "{moved:?} and {before:?}");
    }
}

/// The program with an armed arm that holds itself away from its rest pose.
fn holding(scene: &Path, adapter: &Adapter) -> Child {
    let script = format!("{FIRST}goto 0 0.6 0.8 0 0 0 1.5\nwait\nwait 4\n");
    // A busy machine can delay a tick by more than its period, which ends a session. Then the arm is raised again.
    for _ in 0..5 {
        let mut program = drive(scene, &adapter.name, &script);
        let mut child = program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let is_raised = |q: &[f64]| (q[1] - 0.6).abs() < 0.01 && (q[2] - 0.8).abs() < 0.01;
        while child.try_wait().unwrap().is_none() {
            if is_raised(&adapter.arm.positions()) {
                return child;
            }
            sleep(Duration::from_millis(5));
        }
    }
    panic!("the arm was not raised in five sessions: {:?}", adapter.arm.positions());
}

/// Largest change of a position within this time, rad.
fn fallen(adapter: &Adapter, time: Duration) -> f64 {
    let (begun, from) = (Instant::now(), adapter.arm.positions());
    let mut most = 0.0_f64;
    while begun.elapsed() < time {
        sleep(Duration::from_millis(5));
        let change =
            adapter.arm.positions().iter().zip(&from).map(|(now, then)| (now - then).abs()).fold(0.0, f64::max);
        most = most.max(change);
    }
    most
}

#[test]
fn an_adapter_that_is_unplugged_is_a_fault_and_the_drives_own_timeouts_act() {
    let scene = scene("unplugged");
    let mut adapter = Adapter::new(Kind::Slcan, &scene);
    let child = holding(&scene, &adapter);
    adapter.unplug();
    let fell = fallen(&adapter, Duration::from_secs(1));
    let (code, out, error) = told(child.wait_with_output().unwrap());
    assert_eq!(code, 3, "{out}{error}");
    assert!(out.contains("fault"), "{out}");
    assert!(fell > 0.2, "no drive gives torque after its timeout: {fell} rad");
}

#[test]
fn a_request_to_end_and_a_closed_terminal_damp_the_arm_until_it_rests_and_switch_the_drives_off() {
    for signal in ["-TERM", "-HUP", "-TSTP"] {
        let scene = scene("ended");
        let adapter = Adapter::new(Kind::Slcan, &scene);
        let child = holding(&scene, &adapter);
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let (code, out, error) = told(child.wait_with_output().unwrap());
        assert_eq!(code, 130, "{signal}: {out}{error}");
        // As in `connect`, a script's Ctrl-C disarms; this arm has no brakes and sinks, damped, until it hangs.
        let moved = fallen(&adapter, Duration::from_millis(100));
        assert!(moved < 0.02, "{signal}: {moved} rad, after the drives were switched off");
        let frames = adapter.frames.lock().unwrap();
        // The last frame of each drive switches it off.
        for id in 1..=6 {
            let last = frames.iter().rev().find(|(_, frame)| frame.raw_id() == id).unwrap();
            assert_eq!(last.1.data()[7], 0xFD, "{signal}: motor {id}");
        }
    }
}

#[test]
fn a_program_that_is_killed_leaves_the_arm_to_the_drives_own_timeouts() {
    let scene = scene("killed");
    let adapter = Adapter::new(Kind::Slcan, &scene);
    let mut child = holding(&scene, &adapter);
    child.kill().unwrap();
    child.wait().unwrap();
    let last = adapter.frames.lock().unwrap().last().unwrap().0;
    let fell = fallen(&adapter, Duration::from_secs(2));
    assert!(fell > 0.2, "without torque it sinks: {fell} rad");
    assert!(last.elapsed() > Duration::from_secs(2), "nobody sends");
}

/// Stops the program for this time while its arm holds itself. Returns the largest change of a position in the second after it, and the output.
fn stalled(name: &str, time: Duration) -> (f64, String) {
    let scene = scene(name);
    let adapter = Adapter::new(Kind::Slcan, &scene);
    let child = holding(&scene, &adapter);
    let signal = |name: &str| {
        let sent = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    };
    signal("-STOP");
    sleep(time);
    signal("-CONT");
    let fell = fallen(&adapter, Duration::from_secs(1));
    let (code, out, error) = told(child.wait_with_output().unwrap());
    assert_eq!(code, 3, "{out}{error}");
    (fell, out)
}

#[test]
fn a_program_that_stalls_for_some_ticks_damps_the_arm_and_one_that_stalls_longer_than_the_drives_timeout_drops_it() {
    // Period 10 ms.
    let (fell, out) = stalled("stalled", Duration::from_millis(30));
    assert!(out.contains("fault 6"), "{out}");
    assert!(fell < 2.0, "damped by the drives: {fell} rad");
    let (dropped, out) = stalled("stalled_long", Duration::from_millis(500));
    assert!(out.contains("fault"), "{out}");
    assert!(dropped > 2.0 * fell, "without torque: {dropped} rad, damped {fell} rad");
}

#[test]
fn gains_that_are_too_high_for_the_rate_reach_no_adapter() {
    let scene = scene("too_stiff");
    let text = std::fs::read_to_string(&scene).unwrap().replace("natural_frequency = 20.0", "natural_frequency = 40.0");
    std::fs::write(&scene, text).unwrap();
    // The adapter does not exist: the scene is refused before it is opened.
    let (code, _, error) = told(drive(&scene, "slcan:/dev/no-adapter", "status\n").output().unwrap());
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("held at rest at 100 Hz, oscillates") && error.contains("natural_frequency = "), "{error}");
    assert!(!error.contains("no-adapter"), "{error}");
    // The simulated arm may oscillate; the session says so.
    let (_, out, error) = told(drive(&scene, "simulated", "status\n").output().unwrap());
    assert!(format!("{out}{error}").contains("an arm at an adapter is refused with this scene"), "{out}{error}");
}

#[test]
fn what_this_computer_cannot_drive_is_refused_with_what_to_do() {
    let yam = scene("refused");
    let text = std::fs::read_to_string(&yam).unwrap();
    let other = |name: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        let path = file(&format!("drive_{name}.toml"));
        std::fs::write(&path, text.replace(from, to)).unwrap();
        path
    };
    let mini_cheetah = {
        let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let text = std::fs::read_to_string(top.join("scenes/examples/mit6_wave.toml")).unwrap();
        let text = text
            .replace("../../robots", &top.join("robots").display().to_string())
            .replace("rate = 1000", "rate = 400");
        let path = file("drive_mit.toml");
        std::fs::write(&path, text).unwrap();
        path
    };
    let my_actuator = {
        let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let robot = std::fs::read_to_string(top.join("robots/examples/mit6.toml")).unwrap();
        let robot = robot.replace("kind = \"mit\"\n", "kind = \"myactuator\"\n");
        let robot: String =
            robot.lines().filter(|line| !line.starts_with("reply_")).map(|line| format!("{line}\n")).collect();
        let (robot_path, path) = (file("drive_myactuator_robot.toml"), file("drive_myactuator.toml"));
        std::fs::write(&robot_path, robot).unwrap();
        let text = std::fs::read_to_string(top.join("scenes/examples/mit6_wave.toml")).unwrap();
        let text = text
            .replace("../../robots/examples/mit6.toml", &robot_path.display().to_string())
            .replace("rate = 1000", "rate = 400");
        std::fs::write(&path, text).unwrap();
        path
    };
    let cases = [
        (scene("no_adapter"), vec!["--can", "slcan:/dev/no-such-port"], 1, "slcan:/dev/no-such-port"),
        (scene("no_socket"), vec!["--can", "nocan7"], 1, "nocan7"),
        (
            scene("kind"),
            vec!["--can", "lin:/dev/ttyACM0"],
            2,
            "lin is no kind of adapter; expected an interface such as can0",
        ),
        (scene("none"), vec![], 2, "--can <ADAPTER>"),
        (scene("twice"), vec!["--can", "can0", "--can", "can0"], 2, "--can can0: given twice"),
        (scene("mixed"), vec!["--can", "can0", "--can", "simulated"], 2, "expected no other adapter"),
        (scene("chip"), vec!["--can", "slcan:/dev/ttyUSB0"], 2, "is a serial chip: give its baud rate"),
        (mini_cheetah, vec!["--can", "simulated"], 2, "has no timeout that can be read or set"),
        (my_actuator, vec!["--can", "simulated"], 2, "has no timeout that can be read or set"),
        (
            other("fast", "rate = 100", "rate = 1000"),
            vec!["--can", "simulated"],
            2,
            "control.rate: found 1000 Hz, expected at most 561: 6 drives",
        ),
        (
            other("line", "rate = 100", "rate = 400"),
            vec!["--can", "slcan:/dev/ttyUSB0@460800"],
            2,
            "2865 us for the commands on the adapter's serial line",
        ),
        (
            other("usb", "rate = 100", "rate = 600"),
            vec!["--can", "gs_usb:0041"],
            2,
            "at most 538: 6 drives on gs_usb:0041",
        ),
        (
            scene("channels"),
            vec!["--can", "gs_usb:0041:0", "--can", "gs_usb:0041:1"],
            2,
            "another channel of this adapter is named too",
        ),
        (scene("serial"), vec!["--can", "gs_usb::1"], 2, "is no serial number of a USB adapter"),
        (scene("usb_channel"), vec!["--can", "gs_usb:0041:x"], 2, "expected a channel from 0 to 255"),
        (scene("no_usb"), vec!["--can", "gs_usb:no-such-serial"], 1, "gs_usb:no-such-serial"),
        (other("brake", "\"damped-stop\"", "\"brake\""), vec!["--can", "simulated"], 2, "no line that engages brakes"),
        (
            PathBuf::from("scenes/puma560_pick.toml"),
            vec!["--can", "simulated"],
            2,
            "expected a drive on CAN at every joint",
        ),
    ];
    for (scene, options, exit, part) in cases {
        let lines = file("drive_nothing.txt");
        std::fs::write(&lines, "").unwrap();
        let mut program = at_the_top();
        let (code, out, error) =
            told(program.arg("drive").arg(scene).args(&options).arg("--script").arg(lines).output().unwrap());
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(code, exit, "{options:?}: {out}{error}");
        assert!(error.contains(part), "{options:?}: {error}");
    }
}

#[test]
fn the_timing_of_this_computer_is_measured_without_an_arm() {
    let scene = scene("timing");
    let mut program = at_the_top();
    program.arg("drive").arg(&scene).args(["--check-timing", "1", "--json"]);
    let (_, out, error) = told(program.output().unwrap());
    let found: serde_json::Value = serde_json::from_str(&out).unwrap_or_else(|why| panic!("{why}: {out}{error}"));
    let ticks = found["ticks"].as_u64().unwrap();
    assert!((80..=101).contains(&ticks), "{found}");
    assert!(found["rate_worst"].as_f64().unwrap() <= found["rate_p99_99"].as_f64().unwrap(), "{found}");
}
