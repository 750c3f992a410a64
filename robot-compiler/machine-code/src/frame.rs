//! The frame of a kernel: inputs, numbers, values without a register, and outputs. Each slot holds one number for every lane.

use crate::LANES;
use crate::registers::Allocation;

/// Bytes of a cache line; no vector should lie across two.
const CACHE_LINE: usize = 64;

/// The memory of one kernel.
#[derive(Debug)]
pub(crate) struct Frame {
    /// Longer than the used part by one cache line.
    numbers: Vec<f64>,
    /// Index of the first used number, at the start of a cache line.
    start: usize,
    /// Number of used numbers.
    count: usize,
}

impl Frame {
    /// A frame with the allocation's numbers in their slots, and zero everywhere else.
    pub(crate) fn new(allocation: &Allocation) -> Self {
        let mut frame = Self::of(allocation.places * LANES);
        for &(place, number) in &allocation.numbers {
            if let Some(place) = frame.all_mut().get_mut(place * LANES..(place + 1) * LANES) {
                place.fill(number);
            }
        }
        frame
    }

    fn of(count: usize) -> Self {
        let spare = CACHE_LINE / size_of::<f64>();
        let numbers = vec![0.0_f64; count + spare];
        // If the alignment fails, vectors only lie across cache lines.
        let start = numbers.as_ptr().align_offset(CACHE_LINE);
        Self { start: if start <= spare { start } else { 0 }, numbers, count }
    }

    /// All slots, one after another.
    #[inline]
    pub(crate) fn all(&self) -> &[f64] {
        &self.numbers[self.start..self.start + self.count]
    }

    /// All slots, one after another.
    #[inline]
    pub(crate) fn all_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.start..self.start + self.count]
    }
}

impl Clone for Frame {
    fn clone(&self) -> Self {
        let mut clone = Self::of(self.count);
        clone.all_mut().copy_from_slice(self.all());
        clone
    }
}
