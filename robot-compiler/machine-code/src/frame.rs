//! Frame: inputs, numbers, values without a register, and outputs; each place holds one number for every lane.

use crate::registers::Allocation;

/// A cache line, so that no vector lies across two.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Line([f64; 8]);

/// The memory of one kernel.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    lines: Vec<Line>,
    lanes: usize,
    inputs: usize,
    /// Place of each output.
    outputs: Vec<usize>,
}

impl Frame {
    /// A frame with the allocation's numbers in place, and zero everywhere else; `lanes` is four or eight.
    pub(crate) fn new(allocation: &Allocation, lanes: usize) -> Self {
        let lines = vec![Line([0.0; 8]); (allocation.places * lanes).div_ceil(8)];
        let mut frame = Self { lines, lanes, inputs: allocation.inputs, outputs: allocation.outputs.clone() };
        for &(place, number) in &allocation.numbers {
            frame.place_mut(place).fill(number);
        }
        frame
    }

    /// One input.
    pub(crate) fn input(&mut self, number: usize) -> &mut [f64] {
        if number < self.inputs { self.place_mut(number) } else { &mut [] }
    }

    /// One output.
    pub(crate) fn output(&self, number: usize) -> &[f64] {
        self.outputs.get(number).map_or(&[], |&place| self.place(place))
    }

    /// Start of the memory, and its size in bytes.
    pub(crate) fn memory(&mut self) -> (*mut u8, usize) {
        (self.lines.as_mut_ptr().cast(), size_of_val(self.lines.as_slice()))
    }

    fn place(&self, place: usize) -> &[f64] {
        let start = place * self.lanes % 8;
        self.lines.get(place * self.lanes / 8).map_or(&[], |line| &line.0[start..start + self.lanes])
    }

    fn place_mut(&mut self, place: usize) -> &mut [f64] {
        let (lanes, start) = (self.lanes, place * self.lanes % 8);
        self.lines.get_mut(place * lanes / 8).map_or(&mut [], |line| &mut line.0[start..start + lanes])
    }
}
