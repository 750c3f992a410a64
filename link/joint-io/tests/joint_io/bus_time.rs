//! The bus time that the schedule is held to, against frames laid out bit by bit.

use actuator_model::wire;
use joint_io::bus_time::{BusLoad, frame_bits};
use proptest::prelude::*;

#[test]
fn three_actuators_a_bus_at_1_mbit_hold_1_khz() {
    let load = BusLoad { actuators: 3, reply_bytes: 6, bit_rate: 1_000_000, turnaround_us: 60 };
    // 3 (135 + 115) bits at a microsecond each, and the last actuator's answer.
    assert_eq!((frame_bits(8), frame_bits(6)), (135, 115));
    assert_eq!((load.bits(), load.time_us()), (750, 810));
    // Commands go out 100 us after the tick began.
    assert_eq!(load.max_rate_hz(100), 1098);
    // Replies of eight bytes still hold it, with 30 us to spare.
    let longer = BusLoad { reply_bytes: 8, ..load };
    assert_eq!((longer.time_us(), longer.max_rate_hz(100)), (870, 1030));
    // Half the bit rate, or six on one bus, do not.
    assert_eq!(BusLoad { bit_rate: 500_000, ..load }.max_rate_hz(100), 602);
    assert_eq!(BusLoad { actuators: 6, ..load }.max_rate_hz(100), 602);
}

#[test]
fn a_frame_can_come_near_its_bound() {
    // Data that stuffs as often as can be: alike in fours after the first five. Identifier, length and check sum do not.
    let worst = (0..=0x7ff_u16).map(|id| wire::length(id, &[0x3c; 8]).max(wire::length(id, &[0x78; 8]))).max();
    let found = worst.unwrap();
    assert!((128..=frame_bits(8)).contains(&found), "{found}");
}

#[test]
fn a_frame_without_stuffing_has_the_bits_of_the_standard() {
    // 44 bits beside the data, and 3 between frames.
    for data in [&[][..], &[0x55; 6], &[0x55; 8]] {
        let bits = wire::stuffed_part(0x555, data);
        assert_eq!(bits.len() + 10, 44 + 8 * data.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn no_frame_is_longer_than_its_bound(id in 0..0x800_u16, data in proptest::collection::vec(
        prop_oneof![any::<u8>(), Just(0), Just(0xff), Just(0x0f), Just(0xf0), Just(0x3c), Just(0x78)], 0..9))
    {
        let length = wire::length(id, &data);
        prop_assert!(length <= frame_bits(data.len() as u32), "{length} bits");
        prop_assert!(length >= 47 + 8 * data.len() as u32);
    }
}
