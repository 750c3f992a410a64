//! Parameters that can be read at run time, and those of them that can be changed.
//!
//! A parameter's number is 16 times its joint (counted from 0) plus one of these:
//!
//! | number | parameter | unit | bounds, as multiples of the built-in value |
//! |---|---|---|---|
//! | 0 | position gain | 1/s^2 | 1/4 to 4 |
//! | 1 | velocity gain | 1/s | 1/2 to 2 |
//! | 2 | compensated viscous friction | N m s/rad, N s/m | 0 to 2 |
//! | 3 | compensated Coulomb friction | N m, N | 0 to 2 |
//! | 4 | torque limit | N m, N | fixed |
//! | 5 | largest change of torque in a tick | N m, N | fixed |
//! | 6 | velocity limit | rad/s, m/s | fixed |
//! | 7, 8 | lower and upper position limit | rad, m | fixed |
//! | 9 | position per encoder count | rad, m | fixed |
//! | 10, [`HEAT`] | heat of the motor, 1 at its continuous limit ([`dynamics_core::safety::heat`]); NaN if it is unknown | | read only |
//!
//! Parameters of the whole arm have numbers from 96 on: payload mass (kg), its first moment (kg m, x y z), its inertia about the last link's
//! origin (kg m^2: xx yy zz xy xz yz) and gravity (m/s^2, x y z). These are live inputs; a separate frame sets them together. The payload must
//! be physically possible and within the rules' bounds on mass and size ([`InertiaBounds`]); gravity may be at most [`GRAVITY_MAX`]. The next
//! number is [`LAW`]: the control law, as [`ControlLaw::code`].
//!
//! The first four and the control law can be changed if the scene has `tunable = true` under `[control]`: only then are they in RAM.

use dynamics_core::InertiaBounds;
use dynamics_core::control::{ControlLaw, ControllerConfig, SpringOwner};
use dynamics_core::safety::Rules;
use dynamics_core::scene::Live;
use link::{Refusal, Setting, Value};

/// First number of the parameters of the whole arm.
pub const ARM: u8 = 96;

/// Number of the heat of joint 0; add 16 times the joint. It cannot be set: the safety state machine computes it.
pub const HEAT: u8 = 10;

/// Number of the control law.
pub const LAW: u8 = ARM + 13;

/// Largest gravity that can be set, m/s^2: twice that of the earth, for a base that is accelerated.
pub const GRAVITY_MAX: f32 = 20.0;

/// Names of a joint's parameters, by number.
pub const JOINT_NAMES: [&str; 11] = [
    "position gain",
    "velocity gain",
    "viscous friction",
    "coulomb friction",
    "torque limit",
    "torque step",
    "velocity limit",
    "lower limit",
    "upper limit",
    "position per count",
    "heat",
];

/// Names of the parameters of the whole arm, by number minus [`ARM`].
pub const ARM_NAMES: [&str; 14] = [
    "payload mass",
    "payload first moment x",
    "payload first moment y",
    "payload first moment z",
    "payload inertia xx",
    "payload inertia yy",
    "payload inertia zz",
    "payload inertia xy",
    "payload inertia xz",
    "payload inertia yz",
    "gravity x",
    "gravity y",
    "gravity z",
    "law",
];

/// Returns the name of the parameter with this number, and its joint (counted from 0; `None` for the whole arm).
#[must_use]
pub fn name(index: u8) -> Option<(&'static str, Option<u8>)> {
    match index.checked_sub(ARM) {
        Some(of_arm) => Some((ARM_NAMES.get(usize::from(of_arm))?, None)),
        None => Some((JOINT_NAMES.get(usize::from(index % 16))?, Some(index / 16))),
    }
}

/// A joint's changeable parameter in a configuration; `None` if it is fixed or absent.
fn changeable<const N: usize>(config: &mut ControllerConfig<f32, N>, index: u8) -> Option<&mut f32> {
    let joint = usize::from(index / 16);
    match index % 16 {
        0 => Some(&mut config.gains.get_mut(joint)?.position),
        1 => Some(&mut config.gains.get_mut(joint)?.velocity),
        2 => Some(&mut config.friction.as_mut()?.get_mut(joint)?.viscous),
        3 => Some(&mut config.friction.as_mut()?.get_mut(joint)?.coulomb),
        _ => None,
    }
}

/// Lower and upper bounds of the changeable parameters, as multiples of the built-in values.
const BOUNDS: [(f32, f32); 4] = [(0.25, 4.0), (0.5, 2.0), (0.0, 2.0), (0.0, 2.0)];

/// Returns the value of a parameter, and its bounds if it can be changed. The payload's mass also has bounds, although another frame sets it. A
/// joint's heat is not part of a configuration and is NaN here.
///
/// # Errors
/// [`Refusal::NoParameter`].
pub fn read<const N: usize>(
    index: u8,
    config: &ControllerConfig<f32, N>,
    built_in: &ControllerConfig<f32, N>,
    live: &Live<f32, N>,
    payload: &InertiaBounds<f32>,
    tunable: bool,
) -> Result<Value, Refusal> {
    let value = value(index, config, live).ok_or(Refusal::NoParameter)?;
    let around =
        |built_in: f32| BOUNDS.get(usize::from(index % 16)).map(|(low, high)| (low * built_in, high * built_in));
    let nominal = changeable(&mut built_in.clone(), index).map(|nominal| *nominal);
    let bounds = match index {
        ARM => Some((0.0, payload.mass)),
        LAW => tunable.then_some((0.0, f32::from(ControlLaw::ALL.len() as u8 - 1))),
        _ => nominal.filter(|_| tunable && index < ARM).and_then(around),
    };
    let (low, high) = bounds.unwrap_or((f32::NAN, f32::NAN));
    Ok(Value { index, value, low, high })
}

fn value<const N: usize>(index: u8, config: &ControllerConfig<f32, N>, live: &Live<f32, N>) -> Option<f32> {
    if index == LAW {
        return Some(f32::from(config.law.code()));
    }
    if let Some(of_arm) = index.checked_sub(ARM) {
        let (payload, tensor) = (&live.payload, &live.payload.about_origin);
        let (first, gravity) = (&payload.first_moment, &live.gravity);
        let all = [
            payload.mass,
            first.x,
            first.y,
            first.z,
            tensor.m11,
            tensor.m22,
            tensor.m33,
            tensor.m12,
            tensor.m13,
            tensor.m23,
            gravity.x,
            gravity.y,
            gravity.z,
        ];
        return all.get(usize::from(of_arm)).copied();
    }
    let joint = usize::from(index / 16);
    let (gains, limits) = (config.gains.get(joint)?, config.limits.get(joint)?);
    // Without friction compensation the value is zero.
    let friction = config.friction.as_ref().and_then(|all| all.get(joint));
    Some(match index % 16 {
        0 => gains.position,
        1 => gains.velocity,
        2 => friction.map_or(0.0, |friction| friction.viscous),
        3 => friction.map_or(0.0, |friction| friction.coulomb),
        4 => limits.torque,
        5 => *config.torque_step.get(joint)?,
        6 => limits.velocity,
        7 => limits.position.0,
        8 => limits.position.1,
        9 => config.encoder.get(joint)?.per_count,
        HEAT => f32::NAN,
        _ => return None,
    })
}

/// Checks that a setting is permitted.
///
/// # Errors
/// [`Refusal::NoParameter`], [`Refusal::Fixed`], [`Refusal::OutOfBounds`].
pub fn check<const N: usize>(
    setting: Setting,
    built_in: &ControllerConfig<f32, N>,
    live: &Live<f32, N>,
    payload: &InertiaBounds<f32>,
    tunable: bool,
) -> Result<(), Refusal> {
    let Value { low, high, .. } = read(setting.index, built_in, built_in, live, payload, tunable)?;
    if setting.index == LAW && !low.is_nan() {
        return ControlLaw::from_number(setting.value)
            .filter(|law| is_built_in(*law, built_in))
            .map(|_| ())
            .ok_or(Refusal::OutOfBounds);
    }
    if low.is_nan() || setting.index >= ARM {
        return Err(Refusal::Fixed);
    }
    // False for NaN.
    if setting.value >= low && setting.value <= high { Ok(()) } else { Err(Refusal::OutOfBounds) }
}

/// True if the configuration has all that a control law needs: for hand guiding its parameters, and for a law that uses the drives' springs a
/// built-in law that uses them too.
fn is_built_in<const N: usize>(law: ControlLaw, built_in: &ControllerConfig<f32, N>) -> bool {
    let of_drive = |law: ControlLaw| law.traits().spring == SpringOwner::Drive;
    (!law.is_hand_guided() || built_in.teach.is_some()) && (!of_drive(law) || of_drive(built_in.law))
}

/// Bounds of the live inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveBounds<const N: usize> {
    payload: InertiaBounds<f32>,
    /// Largest reflected rotor inertia of each joint, kg m^2 or kg.
    rotor_max: [f32; N],
}

impl<const N: usize> LiveBounds<N> {
    /// Bounds of these rules.
    pub fn new(rules: &Rules<f32, N>) -> Self {
        Self { payload: rules.payload, rotor_max: rules.joints.each_ref().map(|joint| joint.rotor_max) }
    }
}

/// Checks that live inputs, which must be finite, are within bounds.
///
/// # Errors
/// [`Refusal::OutOfBounds`].
pub fn check_live<const N: usize>(live: &Live<f32, N>, bounds: &LiveBounds<N>) -> Result<(), Refusal> {
    let pull = live.gravity.dot(&live.gravity) <= GRAVITY_MAX * GRAVITY_MAX;
    let mut turn = true;
    for (rotor, rotor_max) in live.rotor.iter().zip(&bounds.rotor_max) {
        turn &= *rotor >= 0.0 && rotor <= rotor_max;
    }
    if pull && turn && live.payload.is_within(&bounds.payload) { Ok(()) } else { Err(Refusal::OutOfBounds) }
}

/// Makes a setting that [`check`] has accepted.
pub fn set<const N: usize>(setting: Setting, config: &mut ControllerConfig<f32, N>) {
    if setting.index == LAW {
        config.law = ControlLaw::from_number(setting.value).unwrap_or(config.law);
    } else if let Some(value) = changeable(config, setting.index) {
        *value = setting.value;
    }
}
