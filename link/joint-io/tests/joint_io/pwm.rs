//! Tests of the joints with H-bridges: duty from torque, bridges and encoders.

use super::encoder::Spi;
use dynamics_core::control::Sensed;
use dynamics_core::drive::{Gearing, PwmDrive};
use dynamics_core::safety::SafeAction;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use joint_io::JointIo;
use joint_io::pwm::{Channel, CurrentSensor, Drive, PwmJoints, duty_steps};
use proptest::prelude::*;
use session::readings::JointFaults;
use std::cell::RefCell;
use std::rc::Rc;

fn drive() -> PwmDrive {
    PwmDrive {
        channel: 0,
        gearing: Gearing { ratio: 50.0, per_ratio: 0.02, zero: 0.0 },
        encoder_zero: 5000,
        encoder_reversed: false,
        jump_max: 500,
        speed_per_count: 19.174_76,
        torque_constant: 0.045,
        per_torque_constant: 1.0 / 0.045,
        resistance: 0.6,
        per_resistance: 1.0 / 0.6,
        supply: 24.0,
        per_supply: 1.0 / 24.0,
        current_max: 5.0,
    }
}

/// Events on the lines of a joint, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    Duty(u16),
    Direction(bool),
    Enable(bool),
    Brake(bool),
}

#[derive(Clone, Default)]
struct Log {
    events: Rc<RefCell<Vec<Event>>>,
    refuse: Rc<RefCell<bool>>,
}

impl Log {
    fn push(&self, event: Event) -> Result<(), Refused> {
        if *self.refuse.borrow() {
            return Err(Refused);
        }
        self.events.borrow_mut().push(event);
        Ok(())
    }
    fn take(&self) -> Vec<Event> {
        std::mem::take(&mut self.events.borrow_mut())
    }
}

#[derive(Debug)]
struct Refused;

impl digital::Error for Refused {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

impl pwm::Error for Refused {
    fn kind(&self) -> pwm::ErrorKind {
        pwm::ErrorKind::Other
    }
}

struct Line(Log, fn(bool) -> Event);

impl digital::ErrorType for Line {
    type Error = Refused;
}

impl OutputPin for Line {
    fn set_low(&mut self) -> Result<(), Refused> {
        self.0.push(self.1(false))
    }
    fn set_high(&mut self) -> Result<(), Refused> {
        self.0.push(self.1(true))
    }
}

struct Timer(Log);

impl pwm::ErrorType for Timer {
    type Error = Refused;
}

impl SetDutyCycle for Timer {
    fn max_duty_cycle(&self) -> u16 {
        4200
    }
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Refused> {
        assert!(duty <= 4200, "beyond the timer's end");
        self.0.push(Event::Duty(duty))
    }
}

#[derive(Clone, Default)]
struct Shunt(Rc<RefCell<Option<f32>>>);

impl CurrentSensor for Shunt {
    fn current(&mut self) -> Option<f32> {
        *self.0.borrow()
    }
}

struct Bench {
    joints: PwmJoints<Timer, Line, Line, Spi, Shunt, Line, 1>,
    log: Log,
    spi: Spi,
    shunt: Shunt,
}

impl Bench {
    fn new() -> Self {
        Self::with(drive())
    }

    fn with(drive: PwmDrive) -> Self {
        let (log, spi, shunt) = (Log::default(), Spi::default(), Shunt::default());
        spi.encoder.borrow_mut().angle = u32::from(drive.encoder_zero);
        let channel = Channel {
            pwm: Timer(log.clone()),
            direction: Line(log.clone(), Event::Direction),
            enable: Line(log.clone(), Event::Enable),
            encoder: spi.clone(),
            sensor: shunt.clone(),
        };
        let joints = PwmJoints::new([channel], Line(log.clone(), Event::Brake), [drive]);
        Self { joints, log, spi, shunt }
    }

    /// Creates a bench with an encoder that is reliable from the first tick on.
    fn ready() -> Self {
        let mut bench = Self::new();
        assert_eq!(bench.counts().1, JointFaults::NONE);
        bench.log.take();
        bench
    }

    fn counts(&mut self) -> (i32, JointFaults) {
        let readings = self.joints.measure().unwrap();
        let Sensed::Counts([counts]) = readings.sensed else { panic!("encoders count") };
        (counts, readings.faults[0])
    }
}

#[test]
fn duty_is_resistance_and_back_emf_over_supply() {
    // 1.8 N m / 50 / 0.045 N m/A = 0.8 A; 0.6 ohm times 0.8 A plus 0.045 V s/rad times 100 rad/s are 4.98 V of 24 V.
    let given = Drive::torque(1.8, 100.0, &drive()).unwrap();
    assert!((given.current - 0.8).abs() < 1e-5, "{given:?}");
    assert!((given.duty - 4.98 / 24.0).abs() < 1e-6, "{given:?}");
    assert!(!given.saturated);
}

#[test]
fn duty_and_current_stop_at_their_limits() {
    let held = Drive::torque(1000.0, 0.0, &drive()).unwrap();
    assert!(held.saturated && (held.current - 5.0).abs() < 1e-5 && (held.duty - 3.0 / 24.0).abs() < 1e-6, "{held:?}");
    // At 600 rad/s the back-EMF alone is 27 V: no duty drives the motor forwards, and the estimated current is negative.
    let fast = Drive::torque(1.8, 600.0, &drive()).unwrap();
    assert_eq!(fast.duty, 1.0);
    assert!(fast.saturated && fast.current < 0.0, "{fast:?}");
    let back = Drive::torque(-1000.0, -600.0, &drive()).unwrap();
    assert_eq!(back.duty, -1.0);
    assert_eq!(
        [duty_steps(1.0, 4200), duty_steps(2.0, 4200), duty_steps(-1.0, 4200), duty_steps(f32::NAN, 4200)],
        [4200, 4200, 0, 0]
    );
}

#[test]
fn nothing_moves_when_the_joints_are_made() {
    let bench = Bench::new();
    assert_eq!(bench.log.take(), [Event::Brake(false), Event::Duty(0), Event::Enable(false)]);
}

#[test]
fn the_motor_holds_before_the_brake_lets_go() {
    let mut bench = Bench::ready();
    bench.joints.drive(&[1.8], None);
    let steps = duty_steps(0.48 / 24.0, 4200);
    let wanted = [Event::Duty(0), Event::Direction(true), Event::Duty(steps), Event::Enable(true), Event::Brake(true)];
    assert_eq!(bench.log.take(), wanted);
}

/// During disarming the brake engages while the motor still holds.
#[test]
fn the_brake_engages_under_torque_before_the_motor_lets_go() {
    let mut bench = Bench::ready();
    bench.joints.drive(&[1.8], None);
    bench.log.take();
    bench.joints.preload(&[1.8], None);
    let steps = duty_steps(0.48 / 24.0, 4200);
    assert_eq!(bench.log.take(), [Event::Brake(false), Event::Duty(steps), Event::Enable(true)]);
    bench.joints.safe(SafeAction::Brake);
    assert_eq!(bench.log.take(), [Event::Brake(false), Event::Duty(0), Event::Enable(false)]);
}

#[test]
fn no_voltage_is_on_while_the_direction_changes() {
    let mut bench = Bench::ready();
    bench.joints.drive(&[1.8], None);
    bench.log.take();
    bench.joints.drive(&[-1.8], None);
    let events = bench.log.take();
    assert_eq!(events[..2], [Event::Duty(0), Event::Direction(false)]);
    bench.joints.drive(&[-1.9], None);
    assert!(!bench.log.take().iter().any(|event| matches!(event, Event::Direction(_) | Event::Duty(0))));
}

#[test]
fn safe_actions_brake_damp_or_let_go() {
    let stopped = |action| {
        let mut bench = Bench::ready();
        bench.joints.drive(&[1.8], None);
        bench.log.take();
        bench.joints.safe(action);
        bench.log.take()
    };
    assert_eq!(stopped(SafeAction::Brake), [Event::Brake(false), Event::Duty(0), Event::Enable(false)]);
    assert_eq!(stopped(SafeAction::DampedStop), [Event::Duty(0)]);
    assert_eq!(stopped(SafeAction::Off), [Event::Duty(0), Event::Enable(false)]);
}

#[test]
fn a_torque_that_is_no_number_drives_nothing_and_is_a_fault() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        let mut bench = Bench::ready();
        bench.joints.drive(&[bad], None);
        let finite = (bad * 0.02 / 0.045).is_finite();
        assert_eq!(bench.counts().1 == JointFaults::NON_FINITE, !finite, "{bad}");
        assert_eq!(bench.joints.given()[0] == Drive::NONE, !finite, "{bad}");
    }
}

#[test]
fn a_pin_that_refuses_is_a_fault_and_no_panic() {
    let mut bench = Bench::ready();
    *bench.log.refuse.borrow_mut() = true;
    bench.joints.drive(&[1.0], None);
    assert!(bench.counts().1.contains(JointFaults::OUTPUT));
    bench.joints.safe(SafeAction::Brake);
    assert!(bench.counts().1.contains(JointFaults::OUTPUT));
    *bench.log.refuse.borrow_mut() = false;
    bench.joints.safe(SafeAction::Brake);
    assert_eq!(bench.counts().1, JointFaults::NONE);
}

#[test]
fn counts_are_the_joints_own_through_zero_and_direction() {
    for (reversed, sign) in [(false, 1), (true, -1)] {
        let mut bench = Bench::with(PwmDrive { encoder_reversed: reversed, ..drive() });
        assert_eq!(bench.counts().0, 0);
        let mut angle: u32 = 5000;
        for step in 1..200 {
            angle = angle.wrapping_add(400);
            bench.spi.encoder.borrow_mut().angle = angle;
            let (counts, faults) = bench.counts();
            assert_eq!((counts, faults), (sign * 400 * step, JointFaults::NONE), "reversed: {reversed}");
        }
    }
}

#[test]
fn an_encoder_that_is_unplugged_is_a_fault_after_the_stated_ticks() {
    let mut bench = Bench::ready();
    *bench.spi.unplugged.borrow_mut() = true;
    let faults: Vec<bool> = (0..5).map(|_| bench.counts().1.contains(JointFaults::MISSING)).collect();
    assert_eq!(faults, [false, false, false, true, true]);
}

#[test]
fn a_weak_magnet_is_a_fault() {
    let mut bench = Bench::ready();
    bench.spi.encoder.borrow_mut().magnet_low = true;
    bench.counts();
    assert_eq!(bench.counts().1, JointFaults::SENSOR);
}

#[test]
fn the_current_is_measured_where_a_sensor_is_and_estimated_where_none_is() {
    let mut bench = Bench::ready();
    bench.joints.drive(&[1.8], None);
    assert!((bench.joints.measure().unwrap().torque[0] - 1.8).abs() < 1e-4);
    *bench.shunt.0.borrow_mut() = Some(0.5);
    assert!((bench.joints.measure().unwrap().torque[0] - 0.5 * 0.045 * 50.0).abs() < 1e-5);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn any_torque_and_speed_give_a_duty_within_the_supply_or_nothing(torque in any::<u32>(), speed in any::<u32>()) {
        let (torque, speed) = (f32::from_bits(torque), f32::from_bits(speed));
        if let Some(given) = Drive::torque(torque, speed, &drive()) {
            prop_assert!(given.duty.abs() <= 1.0, "{given:?}");
        }
    }

    /// Without saturation, the duty drives exactly the requested current.
    #[test]
    fn torque_to_duty_and_back_is_the_same_torque(torque in -10.0..10.0_f32, speed in -400.0..400.0_f32) {
        let d = drive();
        let given = Drive::torque(torque, speed, &d).unwrap();
        if !given.saturated {
            let back = d.gearing.joint_torque(given.current * d.torque_constant);
            // 24 V through 0.6 ohm, 0.045 N m/A and a gear of 50, in units of f32's rounding.
            prop_assert!((back - torque).abs() <= 6.0 * f32::EPSILON * 90.0, "{back} for {torque}");
        }
    }
}
