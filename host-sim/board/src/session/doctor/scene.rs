//! Requirements of the scene on a board.

use super::Check;
use super::board::described;
use link::Hello;
use robot_compiler::SceneFile;
use robot_compiler::drive::JointDrive;

/// The scene, described like its firmware's own log, and the drives that the board needs lines for.
///
/// A scene that cannot be loaded never comes here: loading refuses it, with the line.
#[must_use]
pub fn check(scene: &SceneFile, hello: &Hello) -> Check {
    let drive = scene.robot.joints.first().and_then(|joint| joint.drive.as_ref()).map(JointDrive::kind);
    let drives = drive.map_or("joints over the link".to_owned(), |kind| format!("{kind} drives"));
    Check::ok("scene", format!("{}: {}, {drives}", scene.name, described(hello)))
}
