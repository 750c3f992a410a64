//! Dry friction over a step: which joints slide and which are held, and the instants at which that changes.
//!
//! In a step, each joint either slides in one direction under the full level of its friction, or is held and has no acceleration. So the equations of
//! motion are smooth within a step, and an integrator keeps its order. An event ends a step early if
//!
//! - a sliding joint comes to rest: from then on its velocity is exactly zero;
//! - the load of a held joint exceeds the level of its friction.
//!
//! The instant is the root of the step's interpolant. At the start of every step, the joints at rest are sorted by complementarity: the load of a
//! held joint is at most its level, and a joint that is let go accelerates in the direction of the load that tore it loose. Inertia couples the
//! joints, so letting one go changes the load of the others. The choice exists and is unique, because the inertia matrix is positive definite. It is
//! found by exchanging all joints that violate the conditions, and only one at a time after [`TOGETHER`] exchanges. (K. G. Murty, Linear
//! complementarity, 1988; J. Judice, F. Pires, A block principal pivoting algorithm, 1994.)
//!
//! A state contains all that is needed to continue: a joint is at rest if its velocity is exactly zero.

use super::curve::{Curve, interpolated};
use super::flow::{Dry, Flow};
use super::state::{Lanes, Point};

/// Exchanges of all violating joints at once, after which only the first violating joint is exchanged.
const TOGETHER: usize = 4;

/// Limit on the exchanges at one instant. Six joints have 3^6 choices; no more than ten exchanges have been seen.
const EXCHANGES_MAX: usize = 64;

/// Limit on the events of an arm in an interval. Without it, joints that keep breaking loose and stopping again could stall the simulation.
pub(super) const EVENTS_MAX: u32 = 200;

/// Fraction of the step that is added to the instant at which a joint breaks loose, so that its load is then beyond the level.
const BEYOND: f64 = 1e-6;

/// Latest event in a step, as a fraction of the step: an event practically at the end still ends the step.
const WITHIN: f64 = 1.0 - 1e-12;

/// Changes within a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Events<const N: usize, const L: usize> {
    /// Fraction of the step after which the first change occurs; 1 in a lane without a change.
    pub(super) part: [f64; L],
    /// Joints that come to rest at that instant.
    stops: [[bool; L]; N],
}

impl<const N: usize, const L: usize> Dry<N, L> {
    /// Starts a step of the active lanes from `point`: sorts the joints at rest and writes the slope there.
    #[inline(always)]
    pub(super) fn begin<Y: Point<N, L>, F: Flow<Y, N, L>>(
        &mut self,
        flow: &F,
        point: &Y,
        input: &F::Input,
        slope: &mut Y,
        lanes: &mut Lanes<L>,
    ) {
        let Some(rough) = flow.rough() else {
            flow.slope(point, input, self, slope, lanes);
            return;
        };
        let qd = &point.friction_side().qd;
        self.look(rough, qd, lanes.active);
        flow.slope(point, input, self, slope, lanes);
        if self.rests {
            self.sort(flow, (point, input), slope, lanes);
            self.keep_margin(lanes.active);
        }
    }

    /// Sets the directions of the active lanes' joints from their velocities. A joint at rest counts as held for now.
    #[inline(always)]
    fn look(&mut self, rough: &[[f64; L]; N], qd: &[[f64; L]; N], active: [bool; L]) {
        let mut moves = 1_u64;
        for i in 0..N {
            for lane in 0..L {
                let sign = if qd[i][lane] == 0.0 { 0.0 } else { 1.0_f64.copysign(qd[i][lane]) } * rough[i][lane];
                let free = 1.0 - (rough[i][lane] - sign.abs());
                self.sign[i][lane] = if active[lane] { sign } else { self.sign[i][lane] };
                self.free[i][lane] = if active[lane] { free } else { self.free[i][lane] };
                moves &= u64::from(self.free[i][lane] != 0.0);
            }
        }
        self.rests = moves == 0;
    }

    /// Frees the joints at rest that friction cannot hold.
    #[inline(never)]
    fn sort<Y: Point<N, L>, F: Flow<Y, N, L>>(
        &mut self,
        flow: &F,
        (point, input): (&Y, &F::Input),
        slope: &mut Y,
        lanes: &mut Lanes<L>,
    ) {
        let active = lanes.active;
        for exchange in 0..EXCHANGES_MAX {
            let most = if exchange < TOGETHER { N } else { 1 };
            lanes.active = self.exchange(&point.friction_side().qd, &slope.friction_side().qd, most, lanes.live());
            if !lanes.active.contains(&true) {
                break;
            }
            flow.slope(point, input, self, slope, lanes);
        }
        lanes.active = active;
    }

    /// Exchanges at most this many joints of each live lane that violate complementarity. Returns the lanes in which some did.
    fn exchange(&mut self, qd: &[[f64; L]; N], qdd: &[[f64; L]; N], most: usize, live: [bool; L]) -> [bool; L] {
        let mut exchanged = [0; L];
        for i in 0..N {
            for lane in 0..L {
                if !live[lane] || exchanged[lane] == most {
                    continue;
                }
                let load = self.load[i][lane];
                if self.free[i][lane] == 0.0 && load.abs() > self.level[i][lane] {
                    (self.free[i][lane], self.sign[i][lane]) = (1.0, load.signum());
                } else if qd[i][lane] == 0.0 && self.sign[i][lane] * qdd[i][lane] < 0.0 {
                    (self.free[i][lane], self.sign[i][lane]) = (0.0, 0.0);
                } else {
                    continue;
                }
                exchanged[lane] += 1;
            }
        }
        exchanged.map(|joints| joints > 0)
    }

    /// Stores the margin of the held joints of these lanes, for the start of the next step.
    pub(super) fn keep_margin(&mut self, lanes: [bool; L]) {
        if !self.rests {
            return;
        }
        for i in 0..N {
            for lane in 0..L {
                let margin = self.level[i][lane] - self.load[i][lane].abs();
                self.margin[i][lane] = if lanes[lane] { margin } else { self.margin[i][lane] };
            }
        }
    }

    /// True if a joint in some lane has reversed its direction, or is held under a load beyond its level. Loads are compared only if `end` is true:
    /// they were then computed at the end of the step.
    #[inline(always)]
    fn is_disturbed(&self, qd: &[[f64; L]; N], end: bool) -> bool {
        let mut disturbed = 0_u64;
        for i in 0..N {
            for lane in 0..L {
                disturbed |= u64::from(self.sign[i][lane] * qd[i][lane] < 0.0);
            }
        }
        if end && self.rests {
            for i in 0..N {
                for lane in 0..L {
                    let torn = self.load[i][lane].abs() > self.level[i][lane];
                    disturbed |= u64::from(torn) & u64::from(self.free[i][lane] == 0.0);
                }
            }
        }
        disturbed != 0
    }

    /// Finds the first change in a step along a curve, for each of these lanes; `None` if no lane has any.
    #[inline(always)]
    pub(super) fn events<Y: Point<N, L>>(&self, curve: &Curve<'_, Y, L>, among: [bool; L]) -> Option<Events<N, L>> {
        let qd = &curve.end.friction_side().qd;
        if !self.is_disturbed(qd, curve.last.is_some()) {
            return None;
        }
        self.find(curve, among)
    }

    #[inline(never)]
    fn find<Y: Point<N, L>>(&self, curve: &Curve<'_, Y, L>, among: [bool; L]) -> Option<Events<N, L>> {
        let mut root = [[2.0; L]; N];
        let mut part = [1.0_f64; L];
        let mut any = false;
        for i in 0..N {
            for lane in (0..L).filter(|&lane| among[lane]) {
                let sign = self.sign[i][lane];
                let at = if sign * curve.end.friction_side().qd[i][lane] < 0.0 {
                    root[i][lane] = first_zero(&curve.velocity(i, lane).map(|x| x * sign));
                    root[i][lane]
                } else if let Some(at) = self.torn(i, lane, curve.last.is_some()) {
                    at
                } else {
                    continue;
                };
                any = true;
                part[lane] = if at < part[lane] { at } else { part[lane] };
            }
        }
        let mut stops = [[false; L]; N];
        for i in 0..N {
            for lane in 0..L {
                stops[i][lane] = root[i][lane] <= part[lane];
            }
        }
        any.then_some(Events { part, stops })
    }

    /// Fraction of the step after which a held joint breaks loose, if it does by the end.
    fn torn(&self, i: usize, lane: usize, end: bool) -> Option<f64> {
        let left = self.level[i][lane] - self.load[i][lane].abs();
        if !end || self.free[i][lane] != 0.0 || left >= 0.0 {
            return None;
        }
        let margin = if self.margin[i][lane] > 0.0 { self.margin[i][lane] } else { 0.0 };
        let at = margin / (margin - left) + BEYOND;
        Some(if at < WITHIN { at } else { WITHIN })
    }
}

impl<const N: usize, const L: usize> Events<N, L> {
    /// Moves `end` to the first change of every lane that has one.
    pub(super) fn cut<Y: Point<N, L>>(&self, curve: &Curve<'_, Y, L>) -> Y {
        let (mut end, has) = (*curve.end, self.part.map(|part| part < 1.0));
        end.take(&curve.at(&self.part), &has);
        let qd = &mut end.friction_side_mut().qd;
        for i in 0..N {
            for lane in 0..L {
                qd[i][lane] = if self.stops[i][lane] { 0.0 } else { qd[i][lane] };
            }
        }
        end
    }
}

/// Fraction of the step at which a velocity falls below zero; it must be below zero at the end. Bisection is used, so that a velocity that starts at
/// zero and rises first is followed to its fall.
fn first_zero(velocity: &[f64; 5]) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if interpolated(velocity, middle) > 0.0 { low = middle } else { high = middle }
    }
    if high < WITHIN { high } else { WITHIN }
}
