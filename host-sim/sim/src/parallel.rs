//! Parallel work on all cores, in one place.
//!
//! A parallel iterator is compiled again for every closure and, in a study, for every number of joints. This module is compiled once.

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Results of `work` for the indices below `count`, in their order, computed on all cores.
pub fn in_parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let results: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    share_out(count, &|number| {
        let result = work(number);
        *results[number].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    results.into_iter().filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// As [`in_parallel`], for work that can fail: after a failure, no new work starts.
///
/// # Errors
/// The error of the lowest index that failed.
pub fn try_in_parallel<T: Send, E: Send>(
    count: usize,
    work: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let failed = AtomicBool::new(false);
    let results = in_parallel(count, |number| {
        if failed.load(Ordering::Relaxed) {
            return None;
        }
        let result = work(number);
        failed.fetch_or(result.is_err(), Ordering::Relaxed);
        Some(result)
    });
    results.into_iter().flatten().collect()
}

/// Threads that share work.
#[derive(Debug)]
pub struct Jobs(Option<rayon::ThreadPool>);

impl Jobs {
    /// A pool of this many threads; `None`: one for each core.
    ///
    /// # Errors
    /// The system gives no more threads.
    pub fn new(count: Option<usize>) -> std::io::Result<Self> {
        let pool = count.map(|count| rayon::ThreadPoolBuilder::new().num_threads(count).build()).transpose();
        pool.map(Self).map_err(std::io::Error::other)
    }

    /// Number of threads.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.as_ref().map_or_else(rayon::current_num_threads, rayon::ThreadPool::current_num_threads)
    }

    /// Runs `work` so that its calls of [`in_parallel`] use these threads.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

fn share_out(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

#[cfg(test)]
mod tests {
    use super::{in_parallel, try_in_parallel};

    #[test]
    fn results_stand_in_the_order_of_their_numbers() {
        assert_eq!(in_parallel(1000, |number| number * number), (0..1000).map(|n| n * n).collect::<Vec<_>>());
        assert_eq!(in_parallel(0, |number| number), Vec::<usize>::new());
    }

    #[test]
    fn a_failure_is_reported_and_all_results_are_there_without_one() {
        assert_eq!(try_in_parallel(100, |number| if number == 70 { Err(number) } else { Ok(number) }), Err(70));
        assert_eq!(try_in_parallel(100, Ok::<_, ()>).map(|all| all.len()), Ok(100));
    }
}
