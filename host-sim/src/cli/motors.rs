//! `motors`: motors on a CAN bus. No command enables a motor.

pub mod check;
pub mod setup;

use board::can::adapter::Adapter;
use board::can::adapter_name::AdapterName;
use board::can::damiao_motor::DamiaoMotor;
use board::can::damiao_register::{POSITION_RANGE, Register, TORQUE_RANGE, VELOCITY_RANGE};
use board::can::motor::{Motor, MotorReport, NewZero, Reading, motor_with};
use board::can::motors::{Found, Value, search};
use clap::{Args, Subcommand, ValueEnum};
use dynamics_core::drive::{Protocol, TIMEOUT_UNIT_US};
use serde_json::json;
use sim::failure::Failure;
use sim::terminal;
use std::fmt::Write as _;
use std::io;

const EXAMPLE: &str = "Example:\n  newtau motors scan --can slcan:/dev/ttyACM0";

const EXAMPLES: &str = "\
Examples:
  newtau motors scan --can can0
  newtau motors scan --can gs_usb
  newtau motors show 3 --can slcan:/dev/ttyACM0
  newtau motors set-timeout 3 --ms 20 --can can0
  newtau motors check scenes/yam_one_bus.toml --can can0

A scan reads a setting of every identifier from 1 to 127, and neither enables nor moves anything. Motors of the kinds `mit` and `myactuator` have
no timeout that can be read, so they are not found. `show`, `set-id`, `set-zero`, `set-timeout`, `clear` and `setup` are for Damiao and RobStride
motors, `set-limits` and `check` for Damiao motors. A setting is changed only while its motor is off. It is read back, and the command says
what is stored: a RobStride motor stores with it every parameter that was changed since power-up. No other program may use
the bus. Support the arm first: a motor that is off carries nothing.";

/// Options of `motors`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct MotorsArgs {
    /// Task.
    #[command(subcommand)]
    pub task: Task,
    /// The CAN adapter: can0, slcan:PORT, damiao:PORT or gs_usb:SERIAL.
    #[arg(long, value_name = "ADAPTER", global = true)]
    pub can: Option<AdapterName>,
    /// Kind of the motor, if two kinds have its identifier; for `setup`, of the arm's motors.
    #[arg(long, global = true)]
    pub kind: Option<MotorKind>,
    /// Print JSON.
    #[arg(long, global = true)]
    pub json: bool,
}

/// A kind of motors whose settings can be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MotorKind {
    /// Damiao.
    Damiao,
    /// RobStride.
    Robstride,
}

/// Tasks of `motors`.
#[derive(Clone, Debug, Subcommand)]
pub enum Task {
    /// Find the motors on the bus, of every kind whose settings can be read.
    #[command(after_help = EXAMPLE)]
    Scan,
    /// Show a Damiao or RobStride motor: state, temperatures, position, settings.
    #[command(after_help = "Example:\n  newtau motors show 3 --can slcan:/dev/ttyACM0")]
    Show {
        /// Its identifier.
        id: u8,
    },
    /// Give a motor another identifier, and the replies of a Damiao motor that identifier plus 16; stored in flash.
    #[command(after_help = "Example:\n  newtau motors set-id 1 3 --can can0")]
    SetId {
        /// Its identifier.
        id: u8,
        /// The new one, 1 to 111.
        #[arg(value_parser = clap::value_parser!(u8).range(1..=111))]
        new: u8,
    },
    /// Make the present position of a motor its zero.
    #[command(after_help = "Example:\n  newtau motors set-zero 3 --can can0")]
    SetZero {
        /// Its identifier.
        id: u8,
    },
    /// Set the time without a command after which a motor gives no torque; stored in flash.
    #[command(after_help = "Example:\n  newtau motors set-timeout 3 --ms 20 --can can0")]
    SetTimeout {
        /// Its identifier.
        id: u8,
        /// The time, ms, 1 to 10000. There is no value for "never".
        #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
        ms: u32,
    },
    /// Set the ranges of a Damiao motor's frames; stored in flash. The robot file must have the same ranges: run `motors check` afterwards.
    #[command(after_help = "Example:\n  newtau motors set-limits 3 --torque 28 --can can0")]
    SetLimits {
        /// Its identifier.
        id: u8,
        /// The ranges.
        #[command(flatten)]
        ranges: LimitsArgs,
    },
    /// Compare the settings that Damiao motors have stored with a scene's robot file: ranges, identifiers of replies, control mode.
    #[command(after_help = "Example:\n  newtau motors check scenes/yam_one_bus.toml --can can0")]
    Check(check::CheckArgs),
    /// Find out which motor moves which joint, its direction and its zero, while you move the arm by hand; write the robot file.
    #[command(after_help = "Example:\n  newtau motors setup my_arm.toml --out my_arm_drives.toml --can can0")]
    Setup(setup::SetupArgs),
    /// Clear the error of a motor. It stays off.
    #[command(after_help = "Example:\n  newtau motors clear 3 --can can0")]
    Clear {
        /// Its identifier.
        id: u8,
    },
}

/// Ranges of `set-limits`: at least one.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = true)]
pub struct LimitsArgs {
    /// Highest position, rad.
    #[arg(long, value_name = "RAD", value_parser = above_zero)]
    pub position: Option<f32>,
    /// Highest velocity, rad/s.
    #[arg(long, value_name = "RAD/S", value_parser = above_zero)]
    pub velocity: Option<f32>,
    /// Highest torque, N m.
    #[arg(long, value_name = "NM", value_parser = above_zero)]
    pub torque: Option<f32>,
}

impl LimitsArgs {
    /// The ranges that are given, with their units.
    fn given(&self) -> Vec<(Register, f32)> {
        [(POSITION_RANGE, self.position), (VELOCITY_RANGE, self.velocity), (TORQUE_RANGE, self.torque)]
            .into_iter()
            .filter_map(|(register, value)| Some((register, value?)))
            .collect()
    }
}

fn above_zero(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && value <= 1000.0 => Ok(value),
        _ => Err("expected a number above 0 and at most 1000".into()),
    }
}

/// Does the task. Returns the exit code.
///
/// # Errors
/// An adapter that cannot be opened or dies; a motor that is silent, is on, or did not take a value.
pub fn run(args: &MotorsArgs) -> Result<u8, Failure> {
    let name = args.can.as_ref().ok_or_else(|| {
        Failure::Input(miette::miette!(
            help = EXAMPLE,
            "--can: missing; expected can0, slcan:PORT, damiao:PORT or gs_usb:SERIAL"
        ))
    })?;
    let is_for_damiao = matches!(args.task, Task::SetLimits { .. } | Task::Check(_));
    if is_for_damiao && args.kind == Some(MotorKind::Robstride) {
        return Err(Failure::Input(miette::miette!("--kind robstride: found a task for Damiao motors only")));
    }
    let mut adapter =
        name.open().map_err(|error| Failure::Target(miette::miette!(help = error.advice(), "{error}")))?;
    let failed = |error: io::Error| Failure::Target(miette::miette!("{name}: {error}"));
    let (adapter, is_json) = (adapter.as_mut(), args.json);
    let kind = args.kind.map(|kind| match kind {
        MotorKind::Damiao => Protocol::Damiao,
        MotorKind::Robstride => Protocol::RobStride,
    });
    let (text, json) = match &args.task {
        Task::Scan => scan(adapter, name),
        &Task::Show { id } => show(adapter, id, kind),
        &Task::SetId { id, new } => motor_with(adapter, id, kind).and_then(|mut motor| {
            motor.set_id(new)?;
            Ok(done(format!("{} is now {new}; {}", title(&*motor, id), motor.stored())))
        }),
        Task::SetLimits { id, ranges } => {
            let given = ranges.given();
            DamiaoMotor::new(adapter, *id).set_ranges(&given).map(|()| {
                let all: Vec<_> = given.iter().map(|(it, value)| format!("{} ±{value} {}", it.name, it.unit)).collect();
                done(format!("motor {id}: {}; stored in flash", all.join(", ")))
            })
        }
        Task::Check(args) => return check::run(args, adapter, name, is_json, failed),
        Task::Setup(args) => {
            return setup::run(args, kind, adapter, failed).and_then(|text| terminal::print(&text)).map(|()| 0);
        }
        &Task::SetZero { id } => motor_with(adapter, id, kind).and_then(|mut motor| {
            let NewZero { before, after, note } = motor.set_zero()?;
            let note = if note.is_empty() { String::new() } else { format!("; {note}") };
            Ok(done(format!("{}: position before {before:.4} rad, now {after:.4} rad{note}", title(&*motor, id))))
        }),
        &Task::SetTimeout { id, ms } => motor_with(adapter, id, kind).and_then(|mut motor| {
            motor.set_timeout(ms * 1000 / TIMEOUT_UNIT_US)?;
            let title = title(&*motor, id);
            Ok(done(format!("{title}: gives no torque after {ms} ms without a command; {}", motor.stored())))
        }),
        &Task::Clear { id } => motor_with(adapter, id, kind).and_then(|mut motor| {
            motor.clear()?;
            Ok(done(format!("{}: off, without an error", title(&*motor, id))))
        }),
    }
    .map_err(failed)?;
    terminal::print(&if args.json { terminal::json(&json)? } else { text })?;
    Ok(0)
}

/// Text for a motor without a communication timeout.
const NO_TIMEOUT: &str = "no communication timeout: it keeps its last torque when nobody sends";

fn done(text: String) -> (String, serde_json::Value) {
    let json = json!({ "text": text });
    (format!("{text}\n"), json)
}

/// The motors of all kinds.
fn scan(adapter: &mut dyn Adapter, name: &AdapterName) -> io::Result<(String, serde_json::Value)> {
    let (mut all, mut silent): (Vec<Found>, Vec<&str>) = (Vec::new(), Vec::new());
    for &kind in Protocol::ALL {
        match search(adapter, kind)? {
            Some(found) => all.extend(found),
            None => silent.push(kind.facts().name),
        }
    }
    let mut text = String::new();
    for Found { kind, id, reply_id, timeout_us } in &all {
        let timeout = match timeout_us {
            0 => NO_TIMEOUT.to_owned(),
            us => format!("communication timeout {} ms", f64::from(*us) * 1e-3),
        };
        let _ = writeln!(text, "{kind} {id}: replies at {reply_id}; {timeout}");
    }
    if all.is_empty() {
        let _ = writeln!(
            text,
            "no motor answered on {name}: is the drives' power on, are both ends of the bus terminated (60 Ohm between CANH and CANL), and is the bit \
             rate 1 Mbit/s?"
        );
    }
    let _ = writeln!(
        text,
        "not searched for, because their protocol has no timeout that can be read: {}",
        silent.join(", ")
    );
    let motors: Vec<_> = all
        .iter()
        .map(|it| json!({ "kind": it.kind, "id": it.id, "reply_id": it.reply_id, "timeout_us": it.timeout_us }))
        .collect();
    Ok((text, json!({ "motors": motors, "not_searched": silent })))
}

/// Kind and identifier of a motor.
fn title(motor: &dyn Motor, id: u8) -> String {
    format!("{} {id}", motor.kind().facts().name)
}

/// Everything that a motor says about itself.
fn show(adapter: &mut dyn Adapter, id: u8, kind: Option<Protocol>) -> io::Result<(String, serde_json::Value)> {
    let mut motor = motor_with(adapter, id, kind)?;
    let MotorReport { state, temperatures, readings } = motor.report()?;
    let mut text = format!("{}: {state}", title(&*motor, id));
    for (place, degrees) in &temperatures {
        let _ = write!(text, "; {place} {degrees} degrees Celsius");
    }
    text.push('\n');
    let mut registers = serde_json::Map::new();
    for Reading { name, value, unit } in readings {
        let (shown, json) = match value {
            Some(Value::Float(value)) => (value.to_string(), json!(value)),
            Some(Value::Integer(value)) => (value.to_string(), json!(value)),
            None => ("not available".to_owned(), serde_json::Value::Null),
        };
        let unit = if value.is_some() { unit } else { "" };
        let _ = writeln!(text, "  {name:<38} {}", format!("{shown} {unit}").trim_end());
        if name == "communication timeout" && value == Some(Value::Integer(0)) {
            let _ = writeln!(text, "    {NO_TIMEOUT}");
        }
        registers.insert(name.to_owned(), json);
    }
    let temperatures: Vec<f64> = temperatures.iter().map(|(_, degrees)| *degrees).collect();
    let kind = motor.kind().facts().name;
    let json = json!({ "id": id, "kind": kind, "state": state, "temperatures": temperatures, "registers": registers });
    Ok((text, json))
}
