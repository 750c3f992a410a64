//! Requirements of the scene on a board.

use super::Check;
use super::board::described;
use link::Hello;
use robot_compiler::SceneFile;
use robot_compiler::drive::JointDrive;

/// Check of the scene: its hash in the format of the firmware's own log, and the kind of its drives.
///
/// A scene that cannot be loaded has already been rejected, with the line of the error.
#[must_use]
pub fn check(scene: &SceneFile, hello: &Hello) -> Check {
    let drive = scene.robot.joints.first().and_then(|joint| joint.drive.as_ref()).map(JointDrive::kind);
    let drives = drive.map_or("joints over the link".to_owned(), |kind| format!("{kind} drives"));
    Check::ok("scene", format!("{}: {}, {drives}", scene.name, described(hello)))
}
