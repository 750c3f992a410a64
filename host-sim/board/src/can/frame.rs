//! A classic CAN frame.

use embedded_can::{ExtendedId, Frame, Id, StandardId};

/// Largest number of data bytes.
pub const BYTES_MAX: usize = 8;

/// A classic CAN frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanFrame {
    id: Id,
    data: [u8; BYTES_MAX],
    /// Number of data bytes, or those that a remote frame requests.
    length: u8,
    remote: bool,
}

impl CanFrame {
    /// The frame with this raw identifier; `None` if the identifier has too many bits, or there are more than eight bytes.
    #[must_use]
    pub fn of(raw: u32, extended: bool, data: &[u8]) -> Option<Self> {
        Self::new(id(raw, extended)?, data)
    }

    /// The identifier's number.
    #[must_use]
    pub fn raw_id(&self) -> u32 {
        match self.id {
            Id::Standard(id) => u32::from(id.as_raw()),
            Id::Extended(id) => id.as_raw(),
        }
    }
}

/// The identifier with this number.
pub(super) fn id(raw: u32, extended: bool) -> Option<Id> {
    if extended {
        ExtendedId::new(raw).map(Id::Extended)
    } else {
        StandardId::new(u16::try_from(raw).ok()?).map(Id::Standard)
    }
}

impl Frame for CanFrame {
    fn new(id: impl Into<Id>, bytes: &[u8]) -> Option<Self> {
        let mut data = [0; BYTES_MAX];
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(Self { id: id.into(), data, length: bytes.len() as u8, remote: false })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        let length = u8::try_from(dlc).ok().filter(|&length| usize::from(length) <= BYTES_MAX)?;
        Some(Self { id: id.into(), data: [0; BYTES_MAX], length, remote: true })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        if self.remote { &[] } else { self.data.get(..self.dlc()).unwrap_or_default() }
    }
}
