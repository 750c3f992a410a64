//! Keys of a scene file that are needed before, or without, compiling its robot.

use anyhow::{Context as _, Result};
use std::path::{Path, PathBuf};

/// A scene file as unchecked keys and values; `robot_compiler` checks them later.
pub struct SceneKeys {
    path: PathBuf,
    table: toml::Table,
}

impl SceneKeys {
    /// Reads the file.
    ///
    /// # Errors
    /// The file does not exist or is not TOML.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("no scene file {}", path.display()))?;
        Self::parse(path, &text)
    }

    fn parse(path: &Path, text: &str) -> Result<Self> {
        let table = toml::from_str(text).with_context(|| path.display().to_string())?;
        Ok(Self { path: path.to_owned(), table })
    }

    /// The path of the robot's file, resolved from the scene's folder.
    pub fn robot(&self) -> Result<PathBuf> {
        let robot = self.table.get("robot").and_then(toml::Value::as_str);
        let robot = robot.with_context(|| format!("{}: robot: expected a path in quotes", self.path.display()))?;
        Ok(self.path.parent().unwrap_or(Path::new("")).join(robot))
    }

    /// True if the model is compiled into a kernel. Only a kernel can run from SRAM.
    pub fn has_a_kernel(&self) -> bool {
        let kernel = self.table.get("control").and_then(|control| control.get("kernel")?.as_str());
        kernel != Some("generic")
    }

    /// True for a scene whose firmware must never control a drive.
    pub fn bench_only(&self) -> bool {
        let bench = self.table.get("safety").and_then(|safety| safety.get("bench_only")?.as_bool());
        bench == Some(true)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::SceneKeys;
    use std::path::Path;

    fn keys(text: &str) -> SceneKeys {
        SceneKeys::parse(Path::new("scenes/a.toml"), text).unwrap()
    }

    #[test]
    fn the_robot_lies_where_the_scene_says() {
        let robot = keys("robot = \"../robots/puma560.toml\"").robot().unwrap();
        assert_eq!(robot, Path::new("scenes/../robots/puma560.toml"));
        let why = keys("robot = 5").robot().unwrap_err().to_string();
        assert_eq!(why, "scenes/a.toml: robot: expected a path in quotes");
    }

    #[test]
    fn a_scene_for_the_bench_says_so() {
        assert!(keys("[safety]\nbench_only = true").bench_only());
        assert!(!keys("[safety]\nbench_only = false").bench_only());
        assert!(!keys("[control]\nbench_only = true").bench_only());
    }

    #[test]
    fn only_the_recursion_at_run_time_is_no_kernel() {
        assert!(keys("").has_a_kernel());
        assert!(keys("[control]\nkernel = \"exact\"").has_a_kernel());
        assert!(!keys("[control]\n  kernel  =  'generic' # so").has_a_kernel());
        assert!(keys("[plant]\nkernel = \"generic\"").has_a_kernel());
    }
}
