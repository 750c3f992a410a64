//! Inputs of a kernel: their names, their order and their values.

use super::program::Program;
use dynamics_core::{Live, Real, Reference, Scalar, SinCos};

/// Inputs for each joint, in this order; the live inputs follow, and then those of [`REFERENCE`].
pub(crate) const PER_JOINT: [&str; 6] = ["turn[].sin", "turn[].cos", "q[]", "qd[]", "qdd[]", "tau[]"];

/// The last inputs, for each joint: the law reads them instead of the desired acceleration.
pub(crate) const REFERENCE: [&str; 3] = ["reference.q[]", "reference.qd[]", "reference.qdd[]"];

/// Live inputs that occur once; the rotors follow, one per joint.
pub(crate) const LIVE: [&str; 19] = [
    "live.gravity.x",
    "live.gravity.y",
    "live.gravity.z",
    "live.tip_wrench.force.x",
    "live.tip_wrench.force.y",
    "live.tip_wrench.force.z",
    "live.tip_wrench.moment.x",
    "live.tip_wrench.moment.y",
    "live.tip_wrench.moment.z",
    "live.payload.mass",
    "live.payload.first_moment.x",
    "live.payload.first_moment.y",
    "live.payload.first_moment.z",
    "live.payload.about_origin.m11",
    "live.payload.about_origin.m22",
    "live.payload.about_origin.m33",
    "live.payload.about_origin.m12",
    "live.payload.about_origin.m13",
    "live.payload.about_origin.m23",
];

/// The Rust expression of an input in the arguments of `InverseDynamics::inverse_dynamics`, of forward dynamics, and of
/// `computed_torque`.
#[must_use]
pub(crate) fn input_name(number: u32, joints: usize) -> String {
    let per_joint = |names: &[&str], number: usize| {
        names.get(number / joints).map(|name| name.replace("[]", &format!("[{}]", number % joints)))
    };
    let number = number as usize;
    if let Some(name) = per_joint(&PER_JOINT, number) {
        return name;
    }
    if let Some(name) = number.checked_sub(input_count(joints)).and_then(|number| per_joint(&REFERENCE, number)) {
        return name;
    }
    let live = number - PER_JOINT.len() * joints;
    LIVE.get(live).map_or_else(|| format!("live.rotor[{}]", live - LIVE.len()), |name| (*name).to_owned())
}

/// The argument that contains an input.
#[must_use]
pub const fn argument(number: u32, joints: usize) -> &'static str {
    match number as usize / joints {
        0 | 1 => "turn",
        2 => "q",
        3 => "qd",
        4 => "qdd",
        5 => "tau",
        _ if number as usize >= input_count(joints) => "reference",
        _ => "live",
    }
}

/// Number of live inputs that a program reads, for an arm with `joints` joints.
#[must_use]
pub fn live_inputs(program: &Program, joints: usize) -> usize {
    program.inputs().into_iter().filter(|&number| argument(number, joints) == "live").count()
}

/// Input values in the order of their numbers, for every function except forward dynamics and the law. For the law, those
/// of [`reference_values`] follow.
#[must_use]
pub fn input_values<S: Scalar, const N: usize>(
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    qdd: &[S; N],
    live: &Live<S, N>,
) -> Vec<S> {
    let mut values = Vec::new();
    write_input_values(&mut values, turn, [q, qd, qdd, &[S::zero(); N]], live);
    values
}

/// As [`input_values`], for forward dynamics, which reads torques instead of accelerations.
#[must_use]
pub fn forward_input_values<S: Scalar, const N: usize>(
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    tau: &[S; N],
    live: &Live<S, N>,
) -> Vec<S> {
    let mut values = Vec::new();
    write_input_values(&mut values, turn, [q, qd, &[S::zero(); N], tau], live);
    values
}

/// As the two functions above, into a list that is reused: `joints` are `q`, `qd`, `qdd` and `tau`.
pub(crate) fn write_input_values<S: Scalar, const N: usize>(
    values: &mut Vec<S>,
    turn: &[SinCos<S>; N],
    joints: [&[S; N]; 4],
    live: &Live<S, N>,
) {
    let Live { gravity, payload, tip_wrench, rotor } = live;
    let j = &payload.about_origin;
    values.clear();
    values.extend(turn.iter().map(|t| t.sin));
    values.extend(turn.iter().map(|t| t.cos));
    values.extend(joints.into_iter().flatten());
    values.extend_from_slice(gravity.as_slice());
    values.extend_from_slice(tip_wrench.force.as_slice());
    values.extend_from_slice(tip_wrench.moment.as_slice());
    values.push(payload.mass);
    values.extend_from_slice(payload.first_moment.as_slice());
    values.extend([j.m11, j.m22, j.m33, j.m12, j.m13, j.m23]);
    values.extend(rotor);
}

/// Number of inputs before those of the reference.
pub(crate) const fn input_count(joints: usize) -> usize {
    (PER_JOINT.len() + 1) * joints + LIVE.len()
}

/// The values of the inputs that follow [`input_values`], for [`ComputedTorque`](crate::kernel::Function::ComputedTorque).
#[must_use]
pub fn reference_values<S: Real, const N: usize>(reference: &Reference<S, N>) -> Vec<S> {
    reference.q.iter().chain(&reference.qd).chain(&reference.qdd).copied().collect()
}
