//! Memory that holds the machine code of a kernel, and the one call into it.

use crate::encoding::{END, MIDDLE, encode};
use crate::registers::{Allocation, Instruction, Operand};
use crate::{Instructions, LANES};
use memmap2::{Mmap, MmapMut};

/// Executable code, which reads and writes one frame.
#[derive(Debug)]
pub(crate) struct Code {
    memory: Mmap,
    bytes: usize,
    /// Number of `f64` in the frame that the code uses.
    frame: usize,
    set: Instructions,
}

impl Code {
    /// The code of these instructions; `None` if the system provides no memory for code.
    pub(crate) fn new(allocation: &Allocation, set: Instructions) -> Option<Self> {
        // The safety of the call depends on this check.
        if !allocation.instructions.iter().filter_map(place).all(|place| place < allocation.places) {
            return None;
        }
        let mut bytes = Vec::new();
        for instruction in &allocation.instructions {
            encode(&mut bytes, instruction, set);
        }
        bytes.extend(END);
        let mut memory = MmapMut::map_anon(bytes.len()).ok()?;
        memory.get_mut(..bytes.len())?.copy_from_slice(&bytes);
        // From here on the memory can be executed and no longer written.
        let memory = memory.make_exec().ok()?;
        Some(Self { memory, bytes: bytes.len(), frame: allocation.places * LANES, set })
    }

    /// Size of the code, bytes.
    pub(crate) const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Runs the code on the first vectors of a frame, as many as `vectors`. A frame that is too short is not touched.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[expect(unsafe_code, reason = "there is no other way to call code that was made at run time")]
    pub(crate) fn run(&self, frame: &mut [f64], vectors: usize) {
        if frame.len() < self.frame {
            return;
        }
        let middle = frame.as_mut_ptr().wrapping_add(MIDDLE * LANES);
        // SAFETY: `memory` holds instructions that `encode` wrote and a return. It is executable and never written again, and lives as long
        // as `self`. The instructions are moves, of any alignment, and arithmetic of vector registers, which the calling convention leaves to the
        // callee, and of memory at `middle` and an offset. `new` has checked that these are slots below `places`, all of which are in the
        // frame, which is borrowed for the call; a second vector follows the first in the same slot. `Kernel::with` has checked that the processor
        // has the instructions.
        unsafe {
            let run: extern "sysv64" fn(*mut f64) = core::mem::transmute(self.memory.as_ptr());
            for vector in 0..vectors.min(self.set.vectors()) {
                run(middle.wrapping_add(vector * LANES / 2));
            }
        }
    }

    /// There is no code for this processor.
    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn run(&self, _: &mut [f64], _: usize) {}
}

/// Slot that an instruction reads or writes.
const fn place(instruction: &Instruction) -> Option<usize> {
    match *instruction {
        Instruction::Load { from: place, .. }
        | Instruction::Store { to: place, .. }
        | Instruction::Compute { b: Operand::Place(place), .. } => Some(place),
        Instruction::Compute { b: Operand::Register(_), .. } => None,
    }
}
