//! Synthetic logs of a known motion, with noise.

use crate::arms::Known;
use identification::Series;
use identification::friction::Direction;
use identification::log::Log;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Runs `work` for each index on several threads and returns the results.
pub(crate) fn parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(2, std::num::NonZero::get);
    let next = std::sync::atomic::AtomicUsize::new(0);
    let run = || {
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if k >= count {
                return done;
            }
            done.push((k, work(k)));
        }
    };
    let mut all: Vec<(usize, T)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(run)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    all.sort_by_key(|(k, _)| *k);
    all.into_iter().map(|(_, result)| result).collect()
}

/// Settings of a synthetic log.
#[derive(Clone, Copy)]
pub(crate) struct Making {
    /// Duration, s.
    pub(crate) duration: f64,
    /// Sampling rate, Hz.
    pub(crate) rate: f64,
    /// Viscous (N m s/rad) and Coulomb (N m) friction of every joint.
    pub(crate) friction: (f64, f64),
    /// Standard deviation of the torque noise, as a share of the torque's root mean square.
    pub(crate) noise: f64,
    /// Standard deviation of the position noise, rad.
    pub(crate) encoder: f64,
    pub(crate) seed: u64,
    /// Seed of the motion.
    pub(crate) motion: u64,
    /// Number of point-to-point moves, with a rest after each, that replace the harmonics.
    pub(crate) moves: Option<usize>,
}

impl Default for Making {
    fn default() -> Self {
        Self {
            duration: 12.0,
            rate: 100.0,
            friction: (0.1, 0.2),
            noise: 0.02,
            encoder: 1e-5,
            seed: 1,
            motion: 7,
            moves: None,
        }
    }
}

pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A uniform number between 0 and 1.
    pub(crate) fn share(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0)
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.share().ln()).sqrt() * (std::f64::consts::TAU * self.share()).cos()
    }
}

/// Position, velocity and acceleration of a move from rest to rest.
fn quintic(from: f64, to: f64, length: f64, t: f64) -> [f64; 3] {
    let s = (t / length).clamp(0.0, 1.0);
    let way = to - from;
    [
        from + way * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s),
        way * 30.0 * s * s * (1.0 - s).powi(2) / length,
        way * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (length * length),
    ]
}

/// A log of the arm with these true parameters.
pub(crate) fn log(known: &Known, parameters: &[f64], making: &Making) -> Log {
    let n = known.joints();
    let mut random = Random::new(making.motion);
    // Five harmonics of 0.1 Hz.
    let draws: Vec<[(f64, f64); 5]> = (0..n)
        .map(|_| {
            core::array::from_fn(|k| (0.7 * (random.share() - 0.5) / (0.5 + 0.5 * k as f64), 6.3 * random.share()))
        })
        .collect();
    let points: Vec<Vec<f64>> =
        (0..=making.moves.unwrap_or(0)).map(|_| (0..n).map(|_| 0.3 + 1.6 * (random.share() - 0.5)).collect()).collect();
    let count = (making.duration * making.rate) as usize;
    let time: Vec<f64> = (0..count).map(|k| k as f64 / making.rate).collect();
    let state = |joint: usize, t: f64| {
        if let Some(moves) = making.moves {
            let each = making.duration / moves as f64;
            let at = ((t / each) as usize).min(moves - 1);
            return quintic(points[at][joint], points[at + 1][joint], 0.7 * each, t - at as f64 * each - 0.15 * each);
        }
        let mut x = [0.3, 0.0, 0.0];
        for (k, (a, phase)) in draws[joint].iter().enumerate() {
            let rate = 0.2 * std::f64::consts::PI * (k + 1) as f64;
            let (sin, cos) = (rate * t + phase).sin_cos();
            x[0] += a * sin;
            x[1] += a * rate * cos;
            x[2] -= a * rate * rate * sin;
        }
        x
    };
    let mut series: [Series; 3] = core::array::from_fn(|_| vec![Vec::new(); n]);
    for (joint, t) in (0..n).flat_map(|joint| time.iter().map(move |t| (joint, *t))) {
        for (list, x) in series.iter_mut().zip(state(joint, t)) {
            list[joint].push(x);
        }
    }
    let [mut q, qd, qdd] = series;
    let mut tau: Series = vec![vec![0.0; count]; n];
    let mut out = vec![0.0; 10 * n * n];
    for k in 0..count {
        let at = |list: &Series| -> Vec<f64> { list.iter().map(|x| x[k]).collect() };
        let accelerations = at(&qdd);
        known.arm.columns(&at(&q), &at(&qd), &accelerations, &mut out);
        for joint in 0..n {
            let row = &out[10 * n * joint..10 * n * (joint + 1)];
            tau[joint][k] = row.iter().zip(parameters).map(|(y, pi)| y * pi).sum::<f64>()
                + parameters[10 * n + joint] * accelerations[joint];
        }
    }
    let mut random = Random::new(1000 + making.seed);
    for joint in 0..n {
        let size = (tau[joint].iter().map(|x| x * x).sum::<f64>() / count as f64).sqrt();
        let direction = Direction::Hysteresis(1e-4).along(&q[joint], &qd[joint]);
        for k in 0..count {
            tau[joint][k] += making.friction.0 * qd[joint][k] + making.friction.1 * direction[k];
            tau[joint][k] += making.noise * size * random.normal();
            q[joint][k] += making.encoder * random.normal();
        }
    }
    Log { file: "made".to_owned(), time, q, qd: None, tau, from_current: false }
}

/// The log as rows of CSV fields.
pub(crate) fn text(log: &Log) -> Vec<Vec<String>> {
    let n = log.q.len();
    let names = |what: &str| (1..=n).map(|joint| format!("{what}_{joint}")).collect::<Vec<_>>();
    let mut rows = vec![[vec!["time".to_owned()], names("q"), names("tau")].concat()];
    for k in 0..log.time.len() {
        let values = std::iter::once(log.time[k]).chain(log.q.iter().map(|q| q[k])).chain(log.tau.iter().map(|t| t[k]));
        rows.push(values.map(|x| format!("{x:.7}")).collect());
    }
    rows
}
