//! Tests of the loop on your computer. The same file in every template.

use arm_firmware::control::{Brakes, Control, Hardware};
use arm_firmware::dry_run::{DryRun, TICKS};
use arm_firmware::joints::Joints;
use arm_firmware::robot::N;
use arm_firmware::{GOLDEN, TEST_POSE};
use dynamics_core::control::Fault;
use dynamics_core::safety::{HoldCause, Inputs, Refusal, Request, SafeAction, State};
use embedded_hal::digital::{ErrorType, OutputPin};
use std::cell::Cell;
use std::convert::Infallible;

/// Runs the simulated arm until it has moved for half of its way.
fn running() -> (Control, DryRun) {
    let (mut control, mut joints) = (Control::new(), DryRun::at(TEST_POSE));
    for _ in 0..TICKS / 2 {
        assert!(control.tick(&mut joints, || false));
    }
    assert!(joints.drives && control.state() == State::Running, "{:?}", control.state());
    (control, joints)
}

#[test]
fn the_simulated_arm_gives_the_golden_hash() {
    let hash = DryRun::hash_of_test();
    assert_eq!(hash, GOLDEN, "if you changed the arm: GOLDEN is now 0x{hash:016x}");
}

#[test]
fn a_late_tick_ends_the_torque_at_once_and_raises_a_fault() {
    // Late before the outputs, and late after them only.
    for late in [0, 1] {
        let (mut control, mut joints) = running();
        let asked = Cell::new(0);
        assert!(!control.tick(&mut joints, || asked.replace(asked.get() + 1) >= late));
        assert!(!joints.drives);
        assert!(control.tick(&mut joints, || false));
        assert_eq!(control.state(), State::Fault(Fault::Overrun));
        assert!(!joints.drives);
    }
}

#[test]
fn the_emergency_stop_ends_the_torque_in_its_tick() {
    let (mut control, mut joints) = running();
    joints.emergency_stop = true;
    control.tick(&mut joints, || false);
    assert_eq!(control.state(), State::Fault(Fault::EmergencyStop));
    assert!(!joints.drives);
}

/// The simulated arm, with inputs that a test changes after they were read.
struct Altered<F> {
    joints: DryRun,
    alter: F,
}

impl<F: FnMut(&mut Inputs<f32, N>)> Hardware for Altered<F> {
    fn read_encoders(&mut self, inputs: &mut Inputs<f32, N>) {
        self.joints.read_encoders(inputs);
    }

    fn read_operator(&mut self, inputs: &mut Inputs<f32, N>, state: State) {
        self.joints.read_operator(inputs, state);
        (self.alter)(inputs);
    }

    fn enable_drives(&mut self, action: SafeAction) {
        self.joints.enable_drives(action);
    }

    fn write_torques(&mut self, torque: &[f32; N], brakes: Brakes) {
        self.joints.write_torques(torque, brakes);
    }

    fn make_safe(&mut self, action: SafeAction) {
        self.joints.make_safe(action);
    }
}

/// Sets an input to the second argument's.
type Forget = fn(&mut Inputs<f32, N>, Inputs<f32, N>);

/// Runs one tick with changed inputs.
fn tick_with(control: &mut Control, joints: DryRun, alter: impl FnMut(&mut Inputs<f32, N>)) -> DryRun {
    let mut altered = Altered { joints, alter };
    control.tick(&mut altered, || false);
    altered.joints
}

#[test]
fn a_tick_in_which_one_input_was_forgotten_lets_no_torque_act() {
    let unknown = Inputs::unknown;
    let forget: [Forget; 8] = [
        |inputs, unknown| inputs.sensed = unknown.sensed,
        |inputs, unknown| inputs.age_ticks = unknown.age_ticks,
        |inputs, unknown| inputs.zero_lost = unknown.zero_lost,
        |inputs, unknown| inputs.drive_fault = unknown.drive_fault,
        |inputs, unknown| inputs.on = unknown.on,
        |inputs, unknown| inputs.supply = unknown.supply,
        |inputs, unknown| inputs.temperature = unknown.temperature,
        |inputs, unknown| inputs.emergency_stop = unknown.emergency_stop,
    ];
    for (number, forget) in forget.into_iter().enumerate() {
        let (mut control, joints) = running();
        let joints = tick_with(&mut control, joints, |inputs| forget(inputs, unknown()));
        assert!(!joints.drives, "input {number}");
        assert!(matches!(control.state(), State::Fault(_)), "input {number}: {:?}", control.state());
    }
    // Before the first torque, too.
    let (mut control, mut joints) = (Control::new(), DryRun::at(TEST_POSE));
    for _ in 0..TICKS {
        joints = tick_with(&mut control, joints, |inputs| inputs.sensed = unknown().sensed);
        assert!(!joints.drives && !control.homed());
    }
}

/// Runs the simulated arm until it rests at the end of its motion.
fn arrived() -> (Control, DryRun) {
    let (mut control, mut joints) = (Control::new(), DryRun::at(TEST_POSE));
    for _ in 0..TICKS {
        control.tick(&mut joints, || false);
    }
    assert_eq!(control.state(), State::Running);
    (control, joints)
}

#[test]
fn a_latched_run_does_not_restart_an_arm_that_was_held() {
    let (mut control, mut joints) = arrived();
    joints = tick_with(&mut control, joints, |inputs| inputs.request = Some(Request::Run));
    assert_eq!(control.refused(), Some((Request::Run, Refusal::WrongState)));
    // The host falls silent, and its messages are lost; then it returns, with the same request.
    let hold = State::Holding(HoldCause::HeartbeatLost);
    for request in [Some(Request::Run), None, Some(Request::Run)] {
        joints = tick_with(&mut control, joints, |inputs| (inputs.request, inputs.heartbeat_age) = (request, u32::MAX));
        assert_eq!(control.state(), hold);
    }
    joints = tick_with(&mut control, joints, |inputs| (inputs.request, inputs.heartbeat_age) = (None, u32::MAX));
    for _ in 0..TICKS {
        joints = tick_with(&mut control, joints, |inputs| inputs.request = Some(Request::Run));
        assert_eq!(control.state(), hold);
    }
    // The operator lets go of the button, and presses it again.
    joints = tick_with(&mut control, joints, |inputs| inputs.request = None);
    joints = tick_with(&mut control, joints, |inputs| inputs.request = Some(Request::Run));
    assert_eq!((control.state(), control.refused()), (State::Running, None));
    assert!(joints.drives);
}

#[test]
fn a_rejection_stays_readable_and_a_held_stop_is_no_error() {
    let (mut control, mut joints) = (Control::new(), DryRun::at(TEST_POSE));
    for _ in 0..3 {
        joints = tick_with(&mut control, joints, |inputs| inputs.request = Some(Request::Arm));
        assert_eq!((control.state(), control.refused()), (State::Idle, Some((Request::Arm, Refusal::NotHomed))));
    }
    for (request, homed) in [(Request::Home, false), (Request::Confirm, true)] {
        joints = tick_with(&mut control, joints, |inputs| inputs.request = Some(request));
        assert_eq!((control.homed(), control.refused()), (homed, None));
    }
    // A held stop acts in every tick.
    for _ in 0..2 {
        joints = tick_with(&mut control, joints, |inputs| inputs.request = Some(Request::Stop));
        assert_eq!(control.state(), State::Fault(Fault::EmergencyStop));
    }
    assert!(!joints.drives);
}

/// A line of the chip that remembers whether it was ever high.
struct Line<'a>(&'a Cell<bool>);

impl ErrorType for Line<'_> {
    type Error = Infallible;
}

impl OutputPin for Line<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

/// The joints as shipped, with an operator who asks for everything.
struct Eager<'a>(Joints<Line<'a>, Line<'a>>, usize);

impl Hardware for Eager<'_> {
    fn read_encoders(&mut self, inputs: &mut Inputs<f32, N>) {
        self.0.read_encoders(inputs);
    }

    fn read_operator(&mut self, inputs: &mut Inputs<f32, N>, state: State) {
        self.0.read_operator(inputs, state);
        let all = [Request::Clear, Request::Home, Request::Confirm, Request::Arm, Request::Run];
        inputs.request = all.get(self.1 % all.len()).copied();
        self.1 += 1;
    }

    fn enable_drives(&mut self, action: SafeAction) {
        self.0.enable_drives(action);
    }

    fn write_torques(&mut self, torque: &[f32; N], brakes: Brakes) {
        self.0.write_torques(torque, brakes);
    }

    fn make_safe(&mut self, action: SafeAction) {
        self.0.make_safe(action);
    }
}

#[test]
fn as_shipped_nothing_is_energised() {
    let high = Cell::new(false);
    let joints = Joints { drives: Line(&high), brakes: Line(&high) };
    let (mut control, mut joints) = (Control::new(), Eager(joints, 0));
    for _ in 0..TICKS {
        assert!(control.tick(&mut joints, || false));
        assert_eq!(control.state(), State::Fault(Fault::EmergencyStop));
    }
    assert!(!high.get(), "after you have written joints.rs, delete this test");
}
