//! Messages for the numbers of `docs/safety/state-machine.md`, with advice. The texts of faults, refusals and causes of a hold come from the core;
//! the advice after a rejected request names this program's commands.

use super::rejection::Rejection;
use crate::chip::refusal_in_words;
use ::session::readings::JointFaults;
use dynamics_core::control::{Fault, LimitFlags};
use link::{Denial, DriveFaultReport, Refusal, StateCode, Status};

/// Advice after a rejected request, by [`dynamics_core::safety::Refusal::code`], 1 and up.
const ADVICE: [&str; dynamics_core::safety::Refusal::TEXTS.len()] = [
    "`status` prints the state; idle allows home and arm, homing allows confirm; armed and holding allow run, jog, goto, park and disarm; \
     running and lowering allow hold",
    "remove its cause, then `clear`",
    "`home`, compare the position of every joint with the arm, `confirm`",
    "move it until it finds its zero; an encoder that lost its turn needs a restart: of the board, or of `drive`",
    "check the sensor of this joint",
    "wait until it is at rest; `hold` stops it",
    "check the link; repeat the command",
    "`run`, `jog` and `goto` send one",
    "`goto` or `jog` to a position farther from the limit",
    "repeat the command; it starts at the arm's present position",
    "repeat the command",
    "`payload` and `arm` send all of them; repeat the command",
    "check the link; the operator sends live inputs again while it runs",
    "`dump` reads it, then `erase`",
    "move more slowly, or lift the limits with `full-range`",
];

/// Message for a number that this version does not know.
fn unknown(what: &str, code: u8) -> String {
    format!("{what} {code}, which this version does not know")
}

fn of_joint(joint: Option<u8>) -> String {
    joint.map_or(String::new(), |joint| format!(" (joint {})", u32::from(joint) + 1))
}

/// Message of a fault, with the things to inspect.
#[must_use]
pub fn fault(code: u8, joint: Option<u8>) -> String {
    let known = Fault::from_code(code, joint.unwrap_or(0));
    known.map_or_else(|| unknown("fault", code), |fault| format!("{fault}; check {}", fault.check()))
}

/// State of the machine in words, with the reason.
#[must_use]
pub fn doing(status: &Status) -> String {
    match status.state {
        StateCode::Holding => {
            let why =
                status.hold_cause().map_or_else(|| unknown("cause", status.cause), |cause| cause.text().to_owned());
            format!("{}: {why}{}", status.state, of_joint(status.joint))
        }
        StateCode::Fault => fault(status.cause, status.joint),
        other => other.to_string(),
    }
}

/// Advice for a fault that the limits of the first motion explain: a joint that exceeded its share of the velocity limit, or that sank because too
/// little torque is left beyond gravity. Empty for any other state.
#[must_use]
pub fn in_first_motion(status: &Status, share: f64) -> String {
    let percent = 100.0 * share;
    match (status.state, status.cause) {
        (StateCode::Fault, 5) => format!(
            "; in the first motion after homing the bound is {percent:.0} % of the velocity guard, and torque beyond the weight is limited to {percent:.0} %: a \
             hand or a fall of an arm that is heavier than its model exceeds it; support the arm, and declare what it holds"
        ),
        (StateCode::Fault, 15) => format!(
            "; in the first motion after homing torque beyond the weight is limited to {percent:.0} %: an arm that is heavier than its model sinks; support it, \
             and declare what it holds"
        ),
        _ => String::new(),
    }
}

/// Report of a joint's drive or sensor, with the drive's error text.
#[must_use]
pub fn drive_fault(drive_fault: &DriveFaultReport, words: Option<fn(u8) -> &'static str>) -> String {
    let DriveFaultReport { joint, faults, error } = *drive_fault;
    let mut all: Vec<&str> =
        JointFaults::NAMES.iter().filter(|(fault, _)| faults & fault.bits() != 0).map(|(_, name)| *name).collect();
    let said = words.filter(|_| error != 0).map(|words| words(error));
    // The drive's error text is more specific than the flag for an error.
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
    let mut known = dynamics_core::safety::Refusal::TEXTS.iter().zip(ADVICE);
    let entry = usize::from(denial.code).checked_sub(1).and_then(|index| known.nth(index));
    let Some((why, what_to_do)) = entry else { return unknown("refusal", denial.code) };
    match denial.fault {
        0 => format!("rejected: {why}{}; {what_to_do}", of_joint(denial.joint)),
        code => format!("rejected: {why}: {}; {what_to_do}", fault(code, denial.joint)),
    }
}

/// Reason why a request had no effect, with advice.
#[must_use]
pub fn rejection(rejection: &Rejection) -> String {
    match rejection {
        Rejection::Denied(it) => denial(it),
        Rejection::Superseded => "superseded: a stronger request came at the same time; repeat the command".into(),
        Rejection::Unconfirmed(time) => format!(
            "not confirmed: the controller has not answered for {} ms; check the cable, and `status` before you go on",
            time.as_millis()
        ),
    }
}

/// Reason why a frame was refused, with advice.
#[must_use]
pub fn frame(refusal: &Refusal) -> String {
    let what_to_do = match refusal {
        Refusal::Undecodable(_) | Refusal::Lost { .. } => "; check the cable and the baud rate, and repeat the command",
        Refusal::NoHello | Refusal::OtherRobot => "; connect again",
        Refusal::Unauthentic { .. } => {
            "; check the cable; if the board rejects all commands, it has restarted: connect again"
        }
        _ => "",
    };
    format!("the controller rejected a frame: {}{what_to_do}", refusal_in_words(refusal))
}

/// Limits that acted on a joint.
#[must_use]
pub fn limits(bits: u8) -> String {
    let acted = LimitFlags::NAMES.iter().filter(|(flag, _)| bits & flag.bits() != 0);
    acted.map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::{denial, fault};
    use dynamics_core::control::Fault;
    use dynamics_core::safety::Refusal;
    use link::Denial;

    #[test]
    fn words_name_the_joint_counted_from_1_and_say_what_to_do() {
        assert_eq!(fault(11, Some(1)), "fault 11: the drive reports a fault (joint 2); check the drive's error text");
        let not_homed = denial(&Denial::new(Refusal::NotHomed));
        assert!(not_homed.starts_with("rejected: the arm has not been homed; `home`"), "{not_homed}");
        let standing = denial(&Denial::new(Refusal::Fault(Fault::EmergencyStop)));
        assert!(
            standing.contains("fault 9: emergency stop; check the emergency stop; release it, then `clear`"),
            "{standing}"
        );
        assert!(denial(&Denial::new(Refusal::NoRoom { joint: 2 })).contains("limit (joint 3);"));
    }
}
