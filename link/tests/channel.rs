//! Tests of authentication: the handshake, and attempts to get in without the key.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use newtau_link::{
    Access, BoardChannel, DecodeError, Distrust, Encoder, Frame, Hello, HostChannel, Key, Nonce, NonceSource, Pacing,
    Received, Refusal, Request, Trust,
};

const KEY: [u8; 32] = [0x31; 32];
const OTHER: [u8; 32] = [0x32; 32];
const OWN: Hello = Hello { robot: 7, joints: 2, rate_hz: 1000.0, pacing: Pacing::LockStep };
const LIVE: Frame = Frame::Hello(Hello { pacing: Pacing::Live, ..OWN });
const HOLD: Frame = Frame::request(7, Request::Hold);

/// A board and all bytes that it has sent.
struct Board {
    channel: BoardChannel,
    nonces: u8,
    said: Vec<u8>,
}

impl Board {
    fn new(access: Access) -> Self {
        Self { channel: BoardChannel::new(access), nonces: 0, said: Vec::new() }
    }

    /// Sends bytes to the board; returns the frames that it accepts.
    fn hear(&mut self, bytes: &[u8]) -> Vec<Result<Frame, DecodeError>> {
        let mut counting = Vec::new();
        for &byte in bytes {
            let mut nonce = || {
                self.nonces += 1;
                Some(([self.nonces; 16], NonceSource::Counter))
            };
            let received = self.channel.push(byte, &OWN, &mut nonce, &mut |bytes| self.said.extend_from_slice(bytes));
            counting.extend(received.map(|result| result.map(|received| received.frame)));
        }
        counting
    }

    fn says(&mut self, frame: &Frame) -> Vec<u8> {
        let mut said = Vec::new();
        self.channel.send(frame, &mut |bytes| said.extend_from_slice(bytes));
        said
    }
}

/// The frames that a host accepts.
fn heard(host: &mut HostChannel, bytes: &[u8]) -> Vec<Frame> {
    bytes.iter().filter_map(|&byte| host.push(byte)).map(|result: Result<Received, _>| result.unwrap().frame).collect()
}

/// Runs the handshake. Returns all that the host has sent.
fn join(board: &mut Board, host: &mut HostChannel, nonce: Nonce) -> Result<Vec<u8>, Distrust> {
    let mut sent = host.join(nonce).unwrap().to_vec();
    assert_eq!(board.hear(&sent), []);
    let said = core::mem::take(&mut board.said);
    let [Frame::Challenge(challenge)] = heard(host, &said)[..] else { panic!("a challenge") };
    if let Some(packet) = host.answer(&challenge)? {
        assert_eq!(board.hear(&packet), []);
        sent.extend_from_slice(&packet);
    }
    Ok(sent)
}

/// A board with the key and a host in session with it.
fn session() -> (Board, HostChannel) {
    let (mut board, mut host) = (Board::new(Access::Key(&KEY)), HostChannel::new(Some(Key::new(KEY))));
    join(&mut board, &mut host, [9; 16]).unwrap();
    (board, host)
}

/// Number of packets refused so far, from the board's last open refusal.
fn refused_openly(board: &mut Board) -> u16 {
    let said = core::mem::take(&mut board.said);
    let frames = heard(&mut HostChannel::new(None), &said);
    match frames.last() {
        Some(Frame::Refusal(Refusal::Unauthentic { count })) => *count,
        other => panic!("a refusal, not {other:?}"),
    }
}

#[test]
fn host_and_board_with_the_same_key_understand_each_other_both_ways() {
    let (mut board, mut host) = session();
    assert!(host.is_sealed());
    for _ in 0..300 {
        assert_eq!(board.hear(&host.encode(&HOLD).unwrap()), [Ok(HOLD)]);
        let said = board.says(&Frame::Alive);
        assert_eq!(heard(&mut host, &said), [Frame::Alive]);
    }
    assert_eq!(board.said, []);
}

#[test]
fn a_host_talks_to_none_but_the_board_with_its_key() {
    let table = [
        (Access::Key(&KEY), Some(KEY), Ok(())),
        (Access::Key(&OTHER), Some(KEY), Err(Distrust::WrongProof)),
        (Access::Key(&KEY), None, Err(Distrust::KeyNeeded)),
        (Access::NoKey, Some(KEY), Err(Distrust::BoardHasNoKey)),
        (Access::Insecure, Some(KEY), Err(Distrust::BoardIsInsecure)),
        (Access::NoKey, None, Ok(())),
        (Access::Insecure, None, Ok(())),
    ];
    for (access, key, expected) in table {
        let (mut board, mut host) = (Board::new(access), HostChannel::new(key.map(Key::new)));
        let joined = join(&mut board, &mut host, [9; 16]).map(|_| ());
        assert_eq!(joined, expected, "{key:?}");
        assert_eq!(host.is_sealed(), key.is_some() && expected.is_ok());
    }
}

/// Every frame that is not sealed is refused and counted, also a request to hold.
#[test]
fn a_board_with_a_key_refuses_every_open_frame_and_counts_it() {
    let mut board = Board::new(Access::Key(&KEY));
    let mut encoder = Encoder::new();
    for (frame, count) in [(OWN_HELLO, 1), (LIVE, 2), (HOLD, 3), (Frame::Alive, 4), (Frame::Dump, 5)] {
        assert_eq!(board.hear(&encoder.encode(&frame).unwrap()), []);
        assert_eq!(refused_openly(&mut board), count, "{frame:?}");
    }
}

const OWN_HELLO: Frame = Frame::Hello(OWN);

/// Without a key only the bench modes are available; a build that trusts anybody also runs the state machine.
#[test]
fn a_board_without_a_key_is_for_the_bench_alone() {
    let mut encoder = Encoder::new();
    let mut packet = |frame: &Frame| encoder.encode(frame).unwrap();
    let mut board = Board::new(Access::NoKey);
    assert_eq!(board.hear(&packet(&OWN_HELLO)), [Ok(OWN_HELLO)]);
    for pacing in [Pacing::DryRun, Pacing::Live] {
        assert_eq!(board.hear(&packet(&Frame::Hello(Hello { pacing, ..OWN }))), []);
        let said = core::mem::take(&mut board.said);
        assert_eq!(heard(&mut HostChannel::new(None), &said), [Frame::Refusal(Refusal::NoKey)]);
    }
    let mut board = Board::new(Access::Insecure);
    assert_eq!(board.hear(&packet(&LIVE)), [Ok(LIVE)]);
}

/// Packets of one session have no effect in another: the board's nonce is new, and so are the keys.
#[test]
fn a_session_that_is_replayed_as_a_whole_does_nothing() {
    let (mut board, mut host) = (Board::new(Access::Key(&KEY)), HostChannel::new(Some(Key::new(KEY))));
    let mut sent = join(&mut board, &mut host, [9; 16]).unwrap();
    for frame in [LIVE, HOLD, Frame::Alive] {
        let packet = host.encode(&frame).unwrap();
        assert_eq!(board.hear(&packet), [Ok(frame)]);
        sent.extend_from_slice(&packet);
    }
    // Replayed to the same board, in its session, and to one that has restarted but never repeats a nonce.
    let mut anew = Board::new(Access::Key(&KEY));
    anew.nonces = board.nonces;
    for board in [&mut board, &mut anew] {
        assert_eq!(board.hear(&sent), []);
    }
    // The first board still has its session.
    assert_eq!(board.hear(&host.encode(&HOLD).unwrap()), [Ok(HOLD)]);
    // Proof, hello, request and heartbeat.
    assert_eq!(refused_openly(&mut anew), 4);
}

#[test]
fn packets_again_late_reflected_or_of_an_earlier_session_are_refused() {
    let (mut board, mut host) = session();
    let early: Vec<_> = (0..3).map(|_| host.encode(&HOLD).unwrap()).collect();
    assert_eq!(board.hear(&early[2]), [Ok(HOLD)]);
    for packet in &early {
        assert_eq!(board.hear(packet), [], "again, or out of order");
    }
    let reflected = board.says(&HOLD);
    assert_eq!(board.hear(&reflected), [], "what the board said itself");
    let mut second = HostChannel::new(Some(Key::new(KEY)));
    board.said.clear();
    join(&mut board, &mut second, [10; 16]).unwrap();
    assert_eq!(board.hear(&host.encode(&HOLD).unwrap()), [], "of the earlier session");
    assert_eq!(board.hear(&second.encode(&HOLD).unwrap()), [Ok(HOLD)]);
    // The board reports it to the session's host: 3 + 1 + 1 packets.
    let said = core::mem::take(&mut board.said);
    assert_eq!(heard(&mut second, &said), [Frame::Refusal(Refusal::Unauthentic { count: 5 })]);
}

/// A seal protects every bit of the packet, and every bit of its own 8 bytes is checked.
#[test]
fn no_bit_of_a_sealed_packet_can_be_changed_and_no_byte_left_out() {
    let (mut board, mut host) = session();
    let packet = host.encode(&HOLD).unwrap();
    for bit in 0..packet.len() * 8 {
        let mut changed = packet.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        assert!(board.hear(&changed).iter().all(Result::is_err), "bit {bit}");
        board.hear(&[0]);
    }
    let raw = cobs::decode_vec(&packet[..packet.len() - 1]).unwrap();
    for length in 0..raw.len() {
        let mut cut = cobs::encode_vec(&raw[..length]);
        cut.push(0);
        assert!(board.hear(&cut).iter().all(Result::is_err), "{length} bytes");
    }
    assert_eq!(board.hear(&packet), [Ok(HOLD)], "all that has changed nothing");
}

/// The sequence number on the wire has 32 bits, and the seal covers 64: a packet from 2^32 packets ago is refused, whatever number it carries.
#[test]
fn a_forged_sequence_number_does_not_pass() {
    let (mut board, mut host) = session();
    let packet = host.encode(&HOLD).unwrap();
    let raw = cobs::decode_vec(&packet[..packet.len() - 1]).unwrap();
    for number in [1_u32, 2, 255, 256, 1 << 31, u32::MAX] {
        let mut forged = raw.clone();
        forged[1..5].copy_from_slice(&number.to_le_bytes());
        let mut forged = cobs::encode_vec(&forged);
        forged.push(0);
        assert_eq!(board.hear(&forged), []);
    }
    assert_eq!(board.hear(&packet), [Ok(HOLD)]);
}

/// A flood of joins is answered with challenges and does not disturb the session.
#[test]
fn a_flood_of_joins_does_not_end_a_session() {
    let (mut board, mut host) = session();
    let mut stranger = HostChannel::new(Some(Key::new(OTHER)));
    for _ in 0..100 {
        let failed = join(&mut board, &mut stranger, [3; 16]).unwrap_err();
        assert_eq!(failed, Distrust::WrongProof);
        // The stranger answers with a proof made from another key.
        let mut guess = Encoder::new();
        let proof = Key::new(OTHER)
            .proof(newtau_link::seal::Side::Host, &newtau_link::seal::Transcript::new(&[3; 16], &[1; 16]));
        assert_eq!(board.hear(&guess.encode(&Frame::Proof(proof)).unwrap()), []);
        board.said.clear();
        assert_eq!(board.hear(&host.encode(&HOLD).unwrap()), [Ok(HOLD)]);
    }
}

/// A challenge stays valid after a wrong proof; a correct proof uses it up.
#[test]
fn a_challenge_is_answered_once() {
    let mut board = Board::new(Access::Key(&KEY));
    let mut host = HostChannel::new(Some(Key::new(KEY)));
    let joined = host.join([9; 16]).unwrap();
    board.hear(&joined);
    let said = core::mem::take(&mut board.said);
    let [Frame::Challenge(challenge)] = heard(&mut host, &said)[..] else { panic!("a challenge") };
    let right = host.answer(&challenge).unwrap().unwrap();
    let wrong =
        Key::new(OTHER).proof(newtau_link::seal::Side::Host, &newtau_link::seal::Transcript::new(&[9; 16], &[1; 16]));
    board.hear(&Encoder::new().encode(&Frame::Proof(wrong)).unwrap());
    assert_eq!(refused_openly(&mut board), 1);
    board.hear(&right);
    assert_eq!(board.said, []);
    assert_eq!(board.hear(&host.encode(&HOLD).unwrap()), [Ok(HOLD)]);
    // If the same proof were accepted again, the count of packets would restart and earlier packets could be replayed.
    board.hear(&right);
    assert_eq!(board.hear(&host.encode(&HOLD).unwrap()), [Ok(HOLD)]);
}

#[test]
fn a_board_whose_generator_fails_gives_no_challenge() {
    let mut board = BoardChannel::new(Access::Key(&KEY));
    let mut host = HostChannel::new(Some(Key::new(KEY)));
    let mut said = Vec::new();
    for &byte in &host.join([9; 16]).unwrap() {
        board.push(byte, &OWN, &mut || None, &mut |bytes| said.extend_from_slice(bytes));
    }
    assert_eq!(heard(&mut host, &said), [Frame::Refusal(Refusal::NoNonce)]);
}

/// A host in a session ignores open frames, except those of a board that has restarted.
#[test]
fn a_host_in_session_believes_no_open_frame() {
    let (_, mut host) = session();
    let mut encoder = Encoder::new();
    let lost = Frame::Refusal(Refusal::Lost { missed: 1 });
    for frame in [Frame::Alive, lost, Frame::Refusal(Refusal::NoKey), Frame::Past(None)] {
        assert_eq!(heard(&mut host, &encoder.encode(&frame).unwrap()), []);
    }
    assert_eq!(heard(&mut host, &encoder.encode(&OWN_HELLO).unwrap()), [OWN_HELLO]);
}

#[test]
fn keys_are_not_shown() {
    assert_eq!(format!("{:?}", Key::new(KEY)), "Key(..)");
    assert!(!format!("{:?}", HostChannel::new(Some(Key::new(KEY)))).contains("49"));
}

#[test]
fn a_challenge_says_who_the_board_is() {
    let mut board = Board::new(Access::NoKey);
    let mut host = HostChannel::new(None);
    board.hear(&host.join([1; 16]).unwrap());
    let said = core::mem::take(&mut board.said);
    let frames = heard(&mut host, &said);
    assert!(matches!(&frames[..], [Frame::Challenge(c)] if c.own == OWN && c.trust == Trust::NoKey), "{frames:?}");
}

#[test]
fn a_key_page_is_read_back_and_no_bit_of_it_may_be_wrong() {
    use newtau_link::key_page::{KeyPage, LENGTH, write};
    let page = write(&Key::new(KEY), &[5; 16]);
    let read = KeyPage::read(&page).unwrap();
    assert_eq!((read.key(), read.seed), (&KEY, &[5; 16]));
    for bit in 0..LENGTH * 8 {
        let mut changed = page;
        changed[bit / 8] ^= 1 << (bit % 8);
        assert!(KeyPage::read(&changed).is_none(), "bit {bit}");
    }
    // Erased flash, and missing memory.
    assert!(KeyPage::read(&[0xff; LENGTH]).is_none() && KeyPage::read(&[0; LENGTH]).is_none());
}

/// The page lies in the flash that the linker keeps free of the program.
#[test]
fn the_key_page_is_where_the_linker_s_map_has_it() {
    let map =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/memory/stm32f405/chip_memory.x"))
            .unwrap();
    let origin = format!("ORIGIN = {:#010X}", newtau_link::key_page::ADDRESS).replace("0X", "0x");
    let key = map.lines().find(|line| line.trim_start().starts_with("KEY ")).unwrap();
    assert!(key.contains(&origin), "{key}: {origin}");
    assert!(map.contains("_key_page = ORIGIN(KEY);"));
}

/// Noise without a zero merges with the packet after it; a request must not be lost with it.
#[test]
fn a_request_behind_noise_is_taken() {
    let (mut board, mut host) = session();
    let noise: Vec<u8> = (1..=255).cycle().take(700).collect();
    for length in [1, 100, 251, 252, 253, 700] {
        assert_eq!(board.hear(&noise[..length]), []);
        let heard = board.hear(&host.encode(&HOLD).unwrap());
        assert_eq!(heard.last(), Some(&Ok(HOLD)), "{length} bytes of noise");
    }
}

/// However many packets are refused, there is one short answer of each kind, and nothing is sent before `answer` is called.
#[test]
fn a_flood_owes_one_answer_of_each_kind() {
    let mut stranger = Encoder::new();
    let packets: Vec<u8> = (0..1000)
        .flat_map(|i| match i % 4 {
            0 => stranger.encode(&Frame::Join([i as u8; 16])).unwrap().to_vec(),
            1 => stranger.encode(&LIVE).unwrap().to_vec(),
            2 => vec![1, 0],
            _ => vec![7, 7, 7, 7, 7, 0],
        })
        .collect();
    for access in [Access::Key(&KEY), Access::NoKey] {
        let mut board = Board::new(access);
        let mut channel = board.channel;
        let mut counted = 0;
        for &byte in &packets {
            counted += usize::from(channel.take(byte).is_some());
        }
        assert_eq!(counted, 0);
        assert!(channel.owes());
        let mut nonce = || Some(([5; 16], NonceSource::Generator));
        channel.answer(&OWN, &mut nonce, &mut |bytes| board.said.extend_from_slice(bytes));
        assert!(!channel.owes());
        let frames = heard(&mut HostChannel::new(None), &board.said);
        let [Frame::Refusal(Refusal::Undecodable(_)), Frame::Refusal(refusal)] = &frames[..] else {
            panic!("{frames:?}");
        };
        // The challenge is made for the host that sent the join.
        let expected =
            if matches!(access, Access::NoKey) { Refusal::NoKey } else { Refusal::Unauthentic { count: 250 } };
        assert_eq!(*refusal, expected);
        assert!(board.said.len() <= newtau_link::channel::ANSWERS_MAX, "{} bytes", board.said.len());
        assert!(board.said.iter().filter(|byte| **byte == 0).count() == 3, "two refusals and a challenge");
    }
}

/// [`ANSWERS_MAX`] is the length of all answers at their longest.
#[test]
fn the_longest_answers_have_the_stated_length() {
    let long = Hello { robot: u64::MAX, joints: 255, rate_hz: -1.5e-7, pacing: Pacing::Live };
    let (mut board, _) = session();
    for _ in 0..u16::MAX {
        assert_eq!(board.channel.take(5), None);
        assert_eq!(board.channel.take(0), None);
    }
    let mut stranger = Encoder::new();
    for byte in stranger.encode(&Frame::Alive).unwrap().into_iter().cycle().take(200_000) {
        assert_eq!(board.channel.take(byte), None);
    }
    for byte in stranger.encode(&Frame::Join([255; 16])).unwrap() {
        board.channel.take(byte);
    }
    let mut said = 0;
    board.channel.answer(&long, &mut || Some(([255; 16], NonceSource::Counter)), &mut |bytes| said += bytes.len());
    println!("{said} bytes");
    assert!(said <= newtau_link::channel::ANSWERS_MAX, "{said} bytes");
}
