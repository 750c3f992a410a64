//! Which motor moves which joint, in which direction, and where its zero is: found while a person moves an arm without torque by hand.

use super::adapter::Adapter;
use super::damiao_motor::{DamiaoMotor, FrameRanges, MotorSettings};
use super::motors::search;
use dynamics_core::drive::Protocol;
use std::io;
use std::time::Duration;

/// Smallest turn of a motor's shaft that counts as a movement, rad. A loose gear and a trembling hand turn it less.
pub const MOVED: f64 = 0.2;

/// A motor is at rest if it turns less than this in [`STILL_TIME`], rad.
const STILL: f64 = 0.02;
const STILL_TIME: Duration = Duration::from_millis(300);

/// Longest wait for a swinging arm, in such times.
const STILL_TRIES: u32 = 100;

/// Readings of a motor that is silent before that is an error.
const TRIES: u32 = 3;

/// A motor moves with another one, as in a coupled wrist or an arm that was bumped, if it turns this share of the largest turn.
const ALSO: f64 = 0.5;

/// A motor of an arm, off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftMotor {
    /// Its identifier.
    pub id: u8,
    /// Identifier of its replies.
    pub reply_id: u32,
    /// Highest position (rad), velocity (rad/s) and torque (N m) of its frames.
    pub ranges: [f64; 3],
}

/// The Damiao motors on the bus.
///
/// # Errors
/// The adapter is gone; a motor does not say its ranges.
pub fn motors(adapter: &mut dyn Adapter) -> io::Result<Vec<ShaftMotor>> {
    let found = search(adapter, Protocol::Damiao)?.unwrap_or_default();
    let of = |found: &super::motors::Found| {
        let settings = DamiaoMotor::new(adapter, found.id).settings()?;
        let Some(MotorSettings { ranges: FrameRanges { position, velocity, torque }, .. }) = settings else {
            return Err(io::Error::other(format!("motor {}: it answers no longer", found.id)));
        };
        let ranges = [position, velocity, torque];
        match ranges.iter().find(|range| !(range.is_finite() && **range > 0.0)) {
            Some(wrong) => Err(io::Error::other(format!("motor {}: a range of its frames is {wrong}", found.id))),
            None => Ok(ShaftMotor { id: found.id, reply_id: found.reply_id, ranges }),
        }
    };
    found.iter().map(of).collect()
}

/// Positions of the motors' shafts, rad.
///
/// # Errors
/// The adapter is gone; a motor is silent, or on: a motor that gives torque cannot be moved by hand.
pub fn positions(adapter: &mut dyn Adapter, motors: &[ShaftMotor]) -> io::Result<Vec<f64>> {
    let mut of = |motor: &ShaftMotor| {
        for _ in 1..TRIES {
            if let Some(position) = position(adapter, motor)? {
                return Ok(position);
            }
        }
        position(adapter, motor)?.ok_or_else(|| io::Error::other(format!("motor {} does not answer", motor.id)))
    };
    motors.iter().map(&mut of).collect()
}

/// Positions of the motors' shafts once none of them swings any more, rad.
///
/// # Errors
/// As [`positions`]; the arm does not come to rest.
pub fn still_positions(adapter: &mut dyn Adapter, motors: &[ShaftMotor]) -> io::Result<Vec<f64>> {
    let mut before = positions(adapter, motors)?;
    for _ in 0..STILL_TRIES {
        std::thread::sleep(STILL_TIME);
        let now = positions(adapter, motors)?;
        if before.iter().zip(&now).all(|(before, now)| (now - before).abs() < STILL) {
            return Ok(now);
        }
        before = now;
    }
    Err(io::Error::other("the arm does not come to rest: hold it still"))
}

/// Position of a motor's shaft, rad; `None` if it does not answer.
fn position(adapter: &mut dyn Adapter, motor: &ShaftMotor) -> io::Result<Option<f64>> {
    match DamiaoMotor::new(adapter, motor.id).state()? {
        None => Ok(None),
        Some(state) if state.is_on() => {
            Err(io::Error::other(format!("motor {} is on: expected motors that are off", motor.id)))
        }
        Some(state) => Ok(Some(state.shares[0] * motor.ranges[0])),
    }
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
mod tests {
    use super::{Movement, moved, zero};

    #[test]
    fn the_motor_that_moves_alone_is_the_one_and_otherwise_nobody_guesses() {
        let before = [0.0, 1.0, -2.0];
        assert_eq!(moved(&before, &[0.15, 1.0, -2.0], &[]), Movement::None);
        let one = moved(&before, &[0.02, 1.0, -2.5], &[]);
        assert!(matches!(one, Movement::One(2, by) if (by + 0.5).abs() < 1e-12), "{one:?}");
        assert_eq!(moved(&before, &[0.3, 1.0, -2.5], &[]), Movement::Several(vec![0, 2]));
        assert_eq!(moved(&before, &[0.0, 1.0, -2.5], &[2]), Movement::Several(vec![2]), "it has a joint already");
        // A joint with a motor already hangs and swings a little.
        assert!(matches!(moved(&before, &[0.12, 1.0, -2.5], &[0]), Movement::One(2, _)));
    }

    #[test]
    fn the_zero_is_where_the_formula_of_the_robot_file_has_it() {
        for (direction, gear, q, at_zero) in [(1.0, 1.0, 0.5, 0.2), (-1.0, 6.0, -1.2, 3.0), (-1.0, 1.0, 0.0, 0.7)] {
            let shaft = direction * gear * q + at_zero;
            assert!((zero(shaft, direction, gear, q) - at_zero).abs() < 1e-12);
        }
    }
}
