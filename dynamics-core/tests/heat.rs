//! Heat of motors, compared with the closed form of its equation, and the edges of its levels.

use dynamics_core::safety::heat::{FAULT, HeatLevel, HeatRules, WARNING};

/// Rated torque of a motor, N m, and its time constant, s.
const MOTOR: (f64, f64) = (11.0, 60.0);

fn rules(update: f64) -> HeatRules<f64> {
    HeatRules::new(MOTOR.0, MOTOR.1, update)
}

#[test]
fn a_step_of_torque_heats_and_cools_by_the_closed_form() {
    for update in [1e-3, 0.064, 0.4, 5.0] {
        let rules = rules(update);
        let mut heat = 0.0;
        let mut time = 0.0;
        let mut start = (0.0, 0.0);
        for (torque, until) in [(15.4, 70.0), (0.0, 130.0), (-11.0, 400.0)] {
            let goal = (torque / MOTOR.0).powi(2);
            while time < until {
                heat = rules.step(heat, torque);
                time += update;
                let (since, from): (f64, f64) = start;
                let exact = goal + (from - goal) * (-(time - since) / MOTOR.1).exp();
                assert!((heat - exact).abs() < 1e-9, "{heat} of {exact} at {time} s, an update every {update} s");
            }
            start = (time, heat);
        }
    }
}

#[test]
fn single_precision_keeps_to_the_closed_form_where_updates_are_decimated() {
    // 64 ticks of 1 ms for each of 6 joints.
    let update = 0.384;
    let single = rules(update).cast::<f32>();
    let (mut heat, mut exact) = (0.0_f32, 0.0);
    for _ in 0..2000 {
        heat = single.step(heat, 10.9);
        exact = rules(update).step(exact, 10.9);
    }
    assert!((f64::from(heat) - exact).abs() < 1e-5, "{heat} of {exact}");
    // With an update in every tick the increments would vanish by rounding before the final heat is reached.
    let each = rules(1e-3).cast::<f32>();
    let mut stuck = 0.0_f32;
    for _ in 0..1_000_000 {
        stuck = each.step(stuck, 10.9);
    }
    assert!((f64::from(stuck) - exact).abs() > 1e-4, "{stuck}: updates in every tick would do as well");
}

#[test]
fn the_rated_torque_is_the_edge_of_the_continuous_limit() {
    let settled = |torque: f64| (0..10_000).fold(0.0, |heat, _| rules(0.384).step(heat, torque));
    assert!((settled(MOTOR.0) - 1.0).abs() < 1e-12);
    assert!(settled(MOTOR.0 * 0.999) < 1.0 && settled(MOTOR.0 * 1.001) > 1.0);
    assert_eq!(HeatLevel::of(settled(MOTOR.0)), HeatLevel::Warm);
    assert_eq!(HeatLevel::of(settled(-MOTOR.0 * 1.03)), HeatLevel::Overheated);
}

#[test]
fn the_levels_change_at_their_edges() {
    let below = |x: f64| f64::from_bits(x.to_bits() - 1);
    let above = |x: f64| f64::from_bits(x.to_bits() + 1);
    let levels = [0.0, below(WARNING), WARNING, 1.0, FAULT, above(FAULT), f64::INFINITY, f64::NAN].map(HeatLevel::of);
    use HeatLevel::{Cool, Overheated, Warm};
    assert_eq!(levels, [Cool, Cool, Warm, Warm, Warm, Overheated, Overheated, Overheated]);
}
