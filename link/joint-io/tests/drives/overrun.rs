//! Tests of overruns: the firmware's tick with a simulated clock that its parts advance. A tick is late whichever part took the time.

use crate::rig::{Rig, Uncounted};
use dynamics_core::control::{Fault, Spring};
use dynamics_core::safety::{self, SafeAction};
use joint_io::{JointIo, run_tick};
use link::{Frame, Request};
use session::meter::Meter;
use session::readings::{Lines, Readings};
use std::cell::Cell;

/// Period of the clock, us.
const PERIOD: u32 = 1000;

/// A joint with outputs that take time.
struct Slow<'a> {
    now: &'a Cell<u32>,
    drive: u32,
    drove: bool,
}

impl JointIo<1> for Slow<'_> {
    fn measure(&mut self) -> Option<Readings<1>> {
        let sensed = dynamics_core::control::Sensed::State { q: [0.0], qd: [0.0] };
        let faults = [session::readings::JointFaults::NONE];
        Some(Readings { sensed, torque: [0.0], age_ticks: [0], faults, errors: [0], on: [true], zero_lost: false })
    }
    fn enable(&mut self, _: SafeAction) {}
    fn preload(&mut self, _: &[f32; 1], _: Option<&[Spring<f32>; 1]>) {}
    fn drive(&mut self, _: &[f32; 1], _: Option<&[Spring<f32>; 1]>) {
        self.now.set(self.now.get() + self.drive);
        self.drove = true;
    }
    fn safe(&mut self, _: SafeAction) {
        self.drove = false;
    }
}

/// Runs a tick with computation and outputs of these durations, us. Returns true if it was in time, true if it drove, and the next tick's fault.
fn tick(compute: u32, drive: u32) -> (bool, bool, Option<Fault>) {
    let mut rig = Rig::<dynamics_core::drive::MiniCheetah>::new(Default::default(), SafeAction::Brake);
    let now = Cell::new(0);
    let mut joints = Slow { now: &now, drive: 0, drove: false };
    let meter = Meter::new(Uncounted);
    for (number, request) in [Request::Home, Request::Confirm, Request::Arm].into_iter().enumerate() {
        rig.receive(Frame::request(number as u8, request));
        run_tick(&mut rig.session, &mut joints, &meter, || Lines::NONE, || false);
    }
    for _ in 0..50 {
        rig.receive(Frame::Alive);
        run_tick(&mut rig.session, &mut joints, &meter, || Lines::NONE, || false);
    }
    let mut run = |joints: &mut Slow<'_>, compute: u32| {
        rig.receive(Frame::Alive);
        now.set(0);
        let lines = || {
            now.set(now.get() + compute);
            Lines::NONE
        };
        let in_time = run_tick(&mut rig.session, joints, &meter, lines, || now.get() >= PERIOD);
        (in_time, rig.state())
    };
    joints.drive = drive;
    let (in_time, _) = run(&mut joints, compute);
    let drove = joints.drove;
    joints.drive = 0;
    let (_, state) = run(&mut joints, 0);
    let fault = if let safety::State::Fault(fault) = state { Some(fault) } else { None };
    (in_time, drove, fault)
}

#[test]
fn a_tick_that_ends_after_the_next_ones_time_is_an_overrun_wherever_it_was_late() {
    assert_eq!(tick(600, 300), (true, true, None));
    // The tick becomes late during its outputs.
    for (compute, drive) in [(600, 400), (600, 1500), (990, 20)] {
        assert_eq!(tick(compute, drive), (false, true, Some(Fault::Overrun)), "{compute} + {drive} us");
    }
    // The tick is late before its outputs: its torque is not applied.
    assert_eq!(tick(1200, 20), (false, false, Some(Fault::Overrun)));
}
