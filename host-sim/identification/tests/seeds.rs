//! Stated standard deviations against true errors, over 200 seeds.

use crate::arms::load;
use crate::made::{Making, Random, log};
use identification::base::Base;
use identification::identify::{Settings, identify};

/// For each base parameter, the number of seeds in which it is within three stated deviations; and the root mean square of error over deviation.
fn coverage(seeds: std::ops::Range<u64>) -> (Vec<usize>, f64) {
    let known = load("yam.toml");
    let base = Base::of(known.arm.as_ref());
    // Delays have tests of their own, and take most of the time.
    let settings = Settings { plain_friction: true, motion_cutoff: Some(8.0), keep_delay: true, ..Settings::default() };
    let mut inside = vec![0; base.len()];
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in seeds {
        // Every body's mass differs from the maker's by up to 20 %.
        let mut random = Random::new(seed);
        let factors: Vec<f64> = (0..6).map(|_| 0.8 + 0.4 * random.share()).collect();
        let truth: Vec<f64> =
            known.parameters.iter().enumerate().map(|(k, x)| x * factors.get(k / 10).copied().unwrap_or(1.0)).collect();
        let logs = [log(&known, &truth, &Making { seed, rate: 42.0, ..Making::default() })];
        let found = identify(known.arm.as_ref(), &known.maker(), &logs, &settings);
        let wanted = base.of_parameters(&truth);
        for k in 0..base.len() {
            let error = (found.free[k] - wanted[k]) / found.covariance[(k, k)].sqrt();
            inside[k] += usize::from(error.abs() < 3.0);
            squares += error * error;
            count += 1.0;
        }
    }
    (inside, (squares / count).sqrt())
}

/// In 95 % of 200 seeds every identifiable base parameter is within three of its stated deviations. Four threads run a quarter each.
#[test]
fn base_parameters_are_within_three_stated_deviations_in_95_percent_of_200_seeds() {
    let parts: Vec<(Vec<usize>, f64)> = std::thread::scope(|scope| {
        let parts: Vec<_> = (0..4).map(|part| scope.spawn(move || coverage(50 * part..50 * part + 50))).collect();
        parts.into_iter().map(|part| part.join().unwrap()).collect()
    });
    let inside: Vec<usize> = (0..parts[0].0.len()).map(|k| parts.iter().map(|part| part.0[k]).sum()).collect();
    assert!(inside.iter().all(|inside| *inside >= 190), "{inside:?}");
    // The deviations must not be far too large either.
    let spread = parts.iter().map(|part| part.1).sum::<f64>() / 4.0;
    assert!((0.75..1.15).contains(&spread), "{spread}");
}
