//! Tests with six actuators on one bus, on a controller that holds three frames to send and three received ones.

use super::{drive, model_ranges};
use actuator_model::bus::Bus;
use actuator_model::frame::Frame;
use actuator_model::mit::Actuator;
use dynamics_core::drive::{DataRate, MiniCheetah, MitDrive};
use dynamics_core::safety::SafeAction;
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use joint_io::can::CanJoints;
use joint_io::can_bus::{CanBus, NoBus};
use joint_io::queued::{OUT, Queued};
use joint_io::{JointIo, NoPin};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// Number of frames that the controller holds in each direction.
const ROOM: usize = 3;

/// Number of ticks until the drives are on.
const ENABLING: u32 = 3;

/// A controller and the bus at the other end of its wire.
struct Controller {
    bus: Bus,
    out: Vec<Frame>,
    received: VecDeque<Frame>,
    lost: bool,
    interrupts: u32,
}

#[derive(Clone)]
struct Fdcan(Rc<RefCell<Controller>>);

impl Fdcan {
    /// Exchanges one command, the one with the lowest identifier, and its reply. Returns false if there was none.
    fn exchange(&self) -> bool {
        let mut it = self.0.borrow_mut();
        let Some(next) = (0..it.out.len()).min_by_key(|&i| it.out[i].id) else { return false };
        let frame = it.out.remove(next);
        assert!(it.bus.send(frame));
        it.bus.serve();
        while let Some(reply) = it.bus.receive() {
            if it.received.len() < ROOM {
                it.received.push_back(reply);
            } else {
                it.lost = true;
            }
        }
        true
    }
}

impl Can for Fdcan {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        let mut it = self.0.borrow_mut();
        if it.out.len() >= ROOM {
            return Err(nb::Error::WouldBlock);
        }
        it.out.push(frame.clone());
        Ok(None)
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        let mut it = self.0.borrow_mut();
        if std::mem::take(&mut it.lost) {
            return Err(nb::Error::Other(ErrorKind::Overrun));
        }
        it.received.pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl CanBus for Fdcan {
    fn is_off(&mut self) -> bool {
        false
    }

    fn abandon(&mut self) {
        self.0.borrow_mut().out.clear();
    }

    fn interrupt(&mut self) {
        self.0.borrow_mut().interrupts += 1;
    }
}

struct Bench {
    joints: CanJoints<MiniCheetah, Queued<Fdcan>, NoBus, NoBus, NoPin, 6>,
    wire: Fdcan,
}

impl Bench {
    /// Creates a bench with six drives that are on.
    fn new() -> Self {
        let actuators = (1..=6).map(|id| Actuator::new(id, model_ranges())).collect();
        let (out, received) = (Vec::new(), VecDeque::new());
        let controller = Controller { bus: Bus::new(actuators), out, received, lost: false, interrupts: 0 };
        let wire = Fdcan(Rc::new(RefCell::new(controller)));
        let drives: [MitDrive; 6] =
            std::array::from_fn(|i| MitDrive { data_rate: Some(DataRate::Mbit5), ..drive(0, i as u8 + 1) });
        let joints = CanJoints::new((Queued::new(wire.clone()), NoBus, NoBus), NoPin, drives);
        let mut bench = Self { joints, wire };
        bench.joints.safe(SafeAction::Off);
        bench.pass(true);
        // The drives are enabled and probed, and confirm that they are on.
        for _ in 0..ENABLING {
            bench.tick(0.0, true);
        }
        bench
    }

    /// Exchanges all frames of a tick, with or without the controller's interrupts.
    fn pass(&mut self, interrupts: bool) {
        while self.wire.exchange() {
            if interrupts {
                self.joints.interrupt();
            }
        }
    }

    fn tick(&mut self, torque: f32, interrupts: bool) -> [u32; 6] {
        let readings = self.joints.measure().unwrap();
        self.joints.drive(&[torque; 6], None);
        self.pass(interrupts);
        readings.age_ticks
    }

    fn told(&self) -> Vec<f64> {
        self.wire.0.borrow().bus.actuators.iter().map(|actuator| actuator.electronics.told().torque).collect()
    }
}

#[test]
fn six_actuators_on_one_bus_all_answer_in_every_tick() {
    let mut bench = Bench::new();
    for tick in 0..100 {
        assert_eq!(bench.tick(0.1 * tick as f32, true), [0; 6], "{tick}");
        let near = |told: &f64| (told - 0.1 * f64::from(tick)).abs() < 0.01;
        assert!(bench.told().iter().all(near), "{tick}: {:?}", bench.told());
    }
    assert_eq!(bench.wire.0.borrow().interrupts, 6 * (101 + ENABLING));
}

#[test]
fn without_the_interrupts_half_of_them_are_not_heard() {
    let mut bench = Bench::new();
    let ages: Vec<_> = (0..3).map(|_| bench.tick(1.0, false)).collect();
    let [.., last] = ages[..] else { panic!("three ticks") };
    assert!(last[..3].iter().all(|&age| age > 0) && ages.iter().all(|ages| ages[3..] == [0; 3]), "{ages:?}");
}

#[test]
fn a_torque_that_still_waits_is_never_sent_after_the_next_ticks() {
    let mut bench = Bench::new();
    bench.joints.measure();
    bench.joints.drive(&[5.0; 6], None);
    // One frame is sent before the next tick: five wait, three of them in the controller.
    assert!(bench.wire.exchange());
    bench.joints.interrupt();
    bench.tick(-5.0, true);
    assert!(bench.told().iter().all(|told| (told + 5.0).abs() < 0.01), "{:?}", bench.told());
    let sent = bench.wire.0.borrow().bus.sent.len();
    bench.tick(-5.0, true);
    assert_eq!(bench.wire.0.borrow().bus.sent.len(), sent + 6);
}

#[test]
fn a_reply_that_the_controller_loses_is_an_error_once() {
    let mut bench = Bench::new();
    bench.joints.measure();
    bench.joints.drive(&[0.0; 6], None);
    // Foreign frames fill the receiver.
    let stranger = Frame::standard(0x123, vec![0; 8]);
    bench.wire.0.borrow_mut().received.extend([stranger.clone(), stranger.clone(), stranger]);
    assert!(bench.wire.exchange());
    bench.pass(true);
    let (bus, ..) = bench.joints.buses();
    let received: Vec<_> = core::iter::from_fn(|| match bus.receive() {
        Err(nb::Error::WouldBlock) => None,
        result => Some(result),
    })
    .collect();
    assert!(matches!(received[0], Err(nb::Error::Other(_))), "{received:?}");
    assert!(received[1..].iter().all(Result::is_ok), "{received:?}");
}

#[test]
fn a_queue_that_is_full_refuses() {
    let mut bench = Bench::new();
    let (first, ..) = bench.joints.buses();
    let frame = Frame::standard(1, vec![0; 8]);
    let taken = (0..20).take_while(|_| first.transmit(&frame).is_ok()).count();
    assert_eq!(taken, ROOM + OUT);
    first.abandon();
    assert!(first.transmit(&frame).is_ok());
    assert_eq!(bench.wire.0.borrow().out.len(), 1);
}

#[test]
fn a_bus_that_is_not_there_takes_nothing() {
    let on_third = std::array::from_fn(|i| drive(2, i as u8 + 1));
    let mut joints: CanJoints<MiniCheetah, NoBus, NoBus, NoBus, NoPin, 2> =
        CanJoints::new((NoBus, NoBus, NoBus), NoPin, on_third);
    joints.measure();
    joints.drive(&[0.0; 2], None);
    joints.interrupt();
    assert_eq!(joints.measure().unwrap().age_ticks, [u32::MAX; 2]);
}

/// A controller that holds one frame and displaces it for the next one, and what it has received.
struct Pushing(Option<Frame>, VecDeque<Frame>);

impl Can for Pushing {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        Ok(self.0.replace(frame.clone()))
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        self.1.pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl CanBus for Pushing {
    fn is_off(&mut self) -> bool {
        false
    }

    fn abandon(&mut self) {}
}

/// A reply with a position in the middle of its range.
fn reply(id: u8) -> Frame {
    Frame::standard(0, vec![id, 0x80, 0, 0x80, 0x08, 0])
}

/// To a frame that was not sent no reply is outstanding, so one that arrives is ignored.
#[test]
fn a_frame_that_was_pushed_out_of_its_mailbox_or_dropped_from_the_queue_counts_as_unsent() {
    let three: [MitDrive; 3] = std::array::from_fn(|i| drive(0, i as u8 + 1));
    let mut joints: CanJoints<MiniCheetah, Pushing, NoBus, NoBus, NoPin, 3> =
        CanJoints::new((Pushing(None, VecDeque::new()), NoBus, NoBus), NoPin, three);
    joints.safe(SafeAction::Off);
    joints.buses().0.1.extend((1..=3).map(reply));
    assert_eq!(joints.measure().unwrap().age_ticks, [0, u32::MAX, u32::MAX]);
    // The same if the queue passes frames to the controller; and frames that the next tick drops.
    let mut bench = Bench::new();
    bench.joints.measure();
    bench.joints.drive(&[1.0; 6], None);
    bench.joints.drive(&[2.0; 6], None);
    bench.pass(true);
    bench.joints.measure();
    // Three were in the controller, which does not report its dropped frames.
    bench.wire.0.borrow_mut().received.extend((1..=6).map(reply));
    assert_eq!(bench.joints.measure().unwrap().age_ticks, [1, 1, 1, 0, 0, 0]);
}
