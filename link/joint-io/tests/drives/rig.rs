//! Test rig: a session, one joint with a simulated drive on a CAN bus, and a pendulum on its shaft.
//!
//! The rig runs the firmware's own tick, [`run_tick`].
use actuator_model::bus::Bus;
use actuator_model::frame::Frame as CanFrame;
use actuator_model::mit::{Actuator, Electronics, Language, Ranges, Shaft};
use dynamics_core::control::Spring;
use dynamics_core::control::{
    BuildOf, ControlLaw, Controller, ControllerConfig, Encoder, Fault, Gains, Guard, TrackingObserver, Unprotected,
};
use dynamics_core::drive::{Gearing, MitDrive, MitRanges, Range};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{self, JointRules, Protected, Rules, SafeAction};
use dynamics_core::scene::Live;
use dynamics_core::trig::Polynomial;
use dynamics_core::{InertiaBounds, Limits, SinCos};
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use embedded_hal::digital::{ErrorType, OutputPin};
use joint_io::can::CanJoints;
use joint_io::can_bus::{CanBus, NoBus};
use joint_io::frames::Frames;
use joint_io::{JointIo, run_tick};
use link::codec::Received;
use link::{Cost, Frame, Hello, Pacing, Request};
use session::meter::{Counter, Meter};
use session::readings::{Lines, Readings};
use session::{Reaction, Session, State};
use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::rc::Rc;

/// Control period, s.
pub(crate) const H: f64 = 0.001;

/// Inertia of the pendulum, kg m^2.
pub(crate) const INERTIA: f64 = 0.55;

/// Torque of its weight at `q = 0`, where it is horizontal, N m: 2 kg at 0.5 m.
pub(crate) const WEIGHT: f64 = 9.81;

/// Ticks that the brake needs to engage after its line goes low, and the delay that the board assumes. The brake opens at once.
pub(crate) const ENGAGES: u32 = 80;
pub(crate) const BRAKE_DELAY: u32 = 100;

/// Largest fall of the joint until the brake has engaged, from rest and without torque, rad.
pub(crate) const FALL: f64 = 0.5 * WEIGHT / INERTIA * (ENGAGES as f64 * H) * (ENGAGES as f64 * H);

/// Ticks for setting the drives' timeouts and enabling them.
pub(crate) const ARMING: u32 = 20;

/// The controller's model of the pendulum.
#[derive(Clone, Copy)]
pub(crate) struct Pendulum;

impl InverseDynamics<f32, 1> for Pendulum {
    fn inverse_dynamics(
        &self,
        t: &[SinCos<f32>; 1],
        _: &[f32; 1],
        _: &[f32; 1],
        qdd: &[f32; 1],
        _: &Live<f32, 1>,
    ) -> [f32; 1] {
        [INERTIA as f32 * qdd[0] + WEIGHT as f32 * t[0].cos]
    }
}

/// The board's side of the bus.
#[derive(Clone, Default)]
pub(crate) struct Wire {
    /// The bus.
    pub(crate) bus: Rc<RefCell<Bus>>,
    /// Number of transmissions to refuse from now on (the transmitter is full).
    pub(crate) refuse: Rc<Cell<u32>>,
    /// True if accepted frames never reach the wire: the next tick drops them.
    pub(crate) swallow: Rc<Cell<bool>>,
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

/// The line to the brake; true opens it.
#[derive(Clone, Default)]
pub(crate) struct Brake(pub(crate) Rc<Cell<bool>>);
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

/// A counter that does not count.
pub(crate) struct Uncounted;
impl Counter for Uncounted {
    fn now(&self) -> u32 {
        0
    }
    fn cost(c: u32) -> Cost {
        Cost::Instructions(c)
    }
    fn exercise(&self) {}
}

const OWN: Hello = Hello { robot: 7, joints: 1, rate_hz: 1000.0, pacing: Pacing::LockStep };

fn config(torque_rate: f32) -> ControllerConfig<f32, 1> {
    ControllerConfig {
        law: ControlLaw::ComputedTorque,
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

pub(crate) fn rules(safe_action: SafeAction) -> Rules<f32, 1> {
    let joint = JointRules {
        rest_speed: 0.05,
        jump_step: 0.006,
        resolution: 0.001,
        deceleration: 12.0,
        reach: 0.2,
        reach_speed: 0.3,
        rotor_max: 0.2,
        damping: 4.0,
        lowering_speed: 0.2,
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
        arming_max: 300,
        brake_delay: if safe_action == SafeAction::Brake { BRAKE_DELAY } else { 0 },
        live: 0,
        live_max: 0,
        rest: None,
        first_motion: None,
        heat: None,
        payload: InertiaBounds { mass: 5.0, radius: 0.5 },
        joints: [joint],
    }
}

/// A joint that records the readings and torque of the last tick.
pub(crate) struct Recorded<F> {
    /// The firmware's driver.
    pub(crate) inner: CanJoints<F, Wire, NoBus, NoBus, Brake, 1>,
    /// Readings of this tick.
    pub(crate) readings: Option<Readings<1>>,
    /// Torque of this tick, N m; `None` in the safe action.
    pub(crate) torque: Option<f32>,
}

impl<F: Frames> JointIo<1> for Recorded<F> {
    fn measure(&mut self) -> Option<Readings<1>> {
        self.readings = self.inner.measure();
        self.readings
    }
    fn temperature(&self) -> Option<f32> {
        self.inner.temperature()
    }
    fn enable(&mut self, action: SafeAction) {
        self.torque = None;
        self.inner.enable(action);
    }
    fn preload(&mut self, torque: &[f32; 1], springs: Option<&[Spring<f32>; 1]>) {
        self.torque = Some(torque[0]);
        self.inner.preload(torque, springs);
    }
    fn drive(&mut self, torque: &[f32; 1], springs: Option<&[Spring<f32>; 1]>) {
        self.torque = Some(torque[0]);
        self.inner.drive(torque, springs);
    }
    fn safe(&mut self, action: SafeAction) {
        self.torque = None;
        self.inner.safe(action);
    }
    fn end(&mut self) {
        self.torque = None;
        self.inner.end();
    }
    fn clear(&mut self) {
        self.inner.clear();
    }
}

/// The parts of the controller.
type Build = BuildOf<Pendulum, Polynomial, ControllerConfig<f32, 1>, Unprotected, Protected<f32, 1>>;

/// The rig.
pub(crate) struct Rig<F> {
    /// The joint.
    pub(crate) joints: Recorded<F>,
    /// The bus.
    pub(crate) wire: Wire,
    /// The brake.
    pub(crate) brake: Brake,
    /// The session.
    pub(crate) session: Session<1, Build>,
    meter: Meter<Uncounted>,
    /// Angle of the joint, rad, and its velocity, rad/s.
    pub(crate) q: f64,
    pub(crate) qd: f64,
    /// True while the emergency stop is pressed.
    pub(crate) stop: bool,
    /// True if the drive has power. Without it, the drive neither receives nor answers nor gives torque.
    pub(crate) powered: bool,
    /// True if the drive's bus cable is open; it has power.
    pub(crate) unplugged: bool,
    /// True if the board's ticks run.
    pub(crate) ticking: bool,
    /// True if the brake does not act, as on an arm without brakes.
    pub(crate) brakeless: bool,
    /// True if the host sends nothing.
    pub(crate) host_gone: bool,
    /// Ticks for which the brake is still open after its line went low.
    engaging: u32,
    /// Number of the last request.
    number: u8,
}

/// Ranges of the drive; the same for every kind.
fn ranges() -> MitRanges {
    let symmetric = |max: f32| Range { min: -max, max };
    MitRanges {
        position: symmetric(12.5),
        velocity: symmetric(65.0),
        kp: Range { min: 0.0, max: 500.0 },
        kd: Range { min: 0.0, max: 5.0 },
        torque: symmetric(18.0),
    }
}

impl<F: Frames> Rig<F> {
    /// Creates a rig in a live session with a drive of protocol `language`, at rest and off.
    pub(crate) fn new(language: Language, action: SafeAction) -> Self {
        Self::with(language, action, |_| {})
    }

    /// As [`Rig::new`], with a changed drive.
    pub(crate) fn with(language: Language, action: SafeAction, change: impl FnOnce(&mut MitDrive)) -> Self {
        Self::with_rules(language, (ControlLaw::ComputedTorque, rules(action)), change)
    }

    /// As [`Rig::with`], with this control law and these rules of the safety state machine.
    pub(crate) fn with_rules(
        language: Language,
        (law, rules): (ControlLaw, Rules<f32, 1>),
        change: impl FnOnce(&mut MitDrive),
    ) -> Self {
        let (reply_id, reply_bytes, timeout) = match language {
            Language::MiniCheetah => (0, 6, 0),
            Language::Damiao | Language::RobStride => (0x11, 8, 1000),
            Language::MyActuator => (0x501, 8, 0),
        };
        let mut drive = MitDrive {
            bus: 0,
            data_rate: None,
            id: 1,
            reply_id,
            reply_bytes,
            temperature_offset: None,
            ranges: ranges(),
            gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.0 },
            damping: 4.0,
            timeout,
            restart_ticks: 10,
            absolute: false,
        };
        change(&mut drive);
        let mut actuator = Actuator::new(
            1,
            Ranges {
                position: (-12.5, 12.5),
                velocity: (-65.0, 65.0),
                kp: (0.0, 500.0),
                kd: (0.0, 5.0),
                torque: (-18.0, 18.0),
            },
        );
        actuator.electronics = actuator.electronics.speaking(language);
        actuator.electronics.reply_id = reply_id;
        actuator.electronics.reply_bytes = usize::from(reply_bytes);
        let wire = Wire { bus: Rc::new(RefCell::new(Bus::new(vec![actuator]))), ..Wire::default() };
        let brake = Brake::default();
        let control = ControllerConfig { law, ..config(2000.0) };
        let inner = CanJoints::new((wire.clone(), NoBus, NoBus), brake.clone(), [drive]);
        let mut rig = Self {
            joints: Recorded { inner, readings: None, torque: None },
            wire,
            brake,
            session: Session::new(OWN, Controller::new(control, Pendulum, Polynomial), Protected { control, rules }),
            meter: Meter::new(Uncounted),
            q: 0.0,
            qd: 0.0,
            stop: false,
            powered: true,
            unplugged: false,
            ticking: true,
            brakeless: false,
            host_gone: false,
            engaging: 0,
            number: 0,
        };
        let hello = Hello { pacing: Pacing::Live, ..OWN };
        assert_eq!(rig.receive(Frame::Hello(hello)), Reaction::Start(Pacing::Live, Frame::Hello(hello)));
        for _ in 0..5 {
            rig.tick();
        }
        rig
    }

    /// Homes and arms the joint, and waits until the drive is on.
    pub(crate) fn armed(mut self) -> Self {
        self.home();
        self.ask(Request::Arm);
        for _ in 0..200 {
            self.tick();
        }
        assert!(self.brake.0.get() && self.state() == safety::State::Armed, "{:?}", self.state());
        self
    }

    /// Receives a frame of the host.
    pub(crate) fn receive(&mut self, frame: Frame) -> Reaction {
        self.session.receive(Ok(Received { frame, missed: 0 }))
    }

    /// Sends a request of the host and runs the tick that decides on it.
    pub(crate) fn ask(&mut self, request: Request) {
        self.number = self.number.wrapping_add(1);
        self.receive(Frame::request(self.number, request));
        self.tick();
    }

    /// Homes the joint at its present position.
    pub(crate) fn home(&mut self) {
        self.ask(Request::Home);
        self.ask(Request::Confirm);
    }

    /// State of the machine.
    pub(crate) fn state(&self) -> safety::State {
        match self.session.state() {
            State::Supervised(_, s) => s,
            o => panic!("{o:?}"),
        }
    }

    /// The fault, if there is one.
    pub(crate) fn fault(&self) -> Option<Fault> {
        match self.state() {
            safety::State::Fault(f) => Some(f),
            _ => None,
        }
    }

    /// The drive's electronics.
    pub(crate) fn electronics<T>(&self, look: impl FnOnce(&mut Electronics) -> T) -> T {
        look(&mut self.wire.bus.borrow_mut().actuators[0].electronics)
    }

    /// True if the drive is switched off, or follows a command without gains and with at most half a step of torque: a MyActuator drive that is off
    /// is measured with such commands.
    pub(crate) fn is_off(&self) -> bool {
        self.electronics(|it| {
            let told = it.told();
            !it.is_enabled() || (told.kp == 0.0 && told.kd == 0.0 && told.torque.abs() <= it.torque_max / 4095.0)
        })
    }

    /// Runs one tick of the board, then simulates 1 ms of drive, joint and brake.
    pub(crate) fn tick(&mut self) {
        if self.ticking {
            if !self.host_gone {
                self.receive(Frame::Alive);
            }
            let lines = Lines { emergency_stop: self.stop, ..Lines::NONE };
            run_tick(&mut self.session, &mut self.joints, &self.meter, || lines, || false);
        }
        {
            let mut bus = self.wire.bus.borrow_mut();
            bus.actuators[0].shaft = Shaft { position: self.q, velocity: self.qd };
            bus.unplugged = if self.powered && !self.unplugged { vec![] } else { vec![1] };
            if !self.wire.swallow.get() {
                bus.serve();
            }
        }
        self.wire.refuse.set(self.wire.refuse.get().saturating_sub(1));
        let open = self.is_open();
        self.engaging = if self.brake.0.get() { ENGAGES } else { self.engaging.saturating_sub(1) };
        for _ in 0..10 {
            let dt = H / 10.0;
            let powered = self.powered;
            let shaft = Shaft { position: self.q, velocity: self.qd };
            let torque = self.electronics(|it| {
                it.pass(dt);
                if powered { it.drive(&shaft) } else { 0.0 }
            });
            if open {
                self.qd += dt * (torque - WEIGHT * self.q.cos()) / INERTIA;
                self.q += dt * self.qd;
            } else {
                self.qd = 0.0;
            }
        }
    }

    /// True if no brake holds the joint: its line is high, the brake has not engaged yet, or there is none.
    pub(crate) fn is_open(&self) -> bool {
        self.brake.0.get() || self.engaging > 0 || self.brakeless
    }

    /// Switches the drive's power on again.
    pub(crate) fn restart(&mut self) {
        let shaft = Shaft { position: self.q, velocity: self.qd };
        self.electronics(|it| it.restart(&shaft));
        self.powered = true;
    }

    /// The joint's readings in the last tick.
    pub(crate) fn readings(&self) -> Readings<1> {
        self.joints.readings.unwrap()
    }
}
