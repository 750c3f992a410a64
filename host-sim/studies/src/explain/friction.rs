//! Terms of friction in addition to viscous and Coulomb friction.

use super::{Error, Lab, OperationCount, PartReport};
use dynamics_core::Term;
use robot_compiler::choose::operations_of;
use robot_compiler::kernel::Operations;
use robot_compiler::scene::ModelTerm;
use robot_compiler::{FrictionPart, Robot, SceneFile};
use sim::failure::{Failure, in_file};
use std::path::Path;
use toml_edit::{DocumentMut, Item};

/// Names of the joints with a term of friction.
fn joints(robot: &Robot, part: FrictionPart) -> Vec<String> {
    let has = robot.joints.iter().filter(|joint| joint.friction.is_some_and(|friction| friction.has(part)));
    has.map(|joint| joint.name.clone()).collect()
}

/// Terms that a joint has and the scene's controller uses.
pub(super) fn parts(file: &SceneFile) -> Vec<FrictionPart> {
    let used = file.model.full().state(ModelTerm::Friction) != Term::Absent;
    FrictionPart::ALL.into_iter().filter(|part| used && !joints(&file.robot, *part).is_empty()).collect()
}

impl<const N: usize> Lab<'_, N> {
    /// Reports the cost and benefit of each term on the scene's motion.
    pub(super) fn friction(&self) -> Result<Vec<PartReport>, Failure> {
        let report = |part: FrictionPart| {
            let names = joints(&self.file.robot, part);
            let (one, count) = (operations_of(part), names.len());
            let all = Operations { mul: one.mul * count, add: one.add * count, sub: one.sub * count, ..one };
            let mut scene = self.file.clone();
            scene.model = scene.model.full().clone();
            for joint in &mut scene.robot.joints {
                joint.friction = joint.friction.map(|friction| friction.without(part));
            }
            Ok(PartReport {
                term: part.name(),
                joints: names,
                operations: OperationCount::less(&all, &Operations::default()),
                chip: None,
                torque: Error::from(self.along.error_without_part(part)),
                tracking: self.tracking_of(&scene)?,
            })
        };
        parts(self.file).into_iter().map(report).collect()
    }
}

/// Text of a robot file after a term of friction is removed.
///
/// # Errors
/// [`Failure::Input`]: the file cannot be read.
pub(super) fn robot_without(path: &Path, part: FrictionPart) -> Result<String, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| in_file(path, &error))?;
    let mut document: DocumentMut = text
        .parse()
        .map_err(|error: toml_edit::TomlError| Failure::Input(miette::miette!("{}: {error}", path.display())))?;
    let tables = document.get_mut("joint").and_then(Item::as_array_of_tables_mut);
    for joint in tables.into_iter().flat_map(toml_edit::ArrayOfTables::iter_mut) {
        if let Some(friction) = joint.get_mut("friction").and_then(Item::as_table_like_mut) {
            part.keys().iter().for_each(|key| drop(friction.remove(key)));
        }
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::robot_without;
    use robot_compiler::{FrictionPart, Robot};

    #[test]
    fn a_robot_file_without_a_term_is_that_robot_without_it_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("newtau-friction-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("arm.toml");
        let all = "friction = { viscous = 0.1, coulomb = 0.5, coulomb_load = 0.02, breakaway = 0.9, stribeck_speed = 0.05, \
                   breakaway_load = 0.1, asymmetry = 0.05, offset = -0.1 }";
        let text = format!(
            "name = \"arm\"\nsource = \"a test\"\n[[joint]]\nname = \"swing\"\ntype = \"revolute\"\n\
             dh = {{ a = 0.5, alpha = 0.0, d = 0.0, theta = 0.0 }}\nmass = 1.5\ncom = [-0.25, 0.0, 0.0]\n{all}\n"
        );
        std::fs::write(&path, &text).expect("a file");
        let robot = Robot::load(&path).expect("a robot");
        for part in FrictionPart::ALL {
            let less = robot_without(&path, part).expect("a text");
            let less = Robot::from_toml_str(&less, "arm.toml").expect("a robot");
            let expected = robot.joints[0].friction.map(|friction| friction.without(part));
            assert_eq!(less.joints[0].friction, expected, "{part:?}");
            assert_ne!(less.joints[0].friction, robot.joints[0].friction, "{part:?}");
        }
        std::fs::remove_dir_all(&folder).expect("removed");
        assert!(robot_without(&path, FrictionPart::Load).is_err());
    }
}
