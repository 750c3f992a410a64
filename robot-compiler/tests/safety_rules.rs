//! The safety rules of every shipped scene accept its own motion, and stop one that breaks them.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::panic, reason = "a test names the file that fails")]

use dynamics_core::control::LimitFlags;
use dynamics_core::safety::{HoldCause, Inputs, Output, Protected, Request, Safety, State};
use dynamics_core::{Command, Reference, Sensed};
use robot_compiler::{SceneFile, with_dof};

use crate::common::{files, top};

/// The state machine's output for an arm that is exactly at the reference.
fn tick<const N: usize>(
    machine: &mut Safety<f32, N, Protected<f32, N>>,
    request: Option<Request>,
    reference: Reference<f32, N>,
) -> Output<f32, N> {
    let inputs = Inputs {
        request,
        emergency_stop: false,
        overrun: false,
        heartbeat_age: 0,
        zeroed: true,
        sensed: Sensed::State { q: reference.q, qd: reference.qd },
        age_ticks: [0; N],
        drive_fault: [false; N],
        on: [true; N],
        zero_lost: false,
        live_age: 0,
        supply: None,
        temperature: None,
        reference: Some(reference),
    };
    machine.tick(&inputs, |_| Command::Drive { torque: [0.0; N], limits: [LimitFlags::NONE; N] })
}

#[test]
fn every_shipped_motion_runs_to_its_end_under_the_rules_of_its_scene() {
    let (mut ticks, mut stopped) = (0_u32, 0);
    for path in files(&top("scenes"), &["toml"]) {
        let scene = SceneFile::load(&path).unwrap();
        with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>().unwrap();
            let motion = scene.trajectory(&model).unwrap();
            let control = scene.controller_config(&model).cast();
            let mut machine = Safety::new(Protected { control, rules: scene.safety_rules(&model).cast() });
            let start = motion.start().cast();
            tick(&mut machine, None, start);
            for request in [Request::Home, Request::Confirm, Request::FullRange, Request::Arm, Request::Run] {
                assert_eq!(tick(&mut machine, Some(request), start).refused, None, "{}: {request:?}", scene.name);
                // Torque rises on engaged brakes.
                while machine.state() == State::Arming {
                    tick(&mut machine, None, start);
                }
            }
            for k in 0.. {
                let t = f64::from(k) * scene.period();
                let state = tick(&mut machine, None, motion.sample(t).cast()).state;
                assert_eq!(state, State::Running, "{} at {t} s", scene.name);
                ticks += 1;
                if t > motion.duration() {
                    break;
                }
            }
            // The same reference forever, but faster: every joint with a position limit is stopped before it.
            let limits = model.links().map(|link| link.limits);
            if limits[0].position.1.is_finite() && limits[0].velocity.is_finite() {
                let mut reference = motion.end().cast::<f32>();
                let speed = limits[0].velocity as f32;
                let mut state = State::Running;
                while state == State::Running {
                    reference.qd[0] = (reference.qd[0] + 0.01 * speed).min(speed);
                    reference.q[0] += reference.qd[0] * scene.period() as f32;
                    state = tick(&mut machine, None, reference).state;
                }
                assert_eq!(state, State::Holding(HoldCause::NoRoom { joint: 0 }), "{}", scene.name);
                // The default deceleration stops from the velocity limit in a quarter of a second; the latency is two
                // periods.
                let (v, a) = (f64::from(reference.qd[0]), 4.0 * limits[0].velocity);
                let needed = v * v / (2.0 * a) + v * 2.0 * scene.period();
                let room = limits[0].position.1 - f64::from(reference.q[0]);
                assert!(room < needed + 1e-4 && room > 0.8 * needed, "{}: {room} of {needed}", scene.name);
                stopped += 1;
            }
        });
    }
    assert!(ticks > 10_000 && stopped >= 5, "{ticks}, {stopped}");
}
