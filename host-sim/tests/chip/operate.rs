//! `connect` in a dry run of the emulated chip. Its record is replayed on the desk with the same bits in every status.

use crate::program::{at_the_top, new, printed, told};
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

#[test]
fn a_session_on_the_chip_has_the_desk_s_bits_in_every_status_refusal_and_remembered_tick() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (script, log) = (folder.join("chip_session.txt"), folder.join("chip_session.log"));
    let commands = "arm\nhome\nconfirm\narm\njog shoulder 0.3 0.3\nwait\nhold\njog elbow 0.2 0.3\nwait 0.1\npress\nwait 0.1\ndump\nrelease\nwait 0.3\nclear\n";
    std::fs::write(&script, commands).unwrap();
    let mut connect = at_the_top();
    connect.args(["connect", "scenes/planar2r_swing.toml", "--target", "qemu", "--script"]).arg(&script);
    let (code, out, error) = told(connect.arg("--record").arg(new(&log)).output().unwrap());
    assert_eq!(code, 3, "arming was refused first: {out}{error}");
    assert!(out.contains("press: fault 9: emergency stop"), "{out}");
    assert!(out.ends_with("clear: idle, homed\n"), "{out}");

    let out = printed(at_the_top().args(["connect", "replay"]).arg(&log).output().unwrap());
    let ticks: u64 = out.strip_suffix(" ticks compared, 0 differ\n").unwrap().parse().unwrap();
    assert!(ticks > 400, "{ticks}");
}

#[test]
fn gains_are_changed_on_the_chip_within_their_bounds_and_its_record_has_the_same_bits_again() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (script, log) = (folder.join("chip_tuned.txt"), folder.join("chip_tuned.log"));
    let commands = "home\nconfirm\narm\nset elbow position gain 500\nset elbow position gain 1601\nget elbow position gain\n\
                    goto -0.6 0.8 1\nwait\n";
    std::fs::write(&script, commands).unwrap();
    let mut connect = at_the_top();
    connect.args(["connect", "host-sim/tests/fixtures/tunable.toml", "--target", "qemu", "--script"]).arg(&script);
    let (code, out, error) = told(connect.arg("--record").arg(new(&log)).output().unwrap());
    assert_eq!(code, 3, "one value was refused: {out}{error}");
    for line in [
        "set: elbow position gain 500 1/s^2 (100 to 1600)",
        "set: rejected: the value is outside its bounds",
        "get: elbow position gain 500 1/s^2 (100 to 1600)",
    ] {
        assert!(out.lines().any(|said| said == line), "{line}: {out}");
    }
    let out = printed(at_the_top().args(["connect", "replay"]).arg(&log).output().unwrap());
    let ticks: u64 = out.strip_suffix(" ticks compared, 0 differ\n").unwrap().parse().unwrap();
    assert!(ticks > 900, "{ticks}");
}

/// True if a process of this machine names the folder of that program's temporary files in its command line.
#[cfg(target_os = "linux")]
fn has_emulator(program: u32) -> bool {
    let folder = format!("newtau-run-{program}-0/");
    std::fs::read_dir("/proc").unwrap().flatten().any(|entry| {
        std::fs::read(entry.path().join("cmdline")).is_ok_and(|line| String::from_utf8_lossy(&line).contains(&folder))
    })
}

#[test]
#[cfg(target_os = "linux")]
fn a_program_that_is_killed_leaves_no_emulator_and_the_next_one_deletes_its_folder() {
    let until = |what: &str, is_so: &dyn Fn() -> bool| {
        let begun = Instant::now();
        while !is_so() {
            assert!(begun.elapsed() < Duration::from_secs(200), "{what}");
            sleep(Duration::from_millis(10));
        }
    };
    let mut connect = at_the_top();
    connect.args(["connect", "scenes/planar2r_swing.toml", "--target", "qemu"]);
    let mut program = connect.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    until("the emulator runs", &|| has_emulator(program.id()));
    let folder = std::env::temp_dir().join(format!("newtau-run-{}-0", program.id()));
    assert!(folder.is_dir());
    // SIGKILL: nothing in the program runs after it.
    program.kill().unwrap();
    program.wait().unwrap();
    until("the emulator has ended", &|| !has_emulator(program.id()));
    assert!(folder.is_dir(), "the killed program could not delete it");
    let mut connect = at_the_top();
    connect.args(["connect", "scenes/planar2r_swing.toml", "--target", "qemu"]);
    assert_eq!(told(connect.stdin(Stdio::null()).output().unwrap()).0, 0);
    assert!(!folder.exists());
}
