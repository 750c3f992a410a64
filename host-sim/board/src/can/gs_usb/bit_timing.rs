//! Limits of an adapter's bit timing, and the timing for 1 Mbit/s.
//!
//! A bit is `1 + tseg1 + tseg2` quanta; a quantum is `brp` periods of the adapter's clock. The bit is sampled after `1 + tseg1` quanta.

/// Bit rate, bit/s.
const RATE: u32 = 1_000_000;

/// Smallest number of quanta of a bit (ISO 11898-1).
const QUANTA_MIN: u32 = 8;

/// Range of the sample point, per mille of a bit. The aim is 875.
const SAMPLED: core::ops::RangeInclusive<u32> = 750..=900;

/// Bytes of the answer with the limits.
pub(super) const LIMITS_BYTES: u16 = 40;

/// Features and limits of an adapter (`gs_device_bt_const`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limits {
    /// Feature bits.
    pub(super) features: u32,
    /// Clock of the CAN controller, Hz.
    pub(super) clock_hz: u32,
    /// Range of `tseg1`, quanta.
    pub(super) tseg1: (u32, u32),
    /// Range of `tseg2`, quanta.
    pub(super) tseg2: (u32, u32),
    /// Largest jump width, quanta.
    pub(super) sjw_max: u32,
    /// Smallest and largest divider of the clock, and its step.
    pub(super) brp: (u32, u32, u32),
}

impl Limits {
    /// Reads the answer; `None` if it is too short.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let words = bytes.get(..usize::from(LIMITS_BYTES))?.as_chunks::<4>().0;
        let word = |at: usize| words.get(at).copied().map(u32::from_le_bytes);
        Some(Self {
            features: word(0)?,
            clock_hz: word(1)?,
            tseg1: (word(2)?, word(3)?),
            tseg2: (word(4)?, word(5)?),
            sjw_max: word(6)?,
            brp: (word(7)?, word(8)?, word(9)?),
        })
    }

    /// The timing for 1 Mbit/s with the most quanta; `None` if the clock allows none with a sample point from 75 % to 90 %.
    pub(super) fn timing(&self) -> Option<BitTiming> {
        let (least, most, step) = self.brp;
        // A longer divider leaves fewer than eight quanta.
        let most = most.min(self.clock_hz / (RATE * QUANTA_MIN));
        (least.max(1)..=most).step_by(step.max(1) as usize).find_map(|brp| self.timing_with(brp))
    }

    fn timing_with(&self, brp: u32) -> Option<BitTiming> {
        if !self.clock_hz.is_multiple_of(RATE * brp) {
            return None;
        }
        let quanta = self.clock_hz / (RATE * brp);
        // An eighth of the bit, rounded, within the limits. Wrong limits have no value within.
        let tseg2 = ((quanta + 4) / 8).max(self.tseg2.0).min(self.tseg2.1).max(1);
        let tseg1 = quanta.checked_sub(1)?.checked_sub(tseg2)?;
        let sampled = (1 + tseg1) * 1000 / quanta;
        let fits = (self.tseg1.0..=self.tseg1.1).contains(&tseg1)
            && (self.tseg2.0..=self.tseg2.1).contains(&tseg2)
            && SAMPLED.contains(&sampled);
        // As Linux divides it; a controller adds both.
        let prop_seg = tseg1 / 2;
        let phase_seg1 = tseg1 - prop_seg;
        let sjw = self.sjw_max.min(tseg2).min(phase_seg1).max(1);
        fits.then_some(BitTiming { prop_seg, phase_seg1, phase_seg2: tseg2, sjw, brp })
    }
}

/// Bit timing (`gs_device_bittiming`), in quanta but for the divider of the clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BitTiming {
    /// First part of `tseg1`.
    pub(super) prop_seg: u32,
    /// Second part of `tseg1`.
    pub(super) phase_seg1: u32,
    /// `tseg2`.
    pub(super) phase_seg2: u32,
    /// Largest correction of a bit's length.
    pub(super) sjw: u32,
    /// Divider of the clock.
    pub(super) brp: u32,
}

impl BitTiming {
    /// Data of the request that sets it.
    pub(super) fn bytes(&self) -> Vec<u8> {
        [self.prop_seg, self.phase_seg1, self.phase_seg2, self.sjw, self.brp]
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .collect()
    }
}
