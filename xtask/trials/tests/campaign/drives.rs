//! The campaign with drives on a bus: no unsafe motion in hundreds of runs, and every deliberate fault of a board is found.

use indicatif::ProgressBar;
use link::Pacing;
use robot_compiler::SceneFile;
use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;
use trials::campaign::drives::{Breakage, DrivesStage, run};
use trials::campaign::{
    Campaign, Case, Desk, FaultKind, Number, Outcome, Report, SafetyProperty, Situation, Span, Target,
};

const N: usize = 6;

const SCENES: [&str; 6] =
    ["mini_cheetah_brakes", "mini_cheetah", "damiao_brakes", "damiao", "robstride_brakes", "robstride"];

fn scene(name: &str) -> SceneFile {
    super::desk::scene(&format!("{name}.toml"))
}

fn report(runs: impl IntoIterator<Item = u64>) -> Report {
    let scenes = SCENES.map(scene).to_vec();
    let campaign = Campaign { scenes, seed: 1, runs: runs.into_iter().collect(), target: Target::Drives };
    campaign.report(&AtomicBool::new(false), &ProgressBar::hidden()).unwrap()
}

#[test]
fn no_joint_moves_unsafely_whatever_happens_to_drives_and_buses() {
    // A step that is coprime to the number of cases and of scenes, so that the runs are spread over all of them.
    let report = report((0..700).map(|k| 7 * k));
    assert!(report.counterexamples.is_empty(), "{}", report.table());
    assert_eq!(report.rows.len(), FaultKind::names(Target::Drives).count());
    // The machine is not overcautious: without a fault, the only change is that arming, lowering or disarming completes.
    let nothing = report.rows.iter().find(|row| row.fault == FaultKind::Nothing).unwrap();
    for ((situation, _), cell) in Situation::names(Target::Drives).zip(&nothing.cells) {
        let goes_on = matches!(situation, Situation::Arming | Situation::Lowering | Situation::Disarming);
        let expected = if goes_on { Outcome::Asked } else { Outcome::Unaffected };
        let well = |outcome: &Outcome| *outcome == Outcome::Unaffected || *outcome == expected;
        assert!(cell.outcomes.iter().all(|(outcome, _)| well(outcome)), "{situation:?} {cell:?}");
    }
    assert!(report.table().contains("0 unsafe motions") && report.table().contains("Exempt"), "{}", report.table());
}

/// A shipped scene of an arm with drives can be judged with the settings with which its user runs it.
#[test]
fn the_limits_of_a_first_motion_are_lifted_before_faults_are_judged() {
    let mut limited = scene("damiao");
    assert_eq!(limited.safety.first_motion, None);
    limited.safety.first_motion = Some(0.2);
    let campaign =
        Campaign { scenes: vec![limited], seed: 1, runs: (0..70).map(|k| 7 * k).collect(), target: Target::Drives };
    let report = campaign.report(&AtomicBool::new(false), &ProgressBar::hidden()).unwrap();
    assert!(report.counterexamples.is_empty(), "{}", report.table());
}

/// Deliberate fault: in the board's joints, or in the board as a whole, which was built from another scene than the judge's.
#[derive(Clone, Copy, Debug)]
enum Broken {
    Joints(Breakage),
    /// The board lowers the arm this many times as fast.
    LoweredFast(f64),
    /// The board releases the arm this far above its rest pose, rad.
    LetGoAbove(f64),
}

impl Broken {
    /// The scene that the board was built from.
    fn board(self, mut scene: SceneFile) -> SceneFile {
        match self {
            Self::Joints(_) => {}
            Self::LoweredFast(factor) => scene.safety.lowering_tip_speed *= factor,
            Self::LetGoAbove(more) => scene.safety.rest.as_mut().unwrap()[1] += more,
        }
        scene
    }

    const fn breakage(self) -> Option<Breakage> {
        if let Self::Joints(breakage) = self { Some(breakage) } else { None }
    }
}

/// Properties that a faulty board violates in a scene, in runs with these faults, up to the run in which it violates `law`.
fn found(name: &str, broken: Broken, faults: &[FaultKind], law: SafetyProperty) -> BTreeSet<SafetyProperty> {
    let scene = scene(name);
    let board = broken.board(scene.clone());
    let stage = DrivesStage::<N>::new(&scene).unwrap().with_board_of(&board).unwrap();
    let mut desk = Desk::new(&board, &board.robot.model::<N>().unwrap(), Pacing::Live);
    let mut laws = BTreeSet::new();
    for (fault, number) in faults.iter().flat_map(|fault| (0..8).map(move |number| (*fault, number))) {
        for (situation, _) in Situation::names(Target::Drives).filter(|(it, _)| *it != Situation::Lowering) {
            let number = Number { seed: 1, run: number };
            let case = Case { fault, situation };
            // The deliberate fault may prevent the board from reaching the state of the case.
            let Ok(done) = run(&stage, &mut desk, (case, number.run), number, broken.breakage()) else { continue };
            laws.extend(done.counterexample.and_then(|found| found.law));
            if laws.contains(&law) {
                return laws;
            }
        }
    }
    laws
}

/// Checks that the judge finds each of these, by the stated property.
fn all_found(cases: &[(&str, Broken, &[FaultKind], SafetyProperty)]) {
    let mut missed = Vec::new();
    for (name, broken, faults, law) in cases {
        let laws = found(name, *broken, faults, *law);
        println!("{name}, {broken:?}: {laws:?}");
        if !laws.contains(law) {
            missed.push((name, broken, law, laws));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn a_board_that_is_broken_on_purpose_is_found() {
    use FaultKind::{EnableIgnored, HostSilent, Nothing};
    let power = FaultKind::Power(Span::Long);
    let cases: [(&str, Breakage, &[FaultKind], SafetyProperty); 19] = [
        ("mini_cheetah_brakes", Breakage::EnableCountsAsSent, &[EnableIgnored], SafetyProperty::BrakesOpen),
        ("damiao_brakes", Breakage::EnableCountsAsSent, &[EnableIgnored], SafetyProperty::BrakesOpen),
        ("robstride_brakes", Breakage::NoPreload, &[Nothing], SafetyProperty::Carried),
        ("mini_cheetah_brakes", Breakage::NoPreload, &[Nothing], SafetyProperty::Carried),
        ("mini_cheetah_brakes", Breakage::ZeroNeverLost, &[FaultKind::PowerOfAll(Span::Long)], SafetyProperty::Carried),
        ("mini_cheetah", Breakage::ZeroNeverLost, &[FaultKind::PowerOfAll(Span::Long)], SafetyProperty::ZeroMoved),
        ("damiao_brakes", Breakage::BrakesOpenEarly, &[Nothing], SafetyProperty::BrakesOpen),
        ("robstride_brakes", Breakage::BrakesStayOpen, &[FaultKind::EmergencyStop], SafetyProperty::BrakesOpen),
        ("damiao", Breakage::HoldLost, &[FaultKind::RequestPair, Nothing], SafetyProperty::Strongest),
        ("robstride", Breakage::HostNeverMissed, &[HostSilent], SafetyProperty::Silence),
        ("damiao_brakes", Breakage::OffUnnoticed, &[power], SafetyProperty::OffUnnoticed),
        (
            "mini_cheetah_brakes",
            Breakage::OffUnnoticed,
            &[FaultKind::PowerOfAll(Span::Long)],
            SafetyProperty::OffUnnoticed,
        ),
        ("robstride", Breakage::NoDamping, &[FaultKind::EmergencyStop], SafetyProperty::Damped),
        ("mini_cheetah", Breakage::NoDamping, &[FaultKind::EmergencyStop], SafetyProperty::Damped),
        ("damiao", Breakage::TorqueGoesOn, &[FaultKind::EmergencyStop], SafetyProperty::Damped),
        ("damiao_brakes", Breakage::HalfTorque, &[Nothing], SafetyProperty::Fell),
        ("robstride", Breakage::HalfTorque, &[Nothing], SafetyProperty::Fell),
        ("damiao_brakes", Breakage::NoBrakeDelay, &[Nothing], SafetyProperty::Fell),
        ("robstride_brakes", Breakage::NoBrakeDelay, &[Nothing], SafetyProperty::Fell),
    ];
    all_found(&cases.map(|(name, breakage, faults, law)| (name, Broken::Joints(breakage), faults, law)));
}

#[test]
fn brakes_timeouts_holds_and_lowering_that_are_broken_on_purpose_are_found() {
    use FaultKind::{Burst, EmergencyStop, HostGone, Nothing};
    let joints = Broken::Joints;
    all_found(&[
        ("damiao_brakes", joints(Breakage::BrakesSlip), &[Nothing], SafetyProperty::Stopped),
        ("mini_cheetah_brakes", joints(Breakage::BrakesLate), &[EmergencyStop], SafetyProperty::Stopped),
        ("damiao", joints(Breakage::TimeoutNeverActs), &[Burst], SafetyProperty::OldTorque),
        ("robstride", joints(Breakage::TimeoutNeverActs), &[Burst], SafetyProperty::OldTorque),
        ("mini_cheetah", joints(Breakage::TimeoutNeverActs), &[Burst], SafetyProperty::OldTorque),
        ("robstride", joints(Breakage::HoldCreeps), &[Nothing], SafetyProperty::Rest),
        ("damiao_brakes", joints(Breakage::HoldCreeps), &[Nothing], SafetyProperty::Rest),
        ("damiao", Broken::LoweredFast(3.0), &[HostGone], SafetyProperty::Lowered),
        ("mini_cheetah", Broken::LoweredFast(3.0), &[HostGone], SafetyProperty::Lowered),
        ("damiao", Broken::LetGoAbove(0.1), &[HostGone], SafetyProperty::Lowered),
    ]);
}

/// The simulated brakes need 80 ms. With a shorter `brake_delay` the arm sags when it is disarmed.
#[test]
fn a_scene_that_gives_its_brakes_too_little_time_is_found() {
    for (delay, sags) in [(0.0, true), (0.06, true), (0.08, false)] {
        let mut scene = scene("damiao_brakes");
        scene.safety.brake_delay = delay;
        let stage = DrivesStage::<N>::new(&scene).unwrap();
        let mut desk = Desk::new(&scene, &scene.robot.model::<N>().unwrap(), Pacing::Live);
        let case = Case { fault: FaultKind::RequestPair, situation: Situation::Armed };
        let mut laws = BTreeSet::new();
        for pair in 0..81 {
            let number = Number { seed: 1, run: pair };
            let done = run(&stage, &mut desk, (case, pair), number, None).unwrap();
            laws.extend(done.counterexample.and_then(|found| found.law));
        }
        let expected = if sags { BTreeSet::from([SafetyProperty::Stopped]) } else { BTreeSet::new() };
        assert_eq!(laws, expected, "{delay}");
    }
}
