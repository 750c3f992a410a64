//! Tests of the frames of Damiao's, RobStride's and MyActuator's motors, against frames written by hand from the documented layout, and with simulated drives.

use super::drive;
use dynamics_core::drive::{Damiao, MitDrive, MitRanges, MyActuator, Range, RobStride};
use dynamics_core::safety::SafeAction;
use embedded_can::{ErrorKind, ExtendedId, Frame, Id, StandardId};
use joint_io::can::CanJoints;
use joint_io::can_bus::{CanBus, NoBus};
use joint_io::damiao::CLEAR;
use joint_io::frames::{Frames, Notice, Packet};
use joint_io::mit::{ENTER, EXIT, Setpoint};
use joint_io::{JointIo as _, NoPin};
use session::readings::JointFaults;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

fn standard(id: u16) -> Id {
    StandardId::new(id).unwrap().into()
}

fn extended(id: u32) -> Id {
    ExtendedId::new(id).unwrap().into()
}

/// A drive with ranges equal to the range of codes, so that every value equals its code.
fn with_unit_ranges(bits: [u32; 5]) -> MitDrive {
    let [position, velocity, kp, kd, torque] =
        bits.map(|bits| Range { min: 0.0, max: f32::from(u16::MAX >> (16 - bits)) });
    MitDrive { ranges: MitRanges { position, velocity, kp, kd, torque }, ..drive(0, 0x15) }
}

const SETPOINT: [u16; 5] = [0x1234, 0x567, 0x89a, 0xbcd, 0xef0];

fn setpoint([position, velocity, kp, kd, torque]: [u16; 5]) -> Setpoint {
    let [position, velocity, kp, kd, torque] = [position, velocity, kp, kd, torque].map(f32::from);
    Setpoint { position, velocity, kp, kd, torque }
}

#[test]
fn a_damiao_is_told_as_a_mini_cheetah_and_has_one_more_special_frame() {
    let drive = with_unit_ranges([16, 12, 12, 12, 12]);
    let packet = Damiao::command(&drive, &setpoint(SETPOINT)).unwrap();
    assert_eq!(packet, Packet { id: standard(0x15), data: [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0] });
    assert_eq!(Damiao::enter(&drive), Packet { id: standard(0x15), data: ENTER });
    assert_eq!(Damiao::exit(&drive), Packet { id: standard(0x15), data: EXIT });
    assert_eq!(Damiao::clear(&drive), Some(Packet { id: standard(0x15), data: CLEAR }));
    assert_eq!(Damiao::command(&drive, &Setpoint::torque(f32::NAN)), None);
}

#[test]
fn a_damiaos_reply_has_its_state_and_the_higher_of_its_temperatures() {
    let drive = MitDrive { reply_id: 0x25, ..with_unit_ranges([16, 12, 12, 12, 12]) };
    let reply = |head: u8| Damiao::reply(&drive, standard(0x25), &[head, 0x12, 0x34, 0x56, 0x78, 0x9a, 41, 57]);
    let on = reply(0x15).unwrap();
    assert_eq!(
        (on.position, on.velocity, on.torque),
        (f32::from(0x1234_u16), f32::from(0x567_u16), f32::from(0x89a_u16))
    );
    assert_eq!((on.temperature, on.error, on.off), (Some(57.0), 0, false));
    let off = reply(0x05).unwrap();
    assert_eq!((off.error, off.off), (0, true));
    for (state, words) in [(0x8, "supply voltage too high"), (0xc, "winding too hot"), (0xe, "overloaded")] {
        let failed = reply(state << 4 | 5).unwrap();
        assert_eq!((failed.error, Damiao::error_text(failed.error)), (state, words));
    }
    assert_eq!(reply(0x16), None, "the reply of motor 6");
    for length in 0..8 {
        assert_eq!(Damiao::reply(&drive, standard(0x25), &[0x15; 8][..length]), None);
    }
    for (id, answers) in [(standard(0x25), true), (standard(0x15), false), (extended(0x25), false)] {
        assert_eq!(Damiao::answers(&drive, id), answers, "{id:?}");
    }
}

/// A RobStride drive with identifier 0x15 and host 0xfd.
fn robstride() -> MitDrive {
    MitDrive { reply_id: 0xfd, ..with_unit_ranges([16; 5]) }
}

#[test]
fn a_robstride_is_told_its_torque_in_the_identifier() {
    let drive = robstride();
    let packet = RobStride::command(&drive, &setpoint([0x1234, 0x5678, 0x9abc, 0xdef0, 0x2468])).unwrap();
    assert_eq!(packet.id, extended(0x0124_6815));
    assert_eq!(packet.data, [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0]);
    assert_eq!(RobStride::enter(&drive), Packet { id: extended(0x0300_fd15), data: [0; 8] });
    assert_eq!(RobStride::exit(&drive), Packet { id: extended(0x0400_fd15), data: [0; 8] });
    assert_eq!(RobStride::clear(&drive), Some(Packet { id: extended(0x0400_fd15), data: [1, 0, 0, 0, 0, 0, 0, 0] }));
    assert_eq!(RobStride::command(&drive, &Setpoint::torque(f32::NAN)), None);
}

#[test]
fn a_robstrides_reply_has_its_state_and_errors_in_the_identifier() {
    let drive = robstride();
    // 36.5 degrees.
    let data = [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0x01, 0x6d];
    let running = RobStride::reply(&drive, extended(0x0280_15fd), &data).unwrap();
    let values = (running.position, running.velocity, running.torque);
    assert_eq!(values, (f32::from(0x1234_u16), f32::from(0x5678_u16), f32::from(0x9abc_u16)));
    assert!((running.temperature.unwrap() - 36.5).abs() < 1e-5);
    assert_eq!((running.error, running.off), (0, false));
    let hot_and_off = RobStride::reply(&drive, extended(0x0204_15fd), &data).unwrap();
    assert_eq!((RobStride::error_text(hot_and_off.error), hot_and_off.off), ("too hot", true));
    let low = RobStride::reply(&drive, extended(0x0281_15fd), &data).unwrap();
    assert_eq!((RobStride::error_text(low.error), low.off), ("supply voltage too low", false));
    assert_eq!(RobStride::reply(&drive, extended(0x0280_15fd), &data[..7]), None);
    // Frames of another motor, to another host, of another kind, and with a standard identifier.
    for id in [extended(0x0280_16fd), extended(0x0280_15fc), extended(0x0180_15fd), standard(0x5fd)] {
        assert!(!RobStride::answers(&drive, id), "{id:?}");
    }
    assert!(RobStride::answers(&drive, extended(0x0280_15fd)));
}

/// A MyActuator drive with identifier 0x15.
fn my_actuator() -> MitDrive {
    MitDrive { reply_id: 0x515, ..with_unit_ranges([16, 12, 12, 12, 12]) }
}

#[test]
fn a_myactuator_has_the_commands_of_a_mini_cheetah_and_other_identifiers_for_everything_else() {
    let drive = my_actuator();
    let packet = MyActuator::command(&drive, &setpoint(SETPOINT)).unwrap();
    assert_eq!(packet, Packet { id: standard(0x415), data: [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0] });
    assert_eq!(MyActuator::command(&drive, &Setpoint::torque(f32::NAN)), None);
    let request = |first: u8| Packet { id: standard(0x155), data: [first, 0, 0, 0, 0, 0, 0, 0] };
    assert_eq!(MyActuator::enter(&drive), request(0x77));
    assert_eq!(MyActuator::exit(&drive), request(0x80));
    assert_eq!(MyActuator::request_status(&drive), Some(request(0x9a)));
    assert_eq!((MyActuator::clear(&drive), MyActuator::read_timeout(&drive)), (None, None));
    for (id, receiver) in [(0x415, 0x15), (0x155, 0x15), (0x401, 1), (0x141, 1)] {
        assert_eq!(MyActuator::receiver(standard(id)), receiver, "{id:x}");
    }
    assert!(MyActuator::receiver(standard(0x13f)) > 255 && MyActuator::receiver(extended(0x415)) > 255);
}

#[test]
fn only_a_frame_with_the_identifier_of_replies_is_a_reply_of_a_myactuator() {
    let drive = my_actuator();
    let data = [0x15, 0x12, 0x34, 0x56, 0x78, 0x9a, 0, 0];
    let reply = MyActuator::reply(&drive, standard(0x515), &data).unwrap();
    let values = (reply.position, reply.velocity, reply.torque);
    assert_eq!(values, (f32::from(0x1234_u16), f32::from(0x567_u16), f32::from(0x89a_u16)));
    assert_eq!((reply.temperature, reply.error, reply.off, reply.saturated), (None, 0, false, false));
    // Another length, another drive, bytes that are not zero, and other identifiers.
    assert_eq!(MyActuator::reply(&drive, standard(0x515), &data[..6]), None);
    for (at, value) in [(0, 0x16), (6, 1), (7, 1)] {
        let mut other = data;
        other[at] = value;
        assert_eq!(MyActuator::reply(&drive, standard(0x515), &other), None, "byte {at}");
    }
    for id in [standard(0x255), standard(0x415), standard(0x155), standard(0x516), extended(0x515)] {
        assert_eq!(MyActuator::reply(&drive, id, &data), None, "{id:?}");
    }
    for (id, answers) in [(0x515, true), (0x255, true), (0x415, false), (0x155, false), (0x516, false), (0x256, false)]
    {
        assert_eq!(MyActuator::answers(&drive, standard(id)), answers, "{id:x}");
    }
    assert!(!MyActuator::answers(&drive, extended(0x515)) && !MyActuator::answers(&drive, extended(0x255)));
}

#[test]
fn a_myactuators_other_answers_are_notices() {
    let drive = my_actuator();
    let notice = |data: [u8; 8]| MyActuator::notice(&drive, standard(0x255), &data);
    assert_eq!(notice([0x77, 0, 0, 0, 0, 0, 0, 0]), Some(Notice::On));
    assert_eq!(notice([0x80, 0, 0, 0, 0, 0, 0, 0]), Some(Notice::Off));
    // 50 and 45 degrees, brake released, 48.0 V; then the errors, low byte first.
    let status = |low: u8, high: u8| notice([0x9a, 50, 45, 1, 0xe0, 0x01, low, high]);
    assert_eq!(status(0, 0), Some(Notice::Status(0)));
    for (low, high, text) in [
        (0x02, 0x00, "stalled: it works again only after a restart"),
        (0x04, 0x00, "supply voltage too low"),
        (0x08, 0x00, "supply voltage too high"),
        (0x10, 0x00, "too much current: it works again only after a restart"),
        (0x40, 0x00, "too much power"),
        (0x80, 0x00, "calibration parameters wrong: it works again only after a restart"),
        (0x00, 0x01, "too fast"),
        (0x00, 0x08, "components too hot"),
        (0x00, 0x10, "motor too hot"),
        (0x00, 0x20, "encoder not calibrated"),
        (0x00, 0x40, "its encoder fails: it works again only after a restart"),
        (0x01, 0x00, "an error that its manual does not name"),
        // Of several the lowest bit.
        (0x08, 0x10, "supply voltage too high"),
    ] {
        let Some(Notice::Status(error)) = status(low, high) else { panic!("{low:x} {high:x}") };
        assert_eq!(MyActuator::error_text(error), text, "{low:x} {high:x}");
    }
    let Some(Notice::Status(error)) = notice([0xf1, 0, 0, 0, 0, 0, 0, 0]) else { panic!("its timeout has expired") };
    assert_eq!(MyActuator::error_text(error), "commands stayed out");
    // Answers to other requests, another drive's, a reply, and a short frame.
    for what in [0x9c, 0x92, 0xb3, 0x20, 0xb2] {
        assert_eq!(notice([what, 0, 0, 0, 0, 0, 0, 0]), None, "{what:x}");
    }
    for id in [standard(0x256), standard(0x515), extended(0x255)] {
        assert_eq!(MyActuator::notice(&drive, id, &[0x77, 0, 0, 0, 0, 0, 0, 0]), None, "{id:?}");
    }
    assert_eq!(MyActuator::notice(&drive, standard(0x255), &[0x77]), None);
}

#[test]
fn every_error_has_words() {
    for error in 1..=u8::MAX {
        assert_ne!(Damiao::error_text(error), "no error");
        assert_ne!(RobStride::error_text(error), "no error");
        assert_ne!(MyActuator::error_text(error), "no error");
    }
}

/// A data frame on the wire.
#[derive(Clone, Debug)]
struct Wire(Packet);

impl Frame for Wire {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Some(Self(Packet { id: id.into(), data: data.try_into().ok()? }))
    }
    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }
    fn is_extended(&self) -> bool {
        matches!(self.0.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        false
    }
    fn id(&self) -> Id {
        self.0.id
    }
    fn dlc(&self) -> usize {
        8
    }
    fn data(&self) -> &[u8] {
        &self.0.data
    }
}

/// A bus that records sent packets and returns prepared ones.
#[derive(Clone, Default)]
struct Tape(Rc<RefCell<(Vec<Packet>, VecDeque<Packet>)>>);

impl Tape {
    fn sent(&self) -> Vec<Packet> {
        std::mem::take(&mut self.0.borrow_mut().0)
    }
    fn say(&self, id: Id, data: [u8; 8]) {
        self.0.borrow_mut().1.push_back(Packet { id, data });
    }
}

impl embedded_can::nb::Can for Tape {
    type Frame = Wire;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Wire) -> nb::Result<Option<Wire>, ErrorKind> {
        self.0.borrow_mut().0.push(frame.0);
        Ok(None)
    }
    fn receive(&mut self) -> nb::Result<Wire, ErrorKind> {
        self.0.borrow_mut().1.pop_front().map(Wire).ok_or(nb::Error::WouldBlock)
    }
}

impl CanBus for Tape {
    fn is_off(&mut self) -> bool {
        false
    }
    fn abandon(&mut self) {}
}

/// Creates two motors on the first bus; also returns that bus.
fn pair<F: Frames>(drive: impl Fn(u8) -> MitDrive) -> (CanJoints<F, Tape, NoBus, NoBus, NoPin, 2>, Tape) {
    let tape = Tape::default();
    let mut joints = CanJoints::new((tape.clone(), NoBus, NoBus), NoPin, [drive(1), drive(2)]);
    joints.safe(SafeAction::Off);
    tape.sent();
    (joints, tape)
}

#[test]
fn an_error_stops_the_joint_and_is_cleared_before_torque_is_given_again() {
    let damiao = |id| MitDrive { id, reply_id: 0x10 + u16::from(id), ..with_unit_ranges([16, 12, 12, 12, 12]) };
    let (mut joints, tape) = pair::<Damiao>(damiao);
    let reply = |tape: &Tape, states: [u8; 2]| {
        for (id, state) in (1_u8..).zip(states) {
            tape.say(standard(0x10 + u16::from(id)), [state << 4 | id, 0x80, 0, 0x80, 8, 0, 30, 30]);
        }
    };
    let kinds = |tape: &Tape| tape.sent().iter().rev().map(|packet| packet.data[7]).collect::<Vec<_>>();
    let faults = |joints: &mut CanJoints<Damiao, Tape, NoBus, NoBus, NoPin, 2>| joints.measure().unwrap().faults;

    reply(&tape, [0, 0]);
    assert_eq!(faults(&mut joints), [JointFaults::NONE; 2], "off, as it was told to be");
    joints.drive(&[0.0; 2], None);
    assert_eq!(kinds(&tape), [0xfc, 0xfc]);
    reply(&tape, [1, 1]);
    joints.measure();
    joints.drive(&[0.0; 2], None);
    tape.sent();
    // The winding of the second motor becomes too hot.
    reply(&tape, [1, 0xc]);
    let readings = joints.measure().unwrap();
    assert_eq!((readings.faults, readings.errors), ([JointFaults::NONE, JointFaults::DRIVE], [0, 0xc]));
    joints.safe(SafeAction::Off);
    assert_eq!(kinds(&tape), [0xfd, 0xfd]);
    reply(&tape, [0, 0xc]);
    joints.measure();
    // Torque is commanded again: the second drive's error is cleared first, and the drive is enabled a tick later.
    joints.drive(&[0.0; 2], None);
    assert_eq!(kinds(&tape), [0xfc, 0xfb]);
    reply(&tape, [1, 0]);
    assert_eq!(faults(&mut joints), [JointFaults::NONE; 2]);
    joints.drive(&[0.0; 2], None);
    assert_eq!(kinds(&tape)[1], 0xfc);
}

#[test]
fn a_drive_that_goes_off_by_itself_is_seen_in_its_tick_and_one_that_never_goes_on_never_counts_as_on() {
    let (mut joints, tape) = pair::<RobStride>(|id| MitDrive { id, ..robstride() });
    let reply = |tape: &Tape, states: [u32; 2]| {
        for (id, state) in (1_u32..).zip(states) {
            tape.say(extended(0x0200_00fd | state << 22 | id << 8), [0x80, 0, 0x80, 0, 0x80, 0, 1, 0]);
        }
    };
    reply(&tape, [0, 0]);
    joints.measure();
    // Both are enabled; the second never reports that it is on.
    for tick in 0..30 {
        joints.enable(SafeAction::Off);
        reply(&tape, [2, 0]);
        let readings = joints.measure().unwrap();
        assert_eq!(readings.faults, [JointFaults::NONE; 2]);
        assert_eq!(readings.on, [tick > 0, false], "{tick}");
    }
    for state in [2, 2, 0] {
        joints.preload(&[0.0; 2], None);
        reply(&tape, [2, state]);
        joints.measure();
    }
    reply(&tape, [0, 0]);
    joints.preload(&[0.0; 2], None);
    let readings = joints.measure().unwrap();
    // Detected in the same tick.
    assert_eq!((readings.on, readings.zero_lost), ([false; 2], true));
}

#[test]
fn robstrides_are_sent_to_from_the_identifier_that_waits_longest() {
    let (mut joints, tape) = pair::<RobStride>(|id| MitDrive { id, ..robstride() });
    let on = |tape: &Tape| {
        for id in 1..=2 {
            tape.say(extended(0x0280_00fd | id << 8), [0x80, 0, 0x80, 0, 0x80, 0, 1, 0]);
        }
    };
    on(&tape);
    joints.measure();
    joints.drive(&[0.0; 2], None);
    for torques in [[1000.0, 2000.0], [2000.0, 1000.0]] {
        on(&tape);
        joints.measure();
        tape.sent();
        joints.drive(&torques, None);
        let sent: Vec<u32> = tape
            .sent()
            .iter()
            .map(|packet| match packet.id {
                Id::Extended(id) => id.as_raw(),
                Id::Standard(id) => panic!("{id:?}"),
            })
            .collect();
        assert!(sent.len() == 2 && sent[0] > sent[1], "{sent:x?}");
    }
}
