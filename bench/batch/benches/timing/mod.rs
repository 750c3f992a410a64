//! Shortest times of several functions. They are measured in turn, so that all run under the same load of the machine.

use std::time::Instant;

/// Number of runs of each function.
const ROUNDS: usize = 300;

/// A name and the function to time.
pub(crate) type Contestant<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// Returns the shortest time of each function, ns, divided by `per`.
pub(crate) fn shortest(contestants: &mut [Contestant<'_>], per: usize) -> Vec<f64> {
    let mut best = vec![f64::INFINITY; contestants.len()];
    for _ in 0..ROUNDS {
        for (best, (_, run)) in best.iter_mut().zip(contestants.iter_mut()) {
            let start = Instant::now();
            run();
            *best = best.min(start.elapsed().as_secs_f64() * 1e9 / per as f64);
        }
    }
    best
}

/// Name of the instruction set that the compiler was allowed to use.
pub(crate) fn instruction_set() -> &'static str {
    if cfg!(target_feature = "avx512f") {
        "AVX-512"
    } else if cfg!(target_feature = "avx2") {
        "AVX2"
    } else if cfg!(target_feature = "sse2") {
        "SSE2"
    } else {
        "no x86 vectors"
    }
}
