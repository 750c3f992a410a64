//! Construction of motions: a Fourier series with ramps, slow sweeps, and postures with rests.

use dynamics_core::Model;
use dynamics_core::control::trajectory::{Bounds, FourierSpec, HARMONICS_MAX, Motion, MotionError, Timing, Waypoint};
use identification::excite::Room;

/// Duration of the rest in a posture, and of the motion to the next, s.
pub(super) const REST: (f64, f64) = (1.5, 2.5);

/// Steady speeds of the slow sweeps, as shares of the allowed speed.
const SLOW: (f64, f64) = (0.05, 0.2);

/// A point of a quintic: position (rad or m), duration of the segment to it (s), rest (s).
pub(super) type QuinticPoint = (Vec<f64>, f64, f64);

/// A series as a motion, with the fastest ramps within the limits. The amplitudes are those of the sines and the cosines, for each harmonic.
pub(super) fn fastest_ramp<const N: usize>(
    model: &Model<f64, N>,
    centre: &[f64],
    period: f64,
    periods: u32,
    [sine, cosine]: [&[Vec<f64>]; 2],
) -> Result<(Motion<f64, N>, FourierSpec<f64, N>), MotionError> {
    let bounds = Bounds::from_limits(&model.links().map(|link| link.limits));
    let harmonics = |list: &[Vec<f64>]| -> [[f64; N]; HARMONICS_MAX] {
        core::array::from_fn(|k| core::array::from_fn(|i| list.get(k).map_or(0.0, |a| round(a[i]))))
    };
    let mut ramp = 0.15 * period;
    loop {
        let spec = FourierSpec {
            centre: core::array::from_fn(|i| round(centre[i])),
            sine: harmonics(sine),
            cosine: harmonics(cosine),
            period,
            duration: f64::from(periods) * period + 2.0 * ramp,
            ramp,
        };
        match Motion::fourier(&spec, &bounds) {
            Ok(motion) => return Ok((motion, spec)),
            Err(error) if ramp > 2.0 * period => return Err(error),
            Err(_) => ramp *= 1.4,
        }
    }
}

/// Rounds to five decimals, a hundredth of a milliradian.
fn round(x: f64) -> f64 {
    (x * 1e5).round() / 1e5
}

/// Quintic segments through points, as a motion.
pub(super) fn quintic<const N: usize>(points: &[QuinticPoint]) -> Result<Motion<f64, N>, MotionError> {
    let way: Vec<Waypoint<f64, N>> =
        points.iter().map(|(q, _, dwell)| Waypoint { q: core::array::from_fn(|i| q[i]), dwell: *dwell }).collect();
    let durations: Vec<f64> = points.iter().skip(1).map(|(_, duration, _)| *duration).collect();
    Motion::quintic(&way, Timing::Durations(&durations), &Bounds::none())
}

/// Points for a back-and-forth motion between the ends at two steady speeds: a quintic passes evenly spaced points at their mean speed.
/// `share_of_range` is the swept share of the free range.
pub(super) fn sweeps(room: &Room, share_of_range: f64) -> Vec<QuinticPoint> {
    const WAY: [(f64, bool); 14] = [
        (0.0, false),
        (0.5, false),
        (1.0, false),
        (0.333, false),
        (-0.333, false),
        (-1.0, false),
        (-0.333, true),
        (0.333, true),
        (1.0, true),
        (0.333, true),
        (-0.333, true),
        (-1.0, true),
        (-0.5, false),
        (0.0, false),
    ];
    let swing: Vec<f64> =
        room.centre.iter().zip(&room.position).map(|(q, (lo, hi))| share_of_range * (q - lo).min(hi - q)).collect();
    let mut before = 0.0;
    WAY.iter()
        .map(|&(place, fast)| {
            let share = if fast { SLOW.1 } else { SLOW.0 };
            let needs = |(a, v): (&f64, &f64)| a * (place - before).abs() / (share * v);
            let duration = swing.iter().zip(&room.velocity).map(needs).fold(0.1, f64::max);
            before = place;
            (room.centre.iter().zip(&swing).map(|(q, a)| round(q + a * place)).collect(), milliseconds(duration), 0.0)
        })
        .collect()
}

/// Rounds a time up to milliseconds, as in the file, s.
fn milliseconds(time: f64) -> f64 {
    (time * 1e3).ceil() / 1e3
}

/// Points for postures with rests; the first is repeated at the end.
pub(super) fn rests(found: &[Vec<f64>]) -> Vec<QuinticPoint> {
    let rounded = |q: &Vec<f64>| q.iter().map(|q| round(*q)).collect();
    let mut points: Vec<QuinticPoint> = found.iter().map(|q| (rounded(q), REST.1, REST.0)).collect();
    points.extend(found.first().map(|q| (rounded(q), REST.1, 0.0)));
    points
}
