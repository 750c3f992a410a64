//! The judge alone: properties that need every message of the host, and faults without a cause.

use super::desk::{Moment, N, brake, found, scene};
use dynamics_core::Sensed;
use dynamics_core::safety::SafeAction;
use link::{Actuation, Denial, Pacing, Request, StateCode, Status};
use session::Drives;
use trials::campaign::judge::{Heard, Judge, Trust};
use trials::campaign::{FaultKind, SafetyProperty, Situation, TickInputs, TickOutput};

#[test]
fn a_fault_out_of_nothing_is_found() {
    for cause in [1, 3, 6, 9, 11, 12, 13] {
        let law = found("states.toml", FaultKind::Nothing, Situation::Armed, |moment| {
            if let Moment::Output(said, before) = moment
                && before.is_some_and(|before| matches!(before.status.state, StateCode::Armed | StateCode::Fault))
            {
                brake(said);
                (said.status.state, said.status.cause) = (StateCode::Fault, cause);
            }
        });
        assert_eq!(law, SafetyProperty::Named, "fault {cause}");
    }
}

/// Status of an idle machine.
fn idle() -> Status {
    Status {
        tick: 1,
        taken: 0,
        state: StateCode::Idle,
        cause: 0,
        joint: None,
        homed: false,
        refused: None,
        kept: false,
        room: 16,
        actuation: Some(Actuation::Brake),
        sensed: None,
        extra: link::ExtraFields::Nothing,
        cost: None,
    }
}

/// Property that a first tick violates, for a judge that knows every accepted message, and for one that does not.
fn first_tick(requests: &[Request], spoke: bool, status: &Status) -> [Option<SafetyProperty>; 2] {
    let scene = scene("states.toml");
    let model = scene.robot.model::<N>().unwrap();
    let (config, rules) = (scene.controller_config(&model), scene.safety_rules(&model));
    let told = TickInputs {
        tick: 1,
        sensed: Sensed::State { q: [0.0; N], qd: [0.0; N] },
        age_ticks: [0; N],
        emergency_stop: false,
        overrun: false,
        zeroed: true,
        drive_fault: [false; N],
        supply: None,
        temperature: None,
    };
    [true, false].map(|exact| {
        let mut judge = Judge::new(&config, &rules, Trust::Nothing);
        let said = TickOutput { drives: Drives::Safe(SafeAction::Brake), status: status.clone() };
        judge.watch(&told, &Heard { requests, spoke, exact }, &said).err().map(|broken| broken.law)
    })
}

#[test]
fn who_knows_each_word_finds_a_wrong_answer_and_a_host_that_is_missed_too_early() {
    let idle = idle();
    let refused = Status { refused: Some(Denial { code: 1, fault: 0, joint: None, input: 0 }), ..idle.clone() };
    let homing = Status { state: StateCode::Homing, ..refused.clone() };
    let lost = Status { state: StateCode::Fault, cause: 10, ..idle.clone() };
    let (answered, silence) = ([Some(SafetyProperty::Answered), None], [Some(SafetyProperty::Silence), None]);
    assert_eq!(first_tick(&[], true, &idle), [None; 2]);
    assert_eq!(first_tick(&[Request::Run], true, &refused), [None; 2]);
    assert_eq!(first_tick(&[], false, &lost), [None; 2]);
    assert_eq!(first_tick(&[], true, &refused), answered, "refused, and nothing was asked for");
    assert_eq!(first_tick(&[Request::Run], true, &idle), answered, "neither granted nor refused");
    assert_eq!(first_tick(&[Request::Home], true, &homing), answered, "refused and granted");
    assert_eq!(first_tick(&[], true, &lost), silence, "missed while it is there");
}

#[test]
fn a_dry_run_that_drives_is_found() {
    let scene = scene("states.toml");
    let model = scene.robot.model::<N>().unwrap();
    let judge = Judge::new(&scene.controller_config(&model), &scene.safety_rules(&model), Trust::Nothing);
    let (driven, wrong) = (Drives::Drive([0.0; N]), Drives::Safe(SafeAction::Off));
    let law = |pacing, drives| judge.acts(pacing, drives, &idle()).err().map(|broken| broken.law);
    assert_eq!(law(Pacing::Live, &driven), None);
    assert_eq!(law(Pacing::DryRun, &driven), Some(SafetyProperty::SafeAction));
    assert_eq!(law(Pacing::DryRun, &wrong), Some(SafetyProperty::SafeAction));
    assert_eq!(law(Pacing::DryRun, &Drives::Safe(SafeAction::Brake)), None);
}
