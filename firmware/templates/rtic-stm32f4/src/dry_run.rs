//! A test of the loop without hardware: simulated joints that follow their reference, and a simulated operator that starts a motion.
//!
//! **Do not copy the operator**: it derives its requests from the state. A real one makes each request once.

use crate::control::{Brakes, Control, Hardware};
use crate::robot::{N, RATE_HZ, Settings};
use dynamics_core::control::{Configuration, Reference, Sensed};
use dynamics_core::safety::{Inputs, Request, SafeAction, State};

/// Ticks of the test: homing, arming, a motion of one second at 1 kHz, and the arm at rest after it.
pub const TICKS: u32 = 1200;

/// Ticks of the motion.
const MOTION: u32 = 1000;

/// Length of the motion, rad or m: slow enough for the first motion after homing.
const LENGTH: f32 = 0.1;

/// Joints that are always where the reference was one tick ago.
pub struct DryRun {
    start: [f32; N],
    q: [f32; N],
    /// Ticks in which the arm has run.
    ran: u32,
    homed: bool,
    on: bool,
    /// True if the last command let torque act on released brakes.
    pub drives: bool,
    /// Pressed by a test.
    pub emergency_stop: bool,
    /// FNV-1a of every command so far.
    pub hash: u64,
}

impl DryRun {
    /// An arm at rest at `q`, rad or m.
    #[must_use]
    pub fn at(q: [f32; N]) -> Self {
        let hash = 0xcbf2_9ce4_8422_2325;
        Self { start: q, q, ran: 0, homed: false, on: false, drives: false, emergency_stop: false, hash }
    }

    /// The hash after [`TICKS`] ticks from a reset, all of them in time.
    #[must_use]
    pub fn hash_of_test() -> u64 {
        let (mut control, mut joints) = (Control::new(), Self::at(crate::TEST_POSE));
        for _ in 0..TICKS {
            control.tick(&mut joints, || false);
        }
        joints.hash
    }

    fn add(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.hash = (self.hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The reference of this tick: every joint moves by [`LENGTH`], along a quintic polynomial.
    fn reference(&self) -> Reference<f32, N> {
        let (s, rate) = (self.ran.min(MOTION) as f32 / MOTION as f32, RATE_HZ / MOTION as f32);
        let shape = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let slope = 30.0 * s * s * (1.0 - s) * (1.0 - s) * rate;
        let bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * rate * rate;
        Reference { q: self.start.map(|q| q + LENGTH * shape), qd: [LENGTH * slope; N], qdd: [LENGTH * bend; N] }
    }
}

impl Hardware for DryRun {
    fn read_encoders(&mut self, inputs: &mut Inputs<f32, N>) {
        let encoder = &Settings.get().encoder;
        inputs.sensed = Sensed::Counts(core::array::from_fn(|joint| {
            encoder.get(joint).zip(self.q.get(joint)).map_or(0, |(scale, q)| {
                let counts = q / scale.per_count;
                // Rounds to nearest: `f32::round` is not in `core`. The cast saturates.
                scale.zero.wrapping_add((counts + if counts < 0.0 { -0.5 } else { 0.5 }) as i32)
            })
        }));
        (inputs.age_ticks, inputs.zeroed, inputs.zero_lost) = ([0; N], true, false);
        (inputs.drive_fault, inputs.on) = ([false; N], [self.on; N]);
        (inputs.supply, inputs.temperature) = (None, None);
    }

    fn read_operator(&mut self, inputs: &mut Inputs<f32, N>, state: State) {
        (inputs.emergency_stop, inputs.heartbeat_age) = (self.emergency_stop, 0);
        // A simulated operator: do not copy. Requests that follow from the state would restart an arm that was stopped.
        inputs.request = match state {
            State::Idle if self.homed => Some(Request::Arm),
            State::Idle => Some(Request::Home),
            State::Homing => Some(Request::Confirm),
            State::Armed => Some(Request::Run),
            _ => None,
        };
        self.homed |= state == State::Homing;
        self.ran += u32::from(state == State::Running);
        let reference = self.reference();
        inputs.reference = Some(reference);
        self.q = reference.q;
    }

    fn enable_drives(&mut self, _action: SafeAction) {
        (self.on, self.drives) = (true, false);
        self.add(1);
    }

    fn write_torques(&mut self, torque: &[f32; N], brakes: Brakes) {
        self.drives = brakes == Brakes::Released;
        self.add(2 + u32::from(self.drives));
        for joint in torque {
            self.add(joint.to_bits());
        }
    }

    fn make_safe(&mut self, _action: SafeAction) {
        (self.on, self.drives) = (false, false);
        self.add(0);
    }
}
