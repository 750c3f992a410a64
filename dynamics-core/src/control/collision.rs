//! Collision detection by a momentum observer: it estimates an external torque per joint from the momentum alone, and reacts when one is
//! too large.
//!
//! With the generalised momentum `p = D qd` and `dp/dt = tau + beta + tau_ext`, where `beta = C^T qd - G + J^T w - friction`
//! (module [`crate::momentum`]), the residual
//!
//! ```text
//! r(t) = k (p(t) - p(0) - integral of (tau + beta + r) ds)         dr/dt = k (tau_ext - r)
//! ```
//!
//! is the external torque after a low-pass filter: no acceleration is measured and no inertia matrix inverted. At the control
//! period `h`, with the torque of the last tick held since and `beta` by the trapezoidal rule:
//!
//! ```text
//! I = J + h/2 beta                       up to now
//! r = k (p - I)
//! J = I + h (tau + r) + h/2 beta         tau: torque that this tick commands
//! k = (1 - exp(-bandwidth h)) / h        so that r = exp(-bandwidth h) r + (1 - exp(-bandwidth h)) tau_ext, exactly
//! ```
//!
//! The integral follows the momentum (it is `p - r/k`), so it does not grow with time and single precision does not
//! drift. Everything that the model lacks counts as external: a wrong payload, stiction and friction without
//! feedforward, torque that the drive does not give, the lag of an estimated velocity. The thresholds must lie above
//! all of these; `docs/control/collisions.md` explains how to find them. (De Luca et al., IROS 2006; Haddadin et al., T-RO 2017,
//! section IV.)

use super::momentum_observer::{MomentumFilter, MomentumObserver};
use super::{Friction, FrictionTerms};
use crate::fields::{record, words};
use crate::momentum::GeneralizedMomentum;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::SinCos;

/// Reaction to a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CollisionReaction {
    /// A fault: brake until reset.
    Stop,
    /// The reference stays where the arm was, until reset.
    Hold,
    /// No stiffness: as long as something pushes, the weight is carried and the motion damped. Then as [`CollisionReaction::Hold`], until reset
    /// or the next push.
    Comply,
    /// None: the external torques are reported, and nothing else happens.
    Report,
}

words!(CollisionReaction { Stop = 0, Hold = 1, Comply = 2, Report = 3 });

record! {
    /// Detection of a collision, and the reaction to it.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CollisionConfig<S, const N: usize> {
        /// Bandwidth of the residual.
        pub filter: MomentumFilter<S>,
        /// Residual above which there is a collision, N m or N.
        pub threshold: [S; N],
        /// Residual at the end of a push, half of `threshold`: the push is over once every joint is below it.
        pub released: [S; N],
        /// Number of consecutive ticks with a residual above its threshold that count as a collision.
        pub ticks: u32,
        /// Number of consecutive ticks without a push after which the push is over.
        pub release_ticks: u32,
        /// Reaction to a collision.
        pub reaction: CollisionReaction,
    }
}

/// Source of a collision watch's configuration, like [`super::Configuration`] for the controller's.
pub trait CollisionConfiguration<S, const N: usize> {
    /// The configuration; always the same.
    fn get(&self) -> &CollisionConfig<S, N>;
}

impl<S, const N: usize> CollisionConfiguration<S, N> for CollisionConfig<S, N> {
    #[inline]
    fn get(&self) -> &Self {
        self
    }
}

/// Verdict of a protection on one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict<S, const N: usize> {
    /// Go on.
    Free,
    /// Stop, because of this joint.
    Stop {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// Stop at this position, because of this joint.
    Hold {
        /// Joint position, rad or m.
        q: [S; N],
        /// Joint, counted from 0.
        joint: u8,
    },
    /// Carry the arm's weight and damp, because of this joint.
    Comply {
        /// Joint, counted from 0.
        joint: u8,
    },
}

/// State of the arm in one tick, as a protection sees it.
#[derive(Clone, Copy, Debug)]
pub struct ObservedState<'a, S, const N: usize> {
    /// Joint position, rad or m.
    pub q: &'a [S; N],
    /// Joint velocity, rad/s or m/s.
    pub qd: &'a [S; N],
    /// The scene's live inputs.
    pub live: &'a Live<S, N>,
    /// Friction as the controller feeds it forward.
    pub friction: Option<&'a [Friction<S>; N]>,
    /// Its further terms.
    pub friction_terms: Option<&'a [FrictionTerms<S>; N]>,
}

/// A watch over a controller. [`Unprotected`] adds no instruction.
pub trait Protection<S, const N: usize> {
    /// True if the protection ever looks at the arm. If not, the tick is compiled as if there were no protections.
    const WATCHES: bool = true;

    /// Checks the state of this tick. Returns sine and cosine too if it computed them, so that the tick can reuse
    /// them.
    fn look(
        &mut self,
        seen: &ObservedState<'_, S, N>,
        turn: impl FnOnce() -> [SinCos<S>; N],
    ) -> (Verdict<S, N>, Option<[SinCos<S>; N]>);

    /// Records the torque that this tick commands, N m or N.
    fn drove(&mut self, torque: &[S; N]);

    /// The last estimate of the torque from outside on each joint, N m or N.
    #[inline]
    fn external(&self) -> Option<&[S; N]> {
        None
    }

    /// True if the protection never acts, so that it may watch a hand-guided arm too.
    #[inline]
    fn only_reports(&self) -> bool {
        false
    }

    /// Clears the memory: the next tick is the first.
    fn forget(&mut self);
}

/// No protection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unprotected;

impl<S, const N: usize> Protection<S, N> for Unprotected {
    const WATCHES: bool = false;

    #[inline]
    fn look(
        &mut self,
        _: &ObservedState<'_, S, N>,
        _: impl FnOnce() -> [SinCos<S>; N],
    ) -> (Verdict<S, N>, Option<[SinCos<S>; N]>) {
        (Verdict::Free, None)
    }

    #[inline]
    fn drove(&mut self, _: &[S; N]) {}

    #[inline]
    fn forget(&mut self) {}
}

/// Chosen at run time, by a scene on the desk.
impl<S, const N: usize, P: Protection<S, N>> Protection<S, N> for Option<P> {
    fn look(
        &mut self,
        seen: &ObservedState<'_, S, N>,
        turn: impl FnOnce() -> [SinCos<S>; N],
    ) -> (Verdict<S, N>, Option<[SinCos<S>; N]>) {
        self.as_mut().map_or((Verdict::Free, None), |protection| protection.look(seen, turn))
    }

    fn drove(&mut self, torque: &[S; N]) {
        if let Some(protection) = self {
            protection.drove(torque);
        }
    }

    fn external(&self) -> Option<&[S; N]> {
        self.as_ref()?.external()
    }

    fn only_reports(&self) -> bool {
        self.as_ref().is_some_and(P::only_reports)
    }

    fn forget(&mut self) {
        if let Some(protection) = self {
            protection.forget();
        }
    }
}

/// Watches for collisions by a momentum observer.
///
/// ```text
///         |r| > threshold for `ticks` in a row
/// free ------------------------------------------> stop, hold or comply, as configured
///
///         |r| <= released on every joint for `release_ticks` in a row
/// comply <------------------------------------------------------------> hold
///         |r| > threshold for `ticks` in a row
/// ```
///
/// With [`CollisionReaction::Report`] it stays free. Only [`Protection::forget`] leads back to free: the watch does not know where the
/// reference is now. A residual that is NaN counts as above every threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionWatch<S, const N: usize, M, K = CollisionConfig<S, N>> {
    config: K,
    momentum: M,
    observer: MomentumObserver<S, N>,
    state: WatchState<S, N>,
    /// Consecutive ticks that meet the condition for leaving the state.
    count: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum WatchState<S, const N: usize> {
    Free,
    Stopped { joint: u8 },
    Holding { q: [S; N], joint: u8 },
    Complying { joint: u8 },
}

impl<S: Real, const N: usize, M, K: CollisionConfiguration<S, N>> CollisionWatch<S, N, M, K> {
    /// A watch before its first tick; `momentum` computes the arm's momentum.
    #[must_use]
    pub fn new(config: K, momentum: M) -> Self {
        Self { config, momentum, observer: MomentumObserver::default(), state: WatchState::Free, count: 0 }
    }

    /// The last estimate of the external torques, N m or N.
    #[must_use]
    pub const fn residual(&self) -> &[S; N] {
        self.observer.residual()
    }

    #[inline]
    fn decide(&mut self, q: &[S; N]) -> Verdict<S, N> {
        // Nearly every tick takes this path: comparisons that all succeed.
        if self.state == WatchState::Free && within(self.observer.residual(), &self.config.get().threshold) {
            self.count = 0;
            return Verdict::Free;
        }
        self.react(q)
    }

    #[cold]
    fn react(&mut self, q: &[S; N]) -> Verdict<S, N> {
        let config = self.config.get();
        let residual = self.observer.residual();
        let hit = above(residual, &config.threshold);
        let (speaks, needed) = match self.state {
            WatchState::Free | WatchState::Holding { .. } => (hit.is_some(), config.ticks),
            WatchState::Complying { .. } => (within(residual, &config.released), config.release_ticks),
            WatchState::Stopped { .. } => (false, 0),
        };
        self.count = if speaks { self.count.saturating_add(1) } else { 0 };
        if speaks && self.count >= needed {
            self.count = 0;
            let joint = hit.unwrap_or(0);
            self.state = match (self.state, config.reaction) {
                (WatchState::Complying { joint }, _) => WatchState::Holding { q: *q, joint },
                (WatchState::Free, CollisionReaction::Stop) => WatchState::Stopped { joint },
                (WatchState::Free, CollisionReaction::Hold) => WatchState::Holding { q: *q, joint },
                (WatchState::Free | WatchState::Holding { .. }, CollisionReaction::Comply) => {
                    WatchState::Complying { joint }
                }
                (state, _) => state,
            };
        }
        match self.state {
            WatchState::Free => Verdict::Free,
            WatchState::Stopped { joint } => Verdict::Stop { joint },
            WatchState::Holding { q, joint } => Verdict::Hold { q, joint },
            WatchState::Complying { joint } => Verdict::Comply { joint },
        }
    }
}

/// True if every joint's residual is within the bound. False for NaN.
#[inline]
fn within<S: Real, const N: usize>(residual: &[S; N], bound: &[S; N]) -> bool {
    for i in 0..N {
        let within = residual[i].abs() <= bound[i];
        if !within {
            return false;
        }
    }
    true
}

/// The first joint whose residual is not within the bound.
fn above<S: Real, const N: usize>(residual: &[S; N], bound: &[S; N]) -> Option<u8> {
    let within = |i: usize| residual[i].abs() <= bound[i];
    (0..N).find(|&i| !within(i)).map(|joint| joint as u8)
}

impl<S: Real, const N: usize, M: GeneralizedMomentum<S, N>, K: CollisionConfiguration<S, N>> Protection<S, N>
    for CollisionWatch<S, N, M, K>
{
    #[inline]
    fn look(
        &mut self,
        seen: &ObservedState<'_, S, N>,
        turn: impl FnOnce() -> [SinCos<S>; N],
    ) -> (Verdict<S, N>, Option<[SinCos<S>; N]>) {
        let ObservedState { q, qd, live, friction, friction_terms } = *seen;
        let turn = turn();
        let momentum = self.momentum.momentum(&turn, q, qd, live);
        let lost = match friction {
            Some(friction) => core::array::from_fn(|i| match friction_terms {
                None => friction[i].torque(qd[i]),
                // Without the part that grows with the load, because the torque of this tick is not known yet. The threshold has to cover that part.
                Some(terms) => friction[i].torque_with(&FrictionTerms { load: None, ..terms[i] }, qd[i], S::zero()),
            }),
            None => [S::zero(); N],
        };
        self.observer.observe(&self.config.get().filter, &momentum, &lost);
        (self.decide(q), Some(turn))
    }

    #[inline]
    fn external(&self) -> Option<&[S; N]> {
        Some(self.residual())
    }

    #[inline]
    fn only_reports(&self) -> bool {
        self.config.get().reaction == CollisionReaction::Report
    }

    #[inline]
    fn drove(&mut self, torque: &[S; N]) {
        self.observer.drove(&self.config.get().filter, torque);
    }

    fn forget(&mut self) {
        (self.observer, self.state, self.count) = (MomentumObserver::default(), WatchState::Free, 0);
    }
}
