//! Any packets, damage, readings and ticks into the firmware's session, on the bench, in a drill and live.
//!
//! Beside the session that hears the wire runs a second one, which hears only what must be taken and reports every tick.
//! Whatever is refused must leave no trace: both must do the same to the last bit. What they do is held to `docs/safety.md` by the
//! judge of the campaigns.

use crate::Target;
use crate::examples::top;
use crate::packets::{all_bits, expected, frame, taken};
use dynamics_core::control::Sensed;
use dynamics_core::{ControllerConfig, Model, Reference};
use host_sim::chip::hello;
use host_sim::session::drill::{DeskSession, Uncounted, desk_session};
use host_sim::study::campaign::judge::{Heard, Judge, Trust};
use host_sim::study::campaign::{Said, Told};
use link::{
    DecodeError, Decoder, Encoder, Frame, Hello, Measurement, Pacing, Packet, Parts, Point, Received, Refusal, Request,
    Setting, Status, Watch,
};
use robot_compiler::SceneFile;
use session::black_box::Report;
use session::meter::Meter;
use session::readings::Lines;
use session::readings::{JointFaults, Readings};
use session::{Drives, Reaction, State};
use std::sync::LazyLock;

/// Sessions that come as far as they can and then meet each event.
pub const TARGET: Target = Target { name: "session", check, examples, words: &[] };

/// Kinds of events.
const KINDS: u8 = 23;

/// Bounds of one input's work.
const TICKS_MAX: u32 = 1200;
const PACKETS_MAX: usize = 700;

/// Packets that can come again.
const PAST: usize = 64;

/// An arm that is measured by encoders and brakes, one whose actuators report their state, and one of two joints.
static ARMS: LazyLock<[SceneFile; 3]> = LazyLock::new(|| {
    ["campaign/encoders", "campaign/states", "examples/pwm2_swing"].map(|name| {
        let mut scene = SceneFile::load(&top("scenes").join(format!("{name}.toml"))).unwrap();
        scene.control.tunable = true;
        scene
    })
});

fn examples() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for arm in 0..3 {
        for pacing in 0..4 {
            // Hello, everything watched, the board's lines calm; homed and armed.
            let begin: &[u8] = &[arm, 3, pacing, 14, 6, 0, 0, 2, 0, 2, 1, 2, 2, 1, 3];
            // A trajectory from here, to there and back, and on its way.
            let go: &[u8] = &[5, 0, 0, 5, 20, 40, 5, 20, 0, 2, 4, 1, 5];
            // Stopped, off again, then no word from the host until the arm is at fault; cleared.
            all.push([begin, go, &[2, 5, 1, 63], go, &[20, 255, 2, 6, 1, 3]].concat());
            // Pressed and released; cleared in motion and at rest, and armed again.
            let motion = [7, 0, 1, 0, 0, 0, 63];
            all.push([begin, go, &[6, 1, 0, 0, 6, 0, 0], &motion, &[2, 6, 2, 6, 2, 2, 1, 3]].concat());
            // Beyond the limits as fast as can be; and from where the arm is not.
            all.push([begin, &[5, 0, 0], &[5, 120, 127].repeat(8), &[2, 4], &[1, 63].repeat(8)].concat());
            all.push([begin, &[5, 0, 127, 5, 120, 127, 2, 4, 1, 63]].concat());
            // Other live inputs and another gain, before torque acts and on the way, one of two in a tick.
            let change = [21, 1, 21, 2, 22, 16, 65, 0, 0, 22, 16, 66, 0];
            all.push([begin, &change, go, &change, &[1, 31]].concat());
            for event in 0..KINDS {
                all.push([begin, go, &[event, 1, 3, 200, 7, 0, 1, 4, 2, 5, 1, 3, 1, 31]].concat());
            }
        }
    }
    all
}

/// See the module.
pub fn check(bytes: &[u8]) {
    ticks_of_states(bytes);
}

/// As [`check`]: how many ticks ended in each state of the safety state machine, by its number.
pub fn ticks_of_states(mut bytes: &[u8]) -> [u32; 6] {
    let arm = bytes.split_off_first().copied().unwrap_or_default();
    let scene = &ARMS[usize::from(arm) % ARMS.len()];
    match scene.robot.dof() {
        2 => Bench::<2>::new(scene).run(bytes),
        _ => Bench::<6>::new(scene).run(bytes),
    }
}

/// Both sessions, the wire to the first, and the arm.
struct Bench<const N: usize> {
    own: Hello,
    config: ControllerConfig<f32, N>,
    session: DeskSession<N>,
    /// Hears what must be taken, without damage and gaps, and reports every tick.
    twin: DeskSession<N>,
    meter: Meter<Uncounted>,
    judge: Judge<N>,
    told: Told<N>,
    /// The last of the requests since the tick before.
    asked: Option<Request>,
    /// A frame was taken since the tick before.
    spoke: bool,

    encoder: Encoder,
    decoder: Decoder,
    wire: Vec<u8>,
    results: Vec<Result<Received, DecodeError>>,
    /// Packets sent, with their numbers from 0, which do not wrap.
    sent: Vec<(u64, Packet)>,
    number: u64,
    /// The number of the last packet that was read whole, if it was one of these.
    last: Option<u64>,
    /// Frames taken since the hello, refused ones too.
    taken: u16,
    ticks: u32,
    /// A change waits for its tick.
    changes: bool,
    /// Ticks under supervision, by the state that they ended in.
    states: [u32; 6],

    /// Where the arm is, and whether encoders measure it.
    q: [f32; N],
    qd: [f32; N],
    counted: bool,
    /// What the next tick reads in place of that.
    odd: Option<(Sensed<f32, N>, [u32; N], [JointFaults; N])>,
    /// Ticks for which the board reads nothing.
    blind: u8,
    lines: Lines,
    /// The last point of the trajectory.
    goal: [f32; N],
}

/// All parts of every tick.
const EVERYTHING: Frame = Frame::Watch(Watch { every: 1, parts: Parts::ALL });

impl<const N: usize> Bench<N> {
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
            states: [0; 6],
            q,
            qd: [0.0; N],
            counted: scene.sensors.encoder,
            odd: None,
            blind: 0,
            lines: Lines::NONE,
            goal: q,
        }
    }

    fn run(mut self, mut bytes: &[u8]) -> [u32; 6] {
        while let Some(kind) = bytes.split_off_first()
            && self.ticks < TICKS_MAX
            && self.results.len() < PACKETS_MAX
        {
            self.event(kind % KINDS, &mut bytes);
        }
        // The wire ends in a zero: what has no end is no packet.
        self.push(&[0], None);
        assert_eq!(taken(&self.results), expected(&self.wire));
        let packets = self.wire.split(|&byte| byte == 0).filter(|packet| !packet.is_empty()).count();
        assert_eq!(self.results.len(), packets, "a packet without an answer");
        self.states
    }

    fn event(&mut self, kind: u8, bytes: &mut &[u8]) {
        let mut next = || bytes.split_off_first().copied().unwrap_or_default();
        match kind {
            0 => self.time(),
            1 => {
                for _ in 0..next() % 64 {
                    self.send(&Frame::Alive);
                    self.time();
                }
            }
            2 => {
                let all = [Request::Home, Request::Confirm, Request::Arm, Request::Disarm, Request::Run];
                let more = [Request::Hold, Request::Clear];
                let asked = usize::from(next()) % 7;
                self.send(&Frame::Request(all.iter().chain(&more).copied().nth(asked).unwrap()));
                self.time();
            }
            3 => {
                let byte = next();
                let pacing = [Pacing::Live, Pacing::Drill, Pacing::Timer, Pacing::LockStep][usize::from(byte % 4)];
                let robot = self.own.robot ^ u64::from(byte > 250);
                self.send(&Frame::Hello(Hello { pacing, robot, ..self.own }));
            }
            4 => {
                let any = frame(bytes);
                self.send(&any);
            }
            5 => {
                // From nothing to half a radian, most of them little.
                let (ticks, step) = (next(), 0.5 * (f32::from(next().cast_signed()) / 127.0).powi(3));
                let from = if ticks == 0 { self.q } else { self.goal };
                self.goal = from.map(|q| q + step);
                let reference = link::Reference::new(&Reference::at_rest(self.goal));
                self.send(&Frame::Point(Point { ticks: u16::from(ticks), reference }));
            }
            6 => self.lines(next(), next()),
            7 => {
                let (joint, what) = (usize::from(next()) % N, next());
                let value = f32::from_le_bytes([next(), next(), next(), next()]);
                let (mut sensed, mut ages, mut faults) = (self.reading(), [0; N], [JointFaults::NONE; N]);
                match (&mut sensed, what % 4) {
                    (Sensed::State { q, .. }, 0) => q[joint] = value,
                    (Sensed::State { qd, .. }, 1) => qd[joint] = value,
                    (Sensed::Counts(counts), 0 | 1) => {
                        counts[joint] = counts[joint].wrapping_add(value.to_bits().cast_signed() >> (what >> 4));
                    }
                    (_, 2) => ages[joint] = u32::from(what >> 2),
                    _ => faults[joint] = JointFaults::NAMES[usize::from(what >> 2) % 8].0,
                }
                self.odd = Some((sensed, ages, faults));
            }
            8 => {
                let back = self.sent.len().saturating_sub(1 + usize::from(next()) % PAST);
                let again: Vec<_> = self.sent.iter().skip(back).take(1 + usize::from(next() % 4)).cloned().collect();
                for (number, packet) in again {
                    self.push(&packet, Some(number));
                }
            }
            9 => {
                for _ in 0..next() {
                    self.encoder.encode(&Frame::Alive).unwrap();
                    self.number += 1;
                }
            }
            10 => {
                let (keep, ended) = (usize::from(next()), next() % 2 == 1);
                let packet = self.pack(&frame(bytes));
                self.push(&packet[..keep % packet.len()], None);
                if ended {
                    self.push(&[0], None);
                }
            }
            11 => {
                let bit = usize::from(u16::from_le_bytes([next(), next()]));
                let mut packet = self.pack(&frame(bytes));
                let at = bit / 8 % packet.len();
                packet[at] ^= 1 << (bit % 8);
                self.push(&packet, None);
            }
            12 => {
                let length = usize::from(next()).min(bytes.len());
                let noise = bytes.split_off(..length).unwrap_or_default();
                self.push(noise, None);
            }
            13 => {
                let (first, second) = (frame(bytes), frame(bytes));
                let (early, first) = (self.number, self.pack(&first));
                self.send(&second);
                self.push(&first, Some(early));
            }
            14 => self.send(&EVERYTHING),
            15 => {
                self.session.overrun();
                self.twin.overrun();
                self.told.overrun = true;
            }
            16 => self.blind = next() % 32,
            17 => self.counted = !self.counted,
            18 => {
                // A flood of packets without a tick in between.
                for _ in 0..next() {
                    self.send(&Frame::Alive);
                }
            }
            19 => self.send(&Frame::Dump),
            21 => {
                let mut live = dynamics_core::Live::<f32, N>::zero();
                (live.payload.mass, live.gravity.z) = (f32::from(next()) / 64.0, -9.81);
                self.send(&Frame::Live(link::Live::new(&live).unwrap()));
            }
            22 => {
                let (index, share) = (next(), f32::from(next()) / 64.0);
                let value = share * self.config.gains[usize::from(index / 16) % N].position;
                self.send(&Frame::Set(Setting { index, value }));
            }
            _ => {
                // Nothing comes but noise and what came before.
                for tick in 0..4 * u32::from(next()) {
                    match self.sent.last().cloned() {
                        Some((number, packet)) if tick % 2 == 0 => self.push(&packet, Some(number)),
                        _ => self.push(&[7, 0], None),
                    }
                    self.time();
                }
            }
        }
    }

    /// What the lines of the board say from now on; in a drill the host says it.
    fn lines(&mut self, bits: u8, drive_fault: u8) {
        let value = |choice: u8, inside: f32| [None, Some(inside), Some(-1e3), Some(f32::NAN)][usize::from(choice % 4)];
        let (emergency_stop, supply, temperature) = (bits & 1 == 1, value(bits >> 1, 24.0), value(bits >> 3, 20.0));
        self.lines = Lines { emergency_stop, supply, temperature };
        if self.pacing() == Some(Pacing::Drill) {
            let (overrun, zeroed) = (bits & 32 != 0, bits & 64 == 0);
            let lines = link::Lines { emergency_stop, overrun, zeroed, drive_fault, supply, temperature };
            self.send(&Frame::Lines(lines));
        }
    }

    fn pacing(&self) -> Option<Pacing> {
        self.session.state().pacing()
    }

    /// A packet that is still to be sent.
    fn pack(&mut self, frame: &Frame) -> Packet {
        let packet = self.encoder.encode(frame).unwrap();
        if self.sent.len() == PAST {
            self.sent.remove(0);
        }
        self.sent.push((self.number, packet.clone()));
        self.number += 1;
        packet
    }

    fn send(&mut self, frame: &Frame) {
        let (number, packet) = (self.number, self.pack(frame));
        self.push(&packet, Some(number));
    }

    /// Put bytes on the wire; the number of the packet, if they are a whole one.
    fn push(&mut self, bytes: &[u8], number: Option<u64>) {
        self.wire.extend_from_slice(bytes);
        for &byte in bytes {
            if let Some(result) = self.decoder.push(byte) {
                self.results.push(result.clone());
                self.hear(result, number);
            }
        }
    }

    /// The session takes what the link received, and the other one what must count of it.
    fn hear(&mut self, result: Result<Received, DecodeError>, number: Option<u64>) {
        let before = self.session.state();
        let reaction = self.session.receive(result.clone());
        let Received { frame, missed } = match result {
            Ok(received) => received,
            Err(error) => return self.is_refused(&reaction, Refusal::Undecodable(error), before),
        };
        self.taken = self.taken.wrapping_add(1);
        let last = core::mem::replace(&mut self.last, number);
        if let Frame::Hello(theirs) = &frame {
            return self.greeted(*theirs, &reaction);
        }
        let stops = matches!(frame, Frame::Request(Request::Hold));
        if let (Some(number), Some(last)) = (number, last)
            && number <= last
            && last - number < 255
        {
            assert!(missed > 0, "packet {number} was taken behind {last}");
        }
        if missed > 0 && !stops {
            return self.is_refused(&reaction, Refusal::Lost { missed }, before);
        }

        // It is the second session's own watch.
        let heard = if matches!(frame, Frame::Watch(_)) { Frame::Alive } else { frame.clone() };
        let other = self.twin.receive(Ok(Received { frame: heard, missed: 0 }));
        assert_eq!(bits(&reaction), bits(&other), "{reaction:?} and {other:?}");
        assert_eq!((self.session.state(), self.twin.state()), (before, before), "a frame did what a tick does");
        if let Some(pacing) = before.pacing().filter(|pacing| pacing.is_supervised()) {
            self.tell(pacing, &frame, &reaction);
            let taken = reaction == Reaction::None && matches!(frame, Frame::Live(_) | Frame::Set(_));
            assert!(!(taken && self.changes), "two changes wait for one tick: {frame:?}");
            self.changes |= taken && matches!(before, State::Supervised(_, state) if state.drives());
        }
        match (&reaction, before.pacing()) {
            (Reaction::Tick, Some(Pacing::LockStep | Pacing::Drill)) => self.tick(),
            (Reaction::None | Reaction::Reply(_), Some(_)) => {}
            (Reaction::Reply(Frame::Refusal(Refusal::NoHello)), None) => {}
            other => panic!("{frame:?} led to {other:?}"),
        }
    }

    /// What a frame tells the machine.
    fn tell(&mut self, pacing: Pacing, frame: &Frame, reaction: &Reaction) {
        self.spoke = true;
        if matches!(reaction, Reaction::Reply(Frame::Refusal(_))) {
            return;
        }
        match frame {
            Frame::Request(request) => self.asked = Some(*request),
            Frame::Measurement(measurement) => {
                self.told.sensed = measurement.sensed.to_core().unwrap();
                self.told.age_ticks = [measurement.age_ticks; N];
            }
            Frame::Lines(lines) => {
                assert!(pacing == Pacing::Drill, "the board's own lines count");
                self.told.emergency_stop = lines.emergency_stop;
                self.told.overrun |= lines.overrun;
                self.told.zeroed = lines.zeroed;
                self.told.drive_fault = core::array::from_fn(|i| lines.drive_fault >> i & 1 == 1);
                (self.told.supply, self.told.temperature) = (lines.supply, lines.temperature);
            }
            _ => {}
        }
    }

    /// Refused by this name, and nothing has changed.
    fn is_refused(&self, reaction: &Reaction, refusal: Refusal, before: State) {
        assert_eq!(*reaction, Reaction::Reply(Frame::Refusal(refusal)));
        assert_eq!(self.session.state(), before);
    }

    /// A hello starts afresh, for the robot that it is, and stops for any other.
    fn greeted(&mut self, theirs: Hello, reaction: &Reaction) {
        let own = Hello { pacing: theirs.pacing, ..self.own };
        let answer = Frame::Hello(own);
        let state = if own != theirs {
            assert_eq!(*reaction, Reaction::Stop(answer, Frame::Refusal(Refusal::OtherRobot)));
            State::Waiting
        } else {
            assert_eq!(*reaction, Reaction::Start(theirs.pacing, answer));
            match theirs.pacing {
                pacing if pacing.is_supervised() => State::Supervised(pacing, dynamics_core::safety::State::Idle),
                pacing => State::Bench(pacing, None),
            }
        };
        assert_eq!(self.session.state(), state);
        let other = self.twin.receive(Ok(Received { frame: Frame::Hello(theirs), missed: 0 }));
        assert_eq!(*reaction, other);
        self.judge.reset();
        (self.told, self.asked, self.spoke) = (nothing(), None, false);
        (self.taken, self.changes) = (0, false);
        if own == theirs && theirs.pacing.is_supervised() {
            self.twin.receive(Ok(Received { frame: EVERYTHING, missed: 0 }));
        }
    }

    /// What measures the arm says of it.
    fn reading(&self) -> Sensed<f32, N> {
        if !self.counted {
            return Sensed::State { q: self.q, qd: self.qd };
        }
        Sensed::Counts(core::array::from_fn(|i| {
            let encoder = &self.config.encoder[i];
            encoder.zero.wrapping_add((self.q[i] / encoder.per_count).round() as i32)
        }))
    }

    /// It is time for a tick: the board's timer says so, or a measurement of the host.
    fn time(&mut self) {
        if self.pacing().is_some_and(Pacing::is_lock_step) {
            let (sensed, ages, _) = self.odd.take().unwrap_or((self.reading(), [0; N], [JointFaults::NONE; N]));
            let age_ticks = ages.into_iter().max().unwrap_or(0);
            let measurement = Measurement { tick: self.ticks, age_ticks, sensed: link::Sensed::new(&sensed) };
            self.send(&Frame::Measurement(measurement));
        } else {
            self.tick();
        }
    }

    /// What the board's own lines and joints say, which counts in a live session alone.
    fn sense(&mut self) {
        let (sensed, age_ticks, faults) = self.odd.take().unwrap_or((self.reading(), [0; N], [JointFaults::NONE; N]));
        let sees = self.blind == 0;
        self.blind = self.blind.saturating_sub(1);
        let readings = sees.then_some(Readings { sensed, torque: [0.0; N], age_ticks, faults });
        self.session.sense(readings.as_ref(), &self.lines);
        self.twin.sense(readings.as_ref(), &self.lines);
        if self.pacing() != Some(Pacing::Live) {
            return;
        }
        self.told.emergency_stop = self.lines.emergency_stop;
        (self.told.supply, self.told.temperature) = (self.lines.supply, self.lines.temperature);
        if sees {
            (self.told.sensed, self.told.age_ticks) = (sensed, age_ticks);
            // A missing measurement is known by its age.
            self.told.drive_fault = faults.map(|faults| faults.bits() & !JointFaults::MISSING.bits() != 0);
            self.told.zeroed = !faults.iter().any(|faults| faults.contains(JointFaults::LOST));
        }
    }

    /// A tick of both sessions.
    fn tick(&mut self) {
        self.ticks += 1;
        self.sense();
        let drives = self.session.tick(&self.meter);
        let same = self.twin.tick(&self.meter);
        assert_eq!(torque_bits(&drives), torque_bits(&same), "{drives:?} and {same:?}");
        let (said, full) = (said(&mut self.session), said(&mut self.twin));
        let (status, answers) = split(said);
        let (complete, others) = split(full);
        assert!(answers.iter().map(all_bits).eq(others.iter().map(all_bits)), "{answers:?} and {others:?}");
        match self.pacing() {
            Some(pacing) if pacing.is_supervised() => {
                let complete = complete.unwrap();
                if let Some(status) = status {
                    self.agree(&status, &complete);
                }
                self.judge(pacing, &drives, &complete);
                self.states[usize::from(complete.state)] += 1;
                self.move_arm(&complete);
            }
            _ => {
                assert!(matches!(drives, Drives::Safe(_)), "driven on the bench: {drives:?}");
                assert!(status.is_none() && complete.is_none(), "a status on the bench");
                answers.iter().for_each(|answer| self.keeps_limits(answer));
            }
        }
        // A tick has passed, and nothing new has come.
        (self.asked, self.spoke, self.changes, self.told.overrun) = (None, false, false, false);
        self.told.age_ticks = self.told.age_ticks.map(|age| age.saturating_add(1));
    }

    /// Hold a tick under supervision to the laws of safety.
    fn judge(&mut self, pacing: Pacing, drives: &Drives<N>, status: &Status) {
        let heard = Heard { requests: self.asked.as_slice(), spoke: self.spoke, exact: true };
        self.told.tick = self.ticks;
        let acts = self.judge.acts(pacing, drives, status);
        let judged =
            acts.and_then(|drives| self.judge.watch(&self.told, &heard, &Said { drives, status: status.clone() }));
        if let Err(broken) = judged {
            panic!("{broken:?}: told {:?}, heard {heard:?}, {drives:?}, {status:?}", self.told);
        }
    }

    /// A report is what happened, as far as it goes.
    fn agree(&self, status: &Status, complete: &Status) {
        assert_eq!(status.taken, self.taken, "frames taken");
        let cut = Status {
            taken: status.taken,
            actuation: complete.actuation.clone().filter(|_| status.actuation.is_some()),
            sensed: complete.sensed.clone().filter(|_| status.sensed.is_some()),
            reference: complete.reference.clone().filter(|_| status.reference.is_some()),
            ..complete.clone()
        };
        let (a, b) = (Frame::Status(status.clone()), Frame::Status(cut));
        assert_eq!(all_bits(&a), all_bits(&b), "{a:?} and {b:?}");
    }

    /// A command of the bench is torque inside the limits.
    fn keeps_limits(&self, answer: &Frame) {
        if let Frame::Command(command) = answer {
            for (tau, limits) in command.torque.iter().zip(&self.config.limits) {
                assert!(tau.is_finite() && tau.abs() <= limits.torque, "{command:?}");
            }
        }
    }

    /// The arm is where the reference was, or stands.
    fn move_arm(&mut self, status: &Status) {
        let reference = status.reference.as_ref().filter(|_| status.state == 3);
        match reference.map(|reference| reference.to_core::<N>().unwrap()) {
            Some(Reference { q, qd, .. }) => (self.q, self.qd) = (q, qd),
            None => self.qd = [0.0; N],
        }
    }
}

/// Inputs of a tick when nobody has said anything.
const fn nothing<const N: usize>() -> Told<N> {
    Told {
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

/// All that a session has to say.
fn said<const N: usize>(session: &mut DeskSession<N>) -> Vec<Frame> {
    core::iter::from_fn(|| session.say()).map(Report::frame).collect()
}

/// The status of the tick, and all else; of a tick out of the black box what does not depend on the wire.
fn split(said: Vec<Frame>) -> (Option<Status>, Vec<Frame>) {
    let mut status = None;
    let mut others = Vec::new();
    for frame in said {
        match frame {
            Frame::Status(only) => assert!(status.replace(only).is_none(), "two statuses of a tick"),
            Frame::Past(Some(past)) => others.push(Frame::Past(Some(Status { taken: 0, ..past }))),
            other => others.push(other),
        }
    }
    (status, others)
}

/// A reaction, as bytes: `==` would not hold of a NaN.
fn bits(reaction: &Reaction) -> Vec<u8> {
    match reaction {
        Reaction::None => vec![0],
        Reaction::Tick => vec![1],
        Reaction::Reply(frame) => all_bits(frame),
        Reaction::Stop(first, second) => [all_bits(first), all_bits(second)].concat(),
        Reaction::Start(_, frame) => all_bits(frame),
    }
}

fn torque_bits<const N: usize>(drives: &Drives<N>) -> Option<[u32; N]> {
    match drives {
        Drives::Drive(torque) => Some(torque.map(f32::to_bits)),
        Drives::Safe(_) => None,
    }
}
