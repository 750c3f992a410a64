//! Fuzz target: any text as a robot file, and as a linkage file.

use crate::fuzz::FuzzTarget;
use crate::fuzz::damage::nested;
use crate::fuzz::examples::{files, invalid};
use crate::fuzz::files::{check_robot, read};
use dynamics_core::Trig;
use dynamics_core::linkage::{Branch, Linkage, LinkagePosture};
use dynamics_core::trig::Libm;
use robot_compiler::{LinkageFile, Robot};

/// All shipped robots and linkages, and the invalid ones of the compiler's tests.
pub const TARGET: FuzzTarget =
    FuzzTarget { name: "robot_file", check, examples, words: include_str!("../../words/toml.dict") };

/// File name of the text in errors.
const NAME: &str = "any.toml";

fn examples() -> Vec<Vec<u8>> {
    let mut all = files(&["robots", "robots/chapter12", "robots/examples", "robot-compiler/tests/data"], "toml");
    all.extend(invalid("toml"));
    // The greatest accepted depth, and one more.
    all.extend([32, 33].into_iter().flat_map(nested));
    all
}

/// A text gives a robot, a linkage, or errors with a location. An accepted robot has a model, torques and a scene.
pub fn check(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Some(robot) = read(&text, NAME, "# the end", |text| Robot::from_toml_str(text, NAME)) {
        check_robot(&robot);
    }
    if let Some(linkage) = read(&text, NAME, "# the end", |text| LinkageFile::from_toml_str(text, NAME)) {
        check_linkage(&linkage);
    }
}

/// For every crank angle an accepted linkage gives the positions of its links and its driving moment, or an error.
fn check_linkage(linkage: &LinkageFile) {
    for step in 0..12 {
        let turn = Libm.sin_cos(f64::from(step) * 0.5);
        for branch in [Branch::Open, Branch::Crossed] {
            let motion = |posture: &LinkagePosture<f64>| Ok(posture.coefficients()?.map(|k| k.motion(1.0, 0.0)));
            let forces =
                linkage.mechanism.posture(&turn, branch).and_then(|p| p.forces(&motion(&p)?, &linkage.gravity));
            if let Ok(forces) = forces {
                assert!(forces.driving_moment.is_finite(), "{linkage:?}");
            }
        }
    }
    let range = linkage.mechanism.crank_range();
    assert!(range.ends().iter().flatten().all(|end| end.sin.is_finite() && end.cos.is_finite()), "{linkage:?}");
}
