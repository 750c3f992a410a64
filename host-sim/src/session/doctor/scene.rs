//! What the scene asks of a board.

use super::Check;
use super::board::described;
use link::Hello;
use robot_compiler::SceneFile;
use robot_compiler::drive::JointDrive;

/// The scene in the words in which its firmware speaks of itself, and the drives that its board must have lines for.
///
/// A scene that cannot be loaded never comes here: it is refused with its line.
#[must_use]
pub fn check(scene: &SceneFile, hello: &Hello) -> Check {
    let drive = scene.robot.joints.first().and_then(|joint| joint.drive.as_ref()).map(JointDrive::kind);
    let drives = drive.map_or("joints over the link".to_owned(), |kind| format!("drives of the kind {kind}"));
    Check::ok("scene", format!("{}: {}, {drives}", scene.name, described(hello)))
}
