//! The quick part of the exploration.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use actuator_model::mit::Language;
use dynamics_core::drive::{Damiao, MiniCheetah, RobStride};
use dynamics_core::safety::SafeAction;
use explore::explorer::{Bounds, Explored, Explorer, explore};
use explore::scene::Setup;
use explore::state::Kinds;

fn setup(language: Language, action: SafeAction) -> Setup {
    Setup { language, action, absolute: language != Language::MiniCheetah, budget: 1, events: Kinds::ALL }
}

#[test]
fn the_undisturbed_session_arms_moves_and_disarms() {
    for (language, action) in [(Language::Damiao, SafeAction::Brake), (Language::MiniCheetah, SafeAction::DampedStop)] {
        println!("size of a state: {}", std::mem::size_of::<explore::state::State<Damiao, 1>>());
        let explorer = Explorer::<Damiao, 1>::new(setup(language, action));
        let text = explorer.nominal()[3].text();
        println!("{}: {text}", text.len());
        let some = explorer.nominal()[3].clone();
        let begun = std::time::Instant::now();
        for _ in 0..10_000 { std::hint::black_box(some.clone()); }
        let clone = begun.elapsed().as_secs_f64() * 100.0;
        let begun = std::time::Instant::now();
        for _ in 0..10_000 { std::hint::black_box(explore::digest::of(&[&some.session])); }
        let session = begun.elapsed().as_secs_f64() * 100.0;
        let begun = std::time::Instant::now();
        for _ in 0..10_000 { std::hint::black_box(explore::digest::of(&[&some.joints])); }
        let joints = begun.elapsed().as_secs_f64() * 100.0;
        let begun = std::time::Instant::now();
        for _ in 0..10_000 { std::hint::black_box(explore::digest::of(&[&some.world])); }
        let world = begun.elapsed().as_secs_f64() * 100.0;
        let begun = std::time::Instant::now();
        for _ in 0..10_000 { std::hint::black_box(explorer.step(&some, explore::state::Step::Tick)); }
        let all = begun.elapsed().as_secs_f64() * 100.0;
        println!("clone {clone:.1} us, digest {session:.1} {joints:.1} {world:.1}, next {all:.1}");
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
