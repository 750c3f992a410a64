#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::frame::CanFrame;
use super::super::serial_adapter::{Parsed, Protocol as _};
use super::Slcan;
use embedded_can::{Frame as _, Id, StandardId};
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

/// Everything that these bytes say.
fn read(bytes: &[u8]) -> Vec<Parsed> {
    let mut slcan = Slcan::default();
    bytes.iter().map(|&byte| slcan.push(byte)).filter(|parsed| *parsed != Parsed::Nothing).collect()
}

fn line(frame: &CanFrame) -> String {
    let mut bytes = Vec::new();
    Slcan::encode(frame, &mut bytes);
    String::from_utf8(bytes).unwrap()
}

#[test]
fn lines_are_those_of_the_manual() {
    // CAN232 manual: `t10021133` is identifier 0x100 with the bytes 0x11, 0x33.
    let frame = CanFrame::of(0x100, false, &[0x11, 0x33]).unwrap();
    assert_eq!(line(&frame), "t10021133\r");
    assert_eq!(read(b"t10021133\r"), [Parsed::Frame(frame)]);
    let extended = CanFrame::of(0x1FFF_0001, true, &[0xAB; 8]).unwrap();
    assert_eq!(line(&extended), "T1FFF00018ABABABABABABABAB\r");
    let remote = CanFrame::new_remote(Id::Standard(StandardId::new(0x100).unwrap()), 3).unwrap();
    assert_eq!(line(&remote), "r1003\r");
    assert_eq!(read(b"r1003\r"), [Parsed::Frame(remote)]);
}

#[test]
fn answers_are_ignored_and_a_time_stamp_is_read_over() {
    let frame = CanFrame::of(0x7FF, false, &[1]).unwrap();
    assert_eq!(read(b"\rz\rZ\rV1013\rF00\rt7FF10112AB\rz\r"), [Parsed::Frame(frame)]);
}

#[test]
fn what_is_no_frame_is_an_error_and_the_next_line_is_read() {
    for bad in ["t80011A", "t1009", "t1002113", "tXYZ0", "T200000000", "q", "t100", "t", "t10021133F", "t1+01AA"] {
        let found = read(format!("{bad}\rt10001\rt1000\r").as_bytes());
        let next = CanFrame::of(0x100, false, &[]).unwrap();
        assert_eq!(found, [Parsed::Error, Parsed::Error, Parsed::Frame(next)], "{bad}");
    }
    assert_eq!(read(b"\x07t1000\r").len(), 2, "a refused command");
    assert_eq!(read(&[b't'; 10_000]), [], "a line without an end fills no memory");
}

proptest! {
    #[test]
    fn every_frame_comes_back(raw in 0u32..0x2000_0000, extended in any::<bool>(), data in proptest::collection::vec(any::<u8>(), 0..=8)) {
        let raw = if extended { raw } else { raw & 0x7FF };
        let frame = CanFrame::of(raw, extended, &data).unwrap();
        prop_assert_eq!(read(line(&frame).as_bytes()), [Parsed::Frame(frame)]);
    }

    #[test]
    fn no_bytes_are_too_bad(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(read(&bytes).len() <= bytes.len());
    }
}
