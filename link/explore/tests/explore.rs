//! The quick part of the exploration.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use actuator_model::mit::Language;
use dynamics_core::drive::{Damiao, MiniCheetah, RobStride};
use dynamics_core::safety::SafeAction;
use explore::explorer::{Bounds, Explored, Explorer, explore};
use explore::scene::Setup;
use explore::state::Kinds;

fn setup(language: Language, action: SafeAction) -> Setup {
    Setup { language, action, absolute: language != Language::MiniCheetah, rest: action != SafeAction::Brake, budget: 1, events: Kinds::ALL }
}

#[test]
fn the_undisturbed_session_arms_moves_and_disarms() {
    for action in [SafeAction::Brake, SafeAction::DampedStop] {
        let explorer = Explorer::<Damiao, 1>::new(setup(Language::Damiao, action));
        for (i, state) in explorer.nominal().iter().enumerate() {
            println!("{i:2} {}", Explorer::line(state));
        }
    }
}

fn show(name: &str, explored: &Explored) {
    let Explored { states, steps, depth, seconds, complete, broken } = explored;
    println!("{name}: {states} states, {steps} steps, depth {depth}, {seconds:.1} s, complete {complete}, {:.0} steps/s", *steps as f64 / seconds);
    for (rule, trace) in broken {
        println!("BROKEN {rule}\n{trace}");
    }
}

#[test]
fn one() {
    let budget = std::env::var("BUDGET").map_or(1, |b| b.parse().unwrap());
    let depth = std::env::var("DEPTH").map_or(0, |b| b.parse().unwrap());
    let bounds = Bounds { depth, seconds: 60, threads: 1 };
    for action in [SafeAction::Brake, SafeAction::DampedStop] {
        let of = |language| Setup { budget, ..setup(language, action) };
        show(&format!("mini-cheetah {action:?}"), &explore::<MiniCheetah, 1>(of(Language::MiniCheetah), bounds));
        show(&format!("Damiao {action:?}"), &explore::<Damiao, 1>(of(Language::Damiao), bounds));
        show(&format!("RobStride {action:?}"), &explore::<RobStride, 1>(of(Language::RobStride), bounds));
    }
}
