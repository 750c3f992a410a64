//! Tests of a full queue, and of the packets after the lost bytes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use heapless::spsc::{Consumer, Queue};
use newtau_link::{Arrival, DecodeError, Decoder, Encoder, Frame, Inlet, Request};
use proptest::collection::vec;
use proptest::prelude::*;

/// A queue of 32 bytes.
fn queue() -> (Inlet, Consumer<'static, u8>) {
    let (producer, consumer) = Box::leak(Box::new(Queue::<u8, 33>::new())).split();
    (Inlet::new(producer), consumer)
}

fn drain(decoder: &mut Decoder, pending: &mut Consumer<'static, u8>) -> Vec<Result<Frame, DecodeError>> {
    let bytes = core::iter::from_fn(|| pending.dequeue());
    bytes.filter_map(|byte| decoder.push(byte)).map(|result| result.map(|received| received.frame)).collect()
}

/// A full queue drops the zero that ends the garbage; a request to hold after it is read nevertheless.
#[test]
fn a_hold_behind_more_garbage_than_the_queue_holds_is_read() {
    let hold = Frame::request(7, Request::Hold);
    for garbage in 28..40 {
        let (mut inlet, mut pending) = queue();
        let mut decoder = Decoder::new();
        let arrivals: Vec<_> = (0..garbage).map(|_| 1).chain([0]).map(|byte| inlet.push(byte)).collect();
        assert_eq!(arrivals.contains(&Arrival::Lost), garbage >= 32, "{garbage}");
        let mut read = drain(&mut decoder, &mut pending);
        for &byte in &Encoder::new().encode(&hold).unwrap() {
            inlet.push(byte);
        }
        read.extend(drain(&mut decoder, &mut pending));
        assert_eq!(read.last(), Some(&Ok(hold.clone())), "{garbage} bytes of garbage");
        assert!(read[..read.len() - 1].iter().all(Result::is_err), "{read:?}");
    }
}

/// Garbage without a zero does not fill the queue if the reader runs when it is requested.
#[test]
fn the_reader_is_asked_at_half_of_the_queue() {
    let (mut inlet, mut pending) = queue();
    for byte in 1..=255 {
        if inlet.push(byte) != Arrival::Waits {
            assert_eq!(pending.len(), 16);
            while pending.dequeue().is_some() {}
        }
    }
}

proptest! {
    /// Whatever is lost, only packets that were sent whole are read, and a packet that arrives at an empty queue is always read.
    #[test]
    fn what_is_lost_harms_no_packet_behind_it(bursts in vec((vec(any::<u8>(), 0..60), 0_usize..40), 1..20)) {
        let (mut inlet, mut pending) = queue();
        let mut decoder = Decoder::new();
        let mut encoder = Encoder::new();
        for (noise, taken) in bursts {
            for byte in noise {
                inlet.push(byte);
            }
            for _ in 0..taken {
                pending.dequeue().map(|byte| decoder.push(byte));
            }
        }
        drain(&mut decoder, &mut pending);
        inlet.push(0);
        drain(&mut decoder, &mut pending);
        for &byte in &encoder.encode(&Frame::Alive).unwrap() {
            inlet.push(byte);
        }
        prop_assert_eq!(drain(&mut decoder, &mut pending), [Ok(Frame::Alive)]);
    }
}
