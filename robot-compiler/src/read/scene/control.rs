//! The table `[control]`.

use super::values::per_joint;
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{ControlSpec, KernelChoice, KernelMemory};
use crate::read::table::{Table, Value};

pub(super) fn read(table: &Table<'_>, robot: &Robot) -> Result<ControlSpec, FileError> {
    table.only(&[
        "rate",
        "law",
        "model_every",
        "model_between",
        "natural_frequency",
        "damping",
        "trig",
        "scalar",
        "kernel",
        "kernel_memory",
        "observer_bandwidth",
        "age_max",
        "guard",
        "tunable",
    ])?;
    let mut control = ControlSpec::default_for(robot);
    let number = |key, max, expected, default| table.get(key).map_or(Ok(default), |v| v.positive_up_to(max, expected));
    control.rate = number("rate", 1e5, "a rate in Hz, above zero and at most 1e5", control.rate)?;
    let bandwidth = "a bandwidth in rad/s, above zero and at most 1e6";
    control.observer_bandwidth = number("observer_bandwidth", 1e6, bandwidth, control.observer_bandwidth)?;
    if let Some(value) = table.get("tunable") {
        control.tunable = value.boolean()?;
    }
    if let Some(value) = table.get("law") {
        control.law = value.named()?;
    }
    if let Some(value) = table.get("model_every") {
        control.model_every = value.count(1000, "a whole number of ticks, 1 to 1,000")?;
    }
    if let Some(value) = table.get("model_between") {
        control.model_between = value.named()?;
        if table.get("model_every").is_none() {
            let problem = "the model is evaluated in every tick, and nothing is between";
            return Err(value.error(problem, "`model_every` beside it, the ticks from one evaluation to the next"));
        }
    }
    if let Some(value) = table.get("trig") {
        control.trig = value.named()?;
    }
    if let Some(value) = table.get("scalar") {
        control.scalar = value.named()?;
    }
    if let Some(value) = table.get("kernel") {
        control.kernel = value.named()?;
    }
    if let Some(value) = table.get("kernel_memory") {
        control.kernel_memory = value.named()?;
        if control.kernel_memory == KernelMemory::Sram && control.kernel == KernelChoice::Generic {
            return Err(value.error("the recursion is not placed in SRAM", "`kernel` exact or regrouped, or \"flash\""));
        }
    }
    if let Some(value) = table.get("natural_frequency") {
        let one = |value: &Value<'_>| value.positive_up_to(1e4, "a frequency in rad/s, above zero and at most 1e4");
        control.natural_frequency = per_joint(&value, robot, "a frequency in rad/s", one)?;
    }
    if let Some(value) = table.get("damping") {
        let one = |value: &Value<'_>| value.positive_up_to(1e3, "a damping ratio, above zero and at most 1e3");
        control.damping = per_joint(&value, robot, "a damping ratio", one)?;
    }
    if let Some(value) = table.get("age_max") {
        control.age_max = value.whole(1_000_000, "a whole number of ticks, at most 1,000,000")? as u32;
    }
    if let Some(guard) = table.table("guard")? {
        guard.only(&["position_margin", "velocity_factor"])?;
        if let Some(value) = guard.get("position_margin") {
            control.position_margin = value.not_negative("a margin in rad or m, zero or more")?;
        }
        if let Some(value) = guard.get("velocity_factor") {
            control.velocity_factor = value.at_least(1.0, "a factor of at least 1 on the velocity limit")?;
        }
    }
    Ok(control)
}
