//! Fuzz target: any packets, damage, readings and ticks into the firmware's session, in bench mode, in a dry run and live.
//!
//! A second session, the twin, runs at the same time. It receives only the frames that must be accepted, and reports every tick. A refused input must
//! leave no trace: both sessions must give the same results to the last bit. The campaigns' judge checks their results against
//! `docs/safety/rules.md`.

mod events;
mod ticks;
mod wire;

use crate::campaign::TickInputs;
use crate::campaign::judge::{Judge, Trust};
use crate::fuzz::FuzzTarget;
use crate::fuzz::examples::top;
use crate::fuzz::packets::{expected, taken};
use board::chip::hello;
use board::session::dry_run::{DeskSession, Uncounted, desk_session};
use dynamics_core::control::Sensed;
use dynamics_core::{ControllerConfig, Model};
use link::{DecodeError, Decoder, Encoder, Frame, Hello, Pacing, Packet, Parts, Received, Request, Watch};
use robot_compiler::SceneFile;
use session::meter::Meter;
use session::readings::{JointFaults, Lines};
use std::sync::LazyLock;

/// Sessions that reach each state and then get each kind of event.
pub const TARGET: FuzzTarget = FuzzTarget { name: "session", check, examples, words: "" };

/// Number of kinds of events.
const KINDS: u8 = 23;

/// Bounds on the work for one input.
const TICKS_MAX: u32 = 1200;
const PACKETS_MAX: usize = 700;

/// Number of old packets that can be repeated.
const PAST: usize = 64;

/// An arm with encoders and brakes, one with actuators that report their state, and one with two joints.
static ARMS: LazyLock<[SceneFile; 3]> = LazyLock::new(|| {
    ["campaign/encoders", "campaign/states", "examples/pwm2_swing"].map(|name| {
        let mut scene = SceneFile::load(&top("scenes").join(format!("{name}.toml"))).unwrap();
        scene.control.tunable = true;
        // The judge does not know the limits of a first motion.
        scene.safety.first_motion = None;
        scene
    })
});

fn examples() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for arm in 0..3 {
        for pacing in 0..4 {
            // Hello, watch everything, normal lines; then home and arm.
            let begin: &[u8] = &[arm, 3, pacing, 14, 6, 0, 0, 2, 0, 2, 1, 2, 2, 1, 3];
            // A trajectory from here to another point and back; then run along it.
            let go: &[u8] = &[5, 0, 0, 5, 20, 40, 5, 20, 0, 2, 4, 1, 5];
            // Stop, restart, then silence of the host until the fault; clear it.
            all.push([begin, go, &[2, 5, 1, 63], go, &[20, 255, 2, 6, 1, 3]].concat());
            // Press and release the emergency stop; clear in motion and at rest, and arm again.
            let motion = [7, 0, 1, 0, 0, 0, 63];
            all.push([begin, go, &[6, 1, 0, 0, 6, 0, 0], &motion, &[2, 6, 2, 6, 2, 2, 1, 3]].concat());
            // References beyond the limits at full speed, and references far from the arm.
            all.push([begin, &[5, 0, 0], &[5, 120, 127].repeat(8), &[2, 4], &[1, 63].repeat(8)].concat());
            all.push([begin, &[5, 0, 127, 5, 120, 127, 2, 4, 1, 63]].concat());
            // Change live inputs and a gain, before torque acts and during a motion; once with two changes in a tick.
            let change = [21, 1, 21, 2, 22, 16, 65, 0, 0, 22, 16, 66, 0];
            all.push([begin, &change, go, &change, &[1, 31]].concat());
            for event in 0..KINDS {
                all.push([begin, go, &[event, 1, 3, 200, 7, 0, 1, 4, 2, 5, 1, 3, 1, 31]].concat());
            }
        }
    }
    all
}

/// Checks an input; see the module's documentation.
pub fn check(bytes: &[u8]) {
    ticks_of_states(bytes);
}

/// Same as [`check`]; returns the number of ticks that ended in each state of the safety state machine, indexed by the state's number.
pub fn ticks_of_states(mut bytes: &[u8]) -> [u32; 9] {
    let arm = bytes.split_off_first().copied().unwrap_or_default();
    let scene = &ARMS[usize::from(arm) % ARMS.len()];
    match scene.robot.dof() {
        2 => Comparison::<2>::new(scene).run(bytes),
        _ => Comparison::<6>::new(scene).run(bytes),
    }
}

/// Both sessions, the link to the first one, and the arm.
struct Comparison<const N: usize> {
    own: Hello,
    config: ControllerConfig<f32, N>,
    session: DeskSession<N>,
    /// Receives the frames that must be accepted, without damage and gaps, and reports every tick.
    twin: DeskSession<N>,
    meter: Meter<Uncounted>,
    judge: Judge<N>,
    told: TickInputs<N>,
    /// The strongest request since the previous tick.
    asked: Option<Request>,
    /// Number of the last request.
    request: u8,
    /// True if a frame was accepted since the previous tick.
    spoke: bool,

    encoder: Encoder,
    decoder: Decoder,
    wire: Vec<u8>,
    results: Vec<Result<Received, DecodeError>>,
    /// Sent packets with their numbers, which start at 0 and do not wrap.
    sent: Vec<(u64, Packet)>,
    number: u64,
    /// Number of the last packet that was read whole, if it is in `sent`.
    last: Option<u64>,
    /// Number of accepted frames since the hello, including refused ones.
    taken: u16,
    ticks: u32,
    /// True if a parameter change is pending for the next tick.
    changes: bool,
    /// Number of supervised ticks, by the state at their end.
    states: [u32; 9],

    /// Position of the arm, rad; encoders may measure it.
    q: [f32; N],
    qd: [f32; N],
    counted: bool,
    /// Reading of the next tick that replaces the arm's.
    odd: Option<(Sensed<f32, N>, [u32; N], [JointFaults; N])>,
    /// Number of further ticks in which the board gets no reading.
    blind: u8,
    lines: Lines,
    /// Last point of the trajectory.
    goal: [f32; N],
}

/// Watch that reports every part in every tick.
const EVERYTHING: Frame = Frame::Watch(Watch { every: 1, parts: Parts::ALL });

impl<const N: usize> Comparison<N> {
    fn new(scene: &SceneFile) -> Self {
        let model: Model<f64, N> = scene.robot.model().unwrap();
        let config = scene.controller_config(&model);
        let q = scene.trajectory(&model).unwrap().start().cast::<f32>().q;
        Self {
            own: hello(scene, &model, Pacing::LockStep),
            session: desk_session(scene, &model),
            twin: desk_session(scene, &model),
            meter: Meter::new(Uncounted),
            judge: Judge::new(&config, &scene.safety_rules(&model), Trust::Nothing),
            told: nothing(),
            asked: None,
            request: 0,
            spoke: false,
            config: config.cast(),
            encoder: Encoder::new(),
            decoder: Decoder::new(),
            wire: Vec::new(),
            results: Vec::new(),
            sent: Vec::new(),
            number: 0,
            last: None,
            taken: 0,
            ticks: 0,
            changes: false,
            states: [0; 9],
            q,
            qd: [0.0; N],
            counted: scene.sensors.encoder,
            odd: None,
            blind: 0,
            lines: Lines::NONE,
            goal: q,
        }
    }

    fn run(mut self, mut bytes: &[u8]) -> [u32; 9] {
        while let Some(kind) = bytes.split_off_first()
            && self.ticks < TICKS_MAX
            && self.results.len() < PACKETS_MAX
        {
            self.event(kind % KINDS, &mut bytes);
        }
        // A zero ends the stream, because bytes without an end are no packet.
        self.push(&[0], None);
        assert_eq!(taken(&self.results), expected(&self.wire));
        let packets = self.wire.split(|&byte| byte == 0).filter(|packet| !packet.is_empty()).count();
        assert_eq!(self.results.len(), packets, "a packet without an answer");
        self.states
    }

    fn pacing(&self) -> Option<Pacing> {
        self.session.state().pacing()
    }
}

/// Inputs of a tick before anything has been measured or received.
const fn nothing<const N: usize>() -> TickInputs<N> {
    TickInputs {
        tick: 0,
        sensed: Sensed::State { q: [0.0; N], qd: [0.0; N] },
        age_ticks: [u32::MAX; N],
        emergency_stop: false,
        overrun: false,
        zeroed: false,
        drive_fault: [false; N],
        supply: None,
        temperature: None,
    }
}
