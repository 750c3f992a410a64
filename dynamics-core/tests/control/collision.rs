//! External torques from the momentum, and the effect of a collision on the controller.

use crate::common::pinned;
use crate::control::support::{Desk, UnitMasses, braked, by_hand, config, driven, measured, planar};
use dynamics_core::control::{
    CollisionConfig, CollisionReaction, CollisionWatch, ControlLaw, ControllerOf, Integral, LimitFlags, MomentumFilter,
    MomentumObserver, ObservedState, Protection, Unprotected, Verdict,
};
use dynamics_core::momentum::{GeneralizedMomentum, Momentum};
use dynamics_core::{Controller, ControllerConfig, Fault, InverseDynamics, Live, Reference, SinCos, Trig};

const PERIOD: f64 = 1e-3;

/// Unit masses on rails, without gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rails;

impl<const N: usize> GeneralizedMomentum<f64, N> for Rails {
    fn momentum(&self, _: &[SinCos<f64>; N], _: &[f64; N], qd: &[f64; N], _: &Live<f64, N>) -> Momentum<f64, N> {
        Momentum { momentum: *qd, rate: [0.0; N] }
    }
}

/// The bandwidth is so high that the residual is the external force of the last period.
fn settings(reaction: CollisionReaction) -> CollisionConfig<f64, 2> {
    CollisionConfig {
        filter: MomentumFilter::new(1e5, PERIOD),
        threshold: [8.0, 4.0],
        released: [4.0, 2.0],
        ticks: 3,
        release_ticks: 5,
        reaction,
    }
}

type Watched =
    ControllerOf<f64, 2, UnitMasses, Desk, dynamics_core::ControllerConfig<f64, 2>, CollisionWatch<f64, 2, Rails>>;

fn watched(reaction: CollisionReaction) -> Watched {
    Controller::new(config::<2>(ControlLaw::ComputedTorque), UnitMasses::default(), Desk)
        .with_protection(CollisionWatch::new(settings(reaction), Rails))
}

/// Masses that move under the commanded and an external force, with their controller.
struct Loop {
    controller: Watched,
    q: [f64; 2],
    qd: [f64; 2],
}

const REFERENCE: Reference<f64, 2> = Reference { q: [0.2, -0.1], qd: [0.0, 0.0], qdd: [0.0, 0.0] };

impl Loop {
    fn new(reaction: CollisionReaction) -> Self {
        Self { controller: watched(reaction), q: [0.0; 2], qd: [0.0; 2] }
    }

    /// A tick, followed by a period under the force `external`.
    fn tick(&mut self, external: [f64; 2]) -> (Option<Fault>, [LimitFlags; 2], [f64; 2]) {
        let command = self.controller.tick(&REFERENCE, &measured(self.q, self.qd));
        if let Some(fault) = braked(&command) {
            return (Some(fault), [LimitFlags::NONE; 2], [0.0; 2]);
        }
        let (torque, limits) = driven(command);
        for i in 0..2 {
            let force = torque[i] + external[i];
            self.q[i] += PERIOD * (self.qd[i] + 0.5 * PERIOD * force);
            self.qd[i] += PERIOD * force;
        }
        (None, limits, torque)
    }

    fn run(&mut self, external: [f64; 2], ticks: u32) {
        for _ in 0..ticks {
            self.tick(external);
        }
    }

    fn residual(&self) -> [f64; 2] {
        *self.controller.protection().residual()
    }
}

const HIT: [f64; 2] = [0.0, -4.1];
const FREE: [f64; 2] = [0.0, 0.0];
const COLLIDED: [LimitFlags; 2] = [LimitFlags::NONE, LimitFlags::COLLISION];

#[test]
fn the_residual_is_the_external_force_whatever_the_controller_does() {
    let mut arm = Loop::new(CollisionReaction::Stop);
    for external in [[0.0, 0.0], [5.0, -3.0], [-7.0, 3.5], [0.0, 0.0]] {
        arm.run(external, 4);
        for i in 0..2 {
            assert!((arm.residual()[i] - external[i]).abs() < 1e-9, "{:?} {external:?}", arm.residual());
        }
    }
}

#[test]
fn a_stop_comes_after_so_many_ticks_above_the_threshold_and_latches() {
    let mut arm = Loop::new(CollisionReaction::Stop);
    // Just below the threshold on both joints, for a long time; then above it, but never three times in a row.
    arm.run([-7.9, 3.9], 100);
    for _ in 0..20 {
        arm.run(HIT, 2);
        arm.run(FREE, 1);
    }
    arm.run(HIT, 3);
    // The force of three periods is known in the tick after them.
    assert_eq!(arm.tick(FREE).0, Some(Fault::Collision { joint: 1 }));
    for _ in 0..10 {
        assert_eq!(arm.tick(FREE).0, Some(Fault::Collision { joint: 1 }));
    }
    let mut other = Loop::new(CollisionReaction::Stop);
    other.run([8.1, 0.0], 3);
    assert_eq!(other.tick(FREE).0, Some(Fault::Collision { joint: 0 }));
}

#[test]
fn a_watch_that_reports_tells_the_force_and_does_nothing_even_while_a_hand_leads_the_arm() {
    let (mut arm, mut other) = (Loop::new(CollisionReaction::Report), Loop::new(CollisionReaction::Stop));
    for external in [[5.0, -3.0], [0.0, 0.0], [-7.0, 3.5]] {
        for _ in 0..4 {
            assert_eq!(arm.tick(external), other.tick(external));
        }
    }
    arm.run([200.0, -300.0], 50);
    let (fault, limits, _) = arm.tick(FREE);
    assert_eq!((fault, limits.map(|flags| flags.contains(LimitFlags::COLLISION))), (None, [false; 2]));
    let told = *arm.controller.protection().external().unwrap();
    assert!((told[0] - 200.0).abs() < 1e-9 && (told[1] + 300.0).abs() < 1e-9, "{told:?}");

    // A watch that may act is cleared while the arm is hand-guided.
    for (reaction, tells) in [(CollisionReaction::Report, true), (CollisionReaction::Stop, false)] {
        let mut led = Loop::new(reaction);
        led.controller.config_mut().unwrap().law = ControlLaw::Teach;
        led.run([3.0, 0.0], 5);
        let told = led.controller.protection().external().unwrap()[0];
        assert_eq!((told - 3.0).abs() < 1e-9, tells, "{reaction:?}: {told}");
    }
}

#[test]
fn a_hold_stands_where_the_arm_was_until_the_reset() {
    let mut arm = Loop::new(CollisionReaction::Hold);
    arm.run(FREE, 40);
    arm.run(HIT, 3);
    let at = arm.q;
    assert!((at[0] - REFERENCE.q[0]).abs() > 0.05, "the arm is on its way: {at:?}");
    assert_eq!(arm.tick(HIT).1, COLLIDED);
    arm.run(FREE, 2000);
    for i in 0..2 {
        assert!((arm.q[i] - at[i]).abs() < 1e-6, "{:?} {at:?}", arm.q);
    }
    assert_eq!(arm.tick(FREE).1, COLLIDED);
    arm.controller.reset();
    arm.run(FREE, 2000);
    assert_eq!(arm.tick(FREE).1, [LimitFlags::NONE; 2]);
    for i in 0..2 {
        assert!((arm.q[i] - REFERENCE.q[i]).abs() < 1e-6, "{:?}", arm.q);
    }
}

#[test]
fn what_complies_gives_way_while_pushed_then_stands_and_gives_way_again() {
    let mut arm = Loop::new(CollisionReaction::Comply);
    arm.run(HIT, 3);
    let gains = config::<2>(ControlLaw::ComputedTorque).gains;
    for round in 0..3 {
        // Without stiffness, the force is balanced by the damper alone.
        let (qd, before) = (arm.qd, arm.q);
        let (fault, limits, torque) = arm.tick(HIT);
        assert_eq!((fault, limits), (None, COLLIDED));
        for i in 0..2 {
            assert_eq!(torque[i], 0.0 - gains[i].inertia * (gains[i].velocity * qd[i]));
        }
        arm.run(HIT, 3000);
        // Pushed away at the speed at which the damper balances the force.
        let speed = HIT[1] / (gains[1].inertia * gains[1].velocity);
        assert!((arm.qd[1] - speed).abs() < 1e-6 && arm.q[1] < before[1] - 0.2, "{:?}", arm.qd);
        // Half the threshold does not yet count as the end of the push.
        arm.run([0.0, -2.1], 50);
        let (_, _, torque) = arm.tick(FREE);
        assert!(torque[1].abs() < 4.0, "{torque:?}");
        arm.run(FREE, 4);
        let at = arm.q;
        arm.tick(FREE);
        arm.run(FREE, 2000);
        for i in 0..2 {
            assert!((arm.q[i] - at[i]).abs() < 1e-6, "round {round}: {:?} {at:?}", arm.q);
        }
        arm.run(HIT, 3);
    }
}

#[test]
fn what_complies_is_pushed_by_no_integral_action() {
    let integral = Integral { gain: 1.0, torque_max: 3.0, dead_band: 0.0, friction: 0.0 };
    let config = ControllerConfig { integral: Some([integral; 2]), ..config::<2>(ControlLaw::ComputedTorque) };
    let gains = config.gains[1];
    let watch = CollisionWatch::new(settings(CollisionReaction::Comply), Rails);
    let controller = Controller::new(config, UnitMasses::default(), Desk).with_protection(watch);
    let mut arm = Loop { controller, ..Loop::new(CollisionReaction::Comply) };
    // The arm pushes against a force below its threshold until the integral action is at its bound.
    arm.run([0.0, -3.9], 3000);
    assert!((arm.tick([0.0, -3.9]).2[1] - 3.9).abs() < 1e-6);
    arm.run(HIT, 3);
    let qd = arm.qd[1];
    let (_, limits, torque) = arm.tick(HIT);
    assert_eq!(limits, COLLIDED);
    assert_eq!(torque[1], 0.0 - gains.inertia * (gains.velocity * qd));
}

#[test]
fn a_residual_that_is_no_number_is_a_collision() {
    let mut watch = CollisionWatch::new(CollisionConfig { ticks: 1, ..settings(CollisionReaction::Stop) }, Rails);
    let look = |watch: &mut CollisionWatch<f64, 2, Rails>, qd: [f64; 2]| {
        let seen = ObservedState { q: &[0.0; 2], qd: &qd, live: &Live::zero(), friction: None, friction_terms: None };
        watch.look(&seen, || Desk.sin_cos_all(&[0.0; 2])).0
    };
    assert_eq!(look(&mut watch, [0.0; 2]), Verdict::Free);
    assert_eq!(look(&mut watch, [0.0, f64::NAN]), Verdict::Stop { joint: 1 });
    watch.forget();
    assert_eq!(look(&mut watch, [0.0; 2]), Verdict::Free);
    assert_eq!(*watch.residual(), [0.0; 2]);
}

#[test]
fn no_watch_and_one_that_sees_nothing_leave_every_bit() {
    let mut bare = Controller::new(config::<2>(ControlLaw::ComputedTorque), planar(), Desk);
    let wide = CollisionConfig { threshold: [f64::MAX; 2], ..settings(CollisionReaction::Stop) };
    let mut unprotected = bare.clone().with_protection(Unprotected);
    let mut watched = bare.clone().with_protection(CollisionWatch::new(wide, planar()));
    let mut perhaps = bare.clone().with_protection(Some(CollisionWatch::new(wide, planar())));
    for k in 0..200 {
        let t = f64::from(k) * PERIOD;
        let reference = Reference { q: [t.sin(), t], qd: [t.cos(), 1.0], qdd: [-t.sin(), 0.0] };
        let measurement = measured([1.01 * t.sin(), 0.9 * t], [t.cos() + 0.1, 1.1]);
        let expected = bare.tick(&reference, &measurement);
        assert_eq!(unprotected.tick(&reference, &measurement), expected);
        assert_eq!(watched.tick(&reference, &measurement), expected);
        assert_eq!(perhaps.tick(&reference, &measurement), expected);
    }
    assert!(watched.protection().residual()[0] != 0.0);
}

/// Position, velocity and acceleration of two swinging joints at `t`.
fn swinging(t: f64) -> [[f64; 2]; 3] {
    let (w, a) = ([2.1, 3.3], [0.9, 0.7]);
    [
        core::array::from_fn(|i| a[i] * (w[i] * t).sin()),
        core::array::from_fn(|i| a[i] * w[i] * (w[i] * t).cos()),
        core::array::from_fn(|i| -a[i] * w[i] * w[i] * (w[i] * t).sin()),
    ]
}

/// Runs the observer over a motion with all torques known, with `external` acting all the time: calls `f(tick, residual)` for each
/// tick.
fn over_a_motion<S: dynamics_core::Real>(bandwidth: f64, ticks: u32, external: f64, mut f: impl FnMut(u32, [f64; 2])) {
    let filter: MomentumFilter<S> = MomentumFilter::new(bandwidth, PERIOD);
    let dynamics = planar();
    let single = dynamics_core::Dynamics::<S, 2>::new(dynamics.model().cast(), dynamics.scene().cast());
    let mut observer = MomentumObserver::<S, 2>::default();
    for tick in 0..ticks {
        let [q, qd, _] = swinging(f64::from(tick) * PERIOD);
        let turn = q.map(|q| SinCos { sin: S::literal(q.sin()), cos: S::literal(q.cos()) });
        let momentum = single.momentum(&turn, &q.map(S::literal), &qd.map(S::literal), &Live::zero());
        let found = observer.observe(&filter, &momentum, &[S::zero(); 2]).map(S::to_f64);
        f(tick, found);
        // The torque at the middle of the period approximates its mean.
        let [q, qd, qdd] = swinging((f64::from(tick) + 0.5) * PERIOD);
        observer.drove(&filter, &by_hand(q, qd, qdd).map(|tau| S::literal(tau - external)));
    }
}

#[test]
fn the_residual_follows_an_external_torque_as_a_first_order_lag() {
    let (bandwidth, external) = (50.0, 3.0);
    let mut worst = 0.0_f64;
    over_a_motion::<f64>(bandwidth, 2000, external, |tick, found| {
        let wanted = external * (1.0 - (-bandwidth * f64::from(tick) * PERIOD).exp());
        for r in found {
            worst = worst.max((r - wanted).abs());
        }
    });
    pinned("lag of the residual, N m", worst, 1.64e-5);
}

#[test]
fn single_precision_does_not_drift_in_a_million_ticks() {
    let mut double = Vec::new();
    const TICKS: u32 = 1_000_000;
    over_a_motion::<f64>(50.0, TICKS, 0.0, |_, found| double.push(found));
    let mut worst = [0.0_f64; 2];
    over_a_motion::<f32>(50.0, TICKS, 0.0, |tick, found| {
        let half = usize::from(tick >= TICKS / 2);
        for i in 0..2 {
            worst[half] = worst[half].max((found[i] - double[tick as usize][i]).abs());
        }
    });
    // Torques of tens of N m: the error is that of rounding p, and it is no greater in the second half than in the first.
    pinned("single precision, the first half, N m", worst[0], 1.81e-4);
    pinned("single precision, the second half, N m", worst[1], 1.59e-4);
}

#[test]
fn the_arm_by_hand_is_the_one_that_the_recursion_has() {
    let ([q, qd, qdd], arm) = (swinging(0.3), planar());
    let found = arm.inverse_dynamics(&Desk.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero());
    let wanted = by_hand(q, qd, qdd);
    assert!((0..2).all(|i| (found[i] - wanted[i]).abs() < 1e-12), "{found:?} {wanted:?}");
}
