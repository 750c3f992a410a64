//! Simulated drives: the board's own access to the joints ([`CanJoints`]), three CAN buses, and an actuator at every joint.
//!
//! ```text
//! tick k:  measure: replies to the commands of tick k-1 | controller | commands arrive, actuators measure and reply | the arm moves
//! ```
//!
//! Commands arrive in the instant in which the tick begins, so a measurement is one period old when the controller gets it. The
//! actuator's shaft is the joint, through the gearing: `p = ratio q + zero`, `v = ratio qd`, `tau = ratio tau_shaft`, here in the robot
//! file's double precision. The controller's side has the chip's numbers. An actuator renews the torque of its own position
//! and velocity loop several times a tick; without stiffness and damping it is constant from frame to frame.

use super::{Clock, State};
use actuator_model::bus::{Bus, Fate};
use actuator_model::frame::Frame;
use actuator_model::mit::{Actuator, Electronics, Language, Ranges, Shaft};
use core::convert::Infallible;
use dynamics_core::control::Spring;
use dynamics_core::drive::MitDrive;
use dynamics_core::safety::SafeAction;
use dynamics_core::with_drive_kinds;
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use embedded_hal::digital::{ErrorType, OutputPin};
use joint_io::JointIo;
use joint_io::can::{BUSES, CanJoints};
use joint_io::can_bus::CanBus;
use joint_io::queued::Queued;
use robot_compiler::drive::{MitSpec, Protocol};
use robot_compiler::scene::{DriveFailure, FailureKind};
use session::readings::Readings;

/// Temperature of a drive that is well, degrees Celsius.
const TEMPERATURE: f64 = 25.0;

/// Supply voltage of every drive, V, and the lowest that it works with: numbers of a drive for 24 V.
const SUPPLY: f64 = 24.0;
const SUPPLY_MIN: f64 = 15.0;

/// Exchanges until drives are on, at most: three about each drive's timeout, one drive at a time, and three until it is on.
const ENABLING_MAX: u32 = 100;

/// The joints of an arm whose drives are of the kind `K`.
type JointsOf<K, const N: usize> = CanJoints<K, Queued<Line>, Queued<Line>, Queued<Line>, BrakeLine, N>;

macro_rules! joints_of {
    ($($kind:ident)*) => {
        /// The board's access to the joints, for each kind of drive.
        #[derive(Clone, Debug)]
        enum Joints<const N: usize> {
            $($kind(JointsOf<dynamics_core::drive::$kind, N>),)*
        }

        impl<const N: usize> Joints<N> {
            fn new(protocol: Protocol, lines: [Line; BUSES], wires: [MitDrive; N]) -> Self {
                let buses = lines.map(Queued::new).into();
                match protocol {
                    $(Protocol::$kind => Self::$kind(CanJoints::new(buses, BrakeLine::default(), wires)),)*
                }
            }

            fn io(&mut self) -> &mut dyn JointIo<N> {
                match self {
                    $(Self::$kind(joints) => joints,)*
                }
            }

            fn buses(&mut self) -> (&mut Queued<Line>, &mut Queued<Line>, &mut Queued<Line>) {
                match self {
                    $(Self::$kind(joints) => joints.buses(),)*
                }
            }

            fn brake(&self) -> &BrakeLine {
                match self {
                    $(Self::$kind(joints) => joints.brake(),)*
                }
            }
        }
    };
}

with_drive_kinds!(joints_of);

/// The drives of an arm.
#[derive(Clone, Debug)]
pub struct Drives<const N: usize> {
    joints: Joints<N>,
    seats: [JointMount; N],
    /// Turns of the actuators' own loop in a tick.
    turns: u32,
    period: f64,
    failure: Option<DriveFailure>,
    /// Ticks driven or stopped.
    ticks: u64,
}

/// Place of a joint's actuator, and the joint's gearing.
#[derive(Clone, Copy, Debug)]
struct JointMount {
    bus: usize,
    place: usize,
    ratio: f64,
    zero: f64,
    /// True torque, as a multiple of what the frames say.
    factor: f64,
}

/// Command to all drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order<const N: usize> {
    /// These torques or forces, N m or N, and springs for the drives' own loops.
    Torque([f64; N], Option<[Spring<f32>; N]>),
    /// The drives are enabled with engaged brakes; where the action is a damped stop, those that are on damp.
    Enable(SafeAction),
    /// These torques or forces, N m or N, with engaged brakes.
    Preload([f64; N]),
    /// The safe action.
    Safe(SafeAction),
}

impl<const N: usize> Drives<N> {
    /// Drives that are off: as the robot file has them, and as the chip has them. `loop_rate` is that of their own loop, Hz; a tick
    /// holds the nearest whole number of its turns.
    #[must_use]
    pub fn new(specs: &[MitSpec; N], wires: [MitDrive; N], clock: Clock, loop_rate: f64) -> Self {
        let mut actuators = [const { Vec::new() }; BUSES];
        let seats = specs.map(|spec| {
            let bus = usize::from(spec.bus.saturating_sub(1)).min(BUSES - 1);
            let seat = JointMount { bus, place: actuators[bus].len(), ratio: spec.ratio, zero: spec.zero, factor: 1.0 };
            actuators[bus].push(actuator(&spec));
            seat
        });
        // Loading has checked that all drives are of one kind.
        let protocol = specs.first().map_or(Protocol::MiniCheetah, |spec| spec.protocol);
        let lines = actuators.map(|actuators| Line(Bus::forgetful(actuators)));
        Self {
            joints: Joints::new(protocol, lines, wires),
            seats,
            // The cast saturates.
            turns: ((clock.period * loop_rate).round() as u32).max(1),
            period: clock.period,
            failure: None,
            ticks: 0,
        }
    }

    /// The same drives, of which one fails at some time.
    #[must_use]
    pub fn with_failure(self, failure: Option<DriveFailure>) -> Self {
        Self { failure, ..self }
    }

    /// The same drives, whose true torques are so many times what their frames say; no factors: once.
    #[must_use]
    pub fn with_torque_factors(mut self, factors: &[f64]) -> Self {
        self.seats.iter_mut().zip(factors).for_each(|(seat, factor)| seat.factor = *factor);
        self
    }

    /// Electronics of a joint's actuator, to look at or to break.
    pub fn electronics(&mut self, joint: usize) -> Option<&mut Electronics> {
        let JointMount { bus, place, .. } = *self.seats.get(joint)?;
        Some(&mut self.bus(bus).actuators.get_mut(place)?.electronics)
    }

    /// Torque that a joint's drive gave last, at the joint, N m or N.
    pub fn given(&mut self, joint: usize) -> f64 {
        let factor = self.seats.get(joint).map_or(0.0, |seat| seat.ratio * seat.factor);
        self.electronics(joint).map_or(0.0, |electronics| factor * electronics.torque())
    }

    /// Bus of a joint's drive, and the drive's identifier there.
    pub fn address(&mut self, joint: usize) -> Option<(usize, u16)> {
        let bus = self.seats.get(joint)?.bus;
        Some((bus, self.electronics(joint)?.id))
    }

    /// One of the buses, counted from 0.
    pub fn bus(&mut self, bus: usize) -> &mut Bus {
        let (first, second, third) = self.joints.buses();
        let queued = match bus {
            0 => first,
            1 => second,
            _ => third,
        };
        &mut queued.bus().0
    }

    /// Disturbs the frames of a joint's drive until the next call: a deaf drive hears nothing and says nothing. `replies` are the
    /// fates of its next reply; the first that is true counts.
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

    /// Readings of the replies since the last call, and their highest temperature, degrees Celsius.
    pub fn measure(&mut self) -> (Option<Readings<N>>, Option<f32>) {
        (self.joints.io().measure(), self.joints.io().temperature())
    }

    /// Enables the drives while something else holds the arm, without any time: exchanges until each has shown that it is on, or
    /// [`ENABLING_MAX`] of them.
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

    /// The board's way to the joints. What it sends arrives with [`Drives::serve`].
    pub fn board(&mut self) -> &mut dyn JointIo<N> {
        self.joints.io()
    }

    /// Send a tick's commands. The actuators take them at once, and reply with the state that they measure.
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

    /// Let the commands of a tick arrive, and the actuators measure and reply.
    pub fn serve(&mut self, measured: &State<N>) {
        for joint in 0..N {
            let JointMount { bus, place, .. } = self.seats[joint];
            let shaft = self.seats[joint].shaft(measured, joint);
            if let Some(actuator) = self.bus(bus).actuators.get_mut(place) {
                actuator.shaft = shaft;
            }
        }
        // Each interrupt takes what has come, and hands on the next three commands: two are all six.
        (0..BUSES).for_each(|bus| self.bus(bus).serve());
        self.joints.io().interrupt();
        (0..BUSES).for_each(|bus| self.bus(bus).exchange());
        self.joints.io().interrupt();
    }

    /// Shaft of a joint's actuator at this state of the arm.
    pub fn shaft(&self, state: &State<N>, joint: usize) -> Shaft {
        self.seats.get(joint).map_or(Shaft::default(), |seat| seat.shaft(state, joint))
    }

    /// Number of times that the drives renew their torque in this tick.
    pub fn turns(&mut self) -> u32 {
        let follows = |joint| self.electronics(joint).is_some_and(|electronics| electronics.follows_the_shaft());
        if (0..N).any(follows) { self.turns } else { 1 }
    }

    /// Torques on the joints for the next `dt` (s), N m or N, at this state.
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

    /// Let a period pass while the brakes hold the arm.
    pub fn rest(&mut self, state: &State<N>) {
        self.torque(state, self.period);
    }

    /// Count a tick, and let a drive fail when its time has come.
    pub(crate) fn begin_tick(&mut self) {
        let time = self.ticks as f64 * self.period;
        self.ticks += 1;
        // A rounding error of the sum of ticks is no tick.
        let Some(DriveFailure { joint, kind, .. }) = self.failure.filter(|it| time >= it.at - 1e-9) else { return };
        let bus = self.seats.get(joint).map_or(0, |seat| seat.bus);
        let Some(electronics) = self.electronics(joint) else { return };
        match kind {
            FailureKind::Error => electronics.error = actuator_model::mit::error::OVERLOAD,
            FailureKind::Hot => electronics.temperature = u8::MAX,
            FailureKind::UnderVoltage => electronics.supply = 0.0,
            FailureKind::Unplugged => {
                let id = electronics.id;
                self.bus(bus).unplugged = vec![id];
            }
        }
    }
}

impl JointMount {
    /// The shaft at this state of the arm.
    fn shaft<const N: usize>(&self, state: &State<N>, joint: usize) -> Shaft {
        Shaft { position: self.ratio * state.q[joint] + self.zero, velocity: self.ratio * state.qd[joint] }
    }
}

/// The actuator of a joint, well and off.
fn actuator(spec: &MitSpec) -> Actuator {
    let MitSpec { id, reply_id, reply_bytes, temperature_offset, position, velocity, kp, kd, torque, .. } = *spec;
    let mut actuator = Actuator::new(u16::from(id), Ranges { position, velocity, kp, kd, torque });
    let language = Language::named(spec.protocol.facts().name).unwrap_or_default();
    actuator.electronics = actuator.electronics.speaking(language);
    let electronics = &mut actuator.electronics;
    (electronics.reply_id, electronics.reply_bytes) = (reply_id, usize::from(reply_bytes));
    // The cast saturates.
    electronics.temperature = (TEMPERATURE - temperature_offset.unwrap_or(0.0)).round() as u8;
    (electronics.supply, electronics.supply_range) = (SUPPLY, (SUPPLY_MIN, f64::INFINITY));
    actuator
}

/// The line to the brakes: high opens them.
#[derive(Clone, Copy, Debug, Default)]
struct BrakeLine {
    open: bool,
}

impl ErrorType for BrakeLine {
    type Error = Infallible;
}

impl OutputPin for BrakeLine {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.open = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.open = true;
        Ok(())
    }
}

/// A bus as the board's driver has it.
#[derive(Clone, Debug)]
struct Line(Bus);

impl Can for Line {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        Can::transmit(&mut self.0, frame)
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        Can::receive(&mut self.0)
    }
}

impl CanBus for Line {
    fn is_off(&mut self) -> bool {
        self.0.off
    }

    fn abandon(&mut self) {
        self.0.abandon();
    }
}
