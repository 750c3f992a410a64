//! Every target on its examples, on all earlier findings, and on thousands of damaged examples, which are the same in every run.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::time::{Duration, Instant};
use trials::fuzz::damage::{Damage, nested};
use trials::fuzz::{self, FuzzTarget, found};

/// Longest time to read any input, in a test build on a busy machine.
const LONGEST: Duration = Duration::from_secs(5);

/// Checks one input; if a property does not hold, saves the input.
fn hold(target: &FuzzTarget, number: usize, input: &[u8]) {
    let begin = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| (target.check)(input)));
    let time = begin.elapsed();
    if outcome.is_err() || time > LONGEST {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{number}", target.name));
        let kept = std::fs::write(&path, input);
        eprintln!(
            "input {number} took {time:?}; see it again: cargo run -p trials --bin {} {path:?} ({kept:?})",
            target.name
        );
    }
    outcome.unwrap_or_else(|panic| resume_unwind(panic));
    assert!(time <= LONGEST, "input {number} took {time:?}");
}

fn hold_all(target: &FuzzTarget, damaged: usize) {
    let mut damage = Damage::new(0x6e65_7774_6175, target.words);
    let examples = (target.examples)();
    let found = found(target.name).into_iter().map(|(_, input)| input);
    let inputs = examples.clone().into_iter().chain(found);
    for (number, input) in inputs.chain((0..damaged).map(|_| damage.next_input(&examples))).enumerate() {
        hold(target, number, &input);
    }
}

/// Defines the test of each target, with a number of damaged examples.
macro_rules! tests {
    ($($target:ident: $damaged:literal,)*) => {$(
        #[test]
        fn $target() {
            hold_all(&fuzz::$target::TARGET, $damaged);
        }
    )*};
}

tests! {
    link_channel: 2_000,
    link_decoder: 20_000,
    link_stream: 3_000,
    session: 1_500,
    robot_file: 3_000,
    urdf_file: 2_000,
    scene_file: 2_000,
    json_lines: 4_000,
}

#[test]
fn no_depth_of_nesting_is_too_much_for_a_reader() {
    for target in
        [fuzz::robot_file::TARGET, fuzz::urdf_file::TARGET, fuzz::scene_file::TARGET, fuzz::json_lines::TARGET]
    {
        for depth in [10, 31, 100, 10_000, 200_000] {
            nested(depth).iter().for_each(|input| hold(&target, depth, input));
        }
        let list = [b"{\"q\":".to_vec(), b"[".repeat(200_000)].concat();
        hold(&target, 0, &list);
    }
}

/// The session target must reach every state; otherwise its judge would have nothing to check.
#[test]
fn examples_of_sessions_come_to_every_state() {
    let mut all = [0; 6];
    for example in (fuzz::session::TARGET.examples)() {
        let ticks = fuzz::session::ticks_of_states(&example);
        all = std::array::from_fn(|state| all[state] + ticks[state]);
    }
    assert!(all.iter().all(|ticks| *ticks > 50), "{all:?}");
}

/// Every target has a test here; otherwise it would run only with a nightly compiler.
#[test]
fn every_target_has_its_test() {
    let tests = include_str!("targets.rs");
    for target in fuzz::TARGETS {
        assert!(tests.contains(&format!("    {}: ", target.name)), "{}", target.name);
    }
}
