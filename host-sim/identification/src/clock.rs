//! Time stamps that jitter although the samples are even.
//!
//! A program that stamps samples when it receives them adds its own delays to their times. Velocities and accelerations computed with such stamps are
//! mostly noise, and noise in a column of a linear model biases its coefficient towards zero. The positions show which clock is right: with the true
//! clock they are smooth.

use crate::Series;
use crate::filter::LowPass;
use crate::log::Log;
use crate::statistics::rms;

/// Highest frequency of clock drift that the even clock follows, Hz.
const DRIFT: f64 = 0.5;
/// The even clock is used if positions are at most this share as rough with it as with the stamps.
const SMOOTHER: f64 = 0.6;
/// Stamps whose jitter is below this share of a step are left as they are.
const EVEN: f64 = 0.005;

/// Returns the log with an even clock if its positions show that the stamps jitter, otherwise unchanged; and the root mean square deviation of the
/// stamps from the clock that is used, s.
#[must_use]
pub fn repaired(log: &Log) -> (Log, f64) {
    let (time, jitter) = clock(log);
    (Log { time, ..log.clone() }, jitter)
}

fn clock(log: &Log) -> (Vec<f64>, f64) {
    let n = log.time.len();
    let stamps = || (log.time.clone(), 0.0);
    if n < 20 {
        return stamps();
    }
    let line = line(&log.time);
    let off: Vec<f64> = log.time.iter().zip(&line).map(|(t, l)| t - l).collect();
    let step = (line[n - 1] - line[0]) / (n - 1) as f64;
    if rms(&off) < EVEN * step {
        return stamps();
    }
    let rate = step.recip();
    let drift = LowPass::new(DRIFT.min(0.1 * rate), rate).apply(&off);
    let drifting: Vec<f64> = line.iter().zip(&drift).map(|(l, d)| l + d).collect();
    let by_stamps = roughness(&log.time, &log.q);
    let best = [line, drifting]
        .into_iter()
        .filter(|clock| clock.windows(2).all(|t| t[1] > t[0]))
        .map(|clock| (roughness(&clock, &log.q), clock))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((rough, clock)) if rough < SMOOTHER * by_stamps => {
            let jitter: Vec<f64> = log.time.iter().zip(&clock).map(|(t, c)| t - c).collect();
            let size = rms(&jitter);
            (clock, size)
        }
        _ => stamps(),
    }
}

/// Straight line fitted to the stamps by least squares.
fn line(time: &[f64]) -> Vec<f64> {
    let n = time.len() as f64;
    let (middle, mean) = (0.5 * (n - 1.0), time.iter().sum::<f64>() / n);
    let (mut up, mut across) = (0.0, 0.0);
    for (k, t) in time.iter().enumerate() {
        let k = k as f64 - middle;
        up += k * (t - mean);
        across += k * k;
    }
    (0..time.len()).map(|k| mean + up / across.max(1e-300) * (k as f64 - middle)).collect()
}

/// Roughness of positions: distance of each sample from the cubic through its four neighbours, root mean square over all joints.
fn roughness(time: &[f64], q: &Series) -> f64 {
    let mut sum = 0.0;
    for k in 2..time.len() - 2 {
        let near = [k - 2, k - 1, k + 1, k + 2];
        let weights = near.map(|i| {
            near.iter().filter(|j| **j != i).map(|j| (time[k] - time[*j]) / (time[i] - time[*j])).product::<f64>()
        });
        // Neighbours that nearly coincide get large weights; a sample between them carries little information about the clock, hence the norm.
        let norm = 1.0 + weights.iter().map(|w| w * w).sum::<f64>();
        for q in q {
            let off = q[k] - near.iter().zip(weights).map(|(i, w)| w * q[*i]).sum::<f64>();
            sum += off * off / norm;
        }
    }
    (sum / (time.len() * q.len()).max(1) as f64).sqrt()
}
