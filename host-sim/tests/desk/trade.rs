//! The trade-off between speed and accuracy: its measurements, files and choices.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test that fails should stop there; costs are made up of whole numbers"
)]

use dynamics_core::control::Between;
use dynamics_core::trig::Method;
use indicatif::ProgressBar;
use robot_compiler::kernel::Level;
use robot_compiler::scene::{KernelChoice, ScalarChoice};
use robot_compiler::{Ends, SceneFile};
use sim::failure::Failure;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::trade::baseline::Baseline;
use studies::trade::chip::interrupt::Interrupt;
use studies::trade::chip::{CLOCK, Chip, Cost};
use studies::trade::choice::{Choice, Every, TermSet};
use studies::trade::request::{Budget, Percentage};
use studies::trade::{Trade, TradePoint, Workshop, trade};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

pub(crate) fn shipped(name: &str) -> PathBuf {
    Path::new(ROOT).join(name)
}

pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("trade-{name}-{}", std::process::id()));
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Costs without a chip, derived from the scene files, so that their order is known.
fn made_up(paths: &[PathBuf]) -> Vec<Cost> {
    let cost = |path: &PathBuf| {
        let scene = SceneFile::load(path).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        let mut cycles = 1000.0;
        cycles *= if text.contains("\"f64\"") { 10.0 } else { 1.0 };
        cycles *= if text.contains("\"pd\"") { 0.1 } else { 1.0 };
        cycles *= if text.contains("\"pd-gravity\"") { 0.3 } else { 1.0 };
        cycles *= if scene.control.kernel == KernelChoice::Regrouped { 0.8 } else { 1.0 };
        Cost {
            instructions: cycles,
            instructions_max: cycles as u64,
            cycles,
            cycles_max: cycles,
            flash: 1,
            ram: 1,
            matches_desk: true,
        }
    };
    paths.iter().map(cost).collect()
}

/// A chip with these costs, whose interrupt takes this many cycles more than its controller; or a chip that does not answer.
struct MadeUpChip {
    asked: RefCell<usize>,
    answers: bool,
}

/// Cycles of the simulated firmware interrupt, of which the controller takes 1,000.
const INTERRUPT: f64 = 5000.0;

impl MadeUpChip {
    fn new(answers: bool) -> Self {
        Self { asked: RefCell::new(0), answers }
    }
}

impl Chip for MadeUpChip {
    fn controllers(&self, scenes: &[PathBuf], _: &AtomicBool) -> Result<Vec<Cost>, Failure> {
        *self.asked.borrow_mut() += scenes.len();
        if self.answers { Ok(made_up(scenes)) } else { Err(Failure::Interrupted) }
    }

    fn interrupt(&self, _: &Path, _: &AtomicBool) -> Result<Interrupt, Failure> {
        *self.asked.borrow_mut() += 1;
        Ok(Interrupt { instructions: INTERRUPT, cycles: INTERRUPT })
    }
}

fn choices(base: &Baseline) -> Vec<Choice> {
    let mut all = Vec::new();
    for scalar in [ScalarChoice::F32, ScalarChoice::F64] {
        for terms in [TermSet::Full, TermSet::NoCoriolis, TermSet::Gravity, TermSet::None] {
            for kernel in [Level::Exact, Level::Regrouped] {
                let choice = Choice { scalar, terms, kernel, ..base.own() }.plain();
                if !all.contains(&choice) {
                    all.push(choice);
                }
            }
        }
    }
    all
}

fn measured(scene: &Path, folder: &Path, fresh: bool) -> (Trade, usize) {
    measured_where(scene, folder, fresh, |_| true)
}

/// Measures the choices that satisfy `wanted`.
pub(crate) fn measured_where(scene: &Path, folder: &Path, fresh: bool, wanted: fn(&Choice) -> bool) -> (Trade, usize) {
    let base = Baseline::load(scene, Ends::default()).unwrap();
    let choices: Vec<Choice> = choices(&base).into_iter().filter(wanted).collect();
    let chip = MadeUpChip::new(true);
    let stop = AtomicBool::new(false);
    let progress = ProgressBar::hidden();
    let shop = Workshop { folder, fresh, stop: &stop, progress: &progress };
    let found = trade(&base, scene, &choices, &chip, &shop).unwrap();
    (found, chip.asked.into_inner())
}

fn point<'a>(trade: &'a Trade, scalar: &str, terms: &str, kernel: &str) -> &'a TradePoint {
    let of = |p: &&TradePoint| {
        let [of_scalar, _, of_terms, _, _, _, of_kernel, _] = p.choice.cells();
        of_scalar == scalar && of_terms == terms && of_kernel == kernel
    };
    trade.points.iter().find(of).unwrap()
}

#[test]
fn errors_are_what_the_choices_leave_out() {
    let folder = folder("errors");
    let (trade, _) = measured(&shipped("scenes/planar2r_swing.toml"), &folder, true);
    assert_eq!(trade.points.len(), 2 * (3 * 2 + 1));
    let error = |scalar: &str, terms: &str, kernel: &str| point(&trade, scalar, terms, kernel).torque_of_limit.unwrap();
    // Rounding errors. In double precision: that of the constants, and 1e-16 of the torque. In single precision: 5e8 times as large.
    let double = error("f64", "full", "exact");
    assert!(double > 1e-18 && double < 2e-15, "{double:e}");
    let single = error("f32", "full", "exact");
    assert!(single > 1e-8 && single < 1e-6, "{single:e}");
    let regrouped = error("f32", "full", "regrouped");
    assert!(regrouped > 1e-8 && regrouped < 1e-6, "{regrouped:e}");
    // Fewer terms give larger errors, in both precisions.
    for scalar in ["f32", "f64"] {
        let [full, less, gravity, none] =
            [("full", "exact"), ("no-coriolis", "exact"), ("gravity", "exact"), ("none", "exact")]
                .map(|(terms, kernel)| error(scalar, terms, kernel));
        assert!(full < 1e-3 * less && less < gravity && gravity <= none, "{full} {less} {gravity} {none}");
    }
    let relative = error("f32", "none", "exact") / error("f64", "none", "exact") - 1.0;
    assert!(relative.abs() < 1e-5, "{relative:e}");
    // A worse model tracks worse.
    let tracking = |terms: &str| point(&trade, "f64", terms, "exact").tracking.unwrap();
    assert!(3.0 * tracking("full") < tracking("none"), "{} {}", tracking("full"), tracking("none"));
    let names: Vec<&str> = trade.courses.iter().map(|course| course.name).collect();
    assert_eq!(names, ["slow", "fast", "singular"]);
    assert!(trade.courses[0].speed < 0.11 && trade.courses[1].speed > 0.3, "{:?}", trade.courses);
    // Two rods are nearest to a singularity when stretched or folded.
    assert!(trade.courses[2].least_eigenvalue <= trade.courses[1].least_eigenvalue, "{:?}", trade.courses);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_front_holds_what_nothing_beats() {
    let folder = folder("front");
    let (trade, _) = measured(&shipped("scenes/planar2r_swing.toml"), &folder, true);
    let cycles: Vec<f64> = trade.points.iter().map(|point| point.cost.cycles).collect();
    assert!(cycles.is_sorted());
    for (what, error) in [
        ("torque", (|p: &TradePoint| (p.on_torque_front, p.torque_of_limit)) as fn(&TradePoint) -> _),
        ("tracking", |p: &TradePoint| (p.on_tracking_front, p.tracking)),
    ] {
        for point in &trade.points {
            let (on_front, own) = error(point);
            let beaten = trade.points.iter().any(|other| {
                other.cost.cycles <= point.cost.cycles
                    && error(other).1 <= own
                    && (other.cost.cycles < point.cost.cycles || error(other).1 < own)
            });
            assert!(!(on_front && beaten), "{what}: {:?}", point.choice);
            assert!(
                on_front || beaten || cycles.iter().filter(|c| **c == point.cost.cycles).count() > 1,
                "{what}: {:?}",
                point.choice
            );
        }
        assert!(error(&trade.points[0]).0, "{what}: the cheapest is on the front");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_share_of_the_processor_is_that_of_the_whole_interrupt() {
    let folder = folder("share");
    let (trade, _) = measured(&shipped("scenes/planar2r_swing.toml"), &folder, true);
    assert_eq!(trade.surroundings.cycles, INTERRUPT - 1000.0);
    for TradePoint { cost, interrupt, choice, .. } in &trade.points {
        assert_eq!(interrupt.cycles, cost.cycles + 4000.0);
        assert_eq!(interrupt.cpu_share, interrupt.cycles * choice.rate / CLOCK);
        assert_eq!(interrupt.cpu_share_max, interrupt.cycles_max * choice.rate / CLOCK);
    }
    let own = point(&trade, "f32", "full", "exact");
    assert_eq!(own.interrupt.cycles, INTERRUPT);
    let share = format!("{:.1} %", 100.0 * INTERRUPT * 1000.0 / CLOCK);
    assert!(trade.markdown().contains(&share), "{share}: {}", trade.markdown());
    for text in [trade.table(), trade.markdown()] {
        assert!(text.contains("interrupt: cycles, est.") && text.contains("cycles of the whole interrupt"), "{text}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_page_has_every_choice_and_names_the_front() {
    let folder = folder("picture");
    let (trade, _) = measured(&shipped("scenes/planar2r_swing.toml"), &folder, true);
    let on = |front: fn(&TradePoint) -> bool| trade.points.iter().filter(|point| front(point)).count();
    // The page has every choice with the command that measures it again. The front is named, and the scene's own choice is ringed.
    let html = trade.page().html();
    let commands = html.matches("data-command=").count();
    let fronts = on(|point| point.on_torque_front) + on(|point| point.on_tracking_front);
    assert_eq!(commands, 2 * trade.points.len() + fronts);
    assert!(trade.points.iter().all(|point| html.contains(&format!("data-command=\"{}\"", point.command))));
    assert!(html.contains("class=\"ring\"") && html.contains("terms gravity") && !html.contains("terms diagonal"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_is_known_is_not_measured_again() {
    let (folder, scene) = (folder("resume"), shipped("scenes/planar2r_swing.toml"));
    let (first, asked) = measured(&scene, &folder, false);
    // The interrupt is measured only once.
    assert_eq!(asked, first.points.len() + 1);
    let (second, asked) = measured(&scene, &folder, false);
    assert_eq!((asked, &second), (0, &first));
    let (third, asked) = measured(&scene, &folder, true);
    assert_eq!((asked, &third), (first.points.len() + 1, &first));
    // Half of the file is lost; the other half is kept.
    let path = folder.join("measured.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    let chip: Vec<&str> = text.lines().filter(|line| line.contains("\"chip-")).collect();
    let kept: String = text.lines().filter(|line| !chip[..5].contains(line)).map(|line| format!("{line}\n")).collect();
    std::fs::write(&path, kept).unwrap();
    let (fourth, asked) = measured(&scene, &folder, false);
    assert_eq!((asked, &fourth), (5, &first));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn an_interrupted_work_says_so_and_keeps_what_it_has() {
    let (folder, scene) = (folder("interrupted"), shipped("scenes/planar2r_swing.toml"));
    let base = Baseline::load(&scene, Ends::default()).unwrap();
    let stop = AtomicBool::new(false);
    let progress = ProgressBar::hidden();
    let shop = Workshop { folder: &folder, fresh: true, stop: &stop, progress: &progress };
    let chip = MadeUpChip::new(false);
    assert!(matches!(trade(&base, &scene, &choices(&base), &chip, &shop), Err(Failure::Interrupted)));
    let text = std::fs::read_to_string(folder.join("measured.jsonl")).unwrap();
    assert_eq!(text.lines().filter(|line| line.contains("\"desk-")).count(), choices(&base).len());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_choice_is_written_into_the_scene_and_nothing_else_is() {
    let path = shipped("scenes/puma560_pick.toml");
    let base = Baseline::load(&path, Ends::default()).unwrap();
    let own = SceneFile::from_toml_str(&base.with(&base.own()), &path).unwrap();
    let mut plain = SceneFile::load(&path).unwrap();
    plain.robot.path.clone_from(&own.robot.path);
    assert_eq!(own, plain);
    let choice = Choice {
        trig: Method::Libm,
        terms: TermSet::NoCoriolis,
        friction: false,
        rotors: false,
        kernel: Level::Regrouped,
        rate: 2000.0,
        ..base.own()
    };
    let text = base.with(&choice);
    for kept in ["# Held all the way", "observer_bandwidth = 600.0", "[sensors]\nencoder = true"] {
        assert!(text.contains(kept), "{kept}: {text}");
    }
    for made in
        ["coriolis = \"absent\"", "rotor = \"absent\"", "trig = \"libm\"", "kernel = \"regrouped\"", "rate = 2000.0"]
    {
        assert_eq!(text.matches(made).count(), 1, "{made}: {text}");
    }
    assert_eq!(text.matches("rotor =").count(), 1);
    let file = SceneFile::from_toml_str(&text, &path).unwrap();
    assert_eq!((file.period(), file.steps_per_tick()), (0.0005, 4));
    assert!(!file.model.friction && file.plant.friction);
}

#[test]
fn terms_that_were_chosen_by_a_tolerance_are_written_out() {
    let path = shipped("scenes/puma560_auto.toml");
    let base = Baseline::load(&path, Ends::default()).unwrap();
    let auto = SceneFile::load(&path).unwrap();
    assert!(base.file.model.auto.is_none());
    let full = robot_compiler::scene::ModelSpec { auto: None, ..auto.model.full().clone() };
    assert_eq!(base.file.model, full);
}

#[test]
fn a_robot_alone_gets_a_scene_of_its_own() {
    for robot in ["robots/ur5.toml", "robots/scara.toml", "robots/chapter12/cartesian_pp.toml"] {
        let path = shipped(robot);
        let base = Baseline::load(&path, Ends::default()).unwrap();
        let default = SceneFile::default_for(base.file.robot.clone());
        assert_eq!(
            (&base.file.motion, &base.file.model, &base.file.control),
            (&default.motion, &default.model, &default.control)
        );
    }
}

#[test]
fn what_is_asked_for_is_read_or_refused() {
    let share = |text: &str| text.parse::<Percentage>().ok().map(|share| share.0);
    assert_eq!([share("20%"), share("0.5"), share("0.2 %")], [Some(0.2), Some(0.5), Some(0.002)]);
    assert_eq!([share("0"), share("120%"), share("x"), share("nan")], [None; 4]);
    let budget = |text: &str| text.parse::<Budget>().ok();
    assert_eq!(budget("20%@4kHz"), Some(Budget { share: 0.2, rate: 4000.0 }));
    assert_eq!(budget("0.25@500Hz"), Some(Budget { share: 0.25, rate: 500.0 }));
    assert_eq!(["20%", "20%@4", "@4kHz", "20%@0Hz", "20%@xHz"].map(budget), [None; 5]);
    let every = |text: &str| text.parse::<Every>().ok();
    assert_eq!(every("4:extrapolate"), Some(Every { ticks: 4, between: Between::Extrapolate }));
    assert_eq!([every("1"), every("1:extrapolate")], [Some(Every::TICK); 2]);
    assert_eq!(["0", "1001", "4:", "4:guess", ""].map(every), [None; 5]);
}
