use super::*;
use std::path::Path;

/// A scene: its first tick gave this command, its run-up took 9 instructions a tick, and its counted ticks took 10,
/// 13 ..
fn measured(first: &str, count: usize) -> Measured {
    let instructions = |at: usize| if at < RUN_UP { 9 } else { 10 + 3 * (at - RUN_UP) };
    let command = |at: usize| if at == 0 { first } else { "drive,1,0" };
    let tick = |at| serde_json::json!({ "instructions": instructions(at), "cycles": at, "command": command(at) });
    let ticks: Vec<_> = (0..count).map(tick).collect();
    let tick = serde_json::json!({ "symbol": "tick_0", "address": 0x0800_0000, "bytes": 8, "program": "cost.elf" });
    serde_json::from_value(serde_json::json!({
        "tick": tick, "controller_bytes": 200, "flash_bytes": 300, "ticks": ticks
    }))
    .unwrap()
}

fn desk() -> Vec<String> {
    vec!["drive,1,0".to_owned(); RUN_UP + 2]
}

#[test]
fn ticks_after_the_run_up_are_counted_and_compared() {
    let MeasuredCost { cost, instructions_min, fault } = cost(measured("drive,1,0", RUN_UP + 2), &desk()).unwrap();
    assert_eq!((instructions_min, cost.instructions_max, cost.instructions), (10, 13, 11.5));
    assert_eq!((cost.cycles_max, cost.cycles), (RUN_UP as f64 + 1.0, RUN_UP as f64 + 0.5));
    assert_eq!((cost.flash, cost.ram), (300, 200));
    assert!(cost.matches_desk && fault.is_none());
}

#[test]
fn a_tick_that_differs_or_brakes_is_reported() {
    let first = |command: &str| cost(measured(command, RUN_UP + 2), &desk()).unwrap();
    assert!(!first("drive,2,0").cost.matches_desk);
    let braked = first("brake,5,2");
    assert_eq!(braked.fault, Some(Braked { tick: 0, code: 5, joint: Some(2) }));
    assert_eq!(braked.fault.unwrap().fault(), Some(Fault::VelocityOutOfBounds { joint: 2 }));
    assert!(!braked.cost.matches_desk);
    assert_eq!(first("brake,3,").fault.unwrap().joint, None);
}

#[test]
fn a_program_that_stops_early_or_says_nonsense_is_an_error() {
    assert!(cost(measured("drive,1,0", RUN_UP), &desk()).is_err());
    assert!(cost(measured("brake,x,", RUN_UP + 2), &desk()).is_err());
}

#[test]
fn scenes_whose_ticks_are_not_the_same_are_refused_by_name() {
    let load = |name: &str| {
        SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"))).unwrap()
    };
    let (puma, planar) = (load("puma560_pick"), load("planar2r_swing"));
    let mut lesser = puma.clone();
    lesser.model.friction = false;
    assert!(comparable(&[puma.clone(), lesser]).is_ok());
    let said = comparable(&[puma, planar]).unwrap_err().report().to_string();
    assert!(said.contains("planar2r_swing.toml: robot: not that of "), "{said}");
}
