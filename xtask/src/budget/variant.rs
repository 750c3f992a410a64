//! A variant of a scene file: some settings are changed and the rest stays. The settings belong to `[control]` unless another table is named.

use crate::process::root;
use crate::toolchain;
use anyhow::{Context as _, Result};
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item, table, value};

/// Writes a variant of a scene into the build folder, with `name` in its file name.
pub(crate) fn write(scene: &Path, name: &str, settings: &[(&str, &str)]) -> Result<PathBuf> {
    let scene = root().join(scene);
    let text = std::fs::read_to_string(&scene).with_context(|| format!("no scene file {}", scene.display()))?;
    let folder = toolchain::target_directory().join("budget");
    std::fs::create_dir_all(&folder)?;
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    let path = folder.join(format!("{stem}-{name}.toml"));
    std::fs::write(
        &path,
        with(&text, scene.parent().unwrap_or(Path::new(".")), settings).with_context(|| scene.display().to_string())?,
    )?;
    Ok(path)
}

/// Returns the text with these settings and an absolute path of its robot. `KEY` is a key of `[control]`, `TABLE.KEY` of another table, and `.KEY` of
/// the top level. An empty value removes the key.
fn with(text: &str, folder: &Path, settings: &[(&str, &str)]) -> Result<String> {
    let mut scene: DocumentMut = text.parse()?;
    if let Some(robot) = scene.get("robot").and_then(Item::as_str) {
        scene["robot"] = value(folder.join(robot).display().to_string());
    }
    for (name, setting) in settings {
        let (of, key) = name.split_once('.').unwrap_or(("control", name));
        let setting = if setting.is_empty() { Item::None } else { Item::Value(setting.parse()?) };
        if of.is_empty() {
            scene[key] = setting;
        } else {
            scene.entry(of).or_insert_with(table)[key] = setting;
        }
    }
    Ok(scene.to_string())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::with;
    use std::path::Path;

    const SCENE: &str = "robot = \"../robots/a.toml\"\n[control]\nrate = 1000.0\nlaw = \"pd\"\n[plant]\nrate = 5\n";

    #[test]
    fn a_setting_of_the_control_is_replaced_and_nothing_else() {
        let changed = with(SCENE, Path::new("/p/scenes"), &[("rate", "20000.0")]).unwrap();
        let expected =
            "robot = \"/p/scenes/../robots/a.toml\"\n[control]\nrate = 20000.0\nlaw = \"pd\"\n[plant]\nrate = 5\n";
        assert_eq!(changed, expected);
    }

    #[test]
    fn a_scene_without_the_table_gets_it() {
        let scene = "robot = \"/a.toml\"\n[motion]\n";
        let changed = with(scene, Path::new("/p"), &[("kernel", "\"regrouped\"")]).unwrap();
        assert_eq!(changed, "robot = \"/a.toml\"\n[motion]\n\n[control]\nkernel = \"regrouped\"\n");
        let changed = with(scene, Path::new("/p"), &[(".duration", "9.0")]).unwrap();
        assert_eq!(changed, "robot = \"/a.toml\"\nduration = 9.0\n[motion]\n");
        let changed = with(scene, Path::new("/p"), &[("plant.masses", "1.2")]).unwrap();
        assert_eq!(changed, "robot = \"/a.toml\"\n[motion]\n\n[plant]\nmasses = 1.2\n");
    }
}
