use super::parabola;

#[test]
fn a_parabola_gives_place_speed_and_acceleration_and_does_not_mind_noise_that_it_cannot_follow() {
    let points = |noise: f64| {
        (-20..=20).map(move |i| {
            let t = f64::from(i) * 1e-3;
            let alternates = if i % 2 == 0 { noise } else { -noise };
            (t, 0.3 - 0.7 * t + 0.5 * 4.0 * t * t + alternates)
        })
    };
    let [q, qd, qdd] = parabola(points(0.0));
    assert!((q - 0.3).abs() < 1e-12 && (qd + 0.7).abs() < 1e-10 && (qdd - 4.0).abs() < 1e-6, "{q} {qd} {qdd}");
    let [_, _, noisy] = parabola(points(4e-4));
    assert!((noisy - 4.0).abs() > 1e-3 && (noisy - 4.0).abs() < 1.5, "{noisy}");
}
