//! Tests of the schedule on two buses, with replies that are missing, late, doubled, too short or from other devices.

use super::{drive, model_ranges};
use actuator_model::bus::{Bus, Fate};
use actuator_model::frame::Frame;
use actuator_model::mit::{Actuator, Shaft};
use dynamics_core::control::{Sensed, Spring};
use dynamics_core::drive::{Gearing, MiniCheetah, MitDrive};
use dynamics_core::safety::SafeAction;
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use joint_io::can::CanJoints;
use joint_io::can_bus::{CanBus, NoBus};
use joint_io::{JointIo, MISSING_MAX, NoPin};
use proptest::prelude::*;
use session::readings::{JointFaults, Readings};
use std::cell::RefCell;
use std::rc::Rc;

/// The model's bus with the trait that the firmware uses; it counts receptions.
#[derive(Clone)]
struct Mock {
    bus: Rc<RefCell<Bus>>,
    polls: Rc<RefCell<u32>>,
    /// True if every reception is an error.
    broken: Rc<RefCell<bool>>,
}

impl Mock {
    fn new(ids: &[u16]) -> Self {
        let actuators = ids.iter().map(|&id| Actuator::new(id, model_ranges())).collect();
        Self { bus: Rc::new(RefCell::new(Bus::new(actuators))), polls: Rc::default(), broken: Rc::default() }
    }
}

impl Can for Mock {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        *self.polls.borrow_mut() += 1;
        self.bus.borrow_mut().transmit(frame)
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        *self.polls.borrow_mut() += 1;
        if *self.broken.borrow() {
            return Err(nb::Error::Other(ErrorKind::Overrun));
        }
        self.bus.borrow_mut().receive().ok_or(nb::Error::WouldBlock)
    }
}

impl CanBus for Mock {
    fn is_off(&mut self) -> bool {
        self.bus.borrow().off
    }
    fn abandon(&mut self) {
        self.bus.borrow_mut().abandon();
    }
}

const PERIOD: f64 = 0.001;
const HOLD: [f32; 6] = [0.0; 6];

/// Largest number of ticks until undisturbed drives are on.
const ON_MAX: usize = 4;

struct Bench {
    joints: CanJoints<MiniCheetah, Mock, Mock, NoBus, NoPin, 6>,
    buses: [Mock; 2],
}

/// Three actuators on each bus.
fn drives() -> [MitDrive; 6] {
    std::array::from_fn(|i| drive((i / 3) as u8, i as u8 + 1))
}

impl Bench {
    fn new() -> Self {
        Self::with(drives())
    }

    fn with(drives: [MitDrive; 6]) -> Self {
        let buses = [Mock::new(&[1, 2, 3]), Mock::new(&[4, 5, 6])];
        let [first, second] = buses.clone();
        let mut bench = Self { joints: CanJoints::new((first, second, NoBus), NoPin, drives), buses };
        // A first poll, as a board makes when it starts.
        bench.joints.safe(SafeAction::Off);
        bench.pass();
        bench
    }

    /// Creates a bench with drives that are on.
    fn running() -> Self {
        Self::new().on()
    }

    /// Enables the drives until they have confirmed that they are on; they give no torque.
    fn on(mut self) -> Self {
        for _ in 0..ON_MAX {
            if self.enable().on == [true; 6] {
                self.drive(&HOLD);
                return self;
            }
        }
        panic!("not on after {ON_MAX} ticks");
    }

    fn enable(&mut self) -> Readings<6> {
        let readings = self.joints.measure().unwrap();
        self.joints.enable(SafeAction::Off);
        self.pass();
        readings
    }

    fn pass(&mut self) {
        self.buses.iter().for_each(|mock| mock.bus.borrow_mut().step(PERIOD));
    }

    fn drive(&mut self, torque: &[f32; 6]) -> Readings<6> {
        let readings = self.joints.measure().unwrap();
        self.joints.drive(torque, None);
        self.pass();
        readings
    }

    fn safe(&mut self, action: SafeAction) -> Readings<6> {
        let readings = self.joints.measure().unwrap();
        self.joints.safe(action);
        self.pass();
        readings
    }

    fn actuator<T>(&self, joint: usize, look: impl FnOnce(&mut Actuator) -> T) -> T {
        look(&mut self.buses[joint / 3].bus.borrow_mut().actuators[joint % 3])
    }

    fn fate(&self, joint: usize, fate: Fate) {
        self.buses[joint / 3].bus.borrow_mut().fates.push((joint as u16 + 1, fate));
    }
}

#[test]
fn every_actuator_gets_one_command_a_tick_and_answers_before_the_next() {
    let mut bench = Bench::running();
    for tick in 0..100 {
        let readings = bench.drive(&[0.1; 6]);
        assert_eq!(readings.age_ticks, [0; 6], "tick {tick}");
        assert_eq!(readings.faults, [JointFaults::NONE; 6], "tick {tick}");
    }
    for mock in &bench.buses {
        // Three actuators each in the poll, three ticks of enabling, the first torque and a hundred more; lowest identifier first on the wire.
        let bus = mock.bus.borrow();
        assert_eq!(bus.sent.len(), 3 * 105);
        for tick in bus.sent.chunks(3) {
            assert!(tick.is_sorted_by_key(|frame| frame.id), "{tick:?}");
        }
    }
}

#[test]
fn a_torque_arrives_through_gear_and_direction_and_moves_the_joint() {
    let mut drives = drives();
    drives[1].gearing = Gearing { ratio: -4.0, per_ratio: -0.25, zero: 1.0 };
    let mut bench = Bench::with(drives);
    bench.drive(&HOLD);
    let mut torque = HOLD;
    torque[1] = 8.0;
    for _ in 0..21 {
        bench.drive(&torque);
    }
    assert!((bench.actuator(1, |a| a.electronics.told().torque) + 2.0).abs() < 0.5 * 36.0 / 4095.0 + 1e-6);
    let (position, velocity) = bench.actuator(1, |a| (a.shaft.position, a.shaft.velocity));
    let readings = bench.joints.measure().unwrap();
    let Sensed::State { q, qd } = readings.sensed else { panic!("actuators report a state") };
    // The position is that of one period before, when the command arrived.
    let measured = (position - velocity * PERIOD - 1.0) / -4.0;
    assert!((f64::from(q[1]) - measured).abs() < 2e-4, "{} and {measured}", q[1]);
    assert!(qd[1] > 0.5, "a positive torque moves the joint up: {}", qd[1]);
    assert!((readings.torque[1] - 8.0).abs() < 0.08, "{}", readings.torque[1]);
}

#[test]
fn a_spring_is_renewed_by_the_drive_about_the_measurement_that_its_torque_follows_from() {
    let mut drives = drives();
    drives[1].gearing = Gearing { ratio: -2.0, per_ratio: -0.5, zero: 1.0 };
    let mut bench = Bench::with(drives);
    bench.drive(&HOLD);
    let place = |a: &mut Actuator| (a.shaft.position, a.shaft.velocity) = (0.4, -0.6);
    bench.actuator(1, place);
    bench.drive(&HOLD);
    // The joint moves on after the measurement.
    let springs = [Spring { stiffness: 80.0, damping: 2.0 }; 6];
    bench.actuator(1, place);
    bench.joints.measure().unwrap();
    let mut torque = HOLD;
    torque[1] = 6.0;
    bench.joints.drive(&torque, Some(&springs));
    bench.pass();
    let told = bench.actuator(1, |a| a.electronics.told());
    // At the shaft a stiffness is divided by the square of the ratio, a torque by the ratio.
    let near = |found: f64, expected: f64, step: f64| (found - expected).abs() <= step;
    assert!(near(told.kp, 20.0, 500.0 / 4095.0) && near(told.kd, 0.5, 5.0 / 4095.0), "{told:?}");
    assert!(near(told.torque, -3.0, 36.0 / 4095.0), "{told:?}");
    assert!(near(told.position, 0.4, 25.0 / 65535.0) && near(told.velocity, -0.6, 130.0 / 4095.0), "{told:?}");
    // At the measured state the drive gives the torque; elsewhere also that of spring and damper.
    let given =
        |bench: &Bench, position, velocity| bench.actuator(1, |a| a.electronics.drive(&Shaft { position, velocity }));
    let here = given(&bench, told.position, told.velocity);
    assert!(near(here, told.torque, 1e-9), "{here}");
    let there = given(&bench, told.position + 0.05, told.velocity + 0.2);
    assert!(near(there, told.torque - 0.05 * told.kp - 0.2 * told.kd, 1e-9), "{there}");
    // Without a spring the gains are zero. A spring beyond the frame's range is limited, and never makes a special frame.
    bench.joints.drive(&torque, None);
    bench.pass();
    assert_eq!(bench.actuator(1, |a| (a.electronics.told().kp, a.electronics.told().kd)), (0.0, 0.0));
    let hard = [Spring { stiffness: 1e6, damping: 1e6 }; 6];
    bench.joints.drive(&torque, Some(&hard));
    bench.pass();
    let told = bench.actuator(1, |a| a.electronics.told());
    assert!(told.kp > 498.0 && told.kp < 500.0 && near(told.kd, 5.0, 1e-9), "{told:?}");
    // With a torque of NaN, no spring is sent either.
    bench.joints.drive(&[f32::NAN; 6], Some(&springs));
    bench.pass();
    assert_eq!(bench.actuator(1, |a| (a.electronics.told().kp, a.electronics.told().kd)), (0.0, 0.0));
}

#[test]
fn a_drive_that_is_off_is_switched_on_before_it_gives_torque() {
    let mut bench = Bench::new();
    bench.drive(&[3.0; 6]);
    assert!(bench.actuator(4, |a| a.electronics.is_enabled() && a.electronics.torque() == 0.0));
    // A fiftieth of the range shows that it is on.
    assert_eq!(bench.drive(&[3.0; 6]).on, [false; 6]);
    assert!(bench.actuator(4, |a| (a.electronics.torque() - 0.36).abs() < 0.01));
    assert_eq!(bench.drive(&[3.0; 6]).on, [true; 6]);
    assert!(bench.actuator(4, |a| a.electronics.torque() > 2.9));
}

#[test]
fn torque_that_a_spring_gives_counts_and_one_that_is_missing_is_found_in_a_stated_number_of_replies() {
    let mut bench = Bench::running();
    let springs = [Spring { stiffness: 80.0, damping: 2.0 }; 6];
    let push = |tick: usize| [if (tick / 10).is_multiple_of(2) { 2.0 } else { -2.0 }; 6];
    for tick in 0..300 {
        let readings = bench.joints.measure().unwrap();
        assert_eq!((readings.on, readings.faults), ([true; 6], [JointFaults::NONE; 6]), "{tick}");
        bench.joints.drive(&push(tick), Some(&springs));
        bench.pass();
    }
    bench.drive(&[2.0; 6]);
    // The drive switches itself off.
    bench.actuator(4, |a| a.receive(&joint_io::mit::EXIT));
    let mut weak = 0;
    loop {
        let readings = bench.joints.measure().unwrap();
        if !readings.on[4] {
            assert_eq!(readings.on, [true, true, true, true, false, true]);
            assert!(readings.faults[4] != JointFaults::NONE && readings.zero_lost);
            break;
        }
        bench.joints.drive(&[2.0; 6], Some(&springs));
        bench.pass();
        weak += 1;
        assert!(weak < 20);
    }
    assert_eq!(weak, usize::from(joint_io::can::WEAK_MAX) + 1);
    // The fault is reported until the safe action.
    bench.joints.safe(SafeAction::Off);
    bench.pass();
    assert_eq!(bench.joints.measure().unwrap().faults, [JointFaults::NONE; 6]);
}

#[test]
fn a_lost_reply_ages_its_joint_alone() {
    let mut bench = Bench::running();
    bench.fate(2, Fate::Lost);
    bench.drive(&HOLD);
    let readings = bench.drive(&HOLD);
    assert_eq!(readings.age_ticks, [0, 0, 1, 0, 0, 0]);
    assert_eq!(readings.faults, [JointFaults::NONE; 6]);
    for _ in 0..5 {
        assert_eq!(bench.drive(&HOLD).age_ticks, [0; 6]);
    }
}

#[test]
fn a_joint_that_stays_silent_is_at_fault_after_the_stated_number_of_ticks() {
    let mut bench = Bench::running();
    for _ in 0..10 {
        bench.fate(5, Fate::Lost);
    }
    bench.drive(&HOLD);
    for silent in 1..=10 {
        let readings = bench.drive(&HOLD);
        assert_eq!(readings.age_ticks[5], silent);
        assert_eq!(readings.faults[5].contains(JointFaults::MISSING), silent > MISSING_MAX, "{silent}");
        assert_eq!(readings.age_ticks.into_iter().max(), Some(silent));
    }
}

#[test]
fn a_joint_that_never_answered_is_at_fault_from_the_first_tick() {
    let mut bench = Bench::new();
    let mut silent = drives();
    silent[0].id = 9;
    let [first, second] = bench.buses.clone();
    bench.joints = CanJoints::new((first, second, NoBus), NoPin, silent);
    let readings = bench.safe(SafeAction::Off);
    assert!(readings.faults.iter().all(|faults| faults.contains(JointFaults::MISSING)), "nothing was asked yet");
    let readings = bench.safe(SafeAction::Off);
    assert_eq!(readings.faults[1], JointFaults::NONE);
    assert!(readings.faults[0].contains(JointFaults::MISSING));
    assert_eq!(readings.age_ticks[0], u32::MAX);
}

#[test]
fn a_late_reply_is_missing_once_and_then_accepted() {
    let mut bench = Bench::running();
    bench.fate(3, Fate::Late);
    bench.drive(&HOLD);
    assert_eq!(bench.drive(&HOLD).age_ticks[3], 1);
    assert_eq!(bench.drive(&HOLD).age_ticks[3], 0);
}

#[test]
fn a_second_reply_to_one_command_is_ignored() {
    let mut bench = Bench::running();
    bench.drive(&HOLD);
    // After the joint's own reply, one with the position at the low end of its range.
    bench.buses[0].bus.borrow_mut().inject(Frame::standard(0, vec![2, 0, 0, 0, 0, 0]));
    let readings = bench.drive(&HOLD);
    assert_eq!((readings.age_ticks, readings.faults), ([0; 6], [JointFaults::NONE; 6]));
    bench.fate(1, Fate::Twice);
    bench.drive(&HOLD);
    assert_eq!(bench.drive(&HOLD).age_ticks, [0; 6]);
    assert_eq!(bench.drive(&HOLD).age_ticks, [0; 6]);
}

#[test]
fn strangers_and_cut_frames_are_ignored() {
    let mut bench = Bench::running();
    let before = bench.drive(&HOLD);
    {
        let mut bus = bench.buses[0].bus.borrow_mut();
        bus.inject(Frame::standard(0x123, vec![1, 0, 0, 0, 0, 0]));
        bus.inject(Frame::standard(0, vec![1, 0, 0, 0, 0]));
        bus.inject(Frame::standard(0, vec![77, 0, 0, 0, 0, 0]));
        // An actuator of the other bus.
        bus.inject(Frame::standard(0, vec![5, 0, 0, 0, 0, 0]));
    }
    let readings = bench.drive(&HOLD);
    assert_eq!(readings.sensed, before.sensed);
    assert_eq!(readings.faults, [JointFaults::NONE; 6]);
}

#[test]
fn an_actuator_with_an_error_of_its_own_is_a_fault() {
    let mut all = drives();
    all.iter_mut().for_each(|drive| drive.reply_bytes = 8);
    let mut bench = Bench::with(all);
    (0..6).for_each(|joint| bench.actuator(joint, |a| a.electronics.reply_bytes = 8));
    bench.drive(&HOLD);
    bench.drive(&HOLD);
    bench.actuator(2, |a| a.electronics.error = 4);
    bench.drive(&HOLD);
    let readings = bench.drive(&HOLD);
    assert_eq!(
        readings.faults.map(|faults| faults.contains(JointFaults::DRIVE)),
        [false, false, true, false, false, false]
    );
}

#[test]
fn the_hottest_actuator_is_the_temperature_and_none_without_one() {
    let bench = Bench::running();
    assert_eq!(bench.joints.temperature(), None, "replies of six bytes");
    let mut all = drives();
    all.iter_mut().for_each(|drive| (drive.reply_bytes, drive.temperature_offset) = (7, Some(-40.0)));
    let mut bench = Bench::with(all);
    (0..6).for_each(|joint| bench.actuator(joint, |a| a.electronics.reply_bytes = 7));
    assert_eq!(bench.joints.temperature(), None, "no reply yet");
    bench.actuator(4, |a| a.electronics.temperature = 130);
    bench.drive(&HOLD);
    bench.drive(&HOLD);
    assert_eq!(bench.joints.temperature(), Some(90.0));
    bench.actuator(4, |a| a.electronics.temperature = 65);
    bench.actuator(0, |a| a.electronics.temperature = 0);
    bench.drive(&HOLD);
    bench.drive(&HOLD);
    assert_eq!(bench.joints.temperature(), Some(25.0));
}

#[test]
fn a_temperature_that_is_nan_hides_behind_no_other() {
    use joint_io::higher;
    assert_eq!(higher(None, None), None);
    assert_eq!(higher(Some(1.0), None), Some(1.0));
    assert_eq!(higher(Some(1.0), Some(2.0)), Some(2.0));
    assert!(higher(Some(f32::NAN), Some(2.0)).is_some_and(f32::is_nan));
    assert!(higher(Some(2.0), Some(f32::NAN)).is_some_and(f32::is_nan));
}

#[test]
fn a_position_at_the_end_of_its_range_is_a_fault_while_it_lasts() {
    let mut bench = Bench::running();
    bench.actuator(0, |a| a.shaft.position = 12.6);
    bench.drive(&HOLD);
    assert_eq!(bench.drive(&HOLD).faults[0], JointFaults::RANGE);
    bench.actuator(0, |a| a.shaft.position = 1.0);
    bench.drive(&HOLD);
    assert_eq!(bench.drive(&HOLD).faults[0], JointFaults::NONE);
}

#[test]
fn a_torque_that_is_no_number_goes_out_as_none_and_is_a_fault() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut bench = Bench::running();
        bench.drive(&[1.0; 6]);
        bench.drive(&[1.0, bad, 1.0, 1.0, 1.0, 1.0]);
        assert!(bench.actuator(1, |a| a.electronics.told().torque).abs() < 0.0045);
        assert!(bench.actuator(0, |a| a.electronics.told().torque) > 0.99);
        let readings = bench.drive(&HOLD);
        assert_eq!(readings.faults[1], JointFaults::NON_FINITE);
        assert_eq!(bench.drive(&HOLD).faults[1], JointFaults::NONE);
    }
}

#[test]
fn safe_actions_take_effect_within_one_tick() {
    for action in [SafeAction::Brake, SafeAction::Off] {
        let mut bench = Bench::running();
        bench.drive(&[5.0; 6]);
        assert!(bench.actuator(3, |a| a.electronics.torque() > 4.9));
        bench.safe(action);
        assert!(
            (0..6).all(|joint| bench.actuator(joint, |a| !a.electronics.is_enabled() && a.electronics.torque() == 0.0)),
            "{action:?}"
        );
        // Drives that are off still report their position.
        bench.safe(action);
        assert_eq!(bench.safe(action).age_ticks, [0; 6]);
    }
}

#[test]
fn a_damped_stop_slows_a_moving_joint_and_wakes_none_that_was_off() {
    let mut bench = Bench::running();
    bench.drive(&HOLD);
    bench.actuator(0, |a| a.shaft.velocity = 10.0);
    for _ in 0..30 {
        bench.safe(SafeAction::DampedStop);
    }
    // exp(-30 ms * 1 N m s/rad / 0.01 kg m^2) = 0.05, and half a step of velocity and torque.
    let velocity = bench.actuator(0, |a| a.shaft.velocity);
    assert!((0.2..0.7).contains(&velocity), "{velocity}");
    assert_eq!(bench.actuator(0, |a| a.electronics.told().kp), 0.0);
    let mut idle = Bench::new();
    idle.safe(SafeAction::DampedStop);
    assert!((0..6).all(|joint| idle.actuator(joint, |a| !a.electronics.is_enabled())));
}

#[test]
fn a_full_transmitter_is_asked_a_bounded_number_of_times_and_an_old_torque_never_goes_out() {
    let mut bench = Bench::running();
    bench.drive(&[1.0; 6]);
    bench.buses[0].bus.borrow_mut().stuck = true;
    bench.drive(&[2.0; 6]);
    *bench.buses[0].polls.borrow_mut() = 0;
    for _ in 0..8 {
        bench.drive(&[3.0; 6]);
    }
    let polls = *bench.buses[0].polls.borrow();
    assert!(polls <= 8 * (3 * 16 + 17), "{polls}");
    let readings = bench.drive(&[3.0; 6]);
    assert!(readings.faults[..3].iter().all(|faults| faults.contains(JointFaults::MISSING)));
    assert_eq!(readings.faults[3..], [JointFaults::NONE; 3]);
    bench.buses[0].bus.borrow_mut().stuck = false;
    bench.drive(&[4.0; 6]);
    // The commands of 2 and 3 N m were dropped, not sent late.
    let sent = bench.buses[0].bus.borrow().sent.len();
    bench.drive(&[4.0; 6]);
    assert_eq!(bench.buses[0].bus.borrow().sent.len(), sent + 3);
    // The drives were silent, and must confirm again that they are on.
    for _ in 0..ON_MAX {
        bench.drive(&[4.0; 6]);
    }
    assert!(bench.actuator(0, |a| a.electronics.told().torque) > 3.9);
}

#[test]
fn a_bus_that_is_off_is_a_fault_of_its_joints_at_once_and_ends_with_it() {
    let mut bench = Bench::running();
    bench.drive(&HOLD);
    bench.buses[1].bus.borrow_mut().off = true;
    let readings = bench.drive(&HOLD);
    assert_eq!(
        readings.faults.map(|faults| faults.contains(JointFaults::BUS)),
        [false, false, false, true, true, true]
    );
    // They do not count as on until they have confirmed it again.
    assert_eq!(readings.on, [true, true, true, false, false, false]);
    bench.buses[1].bus.borrow_mut().off = false;
    for _ in 0..3 {
        bench.drive(&HOLD);
    }
    assert_eq!(bench.drive(&HOLD).faults, [JointFaults::NONE; 6]);
}

#[test]
fn a_receiver_in_error_is_given_up_in_bounded_time() {
    let mut bench = Bench::running();
    *bench.buses[0].broken.borrow_mut() = true;
    *bench.buses[0].polls.borrow_mut() = 0;
    bench.drive(&HOLD);
    assert_eq!(*bench.buses[0].polls.borrow(), 16 + 3);
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![
        4 => Just(Fate::Arrives), 1 => Just(Fate::Lost), 1 => Just(Fate::Late), 1 => Just(Fate::Twice), 1 => Just(Fate::Short)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever happens to replies, readings are finite, and a joint is at fault exactly if its reading is too old.
    #[test]
    fn any_sequence_of_fates_gives_finite_readings_and_faults_of_old_ones(
        fates in proptest::collection::vec((0..6_usize, fate()), 0..120),
        torques in proptest::collection::vec(any::<[u32; 6]>(), 40),
    ) {
        let mut bench = Bench::running();
        for (joint, fate) in fates {
            bench.fate(joint, fate);
        }
        for bits in torques {
            let readings = bench.drive(&bits.map(f32::from_bits));
            let Sensed::State { q, qd } = readings.sensed else { panic!("actuators report a state") };
            prop_assert!(q.iter().chain(&qd).chain(&readings.torque).all(|x| x.is_finite()));
            for joint in 0..6 {
                prop_assert_eq!(readings.faults[joint].contains(JointFaults::MISSING), readings.age_ticks[joint] > MISSING_MAX);
            }
            prop_assert!((0..6).all(|joint| bench.actuator(joint, |a| a.electronics.told().torque.is_finite())));
        }
    }
}
