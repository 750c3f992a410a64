//! States of the simulated arm, or of several arms, one per lane.

/// Position and velocity of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// Joint position, rad or m.
    pub q: [f64; N],
    /// Joint velocity, rad/s or m/s.
    pub qd: [f64; N],
}

/// Reason why the simulation of the arm cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Diverged {
    /// The joint-space inertia matrix has a pivot that is not above zero.
    #[error("the plant's inertia matrix is not positive definite: a joint moves no mass")]
    SingularInertia,
    /// A position or velocity is infinite or NaN, or a position is beyond the range of the sine.
    #[error("the plant's motion has grown beyond all bounds: the loop is unstable, or the step too long")]
    NotFinite,
    /// The adaptive integrator has tried a hundred thousand steps in a tick without reaching the tick's end.
    #[error("the plant's integrator cannot keep its tolerance: something acts too suddenly or too fast")]
    ToleranceOutOfReach,
}

/// States of several arms, one per lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct States<const N: usize, const L: usize> {
    pub(super) q: [[f64; L]; N],
    pub(super) qd: [[f64; L]; N],
}

impl<const N: usize> States<N, 1> {
    /// The state of a single arm.
    pub(super) fn alone(state: &State<N>) -> Self {
        Self { q: state.q.map(|x| [x]), qd: state.qd.map(|x| [x]) }
    }
}

impl<const N: usize, const L: usize> States<N, L> {
    /// The state of the arm in a lane.
    pub(super) fn lane(&self, lane: usize) -> State<N> {
        State { q: self.q.map(|x| x[lane]), qd: self.qd.map(|x| x[lane]) }
    }
}

/// Points of the state space, one per lane, each with positions and velocities.
pub(super) trait Point<const N: usize, const L: usize>: Copy {
    /// Applies `f` to every component: to the lane, the component, and the same component of the other points.
    fn combine<const K: usize>(&self, others: [&Self; K], f: impl Fn(usize, f64, [f64; K]) -> f64) -> Self;

    /// Advances the velocities along the slope, then the positions along the new velocities.
    fn kicked(&self, slope: &Self, h: &[f64; L]) -> Self;

    /// Largest magnitude of a component; NaN if any is NaN.
    fn largest(&self) -> [f64; L];

    /// Copies some lanes from another point.
    fn take(&mut self, other: &Self, lanes: &[bool; L]);

    /// State of the side of the joints on which friction acts.
    fn friction_side(&self) -> &States<N, L>;

    /// As [`Point::friction_side`].
    fn friction_side_mut(&mut self) -> &mut States<N, L>;
}

/// Hides a component's index from the compiler if there are several lanes. If the compiler knew the index, it would build vectors of components,
/// which are not adjacent in memory, instead of vectors of lanes, which are.
#[inline(always)]
fn component<const L: usize>(i: usize) -> usize {
    if L > 1 { core::hint::black_box(i) } else { i }
}

/// One component of all lanes.
#[inline(always)]
fn row<const L: usize, const K: usize>(
    x: &[f64; L],
    others: [&[f64; L]; K],
    f: impl Fn(usize, f64, [f64; K]) -> f64,
) -> [f64; L] {
    let mut to = [0.0; L];
    for lane in 0..L {
        let mut own = [0.0; K];
        for k in 0..K {
            own[k] = others[k][lane];
        }
        to[lane] = f(lane, x[lane], own);
    }
    to
}

impl<const N: usize, const L: usize> Point<N, L> for States<N, L> {
    #[inline(always)]
    fn combine<const K: usize>(&self, others: [&Self; K], f: impl Fn(usize, f64, [f64; K]) -> f64) -> Self {
        let mut to = *self;
        for i in 0..N {
            let i = component::<L>(i);
            let (mut q, mut qd) = ([&self.q[i]; K], [&self.qd[i]; K]);
            for k in 0..K {
                (q[k], qd[k]) = (&others[k].q[i], &others[k].qd[i]);
            }
            to.q[i] = row(&self.q[i], q, &f);
            to.qd[i] = row(&self.qd[i], qd, &f);
        }
        to
    }

    #[inline(always)]
    fn kicked(&self, slope: &Self, h: &[f64; L]) -> Self {
        let mut to = *self;
        for i in 0..N {
            for lane in 0..L {
                to.qd[i][lane] += slope.qd[i][lane] * h[lane];
                to.q[i][lane] += to.qd[i][lane] * h[lane];
            }
        }
        to
    }

    #[inline(always)]
    fn largest(&self) -> [f64; L] {
        let mut most = [0.0; L];
        for x in self.q.iter().chain(&self.qd) {
            for lane in 0..L {
                most[lane] = if x[lane].abs() <= most[lane] { most[lane] } else { x[lane].abs() };
            }
        }
        most
    }

    #[inline(always)]
    fn take(&mut self, other: &Self, lanes: &[bool; L]) {
        for (to, from) in self.q.iter_mut().chain(&mut self.qd).zip(other.q.iter().chain(&other.qd)) {
            for lane in 0..L {
                to[lane] = if lanes[lane] { from[lane] } else { to[lane] };
            }
        }
    }

    #[inline(always)]
    fn friction_side(&self) -> &Self {
        self
    }

    #[inline(always)]
    fn friction_side_mut(&mut self) -> &mut Self {
        self
    }
}

/// Status of the lanes during a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes<const L: usize> {
    /// True for lanes that take part in the present step.
    pub(super) active: [bool; L],
    /// For each lane, the first error that stopped it.
    pub(super) failed: [Option<Diverged>; L],
}

impl<const L: usize> Lanes<L> {
    /// True for lanes that take part and have not failed.
    pub(super) fn live(&self) -> [bool; L] {
        core::array::from_fn(|lane| self.active[lane] && self.failed[lane].is_none())
    }

    /// True if no lane can go on.
    pub(super) fn over(&self) -> bool {
        !self.live().contains(&true)
    }

    /// Marks a lane that takes part as failed; the first error is kept.
    pub(super) fn fail(&mut self, lane: usize, why: Diverged) {
        if self.active[lane] && self.failed[lane].is_none() {
            self.failed[lane] = Some(why);
        }
    }
}
