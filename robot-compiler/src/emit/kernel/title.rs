//! Origin of a kernel: its robot and scene.

/// Contents of the head of the text.
#[derive(Clone, Copy, Debug)]
pub struct Title<'a> {
    /// The robot.
    pub robot: &'a str,
    /// The scene.
    pub scene: &'a str,
    /// Hash of everything that determines the bits of a tick; see [`crate::SceneFile::hash`].
    pub hash: u64,
}
