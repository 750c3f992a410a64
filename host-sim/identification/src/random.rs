//! Random numbers that are the same on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A generator of random numbers.
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A uniform number from 0 to 1.
    pub(crate) fn share(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// A uniform number from -1 to 1.
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }

    /// `count` uniform numbers from `-size` to `size`.
    pub(crate) fn list(&mut self, count: usize, size: f64) -> Vec<f64> {
        (0..count).map(|_| size * self.signed()).collect()
    }

    /// A normally distributed number of mean 0 and standard deviation 1, by the Box-Muller method.
    pub(crate) fn normal(&mut self) -> f64 {
        let mut share = || (f64::from(self.0.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
        (-2.0 * share().ln()).sqrt() * (std::f64::consts::TAU * share()).cos()
    }
}
