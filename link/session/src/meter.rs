//! Cost of a tick: counted exactly, or not reported.

use link::Cost;

/// A free-running counter of work.
pub trait Counter {
    /// Returns the current count, which wraps around.
    fn now(&self) -> u32;

    /// Adds the unit to a count.
    fn cost(count: u32) -> Cost;

    /// Does a fixed piece of work with always the same instructions. [`Meter::new`] tests the counter with it.
    fn exercise(&self);
}

/// Measures the cost of work with a counter that was tested to be exact.
#[derive(Clone, Copy, Debug)]
pub struct Meter<C> {
    counter: C,
    /// Count of an empty measurement; `None` if the counter is unreliable.
    overhead: Option<u32>,
}

impl<C: Counter> Meter<C> {
    /// Tests the counter: it must advance over a fixed piece of work, and by the same amount each time.
    ///
    /// This detects a counter that does not advance (the emulator's cycle counter), and one that follows the host's clock (the emulator's timers,
    /// if it does not count instructions). With such a counter the meter reports no costs. The first two runs warm the caches and are not
    /// compared.
    pub fn new(counter: C) -> Self {
        let runs: [u32; 6] = core::array::from_fn(|_| trial(&counter));
        let start = counter.now();
        let overhead = counter.now().wrapping_sub(start);
        let [_, _, first, rest @ ..] = runs;
        let exact = first > overhead && rest.iter().all(|&run| run == first);
        Self { counter, overhead: exact.then_some(overhead) }
    }

    /// True if costs are reported.
    pub fn is_exact(&self) -> bool {
        self.overhead.is_some()
    }

    /// Does the work and returns its result and cost; the cost is `None` if the counter is unreliable.
    #[inline]
    pub fn measure<R>(&self, work: impl FnOnce() -> R) -> (R, Option<Cost>) {
        let start = self.counter.now();
        let result = work();
        let count = self.counter.now().wrapping_sub(start);
        (result, self.overhead.map(|overhead| C::cost(count.wrapping_sub(overhead))))
    }
}

/// Measures one exercise. Not inlined, so that every run has the same instructions: unrolled copies differ by a move or two.
#[inline(never)]
fn trial<C: Counter>(counter: &C) -> u32 {
    let start = counter.now();
    counter.exercise();
    counter.now().wrapping_sub(start)
}

#[cfg(test)]
mod tests {
    use super::{Cost, Counter, Meter};
    use core::cell::Cell;

    /// A counter that advances by 1 at each reading and by the next number of `steps` at each exercise.
    struct Scripted<'a>(&'a Cell<u32>, &'a [u32], &'a Cell<usize>);

    impl Counter for Scripted<'_> {
        fn now(&self) -> u32 {
            self.0.set(self.0.get().wrapping_add(1));
            self.0.get()
        }
        fn cost(count: u32) -> Cost {
            Cost::Instructions(count)
        }
        fn exercise(&self) {
            let step = self.1[self.2.get() % self.1.len()];
            self.2.set(self.2.get() + 1);
            self.0.set(self.0.get().wrapping_add(step));
        }
    }

    fn cost_of_seven(steps: &[u32]) -> Option<Cost> {
        let (count, turn) = (Cell::new(u32::MAX - 100), Cell::new(0));
        let meter = Meter::new(Scripted(&count, steps, &turn));
        meter.measure(|| count.set(count.get().wrapping_add(7))).1
    }

    #[test]
    fn an_exact_counter_shows_the_work_without_the_measuring() {
        assert_eq!(cost_of_seven(&[100]), Some(Cost::Instructions(7)));
    }

    #[test]
    fn a_counter_that_stands_still_shows_nothing() {
        assert_eq!(cost_of_seven(&[0]), None);
    }

    #[test]
    fn a_counter_that_does_not_repeat_shows_nothing() {
        assert_eq!(cost_of_seven(&[100, 100, 100, 100, 100, 101]), None);
    }
}
