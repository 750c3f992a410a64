//! A finished run as a file for viewers.

use super::arm::ArmChannels;
use super::messages::{JointTick, TermTorques, Tick, Time, TipWrench, Xyz, finite};
use super::writer::Writer;
use crate::failure::{Failure, in_file};
use crate::run::record::{JointSample, Record};
use crate::run::simulate::live_inputs;
use dynamics_core::control::trajectory::Motion;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics as _, Live, Trig as _};
use robot_compiler::scene::joints;
use robot_compiler::{SceneFile, with_dof};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a run of a scene.
///
/// # Errors
/// [`Failure::Output`] for a file that cannot be written, [`Failure::Input`] for a scene that cannot be run.
pub fn write(record: &Record, scene: &SceneFile, path: &Path) -> Result<(), Failure> {
    with_dof!(scene.robot.dof(), N => {
        let terms = ModelTerms::<N>::new(scene)?;
        let written = File::create(path).and_then(|file| write_to(record, scene, &terms, BufWriter::new(file)));
        written.map_err(|error| in_file(path, &error))
    })
}

/// Writes a run of a scene to any writer.
///
/// # Errors
/// Errors of the writer.
pub fn write_to<const N: usize>(
    record: &Record,
    scene: &SceneFile,
    terms: &ModelTerms<N>,
    out: impl Write,
) -> io::Result<()> {
    let mut file = Writer::new(out)?;
    let mut arm = ArmChannels::new(&mut file, &scene.robot)?;
    let ticks = file.channel::<Tick>("/newtau/tick")?;
    for tick in 0..record.ticks() {
        let (t, samples) = (record.time()[tick], record.tick(tick));
        let at = (t * 1e9).round() as u64;
        let each = |of: fn(&JointSample) -> f64| samples.iter().map(of).collect::<Vec<f64>>();
        arm.write(&mut file, at, &each(|s| s.q), &each(|s| s.qd), &each(|s| s.torque))?;
        let model = terms.at(t, &samples);
        let (external, wrench) = record.outside(tick);
        let joint = |(i, sample): (usize, &JointSample)| JointTick {
            name: arm.names()[i].clone(),
            reference: finite(sample.q_reference),
            reference_velocity: finite(sample.qd_reference),
            position: finite(sample.q),
            velocity: finite(sample.qd),
            torque: finite(sample.torque),
            limits: sample.limits.bits(),
            external: external.get(i).copied().and_then(finite),
            terms: model[i],
        };
        let fault = record.faults()[tick];
        let message = Tick {
            timestamp: Time::from_nanos(at),
            tick: tick as u64,
            joints: samples.iter().enumerate().map(joint).collect(),
            fault: fault.map_or(0, |fault| fault.code()),
            fault_text: fault.map(|fault| fault.to_string()),
            state: None,
            tip_wrench: wrench.and_then(tip_wrench),
        };
        file.write(&ticks, at, &message)?;
    }
    file.finish()
}

/// A wrench as a message, if all of it is finite.
pub(crate) fn tip_wrench(wrench: [f64; 6]) -> Option<TipWrench> {
    let [fx, fy, fz, mx, my, mz] = wrench;
    wrench
        .iter()
        .all(|x| x.is_finite())
        .then_some(TipWrench { force: Xyz { x: fx, y: fy, z: fz }, moment: Xyz { x: mx, y: my, z: mz } })
}

/// The model of a scene, and the motion that gives the accelerations for it.
#[derive(Debug)]
pub struct ModelTerms<const N: usize> {
    dynamics: Dynamics<f64, N>,
    live: Live<f64, N>,
    /// The motion, and true if it repeats; `None` if the arm is hand-guided.
    motion: Option<(Motion<f64, N>, bool)>,
}

impl<const N: usize> ModelTerms<N> {
    /// The model of a scene.
    ///
    /// # Errors
    /// [`Failure::Input`] for a scene that cannot be run.
    pub fn new(scene: &SceneFile) -> Result<Self, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let motion = scene.trajectory(&model);
        let motion = motion.map_err(|error| Failure::Input(miette::miette!("{}: {error}", scene.path.display())))?;
        Ok(Self {
            dynamics: Dynamics::new(model, scene.scene(&model)),
            live: live_inputs(scene, &model),
            motion: (!scene.control.law.is_hand_guided()).then(|| (motion, scene.motion.repeats())),
        })
    }

    /// Terms of every joint at the reference of a tick; `None` for a joint with a term that is not finite.
    fn at(&self, t: f64, samples: &[JointSample]) -> [Option<TermTorques>; N] {
        let each = |of: fn(&JointSample) -> f64| joints::<N>(&samples.iter().map(of).collect::<Vec<_>>());
        let (q, qd) = (each(|s| s.q_reference), each(|s| s.qd_reference));
        let qdd = self
            .motion
            .as_ref()
            .map_or([0.0; N], |(motion, repeats)| motion.sample(if *repeats { t % motion.duration() } else { t }).qdd);
        let turn = Libm.sin_cos_all(&q);
        let torque = |qd: &[f64; N], qdd: &[f64; N]| self.dynamics.inverse_dynamics(&turn, &q, qd, qdd, &self.live);
        let still = torque(&[0.0; N], &[0.0; N]);
        let (moving, accelerated) = (torque(&qd, &[0.0; N]), torque(&[0.0; N], &qdd));
        core::array::from_fn(|i| {
            let terms =
                TermTorques { inertia: accelerated[i] - still[i], velocity: moving[i] - still[i], gravity: still[i] };
            let all = [terms.inertia, terms.velocity, terms.gravity];
            all.iter().all(|x| x.is_finite()).then_some(terms)
        })
    }
}
