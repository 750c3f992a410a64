//! The scene that both simulate, and its settings.

use crate::budget::variant;
use anyhow::Result;
use std::path::{Path, PathBuf};

pub(super) const SCENE: &str = "scenes/puma560_pick.toml";

/// Step that both take, s.
pub(super) const STEP: f64 = 0.25e-3;

/// Keys of a scene and their values.
pub(super) type Settings = &'static [(&'static str, &'static str)];

/// The scene with settings, and the motion's own duration.
pub(super) fn scene(name: &str, settings: &[(&str, &str)]) -> Result<PathBuf> {
    variant::write(Path::new(SCENE), &format!("simulators-{name}"), settings)
}
