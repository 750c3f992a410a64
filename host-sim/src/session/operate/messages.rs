//! Messages for the numbers of `docs/safety.md`, with advice. One table for each kind; a test compares them with the
//! core's numbers.

use crate::chip::refusal_in_words;
use ::session::readings::JointFaults;
use dynamics_core::control::{Fault, LimitFlags};
use link::{Denial, Refusal, Status, Trouble};

/// State of the machine, by [`dynamics_core::safety::State::code`].
pub const STATES: [&str; 8] = ["idle", "homing", "armed", "running", "holding", "fault", "arming", "lowering"];

/// Reason for holding, by [`dynamics_core::safety::HoldCause::code`]: 1 and up.
pub const HOLDS: [&str; 6] = [
    "as asked",
    "the host fell silent",
    "the trajectory ran out in motion",
    "no room to stop before a limit",
    "the reference went out of reach",
    "the live inputs are too old",
];

/// Reason why a request is denied, by [`dynamics_core::safety::Refusal::code`], 1 and up, with advice.
pub const REFUSALS: [(&str, &str); 14] = [
    (
        "it means nothing in this state",
        "`status` tells the state; idle: home, confirm, arm; armed: run, jog, goto; running: hold",
    ),
    ("a fault stands in the way", "see to what raised it, then `clear`"),
    ("the arm has not been homed", "`home`, see that every joint is where its zero says, `confirm`"),
    ("a joint does not know its zero", "let it find it; an encoder that lost its turn needs a new start of the board"),
    ("the measurement or the reference is not believed", "see to the sensor of this joint"),
    ("the arm moves", "wait until it rests; `hold` stops it"),
    ("the host was silent", "see to the link; ask again"),
    ("there is no reference to follow", "`run`, `jog` and `goto` send one"),
    ("a joint could not stop before its limit", "`goto` or `jog` to where there is room"),
    ("the trajectory does not start where the arm is", "ask again; it starts where the arm is then"),
    ("a change of a parameter or a live input waits for the same tick", "ask again"),
    ("a live input of the scene has not come yet", "send gravity, payload, tip wrench or rotors first"),
    ("a live input is too old", "send it again, and more often than the scene's limit"),
    ("the black box holds a fault that has not been read", "`dump` reads it"),
];

/// Things to inspect after a fault, by [`Fault::code`], 1 and up.
pub const LOOK_AT: [&str; 20] = [
    "the sensor, its cable",
    "whoever makes the reference",
    "the sensor's rate, the link",
    "the reference, the zero of this joint; by hand back inside, then clear",
    "gains, payload, the encoder's scale",
    "the rate, other interrupts of the board",
    "the numbers of the model, the size of the reference",
    "the encoder, its cable; the arm must be homed again",
    "whoever pressed it",
    "the host, the link",
    "the drive's own diagnosis",
    "the supply, a brake resistor",
    "cooling, the load",
    "what is around the arm; payload, friction and thresholds of the scene",
    "whoever pushes it; payload, wrench and rotors as told; the model of the arm",
    "payload, wrench and gravity as told; the posture; `clear`, tell it right, and arm again",
    "the drive's power, its bus, its own error; then `clear` and arm again",
    "the drive's power and its protections against current, voltage and heat",
    "the drives' power; home the arm again",
    "the load, the posture; let the joint cool down",
];

/// Entry of a table by number, counted from `first`.
fn entry<T: Copy>(table: &[T], code: u8, first: u8) -> Option<T> {
    table.get(usize::from(code.checked_sub(first)?)).copied()
}

/// Message for a number that this version does not know.
fn unknown(what: &str, code: u8) -> String {
    format!("{what} {code}, which this version does not know")
}

fn of_joint(joint: Option<u8>) -> String {
    joint.map_or(String::new(), |joint| format!(" (joint {})", u32::from(joint) + 1))
}

/// Name of a state.
#[must_use]
pub fn state(code: u8) -> String {
    entry(&STATES, code, 0).map_or_else(|| unknown("state", code), str::to_owned)
}

/// Message of a fault, with the things to inspect.
#[must_use]
pub fn fault(code: u8, joint: Option<u8>) -> String {
    match (Fault::from_code(code, joint.unwrap_or(0)), entry(&LOOK_AT, code, 1)) {
        (Some(fault), Some(look)) => format!("{fault}; look at: {look}"),
        _ => unknown("fault", code),
    }
}

/// State of the machine, with the reason.
#[must_use]
pub fn doing(status: &Status) -> String {
    match status.state {
        4 => {
            let cause = entry(&HOLDS, status.cause, 1);
            let why = cause.map_or_else(|| unknown("cause", status.cause), str::to_owned);
            format!("holding: {why}{}", of_joint(status.joint))
        }
        5 => fault(status.cause, status.joint),
        code => state(code),
    }
}

/// What a joint's drive or sensor reports, with the drive's own words for its error.
#[must_use]
pub fn trouble(trouble: &Trouble, words: Option<fn(u8) -> &'static str>) -> String {
    let Trouble { joint, faults, error } = *trouble;
    let mut all: Vec<&str> =
        JointFaults::NAMES.iter().filter(|(fault, _)| faults & fault.bits() != 0).map(|(_, name)| *name).collect();
    let said = words.filter(|_| error != 0).map(|words| words(error));
    // Its own words say more than that it has an error.
    if said.is_some() {
        all.retain(|name| {
            !JointFaults::NAMES.iter().any(|(fault, other)| *fault == JointFaults::DRIVE && other == name)
        });
    }
    all.extend(said);
    let code = if error == 0 { String::new() } else { format!(" (error {error:#x})") };
    format!("joint {} says: {}{code}", u32::from(joint) + 1, all.join(", "))
}

/// Reason why a request was denied, with advice.
#[must_use]
pub fn denial(denial: &Denial) -> String {
    let Some((why, what_to_do)) = entry(&REFUSALS, denial.code, 1) else { return unknown("refusal", denial.code) };
    match denial.fault {
        0 => format!("refused: {why}{}; {what_to_do}", of_joint(denial.joint)),
        code => format!("refused: {why}: {}; {what_to_do}", fault(code, denial.joint)),
    }
}

/// Reason why a frame was refused, with advice.
#[must_use]
pub fn frame(refusal: &Refusal) -> String {
    let what_to_do = match refusal {
        Refusal::Undecodable(_) | Refusal::Lost { .. } => "; see to the cable and the baud rate, and ask again",
        Refusal::NoHello | Refusal::OtherRobot => "; connect again",
        Refusal::Unauthentic { .. } => {
            "; see to the wire; if all commands stop, the board has started anew: connect again"
        }
        _ => "",
    };
    format!("the board did not take a frame: {}{what_to_do}", refusal_in_words(refusal))
}

/// Limits that acted on a joint.
#[must_use]
pub fn limits(bits: u8) -> String {
    let acted = LimitFlags::NAMES.iter().filter(|(flag, _)| bits & flag.bits() != 0);
    acted.map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::{HOLDS, LOOK_AT, REFUSALS, STATES, denial, fault, state};
    use dynamics_core::control::Fault;
    use dynamics_core::safety::{HoldCause, Refusal, State};
    use link::Denial;

    #[test]
    fn every_number_of_the_core_has_its_words() {
        let faults = (1..).map_while(|code| Fault::from_code(code, 0)).count();
        assert_eq!(faults, LOOK_AT.len());
        assert_eq!(usize::from(State::Lowering.code()), STATES.len() - 1);
        assert_eq!(usize::from(HoldCause::OutOfReach { joint: 0 }.code()), HOLDS.len());
        assert_eq!(usize::from(Refusal::OutOfReach { joint: 0 }.code()), REFUSALS.len());
    }

    #[test]
    fn words_name_the_joint_counted_from_1_and_say_what_to_do() {
        assert_eq!(
            fault(11, Some(1)),
            "fault 11: the drive reports a fault (joint 2); look at: the drive's own diagnosis"
        );
        let not_homed = denial(&Denial::new(Refusal::NotHomed));
        assert!(not_homed.starts_with("refused: the arm has not been homed; `home`"), "{not_homed}");
        let standing = denial(&Denial::new(Refusal::Fault(Fault::EmergencyStop)));
        assert!(standing.contains("fault 9: emergency stop; look at: whoever pressed it"), "{standing}");
        assert!(denial(&Denial::new(Refusal::NoRoom { joint: 2 })).contains("limit (joint 3);"));
        assert_eq!(state(77), "state 77, which this version does not know");
    }
}
