//! The check that buses and adapters carry the scene's rate.

use crate::can::adapter_name::AdapterName;
use dynamics_core::drive::MitDrive;
use dynamics_core::drive::bus_time::{BusLoad, Identifier, LEAD_US, TURNAROUND_US};
use std::fmt;

/// Load of an adapter by the drives on its bus.
#[derive(Clone, Debug, PartialEq)]
pub struct AdapterLoad {
    name: AdapterName,
    load: BusLoad,
    rate_hz: f64,
}

impl AdapterLoad {
    /// Load of the adapter of bus `bus`, counted from 0.
    #[must_use]
    pub fn new(name: AdapterName, drives: &[MitDrive], bus: u8, identifier: Identifier, rate_hz: f64) -> Self {
        Self { name, load: BusLoad::of(drives, bus, identifier), rate_hz }
    }

    /// Number of drives.
    #[must_use]
    pub fn drives(&self) -> u32 {
        self.load.actuators
    }

    /// Longest time from the begin of a tick to its last reply, us.
    ///
    /// The adapter's line to the computer and the bus work at the same time. So the time is the longer one of two: all frames on the bus, with the first command and
    /// the last reply on the line; or all commands on the line, with the last command and its reply on the bus and the reply on the line.
    #[must_use]
    pub fn time_us(&self) -> u64 {
        let frames = u64::from(self.load.frames_ns());
        let fixed = u64::from(LEAD_US + TURNAROUND_US);
        let Some(line) = self.name.line(self.load.identifier) else { return fixed + frames.div_ceil(1000) };
        let count = self.load.actuators;
        let by_bus = line.commands_ns(1) + frames;
        let by_line = line.commands_ns(count) + frames.div_ceil(u64::from(count.max(1)));
        fixed + (by_bus.max(by_line) + line.reply_ns()).div_ceil(1000)
    }

    /// The highest rate at which every reply arrives before the next tick begins, whole Hz.
    #[must_use]
    pub fn rate_max_hz(&self) -> u32 {
        u32::try_from(1_000_000 / self.time_us().max(1)).unwrap_or(u32::MAX)
    }

    /// Checks that they carry the scene's rate.
    ///
    /// # Errors
    /// The arithmetic, and the rate that they carry.
    pub fn check(&self) -> Result<(), String> {
        if self.rate_hz <= f64::from(self.rate_max_hz()) {
            return Ok(());
        }
        let (bits, count, identifier) = (self.load.bits().nominal, self.load.actuators, self.load.identifier);
        let line = self.name.line(identifier);
        let unknown = line.map_or("", |line| line.unknown());
        let line = line.map_or(String::new(), |line| {
            format!(", {} us for the commands {}", line.commands_ns(count).div_ceil(1000), line.text())
        });
        Err(format!(
            "control.rate: found {} Hz, expected at most {}: {count} drives on {}, each with a command and a reply, are {bits} bits with stuffing: {:.0} us \
             at 1 Mbit/s{line}; with {LEAD_US} us for the controller and {TURNAROUND_US} us for the last reply, the last one arrives {} us after the begin \
             of a tick of {:.0} us{unknown}",
            self.rate_hz,
            self.rate_max_hz(),
            self.name,
            f64::from(self.load.frames_ns()) * 1e-3,
            self.time_us(),
            1e6 / self.rate_hz,
        ))
    }
}

impl fmt::Display for AdapterLoad {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The cast saturates.
        let slack = self.load.slack_percent(self.rate_hz.ceil() as u32);
        write!(
            f,
            "{}: {} drives, bus at least {slack} % free at {} Hz; up to {} Hz{}",
            self.name,
            self.load.actuators,
            self.rate_hz,
            self.rate_max_hz(),
            self.name.line(self.load.identifier).map_or("", |line| line.unknown())
        )
    }
}
