//! [`JointIo`] of the CAN joints: the calls of a control tick.

use super::CanJoints;
use super::bus::collect;
use super::joint::CanJoint;
use super::limits::{CLEARING, Order, TIMEOUT_TRIES};
use crate::can_bus::CanBus;
use crate::frames::Frames;
use crate::{JointIo, MISSING_MAX, higher};
use dynamics_core::control::{Sensed, Spring};
use dynamics_core::safety::SafeAction;
use embedded_hal::digital::OutputPin;
use session::readings::{JointFaults, Readings};

impl<F: Frames, A: CanBus, B: CanBus, C: CanBus, P: OutputPin, const N: usize> JointIo<N>
    for CanJoints<F, A, B, C, P, N>
{
    fn measure(&mut self) -> Option<Readings<N>> {
        let off = [
            collect::<F, A, N>(&mut self.first, 0, &self.drives, &mut self.joints),
            collect::<F, B, N>(&mut self.second, 1, &self.drives, &mut self.joints),
            collect::<F, C, N>(&mut self.third, 2, &self.drives, &mut self.joints),
        ];
        let (mut faults, mut zero_lost) = ([JointFaults::NONE; N], false);
        for ((joint, drive), faults) in self.joints.iter_mut().zip(&self.drives).zip(&mut faults) {
            joint.begin_tick(drive);
            let off = off[usize::from(drive.bus.min(2))];
            if off {
                joint.forget();
            }
            zero_lost |= core::mem::take(&mut joint.zero_lost);
            let unset = joint.timeout.tries > TIMEOUT_TRIES && !joint.timeout.is_settled(drive);
            *faults = joint.faults
                | JointFaults::TIMEOUT.when(unset)
                | JointFaults::TORQUE.when(joint.torque_lost)
                | JointFaults::MISSING.when(joint.age_ticks > MISSING_MAX)
                | JointFaults::BUS.when(off)
                | JointFaults::OUTPUT.when(self.brake_failed);
        }
        let (q, qd) = (self.joints.map(|joint| joint.position), self.joints.map(|joint| joint.velocity));
        Some(Readings {
            sensed: Sensed::State { q, qd },
            torque: self.joints.map(|joint| joint.torque),
            age_ticks: self.joints.map(|joint| joint.age(self.released)),
            faults,
            errors: self.joints.map(|joint| joint.error),
            on: self.joints.map(|joint| joint.on),
            zero_lost,
        })
    }

    fn temperature(&self) -> Option<f32> {
        self.joints.iter().fold(None, |hottest, joint| higher(hottest, joint.temperature))
    }

    fn enable(&mut self, action: SafeAction) {
        self.engage_brakes();
        self.send_all(|_| Order::Enable { damped: action == SafeAction::DampedStop });
    }

    fn preload(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        self.engage_brakes();
        self.send_torque(torque, springs);
    }

    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        // The brakes open only if every drive has replied in this tick with its full torque. Then they stay open while every drive is on.
        let shown = |joint: &CanJoint| joint.age(false) == 0 && joint.weak == 0;
        if self.all_on() && (self.released || self.joints.iter().all(shown)) {
            self.release_brakes();
        } else {
            self.engage_brakes();
        }
        self.send_torque(torque, springs);
    }

    fn safe(&mut self, action: SafeAction) {
        for joint in &mut self.joints {
            joint.forget();
            joint.torque_lost = false;
        }
        match action {
            SafeAction::Brake => {
                self.engage_brakes();
                self.send_all(|_| Order::Off);
            }
            SafeAction::DampedStop => self.send_all(|_| Order::Damp),
            SafeAction::Off => self.send_all(|_| Order::Off),
        }
    }

    fn end(&mut self) {
        if !F::NOTICES {
            return self.safe(SafeAction::Off);
        }
        // The safe action would end with a command that measures, and such a command switches the drive on.
        self.engage_brakes();
        self.joints.iter_mut().for_each(CanJoint::forget);
        self.send_to_all(F::exit);
    }

    fn clear(&mut self) {
        self.clearing = CLEARING;
    }

    fn interrupt(&mut self) {
        self.first.interrupt();
        self.second.interrupt();
        self.third.interrupt();
    }
}
