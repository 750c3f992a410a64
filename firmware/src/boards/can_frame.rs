//! The CAN frame that the controllers of all boards use.

use embedded_can::Id;

/// A data frame: the only kind that the schedule sends or accepts.
pub struct Frame {
    /// The identifier.
    pub id: Id,
    /// Length of the data, bytes.
    pub length: u8,
    /// The data; bytes after `length` have no meaning.
    pub bytes: [u8; 8],
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        bytes.get_mut(..data.len())?.iter_mut().zip(data).for_each(|(to, from)| *to = *from);
        Some(Self { id: id.into(), length: data.len() as u8, bytes })
    }

    fn new_remote(_id: impl Into<Id>, _dlc: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or(&self.bytes)
    }
}
