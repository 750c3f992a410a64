//! The safety state machine between the controller and the drives, with all its inputs.
//!
//! It depends neither on the link nor on a chip. Inputs are stored until the next tick uses them: requests and overruns for one tick, lines and
//! readings until new ones arrive. A stored reading ages by one tick in each tick.

use crate::readings::{JointFaults, Lines, Readings};
use crate::trajectory::{FinitePoint, NotTaken, Trajectory};
use dynamics_core::control::{Fault, LimitFlags, Measurement, Sensed};
use dynamics_core::safety::{Inputs, Output, Request, Safety, SafetyConfiguration, State, TorqueRequest};

/// The safety state machine and its inputs. The caller holds the trajectory, because it is large.
#[derive(Clone, Debug)]
pub struct Supervisor<const N: usize, K> {
    safety: Safety<f32, N, K>,
    /// State before this tick.
    before: State,
    /// True if the arm was stopping along its path in the previous tick.
    along: bool,
    /// Control period, s.
    period: f32,
    /// Inputs of the next tick, including the reference, which the trajectory writes.
    inputs: Inputs<f32, N>,
    /// True if readings have arrived since the last tick. Older readings are aged only when a tick uses them.
    read: bool,
}

impl<const N: usize, K: SafetyConfiguration<f32, N>> Supervisor<N, K> {
    /// Creates an idle machine, before any measurement and any frame of a host.
    pub fn new(config: K) -> Self {
        let period = config.rules().period;
        Self { safety: Safety::new(config), before: State::Idle, along: false, period, inputs: silence(), read: false }
    }

    /// Resets the machine to idle. The inputs are unchanged; [`Supervisor::forget`] resets them.
    pub fn reset(&mut self, config: K) {
        self.safety.reset(config);
        (self.before, self.along) = (State::Idle, false);
    }

    /// Resets the inputs to those before any measurement and any frame of a host.
    pub fn forget(&mut self) {
        (self.inputs, self.read) = (silence(), false);
    }

    /// Returns the state of the machine.
    pub fn state(&self) -> State {
        self.safety.state()
    }

    /// True if the arm follows its path, or comes to rest along it.
    pub fn runs_or_stops(&self) -> bool {
        self.state() == State::Running || self.safety.stops_along()
    }

    /// True if the joints' zeros have been confirmed, and nothing has put them in doubt since.
    pub fn homed(&self) -> bool {
        self.safety.homed()
    }

    /// Returns the heat of a joint's motor, 1 at its continuous limit; NaN if the motor's thermal data are unknown.
    #[cold]
    #[inline(never)]
    pub fn heat(&self, joint: usize) -> f32 {
        let known =
            self.safety.rules().heat.as_ref().and_then(|all| all.get(joint)).is_some_and(|rules| rules.share > 0.0);
        self.safety.heat().get(joint).copied().filter(|_| known).unwrap_or(f32::NAN)
    }

    /// Returns the inputs of the next tick. In the callback of [`Supervisor::tick`] and until [`Supervisor::age`], these are the inputs of the
    /// current tick.
    pub fn inputs(&self) -> &Inputs<f32, N> {
        &self.inputs
    }

    /// Stores a request for the next tick, replacing an earlier one.
    pub fn request(&mut self, request: Request) {
        self.inputs.request = Some(request);
    }

    /// Removes the request.
    pub fn withdraw(&mut self) {
        self.inputs.request = None;
    }

    /// Handles a change of host. A motion of the previous host stops along its path, a motion that waits does not begin, and arming is aborted. A
    /// waiting request is dropped unless it stops the arm.
    pub fn change_host(&mut self, trajectory: &mut Trajectory<N>) {
        if self.inputs.request.is_none_or(|request| request.rank() < Request::Hold.rank()) {
            self.inputs.request = matches!(self.state(), State::Running | State::Arming).then_some(Request::Hold);
        }
        if !self.runs_or_stops() {
            trajectory.clear();
            self.inputs.reference = None;
        }
        self.heard();
    }

    /// Records that live inputs have just been set.
    pub fn live_came(&mut self) {
        self.inputs.live_age = 0;
    }

    /// Records a heartbeat of the host.
    #[inline]
    pub fn heard(&mut self) {
        self.inputs.heartbeat_age = 0;
    }

    /// Records that the tick had not ended when the next one was due.
    pub fn overrun(&mut self) {
        self.inputs.overrun = true;
    }

    /// Takes the state of a board's lines.
    #[inline]
    pub fn lines(&mut self, lines: &Lines) {
        let Lines { emergency_stop, supply, temperature } = *lines;
        (self.inputs.emergency_stop, self.inputs.supply, self.inputs.temperature) =
            (emergency_stop, supply, temperature);
    }

    /// Takes the readings of a board's joints.
    #[inline]
    pub fn sense(&mut self, readings: &Readings<N>) {
        self.inputs.sensed = readings.sensed;
        (self.inputs.age_ticks, self.read) = (readings.age_ticks, true);
        self.inputs.drive_fault = readings.faults.map(|faults| faults.intersects(JointFaults::OF_DRIVE));
        self.inputs.zeroed = !readings.faults.iter().any(|faults| faults.contains(JointFaults::LOST));
        self.inputs.on = readings.on;
        self.inputs.zero_lost |= readings.zero_lost;
    }

    /// Takes one measurement of all joints.
    #[inline]
    pub fn measured(&mut self, measurement: &Measurement<f32, N>) {
        self.inputs.sensed = measurement.sensed;
        (self.inputs.age_ticks, self.read) = ([measurement.age_ticks; N], true);
    }

    /// Takes simulated drive states instead of readings: faults, which drives are on, and whether the joints know their zeros or may have lost
    /// them.
    pub fn drives_say(&mut self, drive_fault: [bool; N], on: [bool; N], zeroed: bool, zero_lost: bool) {
        (self.inputs.drive_fault, self.inputs.on, self.inputs.zeroed) = (drive_fault, on, zeroed);
        self.inputs.zero_lost |= zero_lost;
    }

    /// Returns the control period, s.
    pub fn period(&self) -> f32 {
        self.period
    }

    /// Takes a point that starts a trajectory.
    ///
    /// # Errors
    /// [`NotTaken`]; nothing is changed.
    pub fn start(&mut self, trajectory: &mut Trajectory<N>, point: &FinitePoint<N>) -> Result<(), NotTaken> {
        match self.state() {
            State::Running => Err(NotTaken::Running),
            // The path is still needed.
            _ if self.safety.stops_along() => Err(NotTaken::Running),
            _ => {
                trajectory.start(point, &mut self.inputs.reference);
                Ok(())
            }
        }
    }

    /// Runs one tick and writes its output to `output`. Calls `control` at most once, and only if torque may act. `led`: the arm is hand guided.
    /// Call [`Supervisor::age`] when the tick's inputs are no longer needed.
    #[inline]
    pub fn tick(
        &mut self,
        output: &mut Output<f32, N>,
        led: bool,
        control: impl FnOnce(&TorqueRequest<'_, f32, N>, &mut [f32; N], &mut [LimitFlags; N]) -> Result<(), Fault>,
    ) {
        self.before = self.state();
        if !self.read {
            self.grow_old();
        }
        self.safety.tick_into(output, &self.inputs, led, control);
    }

    /// Ages the readings by a tick, because none has arrived since the last tick.
    #[cold]
    #[inline(never)]
    fn grow_old(&mut self) {
        self.inputs.age_ticks = self.inputs.age_ticks.map(|age| age.saturating_add(1));
    }

    /// Prepares the inputs of the next tick: removes those for one tick, ages the others, and advances the trajectory if it was followed.
    #[inline]
    pub fn age(&mut self, trajectory: &mut Trajectory<N>) {
        let (now, inputs) = (self.safety.state(), &mut self.inputs);
        if now == State::Running {
            trajectory.advance(&mut inputs.reference);
        } else if self.safety.stops_along() {
            let rules = self.safety.rules();
            let deceleration = |i: usize| rules.joints.get(i).map_or(0.0, |joint| joint.deceleration);
            trajectory.slow_down(&mut inputs.reference, deceleration, rules.period);
            self.along = true;
        } else if core::mem::take(&mut self.along) {
            trajectory.clear();
            inputs.reference = None;
        } else if now != self.before && !matches!(now, State::Arming | State::Armed) {
            // The arm has left the trajectory, has stopped, or was disarmed or homed: the next trajectory starts at the arm's position.
            trajectory.clear();
            inputs.reference = None;
        }
        (inputs.request, inputs.overrun, inputs.zero_lost) = (None, false, false);
        inputs.heartbeat_age = inputs.heartbeat_age.saturating_add(1);
        inputs.live_age = inputs.live_age.saturating_add(1);
        self.read = false;
    }
}

/// Inputs before any measurement and any frame of a host.
pub(crate) const fn silence<const N: usize>() -> Inputs<f32, N> {
    Inputs {
        request: None,
        emergency_stop: false,
        overrun: false,
        heartbeat_age: u32::MAX,
        zeroed: false,
        sensed: Sensed::State { q: [0.0; N], qd: [0.0; N] },
        age_ticks: [u32::MAX; N],
        drive_fault: [false; N],
        on: [false; N],
        zero_lost: false,
        live_age: u32::MAX,
        supply: None,
        temperature: None,
        reference: None,
    }
}
