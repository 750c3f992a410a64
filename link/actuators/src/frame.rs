//! Data frames of a CAN bus.

use embedded_can::{ExtendedId, Id, StandardId};

/// A data frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The identifier: 11 bits, or 29.
    pub id: u32,
    /// True if it has 29 bits.
    pub extended: bool,
    /// Up to eight bytes.
    pub data: Vec<u8>,
}

impl Frame {
    /// A frame with an identifier of 11 bits.
    #[must_use]
    pub fn standard(id: u16, data: Vec<u8>) -> Self {
        Self { id: u32::from(id), extended: false, data }
    }

    /// Rank in arbitration: of two frames the lower one is sent first.
    pub(crate) fn rank(&self) -> u32 {
        if self.extended { self.id } else { self.id << 18 }
    }
}

impl embedded_can::Frame for Frame {
    /// `None` for more than eight bytes.
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let (id, extended) = match id.into() {
            Id::Standard(id) => (u32::from(id.as_raw()), false),
            Id::Extended(id) => (id.as_raw(), true),
        };
        (data.len() <= 8).then(|| Self { id, extended, data: data.to_vec() })
    }

    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        self.extended
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        // An identifier with too many bits does not exist on a wire; it becomes the one of lowest priority, which no actuator has.
        if self.extended {
            ExtendedId::new(self.id).unwrap_or(ExtendedId::MAX).into()
        } else {
            u16::try_from(self.id).ok().and_then(StandardId::new).unwrap_or(StandardId::MAX).into()
        }
    }

    fn dlc(&self) -> usize {
        self.data.len()
    }

    fn data(&self) -> &[u8] {
        &self.data
    }
}

/// Kind of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    /// Switch on.
    Enable,
    /// Switch off.
    Disable,
    /// Clear an error.
    Clear,
    /// Read or write a register or parameter, such as the communication timeout.
    Setting,
    /// Position, velocity, gains and torque.
    Torque,
}
