//! Commands that an operator types, and their help.

use super::device::Cut;
use dynamics_core::control::ControlLaw;
use link::{Request, Setting};
use std::path::PathBuf;

/// A command of the operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// No command: an empty line or a comment.
    Nothing,
    /// List the commands.
    Help,
    /// Print the board's status.
    Status,
    /// Send a request to the safety state machine.
    Ask(Request),
    /// Follow the scene's motion.
    Run,
    /// Move one joint by a distance, rad or m, in a time, s.
    Jog(usize, f64, Option<f64>),
    /// Move all joints to these positions, rad or m, in a time, s.
    Goto(Vec<f64>, Option<f64>),
    /// Follow the targets of another program that come at most this time (s) after each other.
    Follow(f64),
    /// Wait for a time, s; without a number, until the motion has ended.
    Wait(Option<f64>),
    /// Print the status at an interval of ticks; 0 never.
    Watch(u64),
    /// Read the black box, into a file if one is named.
    Dump(Option<PathBuf>),
    /// Start a record in this file, or end the record.
    Record(Option<PathBuf>),
    /// Read these parameters.
    Get(Vec<u8>),
    /// Change a parameter.
    Set(Setting),
    /// Set the payload: its mass, kg, and its centre of mass in the tip frame, m.
    Payload(f64, [f64; 3]),
    /// Select another control law.
    Law(ControlLaw),
    /// Set the stiffness to this multiple of the scene's.
    Stiffness(f64),
    /// Estimate the payload and send it to the board.
    Weigh,
    /// Measure the ratio of actual to commanded torque of a joint; `None`: of each joint.
    CheckTorque(Option<usize>),
    /// Cut a simulated cable (`true`) or plug it in again (`false`).
    Cut(Cut, bool),
    /// Press or release the emergency stop of a dry run.
    EmergencyStop(bool),
    /// Remove the torque; `true`: even if joints sink.
    Disarm(bool),
    /// Lift the limits of the first motion after homing.
    FullRange,
    /// Release the black box of a fault.
    Erase,
    /// Move to the rest pose.
    Park,
    /// Stop the arm and hold it; again within a second: emergency stop.
    Stop,
    /// Stop the arm, remove the torque and end the session; `true`: even if joints sink.
    Quit(bool),
}

/// Each command with its arguments and its effect.
pub const HELP: [(&str, &str); 38] = [
    ("status", "the last report: state, positions, torques"),
    ("home", "forget the zeros: the joints look for them"),
    ("confirm", "the zeros are right: look before you say so"),
    ("arm", "hold the arm where it is, by torque"),
    (
        "stop, s",
        "stop along the path and hold; again within 1 s: emergency stop (fault 9). Keys: Esc, or space on an empty line",
    ),
    ("park", "move to the rest pose of the scene or robot file"),
    (
        "disarm",
        "remove the torque at rest; if joints would sink, says how far and asks (a script parks, or is rejected)",
    ),
    ("disarm!", "remove the torque although joints sink"),
    ("run", "the scene's motion, and the way to its start"),
    ("hold", "stop, and stay"),
    ("clear", "leave a fault whose cause is gone"),
    ("jog JOINT DELTA [SECONDS]", "move one joint (number or name) by so many rad or m"),
    ("goto Q1 .. QN [SECONDS]", "move all joints to these positions, rad or m"),
    (
        "follow [SECONDS]",
        "go where another program of yours sends the arm (`newtau.Session` in Python); stops when nothing comes for 0.25 s, or SECONDS",
    ),
    ("wait", "until the motion has ended"),
    ("wait SECONDS", "so long"),
    ("watch TICKS", "print the status every so many ticks; 0 never"),
    ("get [JOINT] [NAME]", "what parameters are, and their bounds: all, a joint's, one"),
    ("set JOINT NAME VALUE", "change a gain or a friction, where the scene is `tunable` and no torque jumps"),
    (
        "payload MASS [X Y Z]",
        "declare a payload of MASS kg with its centre of mass at X Y Z (m) in the tip frame; needs a live payload in the scene",
    ),
    ("law LAW", "another control law, where the scene is `tunable`; a moving arm is stopped first"),
    ("teach", "lead the arm by hand: the law `teach`, and off; `hold` ends it"),
    ("soft", "a quarter of the scene's stiffness, in steps without a jump of torque"),
    ("stiff", "four times the scene's stiffness"),
    ("stiffness FACTOR", "so many times the scene's stiffness, 0.25 to 4"),
    ("check-torque [JOINT]", "move a joint slightly back and forth, and report actual over commanded torque"),
    ("weigh", "measure what the arm holds by slow back-and-forth motions, and declare it"),
    ("dump [FILE]", "the ticks in the black box: a table, or a CSV file"),
    ("erase", "release the black box of an earlier fault, so that it records again"),
    ("full-range", "show what was seen in the first motion after homing, and lift its limits"),
    ("record FILE", "keep every frame from here on, for `newtau connect replay`; begins a new session"),
    ("record off", "end the record"),
    ("press, release", "the emergency stop, in a dry run"),
    ("cut host", "cut a simulated cable, with --simulate-link: to the host; `bus 1` and `drive JOINT` work too"),
    ("plug host", "plug it in again"),
    ("help", "this"),
    ("quit", "hold, `disarm`, end; so does the end of the input"),
    ("quit!", "hold, `disarm!`, end"),
];
