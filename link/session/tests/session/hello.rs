//! Tests of a hello and a fault at nearly the same time: in every order the black box keeps the fault and the ticks around it.

use super::OWN;
use super::supervised::Arm;
use dynamics_core::control::Fault;
use dynamics_core::safety;
use link::{Frame, Hello, Pacing, Request, StateCode, Status};
use newtau_session::black_box::{TICKS, TICKS_AFTER};
use newtau_session::readings::JointFaults;

/// An arm that has run for longer than the black box remembers.
fn long_running() -> Arm {
    let mut arm = Arm::running();
    for _ in 0..60 {
        arm.follow();
    }
    assert_eq!(arm.state(), safety::State::Running);
    arm
}

fn hello(arm: &mut Arm, pacing: Pacing) {
    arm.receive(Frame::Hello(Hello { pacing, ..OWN }));
}

/// Sends the hello of a host with another robot's files: the session ends.
fn stranger(arm: &mut Arm) {
    arm.receive(Frame::Hello(Hello { robot: 8, ..OWN }));
}

fn ticks(arm: &mut Arm, ticks: u32) {
    for _ in 0..ticks {
        arm.tick();
    }
}

/// The black box, read completely.
fn past(arm: &mut Arm) -> Vec<Status> {
    arm.receive(Frame::Dump);
    let past = arm.said().into_iter().filter_map(|frame| match frame {
        Frame::Past(status) => status,
        _ => None,
    });
    past.collect()
}

/// An event that causes a fault in the next tick and ends after it: name, fault, start and end.
type Happens = (&'static str, Fault, fn(&mut Arm), fn(&mut Arm));

const FAULTS: [Happens; 4] = [
    (
        "emergency stop",
        Fault::EmergencyStop,
        |arm| arm.lines.emergency_stop = true,
        |arm| arm.lines.emergency_stop = false,
    ),
    (
        "a drive's error",
        Fault::DriveFault { joint: 1 },
        |arm| arm.faults[1] = JointFaults::DRIVE,
        |arm| arm.faults[1] = JointFaults::NONE,
    ),
    ("a drive that goes off", Fault::DriveOff { joint: 0 }, |arm| arm.on[0] = false, |arm| arm.on[0] = true),
    ("an overrun", Fault::Overrun, |arm| arm.session.overrun(), |_| {}),
];

/// Checks that the fault is kept, with `after` ticks after it and with ticks in motion before it, and that it can be released after reading.
fn keeps(arm: &mut Arm, fault: Fault, after: u32, name: &str) {
    let status = arm.watched();
    assert!(status.kept, "{name}: it is not kept");
    let past = past(arm);
    assert_eq!(past.len(), TICKS, "{name}");
    let first =
        past.iter().position(|status| status.state == StateCode::Fault).unwrap_or_else(|| panic!("{name}: no fault"));
    assert_eq!((past[first].cause, past[first].joint), (fault.code(), fault.joint()), "{name}");
    assert_eq!(past.len() - 1 - first, after as usize, "{name}: ticks after it");
    assert!(past[..first].iter().all(|status| status.state == StateCode::Running), "{name}: ticks before it");
    arm.asked(Request::Release);
    assert!(!arm.watched().kept, "{name}: released");
}

#[test]
fn a_hello_in_the_tick_of_a_fault_or_in_those_after_it_keeps_the_fault_and_its_ticks() {
    for (name, fault, happens, passes) in FAULTS {
        for after in 0..=12 {
            // One hello; two in a row; or a second one some ticks later, possibly before the black box has stopped.
            for second in [None, Some(0), Some(1), Some(2), Some(7)] {
                let mut arm = long_running();
                happens(&mut arm);
                arm.tick();
                assert_eq!(arm.state(), safety::State::Fault(fault), "{name}");
                passes(&mut arm);
                ticks(&mut arm, after);
                hello(&mut arm, Pacing::Live);
                if let Some(later) = second {
                    ticks(&mut arm, later);
                    hello(&mut arm, Pacing::Live);
                }
                ticks(&mut arm, 60);
                let kept = after.min(u32::from(TICKS_AFTER));
                keeps(&mut arm, fault, kept, &format!("{name}, hello after {after} ticks, again after {second:?}"));
            }
        }
    }
}

#[test]
fn a_fault_is_kept_through_a_session_without_the_machine_and_through_a_stranger_s_hello() {
    for between in [|arm: &mut Arm| hello(arm, Pacing::LockStep), |arm: &mut Arm| hello(arm, Pacing::DryRun), stranger]
    {
        for after in [0, 3, 20] {
            let mut arm = long_running();
            arm.lines.emergency_stop = true;
            ticks(&mut arm, 1 + after);
            arm.lines.emergency_stop = false;
            between(&mut arm);
            hello(&mut arm, Pacing::Live);
            ticks(&mut arm, 60);
            keeps(&mut arm, Fault::EmergencyStop, after.min(u32::from(TICKS_AFTER)), "");
        }
    }
}

/// A hello arrives before the tick that raises the fault: the session goes on and keeps the ticks before it.
#[test]
fn a_hello_before_the_tick_of_a_fault_keeps_the_ticks_before_it() {
    for hellos in 1..=2 {
        let mut arm = long_running();
        arm.lines.emergency_stop = true;
        for _ in 0..hellos {
            hello(&mut arm, Pacing::Live);
        }
        ticks(&mut arm, 60);
        assert_eq!(arm.state(), safety::State::Fault(Fault::EmergencyStop));
        keeps(&mut arm, Fault::EmergencyStop, u32::from(TICKS_AFTER), "stop");
    }
}

/// The last tick of a live session was late, and a hello arrives before the tick that would have raised the fault.
#[test]
fn a_late_tick_before_a_hello_is_a_fault_of_the_new_session_with_the_ticks_before_it() {
    for hellos in 1..=2 {
        let mut arm = long_running();
        arm.session.overrun();
        for _ in 0..hellos {
            hello(&mut arm, Pacing::Live);
        }
        arm.tick();
        assert_eq!(arm.state(), safety::State::Fault(Fault::Overrun));
        ticks(&mut arm, 60);
        keeps(&mut arm, Fault::Overrun, u32::from(TICKS_AFTER), "late");
    }
    // In a bench mode the controller reports the fault itself.
    let mut arm = Arm::live();
    hello(&mut arm, Pacing::Timer);
    arm.session.overrun();
    hello(&mut arm, Pacing::Live);
    arm.tick();
    assert_eq!(arm.state(), safety::State::Idle);
}

/// A fault that a host has read and released is not kept again, although the ring still holds its ticks.
#[test]
fn a_hello_does_not_bring_back_a_fault_that_was_released() {
    for hellos in 1..=2 {
        let mut arm = long_running();
        arm.lines.emergency_stop = true;
        ticks(&mut arm, 20);
        assert_eq!(past(&mut arm).len(), TICKS);
        arm.asked(Request::Release);
        ticks(&mut arm, 60);
        assert_eq!(arm.state(), safety::State::Fault(Fault::EmergencyStop));
        arm.lines.emergency_stop = false;
        for _ in 0..hellos {
            hello(&mut arm, Pacing::Live);
        }
        ticks(&mut arm, 3);
        assert!(!arm.watched().kept);
        assert!(past(&mut arm).iter().all(|status| status.state == StateCode::Idle));
    }
}
