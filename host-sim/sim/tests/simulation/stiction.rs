//! Dry friction of the plant: where a joint stops, when it breaks loose, and the effect of coupled joints on each other.
#![allow(clippy::float_cmp, reason = "a joint that is held keeps every bit")]

use crate::reference::Golden;
use indicatif::ProgressBar;
use nalgebra::{SVector, Vector3};
use robot_compiler::SceneFile;
use robot_compiler::scene::Integrator;
use sim::plant::actuator::ActuatorSettings;
use sim::plant::{Arm, Clock, JointFriction, Plant, State};
use sim::run::simulation;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The integrators, with the error that each may have on a motion of some tenths of a radian.
const METHODS: [(Integrator, f64); 3] = [
    (Integrator::RungeKutta, 1e-9),
    (Integrator::Adaptive { tolerance: 1e-10 }, 1e-9),
    (Integrator::SemiImplicitEuler, 1e-3),
];

/// The planar arm in a horizontal plane.
fn planar() -> Arm<2> {
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    arm.gravity = Vector3::zeros();
    arm
}

/// Its first link alone.
fn link() -> Arm<1> {
    let Arm { joints: [first, _], tool, gravity, .. } = planar();
    Arm { joints: [first], tool, payload: None, gravity, tip_wrench: None }
}

fn plant<const N: usize>(arm: &Arm<N>, friction: [JointFriction; N], integrator: Integrator) -> Plant<N> {
    let clock = Clock { period: 1e-2, steps_per_tick: 10 };
    Plant::new(arm, Some(friction), ActuatorSettings::default(), clock, [0.0; N]).with_integrator(integrator)
}

/// Position at which the link rests after 6 N m for 0.1 s, then no torque, rad; and its state after two more seconds.
fn stopped(friction: JointFriction, integrator: Integrator) -> (f64, State<1>) {
    let mut plant = plant(&link(), [friction], integrator);
    (0..10).for_each(|_| plant.drive(&[6.0]).unwrap());
    for _ in 0..1000 {
        plant.drive(&[0.0]).unwrap();
        if plant.state().qd == [0.0] {
            break;
        }
    }
    let rest = plant.state().q[0];
    (0..200).for_each(|_| plant.drive(&[0.0]).unwrap());
    (rest, *plant.state())
}

#[test]
fn a_sliding_joint_stops_where_the_formula_says_and_stays() {
    let inertia = link().terms(&[0.0], &[0.0]).mass_matrix[(0, 0)];
    let (b, c, t) = (0.8, 2.0, 0.1);
    // I v' = 6 - b v - c for 0.1 s, then I v' = -b v - c until v = 0.
    let (rate, drift) = (b / inertia, (6.0 - c) / b);
    let speed = drift * (1.0 - (-rate * t).exp());
    let driven = drift * t - speed / rate;
    let slides = (1.0 + speed * b / c).ln() / rate;
    let place = driven + (speed + c / b) / rate * (1.0 - (-rate * slides).exp()) - c / b * slides;
    assert!(place > 0.01 && slides > 1e-2, "{place} rad, {slides} s");
    for (integrator, error) in METHODS {
        let (rest, later) = stopped(JointFriction::new(b, c), integrator);
        assert!((rest - place).abs() < error * place, "{integrator:?}: {rest} rad, expected {place} rad");
        assert_eq!((later.q, later.qd), ([rest], [0.0]), "{integrator:?}");
        // With 1 % more friction it stops elsewhere, farther away than that error.
        let (other, _) = stopped(JointFriction::new(b, 1.01 * c), integrator);
        assert!((other - place).abs() > 5.0 * error * place, "{integrator:?}: {other} rad");
    }
}

#[test]
fn a_joint_breaks_loose_at_its_level_whatever_the_direction() {
    // Coulomb friction is 3 N m with a difference of half a newton metre between the directions. A constant torque drives the joint back.
    let friction = JointFriction { asymmetry: 0.25, offset: 0.5, ..JointFriction::new(0.1, 3.0) };
    for (integrator, _) in METHODS {
        let after = |torque: f64| {
            let mut plant = plant(&link(), [friction], integrator);
            (0..1000).for_each(|_| plant.drive(&[torque]).unwrap());
            plant.state().q[0]
        };
        for held in [3.7499, 1.0, 0.0, -2.2499] {
            assert_eq!(after(held), 0.0, "{integrator:?}: {held} N m");
        }
        assert!(after(3.7501) > 0.0 && after(-2.2501) < 0.0, "{integrator:?}");
        assert!(after(4.0) > 1.0 && after(-2.5) < -1.0, "{integrator:?}");
    }
}

/// The motion of an arm with Coulomb friction, by trying all states of all joints at the start of each short step. It shares only the terms of the
/// equations of motion with the plant.
struct Trial<'a> {
    arm: &'a Arm<2>,
    coulomb: [f64; 2],
    state: State<2>,
}

impl Trial<'_> {
    /// Acceleration with the joints in these states (direction, or zero for a held joint), and the loads of held joints.
    fn motion(&self, state: &State<2>, torque: [f64; 2], mode: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let terms = self.arm.terms(&state.q, &state.qd);
        let push: [f64; 2] = core::array::from_fn(|i| torque[i] - terms.coriolis[i] - mode[i] * self.coulomb[i]);
        let d = terms.mass_matrix;
        let qdd = match mode.map(|sign| sign != 0.0) {
            [false, false] => [0.0; 2],
            [true, false] => [push[0] / d[(0, 0)], 0.0],
            [false, true] => [0.0, push[1] / d[(1, 1)]],
            [true, true] => d.lu().solve(&SVector::from(push)).unwrap().into(),
        };
        (qdd, core::array::from_fn(|i| push[i] - d[(i, 0)] * qdd[0] - d[(i, 1)] * qdd[1]))
    }

    /// The only state of every joint that is consistent with the motion that follows from it.
    fn mode(&self, torque: [f64; 2]) -> [f64; 2] {
        let all = [-1.0, 0.0, 1.0].into_iter().flat_map(|a| [-1.0, 0.0, 1.0].map(|b| [a, b]));
        let mut agree = all.filter(|mode| {
            let (qdd, load) = self.motion(&self.state, torque, *mode);
            (0..2).all(|i| match self.state.qd[i] {
                0.0 if mode[i] == 0.0 => load[i].abs() <= self.coulomb[i],
                0.0 => mode[i] * qdd[i] > 0.0,
                qd => mode[i] == qd.signum(),
            })
        });
        let found = agree.next().unwrap();
        assert_eq!(agree.next(), None);
        found
    }

    fn step(&self, torque: [f64; 2], mode: [f64; 2], h: f64) -> State<2> {
        let slope = |s: &State<2>| State { q: s.qd, qd: self.motion(s, torque, mode).0 };
        let along = |k: &State<2>, h: f64| State {
            q: core::array::from_fn(|i| self.state.q[i] + h * k.q[i]),
            qd: core::array::from_fn(|i| self.state.qd[i] + h * k.qd[i]),
        };
        let k1 = slope(&self.state);
        let k2 = slope(&along(&k1, h / 2.0));
        let k3 = slope(&along(&k2, h / 2.0));
        let k4 = slope(&along(&k3, h));
        let sum = |k: [f64; 4]| (k[0] + 2.0 * (k[1] + k[2]) + k[3]) / 6.0;
        let mean = State {
            q: core::array::from_fn(|i| sum([k1.q[i], k2.q[i], k3.q[i], k4.q[i]])),
            qd: core::array::from_fn(|i| sum([k1.qd[i], k2.qd[i], k3.qd[i], k4.qd[i]])),
        };
        along(&mean, h)
    }

    /// Simulates this time, s, under a torque. Returns the number of joints that came to rest or broke loose.
    fn pass(&mut self, torque: [f64; 2], time: f64) -> u32 {
        let (mut left, mut changes, mut last) = (time, 0, None);
        while left > 1e-13 {
            let mode = self.mode(torque);
            changes += last.map_or(0, |last: [f64; 2]| (0..2).filter(|&i| last[i] != mode[i]).count() as u32);
            last = Some(mode);
            let over = |end: &State<2>| {
                let (_, load) = self.motion(end, torque, mode);
                let turned = (0..2).any(|i| mode[i] * end.qd[i] < 0.0);
                turned || (0..2).any(|i| mode[i] == 0.0 && load[i].abs() > self.coulomb[i])
            };
            let mut h = left.min(2e-5);
            let mut end = self.step(torque, mode, h);
            if over(&end) {
                // The shortest step that is too long, by bisection.
                let mut low = 0.0;
                for _ in 0..60 {
                    let middle = 0.5 * (low + h);
                    if over(&self.step(torque, mode, middle)) { h = middle } else { low = middle }
                }
                end = self.step(torque, mode, h);
                for i in 0..2 {
                    if mode[i] * end.qd[i] < 0.0 {
                        end.qd[i] = 0.0;
                    }
                }
            }
            left -= h;
            self.state = end;
        }
        changes
    }
}

/// Torques for twelve intervals of 0.1 s, N m: they move one joint while the other holds, tear it loose by the first one's motion, and reverse both.
const TORQUES: [[f64; 2]; 12] = [
    [9.0, 0.0],
    [3.0, 0.3],
    [-8.0, 0.0],
    [0.0, 0.0],
    [0.0, 2.0],
    [0.0, 0.0],
    [7.0, 1.5],
    [-7.0, -1.5],
    [-7.0, 0.9],
    [2.0, -0.9],
    [0.0, 0.0],
    [0.0, 0.0],
];

#[test]
fn coupled_joints_move_as_the_trial_of_all_their_states_has_it() {
    let arm = planar();
    let coulomb = [4.0, 1.0];
    let mut trial = Trial { arm: &arm, coulomb, state: State { q: [0.0; 2], qd: [0.0; 2] } };
    let mut changes = 0;
    let exact = TORQUES.map(|torque| {
        changes += trial.pass(torque, 0.1);
        trial.state
    });
    assert!(changes >= 6, "{changes} changes");
    assert!(exact.iter().any(|s| s.qd[0] == 0.0 && s.qd[1] == 0.0) && exact.iter().any(|s| s.qd[0] != 0.0));
    let worst = |coulomb: [f64; 2], integrator: Integrator, steps_per_tick: u32| {
        let clock = Clock { period: 0.1, steps_per_tick };
        let friction = coulomb.map(|c| JointFriction::new(0.0, c));
        let mut plant =
            Plant::new(&arm, Some(friction), ActuatorSettings::default(), clock, [0.0; 2]).with_integrator(integrator);
        let errors = TORQUES.iter().zip(&exact).map(|(torque, exact)| {
            plant.drive(torque).unwrap();
            let at = plant.state();
            (0..2).map(|i| (at.q[i] - exact.q[i]).abs().max((at.qd[i] - exact.qd[i]).abs())).fold(0.0, f64::max)
        });
        errors.fold(0.0, f64::max)
    };
    let by = |steps: u32| worst(coulomb, Integrator::RungeKutta, steps);
    let [coarse, fine, finest] = [25, 50, 400].map(by);
    let adaptive = worst(coulomb, Integrator::Adaptive { tolerance: 1e-10 }, 1);
    println!("{changes} changes; {coarse:e} {fine:e} {finest:e}, adaptive {adaptive:e}");
    assert!(finest < 1e-8 && adaptive < 1e-7, "{finest:e}, adaptive {adaptive:e}");
    assert!(coarse < 1e-4 && fine < coarse / 4.0, "{coarse:e} {fine:e}");
    // With 0.1 % more friction the motion differs.
    assert!(worst([4.0, 1.001], Integrator::RungeKutta, 400) > 1e-5);
}

/// RMS of each joint's tracking error, rad or m.
fn tracking(scene: &SceneFile) -> Vec<f64> {
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    let run = simulation::run(scene, &stop, &bar).unwrap();
    run.summary.tracking_rms
}

#[test]
fn tracking_errors_at_the_default_step_are_those_of_the_adaptive_integrator() {
    for name in ["yam_move", "rebot_move", "puma560_pick"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).with_extension("toml");
        let mut scene = SceneFile::load(&path).unwrap();
        scene.plant.integrator = Integrator::Adaptive { tolerance: 1e-9 };
        let exact = tracking(&scene);
        scene.plant.integrator = Integrator::RungeKutta;
        let found = tracking(&scene);
        let worst = |found: &[f64]| found.iter().zip(&exact).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        println!("{name}: {found:?} {exact:?} {}", worst(&found));
        assert!(worst(&found) < 0.05, "{name}: {found:?}, adaptive {exact:?}");
        // Without dry friction in the world, the errors differ.
        scene.plant.friction = false;
        let without = tracking(&scene);
        assert!(worst(&without) > 0.2, "{name}: {without:?}, with friction {exact:?}");
    }
}
