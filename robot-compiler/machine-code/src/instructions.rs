//! Instruction sets of processors, and the number of states that are computed in parallel.

/// Number of states computed in parallel.
pub const LANES: usize = 8;

/// Instructions of x86-64 that a processor may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// AVX on one number at a time, sixteen registers: for one state alone.
    AvxOne,
    /// AVX: vectors of four numbers, sixteen registers.
    Avx,
    /// AVX-512: vectors of eight numbers, thirty-two registers.
    Avx512,
}

impl Instructions {
    /// Every set that computes all lanes, the widest first.
    pub const ALL: [Self; 2] = [Self::Avx512, Self::Avx];

    /// Number of vectors needed for all lanes.
    pub(crate) const fn vectors(self) -> usize {
        match self {
            Self::Avx => 2,
            Self::AvxOne | Self::Avx512 => 1,
        }
    }

    /// Number of vector registers.
    pub(crate) const fn registers(self) -> u8 {
        match self {
            Self::AvxOne | Self::Avx => 16,
            Self::Avx512 => 32,
        }
    }

    /// True if this processor has these instructions.
    #[must_use]
    pub fn are_here(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Self::AvxOne | Self::Avx => std::arch::is_x86_feature_detected!("avx"),
            Self::Avx512 => std::arch::is_x86_feature_detected!("avx512f"),
        };
        #[cfg(not(target_arch = "x86_64"))]
        false
    }
}
