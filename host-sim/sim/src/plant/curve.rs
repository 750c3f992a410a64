//! Interpolant of a step. It gives the instant of an event, and the state at that instant.
//!
//! ```text
//! x(s) = r0 + s (r1 + (1 - s) (r2 + s (r3 + (1 - s) r4)))        0 <= s <= 1, a part of the step
//! ```
//!
//! Up to `r3` this is the cubic Hermite interpolant through both ends, with an error of fourth order in the step; `r4` raises the order by one. (E.
//! Hairer, S. Norsett, G. Wanner, Solving ordinary differential equations I, 1993, section II.6.)

use super::state::Point;

/// A step of length `h` (s) from `start` to `end`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve<'a, Y, const L: usize> {
    pub(super) start: &'a Y,
    pub(super) end: &'a Y,
    /// Slope at the start.
    pub(super) first: &'a Y,
    /// Slope at the end; `None` for semi-implicit Euler, where a part of a step is computed as a shorter step.
    pub(super) last: Option<&'a Y>,
    /// The last coefficient, if the method has one.
    pub(super) fourth: Option<&'a Y>,
    pub(super) h: &'a [f64; L],
}

impl<Y, const L: usize> Curve<'_, Y, L> {
    /// Points at these fractions of the step, one per lane.
    pub(super) fn at<const N: usize>(&self, part: &[f64; L]) -> Y
    where
        Y: Point<N, L>,
    {
        let Some(last) = self.last else {
            return self.start.kicked(self.first, &core::array::from_fn(|lane| part[lane] * self.h[lane]));
        };
        let value = |lane: usize, ends: [f64; 2], slopes: [f64; 2], fourth: f64| {
            interpolated(&coefficients(ends, slopes.map(|k| k * self.h[lane]), fourth), part[lane])
        };
        match self.fourth {
            None => self.start.combine([self.end, self.first, last], |lane, x, [end, first, last]| {
                value(lane, [x, end], [first, last], 0.0)
            }),
            Some(fourth) => {
                self.start.combine([self.end, self.first, last, fourth], |lane, x, [end, first, last, fourth]| {
                    value(lane, [x, end], [first, last], fourth)
                })
            }
        }
    }

    /// Coefficients of the velocity of a joint, on the side on which friction acts.
    pub(super) fn velocity<const N: usize>(&self, joint: usize, lane: usize) -> [f64; 5]
    where
        Y: Point<N, L>,
    {
        let of = |point: &Y| point.friction_side().qd[joint][lane];
        let ends = [of(self.start), of(self.end)];
        match self.last {
            None => [ends[0], ends[1] - ends[0], 0.0, 0.0, 0.0],
            Some(last) => {
                let slopes = [self.first, last].map(|slope| of(slope) * self.h[lane]);
                coefficients(ends, slopes, self.fourth.map_or(0.0, of))
            }
        }
    }
}

/// Coefficients of a component, from its values at both ends and from its slopes times the step.
fn coefficients(ends: [f64; 2], slopes: [f64; 2], fourth: f64) -> [f64; 5] {
    let across = ends[1] - ends[0];
    let second = slopes[0] - across;
    [ends[0], across, second, across - slopes[1] - second, fourth]
}

/// Value of an interpolant at a fraction of its step.
pub(super) fn interpolated([r0, r1, r2, r3, r4]: &[f64; 5], part: f64) -> f64 {
    let left = 1.0 - part;
    r0 + part * (r1 + left * (r2 + part * (r3 + left * r4)))
}
