//! Other programs at a session of `drive`: `newtau stop`, and targets that the arm follows.

use crate::drive::{FIRST, drive, file, scene};
use crate::program::{at_the_top, told};
use board::session::local::client::Client;
use board::session::local::message::{Answer, Ask, Snapshot};
use board::session::local::session_file::{SessionFile, running};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest wait for an event.
const LONG: Duration = Duration::from_secs(20);

/// Pose away from the rest pose.
const RAISED: [f64; 6] = [0.0, 0.6, 0.8, 0.0, 0.0, 0.0];

/// Commands that raise the arm.
pub(crate) fn raised() -> String {
    format!("{FIRST}goto 0 0.6 0.8 0 0 0 1.5\nwait\n")
}

/// A session with a simulated arm, and its files in a folder of its own.
pub(crate) struct Session {
    child: Child,
    runtime: PathBuf,
    found: SessionFile,
}

impl Session {
    fn start(name: &str, script: &str) -> Self {
        Self::start_with(name, script, &[])
    }

    pub(crate) fn start_with(name: &str, script: &str, options: &[&str]) -> Self {
        let runtime = file(&format!("runtime_{name}"));
        std::fs::remove_dir_all(&runtime).ok();
        let mut program = drive(&scene(name), "simulated", script);
        program.args(options).env("XDG_RUNTIME_DIR", &runtime).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = program.spawn().unwrap();
        let begun = Instant::now();
        let found = loop {
            if let [session] = running(&runtime.join("newtau")).unwrap().0.as_slice() {
                break session.clone();
            }
            assert!(begun.elapsed() < LONG, "no session");
            sleep(Duration::from_millis(5));
        };
        Self { child, runtime, found }
    }

    pub(crate) fn client(&self) -> Client {
        Client::connect(&self.found).unwrap()
    }

    pub(crate) fn signal(&self, name: &str) {
        assert!(Command::new("kill").args([name, &self.child.id().to_string()]).status().unwrap().success());
    }

    pub(crate) fn end(self) -> (i32, String) {
        let (code, out, error) = told(self.child.wait_with_output().unwrap());
        (code, format!("{out}{error}"))
    }
}

fn stop(runtime: &Path, options: &[&str]) -> (i32, String) {
    let mut program = at_the_top();
    let (code, out, error) = told(program.arg("stop").args(options).env("XDG_RUNTIME_DIR", runtime).output().unwrap());
    assert_eq!(error, "");
    (code, out)
}

pub(crate) fn state(client: &mut Client) -> Snapshot {
    match client.ask(&Ask::State).unwrap() {
        Answer::State(state) => state,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn until(client: &mut Client, what: &str, is_so: impl Fn(&Snapshot) -> bool) -> Snapshot {
    let begun = Instant::now();
    loop {
        let state = state(client);
        if is_so(&state) {
            return state;
        }
        assert!(begun.elapsed() < LONG, "{what}: {state:?}");
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn stop_in_another_terminal_holds_a_moving_arm_and_says_so_and_finds_nothing_once_the_session_is_over() {
    let session = Session::start("stop", &format!("{FIRST}goto 0 0.6 0.8 0 0 0 5\nwait\n"));
    let mut client = session.client();
    until(&mut client, "it moves", |state| state.state == "running" && state.q[1] > 0.1);
    let runtime = session.runtime.clone();
    let (code, out) = stop(&runtime, &[]);
    assert!(code == 0 && out.contains("confirmed: ") && out.contains("hold"), "{code}: {out}");
    let held = until(&mut client, "it is held", |state| state.state == "holding");
    assert!(held.q[1] < 0.5, "stopped on the way: {held:?}");
    // A stop of an arm that is held is confirmed too; the script does not go on.
    sleep(Duration::from_millis(1100));
    let (code, out) = stop(&runtime, &["--json"]);
    let found: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(code == 0 && found["sessions"][0]["confirmed"] == true, "{code}: {out}");
    assert_eq!(state(&mut client).state, "holding");
    session.signal("-TERM");
    let (code, out) = session.end();
    assert_eq!(code, 130, "{out}");
    let (code, out) = stop(&runtime, &[]);
    assert!(code == 3 && out.contains("nothing was stopped"), "{code}: {out}");
}

#[test]
fn an_emergency_stop_from_elsewhere_is_fault_9() {
    let session = Session::start("emergency", &format!("{}wait 20\n", raised()));
    let mut client = session.client();
    until(&mut client, "it is raised", |state| state.q.get(1).is_some_and(|q| (q - 0.6).abs() < 0.01));
    let (code, out) = stop(&session.runtime, &["--emergency"]);
    assert!(code == 0 && out.contains("fault 9"), "{code}: {out}");
    assert_eq!(state(&mut client).state, "fault");
    session.signal("-TERM");
    let (_, out) = session.end();
    assert!(out.contains("fault 9"), "{out}");
}

/// Sends targets every 20 ms for this time, each joint by `speed` (rad/s) further. Returns the last target and state.
fn led(client: &mut Client, from: [f64; 6], speed: f64, time: Duration) -> (Vec<f64>, Snapshot) {
    let begun = Instant::now();
    loop {
        let passed = begun.elapsed().min(time).as_secs_f64();
        let target: Vec<f64> = from.iter().map(|q| q + speed * passed).collect();
        match client.ask(&Ask::Target(target.clone())).unwrap() {
            Answer::State(state) if begun.elapsed() > time + Duration::from_secs(1) => return (target, state),
            Answer::State(_) => sleep(Duration::from_millis(20)),
            other => panic!("{other:?}"),
        }
    }
}

fn error_of(client: &mut Client, ask: &Ask) -> String {
    match client.ask(ask).unwrap() {
        Answer::Error(why) => why,
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_arm_follows_targets_and_is_held_when_they_end_or_stay_away() {
    let session = Session::start("follow", &format!("{}follow\nwait\nfollow 0.4\nwait\nstatus\npark\n", raised()));
    let mut client = session.client();
    let target = Ask::Target(RAISED.to_vec());
    assert!(error_of(&mut client, &target).contains("enter `follow`"));
    until(&mut client, "it follows", |state| state.following && state.state == "running");
    let (goal, arrived) = led(&mut client, RAISED, 0.2, Duration::from_secs(1));
    assert!(arrived.q.iter().zip(&goal).all(|(q, goal)| (q - goal).abs() < 0.01), "{arrived:?}, {goal:?}");
    assert!(error_of(&mut session.client(), &target).contains("another program"));
    assert!(matches!(client.ask(&Ask::Done).unwrap(), Answer::State(_)));
    until(&mut client, "it is held", |state| !state.following);
    // The second `follow`: from the place where the first one ended.
    until(&mut client, "it follows again", |state| state.following && state.state == "running");
    let from: [f64; 6] = goal.try_into().unwrap();
    let (_, moved) = led(&mut client, from, -0.1, Duration::from_millis(500));
    let silent = Instant::now();
    let held = until(&mut client, "it is held", |state| !state.following && state.state != "running");
    assert!(silent.elapsed() < Duration::from_secs(2), "{:?}", silent.elapsed());
    assert!(held.q.iter().zip(&moved.q).all(|(q, moved)| (q - moved).abs() < 0.02), "{held:?}, {moved:?}");
    assert!(error_of(&mut client, &target).contains("no target came for 0.4"));
    let (code, out) = session.end();
    assert_eq!(code, 3, "the program stalled: {out}");
    for part in ["the program has ended its targets: the arm stops", "no target came for 0.4", "park: "] {
        assert!(out.contains(part), "{part}: {out}");
    }
}

#[test]
fn a_target_outside_the_limits_and_a_program_that_is_gone_stop_the_arm() {
    let session = Session::start("refused_target", &format!("{}follow\nwait\nfollow\nwait\npark\n", raised()));
    let mut client = session.client();
    until(&mut client, "it follows", |state| state.following);
    assert!(matches!(client.ask(&Ask::Target(RAISED.to_vec())).unwrap(), Answer::State(_)));
    // In degrees, as it were.
    assert!(matches!(client.ask(&Ask::Target(RAISED.map(|q| q * 57.3).to_vec())).unwrap(), Answer::State(_)));
    until(&mut client, "it does not follow", |state| !state.following);
    assert!(error_of(&mut client, &Ask::Target(RAISED.to_vec())).contains("joint 2: 34.3800, expected"));
    let mut other = session.client();
    until(&mut other, "it follows again", |state| state.following);
    let aside = [0.3, 0.6, 0.8, 0.0, 0.0, 0.0];
    assert!(matches!(client.ask(&Ask::Target(aside.to_vec())).unwrap(), Answer::State(_)));
    drop(client);
    let held = until(&mut other, "it does not follow", |state| !state.following && state.state == "holding");
    assert!(held.q[0] < 0.2, "it stops on its way: {held:?}");
    let (code, out) = session.end();
    assert!(code == 3 && out.contains("the program is gone: the arm stops"), "{code}: {out}");
}

#[test]
fn in_the_first_motion_and_without_torque_no_targets_are_followed() {
    let session = Session::start("not_yet", "home\nconfirm\nfollow\narm\nfollow\nwait\n");
    let (code, out) = session.end();
    assert!(code == 3 && out.contains("follow: rejected: in the first motion after homing"), "{code}: {out}");
    let session = Session::start("no_torque", "home\nconfirm\nfull-range\nfollow\n");
    let (code, out) = session.end();
    assert!(code == 3 && out.contains("follow: "), "{code}: {out}");
}

#[test]
fn whoever_has_no_token_gets_no_answer_and_bad_lines_change_nothing() {
    let session = Session::start("token", "home\nconfirm\nwait 4\n");
    for knock in ["GET / HTTP/1.1\r\nHost: localhost\r\n\r\n", "\"state\"\n", "\"stop\"\n", "{\"token\":\"\"}\n"] {
        let mut stream = TcpStream::connect(session.found.address).unwrap();
        stream.write_all(knock.as_bytes()).unwrap();
        let mut answer = Vec::new();
        // Whether the end is orderly depends on what was not read.
        stream.read_to_end(&mut answer).ok();
        assert!(answer.is_empty(), "{knock}: {answer:?}");
    }
    let mut client = session.client();
    assert_eq!(client.greeting().joints.len(), 6);
    assert!(error_of(&mut client, &Ask::Token(String::new())).contains("already"));
    // More connections than are served at a time: the others are closed, and those that are open go on.
    let idle: Vec<_> = (0..40).map(|_| TcpStream::connect(session.found.address).unwrap()).collect();
    until(&mut client, "it is served", |state| state.state == "idle");
    drop(idle);
    let (code, out) = session.end();
    assert_eq!(code, 0, "{out}");
}
