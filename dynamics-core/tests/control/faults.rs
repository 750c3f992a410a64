//! Each fault is raised by its cause, has its number, and stays until the reset; a reset restores everything.

use crate::control::support::{braked, config, controller, driven, measured};
use dynamics_core::control::{ControlLaw, Friction, Guard};
use dynamics_core::{ControllerConfig, Fault, Limits, Measurement, Reference, Sensed};

fn settings() -> ControllerConfig<f64, 2> {
    let mut settings = config(ControlLaw::ComputedTorque);
    settings.limits = [Limits { position: (-2.0, 2.0), ..Limits::none() }; 2];
    settings.guard = [Guard { position_margin: 0.25, velocity_max: 5.0 }; 2];
    settings
}

/// The fault and its code.
type Expected = Option<(Fault, u8)>;

type Case = (Reference<f64, 2>, Measurement<f64, 2>);

fn good() -> Case {
    (Reference { q: [0.1, 0.2], qd: [0.3, 0.4], qdd: [0.5, 0.6] }, measured([0.1, 0.2], [0.3, 0.4]))
}

fn state(q: [f64; 2], qd: [f64; 2]) -> Case {
    (good().0, measured(q, qd))
}

fn reference(change: impl Fn(&mut Reference<f64, 2>)) -> Case {
    let mut case = good();
    change(&mut case.0);
    case
}

fn aged(age_ticks: u32) -> Case {
    (good().0, Measurement { age_ticks, ..good().1 })
}

/// Every cause together with the nearest input that raises no fault.
fn table() -> Vec<(&'static str, Case, Expected)> {
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let measurement = |joint| Some((Fault::NonFiniteMeasurement { joint }, 1));
    let wanted = |joint| Some((Fault::NonFiniteReference { joint }, 2));
    let position = |joint| Some((Fault::PositionOutOfBounds { joint }, 4));
    let velocity = |joint| Some((Fault::VelocityOutOfBounds { joint }, 5));
    let torque = |joint| Some((Fault::NonFiniteTorque { joint }, 7));
    vec![
        ("nothing", good(), None),
        ("q NaN", state([nan, 0.0], [0.0; 2]), measurement(0)),
        ("q infinite", state([0.0, inf], [0.0; 2]), measurement(1)),
        ("q minus infinite", state([0.0, -inf], [0.0; 2]), measurement(1)),
        ("qd NaN", state([0.0; 2], [0.0, nan]), measurement(1)),
        ("qd infinite", state([0.0; 2], [-inf, 0.0]), measurement(0)),
        ("q_ref NaN", reference(|r| r.q[0] = nan), wanted(0)),
        ("qd_ref infinite", reference(|r| r.qd[1] = inf), wanted(1)),
        ("qdd_ref NaN", reference(|r| r.qdd[1] = nan), wanted(1)),
        ("q_ref huge but a number", reference(|r| r.q[0] = 1e300), None),
        ("oldest allowed", aged(2), None),
        ("too old", aged(3), Some((Fault::StaleMeasurement, 3))),
        ("oldest there is", aged(u32::MAX), Some((Fault::StaleMeasurement, 3))),
        ("in the margin", state([2.25, -2.25], [0.0; 2]), None),
        ("beyond the margin", state([2.25_f64.next_up(), 0.0], [0.0; 2]), position(0)),
        ("below the margin", state([0.0, -2.25_f64.next_up()], [0.0; 2]), position(1)),
        ("as fast as allowed", state([0.0; 2], [5.0, -5.0]), None),
        ("too fast", state([0.0; 2], [5.0_f64.next_up(), 0.0]), velocity(0)),
        ("too fast backwards", state([0.0; 2], [0.0, -5.0_f64.next_up()]), velocity(1)),
        ("torque overflows", reference(|r| r.qdd = [1e308; 2]), torque(0)),
        // More than one cause: the age first, then the reference, then the state, joint by joint.
        ("too old and NaN", (reference(|r| r.q[0] = nan).0, aged(9).1), Some((Fault::StaleMeasurement, 3))),
        ("both NaN", (reference(|r| r.q[1] = nan).0, state([nan; 2], [0.0; 2]).1), wanted(1)),
        ("fast and far", state([9.0, 0.0], [9.0, 0.0]), position(0)),
    ]
}

#[test]
fn each_fault_is_raised_by_its_cause_with_its_code_and_by_nothing_else() {
    for (cause, (reference, measurement), expected) in table() {
        let mut controller = controller(settings());
        let fault = braked(&controller.tick(&reference, &measurement));
        assert_eq!(fault.map(|fault| (fault, fault.code())), expected, "{cause}");
        assert_eq!(controller.fault(), fault, "{cause}");
    }
}

#[test]
fn a_torque_that_overflows_in_the_friction_term_is_a_fault_of_that_joint() {
    let mut settings = settings();
    let friction = Friction { viscous: 1.0, coulomb: 0.0, per_smoothing_speed: 1.0 };
    settings.friction = Some([friction, Friction { viscous: 1e308, ..friction }]);
    let case = reference(|r| r.qd = [0.0, 1e3]);
    assert_eq!(braked(&controller(settings).tick(&case.0, &case.1)), Some(Fault::NonFiniteTorque { joint: 1 }));
}

#[test]
fn an_overrun_and_a_lost_measurement_are_faults_when_told() {
    let (reference, measurement) = good();
    let mut overrun = controller(settings());
    overrun.overrun();
    assert_eq!(braked(&overrun.tick(&reference, &measurement)), Some(Fault::Overrun));
    assert_eq!(Fault::Overrun.code(), 6);
    let mut lost = controller(settings());
    lost.measurement_lost();
    assert_eq!(braked(&lost.tick(&reference, &measurement)), Some(Fault::StaleMeasurement));
}

#[test]
fn the_first_fault_stays_until_the_reset_whatever_comes() {
    let (reference, measurement) = good();
    for (cause, (bad_reference, bad_measurement), expected) in table() {
        let Some((fault, _)) = expected else { continue };
        let mut controller = controller(settings());
        driven(controller.tick(&reference, &measurement));
        controller.tick(&bad_reference, &bad_measurement);
        for _ in 0..3 {
            assert_eq!(braked(&controller.tick(&reference, &measurement)), Some(fault), "{cause}");
        }
        // A later fault does not hide the first.
        controller.overrun();
        controller.measurement_lost();
        for (_, (other_reference, other_measurement), _) in table() {
            assert_eq!(braked(&controller.tick(&other_reference, &other_measurement)), Some(fault), "{cause}");
        }
    }
}

#[test]
fn a_reset_makes_the_controller_as_good_as_new() {
    let counts = Measurement { sensed: Sensed::Counts([1000, 2000]), age_ticks: 0 };
    let (reference, _) = good();
    let new = controller(settings());
    for (cause, (bad_reference, bad_measurement), expected) in table() {
        let mut used = new.clone();
        for _ in 0..5 {
            driven(used.tick(&reference, &counts));
        }
        used.tick(&bad_reference, &bad_measurement);
        assert_ne!(used, new, "{cause}");
        used.reset();
        assert_eq!(used, new, "{cause}, {expected:?}");
        assert_eq!(used.tick(&reference, &counts), controller(settings()).tick(&reference, &counts));
    }
}

/// All numbers that have a meaning.
const CODES: core::ops::RangeInclusive<u8> = 1..=20;

#[test]
fn codes_and_joints_make_the_round_trip_and_other_codes_mean_nothing() {
    for code in 0..=u8::MAX {
        for joint in [0, 3, 5, u8::MAX] {
            let Some(fault) = Fault::from_code(code, joint) else {
                assert!(!CODES.contains(&code), "code {code} has a meaning");
                continue;
            };
            assert!(CODES.contains(&code));
            assert_eq!(fault.code(), code);
            assert_eq!(fault.joint().unwrap_or(joint), joint);
            assert_eq!(fault.joint().is_none(), [3, 6, 9, 10, 12, 13, 19].contains(&code));
            assert_eq!(Fault::from_code(fault.code(), fault.joint().unwrap_or(0)), Some(fault));
        }
    }
}

#[test]
fn messages_name_the_code_and_count_joints_from_one() {
    assert_eq!(Fault::PositionOutOfBounds { joint: 2 }.to_string(), "fault 4: position out of bounds (joint 3)");
    assert_eq!(Fault::Overrun.to_string(), "fault 6: control tick overran");
}
