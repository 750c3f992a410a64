//! Allowed transitions of the firmware's safety state machine, written from `docs/safety/state-machine.md`. They are independent of the machine's
//! source, because its tests use them.

use link::StateCode::{self, Armed, Arming, Disarming, Fault, Holding, Homing, Idle, Lowering, Running};
use link::{Request, Status};

/// True if one tick may lead from a state and its cause to the state of a status. `asked` returns true for a request that was made.
#[must_use]
pub fn may_lead((before, cause): (StateCode, u8), status: &Status, asked: impl Fn(Request) -> bool) -> bool {
    match (before, status.state) {
        (Fault, Fault) => cause == status.cause,
        (Fault, Idle) => asked(Request::Clear),
        (Fault, _) => false,
        (before, now) if before == now => true,
        (_, Fault) => true,
        (Idle, Homing) => asked(Request::Home),
        (Homing, Idle) => asked(Request::Confirm) || asked(Request::Disarm),
        // An arm without brakes whose drives are already on is armed at once.
        (Idle, Arming | Armed) => asked(Request::Arm),
        // Disarmed or held by a request, or the host fell silent.
        (Arming, Armed | Idle) => true,
        (Armed | Running | Holding, Lowering) => true,
        (Lowering, Holding) => asked(Request::Hold),
        (Armed | Holding, Running) => asked(Request::Run),
        // Without brakes, or with brakes that engage at once.
        (Armed | Holding, Idle) => asked(Request::Disarm),
        // Disarmed, or the host fell silent.
        (Armed | Running | Holding | Lowering, Disarming) => true,
        (Disarming, Idle) => true,
        // The machine stops without a request for every cause but the first.
        (Running, Holding) => status.cause != 1 || asked(Request::Hold),
        // The host fell silent.
        (Armed, Holding) => status.cause == 2,
        _ => false,
    }
}
