//! Artefacts: the things that a page measures. Each has a hash that changes when the artefact does.

use super::tokens;
use crate::bench::kernels;
use crate::process::{cargo, root, target_directory};
use crate::scenes::shipped;
use anyhow::{Context as _, Result, ensure};
use firmware_image::Board;
use robot_compiler::emit;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::SystemTime;

/// Something that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Artefact {
    /// A named group of files and folders.
    Files(&'static str, &'static [&'static str]),
    /// The Rust of an arm and its controller that is compiled into the firmware, for these scenes; for all shipped scenes if the list is empty.
    Programs(&'static [&'static str]),
    /// The kernels that `cargo xtask bench` counts.
    Kernels,
    /// The log of the first 0.5 s of a scene's run.
    Log(&'static str),
    /// Output of `newtau` for these arguments and `--json`, without times; output of `campaign` if that is the first word.
    Printed(&'static str),
}

/// Simulated time of a hashed log, s.
const DURATION: &str = "0.5";

/// JSON keys with times that depend on this machine.
const TIMES: [&str; 3] = ["seconds", "realtime_factor", "seconds_per_tick"];

impl Artefact {
    /// Name on a page.
    pub(super) fn name(self) -> String {
        match self {
            Self::Files(name, _) => name.to_owned(),
            Self::Programs([]) => "emitted programs of all scenes".to_owned(),
            Self::Programs(scenes) => format!("emitted programs of {}", scenes.join(", ")),
            Self::Kernels => "emitted kernels".to_owned(),
            Self::Log(scene) => format!("log of {scene}, {DURATION} s"),
            Self::Printed(arguments) => format!("output of `{arguments}`"),
        }
    }
}

/// Hashes of artefacts, each computed once.
#[derive(Default)]
pub(super) struct Hashes(HashMap<Artefact, String>);

impl Hashes {
    /// The first 12 digits of an artefact's SHA-256.
    pub(super) fn of(&mut self, artefact: Artefact) -> Result<String> {
        if let Some(known) = self.0.get(&artefact) {
            return Ok(known.clone());
        }
        let mut hash = Hash(Sha256::new());
        match artefact {
            Artefact::Files(_, paths) => paths.iter().try_for_each(|path| hash.files(&root(), Path::new(path)))?,
            Artefact::Programs([]) => {
                let boards = Board::ALL.map(|board| root().join(board.scene()));
                shipped()?.into_iter().chain(boards).try_for_each(|scene| hash.program(&scene))?;
            }
            Artefact::Programs(scenes) => {
                scenes.iter().try_for_each(|name| hash.program(&root().join(format!("scenes/{name}.toml"))))?;
            }
            Artefact::Kernels => {
                let folder = fresh("kernels")?;
                kernels::write(folder.clone()).map_err(|error| anyhow::anyhow!("{error}"))?;
                hash.files(&folder, Path::new(""))?;
            }
            Artefact::Log(scene) => hash.text("log.csv", &log(scene)?),
            Artefact::Printed(arguments) => hash.text(arguments, &printed(arguments)?),
        }
        let digits = hash.digits();
        self.0.insert(artefact, digits.clone());
        Ok(digits)
    }
}

/// A hash in progress.
struct Hash(Sha256);

impl Hash {
    /// Adds a text and its name, each with its length, so that different lists of texts give different bytes.
    fn text(&mut self, name: &str, text: &str) {
        for part in [name, text] {
            self.0.update((part.len() as u64).to_le_bytes());
            self.0.update(part.as_bytes());
        }
    }

    /// Adds a file, or all files of a folder and its subfolders, by name.
    fn files(&mut self, folder: &Path, path: &Path) -> Result<()> {
        let whole = folder.join(path);
        if whole.is_dir() {
            let mut names: Vec<_> =
                std::fs::read_dir(&whole)?.map(|entry| Ok(entry?.file_name())).collect::<Result<_>>()?;
            names.sort();
            return names.into_iter().try_for_each(|name| self.files(folder, &path.join(name)));
        }
        let Some(text) = meaning(&whole)? else { return Ok(()) };
        // Remove the folder from paths in an emitted module, because it differs between runs.
        self.text(&path.to_string_lossy(), &text.replace(&*folder.to_string_lossy(), ""));
        Ok(())
    }

    /// Adds the files that the firmware of a scene includes.
    fn program(&mut self, scene: &Path) -> Result<()> {
        let name = scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let folder = fresh(&format!("program-{name}"))?;
        emit::write_firmware(scene, emit::Choices::default(), &folder)
            .map_err(|error| anyhow::anyhow!("{}: {error}", scene.display()))?;
        self.text("program", &name);
        self.files(&folder, Path::new(""))
    }

    fn digits(self) -> String {
        self.0.finalize().iter().take(6).map(|byte| format!("{byte:02x}")).collect()
    }
}

/// The part of a file that affects programs; `None` for a file that affects none.
fn meaning(path: &Path) -> Result<Option<String>> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    if matches!(extension.as_str(), "md" | "svg" | "png" | "snap") {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let said = || path.display().to_string();
    Ok(Some(match extension.as_str() {
        "rs" => tokens::of(&text).with_context(said)?,
        "toml" => format!("{:?}", toml::from_str::<toml::Table>(&text).with_context(said)?),
        _ => {
            let comment = |line: &&str| ["#!", "# ", "//", "/*", "* "].iter().any(|sign| line.starts_with(sign));
            let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !comment(line));
            lines.collect::<Vec<_>>().join("\n")
        }
    }))
}

/// Creates an empty folder that no other process uses.
fn fresh(name: &str) -> Result<PathBuf> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = target_directory().join("measured").join(format!("{}-{number}-{name}", std::process::id()));
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    Ok(folder)
}

/// The programs whose output is an artefact.
const NEWTAU: &str = "newtau";
const CAMPAIGN: &str = "campaign";

/// The standard output of `newtau` or `campaign`, in the profile of this program.
fn output_of(name: &str, arguments: &[&str]) -> Result<String> {
    let done = program(name)?.args(arguments).output().with_context(|| format!("cannot start {name}"))?;
    // A run that ends with a fault is a valid result.
    let ended = matches!(done.status.code(), Some(0 | 3));
    ensure!(ended, "{name} {}: {}", arguments.join(" "), String::from_utf8_lossy(&done.stderr));
    Ok(String::from_utf8(done.stdout)?)
}

/// Command for a program, without arguments. A test uses the program that was built together with it, because `cargo run` for one package would build it again.
pub(crate) fn program(name: &str) -> Result<Command> {
    let built = target_directory().join("debug").join(name);
    let made = built.metadata().and_then(|data| data.modified()).ok();
    let newer = |folder: &str| newest(&root().join(folder)).map(|time| made.is_none_or(|made| made < time));
    let sources = ["host-sim", "dynamics-core/src", "robot-compiler/src", "link", "xtask/trials/src"];
    if cfg!(debug_assertions)
        && !sources.iter().map(|folder| newer(folder)).collect::<Result<Vec<_>>>()?.contains(&true)
    {
        let mut command = Command::new(built);
        command.current_dir(root());
        return Ok(command);
    }
    let profile: &[&str] = if cfg!(debug_assertions) { &[] } else { &["--release"] };
    let package = if name == CAMPAIGN { "trials" } else { "host-sim" };
    let mut command = cargo(["run", "--quiet", "--locked", "--package", package, "--bin", name]);
    command.args(profile).arg("--");
    Ok(command)
}

/// Time of the last change of any file below a folder.
fn newest(folder: &Path) -> Result<SystemTime> {
    let mut newest = SystemTime::UNIX_EPOCH;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        newest = newest.max(if path.is_dir() { self::newest(&path)? } else { path.metadata()?.modified()? });
    }
    Ok(newest)
}

fn log(scene: &str) -> Result<String> {
    let folder = fresh(&format!("log-{}", scene.replace('/', "-")))?;
    let (path, out) = (format!("scenes/{scene}.toml"), folder.display().to_string());
    output_of(NEWTAU, &["run", &path, "--duration", DURATION, "--quiet", "--no-report", "--out", &out])?;
    let file = folder.join("log.csv");
    std::fs::read_to_string(&file).with_context(|| file.display().to_string())
}

fn printed(arguments: &str) -> Result<String> {
    let mut words: Vec<&str> = arguments.split_whitespace().chain(["--json"]).collect();
    let name = if words.first() == Some(&CAMPAIGN) { words.remove(0) } else { NEWTAU };
    let out = fresh("printed")?.display().to_string();
    if words.first() == Some(&"sweep") {
        words.extend(["--out", &out]);
    }
    let text = output_of(name, &words)?;
    let values = serde_json::Deserializer::from_str(&text).into_iter::<Value>();
    let values = values.map(|value| Ok(timeless(value?))).collect::<Result<Vec<Value>>>();
    Ok(serde_json::to_string(&values.with_context(|| format!("{name} {arguments} --json"))?)?)
}

/// Removes times that depend on this machine from JSON.
fn timeless(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let kept = map.into_iter().filter(|(key, _)| !TIMES.contains(&key.as_str()));
            Value::Object(kept.map(|(key, value)| (key, timeless(value))).collect())
        }
        Value::Array(list) => Value::Array(list.into_iter().map(timeless).collect()),
        other => other,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests;
