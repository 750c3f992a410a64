//! Integrators: they advance the simulated arm from one instant to the next.
//!
//! The torque is constant over a tick, so the right-hand side jumps between ticks. Every method therefore restarts at each tick, and also inside a
//! tick if jitter moves the jump there: no step crosses a jump. Dry friction also jumps, when a joint comes to rest or breaks loose; `stiction` ends
//! a step there.
//!
//! Several arms can be integrated together, one per lane. Each has its own time, step, method and end; a lane that has arrived waits and keeps its
//! state. The operations in a lane are the same as those for a single arm.
//!
//! The embedded pair is implemented here, because no crate fits. `ode_solvers` 0.6 (which uses another nalgebra and allocates a vector of results in
//! every tick) and `differential-equations` 0.7 accept no right-hand side that can fail. They also compute powers with the platform's library, so a
//! run would not have the same bits on every machine. `diffsol` 0.18 is made for stiff systems and brings a matrix library.

use super::curve::Curve;
use super::dormand_prince::{EmbeddedPair, along, dormand_prince, factor};
use super::flow::{Dry, Flow};
use super::state::{Diverged, Lanes, Point};
use super::stiction::EVENTS_MAX;
use robot_compiler::scene::Integrator;

/// Limit on the adaptive method's steps in a tick, accepted or not.
const ATTEMPTS_MAX: u32 = 100_000;

/// A part of a tick without a jump, with its limits in s and its number of steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) steps: u32,
}

/// A completed step of one lane: from `t`, of length `h` (s).
pub(super) struct Step<'a, Y> {
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) before: &'a Y,
    pub(super) after: &'a Y,
}

/// Integration plan of a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub(super) integrator: Integrator,
    pub(super) stretch: Stretch,
    /// Next step of the adaptive method, s.
    pub(super) next: f64,
}

/// Integrates every lane with a plan along its interval, and calls `each` after every step of a lane. Returns for each lane the error that stopped
/// it, if any; `point` then holds its last good state. Updates the plans' next steps.
#[inline(always)]
pub(super) fn advance<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    flow: &F,
    point: &mut Y,
    plans: &mut [Option<Plan>; L],
    mut each: impl FnMut(&Step<'_, Y>),
) -> [Option<Diverged>; L] {
    let mut lanes = Lanes { active: [false; L], failed: [None; L] };
    let mask = |plans: &[Option<Plan>; L], which: fn(Integrator) -> bool| {
        core::array::from_fn(|lane| plans[lane].is_some_and(|plan| which(plan.integrator)))
    };
    let fourth = mask(plans, |it| matches!(it, Integrator::RungeKutta));
    if fourth.contains(&true) {
        fixed(Fixed::RungeKutta, flow, point, plans, fourth, &mut lanes, &mut each);
    }
    let first = mask(plans, |it| matches!(it, Integrator::SemiImplicitEuler));
    if first.contains(&true) {
        fixed(Fixed::SemiImplicitEuler, flow, point, plans, first, &mut lanes, &mut each);
    }
    let adaptive = mask(plans, |it| matches!(it, Integrator::Adaptive { .. }));
    if adaptive.contains(&true) {
        adapt(flow, point, plans, adaptive, &mut lanes, &mut each);
    }
    lanes.failed
}

/// A method with steps of one length.
#[derive(Clone, Copy, Debug)]
enum Fixed {
    RungeKutta,
    SemiImplicitEuler,
}

/// Integrates the lanes of a mask with the step lengths of their plans. A step that an event ends early adds one step; the steps that follow are
/// shortened evenly.
#[inline(always)]
fn fixed<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    method: Fixed,
    flow: &F,
    point: &mut Y,
    plans: &[Option<Plan>; L],
    mask: [bool; L],
    lanes: &mut Lanes<L>,
    each: &mut impl FnMut(&Step<'_, Y>),
) {
    let stretch = plans.map(|plan| plan.map_or(Stretch { from: 0.0, to: 0.0, steps: 1 }, |plan| plan.stretch));
    let whole = stretch.map(|stretch| (stretch.to - stretch.from) / f64::from(stretch.steps));
    // Equal steps from an instant on: their start, length and number, and how many of them are done.
    let (mut from, mut h) = (stretch.map(|stretch| stretch.from), whole);
    let (mut steps, mut over) = (stretch.map(|stretch| stretch.steps), [0; L]);
    let mut events_left = [EVENTS_MAX; L];
    let mut dry = Dry::none();
    loop {
        lanes.active = core::array::from_fn(|lane| mask[lane] && over[lane] < steps[lane]);
        if lanes.over() {
            return;
        }
        let t = core::array::from_fn(|lane| from[lane] + f64::from(over[lane]) * h[lane]);
        let among = core::array::from_fn(|lane| lanes.active[lane] && events_left[lane] > 0);
        let (after, part) = match method {
            Fixed::RungeKutta => runge_kutta(flow, point, (&t, &h), &mut dry, among, lanes),
            Fixed::SemiImplicitEuler => semi_implicit_euler(flow, point, (&t, &h), &mut dry, among, lanes),
        };
        let largest = after.largest();
        for lane in 0..L {
            if !largest[lane].is_finite() {
                lanes.fail(lane, Diverged::NotFinite);
            }
        }
        let done = lanes.live();
        for lane in (0..L).filter(|&lane| done[lane]) {
            let passed = part.map_or(1.0, |part| part[lane]) * h[lane];
            each(&Step { t: t[lane], h: passed, before: point, after: &after });
            over[lane] += 1;
            if part.is_some_and(|part| part[lane] < 1.0) {
                events_left[lane] -= 1;
                from[lane] = t[lane] + passed;
                let left = stretch[lane].to - from[lane];
                // A remainder of the size of a rounding error gets no step.
                (steps[lane], over[lane]) = (libm::ceil(left / whole[lane] - 1e-9).max(0.0) as u32, 0);
                h[lane] = left / f64::from(steps[lane].max(1));
            }
        }
        point.take(&after, &done);
    }
}

/// One classical fourth-order Runge-Kutta step from `t` (s into the tick), of length `h`, or up to the first event. Returns the points there. If an
/// event ended a lane's step, also returns the fractions of the step that were completed.
#[inline(always)]
fn runge_kutta<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    flow: &F,
    start: &Y,
    (t, h): (&[f64; L], &[f64; L]),
    dry: &mut Dry<N, L>,
    among: [bool; L],
    lanes: &mut Lanes<L>,
) -> (Y, Option<[f64; L]>) {
    let half = h.map(|h| h / 2.0);
    let at = |part: &[f64; L]| flow.input(&core::array::from_fn(|lane| t[lane] + part[lane]));
    let middle = at(&half);
    // Every slope is written before it is read.
    let mut k = [*start; 4];
    dry.begin(flow, start, &flow.input(t), &mut k[0], lanes);
    for stage in 1..3 {
        if lanes.over() {
            return (*start, None);
        }
        let point = along(start, &k[stage - 1], &half);
        flow.slope(&point, &middle, dry, &mut k[stage], lanes);
    }
    if lanes.over() {
        return (*start, None);
    }
    flow.slope(&along(start, &k[2], h), &at(h), dry, &mut k[3], lanes);
    let end = start.combine(k.each_ref(), |lane, x, k| x + (k[0] + 2.0 * (k[1] + k[2]) + k[3]) * (h[lane] / 6.0));
    if flow.rough().is_none() {
        return (end, None);
    }
    shortened(dry, &Curve { start, end: &end, first: &k[0], last: Some(&k[3]), fourth: None, h }, among)
}

/// Ends the step of each of these lanes at its first event. Returns the points and, if there was any event, the fractions of the step.
#[inline(always)]
fn shortened<Y: Point<N, L>, const N: usize, const L: usize>(
    dry: &Dry<N, L>,
    curve: &Curve<'_, Y, L>,
    among: [bool; L],
) -> (Y, Option<[f64; L]>) {
    match dry.events(curve, among) {
        None => (*curve.end, None),
        Some(events) => (events.cut(curve), Some(events.part)),
    }
}

/// One first-order step, with results as in [`runge_kutta`]. Symplectic for a free arm of constant inertia.
#[inline(always)]
fn semi_implicit_euler<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    flow: &F,
    start: &Y,
    (t, h): (&[f64; L], &[f64; L]),
    dry: &mut Dry<N, L>,
    among: [bool; L],
    lanes: &mut Lanes<L>,
) -> (Y, Option<[f64; L]>) {
    let mut slope = *start;
    dry.begin(flow, start, &flow.input(t), &mut slope, lanes);
    let end = start.kicked(&slope, h);
    if flow.rough().is_none() {
        return (end, None);
    }
    shortened(dry, &Curve { start, end: &end, first: &slope, last: None, fourth: None, h }, among)
}

/// Integrates the lanes of a mask with steps as long as their tolerances allow.
#[inline(always)]
fn adapt<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    flow: &F,
    point: &mut Y,
    plans: &mut [Option<Plan>; L],
    mask: [bool; L],
    lanes: &mut Lanes<L>,
    each: &mut impl FnMut(&Step<'_, Y>),
) {
    let of = |f: fn(&Plan) -> f64| plans.each_ref().map(|plan| plan.as_ref().map_or(0.0, f));
    let tolerance = of(|plan| match plan.integrator {
        Integrator::Adaptive { tolerance } => tolerance,
        Integrator::RungeKutta | Integrator::SemiImplicitEuler => 1.0,
    });
    let (mut t, to, mut next) = (of(|plan| plan.stretch.from), of(|plan| plan.stretch.to), of(|plan| plan.next));
    let mut there = mask.map(|asked| !asked);
    lanes.active = mask;
    let mut slope = *point;
    let (mut dry, mut events_left) = (Dry::none(), [EVENTS_MAX; L]);
    dry.begin(flow, point, &flow.input(&t), &mut slope, lanes);
    for _ in 0..ATTEMPTS_MAX {
        lanes.active = there.map(|there| !there);
        if lanes.over() {
            break;
        }
        let left: [f64; L] = core::array::from_fn(|lane| to[lane] - t[lane]);
        // A remainder of the size of a rounding error gets no step.
        let last: [bool; L] = core::array::from_fn(|lane| next[lane] >= left[lane] * (1.0 - 1e-9));
        let h = core::array::from_fn(|lane| if last[lane] { left[lane] } else { next[lane] });
        let among = core::array::from_fn(|lane| lanes.active[lane] && events_left[lane] > 0);
        let mut tried = *lanes;
        let EmbeddedPair { end, slope: slope_after, error, part } =
            dormand_prince(flow, (point, &slope), (&t, &h), &tolerance, (&mut dry, among), &mut tried);
        let (live, mut done, mut cut) = (lanes.live(), [false; L], [false; L]);
        for lane in (0..L).filter(|&lane| live[lane]) {
            let error = match tried.failed[lane] {
                None => error[lane],
                // A stage can be so far out that its position has no sine. Then the step is too long, and a shorter one is tried.
                Some(Diverged::NotFinite) => f64::INFINITY,
                Some(why) => {
                    lanes.fail(lane, why);
                    continue;
                }
            };
            let factor = factor(error);
            done[lane] = error <= 1.0;
            if done[lane] {
                let part = part.map_or(1.0, |part| part[lane]);
                cut[lane] = part < 1.0;
                // The end of the interval may have shortened the last step. Then the longer next step is kept.
                next[lane] = if last[lane] { next[lane].max(h[lane] * factor) } else { h[lane] * factor };
                let passed = part * h[lane];
                each(&Step { t: t[lane], h: passed, before: point, after: &end });
                t[lane] += passed;
                events_left[lane] -= u32::from(cut[lane]);
                there[lane] = if cut[lane] { t[lane] >= to[lane] } else { last[lane] };
            } else {
                next[lane] = h[lane] * factor.min(0.9);
            }
        }
        point.take(&end, &done);
        slope.take(&slope_after, &done);
        dry.keep_margin(done);
        if cut.contains(&true) {
            lanes.active = cut;
            dry.begin(flow, point, &flow.input(&t), &mut slope, lanes);
        }
    }
    lanes.active = there.map(|there| !there);
    for lane in 0..L {
        lanes.fail(lane, Diverged::ToleranceOutOfReach);
        if let Some(plan) = plans[lane].as_mut().filter(|_| mask[lane]) {
            plan.next = next[lane];
        }
    }
}

#[cfg(test)]
mod tests;
