//! `connect` and `replay` as used by a script: in a dry run on the desk, and with a board on a port.

use crate::live_board::LiveBoard;
use crate::program::{at_the_top, new, told};
use board::session::frame_log::{Direction, Entry, Log, Writer};
use link::convert::joints;
use link::{Actuation, Frame};
use robot_compiler::SceneFile;
use serialport::{SerialPort as _, TTYPort};
use std::path::{Path, PathBuf};

const SCENE: &str = "scenes/planar2r_swing.toml";

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn arming_says_which_terms_auto_left_out_and_on_which_motion_it_judged_them() {
    let script = "arm\nhome\nconfirm\narm\nstatus\n";
    let (_, out, error) = connect_to("scenes/puma560_auto.toml", "auto", script, &["--target", "desk"]);
    assert_eq!(error, "", "{out}");
    let scene = SceneFile::load(Path::new("../scenes/puma560_auto.toml")).unwrap();
    let names: Vec<&str> = scene.model.given_up().iter().map(|term| term.name()).collect();
    assert!(!names.is_empty());
    let line = format!(
        "model without {}: left out by `terms = \"auto\"`, judged on the motion of puma560_auto alone",
        names.join(", ")
    );
    let lines: Vec<&str> = out.lines().collect();
    let armed = lines.iter().position(|line| *line == "arm: armed").unwrap();
    // The line is printed once, after the accepted request and not after the rejected one.
    assert!(lines[armed + 1].starts_with(&line) && lines[armed + 1].contains("`jog` and `goto`"), "{out}");
    assert_eq!(out.matches("left out by").count(), 1, "{out}");
    // A scene with an explicit list of terms.
    let (_, out, _) = connect("named", script, &["--target", "desk"]);
    assert!(out.contains("arm: armed") && !out.contains("left out"), "{out}");
}

/// Runs a script. Returns exit code, standard output and standard error.
fn connect(name: &str, script: &str, more: &[&str]) -> (i32, String, String) {
    connect_to(SCENE, name, script, more)
}

fn connect_to(scene: &str, name: &str, script: &str, more: &[&str]) -> (i32, String, String) {
    let path = file(&format!("{name}.txt"));
    std::fs::write(&path, script).unwrap();
    for pair in more.windows(2).filter(|pair| pair[0] == "--record") {
        new(Path::new(pair[1]));
    }
    told(at_the_top().args(["connect", scene, "--script"]).arg(&path).args(more).output().unwrap())
}

fn replay(log: &Path) -> (i32, String, String) {
    told(at_the_top().args(["connect", "replay"]).arg(log).output().unwrap())
}

/// A record with its entries changed.
fn changed(log: &Path, change: impl FnOnce(&mut Vec<Entry>)) -> PathBuf {
    let read = Log::new(std::fs::read(log).unwrap()).unwrap();
    let mut entries: Vec<Entry> = read.entries().collect::<Result<_, _>>().unwrap();
    change(&mut entries);
    let path = log.with_extension("changed.log");
    let mut writer = Writer::new(std::fs::File::create(&path).unwrap(), &read.head).unwrap();
    for Entry { way, missed, at, frame } in &entries {
        writer.push(*way, *missed, *at, frame).unwrap();
    }
    path
}

/// Index and tick of a status with torque in the middle of a record.
fn a_status_with_torque(entries: &[Entry]) -> (usize, u32) {
    let drives = |entry: &Entry| match &entry.frame {
        Frame::Status(status) if matches!(status.actuation, Some(Actuation::Drive { .. })) => Some(status.tick),
        _ => None,
    };
    let all: Vec<_> = entries.iter().enumerate().filter_map(|(i, entry)| drives(entry).map(|tick| (i, tick))).collect();
    all[all.len() / 2]
}

#[test]
fn a_dry_run_does_what_is_asked_and_says_why_not_and_its_record_has_the_same_bits_again() {
    let log = file("dry-run.log");
    let script = "arm\nhome\nconfirm\narm\nrun\nwait\njog elbow 0.2 0.5\nwait 0.2\npress\ndump\nrelease\nwait 0.3\nclear\nstatus\n";
    let (code, out, error) = connect("dry run", script, &["--target", "desk", "--record", log.to_str().unwrap()]);
    assert_eq!((code, error.as_str()), (3, ""), "something was refused: {out}");
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].starts_with("arm: rejected: the arm has not been homed; `home`"), "{out}");
    assert_eq!(lines[1..4], ["home: homing", "confirm: idle, homed", "arm: armed"]);
    assert!(lines[4].starts_with("run: running; ") && lines[4].ends_with("3.60 s of motion"), "{out}");
    assert!(lines[5].starts_with("wait: arrived; furthest off: "), "{out}");
    assert_eq!(lines[6], "jog: running; 0.50 s");
    assert_eq!(lines[7], "press: fault 9: emergency stop; check the emergency stop; release it, then `clear`");
    assert_eq!(lines[8], "dump: 39 ticks");
    for line in
        ["release: fault 9: emergency stop; check the emergency stop; release it, then `clear`", "clear: idle, homed"]
    {
        assert!(lines.contains(&line), "{line}: {out}");
    }

    let (code, out, _) = replay(&log);
    assert_eq!(code, 0, "{out}");
    let ticks: u64 = out.strip_suffix(" ticks compared, 0 differ\n").unwrap().parse().unwrap();
    assert!(ticks > 3800, "{ticks}");

    let mut of = 0;
    let flipped = changed(&log, |entries| {
        let (index, tick) = a_status_with_torque(entries);
        let Frame::Status(status) = &mut entries[index].frame else { panic!("no status") };
        let Some(Actuation::Drive { torque, .. }) = &mut status.actuation else { panic!("no torque") };
        torque[0] = f32::from_bits(torque[0].to_bits() ^ 1);
        of = tick;
    });
    let (code, out, _) = replay(&flipped);
    assert_eq!(code, 1);
    assert!(out.starts_with(&format!("{ticks} ticks compared, 1 differ\nfirst in tick {of}: actuation\n")), "{out}");
}

#[test]
fn a_board_on_a_port_is_operated_and_its_record_has_the_same_bits_again() {
    let scene = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(SCENE)).unwrap();
    let board = LiveBoard::start::<2>(scene);
    let log = file("live.log");
    let script = "home\nconfirm\narm\njog shoulder 0.1 0.3\nwait\njog 1 0.1 0.6\nwait 0.2\nhold\ndisarm\n";
    let key = board.key.to_str().unwrap();
    let more = ["--port", &board.port, "--key", key, "--record", log.to_str().unwrap()];
    let (code, out, error) = connect("live", script, &more);
    assert_eq!((code, error.as_str()), (0, ""), "{out}");
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[..4], ["home: homing", "confirm: idle, homed", "arm: armed", "jog: running; 0.30 s"]);
    assert!(lines[4].starts_with("wait: arrived; furthest off: "), "{out}");
    assert_eq!(lines[5..], ["jog: running; 0.60 s", "hold: holding: as requested", "disarm: idle, homed"]);

    // A second session with the same board, without a restart of the board and without a record.
    let (code, out, error) = connect("again", "arm\n", &["--port", &board.port, "--key", key]);
    assert_eq!((code, error.as_str()), (3, ""));
    assert!(out.starts_with("arm: rejected: the arm has not been homed"), "{out}");

    let (code, out, _) = replay(&log);
    assert_eq!(code, 0, "{out}");
    let ticks: u32 = out.strip_suffix(" ticks compared, 0 differ\n").unwrap().parse().unwrap();
    assert!(ticks > 500, "{ticks}");

    let mut lost = 0;
    let shorter = changed(&log, |entries| {
        let (index, tick) = a_status_with_torque(entries);
        entries.remove(index);
        lost = tick;
    });
    let (code, out, _) = replay(&shorter);
    assert_eq!(code, 1);
    let end = format!(
        "cannot be replayed from tick {lost} on: its status is missing; the next one is that of tick {}\n",
        lost + 1
    );
    let compared = out.strip_suffix(&end).and_then(|before| before.strip_suffix(" ticks compared, 0 differ\n"));
    // The repeated hello adds some ticks before those counted from the last hello.
    let compared: u32 = compared.unwrap().parse().unwrap();
    assert!(compared >= lost - 1 && compared < ticks, "{compared} of {ticks}, lost {lost}");
}

#[test]
fn parameters_are_read_back_and_changed_where_no_torque_jumps_and_its_record_has_the_same_bits_again() {
    const TUNABLE: &str = "host-sim/tests/fixtures/tunable.toml";
    let log = file("parameters.log");
    let script = "get elbow position gain\nset elbow position gain 1601\nset 2 position gain 500\nset elbow torque limit 1\n\
                  payload 3.6\npayload 1 2 0 0\nhome\nconfirm\narm\npayload 0.5\ngoto -0.6 0.8 1\nwait\npayload 3\n\
                  get payload mass\nwait 0.5\nset shoulder velocity gain 50\nget\n";
    let more = ["--target", "desk", "--record", log.to_str().unwrap()];
    let (code, out, error) = connect_to(TUNABLE, "parameters", script, &more);
    assert_eq!((code, error.as_str()), (3, ""), "something was refused: {out}");
    let lines: Vec<&str> = out.lines().collect();
    let expected = [
        "get: elbow position gain 400 1/s^2 (100 to 1600)",
        "set: rejected: the value is outside its bounds",
        "set: elbow position gain 500 1/s^2 (100 to 1600)",
        "set: rejected: limits and encoder numbers are fixed when the firmware is built, even with `tunable = true`; change them in \
         the robot file, then build and flash the firmware again",
        "payload: rejected: the value is outside its bounds: 3.600 kg, allowed 0 to 3.500 kg (`payload_mass` in [safety])",
        // The tip is 0.8 m from the last joint.
        "payload: rejected: the value is outside its bounds: its centre of mass is 2.800 m from the last link's origin, allowed 1.000 m \
         (`payload_radius` in [safety]); are X Y Z in metres, in the tip frame?",
        "home: homing",
        "confirm: idle, homed",
        "arm: armed",
    ];
    assert_eq!(lines[..expected.len()], expected, "{out}");
    let taken = "payload: 0.5 kg at 0.000 0.000 0.000 m in the tip frame (0 to 3.5 kg); torque to hold the arm changes by shoulder ";
    assert!(lines[9].starts_with(taken), "{out}");
    // The whole change at once would make the torque jump; in parts it does not.
    assert!(lines[12].starts_with("payload: 3 kg at 0.000 0.000 0.000 m in the tip frame (0 to 3.5 kg); "), "{out}");
    assert_eq!(lines[13], "get: payload mass 3 kg (0 to 3.5)");
    assert_eq!(lines[14], "set: shoulder velocity gain 50 1/s (20 to 80)");
    assert_eq!(lines[15], "get: 36 parameters");
    for line in [
        "  shoulder torque limit 120 N m (fixed)",
        "  elbow lower limit -6.2831855 rad (fixed)",
        "  gravity y -9.81 m/s^2 (live)",
        // The payload is given in the tip frame, and reported in it.
        "  payload first moment x 0 kg m (live, tip frame)",
    ] {
        assert!(lines.contains(&line), "{line}: {out}");
    }
    let (code, out, _) = replay(&log);
    assert!(code == 0 && out.ends_with(" ticks compared, 0 differ\n"), "{out}");

    // In a scene without these options, the values stay as built in, and a payload is rejected.
    let (code, out, _) =
        connect("fixed", "get 1 position gain\nset 1 position gain 1\npayload 1\n", &["--target", "desk"]);
    assert_eq!(code, 3);
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].ends_with("1/s^2 (fixed)"), "{out}");
    assert!(
        lines[1].starts_with("set: rejected: the firmware holds gains") && lines[1].contains("`tunable = true`"),
        "{out}"
    );
    assert!(lines[2].starts_with("payload: rejected: the scene has no live payload;"), "{out}");
}

/// After a program has died, the board holds the arm. The next program continues: nothing falls, and the payload is known.
#[test]
fn a_host_that_comes_back_to_an_arm_that_is_held_continues_its_session() {
    let scene = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(SCENE)).unwrap();
    let board = LiveBoard::start::<2>(scene);
    let key = board.key.to_str().unwrap();
    let script = file("killed.txt");
    std::fs::write(&script, "home\nconfirm\narm\njog elbow 0.2 0.3\nwait\nstatus\nwait 600\n").unwrap();
    let mut first = at_the_top()
        .args(["connect", SCENE, "--script"])
        .arg(&script)
        .args(["--port", &board.port, "--key", key])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let out = std::io::BufReader::new(first.stdout.take().unwrap());
    let armed = std::io::BufRead::lines(out).map_while(Result::ok).any(|line| line.contains("room for"));
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(armed);
    let script = "status\njog elbow 0.1 0.3\nwait\nhold\ndisarm\n";
    // A script without `--take-over` does nothing.
    let (code, out, error) = connect("not_back", script, &["--port", &board.port, "--key", key]);
    assert_eq!((code, error.as_str()), (3, ""), "{out}");
    assert!(out.contains("`--take-over` lets a script go on with it") && !out.contains("jog: "), "{out}");
    let (code, out, error) = connect("back", script, &["--port", &board.port, "--key", key, "--take-over"]);
    assert_eq!((code, error.as_str()), (0, ""), "{out}");
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].starts_with("the board continues the session of an earlier host: "), "{out}");
    assert!(lines[0].contains("; law computed-torque"), "{out}");
    assert!(lines.iter().any(|line| line.starts_with("wait: arrived")), "{out}");
    assert_eq!(lines.last(), Some(&"disarm: idle, homed"), "{out}");
}

#[test]
fn the_end_of_the_input_stops_and_disarms() {
    let log = file("end.log");
    let script = "home\nconfirm\narm\nrun\nwait 0.2\n";
    let (code, out, _) = connect("end", script, &["--target", "desk", "--record", log.to_str().unwrap()]);
    assert_eq!(code, 0);
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[lines.len() - 2..], ["hold: holding: as requested", "disarm: idle, homed"], "{out}");
    assert_eq!(replay(&log).0, 0);
}

#[cfg(unix)]
#[test]
fn ctrl_c_while_a_script_s_arm_parks_stops_it_and_another_disarms_it() {
    use std::io::{BufRead as _, BufReader};
    use std::process::{Command, Stdio};
    let script = file("park.txt");
    std::fs::write(&script, "home\nconfirm\narm\n").unwrap();
    let mut child = at_the_top()
        .args(["connect", "scenes/yam_move.toml", "--target", "desk", "--simulate-link", "--script"])
        .arg(&script)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let press = |id: u32| assert!(Command::new("kill").args(["-INT", &id.to_string()]).status().unwrap().success());
    let id = child.id();
    let mut said = Vec::new();
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        let line = line.unwrap();
        if line.starts_with("park: running") || line.starts_with("the arm stays held") {
            press(id);
        }
        said.push(line);
    }
    let code = child.wait().unwrap().code();
    let end: Vec<&str> = said.iter().rev().take(4).rev().map(String::as_str).collect();
    let [sent, confirmed, held, disarmed] = end[..] else { panic!("{said:?}") };
    assert_eq!((sent, disarmed), ("stop: sent", "disarm: idle, homed"), "{said:?}");
    assert!(confirmed.starts_with("stop: confirmed: holding"), "{said:?}");
    assert!(held.starts_with("the arm stays held"), "{said:?}");
    assert_eq!(code, Some(130));
}

#[test]
fn what_cannot_be_is_bad_input_with_its_line_and_the_arm_is_disarmed_first() {
    let ready = "home\nconfirm\narm\n";
    for (line, message) in [
        ("jog 3 0.1", "jog: JOINT is 3, expected a number from 1 to 2 or one of shoulder, elbow"),
        ("goto 7 0", "goto: joint 1 at point 2 is at 7, outside its limits"),
        ("jog 1 1 0.1", "leave SECONDS away"),
    ] {
        let (code, out, error) = connect("wrong", &format!("{ready}{line}\nstatus\n"), &["--target", "desk"]);
        assert_eq!(code, 2, "{line}: {out}");
        assert!(out.ends_with("disarm: idle, homed\n"), "{out}");
        assert!(error.contains("wrong.txt:4: ") && error.contains(message), "{line}: {error}");
    }
}

#[test]
fn every_line_of_json_is_an_object_with_what_the_board_says() {
    let (code, out, _) = connect("json", "home\nconfirm\narm\nstatus\nrun\nquit\n", &["--target", "desk", "--json"]);
    assert_eq!(code, 0);
    let all: Vec<serde_json::Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let about: Vec<&str> = all.iter().map(|line| line["about"].as_str().unwrap()).collect();
    assert_eq!(about, ["home", "confirm", "arm", "status", "run", "hold", "disarm"]);
    assert_eq!((&all[3]["status"]["state"], all[3]["status"]["q"].as_array().unwrap().len()), (&"armed".into(), 2));
}

#[test]
fn a_board_of_another_scene_is_refused_by_its_hash() {
    let other = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_sine.toml");
    let board = LiveBoard::start::<2>(SceneFile::load(&other).unwrap());
    let (code, out, error) = connect("other", "home\n", &["--port", &board.port, "--key", board.key.to_str().unwrap()]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(error.contains("the firmware was built for another robot or scene: hash "), "{error}");
}

#[test]
fn a_port_without_a_board_ends_in_time() {
    let (_board, host) = TTYPort::pair().unwrap();
    let port = host.name().unwrap();
    drop(host);
    let (code, _, error) = connect("silent", "home\n", &["--port", &port]);
    assert_eq!(code, 1);
    assert!(error.contains("the controller is silent: no answer to a join came within 2s"), "{error}");
    let (code, _, error) = connect("absent", "home\n", &["--port", "/dev/no-such-port"]);
    assert_eq!(code, 1);
    assert!(error.contains("/dev/no-such-port"), "{error}");
}

#[test]
fn a_record_that_is_none_or_another_s_is_bad_input() {
    let none = file("none.log");
    std::fs::write(&none, "tick,state\n").unwrap();
    let (code, _, error) = replay(&none);
    assert_eq!(code, 2);
    assert!(error.contains("none.log: byte 0: no record of a session"), "{error}");

    let log = file("hash.log");
    assert_eq!(connect("hash", "home\n", &["--target", "desk", "--record", log.to_str().unwrap()]).0, 0);
    let other =
        at_the_top().args(["connect", "replay", "--scene", "scenes/planar2r_sine.toml"]).arg(&log).output().unwrap();
    let (code, _, error) = told(other);
    assert_eq!(code, 2);
    assert!(error.contains("the record is of another robot, scene or controller"), "{error}");
}

#[test]
fn a_record_keeps_what_was_sent_and_received_in_order() {
    let log = file("order.log");
    assert_eq!(connect("order", "home\n", &["--target", "desk", "--record", log.to_str().unwrap()]).0, 0);
    let read = Log::new(std::fs::read(&log).unwrap()).unwrap();
    assert!(read.head.scene.ends_with(SCENE));
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(SCENE)).unwrap();
    assert_eq!(read.head.text, text);
    let kinds: Vec<(Direction, &str)> =
        read.entries().map(Result::unwrap).map(|entry| (entry.way, kind(&entry.frame))).collect();
    let sent = |kind| (Direction::Sent, kind);
    let tick = [sent("measurement"), (Direction::Received, "status")];
    let asked =
        [sent("request"), sent("measurement"), (Direction::Received, "answer"), (Direction::Received, "status")];
    let begin = [sent("hello"), sent("lines"), sent("live")];
    assert_eq!(kinds, [&begin[..], &tick, &asked, &asked].concat());
}

fn kind(frame: &Frame) -> &'static str {
    match frame {
        Frame::Hello(_) => "hello",
        Frame::Lines(_) => "lines",
        Frame::Live(_) => "live",
        Frame::Measurement(_) => "measurement",
        Frame::Request(_) => "request",
        Frame::Status(_) => "status",
        Frame::Answer(_) => "answer",
        _ => "other",
    }
}

#[test]
fn a_status_that_can_be_replayed_takes_as_many_bytes_as_the_docs_say() {
    let six = |sensed| link::Status {
        tick: 1_000_000,
        taken: 40_000,
        state: link::StateCode::Running,
        cause: 0,
        joint: None,
        homed: true,
        refused: None,
        kept: false,
        room: 9,
        actuation: Some(Actuation::Drive { torque: joints(&[1.0; 6]), limits: joints(&[0; 6]) }),
        sensed: Some(link::SensedLines { sensed, age_ticks: joints(&[0; 6]), lines: link::Lines::CALM }),
        extra: link::ExtraFields::Nothing,
        cost: None,
    };
    let keys =
        link::Key::new([1; 32]).session(link::seal::Side::Board, &link::seal::Transcript::new(&[2; 16], &[3; 16]));
    let bytes = |sensed| {
        let mut sealed = link::Encoder::new();
        sealed.seal_with(keys.sending.clone());
        sealed.encode(&Frame::Status(six(sensed))).unwrap().len()
    };
    let state = link::Sensed::State { q: joints(&[1.0; 6]), qd: joints(&[1.0; 6]) };
    assert_eq!((bytes(state), bytes(link::Sensed::Counts(joints(&[1_000_000; 6])))), (129, 98));
}

/// A script that leaves an arm with a `rest` pose armed and away from it ends with the arm parked and without torque.
#[test]
fn a_script_parks_an_arm_without_brakes_and_disarms_it() {
    for (name, script) in [
        ("rest_disarm", "disarm\n"),
        ("rest_quit", "quit\n"),
        ("rest_end", ""),
        ("rest_park", "park\ndisarm\n"),
        ("rest_moved", "jog shoulder 0.1\nwait\nhold\ndisarm\n"),
    ] {
        let script = format!("home\nconfirm\narm\n{script}");
        let (code, out, error) = connect_to("scenes/yam_move.toml", name, &script, &["--target", "desk"]);
        assert_eq!((code, error.as_str()), (0, ""), "{name}: {out}");
        let (parked, after) = out.split_once("park: running; ").unwrap_or_else(|| panic!("{name}: {out}"));
        assert!(!parked.contains("disarm: "), "{name}: {out}");
        let after: Vec<&str> = after.lines().skip(1).collect();
        assert_eq!(after, ["hold: holding: as requested", "disarm: idle, homed"], "{name}: {out}");
    }
}

/// More frames are lost than a report can count: the host still knows which of its frames the board has taken.
#[test]
fn a_cable_that_was_cut_for_long_is_plugged_in_and_the_arm_is_armed_again() {
    let script =
        "home\nconfirm\narm\ncut host\nwait 25\nstatus\nplug host\nstatus\nhold\ndisarm!\narm\nstatus\ndisarm!\n";
    let (_, out, error) = connect_to("scenes/yam_move.toml", "cut", script, &["--target", "desk", "--simulate-link"]);
    assert_eq!(error, "", "{out}");
    let lines: Vec<&str> = out.lines().collect();
    let old = lines
        .iter()
        .position(|line| line.starts_with("the controller is not heard: this is its last report, "))
        .unwrap();
    let plugged = lines.iter().position(|line| *line == "plug: host").unwrap();
    assert!(old < plugged, "{out}");
    // After that, `status` prints the present state: the board lowers the arm.
    assert!(lines[plugged..].iter().any(|line| line.starts_with("lowering; homed")), "{out}");
    assert!(out.contains("host link: at least 255 frames lost"), "{out}");
    assert!(lines[plugged..].contains(&"arm: armed") && lines.last() == Some(&"disarm: idle, homed"), "{out}");
}

/// A drive that was off the bus has latched an error. The host's `clear` clears it too.
#[test]
fn a_drive_that_was_cut_off_is_cleared_by_the_host_s_clear() {
    let script = "home\nconfirm\narm\ncut drive elbow\nwait 1\nplug drive elbow\nwait 0.5\nclear\nwait 0.5\nclear\n";
    let (_, out, error) =
        connect_to("scenes/yam_move.toml", "cut_drive", script, &["--target", "desk", "--simulate-link"]);
    assert_eq!(error, "", "{out}");
    let lines: Vec<&str> = out.lines().collect();
    let plugged = lines.iter().position(|line| *line == "plug: drive of elbow").unwrap();
    let clears: Vec<_> = lines[plugged..].iter().filter(|line| line.starts_with("clear: ")).collect();
    assert!(clears[0].contains("fault 11: the drive reports a fault (joint 3)"), "{out}");
    // The arm has fallen beyond its limits in the meantime.
    assert!(clears[1].contains("fault 4: position out of bounds"), "{out}");
}

/// Beyond a limit, but within the guard's margin: the arm is held at its position, and may be moved back inside.
#[test]
fn an_arm_that_was_armed_beyond_a_limit_is_moved_inward_and_not_outward() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let robot = std::fs::read_to_string(root.join("robots/planar2r.toml")).unwrap();
    let elbow = "position = [-6.283185307179586, 6.283185307179586], velocity = 10.0";
    assert!(robot.contains(elbow));
    std::fs::write(file("beyond_arm.toml"), robot.replace(elbow, "position = [-0.03, 3.0], velocity = 10.0")).unwrap();
    let scene = "name = \"beyond\"\nrobot = \"beyond_arm.toml\"\nduration = 1.0\n\n\
                 [model]\ngravity = [0.0, -9.81, 0.0]\n[plant]\nstart = [0.0, -0.03]\npayload = { mass = 0.1, com = [0.9, 0.0, 0.0] }\n\
                 [motion]\nkind = \"quintic\"\npoints = [{ q = [0.0, 0.1] }, { q = [0.0, 0.2], duration = 0.5 }]\n";
    std::fs::write(file("beyond.toml"), scene).unwrap();
    let script = "home\nconfirm\narm\nwait 0.5\njog elbow -0.01 0.3\n";
    let (code, out, error) =
        connect_to(file("beyond.toml").to_str().unwrap(), "outward", script, &["--target", "desk"]);
    assert_eq!(code, 2, "{out}");
    assert!(out.contains("arm: armed") && error.contains("outside its limits"), "{out}{error}");
    let script = "home\nconfirm\narm\nwait 0.5\njog elbow 0.1 0.5\nwait\nrun\nwait\nstatus\nhold\ndisarm!\n";
    let (code, out, error) = connect_to(file("beyond.toml").to_str().unwrap(), "inward", script, &["--target", "desk"]);
    assert_eq!((code, error.as_str()), (0, ""), "{out}");
    assert_eq!(out.matches("wait: arrived").count(), 2, "{out}");
}
