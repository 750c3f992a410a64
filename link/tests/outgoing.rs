//! Tests of the queue to hardware that sends pieces of memory.

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicU8, Ordering};
use newtau_link::{Outgoing, Sending};
use proptest::collection::vec;
use proptest::prelude::*;
use std::rc::Rc;

const SIZE: usize = 32;

/// Model of the line: sends one byte of its piece after every few polls, and reads the byte only then.
#[derive(Default)]
struct Line {
    piece: RefCell<&'static [AtomicU8]>,
    sent: RefCell<Vec<u8>>,
    pieces: Cell<usize>,
    looks: Cell<usize>,
    looks_a_byte: usize,
}

impl Line {
    fn byte(&self) {
        let piece = *self.piece.borrow();
        if let Some((first, rest)) = piece.split_first() {
            self.sent.borrow_mut().push(first.load(Ordering::Relaxed));
            self.piece.replace(rest);
        }
    }
}

struct Hardware(Rc<Line>);

impl Sending for Hardware {
    fn is_idle(&mut self) -> bool {
        self.0.looks.set(self.0.looks.get() + 1);
        if self.0.looks_a_byte > 0 && self.0.looks.get().is_multiple_of(self.0.looks_a_byte) {
            self.0.byte();
        }
        self.0.piece.borrow().is_empty()
    }

    fn start(&mut self, piece: &'static [AtomicU8]) {
        assert!(self.0.piece.borrow().is_empty(), "a piece is sent already");
        assert!(!piece.is_empty(), "nothing to send");
        self.0.piece.replace(piece);
        self.0.pieces.set(self.0.pieces.get() + 1);
    }
}

fn start(looks_a_byte: usize) -> (Rc<Line>, Outgoing<Hardware, SIZE>) {
    let bytes: &'static [AtomicU8; SIZE] = Box::leak(Box::new([const { AtomicU8::new(0) }; SIZE]));
    let line = Rc::new(Line { looks_a_byte, ..Line::default() });
    (line.clone(), Outgoing::new(bytes, Hardware(line)))
}

/// Does what the interrupt at the end of a piece does.
fn finish(line: &Line, outgoing: &mut Outgoing<Hardware, SIZE>) {
    while !line.piece.borrow().is_empty() {
        line.byte();
        outgoing.advance();
    }
}

/// The line sends nothing here: a writer that waited would never return.
#[test]
fn what_fits_is_taken_without_waiting_for_the_line() {
    let (line, mut outgoing) = start(0);
    for length in [SIZE, 1, SIZE - 1, SIZE] {
        let before = line.pieces.get();
        outgoing.write(&vec![7; length]);
        finish(&line, &mut outgoing);
        assert_eq!(line.pieces.get(), before + 1, "a packet in an empty queue is one piece");
    }
    outgoing.write(&[1; 10]);
    outgoing.write(&[2; 22]);
    assert_eq!(line.pieces.get(), 5, "the second waits behind the first");
    finish(&line, &mut outgoing);
    assert_eq!(line.sent.borrow()[3 * SIZE..], [vec![1; 10], vec![2; 22]].concat());
}

#[test]
fn a_writer_of_more_than_fits_waits_until_all_is_taken() {
    let (line, mut outgoing) = start(3);
    let all: Vec<u8> = (0..=255).collect();
    outgoing.write(&all);
    finish(&line, &mut outgoing);
    assert_eq!(*line.sent.borrow(), all);
}

proptest! {
    /// Every byte is sent once and in order, and none is overwritten before it is sent.
    #[test]
    fn what_is_written_is_sent(writes in vec((vec(any::<u8>(), 0..3 * SIZE), 0_usize..80), 0..30), looks in 1_usize..5) {
        let (line, mut outgoing) = start(looks);
        let mut all = Vec::new();
        for (bytes, steps) in writes {
            outgoing.write(&bytes);
            all.extend(bytes);
            for _ in 0..steps {
                line.byte();
                outgoing.advance();
            }
        }
        finish(&line, &mut outgoing);
        prop_assert_eq!(&*line.sent.borrow(), &all);
    }
}
