//! Stability of the closed loop: the longest control period predicted by the eigenvalues of the linearised sampled loop, compared with the longest
//! period at which the simulated arm settles.
//!
//! The arms are the planar arm with two rods and the Puma at three postures, under three control laws; then the Puma with a wrong model. The fixed
//! inertias of PD with gravity belong to one posture in all tests, as in a scene.

use super::sampled_loop::{SampledLoop, last};
use super::{Cell, Outcome, joints, planar, puma, unlimited};
use dynamics_core::control::{ControlLaw, Gains, Guard};
use dynamics_core::trig::{Libm, Method};
use dynamics_core::{
    Body, Command, Controller, ControllerConfig, Dynamics, InverseDynamics, Limits, Live, Measurement, Reference,
    Sensed, Term, Trig,
};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::scene::MotionSpec;
use robot_compiler::{Robot, SceneFile};
use sim::failure::Failure;
use sim::plant::actuator::ActuatorSettings;
use sim::plant::{Arm, Clock, Plant};
use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;

const GROUP: &str = "stability";

/// A control law in the plot of stable regions.
#[derive(Clone, Copy, Debug)]
struct StableLaw {
    name: &'static str,
    law: ControlLaw,
    delay: usize,
}

const LAWS: [StableLaw; 3] = [
    StableLaw { name: "computed torque", law: ControlLaw::ComputedTorque, delay: 0 },
    StableLaw { name: "computed torque, a tick late", law: ControlLaw::ComputedTorque, delay: 1 },
    StableLaw { name: "PD with gravity", law: ControlLaw::PdGravity, delay: 0 },
];

/// The Puma's postures: the start of the shipped scenes; level and stretched; and with axes 4 and 6 in line.
const POSTURES: [(&str, [f64; 6]); 3] = [
    ("ready", READY),
    ("stretched", [0.0, 0.0, -FRAC_PI_2, 0.0, 0.5, 0.0]),
    ("wrist singular", [0.0, 0.9, -1.6, 0.0, 0.0, 0.0]),
];
const READY: [f64; 6] = [0.0, 0.9, -1.6, 0.0, 0.5, 0.0];

/// Natural frequency of the shipped Puma scenes, rad/s.
const PUMA_FREQUENCY: f64 = 40.0;

/// Assumed and true properties of the arm; masses at the tip in kg.
#[derive(Clone, Copy, Debug)]
struct Knowledge {
    name: &'static str,
    rotors: bool,
    told: f64,
    held: f64,
}

const RIGHT: Knowledge = Knowledge { name: "right model", rotors: true, told: 0.0, held: 0.0 };

/// Wrong models for computed torque at the ready posture.
const WRONG: [Knowledge; 4] = [
    Knowledge { name: "rotors left out", rotors: false, ..RIGHT },
    Knowledge { name: "4 kg held, told 2 kg", told: 2.0, held: 4.0, ..RIGHT },
    Knowledge { name: "4 kg held, told nothing", held: 4.0, ..RIGHT },
    Knowledge { name: "nothing held, told 4 kg", told: 4.0, ..RIGHT },
];

/// All cells of this group.
///
/// # Errors
/// A shipped robot cannot be read.
pub(crate) fn cells() -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::new();
    for law in LAWS {
        for frequency in [20.0, 80.0] {
            let done = "planar 2R in a vertical plane at (0.4, 0.9) rad, critically damped";
            period_cells(&mut cells, &format!("{}, {frequency} rad/s", law.name), done, &planar_case(law, frequency)?);
        }
    }
    for law in LAWS {
        for (name, posture) in POSTURES {
            let case = puma_case(law, PUMA_FREQUENCY, posture, RIGHT)?;
            let done = format!("Puma {name}, {PUMA_FREQUENCY} rad/s, critically damped");
            let name = format!("{}, Puma {name}", law.name);
            period_cells(&mut cells, &name, &done, &case);
            cells.push(Cell::new(
                GROUP,
                format!("frequency at 1 kHz, {name}"),
                "highest natural frequency of all joints that is stable, from the eigenvalues",
                Outcome::between(case.sampled.frequency_max(1e-3), PUMA_FREQUENCY, f64::INFINITY, "rad/s"),
                "the shipped scenes are not stable",
            ));
        }
    }
    for knowledge in WRONG {
        let case = puma_case(LAWS[0], PUMA_FREQUENCY, READY, knowledge)?;
        let done = format!("Puma ready, computed torque, {PUMA_FREQUENCY} rad/s, {}", knowledge.name);
        period_cells(&mut cells, knowledge.name, &done, &case);
    }
    Ok(cells)
}

/// Cells of the predicted period, and of the simulated period relative to it.
fn period_cells<const N: usize>(cells: &mut Vec<Cell>, name: &str, done: &str, case: &Case<N>) {
    let predicted = case.sampled.period_max();
    cells.push(Cell::new(
        GROUP,
        format!("predicted period, {name}"),
        format!("{done}: longest stable period, from the eigenvalues of the linearised sampled loop"),
        Outcome::record(predicted, "s"),
        "",
    ));
    cells.push(Cell::new(
        GROUP,
        format!("simulated over predicted, {name}"),
        "longest period at which the swings of the simulated arm, from a hundredth of a degree, shrink in 400 ticks",
        Outcome::between(case.simulated(predicted) / predicted, 0.95, 1.05, ""),
        "the simulated arm leaves the linearised loop",
    ));
}

/// An arm held in a posture, for simulation and for linearisation.
struct Case<const N: usize> {
    arm: Arm<N>,
    config: ControllerConfig<f64, N>,
    sampled: SampledLoop<N>,
}

fn planar_case(law: StableLaw, frequency: f64) -> Result<Case<2>, Failure> {
    const POSTURE: [f64; 2] = [0.4, 0.9];
    Case::new(planar()?, Vector3::new(0.0, -9.81, 0.0), law, frequency, [POSTURE; 2], RIGHT)
}

fn puma_case(law: StableLaw, frequency: f64, posture: [f64; 6], knowledge: Knowledge) -> Result<Case<6>, Failure> {
    Case::new(puma()?, Vector3::new(0.0, 0.0, -9.81), law, frequency, [READY, posture], knowledge)
}

/// A steel block at the tip, with its centre 5 cm beyond the tip.
fn block(mass: f64) -> Option<Body> {
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.00072, 0.00072, 0.0006)) * mass;
    (mass > 0.0).then_some(Body { mass, com: Vector3::new(0.0, 0.0, 0.05), inertia })
}

impl<const N: usize> Case<N> {
    /// Creates a case without limits, friction or guards; the fixed inertias are those at `start`.
    fn new(
        robot: Robot,
        gravity: Vector3<f64>,
        law: StableLaw,
        frequency: f64,
        [start, posture]: [[f64; N]; 2],
        knowledge: Knowledge,
    ) -> Result<Self, Failure> {
        let model = robot.model::<N>().map_err(Failure::input)?;
        let arm = Arm {
            joints: unlimited(joints::<N>(&robot)?),
            tool: robot.tool,
            payload: block(knowledge.held),
            gravity,
            tip_wrench: None,
        };
        let mut file = SceneFile::default_for(robot);
        file.motion = MotionSpec::Hold { q: start.to_vec(), duration: 1.0 };
        file.control.law = law.law;
        file.control.natural_frequency = vec![frequency; N];
        file.model.gravity = Term::Constant(gravity);
        let payload = |mass| block(mass).map_or(Term::Absent, Term::Constant);
        let mut nature = file.model.clone();
        nature.payload = payload(knowledge.held);
        file.model.payload = payload(knowledge.told);
        if !knowledge.rotors {
            file.model.rotor = Term::Absent;
        }
        let config = ControllerConfig {
            friction: None,
            limits: [Limits::none(); N],
            torque_step: [f64::INFINITY; N],
            guard: [Guard { position_margin: 0.0, velocity_max: f64::INFINITY }; N],
            ..file.controller_config::<N>(&model)
        };
        let gains: [Gains<f64>; N] = config.gains;
        let sampled = SampledLoop {
            arm: Dynamics::new(model, nature.scene(&model)),
            model: Dynamics::new(model, file.scene(&model)),
            posture,
            law: law.law,
            gains,
            delay: law.delay,
        };
        Ok(Self { arm, config, sampled })
    }

    /// The longest period, s, at which the simulated arm settles, to 0.3 %. The search covers 0.8 to 1.25 of the predicted period; a ratio at an end
    /// of that interval means that the true value may be outside.
    fn simulated(&self, predicted: f64) -> f64 {
        last((predicted / 1.25, predicted * 1.25), 7, |h| self.settles(h))
    }

    /// True if the oscillations of the simulated arm about its posture decay at this period (s).
    fn settles(&self, h: f64) -> bool {
        const TICKS: usize = 400;
        /// Initial deviation, rad: a hundredth of a degree.
        const OFF: f64 = 1.75e-4;
        let posture = self.sampled.posture;
        let at_rest = torque_at_rest(&self.sampled.arm, &posture);
        let believed = torque_at_rest(&self.sampled.model, &posture);
        let mut controller = Controller::new(self.config, self.sampled.model, Method::Libm);
        // The delay is implemented in this loop, not in the actuators, which would let the arm fall until the first command arrives.
        let mut waiting = VecDeque::from(vec![at_rest; self.sampled.delay]);
        let start = core::array::from_fn(|i| posture[i] + if i % 2 == 0 { OFF } else { -OFF });
        let clock = Clock { period: h, steps_per_tick: 4 };
        let mut plant = Plant::new(&self.arm, None, ActuatorSettings::default(), clock, start);
        let reference = Reference { q: posture, qd: [0.0; N], qdd: [0.0; N] };
        let (mut early, mut late) = (0.0_f64, 0.0_f64);
        for tick in 0..TICKS {
            let state = *plant.state();
            let off = (0..N).fold(0.0_f64, |off, i| off.max((state.q[i] - posture[i]).abs()));
            // Far from the posture the linear model is not valid, and large oscillations may decay again.
            if off > 100.0 * OFF {
                return false;
            }
            if tick < TICKS / 4 {
                early = early.max(off);
            } else if tick >= TICKS - TICKS / 4 {
                late = late.max(off);
            }
            let measured = Measurement { sensed: Sensed::State { q: state.q, qd: state.qd }, age_ticks: 0 };
            let Command::Drive { torque, .. } = controller.tick(&reference, &measured) else { return false };
            // Compensate the gravity error of a wrong model, so that the arm rests in its posture.
            waiting.push_back(core::array::from_fn(|i| torque[i] + (at_rest[i] - believed[i])));
            let Some(torque) = waiting.pop_front() else { return false };
            if plant.drive(&torque).is_err() {
                return false;
            }
        }
        late < early
    }
}

/// Torque that holds the arm in its posture.
fn torque_at_rest<const N: usize>(dynamics: &Dynamics<f64, N>, posture: &[f64; N]) -> [f64; N] {
    dynamics.inverse_dynamics(&Libm.sin_cos_all(posture), posture, &[0.0; N], &[0.0; N], &Live::zero())
}
