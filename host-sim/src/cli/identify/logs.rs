//! `identify`: estimates the model of an arm from logs of its motion.

use super::corrections::CorrectionArgs;
use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use clap::Args;
use identification::identify::Settings;
use identification::log::Log;
use identification::verdict::Grade;
use nalgebra::Vector3;
use robot_compiler::Robot;
use sim::failure::{FAULT, Failure, in_file};
use sim::terminal::{json, print, say_mounting};
use std::path::PathBuf;
use studies::identify::{LogOptions, Outcome, Subject, held, prediction, report, verdict};
use studies::options::GravityArgs;

const EXAMPLE: &str = "Example:\n  newtau identify robots/planar2r.toml --log out/planar2r_swing/log.csv";

const EXAMPLES: &str = "\
Examples:
  newtau identify robots/yam.toml --log out/yam_excite/log.csv --validate out/yam_move/log.csv --out yam.toml
  newtau identify arm.urdf --log a.csv --validate b.csv --torque-per-ampere 14.9,13.3,11.1,10.6,11,11.5 --report out/arm
  newtau identify arm.toml --log empty.csv --payload loaded.csv

A log is a text file with a header: `time`, per joint a position (`q_1`) and a torque (`tau_1`) or current (`current_1`, with
--torque-per-ampere or a torque constant in the robot file), optionally a velocity (`qd_1`). SI units unless the header names others.
  separators  comma, semicolon, tab, blanks; decimal point or decimal comma; UTF-8, UTF-16; comment lines begin with #, % or //
  names       q, position, pos, angle | qd, dq, velocity, vel | tau, torque, effort, moment | current, i; also actual_q_0 (UR),
              position[0], /joint_states/shoulder/position, joint_1.position, shoulder_effort
  joints      by number, from 0 where column 0 exists, otherwise from 1; or by name. ROS `name[0]` ..: their order is used
  units       q1 [deg], q1_deg, tau_1 [mN m], [N cm], [mA], qd_1 [rpm], time [ms], or in a row below the header. --degrees: angles
              without a unit
  time        s, ms, us, ns, of the header, or judged by the steps where one fits; `sec` and `nanosec`; ticks with --tick-rate
  others      --columns 'q=pos_{},tau=effort_{},t=stamp': {} is a joint's number or name. A list: 'q=a,b,c'. A unit: 'tau[mNm]=..'.
              #3 is the third column, #2-#7 the second to the seventh
Measured values (actual_q) are preferred to commanded ones (target_q). If two columns could be meant, an error names both. What was
converted or assumed is reported as `note`. log.csv of `run` is a log; so are records of `connect` (the longest stretch in which
torque acted) and MCAP files of `run --mcap`.

Torque is linear in the base parameters of the bodies, in rotor inertias and in friction: weighted least squares with robust weights.
Each term of friction, and the cut-off of the filter of motions, must earn its place by the error in blocks held out. The bodies written
are those of possible mass distributions nearest to the data, and to the robot file's where the data say nothing.

The verdict is `trusted` (exit code 0), `doubtful` (3, and no robot file unless --accept-doubtful) or `refused` (3, and no robot file). If a
sign, a unit, the order of columns, or gravity explains a log that the arm does not, it is named with the option that corrects it.";

/// Options of `identify`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct IdentifyArgs {
    /// The robot file (TOML or URDF). Its geometry is used unchanged; its masses are the starting values.
    pub robot: PathBuf,
    /// Logs to identify from.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub log: Vec<PathBuf>,
    /// Logs to validate the result with.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub validate: Vec<PathBuf>,
    /// Logs with a payload, to identify its mass, centre of mass and inertia. Without --log, the numbers of the robot file are used for the arm.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub payload: Vec<PathBuf>,
    /// Relative standard deviation of the scale of the measured torque. Default: 0.1 for currents, 0.02 for torques.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub torque_deviation: Option<f64>,
    /// Write the robot with the identified numbers to this file.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write the report (index.html) to this folder.
    #[arg(long, value_name = "FOLDER")]
    pub report: Option<PathBuf>,
    /// Write the measured and the predicted torque of the first validation log (of the first log if there is none) to this CSV file, both after the
    /// same filter.
    #[arg(long, value_name = "FILE")]
    pub predict: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Units and columns of the logs.
    #[command(flatten)]
    pub reading: LogOptions,
    /// Cut-off frequency of the torque filter, Hz. Default: 8, or a fifth of the log's rate if that is less.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub cutoff: Option<f64>,
    /// Cut-off frequency of the motion filter, Hz. Without it, chosen by the held-out error.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub motion_cutoff: Option<f64>,
    /// Use only offset, viscous and Coulomb friction.
    #[arg(long)]
    pub plain_friction: bool,
    /// Relative uncertainty of the masses and second moments in the robot file.
    #[arg(long, value_name = "SHARE", default_value_t = 0.3, allow_negative_numbers = true)]
    pub trust: f64,
    /// Also write the robot file if the verdict is `doubtful`, and exit with 0.
    #[arg(long)]
    pub accept_doubtful: bool,
    /// Corrections of the logs.
    #[command(flatten)]
    pub corrections: CorrectionArgs,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Gravity.
    #[command(flatten)]
    pub gravity: GravityArgs,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Identifies, prints and writes the model. Returns the exit code: 0, or 3 for a doubtful or rejected model.
///
/// # Errors
/// [`Failure::Input`] for a wrong robot file, log or option; [`Failure::Output`] for a file that cannot be written.
pub fn run(args: &IdentifyArgs) -> Result<u8, Failure> {
    let wrong = |expected: &str, found: String| {
        Err(Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}")))
    };
    if args.log.is_empty() && args.payload.is_empty() {
        return wrong("--log FILE, a record of the arm's motion, or --payload FILE", "no log".to_owned());
    }
    for (name, value) in [
        ("--cutoff", args.cutoff),
        ("--motion-cutoff", args.motion_cutoff),
        ("--torque-deviation", args.torque_deviation),
        ("--trust", Some(args.trust)),
    ] {
        if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
            return wrong("a number above zero", format!("{name} {}", value.unwrap_or(f64::NAN)));
        }
    }
    let robot = Robot::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    say_mounting(&robot);
    let gravity: Vector3<f64> = match args.gravity.of(&robot).as_slice() {
        [x, y, z] if [x, y, z].iter().all(|g| g.is_finite()) => Vector3::new(*x, *y, *z),
        other => return wrong("three finite numbers gx,gy,gz", format!("--gravity {other:?}")),
    };
    // An error here is better before the work than after it.
    let inputs = args.log.iter().chain(&args.validate).chain(&args.payload).chain([&args.robot]);
    let mut output = inputs.fold(args.force.output(), |output, path| output.reads(path));
    [&args.out, &args.predict].into_iter().flatten().try_for_each(|path| output.file(path))?;
    args.report.as_deref().map_or(Ok(()), |folder| output.folder(folder, &["index.html"]))?;
    // Masses scale with the square of the coordinates' scale, so the coordinates have half the standard deviation.
    let subject = Subject::load(&args.robot, args.chain.ends(), gravity, 0.5 * args.trust)?;
    let options = LogOptions {
        correction: Some(args.corrections.correction(subject.robot.dof())?).filter(|correction| !correction.is_none()),
        ..args.reading.clone()
    };
    let mut notes = Vec::new();
    let mut logs: Vec<Log> = Vec::new();
    for path in &args.log {
        let failure = match subject.log(path, &options, &mut notes) {
            Ok(log) => {
                logs.push(log);
                continue;
            }
            Err(failure) => failure,
        };
        // The log contains motions that the arm cannot make. A wrong sign or scale may be the reason.
        let Some(refused) = subject.explained(path, &options) else { return Err(failure) };
        if args.json {
            print(&(json(&serde_json::json!({ "verdict": verdict::json(&refused, &subject) }))? + "\n"))?;
        } else {
            print(&verdict::text(&refused, &subject))?;
        }
        eprintln!("{}: {}", path.display(), verdict::refusal(&refused, &subject));
        return Ok(FAULT);
    }
    let resting = LogOptions { may_rest: true, ..options };
    let mut read = |paths: &[PathBuf]| {
        paths.iter().map(|path| subject.log(path, &resting, &mut notes)).collect::<Result<Vec<Log>, _>>()
    };
    let validation = read(&args.validate)?;
    let loaded = read(&args.payload)?;
    let validation = held_out(&logs, validation, &mut notes);
    let settings = Settings {
        torque_cutoff: args.cutoff,
        motion_cutoff: args.motion_cutoff,
        plain_friction: args.plain_friction,
        keep_delay: !args.corrections.delay.is_empty(),
    };
    if logs.is_empty() {
        let held = held::against_file(&subject, &loaded, &settings, args.torque_deviation);
        print(&if args.json {
            let mut all = held::json(&held, &subject);
            all["notes"] = notes.into();
            json(&all)? + "\n"
        } else {
            held::text(&held, &subject) + &noted(&notes)
        })?;
        return Ok(0);
    }
    let outcome = Outcome::of(&subject, &logs, &validation, &settings);
    if let (Some(path), Some(judged)) = (&args.predict, outcome.judged.first()) {
        prediction::write(judged, path)?;
    }
    let grade = outcome.verdict.grade;
    let accepted = grade == Grade::Trusted || (grade == Grade::Doubtful && args.accept_doubtful);
    if let Some(path) = args.out.as_ref().filter(|_| accepted) {
        let text = outcome.numbers.robot_file(&subject, &args.robot, args.chain.ends())?;
        std::fs::write(path, text).map_err(|error| in_file(path, &error))?;
    }
    let held = (!loaded.is_empty()).then(|| held::against(&subject, &outcome.found, &loaded, args.torque_deviation));
    if let Some(folder) = &args.report {
        let text = held.as_ref().map(|held| held::text(held, &subject));
        report::write(&outcome, &subject, text.as_deref(), folder)?;
    }
    let report = args.report.iter().map(|folder| folder.join("index.html"));
    let written: Vec<PathBuf> = [&args.out, &args.predict].into_iter().flatten().cloned().chain(report).collect();
    output.written(&written)?;
    if args.json {
        let mut all = outcome.json(&subject);
        if let Some(held) = &held {
            all["payload"] = held::json(held, &subject)["payload"].clone();
        }
        all["notes"] = notes.into();
        print(&(json(&all)? + "\n"))?;
    } else {
        let held = held.map_or_else(String::new, |held| held::text(&held, &subject));
        print(&(outcome.text(&subject) + &held + &noted(&notes)))?;
    }
    if accepted {
        return Ok(0);
    }
    eprintln!("{}", verdict::refusal(&outcome.verdict, &subject));
    Ok(FAULT)
}

/// Returns the logs for validation that are not used for identification too. Adds a note for each log that is.
fn held_out(logs: &[Log], validation: Vec<Log>, notes: &mut Vec<String>) -> Vec<Log> {
    let twin = |log: &Log| logs.iter().find(|other| other.is_same(log)).map(|other| other.file.clone());
    let (same, other): (Vec<Log>, Vec<Log>) = validation.into_iter().partition(|log| twin(log).is_some());
    notes.extend(same.iter().map(|log| {
        let twin = twin(log).unwrap_or_default();
        format!(
            "{}: --validate has the samples of --log {twin}: it is not held out and not used for validation",
            log.file
        )
    }));
    other
}

/// Notes on how the logs were interpreted, a line each.
fn noted(notes: &[String]) -> String {
    notes.iter().map(|note| format!("{:<20}{note}\n", "note")).collect()
}
