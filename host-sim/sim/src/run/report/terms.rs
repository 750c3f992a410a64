//! Contribution of each term of the controller's model to the torque.
//!
//! `tau = inertia + rotor + coriolis + gravity + friction + contact + rest`. Each term is computed by the recursion with this effect alone, in f64.
//! It uses the state of the simulated arm (or the reference, if the law does) and the acceleration of the reference. The rest is feedback, the
//! difference between measurement and state, and the effect of limits.

use crate::run::record::{JointSample, Record};
use dynamics_core::control::trajectory::Motion;
use dynamics_core::control::{ControlLaw, Friction, ModelUse};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Scene, Term, Trig as _};
use report::column;
use robot_compiler::SceneFile;
use serde_json::{Map, Value, json};

/// Names of the terms, in the order of [`Contributions::at`].
const NAMES: [&str; 6] = ["inertia", "rotor", "coriolis", "gravity", "friction", "contact"];

/// The terms of a model, each as dynamics of the arm with one effect.
pub(super) struct Contributions<const N: usize> {
    inertia: Dynamics<f64, N>,
    coriolis: Dynamics<f64, N>,
    gravity: Dynamics<f64, N>,
    contact: Dynamics<f64, N>,
    rotor: [f64; N],
    friction: Option<[Friction<f64>; N]>,
    live: Live<f64, N>,
    motion: Motion<f64, N>,
    repeat: bool,
    uses: Uses,
    present: [bool; 6],
}

/// Parts of the model that a control law uses.
#[derive(Clone, Copy)]
struct Uses {
    /// True if the model is evaluated at the reference instead of the arm's state.
    at_reference: bool,
    /// True if the law uses inertia, rotors and velocity terms.
    motion: bool,
}

impl Uses {
    /// Returns `None` for a law that does not use a model.
    fn of(law: ControlLaw) -> Option<Self> {
        match law.traits().model {
            ModelUse::Motion => Some(Self { at_reference: false, motion: true }),
            ModelUse::Reference => Some(Self { at_reference: true, motion: true }),
            ModelUse::Holding => Some(Self { at_reference: false, motion: false }),
            ModelUse::Nothing => None,
        }
    }
}

impl<const N: usize> Contributions<N> {
    /// Returns `None` if the law does not use a model, or the scene has no trajectory.
    pub(super) fn new(scene: &SceneFile, model: &Model<f64, N>) -> Option<Self> {
        let uses = Uses::of(scene.control.law)?;
        let motion = scene.trajectory(model).ok()?;
        let (known, live) = (scene.scene(model), scene.live(model));
        let nothing = Scene { coriolis: Term::Absent, payload: known.payload, ..Scene::free_space() };
        let bound = |scene: Scene<f64, N>| Dynamics::new(*model, scene);
        let config = scene.controller_config(model);
        let there = |absent: bool| uses.motion && !absent;
        Some(Self {
            inertia: bound(nothing),
            coriolis: bound(Scene { coriolis: known.coriolis, ..nothing }),
            gravity: bound(Scene { gravity: known.gravity, ..nothing }),
            contact: bound(Scene { tip_wrench: known.tip_wrench, ..nothing }),
            rotor: known.rotor.value(&live.rotor).copied().unwrap_or([0.0; N]),
            friction: config.friction,
            present: [
                uses.motion,
                there(matches!(known.rotor, Term::Absent)),
                there(matches!(known.coriolis, Term::Absent)),
                !matches!(known.gravity, Term::Absent),
                config.friction.is_some() && !scene.control.law.is_hand_guided(),
                !matches!(known.tip_wrench, Term::Absent),
            ],
            live,
            motion,
            repeat: scene.motion.repeats(),
            uses,
        })
    }

    /// Number of terms that the model contains.
    pub(super) fn count(&self) -> usize {
        self.present.iter().filter(|present| **present).count()
    }

    /// Columns of the terms in the model, at every `stride`-th tick; NaN after a fault.
    pub(super) fn columns(&self, record: &Record, stride: usize) -> Map<String, Value> {
        let rows: Vec<[[f64; N]; 6]> = (0..record.ticks()).step_by(stride).map(|tick| self.row(record, tick)).collect();
        let there = NAMES.iter().zip(self.present).enumerate().filter(|(_, (_, present))| *present);
        there
            .map(|(term, (name, _))| {
                let each = (0..N).map(|joint| json!({ "at": column::encode(rows.iter().map(|row| row[term][joint])) }));
                ((*name).to_owned(), each.collect())
            })
            .collect()
    }

    fn row(&self, record: &Record, tick: usize) -> [[f64; N]; 6] {
        if record.faults()[tick].is_some() {
            return [[f64::NAN; N]; 6];
        }
        let samples = record.tick(tick);
        self.at(record.time()[tick], &std::array::from_fn(|joint| samples[joint]))
    }

    /// Every term at a time (s) and in a state, N m or N, in the order of [`NAMES`].
    fn at(&self, t: f64, samples: &[JointSample; N]) -> [[f64; N]; 6] {
        let reference = self.uses.at_reference;
        let q = samples.map(|s| if reference { s.q_reference } else { s.q });
        let qd = samples.map(|s| if reference { s.qd_reference } else { s.qd });
        let t = if self.repeat { t % self.motion.duration() } else { t };
        let (turn, zero, qdd) = (Libm.sin_cos_all(&q), [0.0; N], self.motion.sample(t).qdd);
        let of = |dynamics: &Dynamics<f64, N>, qd: &[f64; N], qdd: &[f64; N]| {
            dynamics.inverse_dynamics(&turn, &q, qd, qdd, &self.live)
        };
        let friction =
            |friction: &[Friction<f64>; N]| std::array::from_fn(|i| friction[i].torque(samples[i].qd_reference));
        [
            of(&self.inertia, &zero, &qdd),
            std::array::from_fn(|i| self.rotor[i] * qdd[i]),
            of(&self.coriolis, &qd, &zero),
            of(&self.gravity, &zero, &zero),
            self.friction.as_ref().map_or(zero, friction),
            of(&self.contact, &zero, &zero),
        ]
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::Contributions;
    use crate::run::record::JointSample;
    use dynamics_core::control::LimitFlags;
    use dynamics_core::trig::Libm;
    use dynamics_core::{Dynamics, InverseDynamics as _, Trig as _};
    use robot_compiler::SceneFile;
    use std::path::Path;

    fn scene(name: &str) -> SceneFile {
        SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)).unwrap()
    }

    #[test]
    fn the_terms_add_up_to_the_inverse_dynamics_of_the_whole_model() {
        for name in ["puma560_pick.toml", "ur5_wall_contact.toml"] {
            let scene = scene(name);
            let model = scene.robot.model::<6>().unwrap();
            let terms = Contributions::new(&scene, &model).unwrap();
            let t = 0.25;
            let reference = terms.motion.sample(t);
            let samples: [JointSample; 6] = std::array::from_fn(|i| JointSample {
                q_reference: reference.q[i],
                q: reference.q[i] + 0.01 * i as f64,
                qd_reference: reference.qd[i],
                qd: reference.qd[i] - 0.3 + 0.1 * i as f64,
                torque: 0.0,
                limits: LimitFlags::NONE,
            });
            let found = terms.at(t, &samples);
            let (q, qd) = (samples.map(|s| s.q), samples.map(|s| s.qd));
            let whole = Dynamics::new(model, scene.scene(&model)).inverse_dynamics(
                &Libm.sin_cos_all(&q),
                &q,
                &qd,
                &reference.qdd,
                &scene.live(&model),
            );
            for joint in 0..6 {
                let sum: f64 = [0, 1, 2, 3, 5].iter().map(|term| found[*term][joint]).sum();
                assert!((sum - whole[joint]).abs() < 1e-10, "{name}, joint {joint}: {sum} {}", whole[joint]);
            }
        }
    }

    #[test]
    fn a_law_without_a_model_has_no_terms() {
        let mut scene = scene("puma560_pick.toml");
        let model = scene.robot.model::<6>().unwrap();
        assert_eq!(Contributions::new(&scene, &model).unwrap().count(), 5);
        scene.control.law = dynamics_core::control::ControlLaw::Pd;
        assert!(Contributions::new(&scene, &model).is_none());
        scene.control.law = dynamics_core::control::ControlLaw::PdGravity;
        assert_eq!(Contributions::new(&scene, &model).unwrap().present, [false, false, false, true, true, false]);
    }
}
