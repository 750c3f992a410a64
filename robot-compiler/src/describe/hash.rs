//! One number for everything that decides the bits of a tick.
//!
//! The desk and the chip compare it before a run: equal hashes mean equal arm, scene, controller, sine and cosine, joint
//! count and rate, all as the single-precision numbers that the chip computes with.

use crate::describe::scene::{KernelChoice, SceneFile};
use dynamics_core::control::{Between, CollisionConfig, Encoder, Friction, Gains, Guard, Law, Reaction};
use dynamics_core::drive::{Drives, Gearing, MitDrive, MitRanges, PwmDrive, Range};
use dynamics_core::model::{Link, Placement};
use dynamics_core::safety::{JointRules, Rules, SafeAction};
use dynamics_core::trig::Method;
use dynamics_core::{ControllerConfig, Inertia, JointKind, Limits, Model, Scene, Term, Wrench};

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

    /// A number of a small set: a variant, a count.
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

impl SceneFile {
    /// Hash of everything that decides the bits of a tick: model, scene, controller, safety rules, sine and cosine, `N`,
    /// rate, whether the operations were regrouped, in which ticks the model is evaluated, what is a collision, and what lies
    /// between the joints and their drives, where the file says it.
    ///
    /// Not in it, because no tick of the chip reads it: names, the motion, the plant, the sensors, the actuators; and what memory the
    /// kernel runs from, because no bit depends on it. Stable across runs and platforms.
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
            Method::Rotation => 5,
        });
        // The recursion and its exact kernel give the same bits, and either side may run either.
        fnv.tag(match self.control.kernel {
            KernelChoice::Generic | KernelChoice::Exact => 0,
            KernelChoice::Regrouped => 1,
        });
        hash_model(&mut fnv, &model.cast());
        hash_scene(&mut fnv, &self.scene(model).cast());
        hash_config(&mut fnv, &self.controller_config(model).cast());
        hash_rules(&mut fnv, &self.safety_rules(model).cast());
        // A scene that does not ask for it has the hash that it would have without the choice.
        if self.control.model_every > 1 {
            fnv.tag(self.control.model_every);
            fnv.tag(match self.control.model_between {
                Between::Hold => 0,
                Between::Extrapolate => 1,
            });
        }
        hash_drives(&mut fnv, &self.drives::<N>());
        if let Some(collision) = self.collision_config::<N>() {
            hash_collision(&mut fnv, &collision.cast());
        }
        fnv.0
    }
}

// Structures are taken apart by name below, so that a field added to one does not compile until it is hashed.

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
        hash_limits(fnv, limits);
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

fn hash_limits(fnv: &mut Fnv1a, limits: &Limits<f32>) {
    let Limits { position: (lo, hi), velocity, torque, torque_rate } = limits;
    fnv.numbers([lo, hi, velocity, torque, torque_rate]);
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

fn hash_config<const N: usize>(fnv: &mut Fnv1a, config: &ControllerConfig<f32, N>) {
    let ControllerConfig { law, gains, friction, limits, torque_step, guard, age_max, encoder, observer } = config;
    fnv.tag(match law {
        Law::ComputedTorque => 0,
        Law::Pd => 1,
        Law::PdGravity => 2,
        Law::Feedforward => 3,
        Law::DiagonalInertia => 4,
    });
    for Gains { position, velocity, inertia } in gains {
        fnv.numbers([position, velocity, inertia]);
    }
    fnv.tag(u32::from(friction.is_some()));
    for Friction { viscous, coulomb, per_smoothing_speed } in friction.iter().flatten() {
        fnv.numbers([viscous, coulomb, per_smoothing_speed]);
    }
    for limits in limits {
        hash_limits(fnv, limits);
    }
    fnv.numbers(torque_step);
    for Guard { position_margin, velocity_max } in guard {
        fnv.numbers([position_margin, velocity_max]);
    }
    fnv.tag(*age_max);
    for Encoder { zero, per_count } in encoder {
        fnv.bytes(&zero.to_le_bytes());
        fnv.number(*per_count);
    }
    fnv.numbers(&observer.gains());
}

fn hash_rules<const N: usize>(fnv: &mut Fnv1a, rules: &Rules<f32, N>) {
    let Rules { safe_action, heartbeat_max, hold_max, supply, temperature, period, rate, latency, payload, joints } =
        rules;
    fnv.tag(match safe_action {
        SafeAction::Brake => 0,
        SafeAction::DampedStop => 1,
        SafeAction::Off => 2,
    });
    fnv.tag(*heartbeat_max);
    fnv.tag(*hold_max);
    fnv.numbers([
        &supply.0,
        &supply.1,
        &temperature.0,
        &temperature.1,
        period,
        rate,
        latency,
        &payload.mass,
        &payload.radius,
    ]);
    for JointRules { rest_speed, jump_step, resolution, deceleration, reach, reach_speed, damping } in joints {
        fnv.numbers([rest_speed, jump_step, resolution, deceleration, reach, reach_speed, damping]);
    }
}

/// Nothing where the joints are reached over the link: such a hash is what it was before there were drives.
fn hash_drives<const N: usize>(fnv: &mut Fnv1a, drives: &Drives<N>) {
    match drives {
        Drives::Link => {}
        Drives::Mit(all) => {
            fnv.tag(1);
            for MitDrive { bus, id, reply_id, reply_bytes, ranges, gearing, damping } in all {
                fnv.bytes(&[*bus, *id, *reply_bytes]);
                fnv.tag(u32::from(*reply_id));
                let MitRanges { position, velocity, kp, kd, torque } = ranges;
                for Range { min, max } in [position, velocity, kp, kd, torque] {
                    fnv.numbers([min, max]);
                }
                hash_gearing(fnv, gearing);
                fnv.number(*damping);
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

fn hash_collision<const N: usize>(fnv: &mut Fnv1a, collision: &CollisionConfig<f32, N>) {
    let CollisionConfig { filter, threshold, released, ticks, release_ticks, reaction } = collision;
    fnv.numbers(&filter.numbers());
    fnv.numbers(threshold);
    fnv.numbers(released);
    fnv.tag(*ticks);
    fnv.tag(*release_ticks);
    fnv.tag(match reaction {
        Reaction::Stop => 0,
        Reaction::Hold => 1,
        Reaction::Comply => 2,
    });
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
