//! Friction feedforward beyond viscous and Coulomb friction: its formula, its bound, and its value at rest.

use crate::control::support::{Desk, UnitMasses, config, driven, measured};
use dynamics_core::control::{Between, ControlLaw, EveryNth, Friction, FrictionTerms, LoadGrowth, Rise};
use dynamics_core::{Controller, InverseDynamics, Live, Reference, SinCos};

const FRICTION: Friction<f64> = Friction { viscous: 0.3, coulomb: 0.7, per_smoothing_speed: 1.0 / 0.005 };
const TERMS: FrictionTerms<f64> = FrictionTerms {
    rise: Some(Rise { torque: 2.1, per_speed: 1.0 / 0.05 }),
    load: Some(LoadGrowth { coulomb: 0.02, rise: 0.08, most: 20.0 }),
    asymmetry: Some(0.1),
    offset: Some(-0.05),
};

/// A unit mass on a rail with terms of friction.
#[derive(Clone, Debug, Default)]
struct Rail(UnitMasses, Option<[FrictionTerms<f64>; 1]>);

impl InverseDynamics<f64, 1> for Rail {
    fn inverse_dynamics(
        &self,
        turn: &[SinCos<f64>; 1],
        q: &[f64; 1],
        qd: &[f64; 1],
        qdd: &[f64; 1],
        live: &Live<f64, 1>,
    ) -> [f64; 1] {
        self.0.inverse_dynamics(turn, q, qd, qdd, live)
    }

    fn friction_terms(&self) -> Option<&[FrictionTerms<f64>; 1]> {
        self.1.as_ref()
    }
}

fn speeds() -> impl Iterator<Item = f64> {
    (-4000..=4000).map(|i| f64::from(i) * 1e-4)
}

fn loads() -> impl Iterator<Item = f64> {
    (-50..=50).map(|i| f64::from(i) * 0.7)
}

/// The formula, with the exponential of the standard library.
fn expected(terms: &FrictionTerms<f64>, qd: f64, tau: f64) -> f64 {
    let x = (qd * FRICTION.per_smoothing_speed).clamp(-1.0, 1.0);
    let s = 0.5 * x * (3.0 - x * x);
    let e = terms.rise.map_or(0.0, |rise| (-(qd * rise.per_speed).powi(2)).exp());
    let level = FRICTION.coulomb + terms.rise.map_or(0.0, |rise| rise.torque) * e;
    let growth = terms.load.map_or(0.0, |load| (load.coulomb + load.rise * e) * (tau + s * level).abs().min(load.most));
    terms.offset.unwrap_or(0.0) + FRICTION.viscous * qd + terms.asymmetry.unwrap_or(0.0) * s * s + s * (level + growth)
}

#[test]
fn torque_is_that_of_the_formula_with_each_term_alone_and_with_all() {
    let none = FrictionTerms::NONE;
    let alone = [
        none,
        FrictionTerms { rise: TERMS.rise, ..none },
        FrictionTerms { load: TERMS.load, ..none },
        FrictionTerms { asymmetry: TERMS.asymmetry, ..none },
        FrictionTerms { offset: TERMS.offset, ..none },
        TERMS,
    ];
    for terms in alone {
        for (qd, tau) in speeds().step_by(7).flat_map(|qd| loads().step_by(5).map(move |tau| (qd, tau))) {
            let found = FRICTION.torque_with(&terms, qd, tau);
            // The exponential has an error of at most 5.8e-4; it is multiplied by the rise and its growth with 20 N m.
            let close = 5.8e-4 * (2.1 + 0.08 * 20.0);
            assert!((found - expected(&terms, qd, tau)).abs() < close, "{terms:?} at {qd}, {tau}: {found}");
        }
    }
    // The comparison detects a wrong sign, or a missing term.
    assert!((FRICTION.torque_with(&none, 0.02, 0.0) - expected(&TERMS, 0.02, 0.0)).abs() > 1.0);
    for qd in speeds() {
        assert!((FRICTION.torque_with(&none, qd, 3.0) - FRICTION.torque(qd)).abs() < 1e-15, "without terms at {qd}");
    }
}

#[test]
fn a_joint_that_starts_gets_breakaway_and_one_that_moves_fast_gets_coulomb() {
    let terms = FrictionTerms { load: None, asymmetry: None, offset: None, ..TERMS };
    let at = |qd: f64| FRICTION.torque_with(&terms, qd, 0.0);
    let most = speeds().map(at).fold(0.0, f64::max);
    assert!(most > 0.98 * 2.8 && most <= 2.8 + FRICTION.viscous * 0.05, "{most}");
    assert!((at(0.4) - (0.7 + 0.3 * 0.4)).abs() < 1e-12, "{}", at(0.4));
    assert_eq!(at(-0.01), -at(0.01));
}

#[test]
fn torque_never_exceeds_its_bound_and_reaches_most_of_it() {
    let mut most = 0.0_f64;
    for speed in [0.0, 0.01, 0.1, 0.4] {
        let bound = TERMS.bound(&FRICTION, speed);
        for (qd, tau) in speeds().filter(|qd| qd.abs() <= speed).flat_map(|qd| loads().map(move |tau| (qd, tau))) {
            let torque = FRICTION.torque_with(&TERMS, qd, tau).abs();
            assert!(torque <= bound, "{torque} exceeds {bound} at {qd}, {tau}");
            most = most.max(torque / bound);
        }
        // A load beyond every limit counts as the limit.
        for tau in [1e6, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(FRICTION.torque_with(&TERMS, speed, tau).abs() <= bound);
        }
    }
    assert!(most > 0.9, "the bound is {most} of what is found");
}

#[test]
fn a_reference_at_rest_gets_the_offset_alone_under_any_load() {
    for tau in loads().chain([1e30]) {
        assert_eq!(FRICTION.torque_with(&TERMS, 0.0, tau), -0.05, "under {tau}");
        let terms = FrictionTerms { offset: None, ..TERMS };
        assert_eq!(FRICTION.torque_with(&terms, 0.0, tau), 0.0, "under {tau}");
    }
}

#[test]
fn torque_has_the_direction_of_the_reference_and_is_continuous() {
    let terms = FrictionTerms { offset: None, ..TERMS };
    for tau in loads() {
        let at = |qd: f64| FRICTION.torque_with(&terms, qd, tau);
        for qd in speeds().filter(|qd| *qd != 0.0) {
            assert!(at(qd) * qd > 0.0, "at {qd} under {tau}: {}", at(qd));
        }
        // Steepest change of the level over 5 mrad/s: 1.5 (2.8 + 2) / 0.005, and less beyond.
        let steepest = 1.5 * 5.0 / 0.005;
        let jump = speeds().map(|qd| (at(qd + 1e-6) - at(qd)).abs()).fold(0.0, f64::max);
        assert!(jump < steepest * 1e-6, "{jump} under {tau}");
    }
}

#[test]
fn single_precision_gives_the_same_to_its_rounding() {
    let (friction, terms) = (FRICTION.cast::<f32>(), TERMS.cast::<f32>());
    for (qd, tau) in speeds().step_by(3).flat_map(|qd| loads().step_by(9).map(move |tau| (qd, tau))) {
        let (narrow, wide) =
            (friction.torque_with(&terms, qd as f32, tau as f32), FRICTION.torque_with(&TERMS, qd, tau));
        assert!((f64::from(narrow) - wide).abs() < 2e-5, "{narrow} is not {wide} at {qd}, {tau}");
    }
}

#[test]
fn extreme_numbers_stay_finite_and_nan_is_not_hidden() {
    for qd in [0.0, -0.0, f32::MIN_POSITIVE, 1e-30, 1e10, -1e10, 1e30, f32::MAX] {
        for tau in [0.0, 1e30, f32::MAX, f32::INFINITY] {
            let terms = TERMS.cast::<f32>();
            let friction = Friction { viscous: 0.0, ..FRICTION.cast::<f32>() };
            assert!(friction.torque_with(&terms, qd, tau).is_finite(), "at {qd}, {tau}");
        }
    }
    assert!(FRICTION.torque_with(&TERMS, f64::NAN, 0.0).is_nan());
    assert!(FRICTION.torque_with(&TERMS, 0.1, f64::NAN).is_nan());
}

#[test]
fn the_controller_adds_the_terms_along_the_reference_and_loads_them_with_its_own_torque() {
    for law in ControlLaw::ALL.into_iter().filter(|law| *law != ControlLaw::Teach) {
        let torque = |friction, friction_terms, reference: Reference<f64, 1>, qd| {
            let settings = dynamics_core::ControllerConfig { friction, ..config::<1>(law) };
            // A model that is not evaluated in every tick passes its friction terms on.
            let rail = EveryNth::new(Rail(UnitMasses::default(), friction_terms), 2, Between::Hold, &settings.gains);
            driven(Controller::new(settings, rail, Desk).tick(&reference, &measured([0.1], [qd]))).0[0]
        };
        let moving = Reference { q: [0.1], qd: [0.02], qdd: [0.2] };
        let plain = torque(None, None, moving, -0.3);
        let added = torque(Some([FRICTION]), Some([TERMS]), moving, -0.3) - plain;
        assert!((added - FRICTION.torque_with(&TERMS, 0.02, plain)).abs() < 1e-12, "{law:?} adds {added}");
        // While the reference rests, friction feedforward does not support a motion of an arm that is pushed.
        let still = Reference { q: [0.1], qd: [0.0], qdd: [0.0] };
        let terms = FrictionTerms { offset: None, ..TERMS };
        for qd in [-0.02, 0.0, 0.02] {
            let (with, without) = (torque(Some([FRICTION]), Some([terms]), still, qd), torque(None, None, still, qd));
            assert_eq!(with, without, "{law:?} at {qd}");
        }
    }
}

/// A mass whose stiction is half of what the controller assumes: the reference starts it, and it comes to rest with the reference.
#[test]
fn overestimated_stiction_does_not_drive_an_arm_whose_reference_rests() {
    let terms = FrictionTerms { rise: TERMS.rise, ..FrictionTerms::NONE };
    let settings =
        dynamics_core::ControllerConfig { friction: Some([FRICTION]), ..config::<1>(ControlLaw::ComputedTorque) };
    let mut controller = Controller::new(settings, Rail(UnitMasses::default(), Some([terms])), Desk);
    let (mut q, mut qd, h) = (0.0_f64, 0.0_f64, 1e-3);
    let mut fastest_at_rest = 0.0_f64;
    for tick in 0..4000 {
        let t = f64::from(tick) * h;
        // Half a second of motion, then rest.
        let (reference, speed, acceleration) = if t < 0.5 {
            let w = core::f64::consts::TAU / 0.5;
            (0.02 * (t - (w * t).sin() / w), 0.02 * (1.0 - (w * t).cos()), 0.02 * w * (w * t).sin())
        } else {
            (0.01, 0.0, 0.0)
        };
        let reference = Reference { q: [reference], qd: [speed], qdd: [acceleration] };
        let torque = driven(controller.tick(&reference, &measured([q], [qd]))).0[0];
        // Dry friction of 0.35 N m, and 1.4 N m at breakaway, by an implicit step.
        let level = h * (0.35 + 1.05 * (-(qd / 0.05).powi(2)).exp());
        let free = qd + h * torque;
        qd = if free.abs() <= level { 0.0 } else { free - level.copysign(free) };
        q += h * qd;
        if t > 1.5 {
            fastest_at_rest = fastest_at_rest.max(qd.abs());
        }
    }
    assert_eq!(fastest_at_rest, 0.0);
    // Stiction keeps the error that the spring of 20^2 N m/rad cannot overcome.
    assert!((q - 0.01).abs() <= 1.4 / 400.0, "{q}");
}
