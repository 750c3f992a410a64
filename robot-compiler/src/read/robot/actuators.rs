//! The table of actuators, `robot-compiler/actuators.toml`, compiled into the program.

use crate::describe::diagnostics::{FileError, Source};
use crate::describe::drive::{Actuator, Protocol};
use crate::read::table::{Table, Value, parse};
use dynamics_core::drive::PositionMemory;
use std::sync::LazyLock;

static TABLE: LazyLock<Vec<Actuator>> = LazyLock::new(|| read(&source()).unwrap_or_default());

fn source() -> Source {
    let text = include_str!("../../../actuators.toml").to_owned();
    Source { file: "robot-compiler/actuators.toml".to_owned(), text }
}

/// Every actuator of the table.
#[must_use]
pub fn all() -> &'static [Actuator] {
    &TABLE
}

fn read(source: &Source) -> Result<Vec<Actuator>, FileError> {
    let document = parse(source)?;
    let root = Table::root(source, &document);
    root.only(&["actuator"])?;
    let all = root.require("actuator", "one table or more, [[actuator]]")?.array("tables")?;
    all.iter().map(|value| actuator(&value.table()?)).collect()
}

/// Names of what a position survives.
const MEMORY: [(&str, PositionMemory); 3] = [
    ("absolute", PositionMemory::Absolute),
    ("output-turn", PositionMemory::OutputTurn),
    ("motor-turn", PositionMemory::MotorTurn),
];

/// A speed and the voltage for which it is stated.
fn no_load(value: &Value<'_>) -> Result<(f64, f64), FileError> {
    const EXPECTED: &str = "[speed in rad/s, voltage in V], both above zero";
    match value.numbers(2, EXPECTED)?.as_slice() {
        [speed, voltage] if *speed > 0.0 && *voltage > 0.0 => Ok((*speed, *voltage)),
        found => Err(value.error(format!("found {found:?}"), EXPECTED)),
    }
}

fn actuator(table: &Table<'_>) -> Result<Actuator, FileError> {
    table.only(&[
        "name",
        "kind",
        "position",
        "velocity",
        "torque",
        "kp",
        "kd",
        "rated",
        "peak",
        "time_constant",
        "rotor",
        "gear",
        "torque_constant",
        "memory",
        "no_load",
        "source",
    ])?;
    const TEXT: &str = "a text";
    const END: &str = "the end of a range, above zero";
    let text = |key| table.require(key, TEXT)?.string(TEXT).map(str::to_owned);
    let end = |key| table.require(key, END)?.positive(END);
    let known = |key| table.get(key).map(|value: Value<'_>| value.positive("a number above zero")).transpose();
    let tabulated = Protocol::ALL.iter().filter(|protocol| !protocol.facts().ranges_vary);
    let kinds: Vec<_> = tabulated.map(|protocol| (protocol.facts().name, *protocol)).collect();
    Ok(Actuator {
        name: text("name")?,
        protocol: table.require("kind", "mit, damiao or robstride")?.choice(&kinds)?,
        position: end("position")?,
        velocity: end("velocity")?,
        torque: end("torque")?,
        kp: end("kp")?,
        kd: end("kd")?,
        rated: known("rated")?,
        peak: known("peak")?,
        time_constant: known("time_constant")?,
        rotor: known("rotor")?,
        gear: known("gear")?,
        torque_constant: known("torque_constant")?,
        memory: table.get("memory").map(|value| value.choice(&MEMORY)).transpose()?,
        no_load: table.get("no_load").map(|value| no_load(&value)).transpose()?,
        source: text("source")?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{PositionMemory, Source, all, read, source};

    #[test]
    fn the_table_can_be_read_and_no_name_is_in_it_twice() {
        let table = read(&source()).unwrap();
        assert!(table.len() >= 7 && table == all());
        for (i, actuator) in table.iter().enumerate() {
            assert!(table[..i].iter().all(|other| other.name != actuator.name), "{}", actuator.name);
            assert!(actuator.rated.is_none_or(|rated| rated < actuator.torque), "{}", actuator.name);
            let peak = actuator.peak.unwrap_or(actuator.torque);
            assert!(peak <= actuator.torque && actuator.rated.is_none_or(|rated| rated < peak), "{}", actuator.name);
            assert!(actuator.source.len() > 20, "{}: no source", actuator.name);
            assert!(!actuator.protocol.facts().ranges_vary, "{}", actuator.name);
            assert!(actuator.gear.is_none_or(|gear| gear >= 1.0), "{}", actuator.name);
            // A frame that cannot carry the speed without load would report a slower one. Several of these do at a higher voltage.
            let fits = |(speed, _): (f64, f64)| speed <= 1.01 * actuator.velocity;
            assert!(actuator.no_load.is_none_or(fits), "{}", actuator.name);
        }
    }

    #[test]
    fn a_value_that_the_table_cannot_have_is_rejected() {
        let row = "[[actuator]]\nname = \"X\"\nkind = \"mit\"\nposition = 12.5\nvelocity = 50.0\ntorque = 18.0\nkp = 500.0\nkd = 5.0\n\
                   source = \"a document that states it\"\n";
        let with = |line: &str| read(&Source { file: "x.toml".to_owned(), text: format!("{row}{line}\n") });
        let known = with("gear = 9.0\nmemory = \"motor-turn\"\nno_load = [40.8, 48.0]\ntorque_constant = 0.9").unwrap();
        assert_eq!((known[0].gear, known[0].no_load), (Some(9.0), Some((40.8, 48.0))));
        assert_eq!((known[0].memory, known[0].torque_constant), (Some(PositionMemory::MotorTurn), Some(0.9)));
        for line in ["gear = 0.0", "memory = \"nothing\"", "no_load = [40.8]", "no_load = [0.0, 48.0]", "inertia = 1.0"]
        {
            with(line).unwrap_err();
        }
        let other = Source { file: "x.toml".to_owned(), text: row.replace("\"mit\"", "\"myactuator\"") };
        assert!(read(&other).is_err(), "its ranges depend on the firmware");
    }
}
