//! Jitter: random offsets from the instants of the clock.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Uniformly distributed random time between zero and a bound, drawn anew in every tick. Its mean is half the bound, and its standard deviation is
/// the bound over `sqrt(12)`.
#[derive(Clone, Debug)]
pub struct Jitter {
    most: f64,
    generator: ChaCha8Rng,
}

/// Instant that a jitter moves. Each has its own stream of random numbers, so neither affects the other or the sensors' noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moved {
    /// The instant of the measurement, moved to before the tick.
    Sampling = 1,
    /// The instant at which the torque takes effect, moved to after the tick.
    Acting = 2,
}

impl Jitter {
    /// Times below `most` (s), less than a control period.
    #[must_use]
    pub fn new(most: f64, seed: u64, moved: Moved) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(moved as u64);
        Self { most, generator }
    }

    /// The next time, s.
    pub(super) fn draw(&mut self) -> f64 {
        self.most * uniform(&mut self.generator, 0.0)
    }
}

/// 53 random bits as a number from zero to one. An offset of a half avoids both ends.
pub(super) fn uniform(generator: &mut ChaCha8Rng, offset: f64) -> f64 {
    ((generator.next_u64() >> 11) as f64 + offset) * f64::EPSILON / 2.0
}
