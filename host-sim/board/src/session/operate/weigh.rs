//! Estimate of the payload from slow motions of the arm: the command `weigh`.

use super::arm::Arm;
use super::samples::Sample;
use super::scene_arm::ArmModel;
use super::{Operator, Stop};
use dynamics_core::Inertia;
use identification::log::Log;
use identification::payload::Payload;

/// Distance that every joint moves, rad or m; and the duration as a multiple of the shortest possible one.
const REACH: f64 = 0.35;
const SLOWER: f64 = 2.0;

/// Directions of the joints in each of the four motions: bit `i` is joint `i`, 1 is the positive direction.
const WAYS: [u32; 4] = [0b11_0101, 0b00_1010, 0b10_0110, 0b01_1001];

/// Half-width of the reported interval, in standard deviations.
const WIDE: f64 = 1.96;

/// Fewest samples for an estimate.
const SAMPLES_MIN: usize = 100;

impl Operator {
    /// Moves all joints slightly back and forth, four times. Reports the estimated payload and sends it to the board.
    ///
    /// The arm's own model and friction, from the scene, count as exact.
    pub(super) fn weigh(&mut self) -> Result<(), Stop> {
        if !self.arm.payload_is_live {
            return self.reject("weigh", "the scene has no live payload; `payload = \"live\"` in its [model]");
        }
        if !self.may_test("weigh")? || !self.torque_is_believed()? {
            return Ok(());
        }
        let here = self.here()?;
        self.watch(1)?;
        let mut samples: Vec<Sample> = Vec::new();
        for way in WAYS {
            let there = self.beside(&here, way);
            let time = SLOWER * self.way("weigh", &here, &there, None)?.0.duration();
            self.samples.keep((2.5 * time / self.arm.period) as usize);
            if let Some(denial) = self.back_and_forth("weigh", here.clone(), there, time)? {
                self.watch_as_before()?;
                return self.answer("weigh", Some(denial), "");
            }
            samples.extend(self.samples.all().cloned());
        }
        self.watch_as_before()?;
        if !self.drives() || samples.len() < SAMPLES_MIN {
            return self.reject("weigh", &format!("it did not come to its end: {}", self.doing()));
        }
        let held = self.arm.model.weigh(&log(&samples, &self.arm), &self.arm.friction);
        let (text, goal) = in_words(&held, self.arm.model.as_ref());
        self.say("weigh", &format!("weigh: {text}"))?;
        self.take_up("weigh", &goal)
    }

    /// A position near this one. Each joint moves in the direction of its bit, or in the other one if that has more free range.
    fn beside(&self, here: &[f64], way: u32) -> Vec<f64> {
        let place = |(joint, (&at, &(low, high))): (usize, (&f64, &(f64, f64)))| {
            let up = way >> joint & 1 == 1;
            let room = if up { high - at } else { at - low };
            let other = if up { at - low } else { high - at };
            let (up, room) = if room >= REACH.min(other) { (up, room) } else { (!up, other) };
            let step = REACH.min(0.5 * room).max(0.0);
            if up { at + step } else { at - step }
        };
        here.iter().zip(&self.arm.range).enumerate().map(place).collect()
    }
}

/// Converts samples to a log. Missed ticks are gaps in its time.
fn log(samples: &[Sample], arm: &Arm) -> Log {
    let first = samples.first().map_or(0, |sample| sample.tick);
    let mut ordered: Vec<&Sample> = samples.iter().collect();
    ordered.sort_by_key(|sample| sample.tick.wrapping_sub(first));
    ordered.dedup_by_key(|sample| sample.tick);
    let joints = 0..arm.joints.len();
    let series = |of: &dyn Fn(&Sample, usize) -> f64| {
        joints.clone().map(|joint| ordered.iter().map(|sample| of(sample, joint)).collect()).collect()
    };
    Log {
        time: ordered.iter().map(|sample| f64::from(sample.tick.wrapping_sub(first)) * arm.period).collect(),
        q: series(&|sample, joint| sample.q.get(joint).copied().unwrap_or(0.0)),
        tau: series(&|sample, joint| sample.torque.get(joint).copied().unwrap_or(0.0)),
        file: "the arm's own motions".to_owned(),
        qd: None,
        from_current: false,
    }
}

/// Describes the estimated payload, and returns it as a body in the tip frame.
fn in_words(held: &Payload, joints: &dyn ArmModel) -> (String, Inertia<f32>) {
    let half = WIDE * held.mass_deviation;
    let nothing = Inertia::<f64>::zero();
    match held.com {
        Some(com) if held.mass > 0.0 => {
            let body = joints.in_tip(&Inertia::from_mass_centre(held.mass, &com, &held.inertia));
            let [x, y, z]: [f64; 3] = (body.first_moment / held.mass).into();
            let (low, high) = (held.mass - half, held.mass + half);
            let text =
                format!("{:.3} kg, 95 %: {low:.3} to {high:.3}, at {x:.3} {y:.3} {z:.3} m in the tip frame", held.mass);
            (text, body.cast().symmetric())
        }
        _ => (format!("nothing that can be told from nothing: {:.3} +- {half:.3} kg", held.mass), nothing.cast()),
    }
}
