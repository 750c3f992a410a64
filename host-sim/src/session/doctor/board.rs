//! The firmware on a port: presence, protocol version, and whether it was built from this scene.
//!
//! The check sends a hello that no robot matches. The firmware answers any hello with its own. A hello that does not
//! agree stops its ticks and engages the brakes, so the check can never start an arm.

use super::Check;
use crate::session::serial::{BAUD, SerialError, SerialLink};
use link::{DecodeError, Frame, Hello, PROTOCOL_VERSION, Pacing};
use std::time::{Duration, Instant};

/// Number of hellos sent, and timeout of each answer: at [`BAUD`] an answer takes a millisecond.
const TRIES: u32 = 3;
const ANSWER: Duration = Duration::from_millis(400);

const WIRES: &str = "is the board powered and flashed (`cargo xtask firmware flash`), PA2 wired to the adapter's RX, PA3 to its TX, and ground \
                     to ground (docs/flash.md)?";

/// A hello that matches no firmware, because every firmware has at least one joint.
const NOBODY: Hello = Hello { robot: 0, joints: 0, rate_hz: 0.0, pacing: Pacing::LockStep };

/// Answer of the board.
#[derive(Debug)]
enum Heard {
    Hello(Hello),
    OtherVersion(u8),
    Unreadable(DecodeError),
    Nothing,
}

/// Open the port, ask the board, and compare its answer with the scene's hello, if there is one. Every check is needed,
/// because the user named the port.
#[must_use]
pub fn checks(path: &str, scene: Option<&Hello>) -> Vec<Check> {
    let mut link = match SerialLink::open(path, BAUD) {
        Ok(link) => link,
        Err(error) => return vec![Check::wrong("port", true, error.to_string(), advice(&error))],
    };
    let mut checks = vec![Check::ok("port", format!("{path}, {BAUD} baud"))];
    match ask(&mut link) {
        Ok(heard) => checks.extend(judge(&heard, scene)),
        Err(error) => checks.push(Check::wrong("firmware", true, error.to_string(), advice(&error))),
    }
    checks
}

fn advice(error: &SerialError) -> &'static str {
    if error.is_forbidden() {
        "give this user the right to it: on most Linux systems `sudo usermod -aG dialout $USER`, then log in again"
    } else {
        "is it plugged in, and not open in another program? `host-sim doctor` lists the ports that there are"
    }
}

fn ask(link: &mut SerialLink) -> Result<Heard, SerialError> {
    let mut unreadable = None;
    for _ in 0..TRIES {
        link.send(&Frame::Hello(NOBODY))?;
        let end = Instant::now() + ANSWER;
        loop {
            match link.receive(end.saturating_duration_since(Instant::now())) {
                Ok(Some(received)) => {
                    // Other frames were sent before the question.
                    if let Frame::Hello(hello) = received.frame {
                        return Ok(Heard::Hello(hello));
                    }
                }
                Ok(None) => break,
                Err(SerialError::Undecodable(DecodeError::WrongVersion { theirs })) => {
                    return Ok(Heard::OtherVersion(theirs));
                }
                Err(SerialError::Undecodable(error)) => unreadable = Some(error),
                Err(error) => return Err(error),
            }
            // Bytes may keep coming without an answer; the time limit ends the wait.
            if Instant::now() >= end {
                break;
            }
        }
    }
    Ok(unreadable.map_or(Heard::Nothing, Heard::Unreadable))
}

fn judge(heard: &Heard, scene: Option<&Hello>) -> Vec<Check> {
    const REBUILD: &str = "build and flash it again from this source: `cargo xtask firmware flash`";
    let hello = match heard {
        Heard::Hello(hello) => hello,
        Heard::OtherVersion(theirs) => {
            let found = format!("speaks protocol version {theirs}, expected {PROTOCOL_VERSION}");
            return vec![Check::wrong("firmware", true, found, REBUILD)];
        }
        Heard::Unreadable(error) => {
            let found = format!("bytes that are no packet: {error}");
            return vec![Check::wrong("firmware", true, found, "is this the board's link, and the ground wire there?")];
        }
        Heard::Nothing => return vec![Check::wrong("firmware", true, "does not answer", WIRES)],
    };
    let found = format!("protocol version {PROTOCOL_VERSION}, {}", described(hello));
    let mut checks = vec![Check::ok("firmware", found)];
    if let Some(scene) = scene {
        checks.push(if (Hello { pacing: scene.pacing, ..*hello }) == *scene {
            Check::ok("robot hash", "the scene's")
        } else {
            let found = format!("the firmware has {}, expected {}", described(hello), described(scene));
            Check::wrong("robot hash", true, found, "flash this scene, or name the one that was flashed by --scene")
        });
    }
    checks
}

/// Hash, joints and rate, in the format of `info` and the firmware's own log.
pub(crate) fn described(hello: &Hello) -> String {
    format!("hash {:016x}, {} joints, {} Hz", hello.robot, hello.joints, hello.rate_hz)
}
