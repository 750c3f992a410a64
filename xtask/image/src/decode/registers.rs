//! Registers, and sets of them.

use std::ops::BitOr;

/// The stack pointer.
pub(super) const SP: u16 = 13;
/// The link register.
pub(super) const LR: u16 = 14;
/// The program counter.
pub(super) const PC: u16 = 15;

/// A set of registers: the core's r0 to r15 and the float unit's s0 to s31.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers(u64);

impl Registers {
    /// The empty set.
    pub const NONE: Self = Self(0);
    /// Number of registers; [`Registers::numbers`] gives numbers below it.
    pub const COUNT: usize = 48;

    /// Set of one core register; `number` is taken modulo 16.
    #[must_use]
    pub const fn core(number: u16) -> Self {
        Self(1 << (number & 15))
    }

    /// Set of core registers, one bit for each.
    #[must_use]
    pub const fn core_list(bits: u16) -> Self {
        Self(bits as u64)
    }

    /// Set of `count` float registers from `first` on; numbers above s31 are ignored.
    #[must_use]
    pub fn float(first: u16, count: u16) -> Self {
        (first..first.saturating_add(count))
            .filter(|number| *number < 32)
            .fold(Self::NONE, |all, s| all | Self(1 << (16 + s)))
    }

    /// True if the two sets share a register.
    #[must_use]
    pub const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Registers of this set that are not in the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Number of registers in the set.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }

    /// Numbers of the registers in the set: 0 to 15 for the core, 16 to 47 for the float unit.
    pub fn numbers(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let number = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (number < Self::COUNT).then_some(number)
        })
    }
}

impl BitOr for Registers {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
