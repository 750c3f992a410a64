//! Cost of the whole interrupt for a choice, as trade, choose and explain compute it. It is compared with the interrupt of the choice's own firmware,
//! and with the bounds of `cargo xtask budget`.

use robot_compiler::Ends;
use robot_compiler::kernel::Level;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::trade::baseline::Baseline;
use studies::trade::chip::interrupt::{Interrupt, measure};
use studies::trade::chip::{CLOCK, Chip as _, EmulatedChip, InterruptCost};
use studies::trade::choice::{Choice, TermSet};

/// Largest relative difference between the computed sum and the interrupt of the choice's own firmware. Caches and registers cause a difference.
const WITHIN: f64 = 0.02;

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Interrupt cost of a shipped scene. Also the scene of each choice, with the cycles of the interrupt that has this choice's controller.
fn of_scene(name: &str, choices: &[fn(Choice) -> Choice]) -> (InterruptCost, Vec<(PathBuf, f64)>) {
    let (stop, base) =
        (AtomicBool::new(false), Baseline::load(&top().join(format!("scenes/{name}.toml")), Ends::default()).unwrap());
    let write = |place: String, choice: &Choice| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("interrupt_{name}_{place}.toml"));
        std::fs::write(&path, base.with(choice)).unwrap();
        path
    };
    let own = write("own".to_owned(), &base.firmware());
    let surroundings = InterruptCost::measure(&own, None, &EmulatedChip, &stop).unwrap();
    let paths = choices.iter().enumerate().map(|(k, choice)| write(k.to_string(), &choice(base.firmware())));
    let mut paths: Vec<PathBuf> = paths.collect();
    paths.insert(0, own);
    let costs = EmulatedChip.controllers(&paths, &stop).unwrap();
    let cycles = costs.iter().map(|cost| surroundings.around(cost, 4000.0).cycles_max);
    let all = paths.into_iter().zip(cycles).collect();
    (surroundings, all)
}

/// The range of estimated cycles of a scene's interrupt in `firmware/budget.toml`.
fn budget(scene: &str) -> [f64; 2] {
    let text = std::fs::read_to_string(top().join("firmware/budget.toml")).unwrap();
    let row = text
        .split("[[row]]")
        .find(|row| row.contains(&format!("scene = \"{scene}\"\n")) && row.contains("board = \"netduinoplus2\"\n"));
    let range = row.unwrap().lines().find_map(|line| line.strip_prefix("cycles_estimate = [")).unwrap();
    let bounds: Vec<f64> = range.trim_end_matches(']').split(", ").map(|bound| bound.parse().unwrap()).collect();
    [bounds[0], bounds[1]]
}

#[test]
fn the_sum_of_controller_and_surroundings_is_the_interrupt_of_each_choices_own_firmware() {
    let choices: [fn(Choice) -> Choice; 2] =
        [|own| Choice { kernel: Level::Regrouped, ..own }, |own| Choice { terms: TermSet::None, ..own }];
    let (surroundings, all) = of_scene("puma560_pick", &choices);
    let [low, high] = budget("puma560_pick");
    assert!((low..=high).contains(&all[0].1), "{} cycles, the budget has {low} to {high}", all[0].1);
    for (path, sum) in &all[1..] {
        let Interrupt { cycles, .. } = measure(path).unwrap();
        println!("{}: {sum} cycles of {cycles}, around the controller {}", path.display(), surroundings.cycles);
        assert!((sum / cycles - 1.0).abs() < WITHIN, "{}: {sum} of {cycles}", path.display());
    }
}

#[test]
fn the_planar_arm_takes_the_share_of_the_budget_and_most_of_it_around_the_controller() {
    let (surroundings, all) = of_scene("planar2r_swing", &[]);
    let ([low, high], cycles) = (budget("planar2r_swing"), all[0].1);
    assert!((low..=high).contains(&cycles), "{cycles} cycles, the budget has {low} to {high}");
    assert_eq!(format!("{:.1}", 100.0 * cycles * 4000.0 / CLOCK), "3.2");
    assert!(surroundings.cycles > 0.5 * cycles, "{surroundings:?} of {cycles}");
}
