//! Sensors: noise, quantisation to encoder counts, measurement delay. Each is computed only if the scene asks for it.

use super::State;
use super::jitter::uniform;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::VecDeque;

/// Zero and resolution of one encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counter {
    /// Counts at `q = 0`.
    pub zero: i32,
    /// Joint position per count, rad or m.
    pub per_count: f64,
}

/// Effects of the sensors on the state, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSettings<const N: usize> {
    /// White noise on each position, rms, rad or m.
    pub position_noise: f64,
    /// White noise on each velocity, rms, rad/s or m/s.
    pub velocity_noise: f64,
    /// Encoders: positions come in counts, velocities are not measured.
    pub counters: Option<[Counter; N]>,
    /// Ticks between sampling and delivery.
    pub delay: usize,
}

impl<const N: usize> Default for SensorSettings<N> {
    fn default() -> Self {
        Self { position_noise: 0.0, velocity_noise: 0.0, counters: None, delay: 0 }
    }
}

/// A reading of all joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample<const N: usize> {
    /// Position and velocity, rad and rad/s or m and m/s.
    State(State<N>),
    /// Encoder counts.
    Counts([i32; N]),
}

/// A reading and its age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<const N: usize> {
    /// The sample.
    pub sample: Sample<N>,
    /// Ticks since it was taken.
    pub age_ticks: u32,
}

/// The sensors of an arm. Noise is drawn from ChaCha with 8 rounds, so a seed gives the same run on every machine.
#[derive(Clone, Debug)]
pub struct Sensors<const N: usize> {
    settings: SensorSettings<N>,
    generator: ChaCha8Rng,
    /// Samples that are still delayed, oldest first, with the tick at which they were taken.
    pipe: VecDeque<(u64, Sample<N>)>,
    tick: u64,
}

impl<const N: usize> Sensors<N> {
    /// Sensors that have not sampled yet.
    #[must_use]
    pub fn new(settings: SensorSettings<N>, seed: u64) -> Self {
        Self { settings, generator: ChaCha8Rng::seed_from_u64(seed), pipe: VecDeque::new(), tick: 0 }
    }

    /// Samples the state, once per tick, and delivers the sample that arrives now.
    ///
    /// The first sample is delivered early, while none can have arrived: until then the arm has not moved.
    pub fn read(&mut self, state: &State<N>) -> Reading<N> {
        let sample = self.sample(state);
        if self.settings.delay == 0 {
            return Reading { sample, age_ticks: 0 };
        }
        #[cfg(test)]
        super::calls::count(super::calls::Effect::SensorDelay);
        let now = self.tick;
        self.tick += 1;
        self.pipe.push_back((now, sample));
        if self.pipe.len() > self.settings.delay + 1 {
            self.pipe.pop_front();
        }
        let (taken, sample) = self.pipe.front().copied().unwrap_or((now, sample));
        Reading { sample, age_ticks: u32::try_from(now - taken).unwrap_or(u32::MAX) }
    }

    /// The state with noise added.
    pub fn disturbed(&mut self, state: &State<N>) -> State<N> {
        let SensorSettings { position_noise, velocity_noise, .. } = self.settings;
        State { q: self.with_noise(state.q, position_noise), qd: self.with_noise(state.qd, velocity_noise) }
    }

    fn sample(&mut self, state: &State<N>) -> Sample<N> {
        let SensorSettings { position_noise, velocity_noise, counters, .. } = self.settings;
        let q = self.with_noise(state.q, position_noise);
        match counters {
            Some(counters) => Sample::Counts(core::array::from_fn(|i| counters[i].read(q[i]))),
            None => Sample::State(State { q, qd: self.with_noise(state.qd, velocity_noise) }),
        }
    }

    fn with_noise(&mut self, values: [f64; N], rms: f64) -> [f64; N] {
        if rms > 0.0 { values.map(|x| x + rms * self.normal()) } else { values }
    }

    /// A standard normal random number, by the Box-Muller method; libm's functions give the same bits everywhere.
    fn normal(&mut self) -> f64 {
        #[cfg(test)]
        super::calls::count(super::calls::Effect::Noise);
        // The offset keeps the first number above zero, for the logarithm.
        let radius = libm::sqrt(-2.0 * libm::log(uniform(&mut self.generator, 0.5)));
        radius * libm::cos(core::f64::consts::TAU * uniform(&mut self.generator, 0.0))
    }
}

impl Counter {
    /// The nearest count, saturated to the range of `i32`.
    fn read(&self, q: f64) -> i32 {
        #[cfg(test)]
        super::calls::count(super::calls::Effect::Encoder);
        // `as` saturates, and maps NaN to zero.
        let counts = libm::round(q / self.per_count) as i32;
        counts.saturating_add(self.zero)
    }
}

#[cfg(test)]
mod tests {
    use super::Counter;

    #[test]
    fn counts_are_the_nearest_and_halves_go_away_from_zero() {
        let counter = Counter { zero: 100, per_count: 0.25 };
        let counts = [0.12, 0.125, 0.13, 0.374, 0.375, -0.12, -0.125, -0.374, -0.375].map(|q| counter.read(q) - 100);
        assert_eq!(counts, [0, 1, 1, 1, 2, 0, -1, -1, -2]);
        assert_eq!(
            [f64::INFINITY, f64::NEG_INFINITY, f64::NAN].map(|q| counter.read(q)),
            [i32::MAX, i32::MIN + 100, 100]
        );
    }
}
