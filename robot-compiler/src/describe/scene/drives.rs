//! Drives of the joints, as numbers for the chip.
//!
//! A file uses the units of data sheets. [`SceneFile::drives`] converts once, in double precision, and rounds each number
//! once to single precision.

use super::SceneFile;
use crate::describe::drive::{ENCODER_COUNTS, JointDrive, MitSpec, Protocol, PwmSpec};
use crate::describe::robot::RobotJoint;
use dynamics_core::drive::{Drives, Gearing, MitDrive, MitRanges, PositionMemory, PwmDrive, Range, TIMEOUT_UNIT_US};
use std::f64::consts::TAU;

/// Communication timeout that is set in a drive, s, and its least value in control periods. It is longer than a reset of the board by its
/// watchdog takes (eight ticks), so that a drive does not give up while its board works.
const TIMEOUT: f64 = 0.05;
const TIMEOUT_TICKS: f64 = 10.0;

/// Fewest ticks without a reply after which a drive may have restarted: at any rate, a single lost frame is no evidence.
const RESTART_TICKS_MIN: u32 = 2;

/// Least difference between a joint's range and one turn of the output shaft, rad: covers the guard's margin beyond the limits and the resolution.
const TURN_MARGIN: f64 = 0.2;

/// Most ticks for which an encoder may go unread: it must not move half a turn in that time.
pub(crate) const UNREAD_MAX: u16 = 4;

impl SceneFile {
    /// Protocol of the drives on CAN; `None` without any.
    #[must_use]
    pub fn protocol(&self) -> Option<Protocol> {
        match self.robot.joints.first()?.drive? {
            JointDrive::Mit(spec) => Some(spec.protocol),
            JointDrive::Pwm(_) => None,
        }
    }

    /// Drives of the arm's joints, in the chip's numbers. [`Drives::Link`] if the robot file gives none, and for a bench-only
    /// scene: such a firmware reaches no drive.
    #[must_use]
    pub fn drives<const N: usize>(&self) -> Drives<N> {
        let joints = &self.robot.joints;
        if self.safety.bench_only {
            return Drives::Link;
        }
        // Loading has checked that all joints have a drive of one kind, or none has.
        if let Some(drives) = all(joints, |joint| self.mit(joint)) {
            return Drives::Mit(drives);
        }
        let pwm = all(joints, |joint| match joint.drive? {
            JointDrive::Pwm(spec) => Some(self.pwm(joint, &spec)),
            JointDrive::Mit(_) => None,
        });
        pwm.map_or(Drives::Link, Drives::Pwm)
    }

    /// MIT-mode actuators of the joints, base first, in the chip's numbers; empty for drives of another kind.
    #[must_use]
    pub fn mit_drives(&self) -> Vec<MitDrive> {
        self.robot.joints.iter().filter_map(|joint| self.mit(joint)).collect()
    }

    /// MIT-mode actuators that drive the simulated arm, in the robot file's and in the chip's numbers; `None` for ideal drives.
    #[must_use]
    pub fn simulated_drives<const N: usize>(&self) -> Option<([MitSpec; N], [MitDrive; N])> {
        let specs = all(&self.robot.joints, |joint| joint.drive?.mit()).filter(|_| !self.actuators.ideal)?;
        Some((specs, all(&self.robot.joints, |joint| self.mit(joint))?))
    }

    /// A joint's MIT-mode actuator in the chip's numbers.
    fn mit(&self, joint: &RobotJoint) -> Option<MitDrive> {
        let spec = joint.drive?.mit()?;
        let period = self.period();
        let (lowest, highest) = joint.spec.limits.position;
        // If the joint's whole range is less than a turn of the output shaft, an angle within the turn means only one position.
        let one_turn = spec.ratio.abs() * (highest - lowest) < TAU - TURN_MARGIN;
        let absolute = match spec.protocol.facts().memory {
            PositionMemory::Absolute => true,
            PositionMemory::OutputTurn => one_turn,
            PositionMemory::MotorTurn | PositionMemory::Nothing => false,
        };
        let timeout = if spec.protocol.facts().has_timeout {
            TIMEOUT.max(TIMEOUT_TICKS * period) * 1e6 / f64::from(TIMEOUT_UNIT_US)
        } else {
            0.0
        };
        Some(MitDrive {
            // The casts saturate.
            timeout: timeout.round() as u32,
            restart_ticks: ((f64::from(spec.protocol.facts().restart_us) * 1e-6 / period + 1e-9) as u32)
                .max(RESTART_TICKS_MIN),
            absolute,
            ..mit(&spec)
        })
    }

    /// True if every joint has a drive on CAN that a run simulates.
    pub(crate) fn simulates_drives(&self) -> bool {
        !self.actuators.ideal && !self.mit_drives().is_empty() && self.robot.joints.iter().all(RobotJoint::has_own_loop)
    }

    fn pwm(&self, joint: &RobotJoint, spec: &PwmSpec) -> PwmDrive {
        let per_turn = joint.encoder.map_or(f64::from(ENCODER_COUNTS), |encoder| encoder.counts_per_turn);
        let PwmSpec {
            channel,
            ratio,
            encoder_zero,
            encoder_reversed,
            torque_constant,
            resistance,
            supply,
            current_max,
        } = *spec;
        PwmDrive {
            channel: channel.saturating_sub(1),
            gearing: gearing(ratio, 0.0),
            encoder_zero,
            encoder_reversed,
            jump_max: self.jump_max(joint, per_turn),
            speed_per_count: (ratio * TAU / per_turn * self.control.rate) as f32,
            torque_constant: torque_constant as f32,
            per_torque_constant: (1.0 / torque_constant) as f32,
            resistance: resistance as f32,
            per_resistance: (1.0 / resistance) as f32,
            supply: supply as f32,
            per_supply: (1.0 / supply) as f32,
            current_max: current_max as f32,
        }
    }

    /// Most counts that the encoder may move in one tick: at the speed at which the guard raises a fault, plus one for its
    /// noise.
    fn jump_max(&self, joint: &RobotJoint, per_turn: f64) -> u16 {
        let speed = self.control.velocity_factor * joint.spec.limits.velocity;
        // The cast saturates.
        ((speed * per_turn / TAU / self.control.rate).ceil() + 1.0) as u16
    }

    /// The first joint, counted from 0, whose encoder may move half a turn while it is not read for a few ticks: its turns
    /// cannot be counted at this rate. Also returns the counts that it moves in a tick.
    #[must_use]
    pub fn too_fast_for_its_encoder(&self) -> Option<(usize, u16)> {
        self.robot.joints.iter().enumerate().find_map(|(index, joint)| {
            let Some(JointDrive::Pwm(_)) = joint.drive else { return None };
            let jump = self.jump_max(joint, joint.encoder?.counts_per_turn);
            (jump >= ENCODER_COUNTS / 2 / UNREAD_MAX).then_some((index, jump))
        })
    }
}

fn all<T, const N: usize>(joints: &[RobotJoint], one: impl Fn(&RobotJoint) -> Option<T>) -> Option<[T; N]> {
    joints.iter().map(one).collect::<Option<Vec<T>>>()?.try_into().ok()
}

fn gearing(ratio: f64, zero: f64) -> Gearing {
    Gearing { ratio: ratio as f32, per_ratio: (1.0 / ratio) as f32, zero: zero as f32 }
}

fn mit(spec: &MitSpec) -> MitDrive {
    let range = |(min, max): (f64, f64)| Range { min: min as f32, max: max as f32 };
    let MitSpec {
        protocol: _,
        bus,
        data_rate,
        id,
        reply_id,
        reply_bytes,
        temperature_offset,
        ratio,
        zero,
        position,
        velocity,
        kp,
        kd,
        torque,
        damping,
    } = *spec;
    MitDrive {
        bus: bus.saturating_sub(1),
        data_rate,
        id,
        reply_id,
        reply_bytes,
        temperature_offset: temperature_offset.map(|offset| offset as f32),
        ranges: MitRanges {
            position: range(position),
            velocity: range(velocity),
            kp: range(kp),
            kd: range(kd),
            torque: range(torque),
        },
        gearing: gearing(ratio, zero),
        damping: damping as f32,
        timeout: 0,
        restart_ticks: RESTART_TICKS_MIN,
        absolute: false,
    }
}
