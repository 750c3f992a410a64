//! The table of actuators, `robot-compiler/actuators.toml`, compiled into the program.

use crate::describe::diagnostics::{FileError, Source};
use crate::describe::drive::{Actuator, Protocol};
use crate::read::table::{Table, Value, parse};
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
        "source",
    ])?;
    const TEXT: &str = "a text";
    const END: &str = "the end of a range, above zero";
    let text = |key| table.require(key, TEXT)?.string(TEXT).map(str::to_owned);
    let end = |key| table.require(key, END)?.positive(END);
    let known = |key| table.get(key).map(|value: Value<'_>| value.positive("a number above zero")).transpose();
    let tabulated = Protocol::ALL.iter().filter(|protocol| !protocol.facts().reply_varies);
    let kinds: Vec<_> = tabulated.map(|protocol| (protocol.facts().name, *protocol)).collect();
    Ok(Actuator {
        name: text("name")?,
        protocol: table.require("kind", "damiao or robstride")?.choice(&kinds)?,
        position: end("position")?,
        velocity: end("velocity")?,
        torque: end("torque")?,
        kp: end("kp")?,
        kd: end("kd")?,
        rated: known("rated")?,
        peak: known("peak")?,
        time_constant: known("time_constant")?,
        rotor: known("rotor")?,
        source: text("source")?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{all, read, source};

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
        }
    }
}
