//! Springs in the drives' own loops, compared with the same springs over the bus: the YAM with simulated drives.

use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use sim::run::closed_loop::End;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn scene(text: impl FnOnce(String) -> String) -> SceneFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/yam_split.toml");
    let changed = text(std::fs::read_to_string(&path).unwrap());
    SceneFile::from_toml_str(&changed, &path).unwrap()
}

fn simulated(scene: &SceneFile) -> Run {
    simulation::run(scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap()
}

fn run(scene: &SceneFile) -> Run {
    let run = simulated(scene);
    assert_eq!((run.end, run.summary.faults.as_slice()), (End::Complete, [].as_slice()));
    run
}

fn worst(of: &[f64]) -> f64 {
    of.iter().fold(0.0, |worst, x| worst.max(x.abs()))
}

/// Resolution of a position in a reply, rad.
const STEP: f64 = 25.0 / 65_535.0;

#[test]
fn it_tracks_closer_than_the_same_spring_over_the_bus_and_parks_within_one_and_a_half_steps_of_the_drives() {
    let [split, bus] =
        ["split", "impedance"].map(|law| run(&scene(|text| text.replace("\"split\"", &format!("\"{law}\"")))));
    let (near, far) = (worst(&split.summary.tracking_rms), worst(&bus.summary.tracking_rms));
    assert!(near < 0.6 * far && near > 0.1 * far, "{near} rad and {far} rad");
    // A reply rounds down to a multiple of its step, so the integral term ends half a step away. The roll joint needs 9 s to reach breakaway torque.
    let split = run(&scene(|text| text.replace("duration = 4.0", "duration = 12.0")));
    let parked: Vec<f64> = split.summary.rest_error.iter().map(|error| error.unwrap()).collect();
    assert!(worst(&parked) < 1.5 * STEP + 2e-5 && worst(&parked) > 0.5 * STEP, "{parked:?} rad");
    // There is no limit cycle: over the last half second, nothing moves by a step.
    for joint in 0..6 {
        let last = split.record.joint(joint).skip(11_500).map(|sample| sample.q);
        let (low, high) = last.fold((f64::MAX, f64::MIN), |(low, high), q| (low.min(q), high.max(q)));
        assert!(high - low < STEP, "joint {joint} moves by {} rad", high - low);
    }
}

#[test]
fn a_spring_that_swings_over_a_slow_bus_stands_in_the_drives() {
    let stiff = |law: &str| {
        simulated(&scene(|text| {
            let text = text.replace("\"split\"", &format!("\"{law}\"")).replace("rate = 1000", "rate = 250");
            let text = text.lines().filter(|line| !line.starts_with("integral")).collect::<Vec<_>>().join("\n");
            text.replace("natural_frequency = 40.0", "stiffness = [240.0, 240.0, 240.0, 30.0, 30.0, 30.0]")
        }))
    };
    let (bus, drives) = (stiff("impedance").summary, stiff("split").summary);
    assert!(bus.faults.iter().any(|fault| fault.code == 5), "it swings until a joint is too fast: {:?}", bus.faults);
    let chatter = worst(&drives.torque_chatter);
    assert!(drives.faults.is_empty() && chatter < 0.1, "{:?}, {chatter} N m", drives.faults);
}
