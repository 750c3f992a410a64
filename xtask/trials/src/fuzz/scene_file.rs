//! Fuzz target: any text as a scene file in the folder of the shipped scenes, so that it can refer to their robots.

use crate::fuzz::FuzzTarget;
use crate::fuzz::damage::nested;
use crate::fuzz::examples::{files, invalid, top};
use crate::fuzz::files::{check_scene, read};
use robot_compiler::SceneFile;

/// All shipped scenes, and the invalid ones of the compiler's tests.
pub const TARGET: FuzzTarget =
    FuzzTarget { name: "scene_file", check, examples, words: include_str!("../../words/toml.dict") };

fn examples() -> Vec<Vec<u8>> {
    let mut all = files(&["scenes"], "toml");
    // The path of a robot is relative to the scene.
    let mut below = files(&["scenes/chapter12", "scenes/campaign", "scenes/examples"], "toml");
    below.extend(invalid("toml"));
    all.extend(below.into_iter().map(|bytes| {
        let text = String::from_utf8_lossy(&bytes).replace("../../../robots", "../robots");
        text.replace("../../robots", "../robots").replace("../data", "../robot-compiler/tests/data").into()
    }));
    // The greatest accepted depth, and one more.
    all.extend([32, 33].into_iter().flat_map(nested));
    all
}

/// A text gives a scene, or an error with a location. An accepted scene has a hash, a source, a motion, and a controller that keeps its limits on
/// that motion.
pub fn check(bytes: &[u8]) {
    let path = top("scenes").join("any.toml");
    let text = String::from_utf8_lossy(bytes);
    let name = path.display().to_string();
    if let Some(scene) = read(&text, &name, "# the end", |text| SceneFile::from_toml_str(text, &path)) {
        check_scene(&scene);
    }
}

#[cfg(test)]
mod tests {
    use super::{examples, top};
    use robot_compiler::SceneFile;

    /// A wrong path to a robot would leave nothing to check.
    #[test]
    fn shipped_scenes_are_read_among_the_examples() {
        let path = top("scenes").join("any.toml");
        let read = |bytes: &Vec<u8>| SceneFile::from_toml_str(&String::from_utf8_lossy(bytes), &path).is_ok();
        let shipped =
            crate::fuzz::examples::files(&["scenes", "scenes/chapter12", "scenes/campaign", "scenes/examples"], "toml");
        assert_eq!(examples().iter().filter(|bytes| read(bytes)).count(), shipped.len());
    }
}
