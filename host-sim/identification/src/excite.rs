//! Excitation motions for identification.
//!
//! A motion is a finite Fourier series per joint (Swevers et al. 1997). It is periodic, has few frequencies, and is scaled to stay within every
//! limit. The search looks for the most informative series: `max log det (A^T W A)` over base parameters and plain friction together. It starts from
//! random series, then changes one coefficient at a time. The same seed gives the same motion.

use crate::arm::Arm;
use crate::base::Base;
use crate::fit::{condition, inverse};
use crate::random::Random;
use nalgebra::{DMatrix, DVector};

/// Samples per period.
const SAMPLES: usize = 120;
/// Share of the tries that are new random starts. The rest improve the best series.
const STARTS: f64 = 0.25;
/// Friction terms that are identified together with the bodies: offset, viscous, Coulomb.
const FRICTION: usize = 3;

/// Limits of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// Centre of the motion, rad or m.
    pub centre: Vec<f64>,
    /// Lowest and highest position, rad or m.
    pub position: Vec<(f64, f64)>,
    /// Greatest speed, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Greatest acceleration, rad/s^2 or m/s^2.
    pub acceleration: Vec<f64>,
    /// Greatest torque, N m or N.
    pub torque: Vec<f64>,
    /// Expected standard deviation of a filtered torque measurement, N m or N.
    pub noise: Vec<f64>,
}

/// Settings of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Number of harmonics.
    pub harmonics: usize,
    /// Period of the first harmonic, s.
    pub period: f64,
    /// Number of motions that are tried.
    pub tries: usize,
    /// Seed of the search.
    pub seed: u64,
}

/// A Fourier series and the expected information in a log of one period.
#[derive(Clone, Debug, PartialEq)]
pub struct FourierSeries {
    /// Amplitude of the sine for each harmonic and joint, rad or m.
    pub sine: Vec<Vec<f64>>,
    /// Amplitude of the cosine for each harmonic and joint, rad or m.
    pub cosine: Vec<Vec<f64>>,
    /// `log det` of the information matrix, up to a constant.
    pub information: f64,
    /// Condition number of the weighted base-parameter columns, each scaled to equal length.
    pub condition: f64,
    /// Expected standard deviation of each base parameter after one period.
    pub deviations: Vec<f64>,
}

/// The arm, and its expected masses and friction.
pub struct Subject<'a> {
    /// Torque as a linear function of parameters.
    pub arm: &'a dyn Arm,
    /// Its base parameters' definition.
    pub base: &'a Base,
    /// Expected values of the base parameters.
    pub beta: &'a [f64],
    /// Postures and motions that are allowed.
    pub workspace: &'a dyn Workspace,
}

/// Postures and motions that are free of collisions.
pub trait Workspace {
    /// True if a posture is free.
    fn posture(&self, q: &[f64]) -> bool;
    /// True if the straight line in joint space between two postures is free.
    fn line(&self, from: &[f64], to: &[f64]) -> bool;
    /// True if the whole motion of a series is free; takes the amplitudes of each harmonic in each joint. It may be slow: it is called only for a
    /// series that would be the best so far.
    fn series(&self, sine: &[Vec<f64>], cosine: &[Vec<f64>]) -> bool;
}

/// `[q, qd, qdd]` of every sample of a period.
type Motion = Vec<[Vec<f64>; 3]>;

struct Coefficients {
    sine: Vec<Vec<f64>>,
    cosine: Vec<Vec<f64>>,
}

/// Finds the most informative series within the limits. `tick` is called after every try. `None` if no series stays in the workspace.
#[must_use]
pub fn excite(subject: &Subject<'_>, room: &Room, search: &SearchSettings, tick: &dyn Fn()) -> Option<FourierSeries> {
    let mut random = Random::new(search.seed);
    let mut uniform = || random.signed();
    let joints = room.centre.len();
    let mut best: Option<(f64, Coefficients)> = None;
    let starts = ((search.tries as f64 * STARTS) as usize).max(1);
    for attempt in 0..search.tries {
        let mut next = match &best {
            Some((_, best)) if attempt >= starts => {
                let mut next = Coefficients { sine: best.sine.clone(), cosine: best.cosine.clone() };
                let size = 0.5 * (1.0 - attempt as f64 / search.tries as f64) + 0.05;
                let pick = |x: f64, n: usize| (((x + 1.0) / 2.0 * n as f64) as usize).min(n - 1);
                for _ in 0..2 {
                    let (k, joint) = (pick(uniform(), search.harmonics), pick(uniform(), joints));
                    let half = 0.5 * (room.position[joint].1 - room.position[joint].0);
                    let change = uniform() * size * half / (k + 1) as f64;
                    let list = if uniform() > 0.0 { &mut next.sine } else { &mut next.cosine };
                    list[k][joint] += change;
                }
                next
            }
            _ => {
                let mut draw = || -> Vec<Vec<f64>> {
                    (0..search.harmonics)
                        .map(|k| {
                            (0..joints)
                                .map(|j| uniform() * (room.position[j].1 - room.position[j].0) / (k + 1) as f64)
                                .collect()
                        })
                        .collect()
                };
                Coefficients { sine: draw(), cosine: draw() }
            }
        };
        if fit_in(subject, room, search, &mut next) {
            let found = information(subject, room, &motion(room, search, &next)).0;
            let better = best.as_ref().is_none_or(|(most, _)| found > *most);
            if better && subject.workspace.series(&next.sine, &next.cosine) {
                best = Some((found, next));
            }
        }
        tick();
    }
    let (_, chosen) = best?;
    let (information, matrix) = information(subject, room, &motion(room, search, &chosen));
    let b = subject.base.len();
    let spread = inverse(&matrix);
    let deviations = (0..b).map(|k| spread[(k, k)].max(0.0).sqrt()).collect();
    let condition = condition(&matrix.view((0, 0), (b, b)).into_owned());
    Some(FourierSeries { sine: chosen.sine, cosine: chosen.cosine, information, condition, deviations })
}

fn motion(room: &Room, search: &SearchSettings, coefficients: &Coefficients) -> Motion {
    let joints = room.centre.len();
    let sample = |step: usize| {
        let mut state = [room.centre.clone(), vec![0.0; joints], vec![0.0; joints]];
        for k in 0..search.harmonics {
            let rate = std::f64::consts::TAU * (k + 1) as f64 / search.period;
            let (sin, cos) = (rate * search.period * step as f64 / SAMPLES as f64).sin_cos();
            for joint in 0..joints {
                let (a, b) = (coefficients.sine[k][joint], coefficients.cosine[k][joint]);
                state[0][joint] += a * sin + b * cos;
                state[1][joint] += rate * (a * cos - b * sin);
                state[2][joint] -= rate * rate * (a * sin + b * cos);
            }
        }
        state
    };
    (0..SAMPLES).map(sample).collect()
}

/// Scales each joint into its limits, then all joints together until the torques and the workspace allow the motion. False if no scale does.
fn fit_in(subject: &Subject<'_>, room: &Room, search: &SearchSettings, coefficients: &mut Coefficients) -> bool {
    let joints = room.centre.len();
    let first = motion(room, search, coefficients);
    let most = |pick: &dyn Fn(&[Vec<f64>; 3]) -> f64| first.iter().map(pick).fold(0.0, f64::max);
    let mut factors = vec![1.0; joints];
    for (joint, factor) in factors.iter_mut().enumerate() {
        let (lo, hi) = room.position[joint];
        let centre = room.centre[joint];
        // Add a small margin for the extremes between samples.
        let up = most(&|s| (s[0][joint] - centre).max(0.0)) * 1.02;
        let down = most(&|s| (centre - s[0][joint]).max(0.0)) * 1.02;
        let speed = most(&|s| s[1][joint].abs()) * 1.02;
        let steep = most(&|s| s[2][joint].abs()) * 1.03;
        let ratio = |room: f64, taken: f64| if taken > 0.0 { room / taken } else { f64::INFINITY };
        *factor = [
            ratio(hi - centre, up),
            ratio(centre - lo, down),
            ratio(room.velocity[joint], speed),
            ratio(room.acceleration[joint], steep),
        ]
        .into_iter()
        .fold(f64::INFINITY, f64::min)
        .clamp(0.0, 1e6);
    }
    for list in coefficients.sine.iter_mut().chain(&mut coefficients.cosine) {
        list.iter_mut().zip(&factors).for_each(|(a, factor)| *a *= factor);
    }
    for _ in 0..12 {
        let moved = motion(room, search, coefficients);
        if moved.iter().all(|state| holds(subject, room, state)) {
            return true;
        }
        for list in coefficients.sine.iter_mut().chain(&mut coefficients.cosine) {
            list.iter_mut().for_each(|a| *a *= 0.85);
        }
    }
    false
}

fn holds(subject: &Subject<'_>, room: &Room, state: &[Vec<f64>; 3]) -> bool {
    subject.workspace.posture(&state[0])
        && rows(subject, state).iter().enumerate().all(|(joint, row)| {
            let tau: f64 = row.iter().zip(subject.beta).map(|(y, beta)| y * beta).sum();
            tau.abs() <= room.torque[joint]
        })
}

/// Base-parameter columns at each joint.
fn rows(subject: &Subject<'_>, state: &[Vec<f64>; 3]) -> Vec<DVector<f64>> {
    subject.base.rows(subject.arm, state.each_ref().map(Vec::as_slice))
}

/// `log det` of the information about bodies and friction in one period, and the information matrix.
fn information(subject: &Subject<'_>, room: &Room, motion: &Motion) -> (f64, DMatrix<f64>) {
    let b = subject.base.len();
    let unknowns = b + FRICTION * subject.base.joints;
    let mut matrix = DMatrix::zeros(unknowns, unknowns);
    for state in motion {
        for (joint, row) in rows(subject, state).iter().enumerate() {
            let friction = [1.0, state[1][joint], state[1][joint].signum()];
            let mut all = DVector::zeros(unknowns);
            all.rows_mut(0, b).copy_from(row);
            for (k, x) in friction.into_iter().enumerate() {
                all[b + FRICTION * joint + k] = x;
            }
            matrix.syger(room.noise[joint].powi(-2), &all, &all, 1.0);
        }
    }
    matrix.fill_upper_triangle_with_lower_triangle();
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(unknowns, unknowns, |i, j| {
        matrix[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-9 } else { 0.0 }
    });
    let determinant = scaled.cholesky().map_or(f64::NEG_INFINITY, |factor| {
        2.0 * factor.l_dirty().diagonal().iter().zip(scale.iter()).map(|(l, s)| l.ln() + s.ln()).sum::<f64>()
    });
    (determinant, matrix)
}

/// Finds postures for static measurements. Each next posture is, of random ones, the one that adds most information about the gravity parameters and
/// that the arm can reach on a straight line in joint space. The last posture has a free line back to the first.
#[must_use]
pub fn postures(subject: &Subject<'_>, room: &Room, count: usize, seed: u64, tick: &dyn Fn()) -> Vec<Vec<f64>> {
    let mut random = Random::new(seed);
    let joints = room.centre.len();
    let still = vec![0.0; joints];
    let b = subject.base.len();
    let mut matrix = DMatrix::from_diagonal_element(b, b, 1e-6);
    let mut chosen = vec![room.centre.clone()];
    while chosen.len() < count {
        let covariance = inverse(&matrix);
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        for _ in 0..200 {
            let q: Vec<f64> = room.position.iter().map(|(lo, hi)| lo + random.share() * (hi - lo)).collect();
            let state = [q, still.clone(), still.clone()];
            if !holds(subject, room, &state) {
                continue;
            }
            let gain: f64 = rows(subject, &state)
                .iter()
                .zip(&room.noise)
                .map(|(y, noise)| (1.0 + y.dot(&(&covariance * y)) / (noise * noise)).ln())
                .sum();
            found.push((gain, state[0].clone()));
        }
        tick();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let here = chosen.last().unwrap_or(&room.centre);
        let Some((_, q)) = found.into_iter().find(|(_, q)| subject.workspace.line(here, q)) else { break };
        for (y, noise) in rows(subject, &[q.clone(), still.clone(), still.clone()]).iter().zip(&room.noise) {
            matrix += y * y.transpose() / (noise * noise);
        }
        chosen.push(q);
    }
    while chosen.len() > 1 && !chosen.last().is_some_and(|q| subject.workspace.line(q, &room.centre)) {
        chosen.pop();
    }
    chosen
}
