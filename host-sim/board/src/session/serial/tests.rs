//! Tests on a pair of pseudo-terminals: the link at one end, a scripted firmware at the other.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{BAUD, SerialError, SerialLink};
use link::{DecodeError, Decoder, Encoder, Fault, Frame, Refusal};
use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::time::{Duration, Instant};

const SOON: Duration = Duration::from_secs(5);

/// The board's end of the pair, and the link at the other end.
fn pair() -> (TTYPort, SerialLink) {
    let (mut board, host) = TTYPort::pair().unwrap();
    board.set_timeout(SOON).unwrap();
    let name = host.name().unwrap();
    // This end holds the lock that keeps others out.
    drop(host);
    (board, SerialLink::open(&name, BAUD).unwrap())
}

fn fault(tick: u32) -> Frame {
    Frame::Fault(Fault { tick, code: 3, joint: None })
}

#[test]
fn frames_that_come_in_one_read_come_out_one_by_one() {
    let (mut board, mut link) = pair();
    let mut encoder = Encoder::new();
    let packets: Vec<u8> = (0..3).flat_map(|tick| encoder.encode(&fault(tick)).unwrap()).collect();
    board.write_all(&packets).unwrap();
    for tick in 0..3 {
        let received = link.receive(SOON).unwrap().unwrap();
        assert_eq!((received.frame, received.missed), (fault(tick), 0));
    }
    assert_eq!(link.receive(Duration::ZERO).unwrap(), None);
}

#[test]
fn a_frame_that_comes_in_two_pieces_is_whole() {
    let (mut board, mut link) = pair();
    let packet = Encoder::new().encode(&fault(7)).unwrap();
    let (first, second) = packet.split_at(4);
    board.write_all(first).unwrap();
    assert_eq!(link.receive(Duration::from_millis(50)).unwrap(), None);
    board.write_all(second).unwrap();
    assert_eq!(link.receive(SOON).unwrap().unwrap().frame, fault(7));
}

#[test]
fn a_damaged_packet_is_reported_and_the_next_is_read_with_the_loss() {
    let (mut board, mut link) = pair();
    let mut encoder = Encoder::new();
    let (first, mut second, third) =
        (encoder.encode(&fault(1)).unwrap(), encoder.encode(&fault(2)).unwrap(), encoder.encode(&fault(3)).unwrap());
    // Damages the byte of the tick number. It must not become a zero, which would end the packet.
    second[4] ^= 0x40;
    board.write_all(&[&first[..], &second[..], &third[..]].concat()).unwrap();
    assert_eq!(link.receive(SOON).unwrap().unwrap().frame, fault(1));
    let error = link.receive(SOON).unwrap_err();
    assert!(matches!(error, SerialError::Undecodable(DecodeError::BadCrc | DecodeError::BadCobs)), "{error}");
    let received = link.receive(SOON).unwrap().unwrap();
    assert_eq!((received.frame, received.missed), (fault(3), 1));
}

#[test]
fn a_silent_board_costs_the_time_that_was_given_and_no_more() {
    let (_board, mut link) = pair();
    let begun = Instant::now();
    assert_eq!(link.receive(Duration::from_millis(100)).unwrap(), None);
    let took = begun.elapsed();
    assert!(took >= Duration::from_millis(100) && took < SOON, "{took:?}");
}

#[test]
fn what_is_sent_arrives_behind_a_zero_that_ends_what_another_left() {
    let (mut board, mut link) = pair();
    for frame in [Frame::Refusal(Refusal::NoHello), fault(1)] {
        link.send(&frame).unwrap();
    }
    // A decoder left in the middle of a packet by another program.
    let mut decoder = Decoder::new();
    for byte in [5, 1, 2] {
        assert_eq!(decoder.push(byte), None);
    }
    let mut heard = Vec::new();
    while heard.len() < 3 {
        let mut byte = [0];
        board.read_exact(&mut byte).unwrap();
        heard.extend(decoder.push(byte[0]));
    }
    assert!(heard[0].is_err(), "{heard:?}");
    let frames: Vec<_> = heard[1..].iter().map(|received| received.clone().unwrap().frame).collect();
    assert_eq!(frames, [Frame::Refusal(Refusal::NoHello), fault(1)]);
}

#[test]
fn a_board_that_is_unplugged_is_gone() {
    let (board, mut link) = pair();
    drop(board);
    let error = link.receive(SOON).unwrap_err();
    assert!(matches!(error, SerialError::Gone), "{error}");
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let Err(error) = SerialLink::open("/dev/no-such-port", BAUD) else { panic!("opened") };
    assert!(error.to_string().contains("/dev/no-such-port") && !error.is_forbidden(), "{error}");
}
