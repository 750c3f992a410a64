//! An operator at a board: requests, their answers, and the points of a motion, sent ahead of the arm.
//!
//! ```text
//! console -> command -> operator <-> device: a board on a serial port, or a dry run with a simulated arm
//!                          |            `-- tap: every frame, counted and kept in a record
//!                          `-> report
//! ```
//!
//! A request is sent again until its answer has come (`requests`). Other frames have no answer. Instead, every status reports how many frames the
//! board had taken or missed before its tick. The free capacity for points is the capacity in the last status, less the points that are still on
//! their way.
//!
//! | module | holds |
//! |---|---|
//! | [`device`] | interface of a board or a dry run |
//! | [`dry_run_device`], [`on_wire`], [`simulated_board`] | its implementations; [`wire`] simulates a link that loses frames |
//! | [`command`], [`command_parser`] | the commands that an operator types |
//! | [`console`], `keys` | the source of the commands: a script, a pipe or a terminal; the stop key |
//! | `reason` | the reasons why a command was not completed |
//! | [`dead_man`] | a key without which the arm does not move |
//! | `converse` | the loop that executes them line by line |
//! | `rejection` | the reason why a request had no effect |
//! | `greeting` | hellos: starting a session or continuing one |
//! | `operator_state` | questions about the session and its arm: moving, driven, in a fault |
//! | `obey` | execution of a command, and its files |
//! | `requests` | repetition of requests until they are answered, and lost frames |
//! | `stop`, `stop_demands` | the stop key, the command `stop`, and stops of other programs |
//! | `ending` | the end of torque: consent, parking |
//! | `sinking` | joints that sink when the torque ends |
//! | `arm`, `scene_arm` | data of the scene's arm; the operations that depend on the number of its joints |
//! | `step` | passing of time: points are sent, frames received, with their effects |
//! | `planned_motion` | a motion of an arm with any number of joints |
//! | [`motion_queue`] | motions as points that wait to be sent |
//! | `moves` | motions from the arm's present position |
//! | [`follower`] | targets of another program as a smooth reference |
//! | `follow` | other programs: the state for them, and their targets |
//! | `session` | time and requests of a session: reporting interval, waiting, arming, disarming |
//! | [`parameters`] | parameters by name: reading and changing them |
//! | `observed` | observations of the arm since homing |
//! | `first_motion` | limits of the first motion after homing |
//! | `heat` | heat of the motors, as last reported |
//! | `motor_heat` | requests for the heat of the motors, in the background |
//! | `guiding` | conditions of hand guiding: first motion, soft walls, gravity model |
//! | `feel` | changes of control law, stiffness and payload of an armed arm, without a jump of torque |
//! | `samples` | positions and torques of the last ticks |
//! | `torque_check` | comparison of the drives' torque with the commanded torque |
//! | `torque_cause` | the likely cause of a difference |
//! | `weigh` | estimate of the payload from slow motions |
//! | [`messages`] | messages for the protocol's numbers |
//! | [`report`], [`table`], [`screen`] | output for the operator; the lowest lines of the terminal |

pub mod command;
pub mod command_parser;
pub mod console;
pub mod converse;
pub mod dead_man;
pub mod device;
pub mod dry_run_device;
pub mod follower;
pub mod messages;
pub mod motion_queue;
pub mod on_wire;
pub mod parameters;
pub mod report;
pub mod screen;
pub mod simulated;
pub mod simulated_board;
pub mod table;
pub mod wire;

mod arm;
mod ending;
mod feel;
mod first_motion;
mod follow;
mod greeting;
mod guiding;
mod heat;
mod keys;
mod motor_heat;
mod moves;
mod obey;
mod observed;
mod operator_state;
mod planned_motion;
mod reason;
mod rejection;
mod requests;
mod samples;
mod scene_arm;
mod session;
mod sinking;
mod step;
mod stop;
mod stop_demands;
mod torque_cause;
mod torque_check;
mod weigh;

use crate::session::frame_log::Head;
use crate::session::local::shared::Shared;
use arm::Arm;
use dead_man::DeadMan;
use device::Device;
use follower::Following;
use heat::MotorHeat;
pub use keys::Presses;
use link::{Lines, Refusal, Status, Value, Verdict};
use motion_queue::MotionQueue;
use observed::FirstMotion;
pub use reason::Stop;
use report::Report;
use robot_compiler::SceneFile;
use samples::Samples;
use sim::output::Output;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use stop_demands::{Moment, StopDemands};

/// An operator at a board.
pub struct Operator {
    device: Box<dyn Device>,
    arm: Arm,
    report: Report,
    presses: Presses,
    /// Number of presses of Ctrl-C already handled.
    seen: u32,
    /// Counter of presses of the stop key, if a user sits at a terminal, and the demands for a stop that are handled.
    stops: Option<Presses>,
    stops_seen: StopDemands,
    /// True while the stop key is being handled, so that it does not interrupt its own handling.
    deaf: bool,
    /// Key without which the arm does not move, if the user asked for one, and true once it was let go in a motion.
    dead_man: Option<DeadMan>,
    let_go: bool,
    /// Time of the last stop.
    stopped_at: Option<Moment>,
    /// Text to be shown once the request has been sent.
    announcement: Option<&'static str>,
    /// True if a stop came since the last motion began.
    stopped: bool,
    status: Option<Status>,
    /// Time from which the board's silence is counted: of the last status, of a hello, or of a cable that was cut or plugged in.
    heard: Duration,
    /// Time of the last status.
    reported: Duration,
    /// Statuses received.
    statuses: u64,
    /// Time when the live inputs were last sent by the timer.
    live_sent: Duration,
    q: Option<Vec<f64>>,
    feed: MotionQueue,
    /// Targets of another program that the arm follows; `None` otherwise.
    following: Option<Following>,
    /// State, targets and stops that are shared with other programs; `None` where they cannot reach this session.
    shared: Option<Arc<Shared>>,
    /// Points on their way: for each, the number of frames sent up to and including it.
    under_way: VecDeque<u16>,
    /// Position of the arm after all requested motions.
    goal: Option<Vec<f64>>,
    /// Interval of the board's reports that is set now, in ticks.
    watched: u16,
    /// Interval of the printed statuses, in ticks, and the tick of the last printed one.
    print: (u64, u32),
    /// State of the board's input lines, which this program simulates in a dry run.
    lines: Lines,
    /// Ticks of the black box received so far, while it is being dumped.
    past: Option<Vec<Status>>,
    /// All ticks of the black box, once it is complete.
    whole: Option<Vec<Status>>,
    /// Answers received so far to questions that expect a value or a refusal; `None` while no question is pending.
    expected: Option<Vec<Result<Value, Refusal>>>,
    /// True if a request is under way: a change of state is then its answer.
    asking: bool,
    /// True while that request is one that ends a motion.
    stopping: bool,
    /// Number of the last request, and of the one whose answer is awaited.
    number: u8,
    awaited: u8,
    /// The board's verdict on it, and the number of statuses received before.
    verdict: Option<(Verdict, u64)>,
    /// A hold that is repeated until the arm no longer runs: its number, and the time when it was sent last.
    urgent: Option<(u8, Duration)>,
    /// True if anything was refused.
    refused: bool,
    agreed: bool,
    /// True if the board continues the session of an earlier host and its payload has not been read yet.
    resumed: bool,
    /// True if the board was driving the arm when this program connected.
    found_driven: bool,
    /// For each joint, the number of statuses in which its drive's reply was too old; and the number of statuses with readings.
    stale: (Vec<u64>, u64),
    /// Smallest age of each joint's reading, ticks.
    age_min: Vec<u16>,
    /// The last ticks in which torque acted.
    samples: Samples,
    /// True if the torques since this arming have been checked.
    judged: bool,
    first_motion: FirstMotion,
    heat: MotorHeat,
    /// Files of `dump` and `record`.
    outputs: Output,
}

impl Operator {
    /// An operator that has not sent anything yet. `run` follows the motion of the second scene.
    ///
    /// # Errors
    /// A scene whose motion or payload is not possible.
    pub fn new(
        device: Box<dyn Device>,
        (scene, plays): (&SceneFile, &SceneFile),
        head: Head,
        report: Report,
        presses: Presses,
    ) -> Result<Self, Stop> {
        let arm = Arm::new(scene, plays, head, device.pacing())?;
        let lines = Lines::CALM;
        Ok(Self {
            outputs: Output::default(),
            feed: MotionQueue::new(arm.period),
            following: None,
            shared: None,
            report,
            heard: device.now(),
            reported: device.now(),
            device,
            arm,
            seen: presses.load(Ordering::Relaxed),
            stops: None,
            stops_seen: StopDemands::default(),
            deaf: false,
            dead_man: None,
            let_go: false,
            stopped_at: None,
            announcement: None,
            stopped: false,
            presses,
            status: None,
            statuses: 0,
            live_sent: Duration::ZERO,
            q: None,
            under_way: VecDeque::new(),
            goal: None,
            watched: 0,
            print: (0, 0),
            lines,
            past: None,
            whole: None,
            expected: None,
            asking: false,
            stopping: false,
            number: 0,
            awaited: 0,
            verdict: None,
            urgent: None,
            refused: false,
            agreed: false,
            resumed: false,
            found_driven: false,
            stale: (Vec::new(), 0),
            age_min: Vec::new(),
            samples: Samples::default(),
            judged: false,
            first_motion: FirstMotion::default(),
            heat: MotorHeat::default(),
        })
    }
}
