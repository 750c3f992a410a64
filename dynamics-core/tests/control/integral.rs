//! Integral action removes the error that the position gain leaves, without hunting because of stiction and without wind-up.

use crate::control::support::{Desk, UnitMasses, config, driven, measured};
use dynamics_core::control::ControllerOf;
use dynamics_core::control::{ControlLaw, Gains, Integral, Integrated, LimitFlags};
use dynamics_core::{Controller, ControllerConfig, Limits, Reference};

type One = ControllerOf<f64, 1, UnitMasses, Desk>;

const PERIOD: f64 = 1e-3;
const FREQUENCY: f64 = 20.0;
const KP: f64 = FREQUENCY * FREQUENCY;
const KD: f64 = 2.0 * FREQUENCY;

fn joint(integral: Option<Integral<f64>>, torque_max: f64) -> One {
    let limits = Limits { torque: torque_max, ..Limits::none() };
    let gains = [Gains::new(FREQUENCY, 1.0, 1.0)];
    let integral = integral.map(|integral| [integral]);
    Controller::new(
        ControllerConfig { gains, limits: [limits], integral, ..config(ControlLaw::ComputedTorque) },
        UnitMasses::default(),
        Desk,
    )
}

/// Integral action with the time `T`, s, and a bound, N m.
fn integral(time: f64, torque_max: f64) -> Integral<f64> {
    Integral { gain: KP * PERIOD / time, torque_max, dead_band: 0.0, friction: 0.0 }
}

/// A unit mass under a load (N m), with Coulomb friction that also holds it at rest.
struct Mass {
    q: f64,
    qd: f64,
    load: f64,
    friction: f64,
}

impl Mass {
    const FREE: Self = Self { q: 0.0, qd: 0.0, load: 0.0, friction: 0.0 };

    /// Runs ticks with the reference at rest at 0, and returns the last torque.
    fn hold(&mut self, controller: &mut One, ticks: u32) -> f64 {
        let rest = Reference { q: [0.0], qd: [0.0], qdd: [0.0] };
        let mut last = 0.0;
        for _ in 0..ticks {
            let ([torque], _) = driven(controller.tick(&rest, &measured([self.q], [self.qd])));
            last = torque;
            let pushed = torque + self.load;
            if self.qd == 0.0 && pushed.abs() <= self.friction {
                continue;
            }
            let direction = if self.qd == 0.0 { pushed.signum() } else { self.qd.signum() };
            let qd = self.qd + PERIOD * (pushed - self.friction * direction);
            // Friction stops a mass, but does not reverse it.
            self.qd = if qd * direction < 0.0 && self.friction > 0.0 { 0.0 } else { qd };
            self.q += PERIOD * self.qd;
        }
        last
    }
}

#[test]
fn a_constant_load_leaves_no_rest_error_and_without_integral_action_its_share_of_the_stiffness() {
    for load in [-7.0, 0.5, 3.0] {
        let mut mass = Mass { load, ..Mass::FREE };
        mass.hold(&mut joint(None, f64::INFINITY), 5_000);
        assert!((mass.q - load / KP).abs() < 1e-9, "{}", mass.q);
        let mut mass = Mass { load, ..Mass::FREE };
        let torque = mass.hold(&mut joint(Some(integral(0.2, 10.0)), f64::INFINITY), 10_000);
        assert!(mass.q.abs() < 1e-9, "{}", mass.q);
        assert!((torque + load).abs() < 1e-6, "{torque}");
    }
}

#[test]
fn the_shortest_stable_time_is_that_of_routh() {
    // Growth of the oscillation from the first to the fourth second; the tick's finite step shifts the stability bound a little.
    let growth = |time: f64| {
        let mut controller = joint(Some(integral(time, f64::INFINITY)), f64::INFINITY);
        let mut mass = Mass { q: 1e-3, ..Mass::FREE };
        let mut largest = [0.0_f64; 4];
        for second in &mut largest {
            for _ in 0..1_000 {
                mass.hold(&mut controller, 1);
                *second = second.max(mass.q.abs());
            }
        }
        largest[3] / largest[0]
    };
    assert!(growth(1.2 / KD) < 0.5, "{}", growth(1.2 / KD));
    assert!(growth(0.8 / KD) > 2.0, "{}", growth(0.8 / KD));
}

#[test]
fn the_torque_of_the_integral_action_never_passes_its_bound() {
    let mut mass = Mass { load: 50.0, ..Mass::FREE };
    let torque = mass.hold(&mut joint(Some(integral(0.2, 5.0)), f64::INFINITY), 20_000);
    assert!((mass.q - 45.0 / KP).abs() < 1e-6, "{}", mass.q);
    assert!((torque + 50.0).abs() < 1e-6, "{torque}");
}

#[test]
fn a_joint_that_its_torque_limit_held_away_winds_nothing_up() {
    // Two seconds at the torque limit, under a load greater than the motor can hold; then the load is removed.
    let overshoot = |torque_limit: f64| {
        let mut controller = joint(Some(integral(0.2, 200.0)), torque_limit);
        let mut mass = Mass { load: 12.0, q: 0.05, ..Mass::FREE };
        mass.hold(&mut controller, 200);
        let pushed = mass.q;
        mass.load = 0.0;
        let mut lowest = pushed;
        for _ in 0..4_000 {
            mass.hold(&mut controller, 1);
            lowest = lowest.min(mass.q);
        }
        assert!(mass.q.abs() < 1e-6, "{}", mass.q);
        -lowest / pushed
    };
    assert!(overshoot(10.0) < 0.5);
    // The rule itself: an integral torque at a limit does not grow, but may shrink.
    let integral = integral(0.2, 100.0);
    let grown = integral.next(Integrated { torque: 3.0, away: true }, 1.0);
    let shrunk = integral.next(Integrated { torque: 3.0, away: true }, -1.0);
    assert!(grown.torque > 3.0 && shrunk.torque < 3.0);
}

#[test]
fn a_limit_that_acts_freezes_the_integral_action_and_its_release_thaws_it() {
    let mut controller = joint(Some(integral(0.2, 100.0)), 1.0);
    let away = Reference { q: [1.0], qd: [0.0], qdd: [0.0] };
    for _ in 0..1_000 {
        let (_, [flags]) = driven(controller.tick(&away, &measured([0.0], [0.0])));
        assert_eq!(flags, LimitFlags::TORQUE);
    }
    // Without wind-up the torque at the reference is zero at once.
    let ([torque], [flags]) = driven(controller.tick(&away, &measured([1.0], [0.0])));
    assert_eq!((torque, flags), (0.0, LimitFlags::NONE));
}

#[test]
fn a_joint_with_stiction_arrives_once_and_stays() {
    let stiction = Mass { q: 2e-3, friction: 2.0, ..Mass::FREE };
    let with = |friction: f64| Integral { dead_band: 1e-4, friction, ..integral(0.2, 10.0) };
    // Without integral action the mass stays where stiffness and friction balance.
    let mut mass = Mass { ..stiction };
    mass.hold(&mut joint(None, f64::INFINITY), 5_000);
    assert!(mass.q > 1e-3, "{}", mass.q);
    for load in [0.0, 1.0, -1.5] {
        let mut controller = joint(Some(with(2.0)), f64::INFINITY);
        let mut mass = Mass { load, ..stiction };
        mass.hold(&mut controller, 10_000);
        let parked = mass.q;
        assert!(parked.abs() <= 2e-4, "{parked} under {load}");
        mass.hold(&mut controller, 20_000);
        assert_eq!((mass.q, mass.qd), (parked, 0.0), "it hunts under {load}");
    }
}

#[test]
fn a_reset_forgets_the_integral_action() {
    let mut controller = joint(Some(integral(0.2, 100.0)), f64::INFINITY);
    let mut mass = Mass { load: 3.0, ..Mass::FREE };
    mass.hold(&mut controller, 5_000);
    controller.reset();
    let rest = Reference { q: [0.0], qd: [0.0], qdd: [0.0] };
    assert_eq!(driven(controller.tick(&rest, &measured([0.0], [0.0]))).0, [0.0]);
}
