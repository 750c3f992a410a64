//! The states of the firmware's safety state machine, as a [`Status`] numbers them, and the transitions of
//! `docs/safety.md`. Written from that page, not from the machine, because the tests of the machine use it.

use link::{Request, Status};

/// No torque, no request.
pub const IDLE: u8 = 0;
/// The joints search for their zeros.
pub const HOMING: u8 = 1;
/// Torque holds the arm in its place.
pub const ARMED: u8 = 2;
/// The arm follows its trajectory.
pub const RUNNING: u8 = 3;
/// Torque brings the arm to rest and holds it there.
pub const HOLDING: u8 = 4;
/// The safe action acts until the fault is cleared.
pub const FAULT: u8 = 5;
/// The drives come on and take up the arm's weight, with engaged brakes.
pub const ARMING: u8 = 6;
/// Without a host the arm moves to its rest pose.
pub const LOWERING: u8 = 7;
/// Torque holds the arm until its brakes have engaged.
pub const DISARMING: u8 = 8;

/// True if one tick may lead from a state and its cause to the state of a status; `asked` tells whether a request was
/// made.
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
        // An arm without brakes whose drives are on already is armed at once.
        (IDLE, ARMING | ARMED) => asked(Request::Arm),
        // Disarmed or held by a request, or the host fell silent.
        (ARMING, ARMED | IDLE) => true,
        (ARMED | RUNNING | HOLDING, LOWERING) => true,
        (LOWERING, HOLDING) => asked(Request::Hold),
        (ARMED | HOLDING, RUNNING) => asked(Request::Run),
        // Without brakes, or with such that engage at once.
        (ARMED | HOLDING, IDLE) => asked(Request::Disarm),
        // Disarmed, or the host fell silent.
        (ARMED | RUNNING | HOLDING | LOWERING, DISARMING) => true,
        (DISARMING, IDLE) => true,
        // The machine stops by itself for every cause but the first, which needs a request.
        (RUNNING, HOLDING) => status.cause != 1 || asked(Request::Hold),
        // The host fell silent.
        (ARMED, HOLDING) => status.cause == 2,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::{ARMED, ARMING, DISARMING, FAULT, HOLDING, HOMING, IDLE, LOWERING, RUNNING};
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
            State::Arming,
            State::Lowering,
            State::Disarming,
        ];
        let numbers = [IDLE, HOMING, ARMED, RUNNING, HOLDING, FAULT, ARMING, LOWERING, DISARMING];
        assert_eq!(states.map(State::code), numbers);
        assert_eq!((HoldCause::Requested.code(), HoldCause::HeartbeatLost.code()), (1, 2));
    }
}
