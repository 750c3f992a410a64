//! Search for the posture inside a box that minimises a function: descent from many starting points.
//!
//! The search is deterministic and needs no derivatives. The starting points are the given posture, the middle of the box, and points of an additive
//! sequence with the powers of a generalised golden ratio, which fills a box of any dimension evenly. The descent tries a step in both directions on
//! each joint in turn and keeps the first improvement. When no joint improves, it halves the steps. The best result of all starts is then refined
//! further. For a smooth function no joint alone can improve the result. A global minimum is likely with so many starts, but not proved.

use core::f64::consts::{PI, TAU};
use dynamics_core::{JointKind, Model};

/// Number of starting points.
pub const STARTS: usize = 64;

/// First step, as a share of a joint's range.
const FIRST: f64 = 1.0 / 8.0;
/// Depth of a search, as shares of a joint's range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Last step for all starts.
    pub coarse: f64,
    /// Last step for the best start.
    pub fine: f64,
}

/// Depth down to rounding, if the posture itself is needed.
pub const EXACT: Depth = Depth { coarse: 1e-4, fine: 1e-9 };
/// Depth for three digits of the value, for example for a load; near its minimum the value is flat.
pub const ROUGH: Depth = Depth { coarse: 1e-2, fine: 1e-4 };

/// Largest number of rounds over all joints in one descent, in case a valley is too narrow to follow.
const ROUNDS: usize = 20_000;

/// The least value found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowestPosture<const N: usize> {
    /// Posture of the least value, rad or m.
    pub q: [f64; N],
    /// The least value.
    pub value: f64,
    /// Number of evaluations of the function.
    pub evaluations: u64,
}

/// Searches a box for the smallest value of a function. A joint with equal bounds stays there.
///
/// `start` must lie in the box. A NaN value never counts as better.
pub fn minimise<const N: usize>(
    bounds: &[(f64, f64); N],
    start: &[f64; N],
    cost: impl FnMut(&[f64; N]) -> f64,
) -> LowestPosture<N> {
    minimise_to(EXACT, bounds, start, cost)
}

/// Same as [`minimise`], to another depth.
pub fn minimise_to<const N: usize>(
    depth: Depth,
    bounds: &[(f64, f64); N],
    start: &[f64; N],
    mut cost: impl FnMut(&[f64; N]) -> f64,
) -> LowestPosture<N> {
    let share = |part: &[f64; N]| core::array::from_fn(|i| bounds[i].0 + (bounds[i].1 - bounds[i].0) * part[i]);
    let ratio = golden(N);
    let spread = |k: usize| {
        share(&core::array::from_fn(|i| {
            let x = 0.5 + k as f64 * ratio.powi(-(i as i32 + 1));
            x - x.floor()
        }))
    };
    let others = [share(&[0.5; N])].into_iter().chain((1..STARTS - 1).map(spread));
    let mut best = LowestPosture { q: *start, value: cost(start), evaluations: 1 };
    downhill(bounds, &mut best, (FIRST, depth.coarse), &mut cost);
    for q in others {
        let mut next = LowestPosture { q, value: cost(&q), evaluations: best.evaluations + 1 };
        downhill(bounds, &mut next, (FIRST, depth.coarse), &mut cost);
        best = LowestPosture { evaluations: next.evaluations, ..if next.value < best.value { next } else { best } };
    }
    downhill(bounds, &mut best, (depth.coarse, depth.fine), &mut cost);
    best
}

/// Descends from a point, with steps from the first share of each joint's range to the last.
fn downhill<const N: usize>(
    bounds: &[(f64, f64); N],
    at: &mut LowestPosture<N>,
    (first, last): (f64, f64),
    cost: &mut impl FnMut(&[f64; N]) -> f64,
) {
    let mut step = first;
    for _ in 0..ROUNDS {
        let mut gained = false;
        for i in 0..N {
            let (low, high) = bounds[i];
            if low >= high {
                continue;
            }
            for side in [step, -step] {
                let mut q = at.q;
                q[i] = (q[i] + side * (high - low)).clamp(low, high);
                let value = cost(&q);
                at.evaluations += 1;
                if value < at.value {
                    (at.q, at.value, gained) = (q, value, true);
                    break;
                }
            }
        }
        if !gained {
            step /= 2.0;
            if step < last {
                return;
            }
        }
    }
}

/// Root greater than one of `x^(n + 1) = x + 1`; the golden ratio for `n = 1`.
fn golden(n: usize) -> f64 {
    let power = 1.0 / (n as f64 + 1.0);
    (0..64).fold(2.0_f64, |x, _| (1.0 + x).powf(power))
}

/// Range of a joint: its limits, or one turn without limits; `None` for a prismatic joint without limits.
#[must_use]
pub fn positions(kind: JointKind, limits: (f64, f64)) -> Option<(f64, f64)> {
    match (kind, limits.0.is_finite(), limits.1.is_finite()) {
        (_, true, true) => Some(limits),
        (JointKind::Prismatic, ..) => None,
        (_, true, false) => Some((limits.0, limits.0 + TAU)),
        (_, false, true) => Some((limits.1 - TAU, limits.1)),
        (_, false, false) => Some((-PI, PI)),
    }
}

/// Ranges of all joints from [`positions`], and their middle; a prismatic joint without limits stays at zero.
#[must_use]
pub fn ranges<const N: usize>(model: &Model<f64, N>) -> ([(f64, f64); N], [f64; N]) {
    let bounds = model.links().map(|link| positions(link.kind, link.limits.position).unwrap_or((0.0, 0.0)));
    (bounds, bounds.map(|(low, high)| low + (high - low) / 2.0))
}

#[cfg(test)]
mod tests {
    use super::{EXACT, ROUGH, golden, minimise, minimise_to};

    #[test]
    fn the_ratio_is_golden() {
        assert!((golden(1) - (1.0 + 5.0_f64.sqrt()) / 2.0).abs() < 1e-15);
        assert!((golden(2).powi(3) - golden(2) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_deeper_of_two_valleys_is_found_from_the_other_one() {
        let two = |x: &[f64; 1]| (x[0] * x[0] - 1.0).powi(2) + 0.1 * x[0];
        let least = minimise(&[(-3.0, 3.0)], &[1.0], two);
        let slope = 4.0 * least.q[0].powi(3) - 4.0 * least.q[0] + 0.1;
        assert!(least.q[0] < -1.0 && slope.abs() < 1e-6, "{least:?}");
        assert_eq!(least, minimise(&[(-3.0, 3.0)], &[1.0], two));
    }

    #[test]
    fn a_rough_search_has_three_digits_of_the_value_at_a_part_of_the_work() {
        let valley = |x: &[f64; 3]| {
            let [a, b, c] = [x[0] - 0.3, x[0] + x[1] - 0.1, x[2] + 0.7];
            -10.0 * (a.cos() + b.cos() + c.cos())
        };
        let bounds = [(-3.0, 3.0); 3];
        let [rough, exact] = [ROUGH, EXACT].map(|depth| minimise_to(depth, &bounds, &[0.0; 3], valley));
        assert!((rough.value - exact.value).abs() < 1e-3 * exact.value.abs(), "{rough:?} {exact:?}");
        assert!(2 * rough.evaluations < exact.evaluations, "{rough:?} {exact:?}");
    }

    #[test]
    fn bounds_hold_and_equal_ones_hold_a_joint() {
        let slope = |x: &[f64; 3]| x[0] + (x[1] - 0.3).powi(2) - 2.0 * x[2];
        let least = minimise(&[(-1.0, 1.0), (0.7, 0.7), (0.0, 2.0)], &[0.0, 0.7, 0.0], slope);
        assert_eq!((least.q[0], least.q[1], least.q[2]), (-1.0, 0.7, 2.0));
    }

    #[test]
    fn a_value_that_is_none_is_never_the_least() {
        let least = minimise(&[(-1.0, 1.0)], &[0.5], |x| if x[0] < 0.0 { f64::NAN } else { x[0] });
        assert!(least.q[0].abs() < 1e-8 && least.value >= 0.0, "{least:?}");
    }
}
