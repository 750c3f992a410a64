//! Control law, stiffness and payload of an armed arm. They change in small steps, and the board accepts a step only if no torque jumps.

use super::{Operator, Stop};
use crate::chip::ChipError;
use dynamics_core::control::ControlLaw;
use dynamics_core::{Inertia, InertiaBounds};
use link::{Frame, Refusal, Setting, Value};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::names::name;
use session::parameters::{ARM, LAW};

/// Stiffness of `soft` and of `stiff`, as multiples of the scene's.
pub(super) const SOFT: f64 = 0.25;
pub(super) const STIFF: f64 = 4.0;

/// Number of steps in a change of stiffness.
const STEPS: u32 = 24;

/// Smallest part of a payload change, as a share of it. If the board rejects a part this small, the user sees the refusal.
const PART_MIN: f64 = 1.0 / 256.0;

/// Parameter numbers of a joint's position gain and of its velocity gain.
const POSITION_GAIN: u8 = 0;
const VELOCITY_GAIN: u8 = 1;

impl Operator {
    /// Selects another control law. A moving arm is stopped first. With the law `teach`, the arm is hand-guided from then on.
    pub(super) fn law(&mut self, law: ControlLaw) -> Result<(), Stop> {
        self.hold_if_running()?;
        let begins_guiding = law.is_hand_guided() && self.drives();
        if begins_guiding && !self.may_be_led("teach")? {
            return Ok(());
        }
        let setting = Setting { index: LAW, value: f32::from(law.code()) };
        match self.answers(&[Frame::Set(setting)])?.pop() {
            Some(Err(refusal)) => {
                return self.reject("law", &self.refusal_in_words(&refusal));
            }
            Some(Ok(_)) | None => {
                self.arm.law = law;
                self.say("law", &format!("law: {}", name(law)))?;
            }
        }
        if begins_guiding && self.drives() { self.lead() } else { Ok(()) }
    }

    /// Sets every joint's stiffness to this multiple of the scene's and keeps the damping ratio: `Kp` scales with the factor, `Kd` with its square
    /// root.
    pub(super) fn stiffness(&mut self, factor: f64) -> Result<(), Stop> {
        let joints = self.arm.joints.len() as u8;
        let asked: Vec<Frame> = (0..joints).map(|joint| Frame::Get(16 * joint + POSITION_GAIN)).collect();
        let mut built_in = Vec::new();
        for answer in self.answers(&asked)? {
            match answer {
                // The board allows a quarter to four times the built-in value.
                Ok(value) if value.high.is_finite() => built_in.push((value.value, value.high / 4.0)),
                Ok(_) => {
                    return self.reject("stiffness", &self.refusal_in_words(&Refusal::Fixed));
                }
                Err(refusal) => {
                    return self.reject("stiffness", &self.refusal_in_words(&refusal));
                }
            }
        }
        let from: Vec<f64> = built_in.iter().map(|(now, nominal)| f64::from(now / nominal)).collect();
        let nominal = self.damping_gains(joints)?;
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            for (joint, from) in from.iter().enumerate() {
                let now = from * (factor / from).powf(share);
                let gain = |index: u8, nominal: f32, by: f64| Setting {
                    index: 16 * joint as u8 + index,
                    value: (f64::from(nominal) * by) as f32,
                };
                let of = |list: &[f32]| list.get(joint).copied().unwrap_or(0.0);
                let stiff = gain(POSITION_GAIN, built_in.get(joint).map_or(0.0, |(_, nominal)| *nominal), now);
                let damped = gain(VELOCITY_GAIN, of(&nominal), now.sqrt());
                // In between, the joint is damped more, not less.
                let order = if factor > *from { [damped, stiff] } else { [stiff, damped] };
                for setting in order {
                    if let Some(Err(refusal)) = self.answers(&[Frame::Set(setting)])?.pop() {
                        let text = self.refusal_in_words(&refusal);
                        return self.reject("stiffness", &format!("{text}; it stays at {now:.2} of the scene's"));
                    }
                }
            }
        }
        self.say("stiffness", &format!("stiffness: {factor} of the scene's"))
    }

    /// Returns the velocity gains that were built in.
    fn damping_gains(&mut self, joints: u8) -> Result<Vec<f32>, Stop> {
        let asked: Vec<Frame> = (0..joints).map(|joint| Frame::Get(16 * joint + VELOCITY_GAIN)).collect();
        // The upper bound is twice the built-in value.
        Ok(self.answers(&asked)?.into_iter().map(|answer| answer.map_or(0.0, |value| value.high / 2.0)).collect())
    }

    /// Sends the board a payload: its mass (kg) and its centre of mass in the tip frame (m). While torque acts, the payload changes in parts so small
    /// that no torque jumps.
    pub(super) fn payload(&mut self, mass: f64, place: [f64; 3]) -> Result<(), Stop> {
        if !self.arm.payload_is_live {
            return self.reject("payload", "the scene has no live payload; set `payload = \"live\"` in its [model]");
        }
        let goal: Inertia<f32> = Inertia::from_mass_centre(mass, &Vector3::from(place), &Matrix3::zeros()).cast();
        self.take_up("payload", &goal)
    }

    /// As [`Operator::payload`] for any body in the tip frame. `name` is the command in the messages.
    pub(super) fn take_up(&mut self, name: &str, goal: &Inertia<f32>) -> Result<(), Stop> {
        let goal = *goal;
        let from = self.arm.payload.unwrap_or_else(|| self.arm.model.payload());
        let (mut done, mut part) = (0.0, 1.0);
        while done < 1.0 {
            let next = f64::min(done + part, 1.0);
            let payload = if next < 1.0 { between(&from, &goal, next as f32) } else { goal };
            match self.tell_payload(&payload)? {
                None => done = next,
                Some(Refusal::WouldJump { .. }) if part > PART_MIN => part *= 0.5,
                Some(refusal) => {
                    let told = if done > 0.0 {
                        format!("; {:.0} % of the change is made", 100.0 * done)
                    } else {
                        String::new()
                    };
                    let why = match refusal {
                        Refusal::OutOfBounds => self.beyond_bounds(&goal),
                        _ => String::new(),
                    };
                    let text = self.refusal_in_words(&refusal);
                    return self.reject(name, &format!("{text}{why}{told}"));
                }
            }
        }
        let text = match self.answers(&[Frame::Get(ARM)])?.pop() {
            Some(Ok(value)) if value.value.to_bits() == goal.mass.to_bits() => {
                format!("{name}: {}", self.payload_in_words(&from, &goal, &value))
            }
            Some(Ok(value)) => {
                self.refused = true;
                format!(
                    "{name}: not confirmed: the controller has {} kg, sent were {} kg; repeat the command",
                    value.value, goal.mass
                )
            }
            Some(Err(refusal)) => return self.reject(name, &self.refusal_in_words(&refusal)),
            None => String::new(),
        };
        self.say(name, &text)
    }

    /// Describes the payload that the board now has: its mass as the board reports it, position, frame, and the change of each joint's torque.
    fn payload_in_words(&self, from: &Inertia<f32>, to: &Inertia<f32>, mass: &Value) -> String {
        let place = match centre(&to.cast()) {
            Some([x, y, z]) => format!(" at {x:.3} {y:.3} {z:.3} m in the tip frame"),
            None => String::new(),
        };
        let text = format!("{} kg{place} (0 to {} kg)", mass.value, mass.high);
        let Some(q) = &self.q else { return text };
        let torque = |payload: &Inertia<f32>| self.arm.model.gravity(q, Some(*payload));
        let (before, after) = (torque(from), torque(to));
        let change = |(((name, _, unit), before), after): (((&String, &str, &str), &f64), &f64)| {
            format!("{name} {:+.2} {unit}", after - before)
        };
        let joints = self.arm.joints.iter().map(|(name, place, unit)| (name, *place, *unit));
        let changes: Vec<String> = joints.zip(&before).zip(&after).map(change).collect();
        format!("{text}; torque to hold the arm changes by {}", changes.join(", "))
    }

    /// Reason why the board rejects a payload, with the numbers.
    fn beyond_bounds(&self, payload: &Inertia<f32>) -> String {
        let InertiaBounds { mass, radius } = self.arm.payload_bounds;
        let body = self.arm.model.in_last_link(&payload.cast());
        if !(0.0..=mass).contains(&body.mass) {
            return format!(": {:.3} kg, allowed 0 to {mass:.3} kg (`payload_mass` in [safety])", body.mass);
        }
        let distance = body.first_moment.norm() / body.mass;
        match distance > radius {
            true => format!(
                ": its centre of mass is {distance:.3} m from the last link's origin, allowed {radius:.3} m (`payload_radius` in \
                 [safety]); are X Y Z in metres, in the tip frame?"
            ),
            false => format!(
                ": a part of it would be farther than {radius:.3} m from the last link's origin (`payload_radius` in [safety]), or \
                 its inertia belongs to no possible body"
            ),
        }
    }

    /// Sends one payload. Returns the board's refusal, if there is one.
    fn tell_payload(&mut self, payload: &Inertia<f32>) -> Result<Option<Refusal>, Stop> {
        let frame = Frame::Live(self.arm.model.live(Some(*payload)).map_err(ChipError::from)?);
        // The board answers live inputs only with a refusal. While torque acts, it comes in the tick after the one that took the inputs.
        self.expected = Some(Vec::new());
        let taken = self.send_surely(&frame).and_then(|()| self.wait(2.0 * self.arm.period));
        let refused = self.expected.take().unwrap_or_default().into_iter().find_map(Result::err);
        taken?;
        if refused.is_none() {
            self.arm.payload = Some(*payload);
            // The payload of an earlier host no longer applies.
            self.resumed = false;
        }
        Ok(refused)
    }
}

/// Centre of mass, m; `None` for a body without mass.
fn centre(body: &Inertia<f64>) -> Option<[f64; 3]> {
    (body.mass > 0.0).then(|| (body.first_moment / body.mass).into())
}

/// Interpolates between two inertias: each of the ten parameters linearly, at this share.
fn between(from: &Inertia<f32>, to: &Inertia<f32>, share: f32) -> Inertia<f32> {
    Inertia {
        mass: from.mass + share * (to.mass - from.mass),
        first_moment: from.first_moment + (to.first_moment - from.first_moment) * share,
        about_origin: from.about_origin + (to.about_origin - from.about_origin) * share,
    }
    .symmetric()
}
