//! The quick part of the exploration ([`checker`]): complete searches with one event. `examples/search.rs` has longer ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod checker;

use actuator_model::mit::Language;
use checker::explorer::{Bounds, Explored, Explorer, explore};
use checker::faulty::Mutant;
use checker::judge::Rule;
use checker::scene::{Kinds, Setup};
use dynamics_core::drive::{Damiao, MiniCheetah, MyActuator, RobStride};
use dynamics_core::safety::{SafeAction, State};

fn setup(language: Language, action: SafeAction) -> Setup {
    let absolute = !matches!(language, Language::MiniCheetah | Language::MyActuator);
    Setup {
        language,
        action,
        absolute,
        rest: action != SafeAction::Brake,
        budget: 1,
        within: None,
        events: Kinds::ALL,
        mutant: None,
    }
}

fn run<const N: usize>(setup: Setup) -> Explored {
    let bounds = Bounds { seconds: 120, threads: 1, depth_first: false };
    let explored = match setup.language {
        Language::MiniCheetah => explore::<MiniCheetah, N>(setup, bounds),
        Language::Damiao => explore::<Damiao, N>(setup, bounds),
        Language::RobStride => explore::<RobStride, N>(setup, bounds),
        Language::MyActuator => explore::<MyActuator, N>(setup, bounds),
    };
    println!("{N} joints, {setup:?}: {explored}");
    explored
}

/// Checks that the search is complete and no rule is broken.
fn holds<const N: usize>(setup: Setup) {
    let explored = run::<N>(setup);
    assert!(explored.broken.is_empty(), "{explored}");
    assert!(explored.complete, "{explored}");
}

#[test]
fn the_undisturbed_session_goes_round_and_breaks_no_rule() {
    for action in [SafeAction::Brake, SafeAction::DampedStop] {
        let explorer = Explorer::<Damiao, 1>::new(setup(Language::Damiao, action));
        let states = explorer.nominal();
        for (i, state) in states.iter().enumerate() {
            println!("{i:2} {}", Explorer::line(state));
        }
        assert!(states.iter().all(|state| state.judge.all_hold()));
        for wanted in [State::Idle, State::Homing, State::Arming, State::Armed, State::Running] {
            assert!(states.iter().any(|state| state.machine() == wanted), "{wanted:?}");
        }
        let disarms = states.iter().any(|state| state.machine() == State::Disarming);
        assert_eq!(disarms, action == SafeAction::Brake);
        let (mut known, mut now) = (states.clone(), states.last().unwrap().clone());
        let again = (0..100).any(|_| {
            now = explorer.step(&now, checker::event::Step::Tick);
            let was_there = known.contains(&now);
            known.push(now.clone());
            was_there
        });
        assert!(again, "it never comes back to a state that was there");
    }
}

macro_rules! one_event {
    ($($name:ident: $language:ident, $action:ident, $joints:literal;)*) => {
        $(#[test]
        fn $name() {
            holds::<$joints>(setup(Language::$language, SafeAction::$action));
        })*
    };
}

one_event! {
    one_event_mini_cheetah_brake: MiniCheetah, Brake, 1;
    one_event_mini_cheetah_damped_stop: MiniCheetah, DampedStop, 1;
    one_event_damiao_brake: Damiao, Brake, 1;
    one_event_damiao_damped_stop: Damiao, DampedStop, 1;
    one_event_robstride_brake: RobStride, Brake, 1;
    one_event_robstride_damped_stop: RobStride, DampedStop, 1;
    one_event_myactuator_brake: MyActuator, Brake, 1;
    one_event_myactuator_damped_stop: MyActuator, DampedStop, 1;
    one_event_two_joints_mini_cheetah_brake: MiniCheetah, Brake, 2;
    one_event_two_joints_damiao_damped_stop: Damiao, DampedStop, 2;
}

/// Two events of the link in one period: a new host and a request, or two requests.
#[test]
fn two_events_of_the_link_in_a_period() {
    let events = Kinds { frames: false, drives: false, requests: true, host: true };
    for action in [SafeAction::Brake, SafeAction::DampedStop] {
        holds::<1>(Setup { budget: 2, within: Some(0), events, ..setup(Language::Damiao, action) });
    }
}

/// Checks that the search finds the deliberate fault, and prints a shortest counterexample.
fn finds(rule: Rule, mutant: Mutant, setup: Setup) {
    let explored = run::<1>(Setup { mutant: Some(mutant), ..setup });
    let found = explored.broken.iter().find(|(name, _)| *name == rule.name());
    let (_, trace) = found.unwrap_or_else(|| panic!("{mutant:?} does not break \"{}\": {explored}", rule.name()));
    println!("{mutant:?}:\n{trace}");
}

#[test]
fn a_drive_that_counts_as_on_when_it_was_told_to_be_is_found() {
    let it = setup(Language::Damiao, SafeAction::Brake);
    finds(Rule::BrakesOpenOnlyWhenAllDrivesAreOn, Mutant::BlindToDrives, it);
    finds(Rule::BrakesCloseWhenADriveIsOff, Mutant::BlindToDrives, it);
    finds(Rule::NoJointFallsWhileArmed, Mutant::BlindToDrives, setup(Language::Damiao, SafeAction::DampedStop));
}

#[test]
fn a_zero_that_is_lost_in_the_dark_is_found() {
    finds(Rule::HomingEndsWithTheZero, Mutant::ZeroNeverLost, setup(Language::MiniCheetah, SafeAction::Brake));
}

#[test]
fn brakes_that_open_before_the_torque_acts_are_found() {
    finds(Rule::TorqueCarriesTheArmWhenBrakesOpen, Mutant::NoPreload, setup(Language::Damiao, SafeAction::Brake));
}

#[test]
fn a_hold_that_a_later_request_overwrites_is_found() {
    let setup = setup(Language::Damiao, SafeAction::Brake);
    finds(Rule::StopWinsWithinOnePeriod, Mutant::LastRequestWins, setup);
    finds(Rule::TheStrongestRequestWins, Mutant::LastRequestWins, setup);
}

#[test]
fn an_old_trajectory_is_found() {
    let events = Kinds { requests: true, ..Kinds::NONE };
    let setup = Setup { events, ..setup(Language::Damiao, SafeAction::Brake) };
    finds(Rule::NoOldTrajectoryRuns, Mutant::OldTrajectory, setup);
}

#[test]
fn answers_that_are_not_sent_or_sent_twice_are_found() {
    let setup = setup(Language::Damiao, SafeAction::Brake);
    finds(Rule::EveryRequestIsAnsweredOnce, Mutant::NoAnswer, setup);
    finds(Rule::EveryRequestIsAnsweredOnce, Mutant::TwoAnswers, setup);
}

#[test]
fn an_arm_that_is_let_go_without_a_host_is_found() {
    finds(Rule::NobodyFallsWithoutAHost, Mutant::NoRestPose, setup(Language::Damiao, SafeAction::DampedStop));
}
