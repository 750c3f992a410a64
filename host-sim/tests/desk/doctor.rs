//! `doctor` with scripted tools on the path, and scripted firmware at a pseudo-terminal.
#![cfg(unix)]

use crate::program::{at_the_top, told};
use board::chip::hello;
use link::{Access, BoardChannel, Decoder, Frame, Hello, Key, NonceSource, PROTOCOL_VERSION, Pacing};
use robot_compiler::SceneFile;
use serde_json::Value;
use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

const SCENE: &str = "scenes/examples/mit6_wave.toml";

/// A folder of scripts that replace tools; the program finds no other tools.
struct Tools(PathBuf);

impl Tools {
    fn new(test: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("doctor").join(test);
        std::fs::remove_dir_all(&folder).ok();
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn with(self, name: &str, script: &str) -> Self {
        let path = self.0.join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        self
    }

    /// A complete set: compiler with the chip's target, emulator, and a probe.
    fn complete(test: &str) -> Self {
        let tools = Self::new(test);
        let target = tools.0.join("lib/rustlib/thumbv7em-none-eabihf/lib");
        std::fs::create_dir_all(target).unwrap();
        let sysroot = tools.0.display().to_string();
        let rustc =
            format!("case $1 in --version) echo 'rustc 1.95.0 (59807616e 2026-04-14)';; *) echo '{sysroot}';; esac");
        let probe = "case $1 in --version) echo 'probe-rs 0.32.0';; \
                     *) echo 'The following debug probes were found:'; echo '[0]: STLink V3 -- 0483:374e:0030 (ST-LINK)';; esac";
        tools
            .with("rustc", &rustc)
            .with("qemu-system-arm", "echo 'QEMU emulator version 7.2.22'")
            .with("probe-rs", probe)
    }

    fn doctor(&self, arguments: &[&str]) -> (i32, String, String) {
        told(at_the_top().arg("doctor").args(arguments).env("PATH", &self.0).output().unwrap())
    }

    fn report(&self, arguments: &[&str]) -> (i32, Value) {
        let (code, printed, error) = self.doctor(&[arguments, &["--json"]].concat());
        assert_eq!(error, "");
        (code, serde_json::from_str(&printed).unwrap())
    }
}

/// The check of this name: its state, its finding, and whether it has advice.
fn check(report: &Value, name: &str) -> (String, String, bool) {
    let checks = report["checks"].as_array().unwrap();
    let check = checks.iter().find(|check| check["name"] == name).unwrap_or_else(|| panic!("no {name} in {report}"));
    (check["state"].as_str().unwrap().into(), check["found"].as_str().unwrap().into(), check["advice"].is_string())
}

#[test]
fn with_every_tool_nothing_is_wrong_for_any_use() {
    let (code, report) = Tools::complete("every").report(&["--for", "desk,emulator,flash"]);
    assert_eq!((code, &report["problems"]), (0, &Value::from(0)), "{report}");
    assert_eq!(report["for"], serde_json::json!(["desk", "emulator", "flash"]));
    let found = |name| check(&report, name);
    assert_eq!(found("rust"), ("ok".into(), "rustc 1.95.0 (59807616e 2026-04-14)".into(), false));
    assert_eq!(found("emulator").1, "QEMU emulator version 7.2.22");
    assert_eq!(found("probe").1, "[0]: STLink V3 -- 0483:374e:0030 (ST-LINK)");
    assert!(found("chip target").1.contains("thumbv7em-none-eabihf, installed"));
}

#[test]
fn what_a_use_does_not_need_is_a_warning_to_it_and_a_problem_to_another() {
    let tools = Tools::new("uses").with("rustc", "echo 'rustc 1.95.0'");
    for (uses, needed) in [("desk", [].as_slice()), ("emulator", &["emulator"]), ("flash", &["probe-rs"])] {
        let (code, report) = tools.report(&["--for", uses]);
        for name in ["emulator", "probe-rs"] {
            let state = if needed.contains(&name) { "problem" } else { "warning" };
            assert_eq!((check(&report, name).0.as_str(), check(&report, name).2), (state, true), "{uses} {report}");
        }
        assert_eq!(code, if needed.is_empty() { 0 } else { 2 }, "{uses}");
    }
}

#[test]
fn an_old_a_broken_and_a_missing_compiler_are_problems_for_every_use() {
    let old = Tools::new("old").with("rustc", "echo 'rustc 1.80.1 (3f5fd8dd4 2024-08-06)'");
    let (code, report) = old.report(&[]);
    assert_eq!((code, check(&report, "rust").0.as_str()), (2, "problem"));
    assert!(
        check(&report, "rust").1.contains("1.80.1") && check(&report, "rust").1.contains("expected 1.95"),
        "{report}"
    );
    let (code, report) = Tools::new("broken").with("rustc", "echo no toolchain is installed >&2; exit 1").report(&[]);
    assert_eq!(code, 2);
    assert!(check(&report, "rust").1.contains("no toolchain is installed"), "{report}");
    let (code, printed, _) = Tools::new("none").doctor(&[]);
    assert_eq!(code, 2);
    assert!(
        printed.starts_with("problem  rust          no rustc on the path\n                       install"),
        "{printed}"
    );
    assert!(printed.lines().last().unwrap().starts_with("1 problem, "), "{printed}");
}

#[test]
fn a_probe_that_is_missing_or_shut_is_told_apart() {
    let with = |test, list: &str| {
        let tools = Tools::complete(test)
            .with("probe-rs", &format!("case $1 in list) echo '{list}';; *) echo probe-rs;; esac"));
        let (code, report) = tools.report(&["--for", "flash"]);
        (code, check(&report, "probe"))
    };
    let (code, none) = with("no-probe", "No debug probes were found.");
    assert_eq!((code, none.1.as_str()), (2, "none connected"));
    let (code, shut) = with("shut-probe", "[0]: STLink V3 -- 0483:374e:0030 (ST-LINK) (inaccessible)");
    assert_eq!((code, shut.0.as_str()), (2, "problem"));
    assert!(shut.1.ends_with("(inaccessible)"), "{shut:?}");
}

#[test]
fn a_scene_that_is_wrong_is_refused_with_its_line() {
    let folder = Tools::complete("bad-scene");
    let scene = folder.0.join("scene.toml");
    std::fs::write(&scene, "name = \"x\"\nrobot = \"nowhere.toml\"\n").unwrap();
    let (code, printed, error) = folder.doctor(&["--scene", scene.to_str().unwrap()]);
    assert_eq!((code, printed.as_str()), (2, ""));
    assert!(error.contains("scene.toml:2:9") && error.contains("nowhere.toml"), "{error}");
}

/// Firmware at the far end of a terminal. It answers a join like the real firmware, in the same or another protocol version.
struct Board {
    name: String,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Vec<Frame>>,
}

impl Board {
    /// `answer` returns the bytes of the answer to a join; an empty answer means silence.
    fn start(mut answer: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let (mut firmware, port) = TTYPort::pair().unwrap();
        let name = port.name().unwrap();
        // This end holds the lock that excludes other processes.
        drop(port);
        firmware.set_timeout(Duration::from_millis(20)).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let (mut decoder, mut heard, mut packet, mut byte) = (Decoder::new(), Vec::new(), Vec::new(), [0]);
            while !stopped.load(Ordering::Relaxed) {
                if firmware.read(&mut byte).is_err() {
                    // Reading returns at once if nothing arrived or the other end is closed.
                    std::thread::sleep(Duration::from_millis(1));
                    continue;
                }
                packet.push(byte[0]);
                if let Some(received) = decoder.push(byte[0]) {
                    firmware.write_all(&answer(&packet)).unwrap();
                    heard.extend(received.map(|received| received.frame));
                    packet.clear();
                }
            }
            heard
        });
        Self { name, stop, thread }
    }

    /// All frames received.
    fn heard(self) -> Vec<Frame> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

/// Hello of firmware built from the scene.
fn built() -> Hello {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(SCENE);
    let scene = SceneFile::load(&path).unwrap();
    hello(&scene, &scene.robot.model::<6>().unwrap(), Pacing::LockStep)
}

/// Answer as the firmware does.
fn like_the_firmware(own: Hello, access: Access) -> impl FnMut(&[u8]) -> Vec<u8> {
    let mut channel = BoardChannel::new(access);
    move |packet| {
        let mut bytes = Vec::new();
        let mut nonce = || Some(([7; 16], NonceSource::Generator));
        for &byte in packet {
            channel.push(byte, &own, &mut nonce, &mut |said| bytes.extend_from_slice(said));
        }
        bytes
    }
}

const KEY: [u8; 32] = [0x5a; 32];

#[test]
fn firmware_of_this_scene_is_known_by_its_hash_and_is_not_started() {
    let board = Board::start(like_the_firmware(built(), Access::Key(&KEY)));
    let (code, report) = Tools::complete("board").report(&["--port", &board.name, "--scene", SCENE]);
    assert_eq!(code, 0, "{report}");
    let firmware = check(&report, "firmware");
    assert_eq!(firmware.0, "ok");
    assert!(
        firmware.1.contains(&format!("protocol version {PROTOCOL_VERSION}, hash {:016x}", built().robot)),
        "{firmware:?}"
    );
    assert_eq!(check(&report, "robot hash"), ("ok".into(), "the scene's".into(), false));
    let trust = check(&report, "link key");
    assert_eq!(trust.0, "ok");
    assert!(trust.1.contains("a key; `--key FILE` checks which; nonces from the chip's random"), "{trust:?}");
    // The board received only the request for a challenge: no session began, and none ended.
    let heard = board.heard();
    assert!(matches!(heard[..], [Frame::Join(_)]), "{heard:?}");
}

#[test]
fn whom_the_board_trusts_is_told_and_its_key_is_checked_without_a_session() {
    let tools = Tools::complete("trust");
    let path = tools.0.join("arm.key");
    board::key::save(&Key::new(KEY), &path).unwrap();
    let path = path.to_str().unwrap();
    let asked = |access, more: &[&str]| {
        let board = Board::start(like_the_firmware(built(), access));
        let (code, report) = tools.report(&[&["--port", &board.name], more].concat());
        assert!(board.heard().iter().all(|frame| matches!(frame, Frame::Join(_))));
        (code, check(&report, "link key"))
    };
    let (code, known) = asked(Access::Key(&KEY), &["--key", path]);
    assert_eq!((code, known.0.as_str()), (0, "ok"));
    assert!(known.1.starts_with("this key; "), "{known:?}");
    let (code, other) = asked(Access::Key(&[1; 32]), &["--key", path]);
    assert_eq!((code, other.0.as_str()), (2, "problem"));
    assert!(other.1.contains("does not have this key"), "{other:?}");
    let (code, none) = asked(Access::NoKey, &[]);
    assert_eq!((code, none.0.as_str(), none.1.as_str()), (0, "warning", "none"));
    let (code, insecure) = asked(Access::Insecure, &[]);
    assert_eq!((code, insecure.0.as_str()), (0, "warning"));
    assert!(insecure.1.contains("--insecure"), "{insecure:?}");
    let (code, insecure) = asked(Access::Insecure, &["--key", path]);
    assert_eq!((code, insecure.0.as_str()), (2, "problem"));
}

#[test]
fn firmware_of_another_scene_is_a_problem_with_both_hashes() {
    let board = Board::start(like_the_firmware(Hello { robot: 0xbad, ..built() }, Access::NoKey));
    let tools = Tools::complete("other");
    let (code, report) = tools.report(&["--port", &board.name, "--scene", SCENE]);
    let hash = check(&report, "robot hash");
    assert_eq!((code, hash.0.as_str(), hash.2), (2, "problem", true));
    assert!(hash.1.contains("0000000000000bad") && hash.1.contains(&format!("{:016x}", built().robot)), "{hash:?}");
    // Without a scene there is nothing to compare with; the check only finds that firmware is present.
    let (code, report) = tools.report(&["--port", &board.name]);
    assert_eq!((code, check(&report, "firmware").0.as_str()), (0, "ok"));
    board.heard();
}

#[test]
fn firmware_of_another_rate_is_not_the_scene_s() {
    let board = Board::start(like_the_firmware(Hello { rate_hz: 500.0, ..built() }, Access::NoKey));
    let (code, report) = Tools::complete("rate").report(&["--port", &board.name, "--scene", SCENE]);
    assert_eq!((code, check(&report, "robot hash").0.as_str()), (2, "problem"));
    board.heard();
}

#[test]
fn firmware_of_another_protocol_is_named_by_its_version() {
    let board = Board::start(|_| packet_of_version(PROTOCOL_VERSION + 1));
    let (code, report) = Tools::complete("protocol").report(&["--port", &board.name]);
    let found = check(&report, "firmware").1;
    assert_eq!(code, 2);
    assert_eq!(found, format!("speaks protocol version {}, expected {PROTOCOL_VERSION}", PROTOCOL_VERSION + 1));
    board.heard();
}

#[test]
fn silence_noise_and_a_port_that_is_not_there_are_told_apart() {
    let silent = Board::start(|_| Vec::new());
    let (code, report) = Tools::complete("silent").report(&["--port", &silent.name]);
    assert_eq!((code, check(&report, "firmware").1.as_str()), (2, "does not answer"));
    // The request was sent several times before the timeout.
    assert_eq!(silent.heard().len(), 5);

    let noisy = Board::start(|_| vec![0x55, 0xaa, 0x17, 0x99, 0x02, 0]);
    let (code, report) = Tools::complete("noisy").report(&["--port", &noisy.name]);
    assert_eq!(code, 2);
    assert!(check(&report, "firmware").1.starts_with("bytes that are no packet"), "{report}");
    noisy.heard();

    let (code, report) = Tools::complete("absent").report(&["--port", "/dev/no-such-port"]);
    assert_eq!((code, check(&report, "port").0.as_str(), check(&report, "port").2), (2, "problem", true));
}

/// A whole packet with a valid check sum, in an unsupported version.
fn packet_of_version(version: u8) -> Vec<u8> {
    let mut raw = vec![version, 0, 0, 0, 0, 0];
    let check = crc32(&raw);
    raw.extend(check.to_le_bytes());
    // COBS replaces each zero by the distance to the next one.
    let mut packet = vec![0];
    let mut code = 0;
    for byte in raw {
        if byte == 0 {
            packet[code] = u8::try_from(packet.len() - code).unwrap();
            code = packet.len();
            packet.push(0);
        } else {
            packet.push(byte);
        }
    }
    packet[code] = u8::try_from(packet.len() - code).unwrap();
    packet.push(0);
    packet
}

/// CRC-32 as in Ethernet, one bit at a time.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}

#[test]
fn a_bundle_has_versions_checks_scene_and_robot() {
    let tools = Tools::complete("bundle");
    let file = tools.0.join("bug.md");
    let arguments = ["--scene", SCENE, "--bundle", file.to_str().unwrap()];
    assert_eq!(tools.doctor(&arguments).0, 0);
    let text = std::fs::read_to_string(&file).unwrap();
    for part in
        ["| rustc | rustc 1.95.0", "| link protocol | ", "\"checks\": [", "name = \"mit6_wave\"", "[[joint]]", "bus = "]
    {
        assert!(text.contains(part), "{part} in {text}");
    }
    let (code, _, error) = tools.doctor(&arguments);
    assert!(code == 2 && error.contains("bug.md: the file exists"), "{error}");
}
