use super::sinking;

/// Torque that holds a pendulum with a gravity torque of at most 10 N m, at its angle from hanging down.
fn rod(q: &[f64]) -> Vec<f64> {
    vec![10.0 * q[0].sin()]
}

#[test]
fn a_rod_sinks_until_friction_holds_it_or_to_its_limit() {
    // Friction of 1 N m holds it at asin(0.1).
    let [one] = sinking(&[1.5], &[(-3.0, 3.0)], &[1.0], rod).try_into().unwrap();
    assert!((one.distance - (1.5 - 0.1_f64.asin())).abs() < 0.006 && !one.to_limit, "{one:?}");
    let [one] = sinking(&[1.5], &[(0.5, 3.0)], &[1.0], rod).try_into().unwrap();
    assert!((one.distance - 1.0).abs() < 1e-9 && one.to_limit, "{one:?}");
    // Held by friction, or hanging.
    assert_eq!(sinking(&[0.05], &[(-3.0, 3.0)], &[1.0], rod), []);
    assert_eq!(sinking(&[0.0], &[(-3.0, 3.0)], &[0.0], rod), []);
}
