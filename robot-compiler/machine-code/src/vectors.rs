//! Rust code around a kernel, compiled for the same instructions as the kernel.

use crate::Instructions;

/// Work on lanes. A closure would be enough if its inlining were guaranteed.
pub trait Work {
    /// Result of the call.
    type Outcome;

    /// Does the work. Implementations and everything that they call on lanes need `#[inline(always)]`.
    fn run(self) -> Self::Outcome;
}

impl Instructions {
    /// Does some work, compiled for these instructions if the processor has them. No multiplication is fused with an addition, so it has
    /// the same bits.
    ///
    /// Only inlined code is compiled for these instructions.
    #[inline]
    #[expect(unsafe_code, reason = "code for more instructions than every processor has can be called in no other way")]
    pub fn run<W: Work>(self, work: W) -> W::Outcome {
        #[cfg(target_arch = "x86_64")]
        if self.are_here() {
            // SAFETY: the processor has the instructions.
            return unsafe {
                match self {
                    Self::AvxOne | Self::Avx => in_avx(work),
                    Self::Avx512 => in_avx512(work),
                }
            };
        }
        work.run()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
fn in_avx<W: Work>(work: W) -> W::Outcome {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn in_avx512<W: Work>(work: W) -> W::Outcome {
    work.run()
}
