//! Parameters of a board by name: reading and changing them.

use super::heat::Heat;
use super::{Operator, Stop};
use crate::chip::refusal_in_words;
use crate::session::operate::device::{DeviceError, SILENCE};
use dynamics_core::Inertia;
use dynamics_core::control::ControlLaw;
use link::{Frame, Refusal, Setting, Value};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::names;
use session::parameters::{ARM, ARM_NAMES, HEAT, JOINT_NAMES, LAW, name};
use std::ops::RangeInclusive;
use std::time::Duration;

/// Number of parameters requested at once. A board accepts three packets of the greatest length before it answers, and these are short.
const AT_ONCE: usize = 8;

/// Time after which an unanswered request is repeated. It is longer than a change waits for its tick.
const AGAIN: Duration = Duration::from_millis(300);

/// Most attempts to read all parameters of a payload.
const ATTEMPTS: u32 = 8;

/// Payload parameters below this size per kilogram are rounding errors of single precision.
const ROUNDING: f64 = 1e-6;

/// Numbers of the payload's ten parameters: mass, first moment, inertia.
const PAYLOAD: RangeInclusive<u8> = ARM..=ARM + 9;

/// Numbers of the parameters named by these words: all of them, all of a joint, one of a joint, or one of the whole arm.
///
/// # Errors
/// A description of the words found and the words expected.
pub fn of_words(command: &str, words: &[&str], joints: &[String]) -> Result<Vec<u8>, String> {
    let of_joint = |joint: usize| (0..JOINT_NAMES.len()).map(move |number| (16 * joint + number) as u8);
    let of_arm = (0..ARM_NAMES.len()).map(|number| ARM + number as u8);
    let Some((first, rest)) = words.split_first() else {
        return Ok((0..joints.len()).flat_map(of_joint).chain(of_arm).collect());
    };
    let Some(joint) = joint(first, joints) else {
        let found = words.join(" ");
        let one = of_arm.zip(ARM_NAMES).find(|(_, name)| *name == found);
        return one.map(|(number, _)| vec![number]).ok_or_else(|| {
            let (joints, names) = (joints.join(", "), ARM_NAMES.join(", "));
            format!("{command}: {found}: expected a joint ({joints}) or one of {names}")
        });
    };
    if rest.is_empty() {
        return Ok(of_joint(joint).collect());
    }
    let found = rest.join(" ");
    let one = of_joint(joint).zip(JOINT_NAMES).find(|(_, name)| *name == found);
    one.map(|(number, _)| vec![number]).ok_or_else(|| {
        format!("{command}: {found}: expected a parameter of a joint, one of {}", JOINT_NAMES.join(", "))
    })
}

/// Index of a joint, counted from 0, by its name or by its number, counted from 1.
pub(super) fn joint(word: &str, joints: &[String]) -> Option<usize> {
    let by_number = || word.parse::<usize>().ok().filter(|number| (1..=joints.len()).contains(number));
    joints.iter().position(|name| name == word).or_else(|| by_number().map(|number| number - 1))
}

/// Unit of a parameter, from the joint's units of position and force.
fn unit(index: u8, place: &str, force: &str) -> String {
    let per_speed = || format!("{force} s/{place}");
    match index.checked_sub(ARM) {
        Some(0) => "kg".into(),
        Some(1..=3) => "kg m".into(),
        Some(4..=9) => "kg m^2".into(),
        Some(10..=12) => "m/s^2".into(),
        Some(_) => String::new(),
        None => match index % 16 {
            0 => "1/s^2".into(),
            1 => "1/s".into(),
            2 => per_speed(),
            3 | 4 => force.into(),
            5 => format!("{force} a tick"),
            6 => format!("{place}/s"),
            7 | 8 => place.into(),
            _ => format!("{place} a count"),
        },
    }
}

impl Operator {
    /// Reads these parameters and prints their values.
    pub(super) fn get(&mut self, numbers: &[u8]) -> Result<(), Stop> {
        let mut lines = Vec::new();
        // The payload is one body: converting any of its parameters to the tip frame needs all ten.
        let asks = numbers.iter().any(|number| PAYLOAD.contains(number));
        let payload = if asks { self.payload_at_tip()?.as_ref().map(parameters) } else { None };
        for some in numbers.chunks(AT_ONCE) {
            let ask: Vec<_> = some.iter().map(|number| Frame::Get(*number)).collect();
            for answer in self.answers(&ask)? {
                lines.push(match answer {
                    Ok(value) => {
                        let at_tip =
                            payload.as_ref().and_then(|all| all.get(usize::from(value.index.checked_sub(ARM)?)));
                        let value = Value { value: at_tip.map_or(value.value, |at_tip| *at_tip as f32), ..value };
                        format!("  {}", self.value_in_words(&value))
                    }
                    Err(refusal) => {
                        self.refused = true;
                        format!("get: rejected: {}", self.refusal_in_words(&refusal))
                    }
                });
            }
        }
        let text = match lines.as_slice() {
            [one] => format!("get: {}", one.trim_start()),
            all => format!("get: {} parameters\n{}", all.len(), all.join("\n")),
        };
        self.say("get", &text)
    }

    /// Queries the control law: on a new connection it may differ from the scene's, if the scene is tunable.
    pub(super) fn learn_law(&mut self) -> Result<(), Stop> {
        if !self.arm.tunable || !self.is_live() {
            return Ok(());
        }
        if let Some(Ok(value)) = self.answers(&[Frame::Get(LAW)])?.pop()
            && let Some(law) = ControlLaw::from_number(value.value)
        {
            self.arm.law = law;
        }
        Ok(())
    }

    /// The board's payload in the tip frame; `None` if the board does not report one.
    fn payload_at_tip(&mut self) -> Result<Option<Inertia<f64>>, Stop> {
        let mut found = [None; 10];
        // A refusal of another frame may take the place of an answer. A missing value is requested again.
        for _ in 0..ATTEMPTS {
            let missing: Vec<u8> =
                PAYLOAD.zip(&found).filter(|(_, it)| it.is_none()).map(|(number, _)| number).collect();
            for some in missing.chunks(AT_ONCE) {
                let ask: Vec<_> = some.iter().map(|number| Frame::Get(*number)).collect();
                for value in self.answers(&ask)?.into_iter().flatten() {
                    let place = value.index.checked_sub(*PAYLOAD.start()).map(usize::from);
                    if let Some(place) = place.and_then(|place| found.get_mut(place)) {
                        *place = Some(f64::from(value.value));
                    }
                }
            }
        }
        let [Some(mass), Some(hx), Some(hy), Some(hz), Some(xx), Some(yy), Some(zz), Some(xy), Some(xz), Some(yz)] =
            found
        else {
            return Ok(None);
        };
        let body = Inertia {
            mass,
            first_moment: Vector3::new(hx, hy, hz),
            about_origin: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        };
        Ok(Some(self.arm.model.in_tip(&body)))
    }

    /// Reads the payload that an earlier host has declared, so that repeated live inputs do not change it. Returns false if the board does not report
    /// it: then no live inputs are sent until a payload is declared.
    pub(super) fn learn_payload(&mut self) -> Result<bool, Stop> {
        if self.arm.payload_is_live {
            let Some(payload) = self.payload_at_tip()? else { return Ok(false) };
            self.arm.payload = Some(payload.cast().symmetric());
        }
        self.resumed = false;
        Ok(true)
    }

    /// Changes a parameter and prints its new value. A change of the control law uses the command `law` with its checks.
    pub(super) fn set(&mut self, setting: Setting) -> Result<(), Stop> {
        if let Some(law) = ControlLaw::from_number(setting.value).filter(|_| setting.index == LAW) {
            return self.law(law);
        }
        let text = match self.answers(&[Frame::Set(setting)])?.pop() {
            Some(Ok(value)) => format!("set: {}", self.value_in_words(&value)),
            Some(Err(refusal)) => return self.reject("set", &self.refusal_in_words(&refusal)),
            None => String::new(),
        };
        self.say("set", &text)
    }

    /// Sends frames and waits for an answer to each: a value or a refusal.
    pub(super) fn answers(&mut self, frames: &[Frame]) -> Result<Vec<Result<Value, Refusal>>, Stop> {
        self.expected = Some(Vec::new());
        self.heat.expect(frames);
        let waited = self.until_answered(frames);
        self.heat.expect(&[]);
        let answers = self.expected.take().unwrap_or_default();
        waited.map(|()| answers)
    }

    fn until_answered(&mut self, frames: &[Frame]) -> Result<(), Stop> {
        let begin = self.device.now();
        let mut sent = None;
        loop {
            if self.silent_for(begin) > SILENCE {
                return Err(DeviceError::Silent { what: "parameter", time: SILENCE }.into());
            }
            // A frame or its answer was lost. Reading and setting a parameter twice is harmless.
            if sent.is_none_or(|sent| self.silent_for(sent) > AGAIN) {
                sent = Some(self.device.now());
                self.expected = Some(Vec::new());
                for frame in frames {
                    self.send(frame)?;
                }
            }
            self.pass()?;
            if self.expected.as_ref().is_none_or(|answers| answers.len() >= frames.len()) {
                return Ok(());
            }
        }
    }

    /// Describes why the board rejects a change, with advice.
    pub(super) fn refusal_in_words(&self, refusal: &Refusal) -> String {
        match (refusal, self.arm.tunable) {
            (Refusal::Fixed, false) => "the firmware holds gains, friction and control law in flash memory, because its scene does not \
                                        set `tunable = true` in [control]; set it, then build and flash the firmware again"
                .into(),
            (Refusal::Fixed, true) => "limits and encoder numbers are fixed when the firmware is built, even with `tunable = true`; \
                                       change them in the robot file, then build and flash the firmware again"
                .into(),
            _ => refusal_in_words(refusal),
        }
    }

    /// A value in words, for example `elbow position gain 100 1/s^2 (25 to 400)`.
    pub(super) fn value_in_words(&self, value: &Value) -> String {
        let Value { index, value, low, high } = *value;
        let Some((name, joint)) = name(index) else { return format!("parameter {index}: {value}") };
        let (joint, place, force) = match joint.and_then(|joint| self.arm.joints.get(usize::from(joint))) {
            Some((name, place, force)) => (format!("{name} "), *place, *force),
            None => (String::new(), "", ""),
        };
        if index == LAW {
            return format!("law {}", ControlLaw::from_number(value).map_or("unknown", names::name));
        }
        if index < ARM && index % 16 == HEAT {
            return format!("{joint}{name} {}", super::report::heat_in_words(&Heat::of(value)));
        }
        let bounds = match low.is_nan() {
            false => format!("{low} to {high}"),
            true if index < ARM => "fixed".into(),
            // Live inputs are sent as a whole, so they have no bounds of their own.
            true if PAYLOAD.contains(&index) => "live, tip frame".into(),
            true => "live".into(),
        };
        format!("{joint}{name} {value} {} ({bounds})", unit(index, place, force))
    }
}

/// A payload's ten parameters, in the order of their numbers.
fn parameters(payload: &Inertia<f64>) -> [f64; 10] {
    let Inertia { mass, first_moment: h, about_origin: i } = payload;
    // The board uses single precision: the rounding error of a zero after two changes of frame is hidden.
    let shown = |x: f64| if x.abs() < ROUNDING * mass.abs() { 0.0 } else { x };
    [*mass, h.x, h.y, h.z, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23].map(shown)
}

#[cfg(test)]
mod tests;
