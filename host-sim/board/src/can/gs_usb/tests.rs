//! The protocol, and a channel at a simulated adapter.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::adapter::{Adapter, RECEIVED_MAX, UNSENT_MAX};
use super::super::frame::CanFrame;
use super::channel::{GsUsb, UNSENT_FRAMES_MAX};
use super::simulated::SimulatedUsb;
use embedded_can::Frame as _;
use std::io::{self, ErrorKind};

pub(super) fn command(id: u32) -> CanFrame {
    CanFrame::of(id, false, &[1, 2, 3, 4, 5, 6, 7, id as u8]).unwrap()
}

/// A drive that replies with its identifier plus 16.
pub(super) fn reply(frame: &CanFrame) -> Vec<CanFrame> {
    vec![CanFrame::of(frame.raw_id() + 16, false, frame.data()).unwrap()]
}

pub(super) fn opened() -> (SimulatedUsb, GsUsb<SimulatedUsb>) {
    let usb = SimulatedUsb::new(reply);
    let adapter = GsUsb::start(usb.clone(), 0).unwrap();
    (usb, adapter)
}

pub(super) fn received(adapter: &mut impl Adapter) -> Vec<u32> {
    std::iter::from_fn(|| adapter.receive().unwrap()).map(|frame| frame.raw_id()).collect()
}

/// Requests that set a mode: channel and data.
pub(super) fn modes(usb: &SimulatedUsb) -> Vec<(u16, Vec<u8>)> {
    let requests = usb.state().requests.clone();
    requests.into_iter().filter(|(request, ..)| *request == 2).map(|(_, channel, data)| (channel, data)).collect()
}

pub(super) const RESET: [u8; 8] = [0; 8];
pub(super) const START: [u8; 8] = [1, 0, 0, 0, 0, 0, 0, 0];
/// Listening only, with loop-back.
pub(super) const EMPTY: [u8; 8] = [1, 0, 0, 0, 3, 0, 0, 0];

#[test]
fn a_channel_is_reset_before_it_is_started_with_no_option_whatever_the_adapter_offers() {
    let usb = SimulatedUsb::new(reply);
    // Listening only, loop-back, sending once, time stamps, padding, CAN FD.
    usb.state().limits[0] = 0b1_1001_1111;
    usb.state().channels = 2;
    drop(GsUsb::start(usb.clone(), 1).unwrap());
    let numbers = |words: [u32; 5]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    let timing = (1, 1, numbers([6, 7, 2, 2, 3]));
    let expected = [
        (0, 1, vec![0xEF, 0xBE, 0, 0]),
        (5, 1, vec![]),
        (2, 0, RESET.to_vec()),
        (2, 1, RESET.to_vec()),
        (4, 1, vec![]),
        timing.clone(),
        (2, 1, EMPTY.to_vec()),
        (2, 1, RESET.to_vec()),
        timing.clone(),
        (2, 1, START.to_vec()),
        (2, 1, RESET.to_vec()),
        timing,
        (2, 1, EMPTY.to_vec()),
        (2, 1, RESET.to_vec()),
    ];
    assert_eq!(usb.state().requests, expected);
}

#[test]
fn an_adapter_that_cannot_be_used_is_an_error_that_says_why() {
    type Prepare = fn(&SimulatedUsb);
    let cases: [(u8, Prepare, ErrorKind, &str); 10] = [
        (0, |usb| usb.state().refused = Some(0), ErrorKind::ConnectionReset, "the byte order: endpoint stalled"),
        (0, |usb| usb.state().refused = Some(5), ErrorKind::ConnectionReset, "its configuration"),
        (0, |usb| usb.state().refused = Some(2), ErrorKind::ConnectionReset, "the reset"),
        (0, |usb| usb.state().refused = Some(1), ErrorKind::ConnectionReset, "the bit timing"),
        (0, |usb| usb.state().answer_max = 11, ErrorKind::InvalidData, "11 bytes, expected 12"),
        (0, |usb| usb.state().answer_max = 39, ErrorKind::InvalidData, "39 bytes, expected 40"),
        (1, |_| {}, ErrorKind::NotFound, "no channel 1: the adapter has only channel 0"),
        // A byte order that the adapter ignored: 48 MHz with the high byte first.
        (0, |usb| usb.state().limits[1] = 48_000_000_u32.swap_bytes(), ErrorKind::InvalidData, "allows no 1 Mbit/s"),
        (0, |usb| usb.state().limits[0] = 1, ErrorKind::InvalidData, "no loop-back while it only listens"),
        (0, |usb| usb.state().unplugged = true, ErrorKind::NotConnected, "the byte order"),
    ];
    for (channel, prepare, kind, part) in cases {
        let usb = SimulatedUsb::new(reply);
        prepare(&usb);
        let Err(error) = GsUsb::start(usb.clone(), channel) else { panic!("{part}") };
        assert!(error.kind() == kind && error.to_string().contains(part), "{error:?}, expected {part}");
        assert_eq!(usb.state().on, None, "{part}");
    }
}

#[test]
fn commands_are_sent_and_replies_received_with_or_without_time_stamps() {
    for stamps in [false, true] {
        let (usb, mut adapter) = opened();
        usb.state().stamps = stamps;
        for tick in 1..=50 {
            adapter.begin_tick();
            for id in 1..=6 {
                adapter.send(&command(id)).unwrap();
            }
            assert_eq!(received(&mut adapter), [17, 18, 19, 20, 21, 22], "tick {tick}");
        }
        assert!(!adapter.is_off());
        assert_eq!(usb.state().on_bus.len(), 300);
        assert!(usb.state().lengths.iter().all(|&length| length == 20));
    }
}

#[test]
fn an_adapter_that_needs_longer_transfers_gets_them() {
    let usb = SimulatedUsb::new(reply);
    usb.state().limits[0] = 1 << 9 | 0b11;
    let mut adapter = GsUsb::start(usb.clone(), 0).unwrap();
    adapter.send(&command(1)).unwrap();
    assert_eq!(received(&mut adapter), [17]);
    assert_eq!(usb.state().lengths, [21]);
}

/// Sends commands to this many drives in every tick until the adapter is off. Returns the number of ticks.
fn ticks_until_off(adapter: &mut GsUsb<SimulatedUsb>, drives: u32) -> u32 {
    for tick in 1..100 {
        adapter.begin_tick();
        if adapter.is_off() {
            return tick;
        }
        let sent: Vec<io::Result<()>> = (1..=drives).map(|id| adapter.send(&command(id))).collect();
        let kinds: Vec<_> = sent.into_iter().filter_map(Result::err).map(|error| error.kind()).collect();
        assert!(kinds.iter().all(|kind| *kind == ErrorKind::WouldBlock), "{kinds:?}");
    }
    panic!("not off")
}

#[test]
fn without_an_acknowledgement_no_further_frame_is_accepted_and_no_old_one_is_sent_later() {
    // With six drives, frames lack their echo from the first tick on. A single one fills the three mailboxes first.
    for (drives, ticks) in [(6, UNSENT_MAX + 2), (3, UNSENT_MAX + 3), (1, UNSENT_MAX + 5)] {
        let (usb, mut adapter) = opened();
        usb.state().acknowledges = false;
        assert_eq!(ticks_until_off(&mut adapter, drives), ticks, "{drives} drives");
        let error = adapter.receive().unwrap_err();
        assert!(error.kind() == ErrorKind::BrokenPipe && error.to_string().contains("waited"), "{error}");
        assert_eq!(adapter.receive().unwrap(), None, "reported once");
        assert_eq!(adapter.send(&command(1)).unwrap_err().kind(), ErrorKind::BrokenPipe);
        drop(adapter);
        usb.state().acknowledges = true;
        assert_eq!(usb.state().waiting(), 0, "{drives} drives");
        assert!(usb.state().on_bus.is_empty(), "{drives} drives");
        assert!(modes(&usb).ends_with(&[RESET, EMPTY, RESET].map(|mode| (0, mode.to_vec()))));
    }
}

#[test]
fn a_late_echo_stops_the_commands_of_its_ticks_only() {
    let (usb, mut adapter) = opened();
    usb.state().acknowledges = false;
    adapter.begin_tick();
    (1..=6).for_each(|id| adapter.send(&command(id)).unwrap());
    for _ in 0..UNSENT_MAX {
        adapter.begin_tick();
        assert_eq!(adapter.send(&command(1)).unwrap_err().kind(), ErrorKind::WouldBlock);
    }
    usb.state().acknowledges = true;
    adapter.begin_tick();
    assert!(!adapter.is_off());
    adapter.send(&command(1)).unwrap();
    assert_eq!(received(&mut adapter), [17, 18, 19, 20, 21, 22, 17]);
}

#[test]
fn frames_above_the_limit_are_not_accepted() {
    let (usb, mut adapter) = opened();
    usb.state().acknowledges = false;
    adapter.begin_tick();
    // The program reads echoes only when a tick begins or when it receives.
    for id in 1..=UNSENT_FRAMES_MAX as u32 {
        adapter.send(&command(id)).unwrap();
    }
    assert_eq!(adapter.send(&command(99)).unwrap_err().kind(), ErrorKind::WouldBlock);
    assert!(!adapter.is_off());
    assert_eq!(usb.state().lengths.len(), UNSENT_FRAMES_MAX);
}

#[test]
fn an_adapter_that_leaves_the_bus_is_off_and_reset() {
    let (usb, mut adapter) = opened();
    // Warning, passive and active again are no reason; error frames of another channel are none either.
    for (class, channel, data) in [(0x04, 0, 0x08), (0x04, 0, 0x20), (0x04, 0, 0x40), (0x20, 0, 0), (0x40, 1, 0)] {
        usb.state().report(u32::MAX, 0x2000_0000 | class, channel, &[0, data, 0, 0, 0, 0, 0, 0]);
    }
    assert!(received(&mut adapter).is_empty() && !adapter.is_off());
    usb.state().report(u32::MAX, 0x2000_0040, 0, &[0; 8]);
    adapter.begin_tick();
    assert!(adapter.is_off());
    assert!(adapter.receive().unwrap_err().to_string().contains("left the bus"));
    // It says that it is back; its channel is reset all the same.
    usb.state().report(u32::MAX, 0x2000_0100, 0, &[0; 8]);
    adapter.begin_tick();
    assert!(adapter.is_off() && adapter.send(&command(1)).is_err());
    drop(adapter);
    assert_eq!(usb.state().on, None);
    assert_eq!(modes(&usb).len(), 4 + 3, "it is reset and emptied once");
}

#[test]
fn an_adapter_that_is_unplugged_is_off_at_the_next_call() {
    let calls: [fn(&mut GsUsb<SimulatedUsb>); 3] = [
        |adapter| adapter.begin_tick(),
        |adapter| assert!(adapter.send(&command(2)).unwrap_err().to_string().contains("unplugged")),
        |adapter| assert!(adapter.receive().unwrap_err().to_string().contains("unplugged")),
    ];
    for call in calls {
        let (usb, mut adapter) = opened();
        adapter.begin_tick();
        adapter.send(&command(1)).unwrap();
        assert_eq!(received(&mut adapter), [17]);
        usb.state().unplugged = true;
        call(&mut adapter);
        assert!(adapter.is_off());
        // It is never used again, also if it is plugged in.
        usb.state().unplugged = false;
        assert_eq!(adapter.send(&command(1)).unwrap_err().kind(), ErrorKind::BrokenPipe);
        assert_eq!(usb.state().on_bus.len(), 1);
    }
}

#[test]
fn the_newest_frames_are_kept_and_what_is_unreadable_is_an_error() {
    let (usb, mut adapter) = opened();
    (0..40).for_each(|id| usb.state().receive(&command(id), 0));
    assert_eq!(received(&mut adapter), (40 - RECEIVED_MAX as u32..40).collect::<Vec<_>>());
    // Frames of another channel, and a transfer without bytes.
    usb.state().receive(&command(1), 3);
    usb.state().to_host.push_back(Vec::new());
    assert_eq!(received(&mut adapter), [0; 0]);
    // A transfer that is too short.
    usb.state().to_host.push_back(vec![0xFF; 19]);
    usb.state().receive(&command(5), 0);
    assert_eq!(adapter.receive().unwrap_err().kind(), ErrorKind::InvalidData);
    assert_eq!(received(&mut adapter), [5]);
    // Frames were lost in the adapter.
    usb.state().receive(&command(6), 0);
    usb.state().to_host[0][10] = 1;
    assert_eq!(adapter.receive().unwrap().unwrap().raw_id(), 6);
    assert_eq!(adapter.receive().unwrap_err().kind(), ErrorKind::InvalidData);
    assert!(!adapter.is_off());
    // Echoes of frames that this program has not sent.
    for echo in [3, 10, 1 << 31] {
        usb.state().report(echo, 1, 0, &[0; 8]);
    }
    assert_eq!(received(&mut adapter), [0; 0]);
}

#[test]
fn an_adapter_that_always_has_a_frame_holds_up_no_tick() {
    let (usb, mut adapter) = opened();
    (0..1000).for_each(|_| usb.state().receive(&command(7), 0));
    adapter.begin_tick();
    assert!(usb.state().to_host.len() > 500);
    let endless = SimulatedUsb::new(reply);
    (0..60_000).for_each(|_| endless.state().receive(&command(7), 0));
    assert!(GsUsb::start(endless, 0).is_err_and(|error| error.to_string().contains("were reset")));
}

#[test]
fn a_closed_adapter_sends_its_last_frames_and_is_reset() {
    let (usb, mut adapter) = opened();
    usb.state().acknowledges = false;
    (1..=6).for_each(|id| adapter.send(&command(id)).unwrap());
    // A drive acknowledges only later, while the adapter is being closed.
    usb.state().acknowledged_after = Some(12);
    drop(adapter);
    assert_eq!(usb.state().on_bus.len(), 6);
    assert_eq!(usb.state().on, None);
}
