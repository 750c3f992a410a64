//! Mounting of a simulated drive: its bus, the gearing between its shaft and the joint, and its actuator as the robot file describes it.

use super::State;
use actuator_model::mit::{Actuator, Language, Ranges, Shaft};
use joint_io::can::BUSES;
use robot_compiler::drive::MitSpec;

/// Temperature of a healthy drive, degrees Celsius.
const TEMPERATURE: f64 = 25.0;

/// Supply voltage of every drive, and the lowest at which it works, V: typical of a 24 V drive.
const SUPPLY: f64 = 24.0;
const SUPPLY_MIN: f64 = 15.0;

/// Location of a joint's actuator, and the joint's gearing.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointMount {
    pub(super) bus: usize,
    pub(super) place: usize,
    pub(super) ratio: f64,
    zero: f64,
    /// True torque over the torque in the frames.
    pub(super) factor: f64,
}

impl JointMount {
    /// Adds the actuator of a joint to its bus.
    pub(super) fn new(spec: &MitSpec, actuators: &mut [Vec<Actuator>; BUSES]) -> Self {
        let bus = usize::from(spec.bus.saturating_sub(1)).min(BUSES - 1);
        let mount = Self { bus, place: actuators[bus].len(), ratio: spec.ratio, zero: spec.zero, factor: 1.0 };
        actuators[bus].push(actuator(spec));
        mount
    }

    /// The shaft at this state of the arm.
    pub(super) fn shaft<const N: usize>(&self, state: &State<N>, joint: usize) -> Shaft {
        Shaft { position: self.ratio * state.q[joint] + self.zero, velocity: self.ratio * state.qd[joint] }
    }
}

/// The actuator of a joint, without a fault and off.
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
