#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::frame::CanFrame;
use super::super::serial_adapter::{Parsed, Protocol as _};
use super::{COMMAND_BYTES, DamiaoUsb};
use proptest::prelude::{any, prop_assert_eq, proptest};

/// Bytes with which the adapter reports a frame.
fn report(raw: u32, flags: u8, data: [u8; 8]) -> Vec<u8> {
    let head = [0xAA, 0x11, flags];
    head.into_iter().chain(raw.to_le_bytes()).chain(data).chain([0x55]).collect()
}

fn read(bytes: &[u8]) -> Vec<CanFrame> {
    let mut adapter = DamiaoUsb::default();
    let parsed = bytes.iter().map(|&byte| adapter.push(byte));
    parsed.filter_map(|parsed| if let Parsed::Frame(frame) = parsed { Some(frame) } else { None }).collect()
}

#[test]
fn a_command_is_that_of_the_makers_example() {
    let mut bytes = Vec::new();
    let enable = [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFC];
    DamiaoUsb::encode(&CanFrame::of(0x101, false, &enable).unwrap(), &mut bytes);
    let mut expected = vec![0x55, 0xAA, 0x1E, 3, 1, 0, 0, 0, 10, 0, 0, 0, 0, 1, 1, 0, 0, 0, 8, 0, 0];
    expected.extend(enable);
    expected.push(0);
    assert_eq!(bytes, expected);
    bytes.clear();
    DamiaoUsb::encode(&CanFrame::of(0x12345, true, &[7]).unwrap(), &mut bytes);
    assert_eq!((bytes.len(), bytes[12], &bytes[13..17], bytes[18]), (COMMAND_BYTES, 1, &[0x45, 0x23, 1, 0][..], 1));
}

#[test]
fn a_report_of_the_adapter_itself_is_no_frame() {
    let mut bytes = report(0x11, 8, [1; 8]);
    bytes[1] = 0x01;
    assert_eq!(read(&bytes), []);
    assert_eq!(read(&report(0x11, 9, [1; 8])), [], "nine bytes are too many");
    assert_eq!(read(&report(0x800, 8, [1; 8])), [], "a standard identifier has 11 bits");
}

proptest! {
    #[test]
    fn frames_are_found_behind_lost_bytes(raw in 0u32..0x800, data in any::<[u8; 8]>(), lost in 0usize..16) {
        // The first report lacks its beginning. The next ones are read, at the latest from the third on, whatever bytes they have.
        let one = report(raw, 8, data);
        let bytes: Vec<u8> = one[lost..].iter().chain(&one).chain(&one).chain(&one).copied().collect();
        let frames = read(&bytes);
        prop_assert_eq!(frames.last().copied(), CanFrame::of(raw, false, &data));
    }

    #[test]
    fn no_bytes_are_too_bad(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = read(&bytes);
    }
}
