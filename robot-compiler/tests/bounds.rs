//! Bounds of the numbers on which safety relies, the rest pose, and identifiers of drives: both sides of each edge.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::panic, reason = "a test names the case that fails")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]

use dynamics_core::drive::Drives;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Trig};
use robot_compiler::scene::axis_to_tip;
use robot_compiler::{FileError, Robot, SceneFile, conflict_on_one_bus, with_dof};
use std::path::Path;

use crate::common::{files, top};

fn scene(lines: &str) -> Result<SceneFile, FileError> {
    let motion = "[motion]\nkind = \"hold\"\nq = [0.0, 0.0]\nduration = 1.0\n";
    let text = format!("name = \"test\"\nrobot = \"arm.toml\"\n{lines}\n{motion}");
    SceneFile::from_toml_str(&text, Path::new("tests/data/scene.toml"))
}

/// Lines that are accepted, and lines just beyond the bound with a part of the error.
const EDGES: [(&str, &str, &str); 25] = [
    // 0.2 rad / (1.5 x 2 rad/s x 1 ms) = 66.7 ticks.
    (
        "[control]\nage_max = 66",
        "[control]\nage_max = 67",
        "at most 66 ticks at 1000 Hz: 0.2 rad (`safety.reach`) / (3 rad/s x 0.001 s)",
    ),
    (
        "[control]\nage_max = 33\n[safety]\nreach = [0.2, 0.1]",
        "[control]\nage_max = 34\n[safety]\nreach = [0.2, 0.1]",
        "at most 33 ticks at 1000 Hz: 0.1 rad",
    ),
    ("[control]\nage_max = 1000000\n[safety]\nbench_only = true", "[control]\nage_max = 1000000", "at most 66 ticks"),
    ("[control]\nguard = { velocity_factor = 3 }", "[control]\nguard = { velocity_factor = 3.01 }", "1 to 3"),
    ("[control]\nguard = { position_margin = 1 }", "[control]\nguard = { position_margin = 1.01 }", "at most 1"),
    ("[safety]\nheartbeat_ms = 1000", "[safety]\nheartbeat_ms = 1001", "at most 1,000 ms"),
    ("[safety]\nlatency_ms = 1", "[safety]\nlatency_ms = 0.99", "at least 1 ms at 1000 Hz"),
    ("[safety]\nhold_ms = 60000", "[safety]\nhold_ms = 60001", "0 to 60,000"),
    ("[safety]\nbrake_delay_ms = 1000", "[safety]\nbrake_delay_ms = 1001", "a time in ms, 5 to 1,000"),
    ("[safety]\nbrake_delay_ms = 0", "[safety]\nbrake_delay_ms = -1", "a time in ms, 5 to 1,000"),
    ("[safety]\nbrake_delay_ms = 5", "[safety]\nbrake_delay_ms = 4.9", "Is this number in seconds?"),
    ("[safety]\nbrake_delay_ms = 0", "[safety]\nbrake_delay_ms = 0.08", "Is this number in seconds?"),
    (
        "[safety]\nbrake_delay_ms = 50\nsafe_action = \"brake\"",
        "[safety]\nbrake_delay_ms = 50\nsafe_action = \"damped-stop\"",
        "only with `safe_action = \"brake\"`: remove it",
    ),
    (
        "[safety]\npayload_mass = 30",
        "[safety]\npayload_mass = 30.1",
        "at most 30.000 kg, 10 times the 3.000 kg that move",
    ),
    ("[safety]\nsupply = [0, 1500]", "[safety]\nsupply = [0, 1501]", "inside 0 to 1500 V"),
    (
        "[safety]\ntemperature = [-100, 200]",
        "[safety]\ntemperature = [-100, 201]",
        "inside -100 to 200 degrees Celsius",
    ),
    ("[safety]\njump_factor = 100", "[safety]\njump_factor = 100.1", "at most 100.000: 0.2 rad"),
    ("[safety]\nreach = 1", "[safety]\nreach = 1.01", "`resolution` to 1"),
    ("[safety]\nresolution = 0.2", "[safety]\nresolution = 0.201", "at most `reach`, 0.2"),
    ("[safety]\nreach_speed = 2", "[safety]\nreach_speed = 2.01", "at most the velocity limit, 2"),
    ("[safety]\nrest_speed = 0.2", "[safety]\nrest_speed = 0.201", "at most 0.2"),
    ("[safety]\nfirst_motion = 1", "[safety]\nfirst_motion = 1.01", "0.05 to 1"),
    ("[safety]\nfirst_motion = 0.05", "[safety]\nfirst_motion = 0.049", "friction"),
    ("[safety]\nlive_age_ms = 4", "[safety]\nlive_age_ms = 3.9", "at least four control periods, 4.000 ms"),
    ("[safety]\ndamping = 600", "[safety]\ndamping = 601", "at most 600.000, the torque limit at `rest_speed`"),
];

#[test]
fn every_bound_holds_on_both_sides() {
    for (accepted, rejected, expected) in EDGES {
        scene(accepted).unwrap_or_else(|error| panic!("{accepted}: {error}"));
        let error = scene(rejected).err().unwrap_or_else(|| panic!("{rejected} was accepted"));
        assert!(error.expected().contains(expected), "{rejected}: {}", error.expected());
    }
}

#[test]
fn a_deceleration_is_at_most_what_the_torque_limit_gives() {
    let file = scene("").unwrap();
    let model = file.robot.model::<2>().unwrap();
    let dynamics = Dynamics::new(model, file.scene(&model));
    let inertia = dynamics_core::mass_matrix::mass_matrix(
        &dynamics,
        &Libm.sin_cos_all(&[0.0; 2]),
        &[0.0; 2],
        &dynamics_core::Live::zero(),
    );
    let most = [30.0 / inertia[(0, 0)], 30.0 / inertia[(1, 1)]];
    let given = |share: f64| format!("[safety]\ndeceleration = [{}, {}]", 0.5 * most[0], share * most[1]);
    assert!(scene(&given(0.999)).is_ok());
    let error = scene(&given(1.001)).unwrap_err();
    assert!(
        error.problem().contains("joint 2 (elbow)") && error.expected().contains("the torque limit of 30"),
        "{error}"
    );
}

#[test]
fn the_default_age_gives_way_where_the_joints_are_too_fast_for_the_rate() {
    assert_eq!(scene("").unwrap().control.age_max, 2);
    // 0.2 / (1.5 x 2 / 40) = 2.67; at 20 Hz 1.33.
    assert_eq!(scene("[control]\nrate = 40").unwrap().control.age_max, 2);
    assert_eq!(scene("[control]\nrate = 20").unwrap().control.age_max, 1);
}

#[test]
fn a_bench_reaches_no_drive() {
    let drives = |bench: &str| {
        let path = top("scenes/yam_move.toml");
        let text = std::fs::read_to_string(&path).unwrap() + bench;
        SceneFile::from_toml_str(&text, &path).unwrap().drives::<6>()
    };
    assert!(matches!(drives(""), Drives::Mit(_)));
    assert!(matches!(drives("bench_only = false\n"), Drives::Mit(_)));
    // The file ends with its table [safety].
    assert_eq!(drives("bench_only = true\n"), Drives::Link);
}

#[test]
fn the_rest_pose_of_a_scene_comes_before_that_of_its_robot() {
    let of = |robot: &str, safety: &str| {
        let text = std::fs::read_to_string("tests/data/arm.toml").unwrap();
        let text = text.replacen("source = \"a test\"\n", &format!("source = \"a test\"\n{robot}\n"), 1);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("rest_{}_{}.toml", robot.len(), safety.len()));
        std::fs::write(&path, text).unwrap();
        let motion = "[motion]\nkind = \"hold\"\nq = [0.0, 0.0]\nduration = 1.0\n";
        let text = format!("name = \"test\"\nrobot = \"{}\"\n{safety}\n{motion}", path.display());
        SceneFile::from_toml_str(&text, Path::new("scene.toml")).unwrap().safety
    };
    assert_eq!(of("", "").rest, None);
    assert_eq!(of("rest = [0.1, -1.5]", "").rest, Some(vec![0.1, -1.5]));
    let both = of("rest = [0.1, -1.5]", "[safety]\nrest = [1.5, 0.2]\nlowering_tip_speed = 0.25");
    assert_eq!((both.rest, both.lowering_tip_speed), (Some(vec![1.5, 0.2]), 0.25));
    assert_eq!(of("rest = [0.1, -1.5]", "").lowering_tip_speed, 0.05);
}

/// The tip's speed in many postures with all joints at their lowering speed stays below the bound, and comes close to it with the
/// arm stretched out.
#[test]
fn the_tip_is_lowered_no_faster_than_the_scene_says() {
    for path in files(&top("scenes"), &["toml"]) {
        let file = SceneFile::load(&path).unwrap();
        with_dof!(file.robot.dof(), N => {
            let model = file.robot.model::<N>().unwrap();
            let speed = file.lowering_speed(&model);
            let reached: f64 = axis_to_tip(&model).iter().zip(&speed).map(|(r, qd)| r * qd).sum();
            let slides_freely = reached.is_nan();
            assert!(slides_freely || reached <= 0.05 * (1.0 + 1e-12), "{}: {reached}", file.name);
            // The tip, moved for a short time at this speed, joint by joint in the worst directions, from a few postures.
            let limits = model.links().map(|link| link.limits.position);
            for posture in 0..20_u32 {
                let q: [f64; N] = std::array::from_fn(|i| {
                    let (lo, hi) = (limits[i].0.max(-3.0), limits[i].1.min(3.0));
                    let share = (f64::from(posture) * 0.618_034 + 0.37 * i as f64).fract();
                    lo + share * (hi - lo)
                });
                let tip = |q: &[f64; N]| {
                    let chain = dynamics_core::chapter::posture::Chain::new(&model, &dynamics_core::Inertia::zero());
                    chain.posture(&Libm.sin_cos_all(q), q).tip.translation
                };
                const H: f64 = 1e-6;
                let sum: f64 = (0..N)
                    .map(|i| {
                        let mut moved = q;
                        moved[i] += H;
                        (tip(&moved) - tip(&q)).norm() / H * speed[i]
                    })
                    .sum();
                assert!(slides_freely || sum <= 0.05 * (1.0 + 1e-5), "{}: {sum} m/s at {q:?}", file.name);
            }
        });
    }
}

#[test]
fn damiao_drives_with_replies_that_can_be_told_apart_are_accepted() {
    let two = |(first, reply): (u32, u32), (second, other): (u32, u32), buses: (u32, u32)| {
        let joint = |name: &str, bus: u32, id: u32, reply: u32| {
            format!(
                "[[joint]]\nname = \"{name}\"\ntype = \"revolute\"\ndh = {{ a = 0.5, alpha = 0.0, d = 0.0, theta = 0.0 }}\nmass = 1.0\n\
                 com = [-0.25, 0.0, 0.0]\nlimits = {{ position = [-1.5, 1.5], velocity = 2.0, torque = 20.0 }}\n[joint.drive]\n\
                 kind = \"damiao\"\nactuator = \"DM4340\"\nbus = {bus}\nid = {id}\nreply_id = {reply}\ndamping = 1.0\n"
            )
        };
        let text =
            format!("name = \"two\"\n{}{}", joint("a", buses.0, first, reply), joint("b", buses.1, second, other));
        Robot::from_toml_str(&text, "two.toml")
    };
    let problem = |result: Result<Robot, FileError>| result.unwrap_err().problem().to_owned();
    assert!(problem(two((1, 0), (17, 0), (1, 1))).contains("low 4 bits"));
    assert!(problem(two((3, 9), (0x23, 9), (1, 1))).contains("both end in 3"));
    // Different low bits, different replies, different buses.
    for accepted in [((1, 0), (18, 0), (1, 1)), ((1, 5), (17, 6), (1, 1)), ((1, 0), (17, 0), (1, 2))] {
        two(accepted.0, accepted.1, accepted.2).unwrap();
    }
    assert!(problem(two((1, 17), (2, 0x101), (1, 1))).contains("commands of another mode"));
    assert!(problem(two((1, 0x302), (2, 18), (1, 1))).contains("commands of another mode"));
    assert!(two((1, 17), (2, 0x101), (1, 2)).is_ok());
    assert!(two((1, 17), (2, 0x103), (1, 1)).is_ok());
    assert!(problem(two((1, 17), (2, 0x7ff), (1, 1))).contains("settings of damiao drives"));
    assert!(two((1, 17), (2, 0x7fe), (1, 1)).is_ok());
    // Two buses keep these apart, one does not.
    for (first, second, found) in [
        ((1, 0), (17, 0), "the drive of \"b\": identifiers 17 and 1 (of \"a\") on one bus both end in 1"),
        ((1, 17), (1, 18), "the drive of \"b\": identifier 1 on one bus is that of \"a\""),
        ((1, 2), (2, 18), "the drive of \"a\": replies with identifier 2, which is a command's on one bus"),
        ((1, 17), (2, 0x101), "the drive of \"b\": replies of one of 2 and 1"),
    ] {
        let conflict = conflict_on_one_bus(&two(first, second, (1, 2)).unwrap()).unwrap();
        assert!(conflict.starts_with(found), "{conflict}");
    }
    assert_eq!(conflict_on_one_bus(&two((1, 17), (2, 18), (1, 2)).unwrap()), None);
}

#[test]
fn drives_of_the_other_kinds_say_their_whole_identifier() {
    let of_kind = |kind: &str, more: &str| {
        let joint = |name: &str, id: u32| {
            format!(
                "[[joint]]\nname = \"{name}\"\ntype = \"revolute\"\ndh = {{ a = 0.5, alpha = 0.0, d = 0.0, theta = 0.0 }}\nmass = 1.0\n\
                 com = [-0.25, 0.0, 0.0]\nlimits = {{ position = [-1.5, 1.5], velocity = 2.0, torque = 10.0 }}\n[joint.drive]\n\
                 kind = \"{kind}\"\nbus = 1\nid = {id}\ndamping = 1.0\n{more}"
            )
        };
        Robot::from_toml_str(&format!("name = \"two\"\n{}{}", joint("a", 1), joint("b", 17)), "two.toml").map(|_| ())
    };
    of_kind("robstride", "actuator = \"RS00\"\n").unwrap();
    // Requests for a parameter and their answers have the same type: an answer to host 17 would be a request to drive 17.
    let error = of_kind("robstride", "actuator = \"RS00\"\nhost_id = 17\n").unwrap_err();
    assert!(error.problem().contains("host identifier 17"), "{error}");
    of_kind("robstride", "actuator = \"RS00\"\nhost_id = 18\n").unwrap();
    let ranges = "position = [-12.5, 12.5]\nvelocity = [-50, 50]\nkp = [0, 500]\nkd = [0, 5]\ntorque = [-40, 40]\n";
    of_kind("mit", ranges).unwrap();
    of_kind("myactuator", ranges).unwrap();
}

#[test]
fn a_cubemars_of_the_table_has_the_ranges_of_its_name_and_a_myactuator_those_of_the_file() {
    let file = |drive: &str| {
        let text = format!(
            "name = \"one\"\n[[joint]]\nname = \"a\"\ntype = \"revolute\"\ndh = {{ a = 0.5, alpha = 0.0, d = 0.0, theta = 0.0 }}\nmass = 1.0\n\
             com = [-0.25, 0.0, 0.0]\nlimits = {{ position = [-1.5, 1.5], velocity = 2.0, torque = 10.0 }}\n[joint.drive]\nbus = 1\nid = 3\n\
             damping = 1.0\n{drive}"
        );
        Robot::from_toml_str(&text, "one.toml").unwrap().joints[0].clone()
    };
    let ak = file("kind = \"mit\"\nactuator = \"AK80-9\"\nreply_bytes = 8\ntemperature_offset = -40\n");
    let spec = ak.drive.unwrap().mit().unwrap();
    assert_eq!((spec.position, spec.velocity, spec.torque), ((-12.5, 12.5), (-50.0, 50.0), (-18.0, 18.0)));
    assert_eq!((spec.kp, spec.kd, spec.reply_bytes), ((0.0, 500.0), (0.0, 5.0), 8));
    assert_eq!(ak.heat.rated, Some(9.0));
    let ranges = "position = [-12.5, 12.5]\nvelocity = [-45, 45]\nkp = [0, 500]\nkd = [0, 5]\ntorque = [-24, 24]\n";
    let spec = file(&format!("kind = \"myactuator\"\n{ranges}")).drive.unwrap().mit().unwrap();
    assert_eq!((spec.torque, spec.id, spec.reply_id, spec.reply_bytes), ((-24.0, 24.0), 3, 0x503, 8));
}
