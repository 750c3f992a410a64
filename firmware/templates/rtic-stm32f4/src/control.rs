//! The control loop: one tick from the encoders to the drives. The same file in every template.

use crate::robot::{ArmController, ArmSafety, N, arm, controller, safety};
use dynamics_core::safety::{Actuation, Inputs, Refusal, Request, SafeAction, State};

/// State of the brakes while torque acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brakes {
    /// The drives take up the weight, or the brakes are just closing.
    Engaged,
    /// The drives alone carry the arm.
    Released,
}

/// Your hardware. The loop calls the two `read` functions once in every tick, then one of the others.
///
/// A tick that becomes late after its output calls two of them: `write_torques` or `enable_drives`, then `make_safe`.
///
/// None of them may wait, and none may panic. On an error leave the input as it is: it then says that nothing was read.
pub trait Hardware {
    /// Reads the joints: `sensed`, `age_ticks`, `zeroed`, `zero_lost`, `drive_fault`, `on`, `supply`, `temperature`.
    ///
    /// Set `supply` or `temperature` to `None` if the board does not measure it. An input that is not set raises a fault.
    fn read_encoders(&mut self, inputs: &mut Inputs<f32, N>);
    /// Reads the operator and the motion: `emergency_stop`, `heartbeat_age`, `request`, `reference`.
    ///
    /// Report a request once, in the tick in which the operator makes it: when a button goes down, or when a new message arrives. Do not derive it from
    /// `state`, and do not report it again from a stored message: a repeated `Run` restarts an arm that was stopped. [`Control::tick`] ignores a request
    /// that stays the same from tick to tick, but it cannot tell a repeated message from a new one.
    ///
    /// Set `reference` to `None` if none has arrived for this tick. If the last one is reported again, the arm follows a motion that nobody controls.
    fn read_operator(&mut self, inputs: &mut Inputs<f32, N>, state: State);
    /// Switches the drives on, without torque, and engages the brakes. A drive that is on already does the safe action.
    fn enable_drives(&mut self, action: SafeAction);
    /// Sends the torques, N m (N for a prismatic joint), then releases or engages the brakes.
    fn write_torques(&mut self, torque: &[f32; N], brakes: Brakes);
    /// Ends the torque. [`SafeAction::Brake`]: drives off, brakes engaged.
    ///
    /// It must replace whatever is still queued for the drives: in a late tick it follows another output.
    fn make_safe(&mut self, action: SafeAction);
}

/// Action that ends the torque: `safe_action` of the scene.
pub const SAFE_ACTION: SafeAction = arm::rules().safe_action;

/// The controller, and the safety state machine around it.
pub struct Control {
    controller: ArmController,
    safety: ArmSafety,
    /// True if the last tick ended too late.
    late: bool,
    /// Request of the last tick, or of the last tick before the host fell silent.
    requested: Option<Request>,
    /// The last request that the state machine rejected, and the reason.
    refused: Option<(Request, Refusal)>,
}

impl Control {
    /// The state after a reset: idle, not homed, no torque.
    #[must_use]
    pub fn new() -> Self {
        Self { controller: controller(), safety: safety(), late: false, requested: None, refused: None }
    }

    /// State of the safety state machine.
    #[must_use]
    pub fn state(&self) -> State {
        self.safety.state()
    }

    /// True if the joints' zeros have been confirmed.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.safety.homed()
    }

    /// The last request, if the state machine rejected it, and the reason. Show it to the operator. `None` after a request that was accepted.
    #[must_use]
    pub fn refused(&self) -> Option<(Request, Refusal)> {
        self.refused
    }

    /// One tick, to be called at [`RATE_HZ`](crate::robot::RATE_HZ). Returns true if it ended in time: feed the watchdog only then.
    ///
    /// `is_due` returns true if the next tick is due already. A late torque is not sent, and the tick after it raises the fault `Overrun`.
    ///
    /// A request reaches the state machine only if it differs from that of the tick before. While the host is silent, its last request is remembered:
    /// a host that returns with a latched `Run` does not restart the arm. `Stop` is accepted in every tick.
    pub fn tick(&mut self, hardware: &mut impl Hardware, is_due: impl Fn() -> bool) -> bool {
        // Nothing is read yet: every input is the worst case, and none of them lets torque act.
        let mut inputs = Inputs::unknown();
        hardware.read_encoders(&mut inputs);
        hardware.read_operator(&mut inputs, self.safety.state());
        inputs.overrun = self.late;
        inputs.request = self.new_request(&inputs);
        let output = self.safety.tick(&inputs, |request| request.of(&mut self.controller));
        if let Some(request) = inputs.request {
            self.refused = output.refused.map(|reason| (request, reason));
        }
        match output.actuation {
            _ if is_due() => hardware.make_safe(SAFE_ACTION),
            Actuation::Drive { torque, .. } => hardware.write_torques(&torque, Brakes::Released),
            Actuation::Preload { torque, .. } => hardware.write_torques(&torque, Brakes::Engaged),
            Actuation::Enable(action) => hardware.enable_drives(action),
            Actuation::Safe(action) => hardware.make_safe(action),
        }
        self.late = is_due();
        if self.late {
            hardware.make_safe(SAFE_ACTION);
        }
        !self.late
    }

    /// The request of this tick, if it is a new one.
    fn new_request(&mut self, inputs: &Inputs<f32, N>) -> Option<Request> {
        let request = inputs.request;
        let repeated = request == self.requested && request != Some(Request::Stop);
        let silent = inputs.heartbeat_age > self.safety.rules().heartbeat_max;
        if request.is_some() || !silent {
            self.requested = request;
        }
        request.filter(|_| !repeated)
    }
}

impl Default for Control {
    fn default() -> Self {
        Self::new()
    }
}
