//! Tests of the bus time of a schedule, against frames laid out bit by bit.

use super::drive;
use actuator_model::wire;
use dynamics_core::drive::{DataRate, MitDrive};
use joint_io::bus_time::{Bits, BusLoad, Identifier, LEAD_US, classic_bits, fd_bits};
use proptest::prelude::*;

const THREE: BusLoad = BusLoad {
    actuators: 3,
    identifier: Identifier::Standard,
    reply_bytes: 6,
    bit_rate: 1_000_000,
    data_rate: None,
    turnaround_us: 60,
};

#[test]
fn three_actuators_a_bus_at_1_mbit_hold_1_khz() {
    // 3 (135 + 115) bits of 1 us each, plus 60 us for the turnaround.
    assert_eq!((classic_bits(Identifier::Standard, 8), classic_bits(Identifier::Standard, 6)), (135, 115));
    assert_eq!((THREE.bits(), THREE.time_us()), (Bits { nominal: 750, data: 0 }, 810));
    // Commands go out 100 us after the tick began.
    assert_eq!(THREE.max_rate_hz(LEAD_US), 1098);
    // Replies of eight bytes still permit 1 kHz, with 30 us to spare.
    let longer = BusLoad { reply_bytes: 8, ..THREE };
    assert_eq!((longer.time_us(), longer.max_rate_hz(100)), (870, 1030));
    // Half the bit rate, six actuators on one bus, or longer identifiers do not.
    assert_eq!(BusLoad { bit_rate: 500_000, ..THREE }.max_rate_hz(100), 602);
    assert_eq!(BusLoad { actuators: 6, ..THREE }.max_rate_hz(100), 602);
    assert_eq!(BusLoad { identifier: Identifier::Extended, ..longer }.max_rate_hz(100), 892);
}

#[test]
fn frames_have_the_worst_lengths_of_the_literature() {
    // Davis et al., eq. 2 and the sentence after it: 55 + 10 n and 80 + 10 n.
    for bytes in 0..=8 {
        assert_eq!(classic_bits(Identifier::Standard, bytes), 55 + 10 * bytes);
        assert_eq!(classic_bits(Identifier::Extended, bytes), 80 + 10 * bytes);
    }
    // FD: 33 or 57 bits of arbitration and end; 33 + 10 n of the rest, 5 more with the longer check sum.
    for (bytes, data) in [(0, 33), (6, 93), (8, 113), (12, 153), (16, 193), (20, 238), (64, 678)] {
        assert_eq!(fd_bits(Identifier::Standard, bytes), Bits { nominal: 33, data });
        assert_eq!(fd_bits(Identifier::Extended, bytes), Bits { nominal: 57, data });
    }
    // Padded to the next permitted length.
    assert_eq!(fd_bits(Identifier::Standard, 9), fd_bits(Identifier::Standard, 12));
    assert_eq!(fd_bits(Identifier::Standard, 33), fd_bits(Identifier::Standard, 48));
}

/// Load of six drives with replies of eight bytes on their busiest bus.
fn busiest(on_bus: impl Fn(u8) -> u8, data_rate: Option<DataRate>) -> BusLoad {
    let drives: [MitDrive; 6] =
        std::array::from_fn(|i| MitDrive { data_rate, reply_bytes: 8, ..drive(on_bus(i as u8), i as u8 + 1) });
    let load = (0..3).map(|bus| BusLoad::of(&drives, bus, Identifier::Standard));
    load.max_by_key(BusLoad::frames_ns).unwrap()
}

#[test]
fn six_joints_at_1_khz_leave_a_third_of_an_fd_bus_and_nearly_half_of_three_classic_ones() {
    let three = busiest(|i| i / 2, None);
    assert_eq!((three.actuators, three.frames_ns(), three.slack_percent(1000)), (2, 540_000, 46));
    assert_eq!(three.max_rate_hz(LEAD_US), 1428);
    let fd = busiest(|_| 0, Some(DataRate::Mbit5));
    // 12 (33 us + 113 / 5 us).
    assert_eq!((fd.actuators, fd.frames_ns(), fd.slack_percent(1000)), (6, 667_200, 33));
    assert_eq!((fd.time_us(), fd.max_rate_hz(LEAD_US)), (728, 1207));
    // Neither 2 Mbit/s nor classic frames permit 1 kHz.
    let slower = busiest(|_| 0, Some(DataRate::Mbit2));
    assert_eq!((slower.frames_ns(), slower.slack_percent(1000), slower.max_rate_hz(LEAD_US)), (1_074_000, 0, 810));
    let classic = busiest(|_| 0, None);
    assert_eq!((classic.frames_ns(), classic.slack_percent(1000), classic.max_rate_hz(LEAD_US)), (1_620_000, 0, 561));
}

#[test]
fn no_bit_rate_is_no_rate() {
    let none = BusLoad { bit_rate: 0, ..THREE };
    assert_eq!((none.time_us(), none.max_rate_hz(0), none.slack_percent(1)), (u32::MAX, 0, 0));
    let none = BusLoad { data_rate: Some(0), ..THREE };
    assert_eq!((none.time_us(), none.max_rate_hz(0)), (u32::MAX, 0));
    // An empty bus needs only the turnaround.
    let empty = BusLoad { actuators: 0, ..THREE };
    assert_eq!((empty.time_us(), empty.slack_percent(1000)), (60, 100));
}

#[test]
fn a_frame_can_come_near_its_bound() {
    // Data with the most stuff bits: groups of four equal bits after the first five. Identifier, length and check sum do not reach that.
    let worst =
        (0..=0x7ff).map(|id| wire::length(id, false, &[0x3c; 8]).max(wire::length(id, false, &[0x78; 8]))).max();
    let found = worst.unwrap();
    assert!((128..=classic_bits(Identifier::Standard, 8)).contains(&found), "{found}");
    let long = (0..=0x1fff_ffff_u32).step_by(99_991).map(|id| wire::length(id, true, &[0x3c; 8])).max().unwrap();
    assert!((144..=classic_bits(Identifier::Extended, 8)).contains(&long), "{long}");
}

#[test]
fn an_fd_frame_can_come_within_a_bit_of_its_bound() {
    for (bytes, short) in [(8, 1), (64, 0)] {
        let bound = fd_bits(Identifier::Standard, bytes);
        let lengths = [0x78_u8, 0x3c, 0xe1, 0xc3, 0x87, 0x0f, 0xf0, 0x1e].into_iter().flat_map(|byte| {
            [false, true].map(|passive| wire::fd_length(0x078, false, passive, &vec![byte; bytes as usize]))
        });
        let worst = lengths.max_by_key(|length| length.data).unwrap();
        assert_eq!((worst.nominal, worst.data), (bound.nominal, bound.data - short), "{bytes} bytes");
    }
    // SRR and IDE, which are recessive, break the fours of an extended identifier.
    let lows = (0..8).map(|turn| 0x0f0f_0f0f_u32.rotate_left(turn) & 0x3_ffff);
    let ids = lows.flat_map(|low| (0..0x800).map(move |high| high << 18 | low));
    let worst = ids.map(|id| wire::fd_length(id, true, false, &[]).nominal).max().unwrap();
    assert_eq!(worst, fd_bits(Identifier::Extended, 0).nominal - 1);
}

#[test]
fn a_frame_without_stuffing_has_the_bits_of_the_standard() {
    // 44 bits in addition to the data, and 3 between frames.
    for data in [&[][..], &[0x55; 6], &[0x55; 8]] {
        let bits = wire::stuffed_part(0x555, false, data);
        assert_eq!(bits.len() + 10, 44 + 8 * data.len());
        let bits = wire::stuffed_part(0x1555_5555, true, data);
        assert_eq!(bits.len() + 10, 64 + 8 * data.len());
    }
    // FD: 17 bits and 10 after the check sum, with the space 30; of the data rate 5 + 8 n + 4 + 17 + 6, or 21 + 7.
    let short = wire::fd_length(0x555, false, false, &[0x55; 8]);
    assert_eq!((short.nominal, short.data), (30, 96));
    let long = wire::fd_length(0x555, false, false, &[0x55; 20]);
    assert_eq!((long.nominal, long.data), (30, 197));
}

/// Bytes that cause many stuff bits, and arbitrary ones.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![any::<u8>(), Just(0), Just(0xff), Just(0x0f), Just(0xf0), Just(0x3c), Just(0x78)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn no_frame_is_longer_than_its_bound(id in 0..0x2000_0000_u32, data in proptest::collection::vec(byte(), 0..9)) {
        for (extended, identifier, least) in [(false, Identifier::Standard, 47), (true, Identifier::Extended, 67)] {
            let id = if extended { id } else { id >> 18 };
            let length = wire::length(id, extended, &data);
            prop_assert!(length <= classic_bits(identifier, data.len() as u32), "{length} bits");
            prop_assert!(length >= least + 8 * data.len() as u32);
        }
    }

    #[test]
    fn no_fd_frame_is_longer_than_its_bound(
        id in 0..0x2000_0000_u32, passive in any::<bool>(), alike in any::<bool>(), code in 0..16_usize,
        data in proptest::collection::vec(byte(), 64),
    ) {
        const LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
        let data = if alike { vec![data[0]; LENGTHS[code]] } else { data[..LENGTHS[code]].to_vec() };
        for (extended, identifier, least) in [(false, Identifier::Standard, 30), (true, Identifier::Extended, 49)] {
            let id = if extended { id } else { id >> 18 };
            let (length, bound) = (wire::fd_length(id, extended, passive, &data), fd_bits(identifier, data.len() as u32));
            prop_assert!(length.nominal <= bound.nominal && length.data <= bound.data, "{length:?}, {bound:?}");
            prop_assert!(length.nominal >= least && length.data >= 32 + 8 * data.len() as u32, "{length:?}");
        }
    }
}
