//! The campaign with drives on a bus: no unsafe motion in some hundred runs, and every board that is broken on purpose is found.

use host_sim::study::campaign::drives::{Breakage, DrivesStage, run};
use host_sim::study::campaign::{
    Campaign, Case, Desk, FaultKind, Law, Number, Outcome, Report, Situation, Span, Target,
};
use indicatif::ProgressBar;
use link::Pacing;
use robot_compiler::SceneFile;
use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

const N: usize = 6;

const SCENES: [&str; 6] =
    ["mini_cheetah_brakes", "mini_cheetah", "damiao_brakes", "damiao", "robstride_brakes", "robstride"];

fn scene(name: &str) -> SceneFile {
    super::campaign::scene(&format!("{name}.toml"))
}

fn report(runs: impl IntoIterator<Item = u64>) -> Report {
    let scenes = SCENES.map(scene).to_vec();
    let campaign = Campaign { scenes, seed: 1, runs: runs.into_iter().collect(), target: Target::Drives };
    campaign.report(&AtomicBool::new(false), &ProgressBar::hidden()).unwrap()
}

#[test]
fn no_joint_moves_unsafely_whatever_happens_to_drives_and_buses() {
    // Prime to the number of cases and of scenes: from everywhere.
    let report = report((0..700).map(|k| 7 * k));
    assert!(report.counterexamples.is_empty(), "{}", report.table());
    assert_eq!(report.rows.len(), FaultKind::names(Target::Drives).count());
    // The machine is not overcautious: without a fault nothing happens but that an arm comes to be armed, or to be lowered.
    let nothing = report.rows.iter().find(|row| row.fault == FaultKind::Nothing).unwrap();
    for ((situation, _), cell) in Situation::names(Target::Drives).zip(&nothing.cells) {
        let goes_on = matches!(situation, Situation::Arming | Situation::Lowering);
        let expected = if goes_on { Outcome::Asked } else { Outcome::Unaffected };
        let well = |outcome: &Outcome| *outcome == Outcome::Unaffected || *outcome == expected;
        assert!(cell.outcomes.iter().all(|(outcome, _)| well(outcome)), "{situation:?} {cell:?}");
    }
    let page = report.page(&[]).html();
    assert!(page.contains("No motion was unsafe.") && page.contains("Exempt"), "{}", report.table());
}

/// A shipped scene of an arm with drives, as its person runs it, can be judged too.
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

/// Laws that a broken board breaks in a scene, in runs with these faults.
fn found(name: &str, breakage: Breakage, faults: &[FaultKind]) -> BTreeSet<Law> {
    let scene = scene(name);
    let stage = DrivesStage::<N>::new(&scene).unwrap();
    let mut desk = Desk::new(&scene, &scene.robot.model::<N>().unwrap(), Pacing::Live);
    let mut laws = BTreeSet::new();
    for (fault, number) in faults.iter().flat_map(|fault| (0..8).map(move |number| (*fault, number))) {
        for (situation, _) in Situation::names(Target::Drives).filter(|(it, _)| *it != Situation::Lowering) {
            let number = Number { seed: 1, run: number };
            let case = Case { fault, situation };
            // What is broken may keep the board from the state of the case.
            let Ok(done) = run(&stage, &mut desk, (case, number.run), number, Some(breakage)) else { continue };
            laws.extend(done.counterexample.and_then(|found| found.law));
        }
    }
    laws
}

#[test]
fn a_board_that_is_broken_on_purpose_is_found() {
    use FaultKind::{EnableIgnored, HostSilent, Nothing};
    let power = FaultKind::Power(Span::Long);
    let cases: [(&str, Breakage, &[FaultKind], Law); 17] = [
        ("mini_cheetah_brakes", Breakage::EnableCountsAsSent, &[EnableIgnored], Law::BrakesOpen),
        ("damiao_brakes", Breakage::EnableCountsAsSent, &[EnableIgnored], Law::BrakesOpen),
        ("robstride_brakes", Breakage::NoPreload, &[Nothing], Law::Carried),
        ("mini_cheetah_brakes", Breakage::NoPreload, &[Nothing], Law::Carried),
        ("mini_cheetah_brakes", Breakage::ZeroNeverLost, &[FaultKind::PowerOfAll(Span::Long)], Law::Carried),
        ("mini_cheetah", Breakage::ZeroNeverLost, &[FaultKind::PowerOfAll(Span::Long)], Law::ZeroMoved),
        ("damiao_brakes", Breakage::BrakesOpenEarly, &[Nothing], Law::BrakesOpen),
        ("robstride_brakes", Breakage::BrakesStayOpen, &[FaultKind::EmergencyStop], Law::BrakesOpen),
        ("damiao", Breakage::HoldLost, &[FaultKind::RequestPair, Nothing], Law::Strongest),
        ("robstride", Breakage::HostNeverMissed, &[HostSilent], Law::Silence),
        ("damiao_brakes", Breakage::OffUnnoticed, &[power], Law::OffUnnoticed),
        ("mini_cheetah_brakes", Breakage::OffUnnoticed, &[FaultKind::PowerOfAll(Span::Long)], Law::OffUnnoticed),
        ("robstride", Breakage::NoDamping, &[FaultKind::EmergencyStop], Law::Damped),
        ("mini_cheetah", Breakage::NoDamping, &[FaultKind::EmergencyStop], Law::Damped),
        ("damiao", Breakage::TorqueGoesOn, &[FaultKind::EmergencyStop], Law::Damped),
        ("damiao_brakes", Breakage::HalfTorque, &[Nothing], Law::Fell),
        ("robstride", Breakage::HalfTorque, &[Nothing], Law::Fell),
    ];
    let mut missed = Vec::new();
    for (name, breakage, faults, law) in cases {
        let laws = found(name, breakage, faults);
        println!("{name}, {breakage:?}: {laws:?}");
        if !laws.contains(&law) {
            missed.push((name, breakage, law, laws));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}
