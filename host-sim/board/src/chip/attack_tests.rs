//! Attacks by a host without the key on the emulated chip's link. No frame of the attacker has an effect, and no tick of the session is lost.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

mod attacked;

use super::{Chip, ChipError, build_firmware_by_dma};
use crate::key;
use attacked::{AttackedDryRun, KEY, drives, emulator_of, heard_by_a_stranger, hello, scene, started};
use link::{Distrust, Encoder, Frame, HostChannel, Key, Lines, Pacing, Refusal, Request, StateCode, Trust};

#[test]
fn a_whole_session_replayed_to_a_chip_that_has_started_anew_does_nothing() {
    let mut dry_run = AttackedDryRun::armed();
    assert!(drives(&dry_run.tick().0));
    let sent = dry_run.0.sent.clone();
    // The same key after another start: the chip has another random number next to the key.
    let mut anew = started(Some(KEY));
    // The replayed join gets the first challenge, the attacker's own join the second.
    let mut said = heard_by_a_stranger(&mut anew, &sent);
    said.extend(heard_by_a_stranger(&mut anew, &[]));
    assert!(
        !said.iter().any(|frame| matches!(frame, Frame::Status(_) | Frame::Command(_) | Frame::Hello(_))),
        "{said:?}"
    );
    assert!(said.iter().any(|frame| matches!(frame, Frame::Refusal(Refusal::Unauthentic { count: 5.. }))), "{said:?}");
}

#[test]
fn packets_of_the_session_itself_replayed_or_out_of_order_do_nothing_more() {
    let mut dry_run = AttackedDryRun::armed();
    let armed = dry_run.0.sent.clone();
    dry_run.ask(Request::Disarm);
    assert!(!drives(&dry_run.tick().0));
    // The brakes engage.
    let mut ticks = 0;
    while dry_run.tick().0.state == StateCode::Disarming {
        ticks += 1;
        assert!(ticks < 1000);
    }
    // All packets that armed the arm, and the same bytes backwards.
    let packets: Vec<&[u8]> = armed.split_inclusive(|&byte| byte == 0).filter(|packet| packet.len() > 1).collect();
    let refused_before = dry_run.tick().1;
    dry_run.attack(&packets.concat());
    dry_run.attack(&packets.iter().rev().copied().collect::<Vec<_>>().concat());
    let (status, refused) = dry_run.tick();
    assert!(!drives(&status) && status.state == StateCode::Idle, "{status:?}");
    // The joins among them are answered, not refused.
    assert_eq!((refused_before, usize::from(refused)), (0, 2 * (packets.len() - 1)));
    // A request that arrives too late, after a later packet.
    let early = dry_run.packet(&Frame::request(201, Request::Arm));
    dry_run.0.send(&Frame::Alive).unwrap();
    assert_eq!(dry_run.0.receive("a refusal").unwrap(), Frame::Refusal(Refusal::Lost { missed: 1 }));
    dry_run.attack(&early);
    assert!(!drives(&dry_run.tick().0));
}

#[test]
fn a_request_with_a_bit_changed_or_its_seal_cut_short_is_refused_and_the_whole_one_is_granted() {
    let mut dry_run = AttackedDryRun::start();
    dry_run.ask(Request::Home);
    dry_run.ask(Request::Confirm);
    let arm = dry_run.packet(&Frame::request(201, Request::Arm));
    let mut attacks = 0;
    for bit in (0..8 * (arm.len() - 1)).step_by(3) {
        let mut changed = arm.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        // A changed byte may be a zero and so end the packet early. The rest of it is then a packet of its own.
        dry_run.attack(&changed);
        dry_run.attack(&[0]);
        attacks += 1;
    }
    for length in 2..arm.len() - 1 {
        dry_run.attack(&arm[..length]);
        dry_run.attack(&[0]);
        attacks += 1;
    }
    assert!(attacks > 50);
    dry_run.0.emulator.write(&arm).unwrap();
    // The damaged packets were rejected before the intact one was taken. Several packets that arrive at once share a refusal.
    let (status, refusals) = dry_run.tick_after_noise();
    assert!(!refusals.is_empty());
    assert_eq!(status.state, StateCode::Arming);
}

#[test]
fn a_host_with_another_key_gets_nowhere_and_a_forged_proof_gets_no_further() {
    let mut emulator = started(Some(KEY));
    let (mut wrong, other) = (HostChannel::new(Some(Key::new([1; 32]))), Key::new([1; 32]));
    emulator.write(&wrong.join([9; 16]).unwrap()).unwrap();
    let challenge = loop {
        match wrong.push(emulator.read_byte("a challenge").unwrap()) {
            Some(Ok(received)) => break received.frame,
            Some(Err(error)) => panic!("{error}"),
            None => {}
        }
    };
    let Frame::Challenge(challenge) = challenge else { panic!("{challenge:?}") };
    assert_eq!(wrong.answer(&challenge), Err(Distrust::WrongProof));
    // The attacker goes on with a proof and seals of another key.
    let Trust::Key { nonce, .. } = challenge.trust else { panic!("{challenge:?}") };
    let transcript = link::seal::Transcript::new(&[9; 16], &nonce);
    let mut encoder = Encoder::new();
    let mut bytes = encoder.encode(&Frame::Proof(other.proof(link::seal::Side::Host, &transcript))).unwrap().to_vec();
    encoder.seal_with(other.session(link::seal::Side::Host, &transcript).sending);
    for frame in [Frame::Hello(hello(Pacing::DryRun)), Frame::Lines(Lines::CALM), Frame::request(202, Request::Home)] {
        bytes.extend_from_slice(&encoder.encode(&frame).unwrap());
    }
    let said = heard_by_a_stranger(&mut emulator, &bytes);
    // Packets that arrive at once share a refusal, which counts all of them.
    let (_, refusals) = said.split_last().unwrap();
    assert!(refusals.iter().all(|frame| matches!(frame, Frame::Refusal(Refusal::Unauthentic { .. }))), "{said:?}");
    assert_eq!(refusals.last(), Some(&Frame::Refusal(Refusal::Unauthentic { count: 4 })));
}

#[test]
fn a_flood_of_joins_hellos_and_open_stops_disturbs_no_tick_of_the_session() {
    let mut dry_run = AttackedDryRun::running();
    let mut stranger = Encoder::new();
    for round in 1..=20_u16 {
        for _ in 0..5 {
            for frame in [
                Frame::Join(key::random().unwrap()),
                Frame::Hello(hello(Pacing::Live)),
                Frame::request(203, Request::Hold),
                Frame::request(204, Request::Disarm),
            ] {
                let packet = stranger.encode(&frame).unwrap();
                dry_run.attack(&packet);
            }
        }
        let (status, refused) = dry_run.tick();
        assert!(drives(&status) && status.state == StateCode::Running, "{status:?}");
        assert_eq!(refused, 15 * round, "hellos and requests are counted, joins are answered");
    }
}

#[test]
fn without_a_key_there_is_the_bench_and_no_dry_run() {
    let mut emulator = started(None);
    let mut encoder = Encoder::new();
    let dry_run = encoder.encode(&Frame::Hello(hello(Pacing::DryRun))).unwrap();
    let said = heard_by_a_stranger(&mut emulator, &dry_run);
    assert_eq!(said[0], Frame::Refusal(Refusal::NoKey));
    let Some(Frame::Challenge(challenge)) = said.last() else { panic!("{said:?}") };
    assert_eq!((challenge.trust, challenge.own), (Trust::NoKey, hello(Pacing::LockStep)));
    let bench = Chip::over(attacked::emulator(None), hello(Pacing::LockStep));
    let mut bench = bench.unwrap();
    let error = bench.change_pacing(hello(Pacing::DryRun)).unwrap_err();
    assert!(matches!(error, ChipError::Refused(Refusal::NoKey)), "{error}");
    assert!(error.to_string().contains("cargo newtau firmware key write"), "{error}");
}

/// No challenge occurs twice, neither within a start of the chip nor in two starts.
#[test]
fn nonces_do_not_come_again() {
    let mut all = Vec::new();
    for _ in 0..2 {
        let mut emulator = started(Some(KEY));
        for _ in 0..5 {
            let said = heard_by_a_stranger(&mut emulator, &[]);
            let Some(Frame::Challenge(challenge)) = said.last() else { panic!("{said:?}") };
            let Trust::Key { nonce, .. } = challenge.trust else { panic!("{challenge:?}") };
            assert!(!all.contains(&nonce), "{nonce:?}");
            all.push(nonce);
        }
    }
}

/// More garbage than the chip's receive queue holds, so that the last zero byte is dropped too. The stop that follows still acts.
#[test]
fn a_stop_behind_a_flood_of_garbage_stops_the_arm() {
    for garbage in [700, 754, 755, 756, 757, 758, 1000, 3000] {
        a_stop_is_taken(AttackedDryRun::running(), garbage);
    }
}

/// The same with DMA: bytes that were overwritten in the DMA buffer are skipped.
#[test]
fn a_stop_behind_a_flood_of_garbage_stops_the_arm_by_dma_too() {
    let elf = build_firmware_by_dma(&scene()).unwrap();
    for garbage in [378, 379, 700, 756, 757, 758, 759, 1000, 3000] {
        a_stop_is_taken(AttackedDryRun::over(emulator_of(&elf, Some(KEY))).arm().run(), garbage);
    }
}

fn a_stop_is_taken(mut dry_run: AttackedDryRun, garbage: usize) {
    dry_run.attack(&vec![1; garbage]);
    dry_run.attack(&[0]);
    let hold = dry_run.packet(&Frame::request(205, Request::Hold));
    dry_run.0.emulator.write(&hold).unwrap();
    let (status, refusals) = dry_run.tick_after_noise();
    let known = |refusal: &Refusal| matches!(refusal, Refusal::Undecodable(_) | Refusal::Unauthentic { .. });
    assert!(refusals.iter().all(known), "{refusals:?}");
    assert_eq!(status.state, StateCode::Holding, "{garbage} bytes of garbage");
}
