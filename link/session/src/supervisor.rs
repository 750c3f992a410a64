//! The safety state machine between the controller and the drives, with all its inputs.
//!
//! There is no link and no chip in here. Inputs since the tick before are kept until the tick that takes them: requests
//! and overruns for one tick, lines and readings until new ones come. A kept reading is one tick older in each tick.

use crate::readings::{JointFaults, Lines, Readings};
use crate::trajectory::{NotTaken, Trajectory};
use dynamics_core::control::{Fault, LimitFlags, Measurement, Reference, Sensed};
use dynamics_core::safety::{Inputs, Output, Request, Safety, SafetyConfiguration, State, TorqueRequest};

/// The safety state machine and its inputs. The trajectory is kept elsewhere, because it is large.
#[derive(Clone, Debug)]
pub struct Supervisor<const N: usize, K> {
    safety: Safety<f32, N, K>,
    /// State before this tick.
    before: State,
    /// The arm was stopping along its path.
    along: bool,
    /// Control period, s.
    period: f32,
    /// Inputs of the next tick: the reference too, which the trajectory puts there.
    inputs: Inputs<f32, N>,
    /// Readings have come since the last tick. Those from before it are a tick older, which is worked out only where they are used.
    read: bool,
}

impl<const N: usize, K: SafetyConfiguration<f32, N>> Supervisor<N, K> {
    /// An idle machine, before any measurement and any sign of the host.
    pub fn new(config: K) -> Self {
        let period = config.rules().period;
        Self { safety: Safety::new(config), before: State::Idle, along: false, period, inputs: silence(), read: false }
    }

    /// Back to idle. The inputs are as before any measurement and any sign of the host behind [`Supervisor::forget`].
    pub fn reset(&mut self, config: K) {
        self.safety.reset(config);
        (self.before, self.along) = (State::Idle, false);
    }

    /// Forget the inputs.
    pub fn forget(&mut self) {
        (self.inputs, self.read) = (silence(), false);
    }

    /// State of the machine.
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

    /// Heat of a joint's motor, 1 at its continuous limit; NaN where its numbers are not known.
    #[cold]
    #[inline(never)]
    pub fn heat(&self, joint: usize) -> f32 {
        let known =
            self.safety.rules().heat.as_ref().and_then(|all| all.get(joint)).is_some_and(|rules| rules.share > 0.0);
        self.safety.heat().get(joint).copied().filter(|_| known).unwrap_or(f32::NAN)
    }

    /// Inputs of the next tick; those of this tick in [`Supervisor::tick`]'s callback and until [`Supervisor::age`].
    pub fn inputs(&self) -> &Inputs<f32, N> {
        &self.inputs
    }

    /// Put a request to the next tick, in the place of any before it.
    pub fn request(&mut self, request: Request) {
        self.inputs.request = Some(request);
    }

    /// Take the request back.
    pub fn withdraw(&mut self) {
        self.inputs.request = None;
    }

    /// Another host has come: a motion of the previous one stops along its path, one that waits does not begin, an arm that is being armed is
    /// not, and a request that waits is dropped unless it stops the arm.
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

    /// The live inputs are new.
    pub fn live_came(&mut self) {
        self.inputs.live_age = 0;
    }

    /// The host is there.
    #[inline]
    pub fn heard(&mut self) {
        self.inputs.heartbeat_age = 0;
    }

    /// The tick had not ended when the next was due.
    pub fn overrun(&mut self) {
        self.inputs.overrun = true;
    }

    /// Take a board's lines.
    #[inline]
    pub fn lines(&mut self, lines: &Lines) {
        let Lines { emergency_stop, supply, temperature } = *lines;
        (self.inputs.emergency_stop, self.inputs.supply, self.inputs.temperature) =
            (emergency_stop, supply, temperature);
    }

    /// Take the readings of a board's joints.
    #[inline]
    pub fn sense(&mut self, readings: &Readings<N>) {
        self.inputs.sensed = readings.sensed;
        (self.inputs.age_ticks, self.read) = (readings.age_ticks, true);
        self.inputs.drive_fault = readings.faults.map(|faults| faults.intersects(JointFaults::OF_DRIVE));
        self.inputs.zeroed = !readings.faults.iter().any(|faults| faults.contains(JointFaults::LOST));
        self.inputs.on = readings.on;
        self.inputs.zero_lost |= readings.zero_lost;
    }

    /// Take one measurement of all joints at once.
    #[inline]
    pub fn measured(&mut self, measurement: &Measurement<f32, N>) {
        self.inputs.sensed = measurement.sensed;
        (self.inputs.age_ticks, self.read) = ([measurement.age_ticks; N], true);
    }

    /// Take drive faults, drives that are on, and if the joints know their zeros or may have lost them: in place of readings with these
    /// values.
    pub fn drives_say(&mut self, drive_fault: [bool; N], on: [bool; N], zeroed: bool, zero_lost: bool) {
        (self.inputs.drive_fault, self.inputs.on, self.inputs.zeroed) = (drive_fault, on, zeroed);
        self.inputs.zero_lost |= zero_lost;
    }

    /// Control period, s.
    pub fn period(&self) -> f32 {
        self.period
    }

    /// Take a point that starts a trajectory.
    ///
    /// # Errors
    /// [`NotTaken`]; nothing is changed.
    pub fn start(&mut self, trajectory: &mut Trajectory<N>, point: &Reference<f32, N>) -> Result<(), NotTaken> {
        match self.state() {
            State::Running => Err(NotTaken::Running),
            // The path is still needed.
            _ if self.safety.stops_along() => Err(NotTaken::Running),
            _ => trajectory.start(point, &mut self.inputs.reference),
        }
    }

    /// One tick, its output written to its place. `control` is called at most once: where torque may act. `led`: a hand leads the
    /// arm. Call [`Supervisor::age`] when its inputs are no longer needed.
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

    /// No reading has come since the last tick.
    #[cold]
    #[inline(never)]
    fn grow_old(&mut self) {
        self.inputs.age_ticks = self.inputs.age_ticks.map(|age| age.saturating_add(1));
    }

    /// Age the inputs by a tick: nothing new has come for the next one, and the trajectory goes on where it was followed.
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
            // The arm has left the trajectory, or has stopped, been disarmed or homed: the next one starts at the arm.
            trajectory.clear();
            inputs.reference = None;
        }
        (inputs.request, inputs.overrun, inputs.zero_lost) = (None, false, false);
        inputs.heartbeat_age = inputs.heartbeat_age.saturating_add(1);
        inputs.live_age = inputs.live_age.saturating_add(1);
        self.read = false;
    }
}

/// Inputs when nothing has been measured or heard yet.
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
