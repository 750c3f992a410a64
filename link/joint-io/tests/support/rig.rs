//! One joint behind one CAN bus, the session around it, and a pendulum under it: everything between a host's frames and a shaft.
use actuator_model::bus::{Bus, Frame as CanFrame};
use actuator_model::mit::{Actuator, Electronics, Language, Ranges, Shaft};
use dynamics_core::control::{Controller, ControllerConfig, Encoder, Fault, Gains, Guard, Law, Reference, TrackingObserver};
use dynamics_core::drive::{Gearing, MitDrive, MitRanges, Range};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{self, JointRules, Protected, Rules, SafeAction};
use dynamics_core::scene::Live;
use dynamics_core::trig::Polynomial;
use dynamics_core::{InertiaBounds, Limits, SinCos};
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use embedded_hal::digital::{ErrorType, OutputPin};
use joint_io::JointIo;
use joint_io::can::{CanBus, CanJoints, NoBus};
use joint_io::frames::Frames;
use link::codec::Received;
use link::{Cost, Frame, Hello, Pacing, Point, Request};
use session::meter::{Counter, Meter};
use session::readings::{Lines, Readings};
use session::{Drives, Reaction, Session, State};
use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::rc::Rc;

pub const H: f64 = 0.001;
pub const INERTIA: f64 = 0.55;
/// 2 kg at half a metre, level at q = 0.
pub const WEIGHT: f64 = 9.81;

#[derive(Clone, Default)]
pub struct Pendulum {
    /// Gravity is a live input.
    pub live: bool,
}
impl InverseDynamics<f32, 1> for Pendulum {
    fn inverse_dynamics(&self, t: &[SinCos<f32>; 1], _: &[f32; 1], _: &[f32; 1], qdd: &[f32; 1], live: &Live<f32, 1>) -> [f32; 1] {
        let weight = if self.live { -live.gravity.z } else { WEIGHT as f32 };
        [INERTIA as f32 * qdd[0] + weight * t[0].cos]
    }
}

#[derive(Clone, Default)]
pub struct Wire {
    pub bus: Rc<RefCell<Bus>>,
    /// Transmissions to refuse from now on (no room in the transmitter).
    pub refuse: Rc<Cell<u32>>,
    /// The transmitter takes frames and they never reach the wire: abandoned by the next tick.
    pub swallow: Rc<Cell<bool>>,
}
impl Can for Wire {
    type Frame = CanFrame;
    type Error = ErrorKind;
    fn transmit(&mut self, frame: &CanFrame) -> nb::Result<Option<CanFrame>, ErrorKind> {
        if self.refuse.get() > 0 {
            return Err(nb::Error::WouldBlock);
        }
        self.bus.borrow_mut().transmit(frame)
    }
    fn receive(&mut self) -> nb::Result<CanFrame, ErrorKind> {
        self.bus.borrow_mut().receive().ok_or(nb::Error::WouldBlock)
    }
}
impl CanBus for Wire {
    fn is_off(&mut self) -> bool {
        self.bus.borrow().off
    }
    fn abandon(&mut self) {
        self.bus.borrow_mut().abandon();
    }
}

#[derive(Clone, Default)]
pub struct Brake(pub Rc<Cell<bool>>);
impl ErrorType for Brake {
    type Error = Infallible;
}
impl OutputPin for Brake {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

pub struct None0;
impl Counter for None0 {
    fn now(&self) -> u32 {
        0
    }
    fn cost(c: u32) -> Cost {
        Cost::Instructions(c)
    }
    fn exercise(&self) {}
}

pub const OWN: Hello = Hello { robot: 7, joints: 1, rate_hz: 1000.0, pacing: Pacing::LockStep };

pub fn config(torque_rate: f32) -> ControllerConfig<f32, 1> {
    ControllerConfig {
        law: Law::ComputedTorque,
        gains: [Gains { position: 400.0, velocity: 40.0, inertia: INERTIA as f32 }],
        friction: None,
        limits: [Limits { position: (-2.5, 2.5), velocity: 3.0, torque: 18.0, torque_rate }],
        torque_step: [torque_rate * H as f32],
        guard: [Guard { position_margin: 0.05, velocity_max: 4.5 }],
        age_max: 2,
        encoder: [Encoder { zero: 0, per_count: 0.001 }],
        observer: TrackingObserver::from_gains(0.001, 5e-7, 0.63, 155.0),
        integral: None,
        teach: None,
        posture_damping: None,
    }
}

pub fn rules(safe_action: SafeAction) -> Rules<f32, 1> {
    let joint = JointRules {
        rest_speed: 0.05,
        jump_step: 0.006,
        resolution: 0.001,
        deceleration: 12.0,
        reach: 0.2,
        reach_speed: 0.3,
        rotor_max: 0.2,
        damping: 4.0,
    };
    Rules {
        safe_action,
        heartbeat_max: 100,
        hold_max: 500,
        supply: (f32::NEG_INFINITY, f32::INFINITY),
        temperature: (f32::NEG_INFINITY, f32::INFINITY),
        period: 0.001,
        rate: 1000.0,
        latency: 0.002,
        payload: InertiaBounds { mass: 5.0, radius: 0.5 },
        joints: [joint],
    }
}

pub struct Rig<F> {
    pub joints: CanJoints<F, Wire, NoBus, NoBus, Brake, 1>,
    pub wire: Wire,
    pub brake: Brake,
    pub session: Session<1, Pendulum, Polynomial, Protected<f32, 1>>,
    meter: Meter<None0>,
    pub q: f64,
    pub qd: f64,
    pub stop: bool,
    pub order: Option<Drives<1>>,
    pub readings: Option<Readings<1>>,
    pub ticks: u32,
    /// Power of the drive: off, it neither hears nor answers nor gives torque.
    pub powered: bool,
    pub heard: bool,
    /// What the drive's zero is off since it was switched on, rad.
    pub offset: f64,
}

impl<F: Frames> Rig<F> {
    pub fn new(language: Language, torque_rate: f32, action: SafeAction) -> Self {
        Self::with(language, torque_rate, action, false)
    }
    pub fn with(language: Language, torque_rate: f32, action: SafeAction, live: bool) -> Self {
        let sym = |max: f32| Range { min: -max, max };
        let ranges = MitRanges { position: sym(12.5), velocity: sym(65.0), kp: Range { min: 0.0, max: 500.0 }, kd: Range { min: 0.0, max: 5.0 }, torque: sym(18.0) };
        let (reply_id, reply_bytes) = if language == Language::MiniCheetah { (0, 6) } else { (0x11, 8) };
        let drive = MitDrive {
            bus: 0, data_rate: None, id: 1, reply_id, reply_bytes, temperature_offset: None, ranges,
            gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.0 }, damping: 4.0,
        };
        let mut actuator = Actuator::new(1, Ranges { position: (-12.5, 12.5), velocity: (-65.0, 65.0), kp: (0.0, 500.0), kd: (0.0, 5.0), torque: (-18.0, 18.0) });
        actuator.electronics.language = language;
        actuator.electronics.reply_id = reply_id;
        actuator.electronics.reply_bytes = usize::from(reply_bytes);
        let wire = Wire { bus: Rc::new(RefCell::new(Bus::new(vec![actuator]))), ..Wire::default() };
        let brake = Brake::default();
        let control = config(torque_rate);
        let controller = Controller::new(control, Pendulum { live }, Polynomial);
        let protected = Protected { control, rules: rules(action) };
        let mut rig = Self {
            joints: CanJoints::new((wire.clone(), NoBus, NoBus), brake.clone(), [drive]),
            wire, brake,
            session: Session::new(OWN, controller, protected),
            meter: Meter::new(None0),
            q: 0.0, qd: 0.0, stop: false, order: None, readings: None, ticks: 0, powered: true, heard: true, offset: 0.0,
        };
        let hello = Hello { pacing: Pacing::Live, ..OWN };
        assert_eq!(rig.receive(Frame::Hello(hello)), Reaction::Start(Pacing::Live, Frame::Hello(hello)));
        for _ in 0..5 {
            rig.tick();
        }
        rig
    }
    pub fn receive(&mut self, frame: Frame) -> Reaction {
        self.session.receive(Ok(Received { frame, missed: 0 }))
    }
    pub fn ask(&mut self, request: Request) {
        self.receive(Frame::Request(request));
        self.tick();
    }
    pub fn home(&mut self) {
        self.ask(Request::Home);
        self.ask(Request::Confirm);
    }
    pub fn point(&mut self, ticks: u16, q: f32) -> Reaction {
        let reference = link::Reference::new(&Reference::at_rest([q]));
        self.receive(Frame::Point(Point { ticks, reference }))
    }
    pub fn state(&self) -> safety::State {
        match self.session.state() {
            State::Supervised(_, s) => s,
            o => panic!("{o:?}"),
        }
    }
    pub fn fault(&self) -> Option<Fault> {
        match self.state() {
            safety::State::Fault(f) => Some(f),
            _ => None,
        }
    }
    pub fn electronics<T>(&self, look: impl FnOnce(&mut Electronics) -> T) -> T {
        look(&mut self.wire.bus.borrow_mut().actuators[0].electronics)
    }
    /// As `firmware/src/app.rs` has it, then 1 ms of the world.
    pub fn tick(&mut self) {
        if self.heard {
            self.receive(Frame::Alive);
        }
        let readings = self.joints.measure();
        let lines = Lines { emergency_stop: self.stop, ..Lines::NONE };
        self.session.sense(readings.as_ref(), &lines);
        let drives = self.session.tick(&self.meter);
        match drives {
            Drives::Drive(torque) => self.joints.drive(&torque, self.session.springs().as_ref()),
            Drives::Safe(action) => self.joints.safe(action),
        }
        (self.order, self.readings) = (Some(drives), readings);
        let shaft = Shaft { position: self.q + self.offset, velocity: self.qd };
        {
            let mut bus = self.wire.bus.borrow_mut();
            bus.actuators[0].shaft = shaft;
            bus.unplugged = if self.powered { vec![] } else { vec![1] };
            if !self.wire.swallow.get() {
                bus.serve();
            }
        }
        if self.wire.refuse.get() > 0 {
            self.wire.refuse.set(self.wire.refuse.get() - 1);
        }
        for _ in 0..10 {
            let dt = H / 10.0;
            let powered = self.powered;
            let shaft = Shaft { position: self.q + self.offset, velocity: self.qd };
            let torque = self.electronics(|e| {
                e.pass(dt);
                if powered { e.drive(&shaft) } else { 0.0 }
            });
            if self.brake.0.get() {
                self.qd += dt * (torque - WEIGHT * self.q.cos()) / INERTIA;
                self.q += dt * self.qd;
            } else {
                self.qd = 0.0;
            }
        }
        self.ticks += 1;
    }
    pub fn torque_told(&self) -> Option<f32> {
        match self.order {
            Some(Drives::Drive([t])) => Some(t),
            _ => None,
        }
    }
}
