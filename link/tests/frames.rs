//! Property tests of packets, for every frame and every kind of damage.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use newtau_link::codec::Received;
use newtau_link::{
    Command, Cost, DecodeError, Decoder, Encoder, Fault, Frame, Hello, Joints, Live, Measurement, PACKET_MAX, Pacing,
    Payload, Reference, Refusal, Sensed,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// Every f32, NaNs of every payload included.
fn bits() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits)
}

fn joints<T: Clone + std::fmt::Debug>(one: impl Strategy<Value = T>) -> impl Strategy<Value = Joints<T>> {
    vec(one, 0..=6).prop_map(|values| Joints::from_slice(&values).unwrap())
}

fn cost() -> impl Strategy<Value = Option<Cost>> {
    prop_oneof![
        Just(None),
        any::<u32>().prop_map(|n| Some(Cost::Instructions(n))),
        any::<u32>().prop_map(|n| Some(Cost::Cycles(n))),
    ]
}

fn all<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    vec(bits(), N).prop_map(|values| values.try_into().unwrap())
}

fn live() -> impl Strategy<Value = Live> {
    let payload = (bits(), all::<3>(), all::<6>()).prop_map(|(mass, first_moment, inertia)| Payload {
        mass,
        first_moment,
        inertia,
    });
    (all::<3>(), all::<6>(), payload, joints(bits())).prop_map(|(gravity, tip_wrench, payload, rotor)| Live {
        gravity,
        tip_wrench,
        payload,
        rotor,
    })
}

fn frames() -> impl Strategy<Value = Frame> {
    let sensed = prop_oneof![
        (joints(bits()), joints(bits())).prop_map(|(q, qd)| Sensed::State { q, qd }),
        joints(any::<i32>()).prop_map(Sensed::Counts),
    ];
    let error = prop_oneof![
        Just(DecodeError::BadCrc),
        any::<u8>().prop_map(|theirs| DecodeError::WrongVersion { theirs }),
        any::<u8>().prop_map(|tag| DecodeError::UnknownFrame { tag }),
    ];
    let refusal = prop_oneof![
        error.prop_map(Refusal::Undecodable),
        any::<u8>().prop_map(|missed| Refusal::Lost { missed }),
        Just(Refusal::NoHello),
        Just(Refusal::Driven),
        any::<(u8, u8)>().prop_map(|(expected, found)| Refusal::JointCount { expected, found }),
        Just(Refusal::OtherRobot),
        Just(Refusal::NoReference),
        Just(Refusal::Unexpected),
        Just(Refusal::NonFiniteLive),
    ];
    prop_oneof![
        ((any::<u64>(), any::<u8>(), bits()), prop_oneof![Just(Pacing::LockStep), Just(Pacing::Timer)])
            .prop_map(|((robot, joints, rate_hz), pacing)| Frame::Hello(Hello { robot, joints, rate_hz, pacing })),
        (any::<u32>(), any::<u32>(), sensed)
            .prop_map(|(tick, age_ticks, sensed)| { Frame::Measurement(Measurement { tick, age_ticks, sensed }) }),
        (joints(bits()), joints(bits()), joints(bits())).prop_map(|(q, qd, qdd)| Frame::Reference(Reference {
            q,
            qd,
            qdd
        })),
        (any::<u32>(), joints(bits()), joints(any::<u8>()), cost())
            .prop_map(|(tick, torque, limits, cost)| Frame::Command(Command { tick, torque, limits, cost })),
        any::<(u32, u8, Option<u8>)>().prop_map(|(tick, code, joint)| Frame::Fault(Fault { tick, code, joint })),
        refusal.prop_map(Frame::Refusal),
        live().prop_map(Frame::Live),
    ]
}

/// The contents of a frame as bits: `==` on floats is never true for NaN.
fn all_bits(frame: &Frame) -> Vec<u8> {
    postcard::to_slice(frame, &mut [0; 128]).unwrap().to_vec()
}

fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<Received, DecodeError>> {
    bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

fn only_frame(results: &[Result<Received, DecodeError>]) -> &Received {
    match results {
        [Ok(received)] => received,
        other => panic!("expected one good frame, got {other:?}"),
    }
}

/// Live inputs of six joints with a symmetric tensor; all numbers differ.
fn live_of_six() -> dynamics_core::Live<f32, 6> {
    let payload = Payload { mass: 1.5, first_moment: [0.1, -0.2, 0.3], inertia: [1.0, 2.0, 3.0, 0.4, 0.5, -0.0] };
    let rotor = Joints::from_slice(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).unwrap();
    let tip_wrench = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    Live { gravity: [0.5, -0.0, -9.81], tip_wrench, payload, rotor }.to_core().unwrap()
}

/// Every bit of live inputs, also of the numbers that a frame does not carry.
fn live_bits(live: &dynamics_core::Live<f32, 6>) -> Vec<u32> {
    let dynamics_core::Live { gravity, payload, tip_wrench, rotor } = live;
    let vectors = [gravity, &tip_wrench.force, &tip_wrench.moment, &payload.first_moment];
    let numbers = vectors.into_iter().flat_map(|v| v.iter()).chain(&payload.about_origin).chain([&payload.mass]);
    numbers.chain(rotor).map(|x| x.to_bits()).collect()
}

proptest! {
    #[test]
    fn live_inputs_go_to_the_control_loop_and_back_with_the_very_bits(mut live in live(), rotor in all::<6>()) {
        live.rotor = Joints::from_slice(&rotor).unwrap();
        let back = Live::new(&live.to_core::<6>().unwrap()).unwrap();
        prop_assert_eq!(all_bits(&Frame::Live(back)), all_bits(&Frame::Live(live)));
    }

    #[test]
    fn every_frame_comes_back_with_the_very_bits(frame in frames()) {
        let packet = Encoder::new().encode(&frame).unwrap();
        let results = decode(&mut Decoder::new(), &packet);
        let received = only_frame(&results);
        prop_assert_eq!(all_bits(&received.frame), all_bits(&frame));
        prop_assert_eq!(received.missed, 0);
    }

    #[test]
    fn a_packet_has_one_zero_and_it_is_the_last_byte(frame in frames()) {
        let packet = Encoder::new().encode(&frame).unwrap();
        prop_assert!(packet.len() <= PACKET_MAX);
        prop_assert_eq!(packet.iter().position(|&byte| byte == 0), Some(packet.len() - 1));
    }

    #[test]
    fn every_single_bit_flip_is_detected(frame in frames()) {
        let packet = Encoder::new().encode(&frame).unwrap();
        for bit in 0..packet.len() * 8 {
            let mut damaged = packet.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            let results = decode(&mut Decoder::new(), &damaged);
            prop_assert!(results.iter().all(Result::is_err), "bit {} passed: {:?}", bit, results);
        }
    }

    #[test]
    fn a_truncated_packet_is_an_error_and_the_next_is_read(frame in frames(), next in frames(), cut in any::<prop::sample::Index>()) {
        let mut encoder = Encoder::new();
        let first = encoder.encode(&frame).unwrap();
        let keep = 1 + cut.index(first.len() - 2);
        let mut decoder = Decoder::new();
        let mut bytes = first[..keep].to_vec();
        bytes.push(0);
        prop_assert!(matches!(decode(&mut decoder, &bytes)[..], [Err(_)]));
        let second = encoder.encode(&next).unwrap();
        let results = decode(&mut decoder, &second);
        prop_assert_eq!(all_bits(&only_frame(&results).frame), all_bits(&next));
    }

    #[test]
    fn garbage_never_passes_for_a_frame_and_the_next_frame_is_read(
        garbage in vec(any::<u8>(), 0..600), frame in frames()
    ) {
        let mut decoder = Decoder::new();
        let results = decode(&mut decoder, &garbage);
        prop_assert!(results.iter().all(Result::is_err), "{:?}", results);
        decode(&mut decoder, &[0]);
        let packet = Encoder::new().encode(&frame).unwrap();
        let results = decode(&mut decoder, &packet);
        prop_assert_eq!(all_bits(&only_frame(&results).frame), all_bits(&frame));
    }

    #[test]
    fn lost_packets_are_counted(first in frames(), lost in 1_u16..1000, last in frames()) {
        let mut encoder = Encoder::new();
        let mut decoder = Decoder::new();
        decode(&mut decoder, &encoder.encode(&first).unwrap());
        for _ in 0..lost {
            encoder.encode(&first).unwrap();
        }
        let results = decode(&mut decoder, &encoder.encode(&last).unwrap());
        let begins = matches!(last, Frame::Hello(_) | Frame::Join(_) | Frame::Proof(_) | Frame::Challenge(_));
        prop_assert_eq!(only_frame(&results).missed, if begins { 0 } else { u32::from(lost) });
    }
}

/// Repeated packets are recognised, however many there are, and new packets after them are accepted.
#[test]
fn packets_that_come_again_are_known_for_it_and_change_nothing() {
    let mut encoder = Encoder::new();
    let mut packets: Vec<_> = (0..1000).map(|_| encoder.encode(&Frame::Alive).unwrap()).collect();
    let new = packets.split_off(999);
    for replayed in [1, 3, 100, 128, 999] {
        let mut decoder = Decoder::new();
        for packet in &packets {
            assert_eq!(only_frame(&decode(&mut decoder, packet)).missed, 0);
        }
        let last = &packets[packets.len() - replayed..];
        for packet in last.iter().rev().chain(last) {
            assert_eq!(decode(&mut decoder, packet), [Err(DecodeError::Repeated)]);
        }
        assert_eq!(only_frame(&decode(&mut decoder, &new[0])).missed, 0, "{replayed} replayed");
    }
}

/// However many packets are lost, the next one is accepted, and the one after it reports no loss.
#[test]
fn a_gap_of_any_length_costs_nothing_behind_it() {
    for gap in [1, 2, 127, 128, 129, 254, 255, 256, 300, 100_000] {
        let mut encoder = Encoder::new();
        let mut decoder = Decoder::new();
        let mut next = || encoder.encode(&Frame::Alive).unwrap();
        decode(&mut decoder, &next());
        (0..gap).for_each(|_| drop(next()));
        let missed = only_frame(&decode(&mut decoder, &next())).missed;
        assert_eq!(missed, gap);
        assert_eq!(only_frame(&decode(&mut decoder, &next())).missed, 0, "behind a gap of {gap}");
    }
}

/// A packet with this version and payload, and a correct check sum.
fn forge(version: u8, payload: &[u8]) -> Vec<u8> {
    let mut raw = vec![version, 0, 0, 0, 0];
    raw.extend_from_slice(payload);
    let check = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&raw);
    raw.extend_from_slice(&check.to_le_bytes());
    let mut packet = cobs::encode_vec(&raw);
    packet.push(0);
    packet
}

#[test]
fn each_way_of_being_wrong_has_its_name() {
    let version = newtau_link::PROTOCOL_VERSION;
    let mut bad_crc = Encoder::new().encode(&Frame::Refusal(Refusal::NoHello)).unwrap();
    let last = bad_crc.len() - 2;
    bad_crc[last] ^= 0x40;
    let mut overlong = vec![7; PACKET_MAX + 1];
    overlong.push(0);
    let table: [(&[u8], DecodeError); 8] = [
        (&overlong, DecodeError::TooLong),
        (&[3, 1, 2, 0], DecodeError::TooShort),
        (&[9, 1, 0], DecodeError::BadCobs),
        (&bad_crc, DecodeError::BadCrc),
        (&forge(version + 1, &[5, 2]), DecodeError::WrongVersion { theirs: version + 1 }),
        (&forge(version, &[]), DecodeError::TooShort),
        (&forge(version, &[Frame::KINDS, 0]), DecodeError::UnknownFrame { tag: Frame::KINDS }),
        (&forge(version, &[5, 2, 0]), DecodeError::Malformed),
    ];
    for (bytes, expected) in table {
        assert_eq!(decode(&mut Decoder::new(), bytes), [Err(expected)], "{bytes:?}");
    }
}

#[test]
fn the_number_of_kinds_is_the_number_of_tags() {
    let tag = |tag: u8| {
        // Enough zeros for the longest frame: every field of a known kind reads as zero.
        let mut bytes = [0; 128];
        bytes[0] = tag;
        postcard::take_from_bytes::<Frame>(&bytes).is_ok()
    };
    assert!((0..Frame::KINDS).all(tag));
    // From 128 on a tag has two bytes.
    assert!((Frame::KINDS..128).all(|t| !tag(t)));
}

#[test]
fn a_frame_for_another_arm_is_refused_by_its_joint_count() {
    let reference = dynamics_core::Reference { q: [0.0; 3], qd: [0.0; 3], qdd: [0.0; 3] };
    let mismatch = newtau_link::Reference::new(&reference).to_core::<2>().unwrap_err();
    assert_eq!(mismatch.to_string(), "frame has values for 3 joints, expected 2");
}

#[test]
fn live_inputs_of_six_joints_fit_a_packet_and_arrive_where_they_belong() {
    let live = live_of_six();
    let packet = Encoder::new().encode(&Frame::Live(Live::new(&live).unwrap())).unwrap();
    assert_eq!(packet.len(), 113);
    let results = decode(&mut Decoder::new(), &packet);
    let Frame::Live(frame) = &only_frame(&results).frame else { panic!("live inputs") };
    assert_eq!(live_bits(&frame.to_core().unwrap()), live_bits(&live));
}

#[test]
fn live_inputs_for_another_arm_are_refused_by_their_joint_count() {
    let mismatch = Live::new(&live_of_six()).unwrap().to_core::<4>().unwrap_err();
    assert_eq!(mismatch.to_string(), "frame has values for 6 joints, expected 4");
}

#[test]
fn a_payload_that_is_not_symmetric_to_the_last_bit_is_refused_by_its_entry() {
    for (entry, i, j) in [("xy", 1, 0), ("xz", 2, 0), ("yz", 2, 1)] {
        let mut live = live_of_six();
        let x = &mut live.payload.about_origin[(i, j)];
        *x = f32::from_bits(x.to_bits() ^ 1);
        assert!(Live::new(&live).unwrap_err().to_string().contains(&format!("not symmetric in {entry}")));
        live.payload = live.payload.symmetric();
        assert_eq!(live_bits(&live), live_bits(&live_of_six()));
    }
}

#[test]
fn a_single_number_that_is_not_finite_is_found_wherever_it_is() {
    let finite = Live::new(&live_of_six()).unwrap();
    assert!(finite.is_finite());
    let places: [fn(&mut Live) -> &mut f32; 6] = [
        |live| &mut live.gravity[2],
        |live| &mut live.tip_wrench[5],
        |live| &mut live.payload.mass,
        |live| &mut live.payload.first_moment[2],
        |live| &mut live.payload.inertia[5],
        |live| &mut live.rotor[5],
    ];
    for (index, place) in places.iter().enumerate() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut live = finite.clone();
            *place(&mut live) = bad;
            assert!(!live.is_finite(), "place {index}: {bad}");
        }
    }
}
