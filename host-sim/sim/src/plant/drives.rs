//! Simulated drives: the board's own access to the joints ([`CanJoints`](joint_io::can::CanJoints)), three CAN buses, and an actuator at every joint.
//!
//! ```text
//! tick k:  measure: replies to the commands of tick k-1 | controller | commands arrive, actuators measure and reply | the arm moves
//! ```
//!
//! Commands arrive at the instant at which the tick begins, so a measurement is one period old when the controller gets it. The gearing relates the
//! actuator's shaft to the joint: `p = ratio q + zero`, `v = ratio qd`, `tau = ratio tau_shaft`. Here it is computed in double precision, with the
//! robot file's numbers; the controller uses the chip's. An actuator updates the torque of its own position and velocity loop several times a tick.
//! Without stiffness and damping, the torque is constant from frame to frame.

use super::drive_wiring::{self, Joints, Line};
use super::joint_mount::JointMount;
use super::{Clock, State};
use actuator_model::bus::{Bus, Fate};
use actuator_model::frame::Frame;
use actuator_model::mit::{Electronics, Shaft};
use dynamics_core::control::Spring;
use dynamics_core::drive::MitDrive;
use dynamics_core::safety::SafeAction;
use joint_io::JointIo;
use joint_io::can::BUSES;
use robot_compiler::drive::{MitSpec, Protocol};
use robot_compiler::scene::{DriveFailure, FailureKind};
use session::readings::Readings;

/// Limit on the exchanges until all drives are on: for each drive in turn, three about its timeout, and three until it is on.
const ENABLING_MAX: u32 = 100;

/// The drives of an arm.
#[derive(Debug)]
pub struct Drives<const N: usize> {
    joints: Box<dyn Joints<N>>,
    seats: [JointMount; N],
    /// Updates of the actuators' own loop in a tick.
    turns: u32,
    period: f64,
    failure: Option<DriveFailure>,
    /// Ticks driven or stopped.
    ticks: u64,
}

/// Command to all drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order<const N: usize> {
    /// These torques or forces, N m or N, and springs for the drives' own loops.
    Torque([f64; N], Option<[Spring<f32>; N]>),
    /// Enable the drives with engaged brakes. If the action is a damped stop, the drives that are already on damp.
    Enable(SafeAction),
    /// These torques or forces, N m or N, with engaged brakes.
    Preload([f64; N]),
    /// The safe action.
    Safe(SafeAction),
}

impl<const N: usize> Drives<N> {
    /// Drives that are off, with the robot file's numbers (`specs`) and the chip's (`wires`). `loop_rate` is the rate of their own loop, Hz; a tick
    /// contains the nearest whole number of its updates.
    #[must_use]
    pub fn new(specs: &[MitSpec; N], wires: [MitDrive; N], clock: Clock, loop_rate: f64) -> Self {
        let mut actuators = [const { Vec::new() }; BUSES];
        let seats = specs.map(|spec| JointMount::new(&spec, &mut actuators));
        // Loading has checked that all drives are of one kind.
        let protocol = specs.first().map_or(Protocol::MiniCheetah, |spec| spec.protocol);
        let lines = actuators.map(|actuators| Line(Bus::forgetful(actuators)));
        Self {
            joints: drive_wiring::joints(protocol, lines, wires),
            seats,
            // The cast saturates.
            turns: ((clock.period * loop_rate).round() as u32).max(1),
            period: clock.period,
            failure: None,
            ticks: 0,
        }
    }

    /// The same drives, with one that fails at some time.
    #[must_use]
    pub fn with_failure(self, failure: Option<DriveFailure>) -> Self {
        Self { failure, ..self }
    }

    /// The same drives, whose true torques are multiples of the torques in their frames by these factors, base first. Joints without a factor keep 1.
    #[must_use]
    pub fn with_torque_factors(mut self, factors: &[f64]) -> Self {
        self.seats.iter_mut().zip(factors).for_each(|(seat, factor)| seat.factor = *factor);
        self
    }

    /// A joint's simulated drive electronics, for inspection and fault injection.
    pub fn electronics(&mut self, joint: usize) -> Option<&mut Electronics> {
        let JointMount { bus, place, .. } = *self.seats.get(joint)?;
        Some(&mut self.bus(bus).actuators.get_mut(place)?.electronics)
    }

    /// Torque that a joint's drive last produced, at the joint, N m or N.
    pub fn given(&mut self, joint: usize) -> f64 {
        let factor = self.seats.get(joint).map_or(0.0, |seat| seat.ratio * seat.factor);
        self.electronics(joint).map_or(0.0, |electronics| factor * electronics.torque())
    }

    /// Index of the bus of a joint's drive, and the drive's identifier on it.
    pub fn address(&mut self, joint: usize) -> Option<(usize, u16)> {
        let bus = self.seats.get(joint)?.bus;
        Some((bus, self.electronics(joint)?.id))
    }

    /// One of the buses, counted from 0.
    pub fn bus(&mut self, bus: usize) -> &mut Bus {
        self.joints.bus(bus)
    }

    /// Disturbs the frames of a joint's drive until the next call. A deaf drive receives nothing and sends nothing. `replies` are possible fates of
    /// its next reply; the first one whose flag is true applies.
    pub fn disturb(&mut self, joint: usize, deaf: bool, replies: [(bool, Fate); 2]) {
        let Some(JointMount { bus, place, .. }) = self.seats.get(joint).copied() else { return };
        let bus = self.bus(bus);
        let Some(id) = bus.actuators.get(place).map(|actuator| actuator.electronics.id) else { return };
        bus.unplugged.retain(|other| *other != id);
        if deaf {
            bus.unplugged.push(id);
        }
        bus.fates.retain(|(other, _)| *other != id);
        let fate = replies.into_iter().find(|(comes, _)| *comes);
        bus.fates.extend(fate.map(|(_, fate)| (id, fate)));
    }

    /// True if the brakes hold the arm.
    pub fn brakes_hold(&self) -> bool {
        !self.joints.brake().open
    }

    /// Readings from the replies since the last call, and the drives' highest temperature, degrees Celsius.
    pub fn measure(&mut self) -> (Option<Readings<N>>, Option<f32>) {
        (self.joints.io().measure(), self.joints.io().temperature())
    }

    /// Enables the drives while something else holds the arm, in no simulated time. Frames are exchanged until each drive has reported that it is on,
    /// at most [`ENABLING_MAX`] times.
    pub(crate) fn enable(&mut self, action: SafeAction, measured: &State<N>) {
        for _ in 0..ENABLING_MAX {
            let (readings, _) = self.measure();
            if readings.is_some_and(|readings| readings.on == [true; N]) {
                return;
            }
            self.send(&Order::Enable(action), measured);
        }
    }

    /// Clears the drives' errors in the next safe actions.
    pub fn clear(&mut self) {
        self.joints.io().clear();
    }

    /// The board's interface to the joints. Frames sent through it arrive with [`Drives::serve`].
    pub fn board(&mut self) -> &mut dyn JointIo<N> {
        self.joints.io()
    }

    /// Sends a tick's commands. The actuators receive them at once, and reply with the state that they measure.
    pub(crate) fn send(&mut self, order: &Order<N>, measured: &State<N>) {
        match order {
            Order::Torque(torque, springs) => {
                self.joints.io().drive(&torque.map(|torque| torque as f32), springs.as_ref());
            }
            Order::Enable(action) => self.joints.io().enable(*action),
            Order::Preload(torque) => self.joints.io().preload(&torque.map(|torque| torque as f32), None),
            Order::Safe(action) => self.joints.io().safe(*action),
        }
        self.serve(measured);
    }

    /// Moves the actuators' shafts to this state of the arm.
    fn turn_shafts(&mut self, measured: &State<N>) {
        for joint in 0..N {
            let JointMount { bus, place, .. } = self.seats[joint];
            let shaft = self.seats[joint].shaft(measured, joint);
            if let Some(actuator) = self.bus(bus).actuators.get_mut(place) {
                actuator.shaft = shaft;
            }
        }
    }

    /// Delivers a frame from a controller outside this program, and returns the replies. Every bus receives it: identifiers are unique.
    pub(crate) fn deliver(&mut self, frame: &Frame, measured: &State<N>) -> Vec<Frame> {
        self.turn_shafts(measured);
        let mut replies = Vec::new();
        for index in 0..BUSES {
            let bus = self.bus(index);
            bus.send(frame.clone());
            bus.serve();
            replies.extend(core::iter::from_fn(|| bus.receive()));
        }
        replies
    }

    /// Lets the commands of a tick arrive, and the actuators measure and reply.
    pub fn serve(&mut self, measured: &State<N>) {
        self.turn_shafts(measured);
        // Each interrupt handles the received frames and sends the next three commands: two interrupts handle all six.
        (0..BUSES).for_each(|bus| self.bus(bus).serve());
        self.joints.io().interrupt();
        (0..BUSES).for_each(|bus| self.bus(bus).exchange());
        self.joints.io().interrupt();
    }

    /// Position and velocity of a joint's actuator shaft at this state of the arm.
    pub fn shaft(&self, state: &State<N>, joint: usize) -> Shaft {
        self.seats.get(joint).map_or(Shaft::default(), |seat| seat.shaft(state, joint))
    }

    /// Number of times that the drives update their torque in this tick.
    pub fn turns(&mut self) -> u32 {
        let follows = |joint| self.electronics(joint).is_some_and(|electronics| electronics.follows_the_shaft());
        if (0..N).any(follows) { self.turns } else { 1 }
    }

    /// Torques on the joints for the next `dt` (s), N m or N, at this state of the arm.
    pub fn torque(&mut self, state: &State<N>, dt: f64) -> [f64; N] {
        core::array::from_fn(|joint| {
            let seat = &self.seats[joint];
            let (ratio, shaft) = (seat.ratio * seat.factor, seat.shaft(state, joint));
            self.electronics(joint).map_or(0.0, |electronics| {
                electronics.pass(dt);
                ratio * electronics.drive(&shaft)
            })
        })
    }

    /// Advances the drives by a control period while the brakes hold the arm.
    pub fn rest(&mut self, state: &State<N>) {
        self.torque(state, self.period);
    }

    /// Counts a tick, and makes a drive fail at its time.
    pub(crate) fn begin_tick(&mut self) {
        let time = self.ticks as f64 * self.period;
        self.ticks += 1;
        // The tolerance prevents a rounding error of the time from delaying the failure by a tick.
        let Some(DriveFailure { joint, kind, .. }) = self.failure.filter(|it| time >= it.at - 1e-9) else { return };
        let bus = self.seats.get(joint).map_or(0, |seat| seat.bus);
        let Some(electronics) = self.electronics(joint) else { return };
        match kind {
            FailureKind::Error => electronics.error = actuator_model::mit::error::OVERLOAD,
            FailureKind::Hot => electronics.temperature = u8::MAX,
            FailureKind::UnderVoltage => electronics.supply = 0.0,
            FailureKind::Unplugged => {
                let id = electronics.id;
                let unplugged = &mut self.bus(bus).unplugged;
                if !unplugged.contains(&id) {
                    unplugged.push(id);
                }
            }
        }
    }
}

impl<const N: usize> Clone for Drives<N> {
    fn clone(&self) -> Self {
        let Self { ref joints, seats, turns, period, failure, ticks } = *self;
        Self { joints: joints.boxed(), seats, turns, period, failure, ticks }
    }
}
