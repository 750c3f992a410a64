//! Exception numbers of the emulated board, and the core's interrupt masks.

use chip_image::{Effect, Instruction};

/// The link's receiver, USART2.
pub const BYTE: u16 = 16 + 38;

/// The control tick, TIM3.
pub const TICK: u16 = 16 + 29;

/// The interrupt that serves the link: the vector of EXTI0, which no peripheral uses.
pub const SERVE: u16 = 16 + 6;

/// Half of the receive buffer has been filled by DMA: DMA1's stream 5.
pub const HALF_FILLED: u16 = 16 + 16;

/// A piece of the queue has been sent by DMA: DMA1's stream 6.
pub const SENT: u16 = 16 + 17;

/// State of the core's mask registers.
///
/// | register | blocks |
/// |---|---|
/// | PRIMASK | every interrupt |
/// | BASEPRI, unless 0 | every interrupt with this priority number or a greater one |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mask {
    all: bool,
    from: u8,
}

/// An instruction that changes the mask: Arm v7-M Architecture Reference Manual, B5.2.1 (CPS) and B5.2.3 (MSR).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// `CPSID i` (true), `CPSIE i` (false).
    All(bool),
    /// `MSR PRIMASK, Rn`; holds the register's number.
    AllBy(usize),
    /// `MSR BASEPRI, Rn`; holds the register's number.
    FromBy(usize),
    /// `MSR BASEPRI_MAX, Rn`, which can only raise the mask; holds the register's number.
    RaiseBy(usize),
}

impl Change {
    fn of(instruction: &Instruction) -> Option<Self> {
        let by = instruction.reads.numbers().next();
        match instruction.effect {
            Effect::Mask(all) => Some(Self::All(all)),
            Effect::ToSpecial(16) => by.map(Self::AllBy),
            Effect::ToSpecial(17) => by.map(Self::FromBy),
            Effect::ToSpecial(18) => by.map(Self::RaiseBy),
            _ => None,
        }
    }
}

impl Mask {
    /// The mask after an instruction; `registers` holds the values before it.
    #[must_use]
    pub fn after(self, instruction: &Instruction, registers: &[u32; 16]) -> Self {
        // BASEPRI has eight bits; PRIMASK has only the lowest one.
        let byte = |by: usize| registers[by] as u8;
        match Change::of(instruction) {
            None => self,
            Some(Change::All(all)) => Self { all, ..self },
            Some(Change::AllBy(by)) => Self { all: registers[by] & 1 == 1, ..self },
            Some(Change::FromBy(by)) => Self { from: byte(by), ..self },
            Some(Change::RaiseBy(by)) => {
                let raises = byte(by) != 0 && (self.from == 0 || byte(by) < self.from);
                Self { from: if raises { byte(by) } else { self.from }, ..self }
            }
        }
    }

    /// True if an interrupt of this priority must wait.
    #[must_use]
    pub const fn holds_off(self, priority: u8) -> bool {
        self.all || (self.from != 0 && self.from <= priority)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::Mask;
    use chip_image::{Instruction, Program};

    /// As the assembler encodes them: `cpsid i`, `cpsie i`, `msr BASEPRI, r4`, `msr BASEPRI_MAX, r4`, `msr PRIMASK, r4`.
    const CPSID: [u16; 2] = [0xb672, 0];
    const CPSIE: [u16; 2] = [0xb662, 0];
    const TO_BASEPRI: [u16; 2] = [0xf384, 0x8811];
    const TO_BASEPRI_MAX: [u16; 2] = [0xf384, 0x8812];
    const TO_PRIMASK: [u16; 2] = [0xf384, 0x8810];

    fn decoded(halves: [u16; 2]) -> Instruction {
        Program::from_halves(0, &halves).decode(0).unwrap()
    }

    fn r4(value: u32) -> [u32; 16] {
        std::array::from_fn(|i| if i == 4 { value } else { 0xffff_ffff })
    }

    #[test]
    fn primask_holds_off_everything_until_it_is_cleared() {
        let mask = Mask::default().after(&decoded(CPSID), &r4(0));
        assert!(mask.holds_off(0) && mask.holds_off(0xf0));
        assert!(!mask.after(&decoded(CPSIE), &r4(0)).holds_off(0xf0));
        assert!(!mask.after(&decoded(TO_PRIMASK), &r4(0)).holds_off(0));
        assert!(Mask::default().after(&decoded(TO_PRIMASK), &r4(1)).holds_off(0));
    }

    #[test]
    fn basepri_holds_off_what_is_not_more_urgent_and_zero_nothing() {
        let mask = Mask::default().after(&decoded(TO_BASEPRI), &r4(0xe0));
        assert!(mask.holds_off(0xe0) && mask.holds_off(0xf0) && !mask.holds_off(0xd0));
        assert!(!mask.after(&decoded(TO_BASEPRI), &r4(0)).holds_off(0xff));
    }

    #[test]
    fn basepri_max_only_raises() {
        let mask = Mask::default().after(&decoded(TO_BASEPRI_MAX), &r4(0xd0));
        assert_eq!(mask.after(&decoded(TO_BASEPRI_MAX), &r4(0xe0)), mask);
        assert_eq!(mask.after(&decoded(TO_BASEPRI_MAX), &r4(0)), mask);
        assert!(mask.after(&decoded(TO_BASEPRI_MAX), &r4(0xc0)).holds_off(0xc0));
    }

    #[test]
    fn other_instructions_leave_it() {
        // msr CONTROL, r4; nop; mrs r4, BASEPRI
        for halves in [[0xf384, 0x8814], [0xbf00, 0], [0xf3ef, 0x8411]] {
            assert_eq!(Mask::default().after(&decoded(halves), &r4(1)), Mask::default());
        }
    }
}
