//! Search for the states with the largest value of a function: random states, then climbs from the worst.

use super::region::{Region, State, clamped};
use indicatif::ProgressBar;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use sim::parallel::in_parallel;

/// Effort of a search for a large error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Number of random states.
    pub samples: usize,
    /// Number of climbs for every joint.
    pub climbs: usize,
    /// Number of steps in each climb.
    pub steps: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// The largest value found for a joint, and its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestError<const N: usize> {
    /// Value, N m or N.
    pub value: f64,
    /// State with that value.
    pub state: State<N>,
}

/// Number of random states per lot. Each lot has its own random stream, so that the states do not depend on the number of threads.
const LOT: usize = 1000;

/// Random states of a region for one lot. In every second state each input is, at random, at an end of its range or anywhere in it.
pub fn random_states<const N: usize>(region: &Region<N>, seed: u64, lot: usize) -> impl Iterator<Item = State<N>> {
    let (region, mut random) = (*region, generator(seed, lot as u64));
    (0..LOT).map(move |k| {
        region.state(|| {
            let share = share(&mut random);
            match (k % 2, random.next_u32() % 4) {
                (1, 0) => 0.0,
                (1, 1) => 1.0,
                _ => share,
            }
        })
    })
}

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random
}

/// Random number from 0 to 1.
fn share(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Finds the states in which `what` is largest for each joint: random states, then climbs from the worst.
pub fn search<const N: usize>(
    region: &Region<N>,
    effort: &Effort,
    what: &(dyn Fn(&State<N>) -> [f64; N] + Sync),
    progress: &ProgressBar,
) -> [LargestError<N>; N] {
    let lots = effort.samples.div_ceil(LOT).max(1);
    let worst_of_lot = |lot: usize| {
        let mut worst: Option<[LargestError<N>; N]> = None;
        for state in random_states(region, effort.seed, lot) {
            let value = what(&state);
            let worst = worst.get_or_insert_with(|| value.map(|value| LargestError { value, state }));
            for (worst, value) in worst.iter_mut().zip(value) {
                if value > worst.value {
                    *worst = LargestError { value, state };
                }
            }
        }
        progress.inc(LOT as u64);
        worst
    };
    let lots: Vec<[LargestError<N>; N]> = in_parallel(lots, worst_of_lot).into_iter().flatten().collect();
    core::array::from_fn(|joint| {
        let mut starts: Vec<LargestError<N>> = lots.iter().map(|lot| lot[joint]).collect();
        starts.sort_by(|a, b| b.value.total_cmp(&a.value));
        let first = starts[0];
        let climbs: Vec<LargestError<N>> = in_parallel(effort.climbs, |k| {
            let stream = (1 << 40) + (joint * effort.climbs + k) as u64;
            let start = starts[k % starts.len()];
            let top = climb(region, start, effort.steps, generator(effort.seed, stream), |state| what(state)[joint]);
            progress.inc(effort.steps as u64);
            top
        });
        climbs.into_iter().fold(first, |best, next| if next.value > best.value { next } else { best })
    })
}

/// Climbs with steps in random directions, which change at most three inputs at a time. Steps range from a third of the range down to a few units in
/// the last place. The error grows with the torques but jumps from float to float; large steps explore the first, small steps the second.
fn climb<const N: usize>(
    region: &Region<N>,
    start: LargestError<N>,
    steps: usize,
    mut random: ChaCha8Rng,
    what: impl Fn(&State<N>) -> f64,
) -> LargestError<N> {
    let mut best = start;
    for step in 0..steps {
        let size = 0.3 * 10.0_f64.powf(-6.0 * step as f64 / steps as f64);
        let mut state = best.state;
        for _ in 0..=random.next_u32() % 3 {
            let input = random.next_u32() as usize % (3 * N);
            let (lo, hi) = region.inputs[input / N][input % N];
            let entry = match input / N {
                0 => &mut state.q[input % N],
                1 => &mut state.qd[input % N],
                _ => &mut state.qdd[input % N],
            };
            let by = (hi - lo) * size * (2.0 * share(&mut random) - 1.0);
            *entry = clamped(f64::from(*entry) + by, (lo, hi));
        }
        let value = what(&state);
        if value > best.value {
            best = LargestError { value, state };
        }
    }
    best
}
