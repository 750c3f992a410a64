//! Instructions of a processor, and the states that they take side by side.

/// States side by side.
pub const LANES: usize = 8;

/// Instructions of x86-64 that a processor may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// Vectors of four, sixteen registers.
    Avx,
    /// Vectors of eight, thirty-two registers.
    Avx512,
}

impl Instructions {
    /// Every set, the widest first.
    pub const ALL: [Self; 2] = [Self::Avx512, Self::Avx];

    /// Vectors that all lanes take.
    pub(crate) const fn vectors(self) -> usize {
        match self {
            Self::Avx => 2,
            Self::Avx512 => 1,
        }
    }

    /// Vector registers.
    pub(crate) const fn registers(self) -> u8 {
        match self {
            Self::Avx => 16,
            Self::Avx512 => 32,
        }
    }

    /// True if this processor has them.
    #[must_use]
    pub fn are_here(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Self::Avx => std::arch::is_x86_feature_detected!("avx"),
            Self::Avx512 => std::arch::is_x86_feature_detected!("avx512f"),
        };
        #[cfg(not(target_arch = "x86_64"))]
        false
    }
}
