//! Which motor moves which joint, in which direction, and where its zero is: found while a person moves an arm without torque by hand.
//!
//! Positions of Damiao motors come with their states. Positions of RobStride motors are read as parameter 0x7019 while the person moves the arm: this
//! writes nothing. At rest their states are read, too, which writes ([`robstride_motor`](super::robstride_motor)): first the bus is listened to.

use super::adapter::Adapter;
use super::damiao_motor::{DamiaoMotor, FrameRanges, MotorSettings};
use super::motors::{Found, TRIES, Value, search};
use super::robstride_motor::RobStrideMotor;
use super::robstride_parameter::{POWER_UP_RANGE, TORQUE_LIMIT};
use super::robstride_state::state_for_others;
use dynamics_core::drive::Protocol;
use std::f64::consts::PI;
use std::io;
use std::time::Duration;

/// Smallest turn of a motor's shaft that counts as a movement, rad. A loose gear and a trembling hand turn it less.
pub const MOVED: f64 = 0.2;

/// A motor is at rest if it turns less than this in [`STILL_TIME`], rad.
const STILL: f64 = 0.02;
const STILL_TIME: Duration = Duration::from_millis(300);

/// Longest wait for a swinging arm, in such times.
const STILL_TRIES: u32 = 100;

/// Requests for a position before a silent motor is an error, in [`TRIES`]. Hundreds of positions are read while a person works, and a busy computer
/// misses answers for 0.15 s.
const PATIENCE: u32 = 3;

/// A motor moves with another one, as in a coupled wrist or an arm that was bumped, if it turns this share of the largest turn.
const ALSO: f64 = 0.5;

/// Largest turn of a shaft between two readings, rad. A larger one is no movement: the position wrapped at the end of its range, or the motor restarted
/// and shows another turn.
const JUMP: f64 = PI;

/// Position at the end of the frames' range of all RobStride models, rad.
const ROBSTRIDE_POSITION: f64 = 12.57;

/// Largest difference between a RobStride's position in its reply and in its parameter, rad. Firmware whose frames have ±12.5 rad differs by 0.07 rad.
const AGREE: f64 = 0.1;

/// A motor of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftMotor {
    /// Its kind: Damiao or RobStride.
    pub kind: Protocol,
    /// Its identifier.
    pub id: u8,
    /// Identifier of its replies.
    pub reply_id: u32,
    /// Highest position of its frames, rad.
    pub position: f64,
    /// Highest velocity (rad/s) and torque (N m) of its frames; `None` if the motor does not say them.
    pub ranges: Option<[f64; 2]>,
    /// The torque to which it is limited, N m, if the motor says it.
    pub torque_limit: Option<f64>,
    /// Lowest position of the turn that it shows after power-up, rad, if the motor says it.
    pub power_up_lowest: Option<f64>,
}

/// The motors on the bus, of this kind or of whatever kind answers. All are off, and no other program uses them.
///
/// # Errors
/// The adapter is gone; motors of two kinds answer; a motor does not say its ranges, has an error, or is on; another program uses a RobStride motor; two RobStride
/// motors have one identifier.
pub fn motors(adapter: &mut dyn Adapter, kind: Option<Protocol>) -> io::Result<Vec<ShaftMotor>> {
    let mut of = |this: Protocol| match kind.is_none_or(|kind| kind == this) {
        true => Ok(search(adapter, this)?.unwrap_or_default()),
        false => io::Result::Ok(Vec::new()),
    };
    let (damiao, robstride) = (of(Protocol::Damiao)?, of(Protocol::RobStride)?);
    if let ([_, ..], [_, ..]) = (damiao.as_slice(), robstride.as_slice()) {
        let ids = |found: &[Found]| found.iter().map(|it| it.id.to_string()).collect::<Vec<_>>().join(", ");
        return Err(io::Error::other(format!(
            "damiao motors ({}) and robstride motors ({}) answer: expected motors of one kind, or `--kind damiao` or `--kind robstride`",
            ids(&damiao),
            ids(&robstride)
        )));
    }
    let ids: Vec<u8> = robstride.iter().map(|it| it.id).collect();
    reject_others(adapter, &ids)?;
    let mut motors: Vec<ShaftMotor> = damiao.iter().map(|it| damiao_motor(adapter, it)).collect::<io::Result<_>>()?;
    for found in &robstride {
        motors.push(robstride_motor(adapter, found)?);
    }
    positions_at_rest(adapter, &motors)?;
    Ok(motors)
}

fn damiao_motor(adapter: &mut dyn Adapter, found: &Found) -> io::Result<ShaftMotor> {
    let Some(MotorSettings { ranges: FrameRanges { position, velocity, torque }, .. }) =
        DamiaoMotor::new(adapter, found.id).settings()?
    else {
        return Err(io::Error::other(format!("motor {}: it answers no longer", found.id)));
    };
    if let Some(wrong) = [position, velocity, torque].iter().find(|range| !(range.is_finite() && **range > 0.0)) {
        return Err(io::Error::other(format!("motor {}: a range of its frames is {wrong}", found.id)));
    }
    Ok(ShaftMotor {
        kind: Protocol::Damiao,
        id: found.id,
        reply_id: found.reply_id,
        position,
        ranges: Some([velocity, torque]),
        torque_limit: None,
        power_up_lowest: None,
    })
}

fn robstride_motor(adapter: &mut dyn Adapter, found: &Found) -> io::Result<ShaftMotor> {
    let mut motor = RobStrideMotor::new(adapter, found.id);
    // Two motors with one identifier would move as one.
    motor.chip()?;
    let torque_limit = match motor.read(TORQUE_LIMIT)? {
        Some(Value::Float(limit)) if limit.is_finite() => Some(limit.into()),
        _ => None,
    };
    let power_up_lowest = match motor.read(POWER_UP_RANGE)? {
        Some(Value::Integer(0)) => Some(0.0),
        Some(Value::Integer(1)) => Some(-PI),
        _ => None,
    };
    Ok(ShaftMotor {
        kind: Protocol::RobStride,
        id: found.id,
        reply_id: found.reply_id,
        position: ROBSTRIDE_POSITION,
        ranges: None,
        torque_limit,
        power_up_lowest,
    })
}

/// Positions of the motors' shafts, rad. Writes nothing.
///
/// # Errors
/// The adapter is gone; a motor is silent; a Damiao motor has an error, or is on: a motor that gives torque cannot be moved by hand.
pub fn positions(adapter: &mut dyn Adapter, motors: &[ShaftMotor]) -> io::Result<Vec<f64>> {
    let of = |motor: &ShaftMotor| match motor.kind {
        Protocol::RobStride => read_patiently(adapter, motor.id),
        _ => damiao_position(adapter, motor),
    };
    motors.iter().map(of).collect()
}

/// Positions of the motors' shafts once none of them swings any more, as their frames have them in a session, rad.
///
/// # Errors
/// As [`positions`]; the arm does not come to rest; a motor is on, has an error, or is at the end of its range; another program uses a RobStride motor.
pub fn still_positions(adapter: &mut dyn Adapter, motors: &[ShaftMotor]) -> io::Result<Vec<f64>> {
    let mut before = positions(adapter, motors)?;
    for _ in 0..STILL_TRIES {
        std::thread::sleep(STILL_TIME);
        let now = positions(adapter, motors)?;
        if before.iter().zip(&now).all(|(before, now)| (now - before).abs() < STILL) {
            return positions_at_rest(adapter, motors);
        }
        before = now;
    }
    Err(io::Error::other("the arm does not come to rest: hold it still"))
}

/// Positions in the frames of motors that are off, rad.
fn positions_at_rest(adapter: &mut dyn Adapter, motors: &[ShaftMotor]) -> io::Result<Vec<f64>> {
    let robstride = motors.iter().filter(|motor| motor.kind == Protocol::RobStride);
    let ids: Vec<u8> = robstride.map(|motor| motor.id).collect();
    reject_others(adapter, &ids)?;
    let of = |motor: &ShaftMotor| match motor.kind {
        Protocol::RobStride => robstride_position(adapter, motor),
        _ => damiao_position(adapter, motor),
    };
    motors.iter().map(of).collect()
}

/// Fails if another program uses one of these RobStride motors.
fn reject_others(adapter: &mut dyn Adapter, robstride: &[u8]) -> io::Result<()> {
    if robstride.is_empty() {
        return Ok(());
    }
    match state_for_others(adapter, robstride)? {
        Some((id, state)) => Err(is_on(id, &state.text())),
        None => Ok(()),
    }
}

fn is_on(id: u8, state: &str) -> io::Error {
    io::Error::other(format!("motor {id} is {state}: expected motors that are off, and no other program on the bus"))
}

fn has_error(id: u8, state: &str) -> io::Error {
    io::Error::other(format!("motor {id}: {state}: expected a motor without an error (newtau motors clear)"))
}

fn silent(id: u8) -> io::Error {
    io::Error::other(format!("motor {id} does not answer"))
}

fn at_end(id: u8) -> io::Error {
    io::Error::other(format!(
        "motor {id} is at the end of the position range of its frames: turn it back, or make a position near the middle of its joint its zero \
         (newtau motors set-zero)"
    ))
}

fn damiao_position(adapter: &mut dyn Adapter, motor: &ShaftMotor) -> io::Result<f64> {
    let mut damiao = DamiaoMotor::new(adapter, motor.id);
    let state =
        (0..PATIENCE * TRIES).find_map(|_| damiao.state().transpose()).transpose()?.ok_or_else(|| silent(motor.id))?;
    match state.shares[0] {
        _ if state.is_on() => Err(is_on(motor.id, state.text())),
        _ if state.code != 0 => Err(has_error(motor.id, state.text())),
        share if share.abs() < 1.0 => Ok(share * motor.position),
        _ => Err(at_end(motor.id)),
    }
}

/// The position that a RobStride motor's parameter shows, rad.
fn read_patiently(adapter: &mut dyn Adapter, id: u8) -> io::Result<f64> {
    let mut motor = RobStrideMotor::new(adapter, id);
    let first = motor.position();
    (1..PATIENCE).fold(first, |found, _| found.or_else(|_| motor.position()))
}

/// The position in the frames of a RobStride motor that is off. It must be that of its parameter: past the end of the range a frame shows another one.
fn robstride_position(adapter: &mut dyn Adapter, motor: &ShaftMotor) -> io::Result<f64> {
    let mut robstride = RobStrideMotor::new(adapter, motor.id);
    let state = (0..TRIES).find_map(|_| robstride.state_while_unused().transpose()).transpose()?;
    let state = state.ok_or_else(|| silent(motor.id))?;
    if !state.is_off() {
        return Err(is_on(motor.id, &state.text()));
    }
    if state.error != 0 {
        return Err(has_error(motor.id, &state.text()));
    }
    let position = state.share.ok_or_else(|| at_end(motor.id))? * motor.position;
    let parameter = read_patiently(adapter, motor.id)?;
    if (position - parameter).abs() < AGREE {
        return Ok(position);
    }
    Err(io::Error::other(format!(
        "motor {}: its position is {position:.2} rad in its frames and {parameter:.2} rad in its parameter 0x7019: it has turned past the end of its \
         frames' range (±{} rad), or its frames have another range. Turn it back, or switch its power off and on",
        motor.id, motor.position
    )))
}

/// The first motor whose position jumped between two readings, by its index: no hand turns a shaft so fast.
#[must_use]
pub fn jumped(before: &[f64], after: &[f64]) -> Option<usize> {
    before.iter().zip(after).position(|(before, after)| (after - before).abs() > JUMP)
}

/// Motors that have moved between two readings.
#[derive(Clone, Debug, PartialEq)]
pub enum Movement {
    /// None, or only a little.
    None,
    /// One: its index, and how far its shaft turned, rad.
    One(usize, f64),
    /// More than one, by their indices: it is not clear which one was meant.
    Several(Vec<usize>),
}

/// The motor that was moved. Motors in `taken` already have a joint; they may hang and move a little, but not as much as the one that is meant.
#[must_use]
pub fn moved(before: &[f64], after: &[f64], taken: &[usize]) -> Movement {
    let turns: Vec<f64> = before.iter().zip(after).map(|(before, after)| after - before).collect();
    let most = turns.iter().map(|turn| turn.abs()).fold(0.0, f64::max);
    if most < MOVED {
        return Movement::None;
    }
    let all: Vec<usize> = (0..turns.len()).filter(|&motor| turns[motor].abs() >= (ALSO * most).max(MOVED)).collect();
    match all.as_slice() {
        [one] if !taken.contains(one) => Movement::One(*one, turns[*one]),
        _ => Movement::Several(all),
    }
}

/// Position of the shaft where the joint is at zero, rad, from a pose in which the joint is at `q` (rad or m) and its shaft at `shaft`. `gear` is in shaft
/// rad per joint rad or m.
#[must_use]
pub fn zero(shaft: f64, direction: f64, gear: f64, q: f64) -> f64 {
    shaft - direction * gear * q
}

#[cfg(test)]
mod tests;
