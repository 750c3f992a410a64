//! `connect`: operates the arm of a scene, at a board on a serial port or in a dry run.

use super::options::{ConnectArgs, SessionArgs};
use crate::cli::firmware::key;
use crate::run::Target;
use board::chip::hello_of;
use board::session::frame_log::Head;
use board::session::local::page;
use board::session::local::service::Service;
use board::session::local::shared::Shared;
use board::session::operate::console::Console;
use board::session::operate::converse::converse;
use board::session::operate::dead_man::DeadMan;
use board::session::operate::device::{Device, DeviceError, Pace};
use board::session::operate::on_wire::OnWire;
use board::session::operate::report::Report;
use board::session::operate::simulated;
use board::session::operate::{Operator, Presses, Stop};
use board::session::serial::{SerialError, SerialLink};
use console::style;
use link::{Pacing, Trust};
use report::{Block, Page};
use robot_compiler::SceneFile;
use sim::failure::{self, Failure, in_file};
use sim::output::Output;
use sim::run::report::drawing;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Warning about a board that accepts any host.
const INSECURE: &str =
    "INSECURE: this firmware was built with --insecure: whoever reaches the wire can drive the arm (docs/safety.md)";

/// Message to a script that connects to an arm that another session left driven.
const HELD: &str = "the arm is driven in an earlier session, and this script did not arm it: nothing was done; the board holds the arm, and lowers it or does its safe \
                    action when no host is heard; `--take-over` lets a script go on with it";

/// Operates the arm. Returns the exit code.
///
/// # Errors
/// A wrong scene or command; a board that is silent, dies or has other firmware; a record that cannot be written.
pub fn run(args: &ConnectArgs, presses: Presses) -> Result<u8, Failure> {
    let setup = Setup::new(&args.scene, &args.session, args.key.as_deref())?;
    let device = device(args, &setup)?;
    setup.operate(device, presses, args.take_over, || None)
}

/// A scene and a session with its arm, before the arm is reached.
pub struct Setup<'a> {
    args: &'a SessionArgs,
    path: &'a Path,
    /// The scene.
    pub scene: SceneFile,
    head: Head,
    console: Console,
    outputs: Output,
    report: Report,
}

impl<'a> Setup<'a> {
    /// Reads the scene and opens the source of the commands.
    ///
    /// # Errors
    /// A wrong scene, a script that cannot be read, a record that exists.
    pub fn new(path: &'a Path, args: &'a SessionArgs, key: Option<&Path>) -> Result<Self, Failure> {
        let scene = SceneFile::load(path).map_err(Failure::input)?;
        if scene.safety.bench_only {
            let place = path.display();
            return Err(Failure::Input(miette::miette!(
                help = "expected `safety.bench_only = false`",
                "{place}: safety.bench_only: the scene's bounds on old measurements are lifted, and its arm is never armed"
            )));
        }
        let text = std::fs::read_to_string(path).map_err(|error| bad_file(path, &error))?;
        let inputs = [key, args.script.as_deref(), args.motion.as_deref(), Some(path)].into_iter().flatten();
        let mut outputs = inputs.fold(args.force.output(), |outputs, path| outputs.reads(path));
        args.record.as_deref().map_or(Ok(()), |record| outputs.file(record))?;
        let console = match &args.script {
            Some(script) => Console::script(script).map_err(|error| bad_file(script, &error))?,
            None => Console::standard_input(),
        };
        if args.dead_man && !(console.is_a_person() && console.dead_man().is_some()) {
            return Err(Failure::Input(miette::miette!(
                "--dead-man: expected a person at a terminal whose keys can be read one by one, and no --script"
            )));
        }
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let head = Head { hash: hello_of(&scene, Pacing::LockStep)?.robot, scene: absolute, text };
        let report = Report::new(args.json, console.screen());
        Ok(Self { args, path, scene, head, console, outputs, report })
    }

    /// Prints an event of this kind.
    ///
    /// # Errors
    /// The output is closed.
    pub fn say(&self, kind: &'static str, text: &str) -> Result<(), Failure> {
        self.report.say(kind, text, None).map_err(Failure::Output)
    }

    /// Operates the arm at this device until the commands end, and prints the text of `last`. Returns the exit code.
    ///
    /// # Errors
    /// A wrong command; a device that dies; a record that cannot be written.
    pub fn operate(
        self,
        device: Box<dyn Device>,
        presses: Presses,
        take_over: bool,
        last: impl FnOnce() -> Option<String>,
    ) -> Result<u8, Failure> {
        let Self { args, path, scene, head, console, outputs, report } = self;
        // The board was built from the scene's own motion. Only `run` follows the other one.
        let mut plays = scene.clone();
        if let Some(motion) = &args.motion {
            plays.take_motion(motion).map_err(Failure::input)?;
        }
        // The time of a script's dry run passes only while the script needs it: nobody could stop it or lead it.
        let reachable = device.pacing() == Pacing::Live || console.is_a_person();
        let control = device.control_loop();
        let operator = Operator::new(device, (&scene, &plays), head, report, presses)
            .map_err(|stop| failure(stop, &path.display().to_string()))?;
        let operator = operator.with_outputs(outputs);
        let shared = reachable.then(|| Arc::new(Shared::new(control)));
        let key = console.dead_man().filter(|_| args.dead_man).map(DeadMan::new);
        let operator = operator.with_shared(shared.clone()).with_stop_key(console.stops()).with_dead_man(key);
        let page_of = shared.clone();
        // Sessions are found and stopped by `newtau stop` while this is kept.
        let service = shared.map(|shared| Service::start(path, operator.greeting(), shared));
        if let Some(Err(error)) = &service {
            let text = format!("other programs, `newtau stop` among them, cannot reach this session: {error}");
            operator.report().say("service", &text, None).map_err(Failure::Output)?;
        }
        if let Some(port) = args.page {
            let Some(shared) = page_of else {
                return Err(Failure::Input(miette::miette!(
                    "--page: the dry run of a script shows nothing while its time stands; expected commands from a terminal, `--port`, or `newtau drive`"
                )));
            };
            let address = page::start(port, live_page(&scene)?, shared).map_err(|error| {
                Failure::Output(io::Error::other(format!("--page: no page at 127.0.0.1:{port}: {error}")))
            })?;
            let text = format!("page: http://{address}/");
            operator.report().say("page", &text, None).map_err(Failure::Output)?;
        }
        operate(args.record.as_deref(), take_over, operator, console, last)
    }
}

/// The page of a session, without its state.
fn live_page(scene: &SceneFile) -> Result<String, Failure> {
    let page = Page {
        title: format!("{}: {}", scene.name, scene.robot.name),
        lead: vec![
            "The stop button is a convenience, not a safety function: use your emergency stop in danger.".into(),
        ],
        blocks: vec![Block::Live(drawing::of_scene(scene)?)],
    };
    Ok(page.html())
}

fn bad_file(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(miette::miette!("{}: {error}", path.display()))
}

/// Reaches the board, or simulates it.
fn device(args: &ConnectArgs, setup: &Setup<'_>) -> Result<Box<dyn Device>, Failure> {
    let scene = &setup.scene;
    let pace = Pace::new(setup.console.is_a_person());
    let disturbance = args.disturbance();
    if disturbance.is_some() && args.target == Some(Target::Qemu) {
        return Err(Failure::Input(miette::miette!(
            "a simulated link needs `--target desk`; the emulated chip has none"
        )));
    }
    Ok(match (&args.port, args.target, disturbance) {
        (Some(port), ..) => {
            let key = key::given(args.key.as_deref())?;
            let device = SerialLink::open(port, args.baud).map_err(DeviceError::from);
            let joined = device.and_then(|link| OnWire::join(link, key));
            let (device, trust) = joined.map_err(|error| failure(error.into(), port))?;
            if trust == Trust::Insecure {
                setup.say("insecure", &style(INSECURE).red().bold().to_string())?;
            }
            Box::new(device)
        }
        (None, Some(Target::Qemu), _) => simulated::on_chip(scene, pace)?,
        (None, _, Some((disturbance, places))) => simulated::on_board(scene, disturbance, places, pace)?,
        (None, _, None) => simulated::on_desk(scene, pace)?,
    })
}

/// Converts the reason for the end to a failure; `place` is the position of a wrong command.
fn failure(stop: Stop, place: &str) -> Failure {
    match stop {
        Stop::Board(DeviceError::Record(error)) | Stop::Output(error) => Failure::Output(error),
        Stop::Board(DeviceError::Serial(error @ SerialError::Open { .. })) => {
            Failure::Target(miette::miette!(help = error.advice(), "{error}"))
        }
        Stop::Board(error) => Failure::Target(miette::miette!("{error}")),
        Stop::Input(problem) => Failure::Input(miette::miette!("{place}: {problem}")),
        Stop::Interrupted | Stop::Pressed => Failure::Interrupted,
    }
}

fn operate(
    record: Option<&Path>,
    take_over: bool,
    mut operator: Operator,
    mut console: Console,
    last: impl FnOnce() -> Option<String>,
) -> Result<u8, Failure> {
    if let Some(record) = record {
        operator.keep(record).map_err(|stop| failure(stop, ""))?;
    }
    let begun = loop {
        match operator.begin() {
            // Until the board has answered, it is unknown if the arm moves. A repeated hello is harmless.
            Err(Stop::Pressed) => match operator.stop() {
                // The lines of a script would move the arm after the stop.
                Ok(()) if !console.is_a_person() => break Err(Stop::Interrupted),
                Ok(()) => {}
                Err(stop) => break Err(stop),
            },
            other => break other,
        }
    };
    let leaves = begun.is_ok() && operator.found_driven() && !console.is_a_person() && !take_over;
    if leaves {
        operator.complain(HELD).map_err(|stop| failure(stop, ""))?;
        operator.close().map_err(Failure::Output)?;
        return Ok(failure::FAULT);
    }
    let ended = begun.and_then(|()| converse(&mut operator, &mut console));
    // A board that is gone cannot be requested to stop; its own heartbeat limit stops the arm. A second Ctrl-C at a terminal ends the program at
    // once.
    let ended = match ended {
        Err(Stop::Interrupted) if console.is_a_person() => Err(Stop::Interrupted),
        Err(stop @ (Stop::Interrupted | Stop::Input(_))) => operator.end().and(Err(stop)),
        // Even with a full disk or a closed output, the arm is stopped here instead of being left to its heartbeat limit.
        Err(stop @ (Stop::Output(_) | Stop::Board(DeviceError::Record(_)))) => {
            operator.close().ok();
            operator.end().ok();
            Err(stop)
        }
        other => other,
    };
    let told = last().map_or(Ok(()), |text| operator.report().say("timing", &text, None));
    let closed = operator.close().and(told);
    let (person, content) = (console.is_a_person(), operator.is_content());
    match ended {
        Ok(()) => {}
        Err(Stop::Interrupted | Stop::Pressed) => return Ok(failure::INTERRUPTED),
        Err(stop) => return Err(failure(stop, &console.place())),
    }
    closed.map_err(|error| match record {
        Some(record) => in_file(record, &error),
        None => Failure::Output(error),
    })?;
    Ok(if person || content { 0 } else { failure::FAULT })
}
