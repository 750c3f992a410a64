//! The firmware on a port: presence, protocol version, and whether it was built from this scene.
//!
//! The check requests a challenge, which reports the board's firmware and whether it has a key. This neither disturbs nor starts a session.

use super::Check;
use crate::session::serial::{BAUD, SerialError, SerialLink};
use link::{Challenge, DecodeError, Distrust, Hello, Key, NonceSource, PROTOCOL_VERSION, Trust};

const WIRES: &str = "is the board powered and flashed (`cargo newtau firmware flash`), PA2 wired to the adapter's RX, PA3 to its TX, and ground \
                     to ground (docs/flash.md)?";

const NO_KEY: &str = "without a key it runs on the bench and does not arm: `cargo newtau firmware key new FILE`, then `cargo newtau firmware key write FILE --board BOARD`";

/// Answer of the board.
#[derive(Debug)]
enum Heard {
    Board(Challenge),
    /// The board's key does not match the key given.
    Distrusted(Distrust),
    OtherVersion(u8),
    Unreadable(DecodeError),
    Nothing,
}

/// Opens the port, queries the board, and compares its answer with the scene's hello, if there is one. All these checks count as needed, because the
/// user named the port.
#[must_use]
pub fn checks(path: &str, scene: Option<&Hello>, key: Option<Key>) -> Vec<Check> {
    let mut link = match SerialLink::open(path, BAUD) {
        Ok(link) => link,
        Err(error) => return vec![Check::wrong("port", true, error.to_string(), error.advice())],
    };
    let mut checks = vec![Check::ok("port", format!("{path}, {BAUD} baud"))];
    match ask(&mut link, key) {
        Ok(heard) => checks.extend(judge(&heard, scene, key.is_some())),
        Err(error) => checks.push(Check::wrong("firmware", true, error.to_string(), error.advice())),
    }
    checks
}

fn ask(link: &mut SerialLink, key: Option<Key>) -> Result<Heard, SerialError> {
    match link.find(key) {
        Ok(None) => Ok(Heard::Nothing),
        Ok(Some(challenge)) => match link.check(&challenge) {
            // A user without a key may still check a board that has one.
            Ok(()) | Err(Distrust::KeyNeeded) => Ok(Heard::Board(challenge)),
            Err(distrust) => Ok(Heard::Distrusted(distrust)),
        },
        Err(SerialError::Undecodable(DecodeError::WrongVersion { theirs })) => Ok(Heard::OtherVersion(theirs)),
        Err(SerialError::Undecodable(error)) => Ok(Heard::Unreadable(error)),
        Err(error) => Err(error),
    }
}

fn judge(heard: &Heard, scene: Option<&Hello>, proved: bool) -> Vec<Check> {
    const REBUILD: &str = "build and flash it again from this source: `cargo newtau firmware flash`";
    let challenge = match heard {
        Heard::Board(challenge) => challenge,
        Heard::Distrusted(distrust) => {
            return vec![Check::wrong("link key", true, distrust.to_string(), "is this the file that it was given?")];
        }
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
    let hello = &challenge.own;
    let found = format!("protocol version {PROTOCOL_VERSION}, {}", described(hello));
    let mut checks = vec![Check::ok("firmware", found), trust(challenge.trust, proved)];
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

/// Reports whether the board has a key, and which.
fn trust(trust: Trust, proved: bool) -> Check {
    match trust {
        Trust::Key { source, .. } => {
            let nonces = match source {
                NonceSource::Generator => "the chip's random number generator",
                NonceSource::Counter => "a stored number and a counter",
            };
            let found = if proved { "this key" } else { "a key; `--key FILE` checks which" };
            Check::ok("link key", format!("{found}; nonces from {nonces}"))
        }
        Trust::NoKey => Check::wrong("link key", false, "none", NO_KEY),
        Trust::Insecure => Check::wrong(
            "link key",
            false,
            "built with --insecure: whoever reaches the wire can drive the arm",
            "build it without --insecure, and give it a key",
        ),
    }
}

/// Hash, joints and rate, in the format of `info` and the firmware's own log.
pub(crate) fn described(hello: &Hello) -> String {
    format!("hash {:016x}, {} joints, {} Hz", hello.robot, hello.joints, hello.rate_hz)
}
