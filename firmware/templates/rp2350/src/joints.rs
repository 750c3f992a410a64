//! YOUR FILE: encoders, drives, operator. As shipped it reads nothing and sends nothing, so no torque can act.

use crate::control::{Brakes, Hardware, SAFE_ACTION};
use crate::robot::N;
use dynamics_core::safety::{Inputs, SafeAction, State};
use embedded_hal::digital::OutputPin;

// The build ends here if the scene's `safe_action` needs code that `make_safe` does not have.
const _: () = assert!(
    matches!(SAFE_ACTION, SafeAction::Brake),
    "`make_safe` in src/joints.rs does only `safe_action = \"brake\"`, and arm/move.toml has another one. Without brakes the arm would fall. Write the \
     branch of `match action` for it, then delete this assertion"
);

/// The joints, with two lines of the chip. Both need a pull-down: in a reset the chip drives no pin.
pub struct Joints<D, B> {
    /// High: the drives may be on.
    pub drives: D,
    /// High: the brakes are released.
    pub brakes: B,
}

impl<D: OutputPin, B: OutputPin> Hardware for Joints<D, B> {
    fn read_encoders(&mut self, inputs: &mut Inputs<f32, N>) {
        // WRITE THIS: read every encoder and every drive, for example
        //   inputs.sensed = Sensed::Counts(self.encoders.counts()); // as `encoder` of the robot file scales them
        //   inputs.age_ticks = self.encoders.ages();                // ticks since each reading; 0 is fresh
        //   inputs.zeroed = self.encoders.know_their_zero();        // every joint does
        //   inputs.zero_lost = self.encoders.have_restarted();      // the arm must be homed again
        //   inputs.on = self.bus.drives_are_on();                   // as the drives report it, not as you commanded it
        //   inputs.drive_fault = self.bus.drive_faults();
        // CHANGE THIS if your board measures the supply voltage (V) or a temperature (degrees Celsius): `Some`, and `Some(f32::NAN)` after an error.
        (inputs.supply, inputs.temperature) = (None, None);
    }

    fn read_operator(&mut self, inputs: &mut Inputs<f32, N>, state: State) {
        // WRITE THIS: read the emergency stop's second contact, the operator's requests, and the reference of this tick, for example
        //   inputs.emergency_stop = self.stop.is_high().unwrap_or(true); // closed to ground: high is pressed, or a broken wire
        //   inputs.heartbeat_age = self.host.ticks_since_heard();        // of the host that sends the reference
        //   inputs.request = self.host.take_request();                   // Home, Confirm, Arm, Run, then Hold, Disarm. Each ONCE, when it arrives
        //   inputs.reference = self.host.take_reference();               // `None` if none has arrived for this tick. The first: where the arm is
        // With an enabling button as well, the older of both counts. The button alone would hide a dead host:
        //   inputs.heartbeat_age = self.host.ticks_since_heard().max(self.button.ticks_since_held());
        let _ = (inputs, state);
    }

    fn enable_drives(&mut self, action: SafeAction) {
        // WRITE THIS: engage the brakes, and enable the drives only if that succeeded:
        //   if self.brakes.set_low().is_ok() {
        //       self.drives.set_high().ok();
        //   }
        // Then send the frames that switch the drives on, without torque.
        self.make_safe(action);
    }

    fn write_torques(&mut self, torque: &[f32; N], brakes: Brakes) {
        // WRITE THIS: send the torques to the drives. Then, and only if they were sent:
        //   match brakes {
        //       Brakes::Released => self.brakes.set_high().ok(),
        //       Brakes::Engaged => self.brakes.set_low().ok(),
        //   };
        let _ = (torque, brakes);
        self.make_safe(SAFE_ACTION);
    }

    fn make_safe(&mut self, action: SafeAction) {
        match action {
            SafeAction::Brake => {
                // ADD your frames that switch the drives off, after these two lines. They replace everything that is queued.
                self.brakes.set_low().ok();
                self.drives.set_low().ok();
            }
            // WRITE THESE if your scene has another `safe_action`. `DampedStop`: the drives stay on and damp, without torque commands. `Off`: the drives
            // are off; only for an arm that does not fall. The assertion above ends the build until then.
            SafeAction::DampedStop | SafeAction::Off => {
                self.brakes.set_low().ok();
                self.drives.set_low().ok();
            }
        }
    }
}
