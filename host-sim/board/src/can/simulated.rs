//! A simulated arm at the other end of the buses, in the time of the clock.
//!
//! A stand holds the arm until all its drives are on and carry it. Then it moves as its drives make it; there are no brakes. Once no drive
//! carries it in its rest pose, it rests there again, as on its mechanical stops.

use super::adapter::Adapter;
use super::frame::CanFrame;
use actuator_model::frame::Frame as BusFrame;
use actuator_model::mit::Electronics;
use embedded_can::Frame as _;
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use sim::plant::drives::Drives;
use sim::run::scene_world::world;
use sim::run::world::World;
use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Rate at which the drives renew their torque, and at which time passes, Hz.
const RATE: f64 = 4000.0;

/// Longest time that is simulated at once, s. A program that slept longer finds the arm as if it had slept this long.
const CATCH_UP: f64 = 5.0;

/// Distance from the rest pose within which the arm rests on its stops, rad or m.
const REST_NEAR: f64 = 0.15;

/// Torque that carries nothing, as a share of the range: more than that of the probe by which a drive is seen to be on.
const PROBE: f64 = 0.021;

/// True if a drive was commanded to carry its joint.
fn carries(electronics: &Electronics) -> bool {
    let told = electronics.told();
    electronics.is_enabled() && (told.kp > 0.0 || told.torque.abs() > PROBE * electronics.ranges.torque.1)
}

/// An arm that takes and returns frames.
trait Arm: Send {
    fn advance(&mut self, to: f64);

    fn deliver(&mut self, frame: &BusFrame) -> Vec<BusFrame>;

    fn positions(&self) -> Vec<f64>;

    fn unplug(&mut self, joint: usize, unplugged: bool);
}

struct ArmOf<const N: usize> {
    world: World<N>,
    /// Pose in which the arm carries itself.
    rest: Option<[f64; N]>,
    time: f64,
    /// True once all drives have carried it.
    released: bool,
    /// True if the arm can no longer be simulated; its drives still answer.
    lost: bool,
}

impl<const N: usize> Arm for ArmOf<N> {
    fn advance(&mut self, to: f64) {
        self.time = self.time.max(to - CATCH_UP);
        while self.time + self.world.period <= to {
            self.time += self.world.period;
            if let Some(drives) = &mut self.world.drives {
                let has = |drives: &mut Drives<N>, is_so: fn(&Electronics) -> bool, joint| {
                    drives.electronics(joint).is_some_and(|it| is_so(it))
                };
                let all_on = (0..N).all(|joint| has(drives, Electronics::is_enabled, joint));
                let carried = (0..N).any(|joint| has(drives, carries, joint));
                self.released |= all_on && carried;
                let at = self.world.plant.state().q;
                let rests = |rest: &[f64; N]| rest.iter().zip(&at).all(|(rest, q)| (rest - q).abs() < REST_NEAR);
                self.released &= carried || !self.rest.as_ref().is_some_and(rests);
            }
            if self.released && !self.lost {
                self.lost = self.world.pass().is_err();
            } else {
                self.world.stand();
            }
        }
    }

    fn deliver(&mut self, frame: &BusFrame) -> Vec<BusFrame> {
        self.world.deliver(frame)
    }

    fn positions(&self) -> Vec<f64> {
        self.world.plant.state().q.to_vec()
    }

    fn unplug(&mut self, joint: usize, unplugged: bool) {
        if let Some(drives) = &mut self.world.drives {
            drives.disturb(joint, unplugged, [(false, actuator_model::bus::Fate::Arrives); 2]);
        }
    }
}

/// A simulated arm, with any number of adapters at its buses.
#[derive(Clone)]
pub struct SimulatedArm {
    arm: Arc<Mutex<Box<dyn Arm>>>,
    begun: Instant,
}

impl SimulatedArm {
    /// The arm of a scene, in its rest pose if the robot file has one, otherwise where the scene's motion begins.
    ///
    /// # Errors
    /// [`Failure::Input`]: the scene cannot be simulated.
    pub fn new(scene: &SceneFile) -> Result<Self, Failure> {
        let mut scene = scene.clone();
        scene.control.rate = RATE;
        scene.actuators.ideal = false;
        scene.plant.step = scene.plant.step.min(1.0 / RATE);
        if let Some(rest) = &scene.robot.rest {
            scene.plant.start.clone_from(rest);
        }
        let arm: Box<dyn Arm> = with_dof!(scene.robot.dof(), N => {
            let mut world = world::<N>(&scene)?;
            // Compiled later, they would make a tick end too late.
            world.plant.compile_next();
            let lost = world.pass().is_err();
            let rest = scene.robot.rest.as_ref().and_then(|rest| <[f64; N]>::try_from(rest.as_slice()).ok());
            Box::new(ArmOf { world, rest, time: 0.0, released: false, lost })
        });
        Ok(Self { arm: Arc::new(Mutex::new(arm)), begun: Instant::now() })
    }

    fn with<R>(&self, call: impl FnOnce(&mut dyn Arm) -> R) -> R {
        // An arm whose thread panicked has no half-finished state that anybody trusts.
        call(self.arm.lock().unwrap_or_else(PoisonError::into_inner).as_mut())
    }

    /// Lets the time of the clock pass.
    pub fn advance(&self) {
        let now = self.begun.elapsed().as_secs_f64();
        self.with(|arm| arm.advance(now));
    }

    /// Delivers a frame now, and returns the replies.
    #[must_use]
    pub fn deliver(&self, frame: &CanFrame) -> Vec<CanFrame> {
        self.advance();
        let frame = BusFrame { id: frame.raw_id(), extended: frame.is_extended(), data: frame.data().to_vec() };
        let replies = self.with(|arm| arm.deliver(&frame));
        replies.iter().filter_map(|reply| CanFrame::of(reply.id, reply.extended, &reply.data)).collect()
    }

    /// Positions of the joints now, rad or m.
    #[must_use]
    pub fn positions(&self) -> Vec<f64> {
        self.advance();
        self.with(|arm| arm.positions())
    }

    /// Cuts the cable of a joint's drive, or plugs it in again.
    pub fn unplug(&self, joint: usize, unplugged: bool) {
        self.with(|arm| arm.unplug(joint, unplugged));
    }

    /// Time since the arm was made.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.begun.elapsed()
    }

    /// An adapter at one of its buses.
    #[must_use]
    pub fn adapter(&self) -> SimulatedAdapter {
        SimulatedAdapter { arm: self.clone(), received: VecDeque::new() }
    }
}

/// An adapter at a bus of a simulated arm.
pub struct SimulatedAdapter {
    arm: SimulatedArm,
    received: VecDeque<CanFrame>,
}

impl Adapter for SimulatedAdapter {
    fn begin_tick(&mut self) {}

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let replies = self.arm.deliver(frame);
        self.received.extend(replies);
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        Ok(self.received.pop_front())
    }

    fn is_off(&mut self) -> bool {
        false
    }
}
