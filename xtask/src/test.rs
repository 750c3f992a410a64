//! `cargo xtask test`: all tests and checks. Steps that fail fast come first.

use crate::process::{cargo, run, target_directory};
use crate::tally::Tally;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{bench, budget, cores, gate, pages, python, report, robot_data, setup, templates};
use anyhow::{Context, Result, bail};
use firmware_image::board::SCENE_DEFAULT;
use firmware_image::{Board, Build};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, exit};
use std::time::{SystemTime, UNIX_EPOCH};
use std::{env, fs};

/// Installs missing tools, runs everything, and prints the counts at the end. Fails if anything failed.
pub(crate) fn all() -> Result<()> {
    setup::all()?;
    let urdfs = robot_data::fetch();
    let mut tally = Tally::default();
    static_checks(&mut tally);
    host_tests(&mut tally, &urdfs);
    // The commands of the pages run one after the other, and most of the steps below use one processor, too.
    let pages = std::thread::spawn(|| pages::run_commands(&[]));
    chip_tests(&mut tally);
    tally.step("Python wheel", python::check);
    tally.step("commands of the pages, the rest", || pages.join().unwrap_or_else(|_| bail!("they ended in a panic")));
    if !tally.report() {
        exit(1)
    }
    Ok(())
}

/// Checks format, lints and documentation.
fn static_checks(tally: &mut Tally) {
    for workspace in Workspace::ALL {
        tally.command(&format!("format{workspace}"), &mut workspace.cargo(["fmt", "--all", "--check"]));
        let mut lints = workspace.cargo(["clippy", "--workspace", "--all-targets", "--locked"]);
        if workspace == Workspace::Product {
            lints.arg("--features=chip-image/log");
        }
        tally.command(&format!("lints{workspace}"), lints.args(["--", "-D", "warnings"]));
        if workspace == Workspace::Product {
            let mut first = workspace.cargo(["clippy", "--package", "host-sim", "--no-default-features", "--locked"]);
            tally.command("lints of newtau-run", first.args(["--", "-D", "warnings"]));
        }
        let mut doc = workspace.cargo(["doc", "--workspace", "--no-deps", "--locked"]);
        tally.command(&format!("documentation{workspace}"), doc.env("RUSTDOCFLAGS", "-D warnings"));
    }
    tally.step("format of the firmware templates", templates::format);
    tally.step("packages that the chip shares", for_the_chip);
    tally.step("packages for others", for_others);
    for system in ["aarch64-apple-darwin", "x86_64-pc-windows-gnu"] {
        tally.step(&format!("newtau checked for {system}"), || for_system(system));
    }
}

/// Checks that the program compiles for another system. Nothing is linked or run, which would need that system.
fn for_system(name: &str) -> Result<()> {
    if !cores::has_targets()? {
        return Ok(());
    }
    cores::target(name)?;
    run(&mut cargo(["check", "--locked", "--quiet", "--package", "host-sim", "--target", name]))
}

/// Builds the packages that others can depend on from their packed files alone. That is what a stranger would get.
///
/// Cargo serves the packages to each other from a registry in the target folder. It unpacks and compiles one version from one path once, and takes that
/// ever after, even if the files have changed. So each run calls the target folder by another path.
fn for_others() -> Result<()> {
    let start = SystemTime::now().duration_since(UNIX_EPOCH)?;
    let target = env::temp_dir().join(format!("newtau-target-{}", start.as_nanos()));
    symlink(target_directory(), &target).with_context(|| format!("cannot make the link {}", target.display()))?;
    // The dependencies are those of the lints above, which are on this machine by now. Without `--offline`, cargo asks the registry's index again
    // for each package, and a short failure of the network would fail this step.
    let mut package = cargo(["package", "--locked", "--offline", "--allow-dirty", "--quiet", "--target-dir"]);
    let result = run(package.arg(&target).args(FOR_OTHERS.iter().flat_map(|name| ["--package", name])));
    fs::remove_file(&target).with_context(|| format!("cannot remove the link {}", target.display()))?;
    result
}

/// Programs that show others how to use these packages. Each asserts what it prints.
const EXAMPLES: [&str; 16] = [
    "buffered_motion",
    "check_robot",
    "control_loop",
    "emit_kernel",
    "forward_dynamics",
    "four_bar",
    "frames",
    "friction",
    "gravity_compensation",
    "kernel",
    "payload",
    "safety",
    "tip_pose",
    "torques",
    "trajectory",
    "urdf",
];

/// Packages that others can depend on.
const FOR_OTHERS: [&str; 4] = ["dynamics-core", "newtau-link", "newtau-session", "robot-compiler"];

/// Checks the packages that board and desk share for the chip, where no standard library hides a missing feature.
///
/// In a build of the workspace, one package could enable a feature that another one lacks. Packages for others are compiled alone by
/// `cargo package`, and programs alone by the steps that run them.
fn for_the_chip() -> Result<()> {
    let toolchain = Toolchain::find_or_install()?;
    for package in ["dynamics-core", "newtau-link", "newtau-session", "joint-io"] {
        run(toolchain.cargo("check").args(["--locked", "--quiet", "--package", package]))?;
    }
    Ok(())
}

/// Runs unit, integration, property and snapshot tests, and the examples in the documentation.
fn host_tests(tally: &mut Tally, urdfs: &Path) {
    // A missing or different snapshot is a failure; no new snapshot is written.
    let mut tests = cargo(["nextest", "run", "--workspace", "--locked", "--no-fail-fast"]);
    // Include the long tests, which a plain test run leaves out.
    tests.args(["--run-ignored", "all", "--filterset", &format!("not {CHIP_TESTS}")]);
    if let Some(python) = setup::viewers() {
        tests.env("NEWTAU_VIEWERS_PYTHON", python);
    }
    tally.tests("host tests", tests.env("NEWTAU_URDF_DIR", urdfs).env("INSTA_UPDATE", "no"));
    let mut tests = Workspace::Bench.cargo(["nextest", "run", "--workspace", "--locked", "--no-fail-fast"]);
    tally.tests("tests of bench", tests.args(["--run-ignored", "all"]));
    for example in EXAMPLES {
        // Use the program that was built with the tests. `cargo run` for one package would build it again, with that package's features.
        let program = target_directory().join("debug/examples").join(example);
        tally.command(&format!("example {example}"), &mut Command::new(program));
    }
    if report::checks() {
        tally.step("scripts of the report", report::check);
    } else {
        eprintln!("scripts of the report: not compared with their sources, which takes npm");
    }
    for workspace in Workspace::ALL {
        let mut tests = workspace.cargo(["test", "--workspace", "--doc", "--locked"]);
        tally.tests(&format!("documentation examples{workspace}"), &mut tests);
    }
}

/// Builds the firmware for every board, compares it with its budgets, checks the tick for forbidden symbols, and runs it in the emulated chip.
fn chip_tests(tally: &mut Tally) {
    let scene = Path::new(SCENE_DEFAULT);
    for board in Board::ALL {
        tally.step(&format!("firmware for {board}"), || {
            let scene = Path::new(board.scene());
            budget::sizes(&Build::of(scene, board).run()?, scene, board)
        });
    }
    tally.step("gate", || gate::check(scene));
    tally.step("instruction counts", bench::gate);
    tally.step("cores of other kinds", cores::quick);
    tally.step("firmware templates", templates::run);
    tally.step("budget, its cheap part", budget::gate);
    tally.step("cycles, estimated", || bench::cycles::run(false));
    tally.step("cycles of one class of instructions each", || bench::micro::run(None, false));
    let mut tests = cargo(["nextest", "run", "--workspace", "--locked", "--no-fail-fast"]);
    tally.tests("chip tests", tests.args(["--filterset", CHIP_TESTS]));
}

/// Tests that need the emulator.
const CHIP_TESTS: &str = "(binary(/^chip/) or test(/^chip::(firmware|attack|live)_tests/))";
