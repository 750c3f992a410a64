//! Random states of a six-joint arm.

use dynamics_core::Real;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// Position, velocity and desired acceleration of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<S> {
    /// Joint position, rad or m.
    pub q: [S; 6],
    /// Joint velocity, rad/s or m/s.
    pub qd: [S; 6],
    /// Joint acceleration, rad/s^2 or m/s^2.
    pub qdd: [S; 6],
}

/// Number of states for a measurement on the desk: enough that the branch predictor cannot learn the branches of any program.
pub const DESK: usize = 1024;

/// An endless stream of random states, uniform: `q` within +-3, `qd` within +-2, `qdd` within +-5.
///
/// Every number is a multiple of 2^-20, so that f32 represents it exactly and both precisions get the same state. The chip needs no double
/// precision to compute it.
#[derive(Clone, Debug)]
pub struct States(ChaCha8Rng);

impl States {
    /// Creates the stream at its start; it is the same every time.
    #[must_use]
    pub fn new() -> Self {
        Self(ChaCha8Rng::seed_from_u64(1))
    }

    /// Returns the next state.
    pub fn draw<S: Real>(&mut self) -> State<S> {
        State { q: self.joints(3), qd: self.joints(2), qdd: self.joints(5) }
    }

    /// Returns the first `K` states.
    #[must_use]
    pub fn first<S: Real, const K: usize>() -> [State<S>; K] {
        let mut states = Self::new();
        core::array::from_fn(|_| states.draw())
    }

    fn joints<S: Real>(&mut self, size: i32) -> [S; 6] {
        core::array::from_fn(|_| {
            // 21 bits, one of them the sign; at most three more after the multiplication by the size.
            let fraction = (self.0.next_u32() >> 11) as i32 - (1 << 20);
            S::from_i32(size * fraction) / S::from_i32(1 << 20)
        })
    }
}

impl Default for States {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_types, reason = "both precisions are compared, on the desk")]

    use super::{State, States};

    #[test]
    fn both_precisions_get_the_same_states_and_they_fill_their_ranges() {
        let (single, double) = (States::first::<f32, 1000>(), States::first::<f64, 1000>());
        let mut largest = [0.0_f64; 3];
        for (s, d) in single.iter().zip(&double) {
            let wide = |x: [f32; 6]| x.map(f64::from);
            assert_eq!(State { q: wide(s.q), qd: wide(s.qd), qdd: wide(s.qdd) }, *d);
            for (most, all) in largest.iter_mut().zip([d.q, d.qd, d.qdd]) {
                *most = all.iter().fold(*most, |most, x| most.max(x.abs()));
            }
        }
        for (most, bound) in largest.into_iter().zip([3.0, 2.0, 5.0]) {
            assert!(most <= bound && most > 0.99 * bound, "{most} of {bound}");
        }
    }
}
