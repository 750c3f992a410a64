//! Commands to all drives of a tick.

use super::CanJoints;
use super::bus::{Sent, drop_frame, rank, sort_few, transmit};
use super::limits::Order;
use crate::can_bus::CanBus;
use crate::frames::{Frames, Packet};
use dynamics_core::control::Spring;
use dynamics_core::drive::MitDrive;
use embedded_hal::digital::OutputPin;

impl<F: Frames, A: CanBus, B: CanBus, C: CanBus, P: OutputPin, const N: usize> CanJoints<F, A, B, C, P, N> {
    /// Returns the joint whose drive gets a frame about its communication timeout in this tick. Only one of all joints gets one, because all such
    /// frames of a bus may have the same identifier. Its drive has replied in this tick, is off, and has not confirmed its timeout.
    pub(super) fn next_setting(&mut self, order: &impl Fn(usize) -> Order) -> Option<usize> {
        let needs = |i: usize| {
            let (Some(joint), Some(drive)) = (self.joints.get(i), self.drives.get(i)) else { return false };
            let idle = match order(i) {
                Order::Damp => !joint.powered,
                _ => !joint.on,
            };
            joint.age_ticks == 0 && idle && joint.error == 0 && !joint.timeout.is_settled(drive)
        };
        let found = (self.next_setting..N).chain(0..self.next_setting).find(|&i| needs(i))?;
        self.next_setting = if found + 1 < N { found + 1 } else { 0 };
        Some(found)
    }

    pub(super) fn send_torque(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        let spring = |i: usize| springs.and_then(|springs| springs.get(i).copied());
        self.send_all(|i| torque.get(i).map_or(Order::Off, |&torque| Order::Torque(torque, spring(i))));
    }

    /// Sends every drive a frame that depends on nothing else.
    pub(super) fn send_to_all(&mut self, frame: fn(&MitDrive) -> Packet) {
        self.first.abandon();
        self.second.abandon();
        self.third.abandon();
        for i in self.order.map(usize::from) {
            let packet = self.drives.get(i).map(frame);
            self.send(i, packet.as_ref());
        }
    }

    pub(super) fn send_all(&mut self, order: impl Fn(usize) -> Order) {
        self.first.abandon();
        self.second.abandon();
        self.third.abandon();
        let setting = if self.all_on() { None } else { self.next_setting(&order) };
        let clears = self.clearing > 0;
        self.clearing = self.clearing.saturating_sub(1);
        if !F::COMMAND_IN_IDENTIFIER {
            // The frame about a setting has the highest identifier, so it is queued first.
            if let Some(i) = setting {
                let packet = self.setting_packet(i);
                self.send(i, packet.as_ref());
            }
            for i in self.order.map(usize::from) {
                if setting != Some(i) {
                    let packet = self.packet(i, order(i), clears);
                    self.send(i, packet.as_ref());
                }
            }
            return;
        }
        let mut packets: [(usize, Option<Packet>); N] = core::array::from_fn(|i| {
            (i, if setting == Some(i) { self.setting_packet(i) } else { self.packet(i, order(i), clears) })
        });
        sort_few(&mut packets, |(_, packet)| core::cmp::Reverse(packet.map(|packet| rank(packet.id))));
        for (i, packet) in &packets {
            self.send(*i, packet.as_ref());
        }
    }

    /// Returns the frame that carries out an order to a joint; `None` for a joint that does not exist.
    pub(super) fn packet(&mut self, i: usize, order: Order, clears: bool) -> Option<Packet> {
        Some(self.joints.get_mut(i)?.packet::<F>(self.drives.get(i)?, order, clears))
    }

    /// Returns the frame that reads or writes the communication timeout of a joint's drive.
    #[cold]
    #[inline(never)]
    pub(super) fn setting_packet(&mut self, i: usize) -> Option<Packet> {
        self.joints.get_mut(i)?.setting_packet::<F>(self.drives.get(i)?)
    }

    pub(super) fn send(&mut self, i: usize, packet: Option<&Packet>) {
        let (Some(drive), Some(joint), Some(packet)) = (self.drives.get(i), self.joints.get_mut(i), packet) else {
            return;
        };
        let sent = match drive.bus {
            0 => transmit(&mut self.first, packet),
            1 => transmit(&mut self.second, packet),
            _ => transmit(&mut self.third, packet),
        };
        if sent != Sent::Refused {
            joint.sent();
        }
        if let Sent::InPlaceOf(id) = sent {
            let bus = drive.bus;
            drop_frame::<F, N>(id, bus, &self.drives, &mut self.joints);
        }
    }
}
