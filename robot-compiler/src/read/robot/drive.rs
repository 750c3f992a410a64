//! The `[joint.drive]` tables of a robot file.

use super::actuators;
use crate::describe::diagnostics::{FileError, nearest};
use crate::describe::drive::{Actuator, ENCODER_COUNTS, JointDrive, MitSpec, Protocol, PwmSpec};
use crate::describe::robot::JointEncoder;
use crate::read::table::{Table, Value};
use dynamics_core::drive::bus_time::Identifier;
use dynamics_core::drive::{DataRate, DriveFacts};
use dynamics_core::{Limits, Rotor};

/// Most buses of a board.
const BUSES: u64 = 3;

/// One joint's drive.
pub(super) fn read(
    table: &Table<'_>,
    limits: &Limits<f64>,
    rotor: &Rotor,
    encoder: Option<&JointEncoder>,
) -> Result<JointDrive, FileError> {
    let mut kinds: Vec<_> = Protocol::ALL.iter().map(|protocol| (protocol.facts().name, Some(*protocol))).collect();
    // Kinds without a protocol are H-bridges; the kind `mit` uses the mini-cheetah's frames.
    kinds.extend([("pwm", None), ("mini-cheetah", Some(Protocol::MiniCheetah))]);
    match table.require("kind", "mit, damiao, robstride, myactuator or pwm")?.choice(&kinds)? {
        Some(protocol) => mit(table, protocol, limits).map(JointDrive::Mit),
        None => pwm(table, limits, rotor, encoder).map(JointDrive::Pwm),
    }
}

/// Default identifier of the host to which a RobStride replies: that of the maker's tools.
const HOST: u64 = 0xfd;

fn mit(table: &Table<'_>, protocol: Protocol, limits: &Limits<f64>) -> Result<MitSpec, FileError> {
    let DriveFacts { identifier, reply_varies, ranges_vary, reply_offset, ids, .. } = protocol.facts();
    let extended = identifier == Identifier::Extended;
    let of_address: &[&str] = match reply_offset {
        _ if extended => &["host_id"],
        // Such a protocol has no FD frames either.
        Some(_) => &[],
        None => &["data_rate", "reply_id"],
    };
    let of_reply: &[&str] = if reply_varies { &["reply_bytes", "temperature_offset"] } else { &[] };
    let of_table: &[&str] = if ranges_vary { &[] } else { &["actuator"] };
    const ALWAYS: [&str; 12] =
        ["kind", "bus", "id", "direction", "gear", "zero", "position", "velocity", "kp", "kd", "torque", "damping"];
    if ranges_vary && table.get("actuator").is_some() {
        let problem = format!("no actuator of the kind {} has a name", protocol.facts().name);
        let expected = "`position`, `velocity`, `kp`, `kd` and `torque` as this drive's firmware has them: they depend on its date, and a wrong \
                        torque range gives another torque";
        return Err(table.error("actuator", problem, expected));
    }
    table.only(&[&ALWAYS, of_address, of_reply, of_table].concat())?;
    let actuator = table.get("actuator").map(|value| actuator(&value, protocol)).transpose()?;
    let actuator = actuator.as_ref();
    let whole = |key, lo: u64, hi: u64, default: Option<u64>, expected: &str| {
        let value = match (table.get(key), default) {
            (None, Some(default)) => return Ok(default),
            _ => table.require(key, expected)?,
        };
        let number = value.whole(hi, expected)?;
        if number < lo { Err(value.error(format!("found {number}"), expected)) } else { Ok(number) }
    };
    let ratio = ratio(table, 1.0)?;
    let (reply_bytes, temperature_offset) = if reply_varies {
        const BYTES: &str = "bytes of a reply: 6, 7 with a temperature, 8 with an error too";
        let bytes = whole("reply_bytes", 6, 8, Some(6), BYTES)? as u8;
        (bytes, temperature_offset(table, bytes)?)
    } else {
        // A reply to a MyActuator's command has no temperature.
        (8, reply_offset.is_none().then_some(0.0))
    };
    let id = match ids {
        (0, u8::MAX) => whole("id", 0, 255, None, "the identifier of its commands, 0 to 255")?,
        (lo, hi) => {
            let expected = format!("the identifier of the drive, {lo} to {hi}");
            whole("id", u64::from(lo), u64::from(hi), None, &expected)?
        }
    };
    let reply_id = if let Some(offset) = reply_offset {
        u64::from(offset) + id
    } else if extended {
        whole("host_id", 0, 255, Some(HOST), "the identifier of the host that it replies to, 0 to 255")?
    } else {
        whole("reply_id", 0, 0x7ff, Some(0), "the identifier of its replies, 0 to 2047")?
    };
    let symmetric = |of: fn(&Actuator) -> f64| actuator.map(|actuator| (-of(actuator), of(actuator)));
    let from_zero = |of: fn(&Actuator) -> f64| actuator.map(|actuator| (0.0, of(actuator)));
    let around = |lo: f64, hi: f64| lo < 0.0 && hi > 0.0;
    let above = |lo: f64, hi: f64| lo == 0.0 && hi > 0.0;
    const ZERO: &str = "the actuator's position where the joint's is 0, rad";
    let spec = MitSpec {
        protocol,
        bus: whole("bus", 1, BUSES, None, "the bus, 1 to 3")? as u8,
        data_rate: table.get("data_rate").map(|value| data_rate(&value)).transpose()?,
        id: id as u8,
        reply_id: reply_id as u16,
        reply_bytes,
        temperature_offset,
        ratio,
        zero: table.get("zero").map_or(Ok(0.0), |value| value.finite(ZERO))?,
        position: span(
            table,
            "position",
            symmetric(|a| a.position),
            "[lowest, highest] at the actuator's shaft in rad, with 0 inside",
            around,
        )?,
        velocity: span(
            table,
            "velocity",
            symmetric(|a| a.velocity),
            "[lowest, highest] at the actuator's shaft in rad/s, with 0 inside",
            around,
        )?,
        kp: span(table, "kp", from_zero(|a| a.kp), "[0, highest] at the actuator's shaft in N m/rad", above)?,
        kd: span(table, "kd", from_zero(|a| a.kd), "[0, highest] at the actuator's shaft in N m s/rad", above)?,
        torque: span(
            table,
            "torque",
            symmetric(|a| a.torque),
            "[lowest, highest] at the actuator's shaft in N m, with 0 inside",
            around,
        )?,
        damping: {
            const EXPECTED: &str =
                "damping of a damped stop at the actuator's shaft, N m s/rad, inside the range of kd";
            table.require("damping", EXPECTED)?.not_negative(EXPECTED)?
        },
    };
    if spec.damping > spec.kd.1 {
        let problem = format!("found {}, the range of kd ends at {}", spec.damping, spec.kd.1);
        return Err(table.error("damping", problem, "damping inside the range of kd"));
    }
    covers(table, limits, &spec)?;
    Ok(spec)
}

/// The bit rate of the data of FD frames.
fn data_rate(value: &Value<'_>) -> Result<DataRate, FileError> {
    const EXPECTED: &str = "bits per second of the data of FD frames, 2000000 or 5000000; no key for classic frames";
    let found = value.whole(u64::from(u32::MAX), EXPECTED)?;
    let rate = DataRate::ALL.into_iter().find(|rate| u64::from(rate.bits_per_second()) == found);
    rate.ok_or_else(|| value.error(format!("found {found}"), EXPECTED))
}

/// Makers use different temperatures for code 0: without the offset a hot motor may look cool.
fn temperature_offset(table: &Table<'_>, reply_bytes: u8) -> Result<Option<f64>, FileError> {
    const EXPECTED: &str = "the temperature of code 0 in its replies, degrees Celsius, -300 to 300";
    match table.get("temperature_offset") {
        Some(value) if reply_bytes < 7 => {
            Err(value
                .error("replies of 6 bytes have no temperature", "`reply_bytes` 7 or 8, or no `temperature_offset`"))
        }
        None if reply_bytes < 7 => Ok(None),
        _ => {
            let value = table.require("temperature_offset", EXPECTED)?;
            let offset = value.finite(EXPECTED)?;
            if offset.abs() > 300.0 { Err(value.error(format!("found {offset}"), EXPECTED)) } else { Ok(Some(offset)) }
        }
    }
}

/// The joint's limits must fit into the frames: a value beyond a range would be clipped silently.
fn covers(table: &Table<'_>, limits: &Limits<f64>, spec: &MitSpec) -> Result<(), FileError> {
    let within = |key: &str, x: f64, (lo, hi): (f64, f64), unit: &str, expected: &str| {
        if lo <= x && x <= hi {
            return Ok(());
        }
        let problem = format!("the joint's limit is {x} {unit} at the actuator, the range is [{lo}, {hi}]");
        Err(table.error(key, problem, expected))
    };
    for q in [limits.position.0, limits.position.1] {
        let expected = "a range with both position limits of the joint inside";
        within("position", spec.ratio * q + spec.zero, spec.position, "rad", expected)?;
    }
    for sign in [-1.0, 1.0] {
        let expected = "a range with the joint's velocity limit inside";
        within("velocity", sign * spec.ratio.abs() * limits.velocity, spec.velocity, "rad/s", expected)?;
        let expected = "a range with the joint's torque limit inside";
        within("torque", sign * limits.torque / spec.ratio.abs(), spec.torque, "N m", expected)?;
    }
    Ok(())
}

/// The actuator of the table with this name, which must be of this kind.
fn actuator(value: &Value<'_>, protocol: Protocol) -> Result<Actuator, FileError> {
    let of_kind = || actuators::all().iter().filter(|actuator| actuator.protocol == protocol);
    let names: Vec<&str> = of_kind().map(|actuator| actuator.name.as_str()).collect();
    let expected =
        format!("{} for this kind of drive; another actuator needs its ranges in the robot file", names.join(", "));
    let name = value.string(&expected)?;
    match of_kind().find(|actuator| actuator.name == name) {
        Some(actuator) => Ok(actuator.clone()),
        None => {
            let guess = nearest(name, &names).map_or(String::new(), |guess| format!("; did you mean `{guess}`?"));
            let problem = format!("no actuator of the kind {} is {name:?}", protocol.facts().name);
            Err(value.error(problem, expected + &guess))
        }
    }
}

/// A range, or the actuator's if the file gives none.
fn span(
    table: &Table<'_>,
    key: &str,
    of_actuator: Option<(f64, f64)>,
    expected: &str,
    holds: impl Fn(f64, f64) -> bool,
) -> Result<(f64, f64), FileError> {
    if let (None, Some(range)) = (table.get(key), of_actuator) {
        return Ok(range);
    }
    let value = table.require(key, expected)?;
    let ends = value.numbers(2, expected)?;
    match ends.as_slice() {
        [lo, hi] if holds(*lo, *hi) => Ok((*lo, *hi)),
        _ => Err(value.error(format!("found {ends:?}"), expected)),
    }
}

/// `direction` times `gear`.
fn ratio(table: &Table<'_>, gear: f64) -> Result<f64, FileError> {
    const GEAR: &str = "shaft turns per joint turn (rad per m on a prismatic joint), above zero";
    let gear = table.get("gear").map_or(Ok(gear), |value| value.positive(GEAR))?;
    Ok(gear * direction(table, "direction", 1.0)?)
}

fn direction(table: &Table<'_>, key: &str, default: f64) -> Result<f64, FileError> {
    const EXPECTED: &str = "1 or -1";
    let Some(value) = table.get(key) else { return Ok(default) };
    let number = value.number(EXPECTED)?;
    if [1.0, -1.0].contains(&number) { Ok(number) } else { Err(value.error(format!("found {number}"), EXPECTED)) }
}

fn pwm(
    table: &Table<'_>,
    limits: &Limits<f64>,
    rotor: &Rotor,
    encoder: Option<&JointEncoder>,
) -> Result<PwmSpec, FileError> {
    table.only(&[
        "kind",
        "channel",
        "direction",
        "gear",
        "encoder_zero",
        "encoder_direction",
        "torque_constant",
        "resistance",
        "supply",
        "current_max",
    ])?;
    if encoder.is_none() {
        return Err(table.error("kind", "the joint has no `encoder`", "`encoder` beside a drive of the kind pwm"));
    }
    if !limits.velocity.is_finite() {
        let expected =
            "`limits.velocity` beside a drive of the kind pwm: it bounds how far the encoder moves in a tick";
        return Err(table.error("kind", "the joint has no velocity limit", expected));
    }
    // The rotor is part of the motor, so its gear is known if the rotor is.
    let geared = rotor.inertia > 0.0;
    let ratio = ratio(table, if geared { rotor.gear.abs() } else { 1.0 })?;
    if geared && (ratio.abs() / rotor.gear.abs() - 1.0).abs() > 1e-9 {
        let problem = format!("found {}, the rotor's is {}", ratio.abs(), rotor.gear.abs());
        return Err(table.error("gear", problem, "the rotor's gear, or no key"));
    }
    const CHANNEL: &str = "the board's channel, 1 to 6";
    let channel = table.require("channel", CHANNEL)?;
    let number = channel.whole(6, CHANNEL)?;
    if number == 0 {
        return Err(channel.error("found 0", CHANNEL));
    }
    const COUNTS: &str = "what the encoder shows where the joint is at 0, 0 to 16383 counts";
    let positive = |key, expected: &str| table.require(key, expected)?.positive(expected);
    Ok(PwmSpec {
        channel: number as u8,
        ratio,
        encoder_zero: table
            .get("encoder_zero")
            .map_or(Ok(0), |value| value.whole(u64::from(ENCODER_COUNTS - 1), COUNTS))? as u16,
        encoder_reversed: direction(table, "encoder_direction", ratio.signum())? < 0.0,
        torque_constant: positive("torque_constant", "torque constant of the motor, N m/A, above zero")?,
        resistance: positive("resistance", "resistance of winding and bridge, ohm, above zero")?,
        supply: positive("supply", "supply voltage, V, above zero")?,
        current_max: positive("current_max", "greatest current, A, above zero")?,
    })
}
