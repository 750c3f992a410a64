//! The long part of the exploration: two and three events. `cargo nextest run -p explore --run-ignored only --no-capture`.
//!
//! `EXPLORE_SECONDS` is the time for each search (600 if not given). A search that is cut off has looked at all states up to about its depth.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use actuator_model::mit::Language;
use dynamics_core::drive::{Damiao, MiniCheetah, RobStride};
use dynamics_core::safety::SafeAction;
use explore::explorer::{Bounds, explore};
use explore::scene::Setup;
use explore::state::Kinds;

fn holds<const N: usize>(language: Language, action: SafeAction, budget: u8, events: Kinds) {
    let seconds = std::env::var("EXPLORE_SECONDS").map_or(600, |seconds| seconds.parse().unwrap());
    let absolute = language != Language::MiniCheetah;
    let setup = Setup { language, action, absolute, rest: action != SafeAction::Brake, budget, events, mutant: None };
    let bounds = Bounds { depth: 0, seconds, threads: 1 };
    let explored = match language {
        Language::MiniCheetah => explore::<MiniCheetah, N>(setup, bounds),
        Language::Damiao => explore::<Damiao, N>(setup, bounds),
        Language::RobStride => explore::<RobStride, N>(setup, bounds),
    };
    println!("RESULT {N} joints, {language:?}, {action:?}, {budget} events of {events:?}: {explored}");
    assert!(explored.broken.is_empty(), "{explored}");
}

const LINK: Kinds = Kinds { requests: true, host: true, ..Kinds::NONE };
const BUS: Kinds = Kinds { frames: true, drives: true, ..Kinds::NONE };

macro_rules! long {
    ($($name:ident: $joints:literal, $language:ident, $action:ident, $budget:literal, $kinds:expr;)*) => {
        $(#[test]
        #[ignore = "minutes"]
        fn $name() {
            holds::<$joints>(Language::$language, SafeAction::$action, $budget, $kinds);
        })*
    };
}

long! {
    two_events_mini_cheetah_brake: 1, MiniCheetah, Brake, 2, Kinds::ALL;
    two_events_mini_cheetah_damped_stop: 1, MiniCheetah, DampedStop, 2, Kinds::ALL;
    two_events_damiao_brake: 1, Damiao, Brake, 2, Kinds::ALL;
    two_events_damiao_damped_stop: 1, Damiao, DampedStop, 2, Kinds::ALL;
    two_events_robstride_brake: 1, RobStride, Brake, 2, Kinds::ALL;
    two_events_robstride_damped_stop: 1, RobStride, DampedStop, 2, Kinds::ALL;
    two_events_two_joints_mini_cheetah_brake: 2, MiniCheetah, Brake, 2, Kinds::ALL;
    two_events_two_joints_damiao_damped_stop: 2, Damiao, DampedStop, 2, Kinds::ALL;
    three_events_of_the_link_damiao_brake: 1, Damiao, Brake, 3, LINK;
    three_events_of_the_link_damiao_damped_stop: 1, Damiao, DampedStop, 3, LINK;
    three_events_of_the_bus_mini_cheetah_brake: 1, MiniCheetah, Brake, 3, BUS;
    three_events_of_the_bus_damiao_brake: 1, Damiao, Brake, 3, BUS;
    three_events_damiao_brake: 1, Damiao, Brake, 3, Kinds::ALL;
}
