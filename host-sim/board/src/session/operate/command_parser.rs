//! The line that an operator types as a command: one command a line.

use super::command::{Command, HELP};
use super::device::Cut;
use super::feel::{SOFT, STIFF};
use super::parameters;
use dynamics_core::control::ControlLaw;
use link::{Request, Setting};
use robot_compiler::names::named;

/// Longest time between two targets of another program, if the command `follow` gives none and at most, s.
const PATIENCE: f64 = 0.25;
const PATIENCE_MAX: f64 = 5.0;

/// Requests that have commands of their own, because the operator does more than pass them on.
const OWN: [&str; 5] = ["run", "disarm", "stop", "full-range", "release"];

/// Parses a line. `joints` are the names of the joints, base first.
///
/// # Errors
/// Description of the error: the field, the value found, and the value expected.
pub fn parse(line: &str, joints: &[String]) -> Result<Command, String> {
    let line = line.split('#').next().unwrap_or_default();
    let words: Vec<&str> = line.split_whitespace().collect();
    let Some((&name, arguments)) = words.split_first() else { return Ok(Command::Nothing) };
    if let Some((request, _)) = Request::NAMES.iter().find(|(_, word)| *word == name && !OWN.contains(word)) {
        return none(name, arguments, Command::Ask(*request));
    }
    match (name, arguments) {
        ("help", _) => none(name, arguments, Command::Help),
        ("status", _) => none(name, arguments, Command::Status),
        ("run", _) => none(name, arguments, Command::Run),
        ("press", _) => none(name, arguments, Command::EmergencyStop(true)),
        ("release", _) => none(name, arguments, Command::EmergencyStop(false)),
        ("disarm" | "disarm!", _) => none(name, arguments, Command::Disarm(name.ends_with('!'))),
        ("full-range", _) => none(name, arguments, Command::FullRange),
        ("erase", _) => none(name, arguments, Command::Erase),
        ("park", _) => none(name, arguments, Command::Park),
        ("stop" | "s", _) => none(name, arguments, Command::Stop),
        ("quit" | "quit!", _) => none(name, arguments, Command::Quit(name.ends_with('!'))),
        ("cut" | "plug", ["host"]) => Ok(Command::Cut(Cut::Host, name == "cut")),
        ("cut" | "plug", ["bus", number]) => match number.parse() {
            Ok(bus @ 1..=3) => Ok(Command::Cut(Cut::Bus(bus - 1), name == "cut")),
            _ => Err(format!("{name}: bus {number}, expected 1 to 3")),
        },
        ("cut" | "plug", ["drive", which]) => Ok(Command::Cut(Cut::Drive(joint(name, which, joints)?), name == "cut")),
        ("jog", [which, delta, time @ ..]) if time.len() < 2 => {
            let time = time.first().map(|time| seconds(name, time)).transpose()?;
            Ok(Command::Jog(joint(name, which, joints)?, number(name, "DELTA", delta)?, time))
        }
        ("jog", _) => Err(format!("jog: {} words, expected JOINT DELTA [SECONDS]", arguments.len())),
        ("goto", positions) if positions.len() == joints.len() || positions.len() == joints.len() + 1 => {
            let (positions, time) = positions.split_at(joints.len());
            let q = positions.iter().map(|q| number(name, "a position", q)).collect::<Result<_, _>>()?;
            Ok(Command::Goto(q, time.first().map(|time| seconds(name, time)).transpose()?))
        }
        ("goto", _) => {
            Err(format!("goto: {} numbers, expected {} positions and at most one time", arguments.len(), joints.len()))
        }
        ("get", words) => parameters::of_words(name, words, joints).map(Command::Get),
        ("set", [which @ .., value]) => match parameters::of_words(name, which, joints)?.as_slice() {
            [index] => Ok(Command::Set(Setting { index: *index, value: number(name, "VALUE", value)? as f32 })),
            _ => Err(format!("set: {} VALUE: expected JOINT NAME VALUE", which.join(" "))),
        },
        ("payload", [mass, place @ ..]) if place.is_empty() || place.len() == 3 => {
            let mass = number(name, "MASS", mass)?;
            let place = place.iter().map(|x| number(name, "a place", x)).collect::<Result<Vec<_>, _>>()?;
            Ok(Command::Payload(mass, [0, 1, 2].map(|axis| place.get(axis).copied().unwrap_or(0.0))))
        }
        ("weigh", _) => none(name, arguments, Command::Weigh),
        ("law", [law]) => named(law).map(Command::Law).map_err(|expected| format!("law: {expected}")),
        ("teach", _) => none(name, arguments, Command::Law(ControlLaw::Teach)),
        ("soft", _) => none(name, arguments, Command::Stiffness(SOFT)),
        ("stiff", _) => none(name, arguments, Command::Stiffness(STIFF)),
        ("stiffness", [factor]) => match number(name, "FACTOR", factor)? {
            factor if (SOFT..=STIFF).contains(&factor) => Ok(Command::Stiffness(factor)),
            factor => Err(format!("stiffness: FACTOR is {factor}, expected {SOFT} to {STIFF}")),
        },
        ("check-torque", []) => Ok(Command::CheckTorque(None)),
        ("check-torque", [which]) => Ok(Command::CheckTorque(Some(joint(name, which, joints)?))),
        ("follow", []) => Ok(Command::Follow(PATIENCE)),
        ("follow", [time]) => match seconds(name, time)? {
            time if time <= PATIENCE_MAX => Ok(Command::Follow(time)),
            time => Err(format!("follow: SECONDS is {time}, expected {PATIENCE_MAX} at most")),
        },
        ("wait", []) => Ok(Command::Wait(None)),
        ("wait", [time]) => Ok(Command::Wait(Some(seconds(name, time)?))),
        ("watch", [every]) => {
            every.parse().map(Command::Watch).map_err(|_| format!("watch: {every}: expected a whole number of ticks"))
        }
        ("dump", []) => Ok(Command::Dump(None)),
        ("dump", [file]) => Ok(Command::Dump(Some(file.into()))),
        ("record", ["off"]) => Ok(Command::Record(None)),
        ("record", [file]) => Ok(Command::Record(Some(file.into()))),
        (
            "follow" | "wait" | "watch" | "dump" | "record" | "set" | "payload" | "law" | "stiffness" | "check-torque"
            | "cut" | "plug",
            _,
        ) => {
            let usage = HELP.iter().filter(|(usage, _)| usage.split(' ').next() == Some(name));
            let usage: Vec<_> = usage.map(|(usage, _)| *usage).collect();
            Err(format!("{name}: {} words, expected {}", arguments.len(), usage.join(" or ")))
        }
        _ => Err(format!("{name}: no such command; `help` lists them")),
    }
}

fn none(name: &str, arguments: &[&str], command: Command) -> Result<Command, String> {
    match arguments {
        [] => Ok(command),
        [first, ..] => Err(format!("{name}: {first}: expected nothing behind it")),
    }
}

fn number(name: &str, what: &str, word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{name}: {what} is {word}, expected a number")),
    }
}

fn seconds(name: &str, word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e5 => Ok(value),
        _ => Err(format!("{name}: SECONDS is {word}, expected a time above zero, 1e5 at most")),
    }
}

fn joint(name: &str, word: &str, joints: &[String]) -> Result<usize, String> {
    parameters::joint(word, joints).ok_or_else(|| {
        format!("{name}: JOINT is {word}, expected a number from 1 to {} or one of {}", joints.len(), joints.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::{Command, HELP, parse};
    use link::{Request, Setting};

    fn read(line: &str) -> Result<Command, String> {
        parse(line, &["shoulder".into(), "elbow".into()])
    }

    #[test]
    fn every_command_is_read() {
        let jog = Command::Jog(1, -0.2, Some(1.5));
        assert_eq!((read("jog 2 -0.2 1.5"), read("  jog elbow -2e-1 1.5 # down")), (Ok(jog.clone()), Ok(jog)));
        assert_eq!(read("goto 0 1"), Ok(Command::Goto(vec![0.0, 1.0], None)));
        assert_eq!(read("goto 0 1 2"), Ok(Command::Goto(vec![0.0, 1.0], Some(2.0))));
        assert_eq!((read("run"), read("arm")), (Ok(Command::Run), Ok(Command::Ask(Request::Arm))));
        assert_eq!((read("wait"), read("wait 2")), (Ok(Command::Wait(None)), Ok(Command::Wait(Some(2.0)))));
        let gain = Setting { index: 16, value: 120.5 };
        assert_eq!(read("set elbow position gain 120.5"), Ok(Command::Set(gain)));
        assert_eq!(read("payload 2 0 0 0.1"), Ok(Command::Payload(2.0, [0.0, 0.0, 0.1])));
        assert_eq!((read("record off"), read("")), (Ok(Command::Record(None)), Ok(Command::Nothing)));
    }

    #[test]
    fn every_line_of_the_help_is_a_command() {
        for (usage, _) in HELP {
            for word in usage.split(", ") {
                let line = word.replace("JOINT", "1").replace("DELTA", "1").replace("Q1 .. QN", "1 1");
                let line = line.replace("SECONDS", "1").replace("TICKS", "1").replace("NAME", "position gain");
                let line = line
                    .replace("VALUE", "1")
                    .replace("MASS", "1")
                    .replace("X Y Z", "0 0 1")
                    .replace("LAW", "pd")
                    .replace("FACTOR", "1")
                    .replace(['[', ']'], "");
                assert!(read(&line).is_ok(), "{line}: {:?}", read(&line));
            }
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_what_was_expected() {
        for (line, message) in [
            ("jog 3 1", "jog: JOINT is 3, expected a number from 1 to 2 or one of shoulder, elbow"),
            ("jog 1 x", "jog: DELTA is x, expected a number"),
            ("jog 1 nan", "jog: DELTA is nan, expected a number"),
            ("jog 1", "jog: 1 words, expected JOINT DELTA [SECONDS]"),
            ("goto 1", "goto: 1 numbers, expected 2 positions and at most one time"),
            ("follow 9", "follow: SECONDS is 9, expected 5 at most"),
            ("wait 0", "wait: SECONDS is 0, expected a time above zero, 1e5 at most"),
            ("wait 1 2", "wait: 2 words, expected wait or wait SECONDS"),
            ("set 1 position gain x", "set: VALUE is x, expected a number"),
            ("set 1 2", "set: 1 VALUE: expected JOINT NAME VALUE"),
            ("set", "set: 0 words, expected set JOINT NAME VALUE"),
            ("payload 1 2", "payload: 2 words, expected payload MASS [X Y Z]"),
            ("law fly", "law: fly: expected one of"),
            ("stiffness 5", "stiffness: FACTOR is 5, expected 0.25 to 4"),
            ("arm now", "arm: now: expected nothing behind it"),
            ("fly", "fly: no such command; `help` lists them"),
        ] {
            assert!(read(line).unwrap_err().starts_with(message), "{:?}", read(line));
        }
    }
}
