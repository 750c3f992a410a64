//! Hash of everything that determines the bits of a tick.
//!
//! The desk and the chip compare their hashes before a run. Equal hashes mean equal arm, scene, controller, sine and
//! cosine, joint count and rate, all as the single-precision numbers that the chip computes with.

use crate::describe::drive::JointDrive;
use crate::describe::scene::{KernelChoice, SceneFile};
use dynamics_core::control::Between;
use dynamics_core::drive::{Drives, Gearing, MitDrive, MitRanges, PwmDrive, Range};
use dynamics_core::fields::{Fields, Visitor};
use dynamics_core::model::{Link, Placement};
use dynamics_core::trig::Method;
use dynamics_core::{Inertia, JointKind, Model, Scene, Term, Wrench};

/// FNV-1a, 64 bits: `h = (h xor byte) * 0x100000001b3` over bytes, little-endian, from `0xcbf29ce484222325`.
///
/// (Fowler, Noll, Vo; draft-eastlake-fnv.) Written out because it must not change with a library or a platform. It guards
/// against mistakes, not against malice.
struct Fnv1a(u64);

impl Fnv1a {
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;

    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(Self::PRIME);
        }
    }

    /// A number from a small set, such as a variant or a count.
    fn tag(&mut self, tag: u32) {
        self.bytes(&tag.to_le_bytes());
    }

    fn number(&mut self, x: f32) {
        self.tag(x.to_bits());
    }

    fn numbers<'a>(&mut self, all: impl IntoIterator<Item = &'a f32>) {
        for x in all {
            self.number(*x);
        }
    }

    fn term<T>(&mut self, term: &Term<T>, constant: impl FnOnce(&mut Self, &T)) {
        match term {
            Term::Absent => self.tag(0),
            Term::Constant(value) => {
                self.tag(1);
                constant(self, value);
            }
            Term::Live => self.tag(2),
        }
    }
}

/// Every number of a configuration, in the order in which its fields are declared.
impl Visitor<f32> for Fnv1a {
    fn number(&mut self, x: f32) {
        Fnv1a::number(self, x);
    }

    fn integer(&mut self, x: i64) {
        self.tag(x as u32);
    }

    fn word(&mut self, _: &'static str, _: &'static str, number: u32) {
        self.tag(number);
    }

    fn option(&mut self, value: Option<&impl Fields<f32>>) {
        self.tag(u32::from(value.is_some()));
        if let Some(value) = value {
            value.visit(self);
        }
    }
}

impl SceneFile {
    /// Hash of everything that determines the bits of a tick: model, scene, controller, safety rules, sine and cosine, `N`,
    /// rate, whether the operations were regrouped, the ticks in which the model is evaluated, the collision settings,
    /// and the drives between the chip and the joints if the file describes them.
    ///
    /// Names, the motion, the plant, the sensors and the actuators are not included, because no tick of the chip reads them. The hash is
    /// stable across runs and platforms.
    #[must_use]
    pub fn hash<const N: usize>(&self, model: &Model<f64, N>) -> u64 {
        let mut fnv = Fnv1a(Fnv1a::BASIS);
        fnv.tag(N as u32);
        fnv.number(self.control.rate as f32);
        fnv.tag(match self.control.trig {
            Method::Polynomial => 0,
            Method::Libm => 1,
            Method::Polynomial5 => 2,
            Method::Polynomial3 => 3,
            Method::Table => 4,
        });
        // The recursion and its exact kernel give the same bits, and either side may run either of them.
        fnv.tag(match self.control.kernel {
            KernelChoice::Generic | KernelChoice::Exact => 0,
            KernelChoice::Regrouped => 1,
        });
        hash_model(&mut fnv, &model.cast());
        hash_scene(&mut fnv, &self.scene(model).cast());
        self.controller_config(model).cast::<f32>().visit(&mut fnv);
        self.safety_rules(model).cast::<f32>().visit(&mut fnv);
        fnv.option(self.friction_terms::<N>().map(|terms| terms.map(|terms| terms.cast::<f32>())).as_ref());
        fnv.tag(self.control.model_every);
        // Without ticks between evaluations the setting has no effect.
        let extrapolates = self.control.model_every > 1 && self.control.model_between == Between::Extrapolate;
        fnv.tag(u32::from(extrapolates));
        // The kind of drives determines the frames and their meaning.
        for joint in &self.robot.joints {
            fnv.bytes(joint.drive.as_ref().map_or("link", JointDrive::kind).as_bytes());
        }
        hash_drives(&mut fnv, &self.drives::<N>());
        fnv.option(self.collision_config::<N>().map(|collision| collision.cast::<f32>()).as_ref());
        fnv.0
    }
}

// The types below that are not configurations are destructured by field name: a new field does not compile until it is
// hashed.

fn hash_model<const N: usize>(fnv: &mut Fnv1a, model: &Model<f32, N>) {
    for Link { kind, rotation, translation, inertia, rotor, limits } in model.links() {
        fnv.tag(match kind {
            JointKind::Revolute => 0,
            JointKind::Prismatic => 1,
        });
        fnv.numbers(rotation);
        fnv.numbers(translation);
        hash_inertia(fnv, inertia);
        fnv.number(*rotor);
        limits.visit(fnv);
    }
    let Placement { rotation, translation } = model.tip();
    fnv.numbers(rotation);
    fnv.numbers(translation);
}

fn hash_inertia(fnv: &mut Fnv1a, inertia: &Inertia<f32>) {
    let Inertia { mass, first_moment, about_origin } = inertia;
    fnv.number(*mass);
    fnv.numbers(first_moment);
    fnv.numbers(about_origin);
}

fn hash_scene<const N: usize>(fnv: &mut Fnv1a, scene: &Scene<f32, N>) {
    let Scene { gravity, payload, tip_wrench, rotor, coriolis } = scene;
    fnv.term(gravity, |fnv, gravity| fnv.numbers(gravity));
    fnv.term(payload, hash_inertia);
    fnv.term(tip_wrench, |fnv, Wrench { force, moment }| {
        fnv.numbers(force);
        fnv.numbers(moment);
    });
    fnv.term(rotor, |fnv, rotor| fnv.numbers(rotor));
    fnv.term(coriolis, |fnv, coriolis| fnv.numbers(coriolis));
}

fn hash_drives<const N: usize>(fnv: &mut Fnv1a, drives: &Drives<N>) {
    match drives {
        Drives::Link => fnv.tag(0),
        Drives::Mit(all) => {
            fnv.tag(1);
            for drive in all {
                let MitDrive {
                    bus,
                    data_rate,
                    id,
                    reply_id,
                    reply_bytes,
                    temperature_offset,
                    ranges,
                    gearing,
                    damping,
                    timeout,
                    restart_ticks,
                    absolute,
                } = drive;
                fnv.bytes(&[*bus, *id, *reply_bytes]);
                fnv.tag(u32::from(*reply_id));
                let MitRanges { position, velocity, kp, kd, torque } = ranges;
                for Range { min, max } in [position, velocity, kp, kd, torque] {
                    fnv.numbers([min, max]);
                }
                hash_gearing(fnv, gearing);
                fnv.number(*damping);
                fnv.tag(u32::from(temperature_offset.is_some()));
                fnv.numbers(temperature_offset);
                fnv.tag(data_rate.map_or(0, |rate| rate.bits_per_second()));
                fnv.tag(*timeout);
                fnv.tag(*restart_ticks);
                fnv.tag(u32::from(*absolute));
            }
        }
        Drives::Pwm(all) => {
            fnv.tag(2);
            for drive in all {
                hash_pwm(fnv, drive);
            }
        }
    }
}

fn hash_gearing(fnv: &mut Fnv1a, gearing: &Gearing) {
    let Gearing { ratio, per_ratio, zero } = gearing;
    fnv.numbers([ratio, per_ratio, zero]);
}

fn hash_pwm(fnv: &mut Fnv1a, drive: &PwmDrive) {
    let PwmDrive {
        channel,
        gearing,
        encoder_zero,
        encoder_reversed,
        jump_max,
        speed_per_count,
        torque_constant,
        per_torque_constant,
        resistance,
        per_resistance,
        supply,
        per_supply,
        current_max,
    } = drive;
    fnv.bytes(&[*channel, u8::from(*encoder_reversed)]);
    fnv.tag(u32::from(*encoder_zero));
    fnv.tag(u32::from(*jump_max));
    hash_gearing(fnv, gearing);
    fnv.numbers([
        speed_per_count,
        torque_constant,
        per_torque_constant,
        resistance,
        per_resistance,
        supply,
        per_supply,
        current_max,
    ]);
}

#[cfg(test)]
mod tests {
    use super::Fnv1a;

    /// Vectors of the FNV reference implementation.
    #[test]
    fn fnv1a_gives_the_published_hashes() {
        for (text, hash) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut fnv = Fnv1a(Fnv1a::BASIS);
            fnv.bytes(text.as_bytes());
            assert_eq!(fnv.0, hash, "{text:?}");
        }
    }
}
