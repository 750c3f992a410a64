//! Longer explorations, with two and three events: `cargo run --release -p joint-io --example search -- [NAME] [SECONDS] [PERIODS]`.
//!
//! Each search ends after SECONDS (600 by default). It is depth first, so that the pending states fit into memory. With PERIODS, all events of a
//! path happen within this many control periods after its first one, and the first may happen at any moment of the session. Exit code 1 if a rule
//! is broken.

#[path = "../tests/explore/checker/mod.rs"]
mod checker;

use actuator_model::mit::Language::{self, Damiao, MiniCheetah, MyActuator, RobStride};
use checker::explorer::{Bounds, explore};
use checker::scene::{Kinds, Setup};
use dynamics_core::drive;
use dynamics_core::safety::SafeAction::{self, Brake, DampedStop};
use std::process::ExitCode;

const LINK: Kinds = Kinds { requests: true, host: true, ..Kinds::NONE };
const BUS: Kinds = Kinds { frames: true, drives: true, ..Kinds::NONE };

/// Name, number of joints, protocol, safe action, largest number of events, kinds of events.
const SEARCHES: [(&str, usize, Language, SafeAction, u8, Kinds); 17] = [
    ("two_mini_cheetah_brake", 1, MiniCheetah, Brake, 2, Kinds::ALL),
    ("two_mini_cheetah_damped_stop", 1, MiniCheetah, DampedStop, 2, Kinds::ALL),
    ("two_damiao_brake", 1, Damiao, Brake, 2, Kinds::ALL),
    ("two_damiao_damped_stop", 1, Damiao, DampedStop, 2, Kinds::ALL),
    ("two_robstride_brake", 1, RobStride, Brake, 2, Kinds::ALL),
    ("two_robstride_damped_stop", 1, RobStride, DampedStop, 2, Kinds::ALL),
    ("two_myactuator_brake", 1, MyActuator, Brake, 2, Kinds::ALL),
    ("two_myactuator_damped_stop", 1, MyActuator, DampedStop, 2, Kinds::ALL),
    ("two_on_two_joints_mini_cheetah_brake", 2, MiniCheetah, Brake, 2, Kinds::ALL),
    ("two_on_two_joints_damiao_damped_stop", 2, Damiao, DampedStop, 2, Kinds::ALL),
    ("three_of_the_link_damiao_brake", 1, Damiao, Brake, 3, LINK),
    ("three_of_the_link_damiao_damped_stop", 1, Damiao, DampedStop, 3, LINK),
    ("three_of_the_bus_mini_cheetah_brake", 1, MiniCheetah, Brake, 3, BUS),
    ("three_of_the_bus_damiao_brake", 1, Damiao, Brake, 3, BUS),
    ("three_damiao_brake", 1, Damiao, Brake, 3, Kinds::ALL),
    ("three_mini_cheetah_brake", 1, MiniCheetah, Brake, 3, Kinds::ALL),
    ("three_damiao_damped_stop", 1, Damiao, DampedStop, 3, Kinds::ALL),
];

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let numbers: Result<Vec<u64>, _> = arguments.map(|number| number.parse()).collect();
    let (seconds, within) = match numbers.as_deref() {
        Ok([]) => (600, None),
        Ok([seconds]) => (*seconds, None),
        Ok([seconds, within]) => (*seconds, u8::try_from(*within).ok()),
        _ => {
            eprintln!("error: expected a name, a time in s and a number of periods, such as `three_damiao 600 1`");
            return ExitCode::from(2);
        }
    };
    let mut code = ExitCode::SUCCESS;
    for (_, joints, language, action, budget, events) in SEARCHES.into_iter().filter(|search| search.0.contains(&name))
    {
        let absolute = !matches!(language, MiniCheetah | MyActuator);
        let setup = Setup { language, action, absolute, rest: action != Brake, budget, within, events, mutant: None };
        let bounds = Bounds { seconds, threads: 1, depth_first: true };
        let explored = match (language, joints) {
            (MiniCheetah, 1) => explore::<drive::MiniCheetah, 1>(setup, bounds),
            (MiniCheetah, _) => explore::<drive::MiniCheetah, 2>(setup, bounds),
            (Damiao, 1) => explore::<drive::Damiao, 1>(setup, bounds),
            (Damiao, _) => explore::<drive::Damiao, 2>(setup, bounds),
            (RobStride, _) => explore::<drive::RobStride, 1>(setup, bounds),
            (MyActuator, _) => explore::<drive::MyActuator, 1>(setup, bounds),
        };
        println!("{joints} joints, {language:?}, {action:?}, {budget} events of {events:?}: {explored}");
        if !explored.broken.is_empty() {
            code = ExitCode::FAILURE;
        }
    }
    code
}
