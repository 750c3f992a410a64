//! A model that is evaluated in some ticks only.

use crate::control::support::{Desk, by_hand, config, controller, driven, measured, planar};
use dynamics_core::control::{Between, ControlLaw, EveryNth, Gains};
use dynamics_core::{Command, Controller, Fault, InverseDynamics, Live, Measurement, Reference, SinCos, Trig};
use std::cell::Cell;

/// One joint on a rail: `tau = 3 + t / 4 + m qdd`, with the time passed as the position. The numbers are sums of few powers
/// of two, so every result below is exact.
#[derive(Clone, Debug, Default)]
struct Drifting {
    mass: f64,
    calls: Cell<u32>,
}

impl InverseDynamics<f64, 1> for Drifting {
    fn inverse_dynamics(
        &self,
        _turn: &[SinCos<f64>; 1],
        q: &[f64; 1],
        _qd: &[f64; 1],
        qdd: &[f64; 1],
        _live: &Live<f64, 1>,
    ) -> [f64; 1] {
        self.calls.set(self.calls.get() + 1);
        [3.0 + 0.25 * q[0] + self.mass * qdd[0]]
    }
}

const FIXED: [Gains<f64>; 1] = [Gains { position: 0.0, velocity: 0.0, inertia: 1.5 }];

fn rail(mass: f64, every: u32, between: Between) -> EveryNth<Drifting, f64, 1> {
    EveryNth::new(Drifting { mass, ..Drifting::default() }, every, between, &FIXED)
}

/// The torque at the time `t` for the acceleration `qdd`.
fn at(dynamics: &mut impl InverseDynamics<f64, 1>, t: f64, qdd: f64) -> f64 {
    dynamics.tick(|| Desk.sin_cos_all(&[t]), &[t], &[0.0], &[qdd], &Live::zero())[0]
}

/// States along a motion of the planar arm, one a tick.
fn ticks() -> impl Iterator<Item = (Reference<f64, 2>, Measurement<f64, 2>)> {
    (0..40).map(|tick| {
        let t = f64::from(tick) * 1e-3;
        let q = [0.4 + 2.0 * t, -1.1 + 3.0 * t * t];
        let reference = Reference { q, qd: [2.0, 6.0 * t], qdd: [(9.0 * t).sin(), 6.0] };
        (reference, measured([q[0] - 1e-3, q[1] + 2e-3 * t], [2.01, 6.0 * t - 0.01]))
    })
}

#[test]
fn in_every_tick_it_is_the_inner_model_bit_for_bit() {
    for law in [
        ControlLaw::ComputedTorque,
        ControlLaw::PdGravity,
        ControlLaw::DiagonalInertia,
        ControlLaw::Feedforward,
        ControlLaw::Impedance,
        ControlLaw::Split,
    ] {
        for (every, between) in [(0, Between::Hold), (1, Between::Hold), (1, Between::Extrapolate)] {
            let mut plain = controller(config(law));
            let settings = config(law);
            let mut wrapped = Controller::new(settings, EveryNth::new(planar(), every, between, &settings.gains), Desk);
            for (reference, measurement) in ticks() {
                let bits = |command| driven(command).0.map(f64::to_bits);
                let expected = bits(plain.tick(&reference, &measurement));
                assert_eq!(bits(wrapped.tick(&reference, &measurement)), expected, "{law:?}, every {every}");
            }
        }
    }
}

#[test]
fn held_is_a_constant_torque_and_the_fixed_inertia_acts_in_every_tick() {
    // With the inner mass equal to the fixed one, and no drift, the held torque is the whole torque.
    let mut dynamics = rail(1.5, 4, Between::Hold);
    for tick in 0..9 {
        let qdd = 0.5 * f64::from(tick) - 1.0;
        assert_eq!(at(&mut dynamics, 0.0, qdd), 3.0 + 1.5 * qdd, "tick {tick}");
    }
    assert_eq!(dynamics.inner_mut().calls.get(), 3);
    // With drift it is the torque of the last evaluation; with another mass, the difference acts at the last acceleration.
    let mut dynamics = rail(2.0, 4, Between::Hold);
    for tick in 0..9 {
        let (t, qdd) = (f64::from(tick), 0.5 * f64::from(tick));
        let (then, qdd_then) = (f64::from(tick / 4 * 4), 0.5 * f64::from(tick / 4 * 4));
        let expected = 3.0 + 0.25 * then + 2.0 * qdd_then + 1.5 * (qdd - qdd_then);
        assert_eq!(at(&mut dynamics, t, qdd), expected, "tick {tick}");
    }
}

#[test]
fn extrapolated_is_a_torque_linear_in_time_from_the_second_evaluation_on() {
    let mut dynamics = rail(1.5, 4, Between::Extrapolate);
    for tick in 0..14 {
        let (t, qdd) = (f64::from(tick), if tick % 3 == 0 { 2.0 } else { -0.5 });
        // After one evaluation there is no slope: the torque is held.
        let known = if tick < 4 { 0.0 } else { t };
        assert_eq!(at(&mut dynamics, t, qdd), 3.0 + 0.25 * known + 1.5 * qdd, "tick {tick}");
    }
    assert_eq!(dynamics.inner_mut().calls.get(), 4);
}

#[test]
fn sine_and_cosine_are_asked_for_in_the_ticks_of_evaluation_alone() {
    #[derive(Clone, Copy)]
    struct Counting<'a>(&'a Cell<u32>);
    impl Trig<f64> for Counting<'_> {
        fn sin_cos(&self, angle: f64) -> SinCos<f64> {
            self.0.set(self.0.get() + 1);
            Desk.sin_cos(angle)
        }
    }
    let asked = Cell::new(0);
    let settings = config(ControlLaw::ComputedTorque);
    let dynamics = EveryNth::new(planar(), 5, Between::Hold, &settings.gains);
    let mut slow = Controller::new(settings, dynamics, Counting(&asked));
    for (reference, measurement) in ticks() {
        driven(slow.tick(&reference, &measurement));
    }
    assert_eq!(asked.get(), 2 * 40 / 5);
}

#[test]
fn feedback_and_reference_act_between_evaluations_as_in_them() {
    // Gravity is held; the wanted acceleration acts through the fixed inertia in every tick.
    for law in [ControlLaw::PdGravity, ControlLaw::DiagonalInertia] {
        let settings = config(law);
        let mut slow = Controller::new(settings, EveryNth::new(planar(), 4, Between::Hold, &settings.gains), Desk);
        let mut gravity = [0.0; 2];
        for (tick, (reference, measurement)) in ticks().enumerate() {
            let dynamics_core::Sensed::State { q, qd } = measurement.sensed else { unreachable!() };
            if tick % 4 == 0 {
                gravity = by_hand(q, [0.0; 2], [0.0; 2]);
            }
            let (torque, _) = driven(slow.tick(&reference, &measurement));
            for i in 0..2 {
                let Gains { position, velocity, inertia } = settings.gains[i];
                let feedforward = if law == ControlLaw::DiagonalInertia { reference.qdd[i] } else { 0.0 };
                let wanted = feedforward + velocity * (reference.qd[i] - qd[i]) + position * (reference.q[i] - q[i]);
                let expected = gravity[i] + inertia * wanted;
                assert!((torque[i] - expected).abs() < 1e-12, "{law:?}, tick {tick}: {torque:?}, {expected}");
            }
        }
    }
}

#[test]
fn after_a_reset_the_next_tick_evaluates_and_nothing_is_left_of_what_was_not_finite() {
    let settings = dynamics_core::ControllerConfig { gains: FIXED, ..config(ControlLaw::Feedforward) };
    let new = |between| Controller::new(settings, rail(2.0, 3, between), Desk);
    let wanting = |qdd| Reference { q: [1.0], qd: [0.0], qdd: [qdd] };
    let still = measured([1.0], [0.0]);
    for between in [Between::Hold, Between::Extrapolate] {
        let mut broken = new(between);
        // 2 MAX is infinite, and so is the slope to it.
        for _ in 0..3 {
            driven(broken.tick(&wanting(1.0), &still));
        }
        let command = broken.tick(&wanting(f64::MAX), &still);
        assert_eq!(command, Command::Brake(Fault::NonFiniteTorque { joint: 0 }));
        let evaluated = broken.dynamics_mut().inner_mut().calls.get();
        assert_eq!(evaluated, 2);
        broken.reset();
        let mut fresh = new(between);
        for tick in 0..7 {
            let reference = wanting(f64::from(tick));
            assert_eq!(broken.tick(&reference, &still), fresh.tick(&reference, &still), "{between:?}, tick {tick}");
        }
        assert_eq!(broken.dynamics_mut().inner_mut().calls.get(), evaluated + 3);
        // The same in the middle between two evaluations.
        broken.reset();
        driven(broken.tick(&wanting(0.0), &still));
        assert_eq!(broken.dynamics_mut().inner_mut().calls.get(), evaluated + 4);
    }
}
