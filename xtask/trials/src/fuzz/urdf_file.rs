//! Fuzz target: any text as a URDF file.

use crate::fuzz::FuzzTarget;
use crate::fuzz::damage::nested;
use crate::fuzz::examples::{files, invalid};
use crate::fuzz::files::{check_robot, read};
use robot_compiler::{Ends, Robot};

/// The valid and invalid arms of the compiler's tests, and nested elements.
pub const TARGET: FuzzTarget =
    FuzzTarget { name: "urdf_file", check, examples, words: include_str!("../../words/urdf.dict") };

/// File name of the text in errors.
const NAME: &str = "any.urdf";

fn examples() -> Vec<Vec<u8>> {
    let mut all = files(&["robot-compiler/tests/data"], "urdf");
    all.extend(invalid("urdf"));
    // The greatest accepted depth, and one more.
    all.extend([32, 33].into_iter().flat_map(nested));
    all
}

/// A text gives a robot, or an error with a location; it is read once with its only chain, and once with the chain that ends at a link named `tip`.
/// An accepted robot has a model, torques and a scene.
pub fn check(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    for tip in [None, Some("tip")] {
        if let Some(robot) =
            read(&text, NAME, "<!-- the end -->", |text| Robot::from_urdf_str(text, NAME, Ends { base: None, tip }))
        {
            check_robot(&robot);
        }
    }
}
