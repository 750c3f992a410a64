//! Random states of an arm, one list per joint, for tests and measurements.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_batch::{Float, States};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use robot_compiler::SceneFile;
use std::path::Path;

pub(crate) fn scene(name: &str) -> SceneFile {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    SceneFile::load(&folder.join(format!("{name}.toml"))).unwrap()
}

/// Numbers in [-1, 1), the same in every run.
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new() -> Self {
        Self(ChaCha8Rng::seed_from_u64(1))
    }

    pub(crate) fn next<F: Float>(&mut self) -> F {
        F::from_i32((self.0.next_u32() >> 8) as i32 - (1 << 23)) / F::from_i32(1 << 23)
    }

    fn lists<F: Float, const N: usize>(&mut self, size: i32, count: usize) -> [Vec<F>; N] {
        core::array::from_fn(|_| (0..count).map(|_| F::from_i32(size) * self.next()).collect())
    }
}

/// The lists of many states.
pub(crate) struct Lists<F, const N: usize> {
    q: [Vec<F>; N],
    qd: [Vec<F>; N],
    qdd: [Vec<F>; N],
}

impl<F: Float, const N: usize> Lists<F, N> {
    /// Random lists with `q` within +-3, `qd` within +-2, `qdd` within +-5.
    pub(crate) fn random(random: &mut Random, count: usize) -> Self {
        Self { q: random.lists(3, count), qd: random.lists(2, count), qdd: random.lists(5, count) }
    }

    pub(crate) fn states(&self) -> States<'_, F, N> {
        let [q, qd, qdd] = [&self.q, &self.qd, &self.qdd].map(|lists| lists.each_ref().map(Vec::as_slice));
        States::new(q, qd, qdd).unwrap()
    }

    /// `q`, `qd` and `qdd` of one state.
    pub(crate) fn state(&self, at: usize) -> [[F; N]; 3] {
        [&self.q, &self.qd, &self.qdd].map(|lists| lists.each_ref().map(|list| list[at]))
    }
}

/// Lists for the torques of `count` states, filled with NaN.
pub(crate) fn places<F: Float, const N: usize>(count: usize) -> [Vec<F>; N] {
    core::array::from_fn(|_| vec![F::literal(f64::NAN); count])
}
