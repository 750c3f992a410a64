//! Everything in the loop but the controller: arm, sensors, drives and motion.

use crate::plant::drives::{Drives, Order};
use crate::plant::sensor::Sensors;
use crate::plant::solver::{Solver, now};
use crate::plant::{Diverged, Plant};
use crate::run::sensing::Sensing;
use actuator_model::frame::Frame;
use core::fmt;
use dynamics_core::control::Spring;
use dynamics_core::control::trajectory::Motion;
use dynamics_core::safety::SafeAction;
use dynamics_core::{Fault, Model, Real, Reference};

/// Everything in the loop but the controller.
///
/// Ideal drives produce a commanded torque at once, the sensors measure at the tick, and any safe action is that of the brakes. Simulated drives
/// measure themselves, and do the safe action as the board commands it.
#[derive(Clone, Debug)]
pub struct World<const N: usize> {
    /// The simulated arm.
    pub plant: Plant<N>,
    /// Its sensors; with simulated drives, only their noise is used.
    pub sensors: Sensors<N>,
    /// Simulated drives; `None` where they are ideal.
    pub drives: Option<Drives<N>>,
    /// The safe action, if the drives are simulated.
    pub safe_action: SafeAction,
    /// Lowest and highest temperature of simulated drives, degrees Celsius.
    pub temperature: (f64, f64),
    /// The motion that the arm should follow.
    pub motion: Motion<f64, N>,
    /// True if the motion restarts each time it ends.
    pub repeat: bool,
    /// True if the arm is hand-guided: its reference is its own position.
    pub hand_guided: bool,
    /// Springs and dampers for the drives' own loops, sent with every torque.
    pub springs: Option<[Spring<f32>; N]>,
    /// Control period, s.
    pub period: f64,
    /// The arm's model from the robot file.
    pub model: Model<f64, N>,
    /// The integration of the arm.
    pub(crate) compiled: Compiled<N>,
}

impl<const N: usize> World<N> {
    /// Reference of the arm at `t` (s).
    pub fn reference(&self, t: f64) -> Reference<f64, N> {
        if self.hand_guided {
            return Reference::at_rest(self.plant.state().q);
        }
        self.motion.sample(if self.repeat { t % self.motion.duration() } else { t })
    }

    /// Switches simulated drives on while something else holds the arm. They have then replied, and accept torque from the first tick on.
    pub fn switch_on(&mut self) {
        self.ask();
        let Self { plant, sensors, drives, safe_action, .. } = self;
        if let Some(drives) = drives {
            drives.enable(*safe_action, &sensors.disturbed(plant.measured()));
        }
        // They reply to this in the first tick.
        self.exchange(&Order::Torque([0.0; N], None));
    }

    /// Requests a first reply from simulated drives, as a board does when it starts. They stay off.
    pub fn ask(&mut self) {
        self.exchange(&Order::Safe(self.safe_action));
    }

    /// Reads the sensors or drives at the start of a tick.
    pub fn sense<S: Real>(&mut self) -> Sensing<S, N> {
        match self.drives.as_mut().map(Drives::measure) {
            None => Sensing::of_sensors(&self.sensors.read(self.plant.measured())),
            Some(reports) => Sensing::of_drives(reports),
        }
    }

    /// Fault that the firmware's state machine would detect in the drives' reports: that of the first drive at fault, otherwise that of the
    /// temperature.
    #[must_use]
    pub fn fault<S>(&self, sensing: &Sensing<S, N>) -> Option<Fault> {
        if let Some(joint) = sensing.drive_fault.iter().position(|fault| *fault) {
            return Some(Fault::DriveFault { joint: joint as u8 });
        }
        let (lowest, highest) = (self.temperature.0 as f32, self.temperature.1 as f32);
        // The comparison is false for NaN.
        let inside = sensing.temperature.is_none_or(|it| it >= lowest && it <= highest);
        (!inside).then_some(Fault::TemperatureOutOfBounds)
    }

    /// Simulates one control period with these commanded torques, N m or N.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn drive(&mut self, torque: &[f64; N]) -> Result<(), Diverged> {
        let Compiled(compiled) = self.compiled;
        compiled.drive(self, torque)
    }

    /// As [`World::drive`], with this solver.
    pub(crate) async fn drive_with(&mut self, solver: Solver<'_, N>, torque: &[f64; N]) -> Result<(), Diverged> {
        self.begin_tick();
        self.exchange(&Order::Torque(*torque, self.springs));
        let Self { plant, drives, .. } = self;
        match drives {
            None => plant.drive_with(solver, torque).await,
            Some(drives) if drives.brakes_hold() => {
                hold(plant, drives);
                Ok(())
            }
            Some(drives) => plant.drive_by(solver, drives.turns(), |state, dt| drives.torque(state, dt)).await,
        }
    }

    /// Simulates one control period of the safe action.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn stop(&mut self) -> Result<(), Diverged> {
        self.rest(&Order::Safe(self.safe_action))
    }

    /// As [`World::stop`], with this solver.
    pub(crate) async fn stop_with(&mut self, solver: Solver<'_, N>) -> Result<(), Diverged> {
        self.rest_with(solver, &Order::Safe(self.safe_action)).await
    }

    /// Simulates one control period in which the drives are switched on with engaged brakes.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn enable(&mut self, action: SafeAction) -> Result<(), Diverged> {
        self.rest(&Order::Enable(action))
    }

    /// Simulates one control period with these torques, N m or N, against engaged brakes.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn preload(&mut self, torque: &[f64; N]) -> Result<(), Diverged> {
        self.rest(&Order::Preload(*torque))
    }

    fn rest(&mut self, order: &Order<N>) -> Result<(), Diverged> {
        let Compiled(compiled) = self.compiled;
        compiled.rest(self, order)
    }

    /// Simulates a control period that the ledger does not count, in which brakes, if there are any, hold the arm.
    async fn rest_with(&mut self, solver: Solver<'_, N>, order: &Order<N>) -> Result<(), Diverged> {
        self.begin_tick();
        self.exchange(order);
        let Self { plant, drives, .. } = self;
        match drives {
            None => plant.brake(),
            Some(drives) if drives.brakes_hold() => hold(plant, drives),
            Some(drives) => {
                return plant.stop_by(solver, drives.turns(), |state, dt| drives.torque(state, dt)).await;
            }
        }
        Ok(())
    }

    /// Simulates one control period with drives that a controller outside this program commands ([`World::deliver`]).
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn pass(&mut self) -> Result<(), Diverged> {
        let Compiled(compiled) = self.compiled;
        compiled.pass(self)
    }

    /// As [`World::pass`], with this solver.
    async fn pass_with(&mut self, solver: Solver<'_, N>) -> Result<(), Diverged> {
        self.begin_tick();
        let Self { plant, drives, .. } = self;
        match drives {
            None => plant.brake(),
            Some(drives) => {
                return plant.drive_by(solver, drives.turns(), |state, dt| drives.torque(state, dt)).await;
            }
        }
        Ok(())
    }

    /// Simulates one control period in which a stand holds the arm.
    pub fn stand(&mut self) {
        self.begin_tick();
        let Self { plant, drives, .. } = self;
        match drives {
            None => plant.brake(),
            Some(drives) => hold(plant, drives),
        }
    }

    /// Delivers a frame to the simulated drives, and returns their replies.
    pub fn deliver(&mut self, frame: &Frame) -> Vec<Frame> {
        let Self { plant, sensors, drives, .. } = self;
        drives.as_mut().map_or(Vec::new(), |drives| drives.deliver(frame, &sensors.disturbed(plant.measured())))
    }

    fn begin_tick(&mut self) {
        if let Some(drives) = &mut self.drives {
            drives.begin_tick();
        }
    }

    /// Sends commands to simulated drives, and lets them measure.
    fn exchange(&mut self, order: &Order<N>) {
        let Self { plant, sensors, drives, .. } = self;
        if let Some(drives) = drives {
            drives.send(order, &sensors.disturbed(plant.measured()));
        }
    }
}

/// The integration of the arm. Other packages call it through this interface, so that they do not compile it again for each number of joints.
trait Steps<const N: usize>: Send + Sync {
    fn drive(&self, world: &mut World<N>, torque: &[f64; N]) -> Result<(), Diverged>;

    fn rest(&self, world: &mut World<N>, order: &Order<N>) -> Result<(), Diverged>;

    fn pass(&self, world: &mut World<N>) -> Result<(), Diverged>;
}

/// [`Steps`] of the package that made the world.
#[derive(Clone, Copy)]
pub(crate) struct Compiled<const N: usize>(&'static dyn Steps<N>);

impl<const N: usize> Compiled<N> {
    /// The caller's package compiles them.
    pub(crate) fn new() -> Self {
        Self(&OneByOne)
    }
}

impl<const N: usize> fmt::Debug for Compiled<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Compiled")
    }
}

/// Integrates each arm at once.
struct OneByOne;

impl<const N: usize> Steps<N> for OneByOne {
    fn drive(&self, world: &mut World<N>, torque: &[f64; N]) -> Result<(), Diverged> {
        now(world.drive_with(Solver::AtOnce, torque))
    }

    fn rest(&self, world: &mut World<N>, order: &Order<N>) -> Result<(), Diverged> {
        now(world.rest_with(Solver::AtOnce, order))
    }

    fn pass(&self, world: &mut World<N>) -> Result<(), Diverged> {
        now(world.pass_with(Solver::AtOnce))
    }
}

/// Simulates one control period under the brakes.
fn hold<const N: usize>(plant: &mut Plant<N>, drives: &mut Drives<N>) {
    drives.rest(plant.measured());
    plant.brake();
}
