//! The states of the firmware's safety state machine, as a [`Status`] numbers them, and the ways between them that
//! `docs/safety.md` draws. Written from that page, not from the machine: who judges the machine uses it.

use link::{Request, Status};

/// No torque, nothing asked for.
pub const IDLE: u8 = 0;
/// The joints look for their zeros.
pub const HOMING: u8 = 1;
/// Torque holds the arm where it is.
pub const ARMED: u8 = 2;
/// The arm follows its trajectory.
pub const RUNNING: u8 = 3;
/// Torque brings the arm to rest and holds it there.
pub const HOLDING: u8 = 4;
/// The safe action, until it is cleared.
pub const FAULT: u8 = 5;

/// Whether one tick may lead from a state with its cause to what a status says, where this was asked for.
#[must_use]
pub fn may_lead((before, cause): (u8, u8), status: &Status, asked: impl Fn(Request) -> bool) -> bool {
    match (before, status.state) {
        (FAULT, FAULT) => cause == status.cause,
        (FAULT, IDLE) => asked(Request::Clear),
        (FAULT, _) => false,
        (before, now) if before == now => true,
        (_, FAULT) => true,
        (IDLE, HOMING) => asked(Request::Home),
        (HOMING, IDLE) => asked(Request::Confirm) || asked(Request::Disarm),
        (IDLE, ARMED) => asked(Request::Arm),
        (ARMED | HOLDING, RUNNING) => asked(Request::Run),
        (ARMED | HOLDING, IDLE) => asked(Request::Disarm),
        // On its own it stops for every cause but the first, which is to have been asked.
        (RUNNING, HOLDING) => status.cause != 1 || asked(Request::Hold),
        // The host fell silent.
        (ARMED, HOLDING) => status.cause == 2,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::{ARMED, FAULT, HOLDING, HOMING, IDLE, RUNNING};
    use dynamics_core::control::Fault;
    use dynamics_core::safety::{HoldCause, State};

    #[test]
    fn the_numbers_are_the_machines() {
        let states = [
            State::Idle,
            State::Homing,
            State::Armed,
            State::Running,
            State::Holding(HoldCause::Requested),
            State::Fault(Fault::Overrun),
        ];
        assert_eq!(states.map(State::code), [IDLE, HOMING, ARMED, RUNNING, HOLDING, FAULT]);
        assert_eq!((HoldCause::Requested.code(), HoldCause::HeartbeatLost.code()), (1, 2));
    }
}
