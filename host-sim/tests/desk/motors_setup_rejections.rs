//! `motors setup` as a process: motors, models and robot files that it must not take.

use crate::drive::file;
use crate::motors_setup::{Motors, Served, Session};
use crate::motors_setup_robstride::{Bus, bus, served, turn};
use crate::program::new;
use board::can::frame::CanFrame;
use embedded_can::Frame as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// The first joint of a robot without its drive, as an arm.
fn one_joint(robot: &str, name: &str, change: impl Fn(String) -> String) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots").join(robot);
    let text = std::fs::read_to_string(path).unwrap();
    let joint = text.split("[joint.drive]").next().unwrap();
    // A rest pose of six joints.
    let kept: Vec<&str> = joint.lines().filter(|line| !line.starts_with("rest")).collect();
    let path = file(name);
    std::fs::write(&path, change(kept.join("\n"))).unwrap();
    path
}

/// Text of an error, without the breaks of its lines.
fn flat(error: &str) -> String {
    error.replace("\n  │ ", " ")
}

/// An RS06 alone, with this torque limit.
fn one_motor(torque_limit: Option<f32>) -> Arc<Mutex<Bus>> {
    let bus = bus();
    {
        let motors = &mut bus.lock().unwrap().motors;
        motors.truncate(1);
        motors[0].torque_limit = torque_limit;
    }
    bus
}

/// A setup of an arm with one joint, at the question for the model of its motor.
struct AtModel {
    session: Session,
    out: PathBuf,
    _served: Served,
}

impl AtModel {
    /// `torque` is the joint's limit, N m.
    fn new(name: &str, torque_limit: Option<f32>, torque: &str) -> Self {
        let robot = one_joint("rebot_b601_rs.toml", &format!("{name}_arm.toml"), |text| {
            text.replace("torque = 36.0", &format!("torque = {torque}"))
        });
        let (bus, out) = (one_motor(torque_limit), file(&format!("{name}.toml")));
        let served = served(&bus);
        // Without a search for the other kind.
        let mut session = Session::with(&robot, &served, &out, &["--kind", "robstride"]);
        session.until("joint 1 of 1");
        turn(&bus, 1, 0.4);
        session.line("");
        session.until("model of motor 1");
        Self { session, out, _served: served }
    }

    /// Types a model. The answer has this text, and the model is asked for again.
    fn is_not_taken(&mut self, model: &str, why: &str) {
        self.session.line(model);
        self.session.until(why);
        self.session.until("model of motor 1");
    }

    /// Ends the input. Returns the exit code and the error.
    fn end(self) -> (i32, String) {
        let (code, _, error) = self.session.end();
        assert!(!self.out.exists());
        (code, flat(&error))
    }
}

#[test]
fn a_robot_file_that_is_changed_meanwhile_is_not_used() {
    let (motors, out) = (Motors::default(), file("motors_setup_changed.toml"));
    let served = Served::of(&motors);
    let robot = one_joint("yam.toml", "motors_setup_changed_arm.toml", |text| text);
    let mut session = Session::new(&robot, &served, &out);
    session.until("joint 1 of 1");
    motors.turn(1, 0.4);
    session.line("");
    session.until("a pose that is known");
    session.line("z");
    session.until("to both of its ends");
    let text = std::fs::read_to_string(&robot).unwrap();
    std::fs::write(&robot, text.replace("velocity = 3.0", "velocity = 2.0")).unwrap();
    session.line("");
    let (code, said, error) = session.end();
    assert!(code == 2 && flat(&error).contains("it was changed meanwhile: nothing was written"), "{said}{error}");
    assert!(!out.exists());
}

#[test]
fn motors_with_an_error_are_rejected() {
    let out = file("motors_setup_error.toml");
    new(&out);
    let rejected = |served: &Served, robot: &str, text: &str| {
        let (code, said, error) = served.alone(Path::new(robot), &out, &[]);
        assert!(code != 0 && flat(&error).contains(text), "{text}: {said}{error}");
        assert!(said.is_empty() && !out.exists(), "{said}");
    };
    let robstride = one_motor(Some(36.0));
    robstride.lock().unwrap().motors[0].errors = 1 << 3;
    let text = "motor 1: off; its encoder fails: expected a motor without an error (newtau motors clear)";
    rejected(&served(&robstride), "robots/rebot_b601_rs.toml", text);
    let motors = Motors::default();
    let damiao = Served::new(move |frame| {
        let Some(frame) = frame else { return Vec::new() };
        let answer = motors.answer(frame);
        // Motor 3 puts its error above its identifier.
        let with_error = |answer: CanFrame| match (frame.data(), answer.data()) {
            ([3, 0, 0xCC, ..], [3, rest @ ..]) => CanFrame::of(19, false, &[&[0xA3], rest].concat()),
            _ => Some(answer),
        };
        answer.and_then(with_error).into_iter().collect()
    });
    let text = "motor 3: too much current: expected a motor without an error (newtau motors clear)";
    rejected(&damiao, "robots/yam.toml", text);
}

#[test]
fn a_position_range_that_no_robstride_motor_has_is_not_taken() {
    let mut at_model = AtModel::new("motors_setup_range", Some(36.0), "36.0");
    let why = "the position range of this model is 12.4 rad; expected 12.57 rad, that of every robstride model";
    // However often it is entered.
    for _ in 0..3 {
        at_model.is_not_taken("12.4 50 36 5000 100", why);
    }
    at_model.session.line("12.5 50 36 5000 100");
    at_model.session.until("a pose that is known");
    at_model.end();
}

#[test]
fn drives_of_the_robot_file_must_all_be_of_the_motors_kind() {
    let served = served(&one_motor(Some(36.0)));
    let (robot, out) = (file("motors_setup_kinds_arm.toml"), file("motors_setup_kinds.toml"));
    new(&out);
    let of = |robot: &str| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(robot)).unwrap();
    let rejected = |text: &str, why: &str| {
        std::fs::write(&robot, text).unwrap();
        let (code, said, error) = served.alone(&robot, &out, &[]);
        assert!(code == 2 && flat(&error).contains(why), "{why}: {said}{error}");
        assert!(said.is_empty() && !out.exists(), "{said}");
    };
    let yam = of("../robots/yam.toml");
    rejected(&yam, "found drives of the kind damiao in the file, and robstride motors on the bus");
    let ranges = "position = [-12.5, 12.5]\nvelocity = [-30.0, 30.0]\ntorque = [-36.0, 36.0]\nkp = [0.0, 500.0]\nkd = [0.0, 5.0]";
    let (damiao, others) = ("kind = \"damiao\"\n", ["actuator = \"DM4340\"", "actuator = \"DM4310\""]);
    let mit = others.iter().fold(yam.replace(damiao, "kind = \"mit\"\n"), |text, other| text.replace(other, ranges));
    rejected(&mit, "found drives of the kind mit; setup can read the positions of damiao and robstride motors only");
    // A robot file with two kinds is rejected where it is read.
    let (five, last) = yam.rsplit_once(damiao).unwrap();
    let last = last.replace(others[1], "actuator = \"RS00\"").replace("reply_id = 22\n", "");
    rejected(
        &format!("{five}kind = \"robstride\"\n{last}"),
        "of the kind robstride, while \"base\" has one of the kind damiao",
    );
}

/// Its drives could not be written into it at the end.
#[test]
fn a_urdf_of_any_ending_is_refused_before_the_interview() {
    let served = served(&one_motor(Some(36.0)));
    let urdf =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../robot-compiler/tests/data/two.urdf"))
            .unwrap();
    for name in ["motors_setup_arm.urdf", "motors_setup_arm.URDF", "motors_setup_arm.xml"] {
        let (robot, out) = (file(name), file("motors_setup_urdf.toml"));
        new(&out);
        std::fs::write(&robot, &urdf).unwrap();
        let (code, said, error) = served.alone(&robot, &out, &[]);
        assert!(
            code == 2 && error.contains("expected a robot file in TOML") && said.is_empty(),
            "{name}: {said}{error}"
        );
    }
}

#[test]
fn a_model_that_its_motor_confirms_and_the_joint_exceeds_ends_the_setup() {
    let mut at_model = AtModel::new("motors_setup_exceeds", Some(36.0), "40.0");
    at_model.session.line("RS06");
    let (code, error) = at_model.end();
    assert!(code == 2 && error.contains("the limits of base are 40 N m and 3 rad/s"), "{error}");
    assert!(error.contains("motor 1 is RS06, because its torque limit says so: nothing was written"), "{error}");
}

#[test]
fn a_model_that_the_joint_exceeds_and_a_person_insists_on_ends_the_setup() {
    let mut at_model = AtModel::new("motors_setup_insists", Some(10.0), "40.0");
    at_model.is_not_taken("RS06", "the torque limit of motor 1 is 10 N m: is this its model?");
    at_model.is_not_taken("RS06", "The same model again ends the setup");
    at_model.session.line("RS06");
    let (code, error) = at_model.end();
    assert!(
        code == 2 && error.contains("motor 1 is RS06, because it was entered again: nothing was written"),
        "{error}"
    );
}

#[test]
fn the_question_for_a_model_ends_with_the_input() {
    let mut at_model = AtModel::new("motors_setup_no_model", Some(36.0), "36.0");
    at_model.session.line("RS99");
    at_model.session.until("model of motor 1");
    let (code, error) = at_model.end();
    assert!(
        code == 2 && error.contains("the input ended before the setup was complete: nothing was written"),
        "{error}"
    );
}

#[test]
fn a_model_of_a_motor_that_does_not_say_its_torque_limit_is_asked_for_again() {
    let mut at_model = AtModel::new("motors_setup_unknown", None, "14.0");
    let unknown =
        |torque: &str| format!("have {torque} N m, and the torque limit of motor 1 is unknown: is this its model?");
    // Another model than before is doubted, too.
    at_model.is_not_taken("RS00", &unknown("14"));
    at_model.is_not_taken("RS06", &unknown("36"));
    at_model.session.line("RS06");
    at_model.session.until("a pose that is known");
    at_model.end();
}
