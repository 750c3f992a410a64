//! Tests of the magnetic encoder's driver against a model, and of the count of turns.

use actuator_model::encoder::Encoder;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use joint_io::as5047p::{ANGLECOM, As5047p, COUNTS, DIAAGC, ERRFL, NOP, Turns, Word, read_word};
use proptest::prelude::*;
use std::cell::RefCell;
use std::rc::Rc;

/// The model with the trait that the firmware uses; it can be unplugged.
#[derive(Clone, Default)]
pub(crate) struct Spi {
    pub(crate) encoder: Rc<RefCell<Encoder>>,
    pub(crate) unplugged: Rc<RefCell<bool>>,
}

impl ErrorType for Spi {
    type Error = ErrorKind;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        if *self.unplugged.borrow() {
            return Err(ErrorKind::Other);
        }
        let [Operation::TransferInPlace(bytes)] = operations else { panic!("one word a chip select") };
        let word = u16::from_be_bytes([bytes[0], bytes[1]]);
        bytes.copy_from_slice(&self.encoder.borrow_mut().transfer(word).to_be_bytes());
        Ok(())
    }
}

fn bench() -> (As5047p<Spi>, Spi) {
    let spi = Spi::default();
    (As5047p::new(spi.clone()), spi)
}

#[test]
fn words_have_the_bits_of_the_data_sheet() {
    assert_eq!(read_word(ANGLECOM), 0xffff);
    assert_eq!(read_word(DIAAGC), 0xfffc);
    assert_eq!(read_word(ERRFL), 0x4001);
    assert_eq!(read_word(NOP), 0xc000);
    for address in 0..0x4000 {
        assert_eq!(read_word(address).count_ones() % 2, 0);
    }
    assert_eq!(Word::new(0x1234), None, "odd parity");
    assert_eq!(Word::new(0x9234), Some(Word { value: 0x1234, flagged: false }));
    assert_eq!(Word::new(0x5234), Some(Word { value: 0x1234, flagged: true }));
}

#[test]
fn an_angle_is_of_this_tick() {
    let (mut encoder, spi) = bench();
    for angle in [0, 1, 8191, 8192, 16383, 5] {
        spi.encoder.borrow_mut().angle = angle;
        assert_eq!(encoder.angle(), Some(angle as u16));
    }
    assert!(!encoder.is_doubtful());
    assert_eq!(spi.encoder.borrow().read[..4], [ANGLECOM, DIAAGC, ANGLECOM, DIAAGC]);
}

#[test]
fn an_encoder_is_doubtful_until_its_first_diagnostics_and_while_its_magnet_is_weak() {
    let (mut encoder, spi) = bench();
    assert!(encoder.is_doubtful());
    encoder.angle();
    encoder.angle();
    assert!(!encoder.is_doubtful());
    spi.encoder.borrow_mut().magnet_low = true;
    encoder.angle();
    encoder.angle();
    assert!(encoder.is_doubtful());
    spi.encoder.borrow_mut().magnet_low = false;
    encoder.angle();
    encoder.angle();
    assert!(!encoder.is_doubtful());
}

#[test]
fn a_flipped_bit_costs_the_angle_only_where_it_hit_the_angle() {
    // The first word of a tick returns diagnostics, the second the angle.
    for (words, hit) in [(0, false), (1, true)] {
        for bit in 0..16 {
            let (mut encoder, spi) = bench();
            encoder.angle();
            encoder.angle();
            spi.encoder.borrow_mut().angle = 77;
            spi.encoder.borrow_mut().flip = Some((words, bit));
            assert_eq!(encoder.angle(), (!hit).then_some(77), "bit {bit}");
            assert_eq!(encoder.angle(), Some(77));
            assert!(!encoder.is_doubtful());
        }
    }
}

/// Flips one bit of a command on the wire.
#[derive(Clone)]
struct Noisy(Spi, Rc<RefCell<u32>>);

impl ErrorType for Noisy {
    type Error = ErrorKind;
}

impl SpiDevice for Noisy {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let mut left = self.1.borrow_mut();
        if *left > 0 {
            *left -= 1;
            if let ([Operation::TransferInPlace(bytes)], 0) = (&mut *operations, *left) {
                bytes[1] ^= 1;
            }
        }
        self.0.transaction(operations)
    }
}

#[test]
fn an_error_flag_is_read_and_cleared_within_two_ticks() {
    let (spi, left) = (Spi::default(), Rc::new(RefCell::new(0)));
    let mut encoder = As5047p::new(Noisy(spi.clone(), left.clone()));
    encoder.angle();
    encoder.angle();
    // The next tick's first command is broken: the encoder flags every word until its error register was read.
    *left.borrow_mut() = 1;
    let angles: Vec<bool> = (0..4).map(|_| encoder.angle().is_some()).collect();
    assert_eq!(angles, [false, false, true, true]);
    assert!(spi.encoder.borrow().read.contains(&ERRFL));
    assert!(!encoder.is_doubtful());
}

#[test]
fn a_bus_that_refuses_is_recovered_from() {
    let (mut encoder, spi) = bench();
    encoder.angle();
    *spi.unplugged.borrow_mut() = true;
    assert_eq!(encoder.angle(), None);
    *spi.unplugged.borrow_mut() = false;
    spi.encoder.borrow_mut().angle = 9;
    assert_eq!(encoder.angle(), Some(9));
}

#[test]
fn turns_are_counted_over_both_ends() {
    let mut turns = Turns::new(2000);
    for step in [1500, -1500] {
        let mut truth = turns.position();
        turns.update(Some((truth & 0x3fff) as u16));
        for _ in 0..100 {
            truth += step;
            turns.update(Some((truth & 0x3fff) as u16));
            assert_eq!((turns.position(), turns.speed(), turns.age_ticks()), (truth, step, 0));
        }
    }
    assert!(!turns.is_lost());
}

#[test]
fn the_first_angle_is_taken_within_half_a_turn_of_zero() {
    for (angle, position) in [(0, 0), (8191, 8191), (8192, -8192), (16383, -1)] {
        let mut turns = Turns::new(100);
        assert_eq!(turns.age_ticks(), u32::MAX);
        turns.update(Some(angle));
        assert_eq!((turns.position(), turns.age_ticks()), (position, 0));
    }
}

#[test]
fn an_impossible_jump_is_refused() {
    let mut turns = Turns::new(100);
    turns.update(Some(500));
    turns.update(Some(601));
    assert_eq!((turns.position(), turns.age_ticks()), (500, 1));
    // After two ticks, twice the step is possible.
    turns.update(Some(601));
    assert_eq!((turns.position(), turns.speed(), turns.age_ticks()), (601, 50, 0));
}

#[test]
fn a_turn_that_cannot_be_known_is_lost_and_stays_lost() {
    let mut turns = Turns::new(2047);
    turns.update(Some(0));
    for _ in 0..3 {
        turns.update(None);
    }
    let mut known = turns;
    known.update(Some(100));
    assert_eq!((known.position(), known.is_lost()), (100, false), "4 times 2047 is less than half a turn");
    turns.update(None);
    turns.update(None);
    assert!(turns.is_lost() && turns.age_ticks() == u32::MAX);
    turns.update(Some(0));
    assert!(turns.is_lost() && turns.age_ticks() == u32::MAX);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn any_walk_within_reach_is_followed_exactly(
        start in -8192..8192_i32,
        steps in proptest::collection::vec((-600..=600_i32, any::<bool>()), 1..300),
    ) {
        let mut turns = Turns::new(600);
        let mut truth = start;
        turns.update(Some((truth & 0x3fff) as u16));
        let mut unread = 0;
        for (step, read) in steps {
            truth += step;
            unread = if read || unread >= 3 { 0 } else { unread + 1 };
            turns.update((unread == 0).then_some((truth & 0x3fff) as u16));
            if unread == 0 {
                prop_assert_eq!(turns.position(), truth);
            }
        }
    }

    #[test]
    fn any_angles_at_all_never_move_further_than_the_reach(
        jump_max in any::<u16>(), angles in proptest::collection::vec(any::<Option<u16>>(), 1..200),
    ) {
        let mut turns = Turns::new(jump_max);
        let mut last = None;
        for angle in angles {
            let unread = turns.age_ticks().saturating_add(1);
            turns.update(angle);
            if let (Some(before), false, 0) = (last, turns.is_lost(), turns.age_ticks()) {
                let moved = i64::from(turns.position()) - i64::from(before);
                prop_assert!(moved.abs() <= i64::from(jump_max) * i64::from(unread) && moved.abs() <= i64::from(COUNTS / 2));
            }
            last = (turns.age_ticks() < u32::MAX).then(|| turns.position());
        }
    }
}
