//! Joint values, and the inputs and outputs of a tick.

use serde::{Deserialize, Serialize};

/// Largest number of joints that a frame carries.
pub const JOINTS_MAX: usize = 6;

/// One value per joint, base first. The count is sent too: frames need no type parameter, and a frame for another arm causes an error instead
/// of being misread.
pub type Joints<T> = heapless::Vec<T, JOINTS_MAX>;

/// Reading of the sensors for a tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Number of the tick; the answer repeats it.
    pub tick: u32,
    /// Age of the reading, ticks; 0 is fresh.
    pub age_ticks: u32,
    /// The reading.
    pub sensed: Sensed,
}

/// A sensor reading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sensed {
    /// Position and velocity.
    State {
        /// Joint position, rad or m.
        q: Joints<f32>,
        /// Joint velocity, rad/s or m/s.
        qd: Joints<f32>,
    },
    /// Encoder counts, one per joint.
    Counts(Joints<i32>),
}

/// Reference for the arm, valid until the next one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Joint position, rad or m.
    pub q: Joints<f32>,
    /// Joint velocity, rad/s or m/s.
    pub qd: Joints<f32>,
    /// Joint acceleration, rad/s^2 or m/s^2.
    pub qdd: Joints<f32>,
}

/// The live inputs of the scene, valid until the next frame of this kind. The controller uses those that the scene declares as live.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Live {
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: [f32; 3],
    /// Wrench of the environment on the arm at the tip's origin, in tip axes: force, N, then moment, N m.
    pub tip_wrench: [f32; 6],
    /// Payload at the tip, in the last link's frame.
    pub payload: Payload,
    /// Reflected rotor inertias, kg m^2 (kg for a prismatic joint).
    pub rotor: Joints<f32>,
}

/// The ten inertial parameters of a held body, in the last link's frame and about its origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payload {
    /// Mass, kg.
    pub mass: f32,
    /// First moment: mass times position of the centre of mass, kg m.
    pub first_moment: [f32; 3],
    /// Inertia about the origin, kg m^2: xx, yy, zz, xy, xz, yz.
    pub inertia: [f32; 6],
}

/// Torques for the actuators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// Number of the tick that this answers.
    pub tick: u32,
    /// Actuator torque or force, N m or N: exactly the computed bits.
    pub torque: Joints<f32>,
    /// Limits that acted, as the bits of [`dynamics_core::control::LimitFlags`].
    pub limits: Joints<u8>,
    /// Cost of the controller's tick, if the board can count it exactly.
    pub cost: Option<Cost>,
}

/// Cost of a tick. Instructions and cycles are different quantities, and no table mixes them in one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cost {
    /// Instructions executed, as the emulator counts them.
    Instructions(u32),
    /// Processor cycles, from the chip's own counter.
    Cycles(u32),
}

/// Reason why the controller brakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Number of the tick that this answers; for a fault without a measurement, the last tick before it.
    pub tick: u32,
    /// Stable code of the fault: [`dynamics_core::Fault::code`].
    pub code: u8,
    /// The joint that caused it, counted from 0, if it is a single joint.
    pub joint: Option<u8>,
}

/// A point of the trajectory. The segment from the previous point is the fifth-degree polynomial that matches position, velocity and
/// acceleration at both points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Ticks from the previous point to this one; 0 starts a new trajectory here.
    pub ticks: u16,
    /// Position, velocity and acceleration.
    pub reference: Reference,
}
