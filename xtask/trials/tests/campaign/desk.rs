//! The fault-injection campaign on the desk: no unsafe command in hundreds of runs. The judge finds every deliberate fault of the machine, by the
//! property that it violates.

use dynamics_core::Sensed;
use dynamics_core::safety::SafeAction;
use indicatif::ProgressBar;
use link::seal::SealKey;
use link::{Actuation, Encoder, Frame, Pacing, StateCode};
use robot_compiler::SceneFile;
use session::Drives;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use trials::campaign::{
    Campaign, Case, Desk, FaultKind, Machine, MachineError, Number, Outcome, Report, SafetyProperty, Situation, Stage,
    Target, TickInputs, TickOutput, run,
};

pub(super) const N: usize = 6;

pub(super) fn scene(name: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/campaign").join(name)).unwrap()
}

/// A machine with falsified inputs or outputs.
struct Broken<F> {
    desk: Desk<N>,
    breaks: F,
    said: Option<TickOutput<N>>,
}

/// Falsification of the machine's inputs, or of its outputs. The latter also receives the outputs of the previous tick.
pub(super) enum Moment<'a> {
    Inputs(&'a mut TickInputs<N>, &'a mut Vec<u8>),
    Output(&'a mut TickOutput<N>, Option<&'a TickOutput<N>>),
}

impl<F: FnMut(Moment<'_>)> Machine<N> for Broken<F> {
    fn pacing(&self) -> Pacing {
        Pacing::Live
    }

    fn begin(&mut self) -> Result<Option<SealKey>, MachineError> {
        self.desk.begin()
    }

    fn tick(&mut self, bytes: &[u8], told: &TickInputs<N>) -> Result<TickOutput<N>, MachineError> {
        let (mut bytes, mut hears) = (bytes.to_vec(), told.clone());
        (self.breaks)(Moment::Inputs(&mut hears, &mut bytes));
        let mut said = self.desk.tick(&bytes, &hears)?;
        (self.breaks)(Moment::Output(&mut said, self.said.as_ref()));
        self.said = Some(said.clone());
        Ok(said)
    }
}

/// The property that the judge finds violated in some of these runs of a faulty machine; panics if it finds none.
pub(super) fn found(
    scene_name: &str,
    fault: FaultKind,
    situation: Situation,
    breaks: impl FnMut(Moment<'_>),
) -> SafetyProperty {
    let scene = scene(scene_name);
    let stage = Stage::<N>::new(&scene).unwrap();
    let model = scene.robot.model::<N>().unwrap();
    let desk = Desk::new(&scene, &model, Pacing::Live);
    let mut broken = Broken { desk, breaks, said: None };
    for number in 0..20 {
        broken.said = None;
        let number = Number { seed: 5, run: number };
        let finished = run(&stage, &mut broken, Case { fault, situation }, number).unwrap();
        if let Some(found) = finished.counterexample {
            return found.law.unwrap();
        }
    }
    panic!("{fault:?} in {situation:?} was not found in 20 runs");
}

/// Applies this torque, and reports it.
fn drive(said: &mut TickOutput<N>, torque: [f32; N]) {
    said.drives = Drives::Drive(torque);
    said.status.actuation =
        Some(link::Actuation::Drive { torque: link::convert::joints(&torque), limits: link::convert::joints(&[0; N]) });
}

/// Applies the brake, and reports it.
pub(super) fn brake(said: &mut TickOutput<N>) {
    said.drives = Drives::Safe(SafeAction::Brake);
    said.status.actuation = Some(Actuation::Brake);
}

fn acting(said: Option<&TickOutput<N>>) -> Option<[f32; N]> {
    match said?.drives {
        Drives::Drive(torque) => Some(torque),
        Drives::Safe(_) | Drives::Enable(_) | Drives::Preload(_) => None,
    }
}

#[test]
fn a_torque_that_acts_a_tick_too_long_is_found() {
    let law = found("states.toml", FaultKind::EmergencyStop, Situation::Running, |moment| {
        if let Moment::Output(said, before) = moment
            && said.status.state == StateCode::Fault
            && let Some(torque) = acting(before)
        {
            drive(said, torque);
        }
    });
    assert_eq!(law, SafetyProperty::SafeAction);
}

#[test]
fn a_torque_above_its_limit_at_a_rate_too_high_or_no_number_is_found() {
    let cases = [
        ("encoders.toml", 1e4, SafetyProperty::Limit),
        ("states.toml", 5.0, SafetyProperty::Rate),
        ("states.toml", f32::NAN, SafetyProperty::Finite),
    ];
    for (name, more, law) in cases {
        let mut ticks = 0;
        let by = found(name, FaultKind::Nothing, Situation::Running, |moment| {
            if let Moment::Output(said, ..) = moment
                && let Drives::Drive(mut torque) = said.drives
            {
                ticks += 1;
                torque[2] += if ticks == 50 { more } else { 0.0 };
                drive(said, torque);
            }
        });
        assert_eq!(by, law);
    }
}

#[test]
fn a_torque_in_a_state_that_has_none_is_found() {
    for (situation, torque) in [(Situation::Idle, 0.0), (Situation::Homing, 1e-3), (Situation::Fault, 1.0)] {
        let law = found("states.toml", FaultKind::Nothing, situation, |moment| {
            if let Moment::Output(said, ..) = moment
                && said.status.state == situation.state()
            {
                drive(said, [torque; N]);
            }
        });
        assert_eq!(law, SafetyProperty::SafeAction, "{situation:?}");
    }
}

#[test]
fn a_fault_that_does_not_stay_or_changes_its_number_is_found() {
    let mut fault = 0;
    let law = found("states.toml", FaultKind::Nothing, Situation::Fault, |moment| {
        if let Moment::Output(said, ..) = moment
            && said.status.state == StateCode::Fault
        {
            fault += 1;
            if fault > 3 {
                (said.status.state, said.status.cause) = (StateCode::Idle, 0);
            }
        }
    });
    assert_eq!(law, SafetyProperty::Latched);
    let mut fault = 0;
    let law = found("states.toml", FaultKind::Nothing, Situation::Fault, |moment| {
        if let Moment::Output(said, ..) = moment
            && said.status.state == StateCode::Fault
        {
            fault += 1;
            said.status.cause += u8::from(fault > 3);
        }
    });
    assert_eq!(law, SafetyProperty::Latched);
}

/// Hides a part of the machine's inputs.
fn hide(fault: FaultKind, scene: &str, mut from: impl FnMut(&mut TickInputs<N>)) -> SafetyProperty {
    found(scene, fault, Situation::Running, |moment| {
        if let Moment::Inputs(told, _) = moment {
            from(told);
        }
    })
}

#[test]
fn a_machine_that_does_not_look_at_one_of_its_inputs_is_found() {
    type Hidden = (FaultKind, fn(&mut TickInputs<N>));
    let all: [Hidden; 5] = [
        (FaultKind::EmergencyStop, |told| told.emergency_stop = false),
        (FaultKind::Overrun, |told| told.overrun = false),
        (FaultKind::Drive, |told| told.drive_fault = [false; N]),
        (FaultKind::Supply, |told| told.supply = None),
        (FaultKind::Temperature, |told| told.temperature = None),
    ];
    for (fault, hides) in all {
        assert_eq!(hide(fault, "states.toml", hides), SafetyProperty::Fault, "{fault:?}");
        assert_eq!(hide(fault, "encoders.toml", hides), SafetyProperty::Fault, "{fault:?}");
    }
    // A reading older than its stated age has moved too far for that age; this also cancels the homing.
    let law = hide(FaultKind::Stale, "states.toml", |told| told.age_ticks = [0; N]);
    assert!(matches!(law, SafetyProperty::Fault | SafetyProperty::Homed), "{law:?}");
}

#[test]
fn a_machine_that_does_not_look_at_a_wild_reading_is_found() {
    for (fault, name) in [
        (FaultKind::Position, "states.toml"),
        (FaultKind::Velocity, "states.toml"),
        (FaultKind::Jump, "states.toml"),
        (FaultKind::Jump, "encoders.toml"),
    ] {
        let mut last = None;
        let law = hide(fault, name, |told| {
            let last = last.insert(match (last, told.sensed) {
                (Some(last), sensed) if told.tick > 1 => smoothed(last, sensed),
                (_, sensed) => sensed,
            });
            told.sensed = *last;
        });
        // A jump also cancels the homing.
        assert!(matches!(law, SafetyProperty::Fault | SafetyProperty::Homed), "{fault:?}, {name}: {law:?}");
    }
}

/// A reading in which every implausible number is replaced by the previous one.
fn smoothed(last: Sensed<f32, N>, sensed: Sensed<f32, N>) -> Sensed<f32, N> {
    match (last, sensed) {
        (Sensed::State { q: before, .. }, Sensed::State { q, qd }) => {
            let near = |i: usize| (q[i] - before[i]).abs() < 0.05;
            let calm = |i: usize| if qd[i].abs() < 20.0 { qd[i] } else { 0.0 };
            let q = core::array::from_fn(|i| if near(i) { q[i] } else { before[i] });
            Sensed::State { q, qd: core::array::from_fn(calm) }
        }
        (Sensed::Counts(before), Sensed::Counts(counts)) => {
            let near = |i: usize| counts[i].abs_diff(before[i]) < 200;
            Sensed::Counts(core::array::from_fn(|i| if near(i) { counts[i] } else { before[i] }))
        }
        (_, sensed) => sensed,
    }
}

/// A declared payload that the arm does not carry drives the arm away, while the machine believes that it is at rest.
#[test]
fn an_armed_arm_that_leaves_its_place_is_found() {
    let (mut stood, mut state) = (None, StateCode::Idle);
    let law = found("states.toml", FaultKind::Model, Situation::Armed, |moment| match moment {
        Moment::Inputs(told, _) => {
            stood = if state == StateCode::Armed { stood } else { None };
            told.sensed = *stood.get_or_insert(told.sensed);
        }
        Moment::Output(said, _) => state = said.status.state,
    });
    assert!(matches!(law, SafetyProperty::Standing | SafetyProperty::Fault), "{law:?}");
}

#[test]
fn a_host_that_is_never_missed_is_found() {
    for situation in [Situation::Armed, Situation::Running, Situation::Holding] {
        let (mut encoder, mut quiet) = (Encoder::new(), 0);
        let law = found("states.toml", FaultKind::HostSilent, situation, |moment| {
            if let Moment::Inputs(_, bytes) = moment {
                quiet = if bytes.is_empty() { quiet + 1 } else { 0 };
                // The simulated host is never silent for this long.
                if quiet > 25 {
                    bytes.extend(encoder.encode(&Frame::Alive).unwrap());
                }
            }
        });
        assert_eq!(law, SafetyProperty::Silence, "{situation:?}");
    }
}

#[test]
fn an_arm_that_holds_and_creeps_is_found() {
    // The machine reads a wrong position, and drives away from it at 0.1 rad/s, twice the speed that counts as rest.
    let mut held = 0_u16;
    let law = found("states.toml", FaultKind::HostSilent, Situation::Holding, |moment| match moment {
        Moment::Inputs(told, _) => {
            if let Sensed::State { q, qd } = &mut told.sensed
                && held > 0
            {
                q[0] -= 1e-4 * f32::from(held);
                qd[0] -= 0.1;
            }
        }
        Moment::Output(said, ..) => held = if said.status.state == StateCode::Holding { held + 1 } else { 0 },
    });
    assert_eq!(law, SafetyProperty::Rest);
}

/// After loss of the host: the torque of disarming ends before the brakes have engaged, is left out, or continues.
#[test]
fn torque_that_ends_before_the_brakes_have_engaged_or_goes_on_after_is_found() {
    let fault = |said: &mut TickOutput<N>| {
        brake(said);
        (said.status.state, said.status.cause) = (StateCode::Fault, 10);
    };
    for ticks in [0, 1, 50] {
        let mut disarms = 0;
        let law = found("states.toml", FaultKind::HostSilent, Situation::Holding, |moment| {
            if let Moment::Output(said, before) = moment {
                disarms =
                    if before.is_none() { 0 } else { disarms + u32::from(said.status.state == StateCode::Disarming) };
                if disarms > ticks && matches!(said.status.state, StateCode::Fault | StateCode::Disarming) {
                    fault(said);
                }
            }
        });
        assert_eq!(law, SafetyProperty::Disarmed, "{ticks}");
    }
    let law = found("states.toml", FaultKind::HostSilent, Situation::Holding, |moment| {
        if let Moment::Output(said, Some(before)) = moment
            && before.status.state == StateCode::Disarming
        {
            let tick = said.status.tick;
            *said = before.clone();
            said.status.tick = tick;
        }
    });
    assert_eq!(law, SafetyProperty::Disarmed);
}

#[test]
fn a_state_without_a_request_a_homing_that_never_was_and_a_false_report_are_found() {
    let jump_to = |state: StateCode| {
        move |moment: Moment<'_>| {
            if let Moment::Output(said, ..) = moment
                && said.status.tick > 5
            {
                said.status.state = state;
            }
        }
    };
    assert_eq!(
        found("states.toml", FaultKind::Nothing, Situation::Idle, jump_to(StateCode::Homing)),
        SafetyProperty::Transition
    );
    let law = found("states.toml", FaultKind::Nothing, Situation::Idle, |moment| {
        if let Moment::Output(said, ..) = moment {
            said.status.homed = true;
        }
    });
    assert_eq!(law, SafetyProperty::Homed);
    let law = found("states.toml", FaultKind::Nothing, Situation::Armed, |moment| {
        if let Moment::Output(said, ..) = moment
            && said.status.state == StateCode::Armed
        {
            let drives = said.drives;
            brake(said);
            said.drives = drives;
        }
    });
    assert_eq!(law, SafetyProperty::Reported);
    let law = found("states.toml", FaultKind::Nothing, Situation::Idle, |moment| {
        if let Moment::Output(said, ..) = moment {
            said.drives = Drives::Safe(SafeAction::Off);
            said.status.actuation = Some(Actuation::Off);
        }
    });
    assert_eq!(law, SafetyProperty::SafeAction);
}

#[test]
fn a_wrong_name_and_a_reference_that_is_followed_anywhere_are_found() {
    let law = found("states.toml", FaultKind::EmergencyStop, Situation::Armed, |moment| {
        if let Moment::Output(said, ..) = moment
            && said.status.state == StateCode::Fault
        {
            said.status.cause = 11;
        }
    });
    assert_eq!(law, SafetyProperty::Named);
    for (value, law) in [(f32::NAN, SafetyProperty::Reference), (2.5, SafetyProperty::Reference)] {
        let by = found("states.toml", FaultKind::Nothing, Situation::Running, |moment| {
            if let Moment::Output(said, ..) = moment
                && let link::ExtraFields::Reference(reference) = &mut said.status.extra
            {
                reference.q[1] = value;
            }
        });
        assert_eq!(by, law);
    }
    // Remove the flag of a clamped velocity.
    let by = found("states.toml", FaultKind::Nothing, Situation::Running, |moment| {
        if let Moment::Output(said, ..) = moment
            && let link::ExtraFields::Reference(reference) = &mut said.status.extra
        {
            reference.qd[5] = 8.5;
        }
    });
    assert_eq!(by, SafetyProperty::Held);
}

/// Two scenes in turn, and every fault in every state of the scene that has more cases.
const CASES: u64 = 2 * 32 * 7;

pub(crate) fn report(runs: impl IntoIterator<Item = u64>) -> Report {
    let scenes = vec![scene("encoders.toml"), scene("states.toml")];
    let campaign = Campaign { scenes, seed: 1, runs: runs.into_iter().collect(), target: Target::Desk };
    campaign.report(&AtomicBool::new(false), &ProgressBar::hidden()).unwrap()
}

#[test]
fn no_command_is_unsafe_whatever_fails_in_whatever_state() {
    // Every fault in every state of both scenes, once.
    let report = report(0..CASES);
    assert!(report.counterexamples.is_empty(), "{}", report.table());
    // The page says in words what its colours show.
    let page = report.page().html();
    for part in [
        "<span class=\"tone stop\">fault 9: ",
        "<span class=\"tone caution\">hold ",
        "<span class=\"tone quiet\">goes on: ",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert_eq!((report.runs, report.rows.len()), (CASES, FaultKind::NAMES.len()));
    let row = |fault| report.rows.iter().find(|row| row.fault == fault).unwrap();
    assert!(report.rows.iter().all(|row| row.cells.iter().all(|cell| cell.runs > 0)));
    // The machine is not overcautious: without a fault nothing happens.
    for cell in &row(FaultKind::Nothing).cells {
        assert!(cell.outcomes.iter().all(|(outcome, _)| *outcome == Outcome::Unaffected), "{cell:?}");
    }
    // Faults that must be detected in every state are detected.
    for (fault, code) in [(FaultKind::EmergencyStop, 9), (FaultKind::Overrun, 6), (FaultKind::Drive, 11)] {
        for cell in row(fault).cells.iter().take(6) {
            assert!(cell.outcomes.iter().all(|(outcome, _)| *outcome == Outcome::Fault(code)), "{fault:?} {cell:?}");
        }
    }
}

#[test]
fn the_runs_of_a_campaign_do_not_depend_on_threads_or_on_each_other() {
    let text = |mut report: Report| {
        report.seconds = 0.0;
        serde_json::to_string(&report).unwrap()
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(one.install(|| text(report(500..560))), three.install(|| text(report(500..560))));
}
