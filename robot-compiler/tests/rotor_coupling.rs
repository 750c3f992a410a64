//! Worst-case torque that the Puma's reflected rotor inertias omit: the greatest of each joint at full speed.
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]

use crate::common::top;
use dynamics_core::chapter::posture::Chain;
use dynamics_core::chapter::rotor_coupling::{Carried, Rotors};
use dynamics_core::trig::Libm;
use dynamics_core::{Inertia, Trig};
use robot_compiler::Robot;

const N: usize = 6;

/// An arm at full speed: its posture, and the direction of each joint.
struct Fast {
    chain: Chain<f64, N>,
    rotors: Rotors<f64, N>,
    position: [(f64, f64); N],
    speed: [f64; N],
}

#[derive(Clone, Copy)]
struct State {
    q: [f64; N],
    backwards: [bool; N],
}

impl Fast {
    fn torque(&self, joint: usize, state: &State) -> f64 {
        let posture = self.chain.posture(&Libm.sin_cos_all(&state.q), &state.q);
        let qd = std::array::from_fn(|i| if state.backwards[i] { -self.speed[i] } else { self.speed[i] });
        self.rotors.extra_torque(&posture, Carried::ByLink, &qd, &[0.0; N])[joint].abs()
    }

    /// Maximises the torque from a state, one variable after another, with ever shorter steps.
    ///
    /// At constant speed the torque is a sum of products of two different velocities, so it is linear in each. Its maximum
    /// is therefore reached with every joint at full speed, in one direction or the other.
    fn climb(&self, joint: usize, mut state: State) -> f64 {
        let mut best = self.torque(joint, &state);
        let mut step = 0.5;
        while step > 1e-6 {
            let mut tries = Vec::new();
            for i in 0..N {
                let mut turned = state;
                turned.backwards[i] = !turned.backwards[i];
                tries.push(turned);
                for signed in [step, -step] {
                    let mut moved = state;
                    moved.q[i] = (moved.q[i] + signed).clamp(self.position[i].0, self.position[i].1);
                    tries.push(moved);
                }
            }
            let uphill = tries.into_iter().map(|s| (self.torque(joint, &s), s)).max_by(|a, b| a.0.total_cmp(&b.0));
            match uphill {
                Some((higher, there)) if higher > best => (best, state) = (higher, there),
                _ => step *= 0.5,
            }
        }
        best
    }
}

#[test]
fn the_coupling_of_the_pumas_rotors_at_full_speed_is_what_was_measured() {
    let robot = Robot::load(&top("robots/puma560.toml")).unwrap();
    let spec: [_; N] = std::array::from_fn(|i| robot.joints[i].spec);
    let fast = Fast {
        chain: Chain::new(&robot.model::<N>().unwrap(), &Inertia::zero()),
        rotors: Rotors { inertia: spec.map(|s| s.rotor.inertia), gear: spec.map(|s| s.rotor.gear) },
        position: spec.map(|s| s.limits.position),
        speed: spec.map(|s| s.limits.velocity),
    };
    // All combinations of three positions per joint. The first joint only turns everything, and the last carries no
    // rotor.
    let starts: Vec<State> = (0..81_u32)
        .map(|index| State {
            q: std::array::from_fn(|i| {
                let (lo, hi) = fast.position[i];
                let third = (1..5).contains(&i).then(|| f64::from(index / 3_u32.pow(i as u32 - 1) % 3));
                lo + (hi - lo) * (0.25 + 0.25 * third.unwrap_or(1.0))
            }),
            backwards: std::array::from_fn(|i| index >> i & 1 == 1),
        })
        .collect();
    let found: [f64; N] =
        std::array::from_fn(|joint| starts.iter().map(|start| fast.climb(joint, *start)).fold(0.0, f64::max));
    // N m, base first.
    let measured = [0.186185, 0.161745, 0.161745, 0.175072, 0.156322, 0.132918];
    for (joint, found) in found.iter().enumerate() {
        let share = found / spec[joint].limits.torque;
        println!("{}: {found:.6} N m, {:.3} % of the limit", robot.joints[joint].name, 100.0 * share);
    }
    for (joint, (found, measured)) in found.iter().zip(measured).enumerate() {
        assert!((found - measured).abs() <= 1e-4 * measured, "joint {}: {found} {measured}", joint + 1);
    }
}
