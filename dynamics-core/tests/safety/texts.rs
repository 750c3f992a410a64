//! Texts of states, causes of a hold, and refusals.

use dynamics_core::Fault;
use dynamics_core::safety::{HoldCause, LiveInput, Refusal, State};

#[test]
fn states_and_causes_are_printed_in_plain_words() {
    assert_eq!(State::Disarming.to_string(), "disarming");
    let held = State::Holding(HoldCause::OutOfReach { joint: 1 });
    assert_eq!(held.to_string(), "holding: the reference is out of reach (joint 2)");
    assert_eq!(State::Holding(HoldCause::Requested).to_string(), "holding: as requested");
    assert_eq!(State::Fault(Fault::EmergencyStop).to_string(), "fault 9: emergency stop");
    for (cause, code) in HoldCause::ALL.into_iter().zip(1..) {
        assert_eq!((cause.code(), HoldCause::from_code(code, 0)), (code, Some(cause)));
    }
    assert_eq!(HoldCause::from_code(HoldCause::ALL.len() as u8 + 1, 0), None);
}

#[test]
fn refusals_name_what_they_concern() {
    assert_eq!(Refusal::NotHomed.to_string(), "the arm has not been homed");
    assert_eq!(Refusal::NoRoom { joint: 2 }.to_string(), "a joint could not stop before its limit (joint 3)");
    assert_eq!(
        Refusal::Implausible(Fault::NonFiniteMeasurement { joint: 0 }).to_string(),
        "the measurement or the reference is implausible: fault 1: measurement is not a finite number (joint 1)"
    );
    assert_eq!(
        Refusal::MissingInput(LiveInput::TipWrench).to_string(),
        "a live input of the scene has not been sent yet: tip wrench"
    );
    // The last one has the last text.
    assert_eq!(usize::from(Refusal::FirstMotion { joint: 0 }.code()), Refusal::TEXTS.len());
}
