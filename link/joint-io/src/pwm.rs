//! Joints with H-bridges, which are driven by a duty cycle, and magnetic encoders.
//!
//! ```text
//! tau_m = tau / ratio                        torque of the motor                [N m]
//! i     = tau_m / k                          limited to the largest current     [A]
//! u     = R i + k w                          resistance and back-EMF            [V]
//! duty  = |u| / supply                       limited to 1; a pin sets the sign
//! ```
//!
//! with the torque constant `k`, the resistance `R` and the motor's speed `w` from the last step of the encoder.
//! Inductance is neglected: its time constant is far below a tick. Without a current sensor the current is estimated from the last duty,
//! `(duty supply - k w) / R`.

use crate::as5047p::{As5047p, Turns};
use crate::{JointIo, MISSING_MAX};
use dynamics_core::Real;
use dynamics_core::control::{Sensed, Spring};
use dynamics_core::drive::PwmDrive;
use dynamics_core::safety::SafeAction;
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal::spi::SpiDevice;
use session::readings::{JointFaults, Readings};

/// Sensor of a motor's current.
pub trait CurrentSensor {
    /// Returns the present current, A, positive for positive torque of the joint; `None` if it cannot be measured.
    fn current(&mut self) -> Option<f32>;
}

/// No current sensor: the current is estimated from the duty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoSensor;

impl CurrentSensor for NoSensor {
    fn current(&mut self) -> Option<f32> {
        None
    }
}

/// Duty and current of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Voltage as a share of the supply voltage, from -1 to 1.
    pub duty: f32,
    /// Current that the duty drives at the speed it was computed for, A.
    pub current: f32,
    /// True if the torque needs more current or more voltage than the limits allow.
    pub saturated: bool,
}

impl Drive {
    /// No voltage.
    pub const NONE: Self = Self { duty: 0.0, current: 0.0, saturated: false };

    /// Computes duty and current for a torque or force of the joint, N m or N, while the motor turns at `speed`, rad/s. `None` if they are not
    /// finite.
    #[inline]
    #[must_use]
    pub fn torque(torque: f32, speed: f32, drive: &PwmDrive) -> Option<Self> {
        let wanted = drive.gearing.drive_torque(torque) * drive.per_torque_constant;
        let back_emf = drive.torque_constant * speed;
        if !(wanted.is_finite() && back_emf.is_finite()) {
            return None;
        }
        let held = wanted.clamp_symmetric(drive.current_max);
        let share = (drive.resistance * held + back_emf) * drive.per_supply;
        let duty = share.clamp_symmetric(1.0);
        let current = (duty * drive.supply - back_emf) * drive.per_resistance;
        Some(Self { duty, current, saturated: held.abs() < wanted.abs() || duty.abs() < share.abs() })
    }
}

/// Converts a duty from 0 to 1 into steps from 0 to `max`. A duty outside this range is clamped; NaN gives 0.
#[inline]
#[must_use]
pub fn duty_steps(duty: f32, max: u16) -> u16 {
    ((duty * f32::from(max) + 0.5) as u16).min(max)
}

/// The pins and devices of one joint.
#[derive(Debug)]
pub struct Channel<W, D, E, S, C = NoSensor> {
    /// PWM output that sets the duty cycle of the bridge.
    pub pwm: W,
    /// Direction pin: high for a voltage that moves the motor forwards.
    pub direction: D,
    /// Enable pin: high while the bridge drives.
    pub enable: E,
    /// The encoder.
    pub encoder: S,
    /// The current sensor.
    pub sensor: C,
}

#[derive(Debug)]
struct PwmJoint<W, D, E, S, C> {
    pwm: W,
    direction: D,
    enable: E,
    encoder: As5047p<S>,
    sensor: C,
    turns: Turns,
    forwards: Option<bool>,
    given: Drive,
    faults: JointFaults,
}

/// The joints with H-bridges.
#[derive(Debug)]
pub struct PwmJoints<W, D, E, S, C, P, const N: usize> {
    joints: [PwmJoint<W, D, E, S, C>; N],
    drives: [PwmDrive; N],
    brake: P,
    brake_failed: bool,
}

impl<W, D, E, S, C, P, const N: usize> PwmJoints<W, D, E, S, C, P, N>
where
    W: SetDutyCycle,
    D: OutputPin,
    E: OutputPin,
    S: SpiDevice,
    C: CurrentSensor,
    P: OutputPin,
{
    /// Creates the driver, with no duty, bridges off and brakes engaged. `channels` are in the order of the joints.
    pub fn new(channels: [Channel<W, D, E, S, C>; N], brake: P, drives: [PwmDrive; N]) -> Self {
        let mut jumps = drives.iter().map(|drive| drive.jump_max);
        let joints = channels.map(|Channel { pwm, direction, enable, encoder, sensor }| {
            let mut encoder = As5047p::new(encoder);
            // Requests diagnostics, so that the first tick receives them.
            encoder.angle();
            PwmJoint {
                pwm,
                direction,
                enable,
                encoder,
                sensor,
                turns: Turns::new(jumps.next().unwrap_or(0)),
                forwards: None,
                given: Drive::NONE,
                faults: JointFaults::NONE,
            }
        });
        let mut joints = Self { joints, drives, brake, brake_failed: false };
        joints.safe(SafeAction::Brake);
        joints
    }

    /// Returns the last duty and current of each joint.
    pub fn given(&self) -> [Drive; N] {
        core::array::from_fn(|i| self.joints.get(i).map_or(Drive::NONE, |joint| joint.given))
    }

    /// Applies torques or forces, N m or N; does not change the brake.
    fn give(&mut self, torque: &[f32; N]) {
        for ((joint, drive), &torque) in self.joints.iter_mut().zip(&self.drives).zip(torque) {
            joint.torque(torque, drive);
        }
    }
}

impl<W: SetDutyCycle, D: OutputPin, E: OutputPin, S: SpiDevice, C: CurrentSensor> PwmJoint<W, D, E, S, C> {
    fn measure(&mut self, drive: &PwmDrive) {
        let counts = self.encoder.angle().map(|angle| {
            let counts = angle.wrapping_sub(drive.encoder_zero);
            if drive.encoder_reversed { counts.wrapping_neg() } else { counts }
        });
        self.turns.update(counts);
    }

    /// Speed of the motor, rad/s, positive in the direction of its positive torque.
    fn speed(&self, drive: &PwmDrive) -> f32 {
        self.turns.speed() as f32 * drive.speed_per_count
    }

    fn torque(&mut self, torque: f32, drive: &PwmDrive) {
        let wanted = Drive::torque(torque, self.speed(drive), drive);
        self.faults = JointFaults::NON_FINITE.when(wanted.is_none());
        self.give(wanted.unwrap_or(Drive::NONE));
        self.check(|joint| joint.enable.set_high().is_ok());
    }

    /// Sets duty and direction. The duty is zero while the direction changes, so that no voltage acts in the wrong direction.
    fn give(&mut self, drive: Drive) {
        self.given = drive;
        let forwards = drive.duty >= 0.0;
        if self.forwards != Some(forwards) {
            self.check(|joint| joint.pwm.set_duty_cycle(0).is_ok());
            self.forwards = Some(forwards);
            self.check(|joint| {
                let set = if forwards { joint.direction.set_high() } else { joint.direction.set_low() };
                set.is_ok()
            });
        }
        let steps = duty_steps(drive.duty.abs(), self.pwm.max_duty_cycle());
        self.check(|joint| joint.pwm.set_duty_cycle(steps).is_ok());
    }

    /// Sets the duty to zero. A bridge that stays on shorts the motor, which damps it; a bridge that is off lets it coast.
    fn stop(&mut self, bridge_off: bool) {
        self.faults = JointFaults::NONE;
        self.given = Drive::NONE;
        self.check(|joint| joint.pwm.set_duty_cycle(0).is_ok());
        if bridge_off {
            self.check(|joint| joint.enable.set_low().is_ok());
        }
    }

    fn check(&mut self, act: impl FnOnce(&mut Self) -> bool) {
        let done = act(self);
        self.faults |= JointFaults::OUTPUT.when(!done);
    }

    fn found(&self) -> JointFaults {
        self.faults
            | JointFaults::SENSOR.when(self.encoder.is_doubtful())
            | JointFaults::LOST.when(self.turns.is_lost())
            | JointFaults::MISSING.when(self.turns.age_ticks() > MISSING_MAX)
    }
}

impl<W, D, E, S, C, P, const N: usize> JointIo<N> for PwmJoints<W, D, E, S, C, P, N>
where
    W: SetDutyCycle,
    D: OutputPin,
    E: OutputPin,
    S: SpiDevice,
    C: CurrentSensor,
    P: OutputPin,
{
    fn measure(&mut self) -> Option<Readings<N>> {
        let mut readings = Readings {
            sensed: Sensed::Counts([0; N]),
            torque: [0.0; N],
            age_ticks: [u32::MAX; N],
            faults: [JointFaults::OUTPUT.when(self.brake_failed); N],
            errors: [0; N],
            on: [true; N],
            zero_lost: false,
        };
        let mut counts = [0; N];
        for (i, (joint, drive)) in self.joints.iter_mut().zip(&self.drives).enumerate() {
            joint.measure(drive);
            let current = joint.sensor.current().unwrap_or(joint.given.current);
            counts[i] = joint.turns.position();
            readings.torque[i] = drive.gearing.joint_torque(current * drive.torque_constant);
            readings.age_ticks[i] = joint.turns.age_ticks();
            readings.faults[i] |= joint.found();
        }
        readings.sensed = Sensed::Counts(counts);
        Some(readings)
    }

    fn enable(&mut self, action: SafeAction) {
        self.safe(action);
    }

    fn preload(&mut self, torque: &[f32; N], _: Option<&[Spring<f32>; N]>) {
        // Before the torque is set, because the brakes need time to engage.
        self.brake_failed = self.brake.set_low().is_err();
        self.give(torque);
    }

    fn drive(&mut self, torque: &[f32; N], _: Option<&[Spring<f32>; N]>) {
        self.give(torque);
        // After the torque is set, so that the motors hold before the brakes release.
        self.brake_failed = self.brake.set_high().is_err();
    }

    fn safe(&mut self, action: SafeAction) {
        if action == SafeAction::Brake {
            self.brake_failed = self.brake.set_low().is_err();
        }
        for joint in &mut self.joints {
            joint.stop(action != SafeAction::DampedStop);
        }
    }
}
