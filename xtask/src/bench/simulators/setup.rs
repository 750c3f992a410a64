//! The scene that both simulators run, and its settings.

use crate::budget::variant;
use anyhow::Result;
use std::path::{Path, PathBuf};

pub(super) const SCENE: &str = "scenes/puma560_pick.toml";

/// Step of both simulators, s.
pub(super) const STEP: f64 = 0.25e-3;

/// Keys of a scene and their values.
pub(super) type Settings = &'static [(&'static str, &'static str)];

/// Writes the scene with these settings.
pub(super) fn scene(name: &str, settings: &[(&str, &str)]) -> Result<PathBuf> {
    variant::write(Path::new(SCENE), &format!("simulators-{name}"), settings)
}
