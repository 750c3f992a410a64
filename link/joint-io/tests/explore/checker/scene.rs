//! An arm to explore: drive kind, safe action, and the numbers of controller and machine.
//!
//! The arm's joints are independent: each lifts [`WEIGHT`] from a table at position 0. One control period is 10 ms. Time limits are a few
//! periods, so that a search over some tens of periods exceeds all of them.

use super::faulty::Mutant;
use actuator_model::mit::{Electronics, Language, Ranges};
use core::fmt::Debug;
use dynamics_core::control::{ControlLaw, ControllerConfig, Encoder, Gains, Guard, TrackingObserver};
use dynamics_core::drive::{Gearing, MitDrive, MitRanges, Range};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{JointRules, Protected, Rules, SafeAction};
use dynamics_core::scene::Live;
use dynamics_core::{InertiaBounds, Limits, SinCos};
use link::{Hello, Pacing};

/// Control period, s.
pub const PERIOD: f64 = 0.01;
/// Inertia of a joint, kg m^2.
pub const INERTIA: f64 = 0.55;
/// Torque that holds a joint, N m.
pub const WEIGHT: f64 = 6.0;
/// Highest position of the operator's motion, rad; it begins at the table, at 0.
pub const TOP: f32 = 24.0 / 1024.0;
/// Control periods of the operator's motion up or down.
pub const MOTION_TICKS: u16 = 20;
/// Largest change of torque in a period, N m: three periods to [`WEIGHT`].
pub const TORQUE_STEP: f32 = 2.0;
/// Longest age of a measurement, periods.
pub const AGE_MAX: u32 = 2;
/// Longest silence of the host, periods.
pub const HEARTBEAT_MAX: u32 = 3;
/// Longest hold without the host, periods.
pub const HOLD_MAX: u32 = 4;
/// Longest time to enable the drives, periods.
pub const ARMING_MAX: u32 = 12;
/// Longest time that the brakes need to engage, periods. Those of the model engage at once.
pub const BRAKE_DELAY: u32 = 2;
/// Greatest speed of lowering, rad/s.
pub const LOWERING_SPEED: f32 = 0.1;
/// Shortest restart of a drive, periods: it misses as many commands.
pub const RESTART: u32 = 2;
/// The drives' own communication timeout, which the board sets, in units of 50 us: ten periods.
pub const TIMEOUT: u32 = 2000;
/// Shift of a drive's zero after a restart, rad: one turn of the motor at a gear of 30.
pub const TURN: f64 = core::f64::consts::TAU / 30.0;

/// Kinds of disturbing events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kinds {
    /// Fates of frames on the bus.
    pub frames: bool,
    /// Drives that restart, lose power, or go off.
    pub drives: bool,
    /// Requests in addition to the operator's.
    pub requests: bool,
    /// The host's frames and its presence.
    pub host: bool,
}

impl Kinds {
    /// All of them.
    pub const ALL: Self = Self { frames: true, drives: true, requests: true, host: true };

    /// None of them.
    pub const NONE: Self = Self { frames: false, drives: false, requests: false, host: false };
}

/// The explored configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Protocol of the drives.
    pub language: Language,
    /// The arm's safe action.
    pub action: SafeAction,
    /// True if a drive keeps its zero through a restart.
    pub absolute: bool,
    /// True if the arm has a rest pose, on the table.
    pub rest: bool,
    /// Largest number of disturbing events on one path.
    pub budget: u8,
    /// Periods after the first event in which the others may happen; `None` for any number.
    pub within: Option<u8>,
    /// Kinds of events.
    pub events: Kinds,
    /// A deliberate fault that the search must find.
    pub mutant: Option<Mutant>,
}

/// Configuration of controller and safety state machine, shared by all states.
#[derive(Clone, Copy)]
pub struct Numbers<const N: usize>(&'static Protected<f32, N>);

impl<const N: usize> Numbers<N> {
    /// The numbers of a setup, which live as long as the program.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        Self(Box::leak(Box::new(Protected { control: control(), rules: rules(setup) })))
    }
}

impl<const N: usize> Debug for Numbers<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Numbers")
    }
}

impl<const N: usize> dynamics_core::control::Configuration<f32, N> for Numbers<N> {
    fn get(&self) -> &ControllerConfig<f32, N> {
        &self.0.control
    }
}

impl<const N: usize> dynamics_core::safety::SafetyConfiguration<f32, N> for Numbers<N> {
    fn rules(&self) -> &Rules<f32, N> {
        &self.0.rules
    }
}

/// The model of the arm: inertia and a constant weight at every joint.
#[derive(Clone, Copy, Debug)]
pub struct Lift;

impl<const N: usize> InverseDynamics<f32, N> for Lift {
    fn inverse_dynamics(
        &self,
        _: &[SinCos<f32>; N],
        _: &[f32; N],
        _: &[f32; N],
        qdd: &[f32; N],
        _: &Live<f32, N>,
    ) -> [f32; N] {
        qdd.map(|qdd| INERTIA as f32 * qdd + WEIGHT as f32)
    }
}

fn control<const N: usize>() -> ControllerConfig<f32, N> {
    ControllerConfig {
        law: ControlLaw::ComputedTorque,
        gains: [Gains { position: 100.0, velocity: 20.0, inertia: INERTIA as f32 }; N],
        friction: None,
        limits: [Limits { position: (-0.02, 0.5), velocity: 3.0, torque: 18.0, torque_rate: 200.0 }; N],
        torque_step: [TORQUE_STEP; N],
        guard: [Guard { position_margin: 0.05, velocity_max: 4.5 }; N],
        age_max: AGE_MAX,
        encoder: [Encoder { zero: 0, per_count: 0.001 }; N],
        observer: TrackingObserver::from_gains(0.01, 5e-5, 0.63, 15.5),
        integral: None,
        teach: None,
        posture_damping: None,
    }
}

fn rules<const N: usize>(setup: &Setup) -> Rules<f32, N> {
    let joint = JointRules {
        rest_speed: 0.05,
        jump_step: 0.045,
        resolution: 0.002,
        deceleration: 12.0,
        reach: 0.1,
        reach_speed: 0.3,
        rotor_max: 0.2,
        damping: 4.0,
        lowering_speed: LOWERING_SPEED,
    };
    Rules {
        safe_action: setup.action,
        heartbeat_max: HEARTBEAT_MAX,
        hold_max: HOLD_MAX,
        supply: (f32::NEG_INFINITY, f32::INFINITY),
        temperature: (f32::NEG_INFINITY, f32::INFINITY),
        period: PERIOD as f32,
        rate: 1.0 / PERIOD as f32,
        latency: 0.02,
        arming_max: ARMING_MAX,
        brake_delay: if matches!(setup.action, SafeAction::Brake) { BRAKE_DELAY } else { 0 },
        live: 0,
        live_max: 0,
        rest: (setup.rest && setup.mutant != Some(Mutant::NoRestPose)).then_some([0.0; N]),
        first_motion: None,
        heat: None,
        payload: InertiaBounds { mass: 5.0, radius: 0.5 },
        joints: [joint; N],
    }
}

/// Hello of the board.
#[must_use]
pub const fn own(joints: u8) -> Hello {
    Hello { robot: 7, joints, rate_hz: 1.0 / PERIOD as f32, pacing: Pacing::LockStep }
}

/// The board's configuration of a joint's drive.
#[must_use]
pub fn drive(setup: &Setup, joint: u8) -> MitDrive {
    let both = |max: f32| Range { min: -max, max };
    let up = |max: f32| Range { min: 0.0, max };
    let (reply_id, reply_bytes) = reply(setup.language, joint);
    MitDrive {
        bus: 0,
        data_rate: None,
        id: joint + 1,
        reply_id,
        reply_bytes,
        temperature_offset: None,
        ranges: MitRanges { position: both(1.0), velocity: both(5.0), kp: up(500.0), kd: up(5.0), torque: both(18.0) },
        gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.0 },
        damping: 4.0,
        timeout: if reports_state(setup.language) { TIMEOUT } else { 0 },
        restart_ticks: RESTART - 1,
        absolute: setup.absolute,
    }
}

/// The simulated drive, just switched on.
#[must_use]
pub fn electronics(setup: &Setup, joint: u8) -> Electronics {
    let ranges = Ranges {
        position: (-1.0, 1.0),
        velocity: (-5.0, 5.0),
        kp: (0.0, 500.0),
        kd: (0.0, 5.0),
        torque: (-18.0, 18.0),
    };
    let (reply_id, reply_bytes) = reply(setup.language, joint);
    let mut electronics = Electronics::new(u16::from(joint) + 1, ranges).speaking(setup.language);
    electronics.reply_id = reply_id;
    electronics.reply_bytes = usize::from(reply_bytes);
    if setup.language == Language::MyActuator {
        electronics.reports_errors = true;
        electronics.release_time = RELEASE_TIME;
    }
    electronics
}

/// Time that a drive needs to release its holding brake and to confirm that, s. Real ones need 0.05 to 0.15 s; a shorter time has fewer states.
const RELEASE_TIME: f64 = 0.025;

/// True if the drive reports its errors: in its replies, or in a status that it sends by itself.
#[must_use]
pub const fn reports_errors(language: Language) -> bool {
    reports_state(language) || matches!(language, Language::MyActuator)
}

/// True if replies show whether the drive is on. Such drives also have a timeout that the board sets, and an error in their replies.
#[must_use]
pub const fn reports_state(language: Language) -> bool {
    matches!(language, Language::Damiao | Language::RobStride)
}

/// Identifier and length of a drive's replies.
fn reply(language: Language, joint: u8) -> (u16, u8) {
    match language {
        Language::MiniCheetah => (0, 6),
        Language::Damiao => (0x11 + u16::from(joint), 8),
        Language::RobStride => (0xfd, 8),
        Language::MyActuator => (0x501 + u16::from(joint), 8),
    }
}
