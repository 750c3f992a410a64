//! A measurement as a packet on the wire: encoded, decoded, rejected if a byte is damaged, and counted if it is lost.
//!
//! ```console
//! $ cargo run -p newtau-link --example frames
//! ```

use dynamics_core::{Measurement, Sensed};
use newtau_link::{DecodeError, Decoder, Encoder, Frame, Packet, Received};
use std::error::Error;

/// Passes bytes to a decoder one by one, as a serial port does, and returns the result of the packet that they end.
fn receive(decoder: &mut Decoder, packet: &Packet) -> Option<Result<Received, DecodeError>> {
    packet.iter().fold(None, |result, &byte| decoder.push(byte).or(result))
}

fn main() -> Result<(), Box<dyn Error>> {
    // Position (rad) and velocity (rad/s) of two joints, as the control loop has them.
    let measured = Measurement { sensed: Sensed::State { q: [0.3, 0.7], qd: [1.0, -2.0] }, age_ticks: 0 };
    let frame = |tick| Frame::Measurement(newtau_link::Measurement::new(tick, &measured));

    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    let packet = encoder.encode(&frame(1))?;
    println!("{} bytes: {:02x?}", packet.len(), packet.as_slice());
    // The only zero is the last byte, so a receiver finds the start of the next packet after any error.
    assert_eq!(packet.iter().position(|&byte| byte == 0), Some(packet.len() - 1));

    // Decoded, every number has the bits that it had.
    let received = receive(&mut decoder, &packet).ok_or("the packet has no end")??;
    let Frame::Measurement(decoded) = received.frame else { return Err("another kind of frame".into()) };
    println!("tick {}: {:?}", decoded.tick, decoded.sensed);
    assert_eq!(decoded.to_core::<2>()?, measured);

    // A frame for two joints does not fit a controller of six.
    if let Err(mismatch) = decoded.to_core::<6>() {
        println!("read for six joints: {mismatch}");
    }

    // A flipped bit in any byte is detected. A byte that becomes zero splits the packet into two fragments.
    let second = encoder.encode(&frame(2))?;
    let mut rejected = 0;
    for position in 0..second.len() - 1 {
        let mut damaged = second.clone();
        damaged[position] ^= 0x10;
        let mut fresh = decoder.clone();
        let result = receive(&mut fresh, &damaged);
        assert!(matches!(result, Some(Err(_))), "damage at byte {position} passed: {result:?}");
        rejected += 1;
        if let (8, Some(Err(reason))) = (position, result) {
            println!("byte {position} damaged: {reason}");
        }
    }
    println!("{rejected} damaged packets, all rejected");

    // The second packet never arrives. The third one reports the gap by its sequence number.
    let third = encoder.encode(&frame(3))?;
    let received = receive(&mut decoder, &third).ok_or("the packet has no end")??;
    println!("packets missing before tick 3: {}", received.missed);
    assert_eq!(received.missed, 1);

    // A packet that is played back is rejected.
    let replayed = receive(&mut decoder, &third).ok_or("the packet has no end")?;
    assert_eq!(replayed, Err(DecodeError::Repeated));
    println!("the same packet again: {}", DecodeError::Repeated);
    Ok(())
}
