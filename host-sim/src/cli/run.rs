//! `run`: close the loop of a scene, show and write what came of it.

use crate::cli::progress::progress_bar;
use crate::cli::{RunArgs, Target};
use crate::failure::{self, Failure};
use crate::run::closed_loop::End;
use crate::run::plot;
use crate::run::simulate::{self, Run};
use indicatif::ProgressBar;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Run a scene; returns the exit code.
///
/// # Errors
/// A scene that is wrong, a file that cannot be written, a target that died (what was recorded is written first).
pub fn run(args: &RunArgs, stop: &AtomicBool) -> Result<u8, Failure> {
    let scene = scene(args)?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&scene.name)));
    // Better now than after the run.
    fs::create_dir_all(&folder).map_err(|error| in_file(&folder, &error))?;
    let progress = if args.json || args.quiet { ProgressBar::hidden() } else { progress_bar(None, "ticks") };
    let run = with_dof!(scene.robot.dof(), N => match args.target {
        Target::Desk => simulate::on_desk::<N>(&scene, stop, &progress),
        Target::Qemu => crate::chip::on_chip::run::<N>(&scene, stop, &progress),
    })?;
    let files = write(&run, &scene.name, &folder)?;
    show(args, &run, &files).or_else(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Ok(()),
        _ => Err(Failure::Output(error)),
    })?;
    let code = exit_code(&run);
    match run.failure {
        Some(report) => Err(Failure::Target(report)),
        None => Ok(code),
    }
}

/// The scene with what the command line changes.
fn scene(args: &RunArgs) -> Result<SceneFile, Failure> {
    if args.target == Target::Qemu
        && let Some(scalar) = args.scalar.map(ScalarChoice::from).filter(|scalar| *scalar != ScalarChoice::F32)
    {
        return Err(Failure::Input(miette::miette!(
            "--scalar {} with --target qemu: expected f32, which the chip has",
            scalar.name()
        )));
    }
    let mut scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    set_duration(&mut scene, args.duration)?;
    if let Some(law) = args.law {
        scene.control.law = law.into();
    }
    // The command line takes no name that is none.
    scene
        .control
        .choose(None, args.trig.as_deref())
        .map_err(|problem| Failure::Input(miette::miette!("--trig {problem}")))?;
    if let Some(scalar) = args.scalar {
        scene.control.scalar = scalar.into();
    }
    Ok(scene)
}

/// Run for another time than the scene says, if one is given.
pub(crate) fn set_duration(scene: &mut SceneFile, duration: Option<f64>) -> Result<(), Failure> {
    if let Some(duration) = duration {
        if !(duration.is_finite() && duration > 0.0) {
            return Err(Failure::Input(miette::miette!("--duration {duration}: expected a time in s above zero")));
        }
        scene.duration = Some(duration);
    }
    Ok(())
}

/// A name that is one safe part of a path.
pub(crate) fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_') { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    if name.is_empty() { "scene".to_owned() } else { name }
}

/// Write log, summary and plots; returns the files.
fn write(run: &Run, name: &str, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let log = folder.join("log.csv");
    let file = File::create(&log).map_err(|error| in_file(&log, &error))?;
    run.record.write_csv(BufWriter::new(file)).map_err(|error| in_file(&log, &error))?;
    let summary = folder.join("summary.json");
    fs::write(&summary, json(run)?).map_err(|error| in_file(&summary, &error))?;
    let plots = plot::write_all(&run.record, name, folder).map_err(|error| in_file(folder, &error))?;
    Ok([log, summary].into_iter().chain(plots).collect())
}

fn json(run: &Run) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(&run.summary).map_err(|error| Failure::Output(error.into()))?;
    Ok(text + "\n")
}

fn show(args: &RunArgs, run: &Run, files: &[PathBuf]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if args.json {
        let text = serde_json::to_string_pretty(&run.summary)?;
        writeln!(out, "{text}")?;
    } else if !args.quiet {
        writeln!(out, "{}", run.summary.table())?;
        for (index, file) in files.iter().enumerate() {
            let name = if index == 0 { "files" } else { "" };
            writeln!(out, "{name:<20}{}", file.display())?;
        }
    }
    out.flush()
}

pub(crate) fn exit_code(run: &Run) -> u8 {
    let differs = run.summary.parity.is_some_and(|parity| parity.mismatches > 0);
    match run.end {
        _ if differs => failure::PARITY,
        End::Interrupted => failure::INTERRUPTED,
        End::Diverged(_) => failure::FAULT,
        End::TargetFailed => failure::OUTSIDE,
        End::Complete if run.summary.faults.is_empty() => 0,
        End::Complete => failure::FAULT,
    }
}

pub(crate) fn in_file(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Output(io::Error::other(format!("{}: {error}", path.display())))
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn a_scene_cannot_name_a_folder_elsewhere() {
        assert_eq!(file_name("puma560_pick"), "puma560_pick");
        assert_eq!(file_name("../../etc/x y"), "______etc_x_y");
        assert_eq!(file_name(""), "scene");
    }
}
