//! Bytes of a tick from `cargo xtask firmware cost`, compared with those that the linker keeps.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod task;

use chip_image::Program;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use task::{folder, told, xtask};

const SCENE: &str = "scenes/puma560_pick.toml";

/// Output of the task for the scene.
fn cost() -> Value {
    let list = folder("chip_bytes").join("one.scenes");
    std::fs::write(&list, format!("{SCENE}\n")).unwrap();
    let (code, printed, error) = told(xtask().args(["firmware", "cost", "--scenes"]).arg(list).output().unwrap());
    assert_eq!(code, 0, "{error}");
    serde_json::from_str(&printed).unwrap()
}

#[test]
fn the_bytes_of_a_tick_are_those_that_the_linker_keeps_of_it() {
    let cost = cost();
    let (code, _, error) = told(xtask().args(["gate", "--scene", SCENE]).output().unwrap());
    assert_eq!(code, 0, "{error}");
    // A folder next to the measuring program contains the tick alone, without the sections that the linker removed.
    let measured = Path::new(cost["tick"]["program"].as_str().unwrap());
    let linked = measured.with_file_name("thumbv7em-none-eabihf/firmware/tick-gate-tick.elf");
    let program = Program::parse(&std::fs::read(linked).unwrap()).unwrap();
    let kept: u64 = [".text", ".rodata"].into_iter().filter_map(|name| program.section_bytes(name)).sum();
    // The gate links the tick twice: alone, and inside the safety state machine.
    let [tick, safe] = ["newtau_gate_tick", "newtau_gate_safety"]
        .map(|entry| program.reached_from(program.address_of(|name| name == entry).unwrap()).unwrap());
    assert_eq!((tick.indirect, safe.indirect), (0, 0));
    let parts = [&tick, &safe].into_iter().flat_map(|reached| reached.functions.iter().chain(&reached.tables));
    let all: BTreeMap<u32, u64> = parts.map(|part| (part.address & !1, u64::from(part.bytes))).collect();
    let (both, bare) = (all.values().sum::<u64>(), tick.flash_bytes());
    let measured = cost["flash_bytes"].as_u64().unwrap();
    println!("{both} reached of {kept} kept; {bare} by the bare tick, {measured} in the program that measures it");
    let share = |part: u64, whole: u64| part as f64 / whole as f64;
    assert!((0.97..=1.0).contains(&share(both, kept)), "{all:#?}");
    assert!((0.95..1.05).contains(&share(measured, bare)));
}
