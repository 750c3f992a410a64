//! Every written frame is read back bit for bit; an error names the byte offset of the damage.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{Direction, Entry, Head, Log, LogError, Writer};
use link::convert::joints;
use link::{Frame, Request, Sensed};
use std::time::Duration;

fn head() -> Head {
    Head { hash: 0x0123_4567_89ab_cdef, scene: "scenes/ä.toml".into(), text: "name = \"x\"\n".into() }
}

/// A measurement with a special NaN and a negative zero.
fn odd() -> Frame {
    let q = joints(&[f32::from_bits(0x7fc0_1234), -0.0]);
    Frame::Measurement(link::Measurement { tick: 7, age_ticks: 0, sensed: Sensed::State { qd: q.clone(), q } })
}

fn bytes() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, &head()).unwrap();
    writer.push(Direction::Sent, 0, Duration::from_micros(5), &odd()).unwrap();
    writer.push(Direction::Received, 3, Duration::from_secs(7200), &Frame::request(1, Request::Hold)).unwrap();
    bytes
}

#[test]
fn every_frame_comes_back_with_its_bits_its_time_and_what_was_lost_before_it() {
    let log = Log::new(bytes()).unwrap();
    assert_eq!((&log.head, log.cut()), (&head(), 0));
    let entries: Vec<Entry> = log.entries().collect::<Result<_, _>>().unwrap();
    let [first, second] = &entries[..] else { panic!("{entries:?}") };
    let Frame::Measurement(link::Measurement { sensed: Sensed::State { q, .. }, .. }) = &first.frame else {
        panic!("{first:?}")
    };
    assert_eq!(q.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), [0x7fc0_1234, 0x8000_0000]);
    assert_eq!((first.way, first.missed, first.at.as_micros()), (Direction::Sent, 0, 5));
    assert_eq!((second.way, second.missed, second.at.as_secs()), (Direction::Received, 3, 7200));
    assert_eq!(second.frame, Frame::request(1, Request::Hold));
}

#[test]
fn a_file_that_ends_anywhere_says_so_and_keeps_what_is_whole() {
    let bytes = bytes();
    let begin = Log::new(bytes.clone()).unwrap().begin;
    for end in 0..bytes.len() {
        match Log::new(bytes[..end].to_vec()) {
            Err(LogError::NotALog) => assert!(end < 8),
            Err(LogError::Headless(at)) => assert!(at == end && (8..begin).contains(&end)),
            Err(other) => panic!("{other}"),
            Ok(log) => {
                let whole = log.entries().inspect(|entry| assert!(entry.is_ok())).count();
                assert_eq!(whole, usize::from(log.cut() + begin < end));
            }
        }
    }
}

#[test]
fn what_is_damaged_is_named_with_its_place() {
    let good = bytes();
    let begin = Log::new(good.clone()).unwrap().begin;
    let with = |at: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[at] = byte;
        let log = Log::new(bytes)?;
        log.entries().collect::<Result<Vec<_>, _>>()
    };
    let message = |at, byte| with(at, byte).unwrap_err().to_string();
    assert_eq!(
        message(0, 0),
        "byte 0: no record of a session; expected a file that begins with NEWTAULG, or an MCAP file"
    );
    assert_eq!(message(8, 9), "byte 8: version 9 of the layout, expected 1");
    let protocol = format!("byte 10: version 2 of the link's protocol, expected {}", link::PROTOCOL_VERSION);
    assert_eq!(message(10, 2), protocol);
    assert_eq!(message(23, 0xff), "byte 23: a text of the head is not UTF-8");
    let entry = |what: &str| format!("entry 1, byte {begin}: {what}");
    assert_eq!(message(begin, 4), entry("direction 4, expected 0 (sent) or 1 (received)"));
    assert_eq!(message(begin + 12, 99), entry(&format!("frame of kind 99, expected one below {}", Frame::KINDS)));
    assert!(message(begin + 12, 7).starts_with(&entry("")), "another kind of frame with these bytes");
}
