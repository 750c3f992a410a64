//! Integrators: they advance the simulated arm from one instant to the next.
//!
//! The torque is constant over a tick, so the right-hand side jumps between ticks. Every method therefore restarts at
//! each tick, and also inside a tick if a jitter moves the jump there: no step crosses a jump. Dry friction jumps too, where a joint comes
//! to rest or breaks loose; `stiction` ends a step there.
//!
//! Several arms may go side by side, one a lane. Each has its own time, step, method and end; a lane that has arrived waits and keeps its
//! state. The operations of a lane are those of an arm alone.
//!
//! The embedded pair is our own. Two crates, `ode_solvers` 0.6 (another nalgebra, a vector of results allocated in
//! every tick) and `differential-equations` 0.7, accept no right-hand side that can fail. They also compute powers with
//! the platform's library, so that a run would not have the same bits on every machine. A third, `diffsol` 0.18, is
//! made for stiff systems and brings a matrix library.

use super::curve::Curve;
use super::flow::{Dry, Flow};
use super::state::{Diverged, Lanes, Point};
use super::stiction::EVENTS_MAX;
use robot_compiler::scene::Integrator;

/// Limit on the adaptive method's steps in a tick, accepted or not.
const ATTEMPTS_MAX: u32 = 100_000;

/// A part of a tick without a jump, s, and its number of steps.
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
    /// The adaptive method's next step, s.
    pub(super) next: f64,
}

/// Advance every lane with a plan along its stretch and call `each` after every step of a lane. Returns why a lane could not be
/// continued; `point` then holds its last good state. The plans' next steps are renewed.
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

/// Advance the lanes of a mask in steps of the length that their plans say. A step that ends early, by an event, is one step more; those
/// that follow are evenly shorter.
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
    // Steps of one length from an instant on: their start, length, number, and how many of them are over.
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
                // A rounding error gets no step of its own.
                (steps[lane], over[lane]) = (libm::ceil(left / whole[lane] - 1e-9).max(0.0) as u32, 0);
                h[lane] = left / f64::from(steps[lane].max(1));
            }
        }
        point.take(&after, &done);
    }
}

/// `start + slope * h`.
#[inline(always)]
fn along<Y: Point<N, L>, const N: usize, const L: usize>(start: &Y, slope: &Y, h: &[f64; L]) -> Y {
    start.combine([slope], |lane, x, [k]| x + k * h[lane])
}

/// One classical fourth-order step from `t` (s into the tick), of length `h`, or as far as to the first event. Returns the points there, and
/// the parts of the step that were passed if an event ended the step of a lane.
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

/// The end of a step, brought to the first event of each of these lanes, and the parts of the step up to it if there is any.
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

/// One step of first order, symplectic for a free arm of constant inertia, as [`runge_kutta`] otherwise.
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

/// `sum a_i k_i`.
#[inline(always)]
fn sum<const K: usize>(a: [f64; K], k: [f64; K]) -> f64 {
    a.into_iter().zip(k).fold(0.0, |sum, (a, k)| sum + a * k)
}

/// A step of the embedded pair: the points of fifth order, their slopes, and the errors of the points of fourth order relative to the
/// tolerances. The points are those of the first event in the step, if there is any; then the parts of the step are given.
struct EmbeddedPair<Y, const L: usize> {
    end: Y,
    slope: Y,
    error: [f64; L],
    part: Option<[f64; L]>,
}

/// One step of Dormand and Prince's pair from `t` of length `h`. (J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta
/// formulae, 1980.)
#[inline(always)]
fn dormand_prince<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    flow: &F,
    (start, k1): (&Y, &Y),
    (t, h): (&[f64; L], &[f64; L]),
    tolerance: &[f64; L],
    (dry, among): (&mut Dry<N, L>, [bool; L]),
    lanes: &mut Lanes<L>,
) -> EmbeddedPair<Y, L> {
    // Every slope is written before it is read.
    let [mut k2, mut k3, mut k4, mut k5, mut k6, mut k7] = [*k1; 6];
    let mut slope = |c: f64, at: &Y, k: &mut Y| {
        if !lanes.over() {
            flow.slope(at, &flow.input(&core::array::from_fn(|lane| t[lane] + c * h[lane])), dry, k, lanes);
        }
    };
    slope(1.0 / 5.0, &along(start, k1, &h.map(|h| h / 5.0)), &mut k2);
    let at = start.combine([k1, &k2], |lane, x, k| x + h[lane] * sum([3.0 / 40.0, 9.0 / 40.0], k));
    slope(3.0 / 10.0, &at, &mut k3);
    const A4: [f64; 3] = [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0];
    slope(4.0 / 5.0, &start.combine([k1, &k2, &k3], |lane, x, k| x + h[lane] * sum(A4, k)), &mut k4);
    const A5: [f64; 4] = [19_372.0 / 6561.0, -25_360.0 / 2187.0, 64_448.0 / 6561.0, -212.0 / 729.0];
    slope(8.0 / 9.0, &start.combine([k1, &k2, &k3, &k4], |lane, x, k| x + h[lane] * sum(A5, k)), &mut k5);
    const A6: [f64; 5] = [9017.0 / 3168.0, -355.0 / 33.0, 46_732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18_656.0];
    slope(1.0, &start.combine([k1, &k2, &k3, &k4, &k5], |lane, x, k| x + h[lane] * sum(A6, k)), &mut k6);
    const B5: [f64; 5] = [35.0 / 384.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
    let end = start.combine([k1, &k3, &k4, &k5, &k6], |lane, x, k| x + h[lane] * sum(B5, k));
    slope(1.0, &end, &mut k7);
    // The weights of fifth order less the weights of fourth.
    const E: [f64; 6] =
        [71.0 / 57_600.0, -71.0 / 16_695.0, 71.0 / 1920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
    let error = start.combine([&end, k1, &k3, &k4, &k5, &k6, &k7], |lane, x, [end, k @ ..]| {
        // As `f64::max` of a number and anything, which a vector has no instruction for.
        let size = if end.abs() > x.abs() { end.abs() } else { x.abs() };
        h[lane] * sum(E, k) / (tolerance[lane] * (1.0 + size))
    });
    let error = error.largest();
    let curve = Curve { start, end: &end, first: k1, last: Some(&k7), fourth: None, h };
    let Some(events) = flow.rough().and_then(|_| dry.events(&curve, among)) else {
        return EmbeddedPair { end, slope: k7, error, part: None };
    };
    // The interpolant of fourth order (L. F. Shampine, Some practical Runge-Kutta formulas, 1986).
    const D: [f64; 6] = [
        -12_715_105_075.0 / 11_282_082_432.0,
        87_487_479_700.0 / 32_700_410_799.0,
        -10_690_763_975.0 / 1_880_347_072.0,
        701_980_252_875.0 / 199_316_789_632.0,
        -1_453_857_185.0 / 822_651_844.0,
        69_997_945.0 / 29_380_423.0,
    ];
    let fourth = start.combine([k1, &k3, &k4, &k5, &k6, &k7], |lane, _, k| h[lane] * sum(D, k));
    let curve = Curve { fourth: Some(&fourth), ..curve };
    let events = dry.events(&curve, among).unwrap_or(events);
    EmbeddedPair { end: events.cut(&curve), slope: k7, error, part: Some(events.part) }
}

/// Advance the lanes of a mask in steps as long as their tolerances allow.
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
        // A remainder of the size of a rounding error gets no step of its own.
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
                // A stage can be so far out that it has no sine: the step is too long, so try a shorter one.
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
                // The end of the stretch may have cut the last step short; then keep the longer one.
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

/// Ratio of the next step to this one: `0.9 error^(-1/5)`, from a fifth to five.
fn factor(error: f64) -> f64 {
    // Below, the power is beyond the bound and needs no computing.
    const SURELY_FIVE: f64 = 1.8e-4;
    if error < SURELY_FIVE {
        5.0
    } else if error.is_finite() {
        (0.9 * libm::pow(error, -0.2)).clamp(0.2, 5.0)
    } else {
        0.2
    }
}

#[cfg(test)]
mod tests;
