//! Frames to and from the buses.

use super::joint::CanJoint;
use super::limits::{RECEIVED_MAX, TRANSMIT_POLLS};
use crate::can_bus::CanBus;
use crate::frames::{Frames, Packet};
use crate::queued::OUT;
use dynamics_core::drive::MitDrive;
use embedded_can::{Frame, Id};

/// Joints by decreasing identifier; of equal ones (on two buses) the first joint first.
pub(super) fn sending_order<const N: usize>(drives: &[MitDrive; N]) -> [u8; N] {
    let mut order: [u8; N] = core::array::from_fn(|i| i as u8);
    sort_few(&mut order, |&i| drives.get(usize::from(i)).map(|drive| core::cmp::Reverse(drive.id)));
    order
}

/// Sorts a few items by a key, smallest first, by insertion. Items with equal keys keep their order. The sorts of `core` consist of four algorithms
/// for long slices; there are at most six joints.
pub(super) fn sort_few<T, K: Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    for last in 1..items.len() {
        for place in (1..=last).rev() {
            let Some([before, item]) = items.get_mut(place - 1..=place) else { break };
            if key(before) <= key(item) {
                break;
            }
            core::mem::swap(before, item);
        }
    }
}

/// Rank of an identifier in arbitration: the lower rank is sent first. A standard identifier is sent before extended ones with the same first 11
/// bits.
pub(super) fn rank(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 18,
        Id::Extended(id) => id.as_raw(),
    }
}

/// Fate of a frame that was given to a bus.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sent {
    /// It waits to be sent.
    Queued,
    /// It waits, and has displaced the frame with this identifier.
    InPlaceOf(Id),
    /// The transmitter is full or has an error.
    Refused,
}

/// Queues one command.
pub(super) fn transmit<B: CanBus>(bus: &mut B, packet: &Packet) -> Sent {
    // Eight bytes always fit into a frame.
    let Some(frame) = B::Frame::new(packet.id, &packet.data) else { return Sent::Refused };
    for _ in 0..TRANSMIT_POLLS {
        match bus.transmit(&frame) {
            Ok(None) => return Sent::Queued,
            Ok(Some(other)) => return Sent::InPlaceOf(other.id()),
            Err(nb::Error::WouldBlock) => {}
            Err(nb::Error::Other(_)) => return Sent::Refused,
        }
    }
    Sent::Refused
}

/// Records that a frame with this identifier was not sent, for the joint that it was for. A Damiao's frame about a setting has an identifier that
/// belongs to no joint and is not recorded.
pub(super) fn drop_frame<F: Frames, const N: usize>(
    id: Id,
    bus: u8,
    drives: &[MitDrive; N],
    joints: &mut [CanJoint; N],
) {
    let to = F::receiver(id);
    let mut ours = drives.iter().zip(joints).filter(|(drive, _)| drive.bus == bus && u32::from(drive.id) == to);
    if let Some((_, joint)) = ours.next() {
        joint.dropped();
    }
}

/// Empties a bus's receiver. Returns true if the bus is off.
pub(super) fn collect<F: Frames, B: CanBus, const N: usize>(
    bus: &mut B,
    index: u8,
    drives: &[MitDrive; N],
    joints: &mut [CanJoint; N],
) -> bool {
    for _ in 0..RECEIVED_MAX {
        match bus.receive() {
            Ok(frame) => take_frame::<F, B::Frame, N>(&frame, index, drives, joints),
            Err(nb::Error::WouldBlock) => break,
            Err(nb::Error::Other(_)) => {}
        }
    }
    for _ in 0..OUT {
        let Some(id) = bus.dropped() else { break };
        drop_frame::<F, N>(id, index, drives, joints);
    }
    bus.is_off()
}

/// Passes a frame to its sender's joint. A frame that no joint accepts is ignored.
pub(super) fn take_frame<F: Frames, T: Frame, const N: usize>(
    frame: &T,
    index: u8,
    drives: &[MitDrive; N],
    joints: &mut [CanJoint; N],
) {
    let id = frame.id();
    let data = if frame.is_data_frame() { frame.data() } else { &[] };
    let ours = drives.iter().zip(joints).filter(|(drive, _)| drive.bus == index && F::answers(drive, id));
    for (drive, joint) in ours {
        if F::NOTICES
            && let Some(notice) = F::notice(drive, id, data)
        {
            joint.take_notice(notice);
            return;
        }
        if let Some(setting) = F::setting(drive, id, data) {
            if joint.take_setting(setting) {
                return;
            }
        } else if let Some(reply) = F::reply(drive, id, data) {
            joint.take::<F>(&reply, drive);
            return;
        }
    }
}
