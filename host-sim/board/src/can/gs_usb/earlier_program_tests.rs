//! Frames and echoes of an earlier program that are still in the adapter.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::adapter::Adapter as _;
use super::channel::GsUsb;
use super::requests;
use super::simulated::SimulatedUsb;
use super::tests::{EMPTY, RESET, START, command, modes, opened, received, reply};
use super::transport::Transport as _;
use std::io::ErrorKind;

#[test]
fn what_an_adapter_still_has_for_a_killed_program_is_dropped() {
    let usb = SimulatedUsb::new(reply);
    usb.state().on = Some(0);
    for id in 0..20 {
        usb.state().receive(&command(id), 0);
        usb.state().report(id, id, 0, &[0; 8]);
    }
    let mut adapter = GsUsb::start(usb.clone(), 0).unwrap();
    assert_eq!(received(&mut adapter), [0; 0]);
    assert_eq!(modes(&usb), [RESET, EMPTY, RESET, START].map(|mode| (0, mode.to_vec())));
}

/// A program that was killed with frames in the adapter, on a bus where nothing acknowledged them.
fn killed_with_frames(drops: bool) -> SimulatedUsb {
    let (usb, mut adapter) = opened();
    usb.state().drops = drops;
    usb.state().acknowledges = false;
    (1..=6).for_each(|id| adapter.send(&command(id)).unwrap());
    std::mem::forget(adapter);
    assert_eq!(usb.state().waiting(), 6);
    usb
}

#[test]
fn frames_that_a_reset_leaves_in_the_adapter_never_reach_the_bus() {
    for drops in [false, true] {
        let usb = killed_with_frames(drops);
        usb.state().acknowledges = true;
        let mut adapter = GsUsb::start(usb.clone(), 0).unwrap();
        assert!(received(&mut adapter).is_empty() && usb.state().on_bus.is_empty(), "drops: {drops}");
        adapter.send(&command(9)).unwrap();
        assert_eq!(received(&mut adapter), [25]);
    }
    // The control: started as Linux starts it, the channel sends them.
    let mut usb = killed_with_frames(false);
    usb.state().acknowledges = true;
    requests::reset(&mut usb, 0).unwrap();
    usb.control_out(2, 0, &START).unwrap();
    assert_eq!(usb.state().on_bus.len(), 3);
}

#[test]
fn echoes_of_an_earlier_program_are_not_taken_for_those_of_this_one() {
    let (usb, mut adapter) = opened();
    usb.state().acknowledges = false;
    adapter.begin_tick();
    (1..=6).for_each(|id| adapter.send(&command(id)).unwrap());
    for echo in 0..16 {
        usb.state().report(echo, 1, 0, &[0; 8]);
    }
    adapter.begin_tick();
    assert_eq!(adapter.send(&command(7)).unwrap_err().kind(), ErrorKind::WouldBlock);
}
