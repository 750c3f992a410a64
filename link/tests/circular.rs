//! Tests of the reader of a circular buffer: against a model of the hardware, and against a thread that never waits.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};
use newtau_link::{Circular, DecodeError, Decoder, Encoder, Filling, Frame, Halves, Request};
use proptest::collection::vec;
use proptest::prelude::*;
use std::collections::VecDeque;
use std::rc::Rc;

const SIZE: usize = 96;
const HALF: usize = SIZE / 2;

/// Model of the hardware: writes bytes, raises a flag at each half, and goes on writing while its position is read.
#[derive(Default)]
struct Model {
    /// Number of bytes written so far.
    written: Cell<usize>,
    /// True for each half that is full and whose interrupt has not run.
    flags: Cell<[bool; 2]>,
    counted: Halves,
    /// Halves that were counted before the start, even.
    before: u32,
    /// Number of bytes written at each read of the position. After an odd number the interrupt has not run yet.
    meanwhile: RefCell<VecDeque<u8>>,
    /// True if the interrupt is as late as it may be: it runs when the next half is full.
    held_off: bool,
    /// True if the position at the end of the buffer is its length.
    shows_end: bool,
}

#[derive(Clone)]
struct Hardware(Rc<Model>, &'static [AtomicU8; SIZE]);

impl Hardware {
    fn write(&self, byte: u8) {
        let at = self.0.written.get() % SIZE;
        self.1[at].store(byte, Ordering::Relaxed);
        self.0.written.set(self.0.written.get() + 1);
        let filled = [at + 1 == HALF, at + 1 == SIZE];
        if filled.contains(&true) {
            self.interrupt();
            self.0.flags.set(filled);
        }
    }

    fn interrupt(&self) {
        let [first, second] = self.0.flags.take();
        self.0.counted.count(first, second);
    }

    fn look(&self) {
        let bytes = self.0.meanwhile.borrow_mut().pop_front().unwrap_or(0);
        for _ in 0..bytes {
            self.write(numbered(self.0.written.get()));
        }
        if !self.0.held_off && bytes.is_multiple_of(2) {
            self.interrupt();
        }
    }
}

impl Filling for Hardware {
    fn position(&self) -> usize {
        self.look();
        let written = self.0.written.get();
        if self.0.shows_end && written > 0 && written.is_multiple_of(SIZE) { SIZE } else { written % SIZE }
    }

    fn halves(&self) -> u32 {
        self.look();
        self.0.before.wrapping_add(self.0.counted.so_far())
    }
}

/// A non-zero byte that encodes its position in the stream; the buffer's length is not a multiple of the period.
fn numbered(at: usize) -> u8 {
    (at % 251) as u8 + 1
}

fn start(model: Model) -> (Hardware, Circular<Hardware, SIZE>) {
    let bytes: &'static [AtomicU8; SIZE] = Box::leak(Box::new([const { AtomicU8::new(0) }; SIZE]));
    let hardware = Hardware(Rc::new(model), bytes);
    (hardware.clone(), Circular::new(bytes, hardware))
}

fn drain(circular: &mut Circular<Hardware, SIZE>) -> Vec<u8> {
    core::iter::from_fn(|| circular.next_byte()).collect()
}

/// True if the bytes between two zeros are consecutive in the stream.
fn consecutive(bytes: &[u8]) -> bool {
    bytes.split(|byte| *byte == 0).all(|part| part.windows(2).all(|pair| pair[1] == pair[0] % 251 + 1))
}

#[test]
fn one_byte_less_than_the_buffer_waits_whole_and_one_more_costs_the_older_half() {
    for (count, kept) in [(0, 0), (1, 1), (HALF, HALF), (SIZE - 1, SIZE - 1), (SIZE, HALF), (7 * SIZE + 3, HALF)] {
        for shows_end in [false, true] {
            let (hardware, mut circular) = start(Model { shows_end, ..Model::default() });
            (0..count).for_each(|at| hardware.write(numbered(at)));
            hardware.interrupt();
            let mut expected: Vec<u8> = (count - kept..count).map(numbered).collect();
            if count >= SIZE {
                expected.insert(0, 0);
            }
            assert_eq!(drain(&mut circular), expected, "{count}");
            assert_eq!((circular.has_lost(), circular.has_lost()), (count >= SIZE, false), "{count}");
        }
    }
}

#[test]
fn a_boundary_whose_interrupt_has_not_run_yet_is_known_by_the_position() {
    let (hardware, mut circular) = start(Model { held_off: true, ..Model::default() });
    let mut read = Vec::new();
    for at in 0..20 * SIZE {
        hardware.write(numbered(at));
        read.extend(drain(&mut circular));
        assert_eq!(read.len(), at + 1);
    }
    assert_eq!(read, (0..20 * SIZE).map(numbered).collect::<Vec<_>>());
}

#[test]
fn the_count_of_halves_may_wrap() {
    let (hardware, mut circular) = start(Model { before: u32::MAX - 9, ..Model::default() });
    // The reader starts at zero, so the count looks like a loss.
    assert_eq!(drain(&mut circular)[0], 0);
    assert!(circular.has_lost());
    let mut read = Vec::new();
    for at in 0..20 * SIZE {
        hardware.write(numbered(at));
        read.extend(drain(&mut circular));
    }
    assert_eq!(read, (0..20 * SIZE).map(numbered).collect::<Vec<_>>());
    assert!(!circular.has_lost());
}

fn frames(bytes: &[u8]) -> Vec<Result<Frame, DecodeError>> {
    let mut decoder = Decoder::new();
    let packets = bytes.iter().filter_map(|byte| decoder.push(*byte));
    packets.map(|result| result.map(|received| received.frame)).collect()
}

/// The newest half is kept, so a packet after any amount of garbage is read.
#[test]
fn a_hold_behind_more_garbage_than_the_buffer_holds_is_read() {
    let hold = Frame::request(7, Request::Hold);
    let packet = Encoder::new().encode(&hold).unwrap();
    for garbage in 0..3 * SIZE {
        let (hardware, mut circular) = start(Model::default());
        for byte in core::iter::repeat_n(1, garbage).chain([0]).chain(packet.iter().copied()) {
            hardware.write(byte);
        }
        hardware.interrupt();
        let read = frames(&drain(&mut circular));
        assert_eq!(read.last(), Some(&Ok(hold.clone())), "{garbage} bytes of garbage");
        assert!(read[..read.len() - 1].iter().all(Result::is_err), "{read:?}");
    }
}

/// A thread writes without waiting, so bytes are often overwritten while the reader copies them.
#[test]
fn what_a_thread_overwrites_is_never_read_as_one_piece() {
    struct Shared {
        bytes: [AtomicU8; SIZE],
        position: AtomicUsize,
        halves: Halves,
        ends: AtomicBool,
    }
    struct Look(&'static Shared);
    impl Filling for Look {
        fn position(&self) -> usize {
            self.0.position.load(Ordering::SeqCst)
        }
        fn halves(&self) -> u32 {
            core::sync::atomic::fence(Ordering::SeqCst);
            self.0.halves.so_far()
        }
    }
    let shared: &'static Shared = Box::leak(Box::new(Shared {
        bytes: [const { AtomicU8::new(0) }; SIZE],
        position: AtomicUsize::new(0),
        halves: Halves::new(),
        ends: AtomicBool::new(false),
    }));
    let writer = std::thread::spawn(|| {
        let mut written = 0_usize;
        while !shared.ends.load(Ordering::Relaxed) {
            shared.bytes[written % SIZE].store(numbered(written), Ordering::SeqCst);
            written += 1;
            shared.position.store(written % SIZE, Ordering::SeqCst);
            shared.halves.count(written % SIZE == HALF, written.is_multiple_of(SIZE));
            // Sometimes faster than the reader, sometimes slower.
            for _ in 0..(written / 10_000) % 60 {
                core::hint::spin_loop();
            }
        }
    });
    let mut circular: Circular<Look, SIZE> = Circular::new(&shared.bytes, Look(shared));
    let (mut read, mut lost) = (Vec::new(), 0);
    let until = std::time::Instant::now() + std::time::Duration::from_millis(500);
    while std::time::Instant::now() < until {
        for _ in 0..1000 {
            read.extend(circular.next_byte());
        }
        lost += u32::from(circular.has_lost());
        assert!(consecutive(&read));
        // Keep the last byte, to check that the next bytes follow it.
        read.drain(..read.len().saturating_sub(1));
    }
    shared.ends.store(true, Ordering::Relaxed);
    writer.join().unwrap();
    assert!(lost > 0, "the reader was never overtaken");
}

proptest! {
    /// A reader that is never overtaken reads exactly the bytes written, whenever it runs and however late the interrupt is.
    #[test]
    fn what_is_not_overtaken_is_read_in_order(steps in vec((0_usize..40, vec(0_u8..4, 8)), 1..60), [shows_end, held_off]: [bool; 2]) {
        let (hardware, mut circular) = start(Model { shows_end, held_off, ..Model::default() });
        let mut read = Vec::new();
        for (count, meanwhile) in steps {
            for _ in 0..count {
                hardware.write(numbered(hardware.0.written.get()));
            }
            hardware.0.meanwhile.replace(meanwhile.into());
            read.extend(drain(&mut circular));
        }
        hardware.0.meanwhile.borrow_mut().clear();
        read.extend(drain(&mut circular));
        prop_assert_eq!(read, (0..hardware.0.written.get()).map(numbered).collect::<Vec<_>>());
        prop_assert!(!circular.has_lost());
    }

    /// A reader that is overtaken gets pieces of the stream up to its end, with a zero before each, and reports the loss.
    #[test]
    fn what_is_overtaken_is_cut_by_a_zero(steps in vec((0_usize..300, 0_usize..60, vec(0_u8..40, 8)), 1..30)) {
        let (hardware, mut circular) = start(Model::default());
        let mut read = Vec::new();
        for (count, taken, meanwhile) in steps {
            for _ in 0..count {
                hardware.write(numbered(hardware.0.written.get()));
            }
            hardware.0.meanwhile.replace(meanwhile.into());
            read.extend(core::iter::from_fn(|| circular.next_byte()).take(taken));
        }
        hardware.0.meanwhile.borrow_mut().clear();
        read.extend(drain(&mut circular));
        let written = hardware.0.written.get();
        prop_assert!(consecutive(&read), "{:?}", read);
        prop_assert_eq!(circular.has_lost(), read.contains(&0));
        prop_assert!(read.contains(&0) || read.len() == written);
        if written > 0 {
            prop_assert_eq!(read.last().copied(), Some(numbered(written - 1)));
        }
    }

    /// Whatever is lost, only packets that were sent whole are read, and a packet after the loss is read.
    #[test]
    fn what_is_lost_harms_no_packet_behind_it(bursts in vec((vec(any::<u8>(), 0..150), 0_usize..60), 1..20)) {
        let (hardware, mut circular) = start(Model::default());
        let mut decoder = Decoder::new();
        for (noise, taken) in bursts {
            noise.into_iter().for_each(|byte| hardware.write(byte));
            for _ in 0..taken {
                circular.next_byte().map(|byte| decoder.push(byte));
            }
        }
        hardware.write(0);
        for &byte in &Encoder::new().encode(&Frame::Alive).unwrap() {
            hardware.write(byte);
        }
        let read = drain(&mut circular).into_iter().filter_map(|byte| decoder.push(byte));
        let good: Vec<Frame> = read.filter_map(|packet| packet.ok().map(|received| received.frame)).collect();
        prop_assert_eq!(good, [Frame::Alive]);
    }
}
