//! A tick of the simulated arm: driven, driven in several parts, or braked.

use super::actuator::Drive;
use super::braking::{Braking, braked};
#[cfg(test)]
use super::calls;
use super::elasticity::BothSides;
use super::integrator::{self, Plan, Stretch};
use super::loaded_arm::Elastic;
use super::solver::{IntegrationRequest, Solver, now};
use super::state::{Diverged, State, States};
use super::{Clock, Plant};
use robot_compiler::scene::Push;

impl<const N: usize> Plant<N> {
    /// Sets the wrench at the tip for the tick that begins.
    fn begin_tick(&mut self) {
        let now = self.ticks;
        self.ticks += 1;
        let Some((always, Push { at, duration, wrench })) = self.push else { return };
        let tick = |t: f64| (t / self.clock.period).round() as u64;
        let pushes = (tick(at)..tick(at + duration)).contains(&now);
        let both = || always.map_or(wrench, |always| always + wrench);
        self.body.mechanism.push(if pushes { Some(both()) } else { always });
    }

    /// Simulates one control period with this constant torque command (before the actuators' effects), and with released brakes.
    ///
    /// # Errors
    /// [`Diverged`] if the motion cannot be continued; the state is then the last good one.
    pub fn drive(&mut self, torque: &[f64; N]) -> Result<(), Diverged> {
        now(self.drive_with(Solver::AtOnce, torque))
    }

    /// As [`Plant::drive`], with this solver.
    pub(crate) async fn drive_with(&mut self, solver: Solver<'_, N>, torque: &[f64; N]) -> Result<(), Diverged> {
        self.begin_tick();
        if self.brake.take().is_some() {
            self.actuators.released();
        }
        let Clock { period, steps_per_tick } = self.clock;
        let (acts, samples) = (self.acts(), self.samples());
        let (before, drive) = self.actuators.drive(torque, period, acts.unwrap_or(0.0));
        if acts.is_none() && samples.is_none() {
            return self.pass(solver, &drive, Stretch { from: 0.0, to: period, steps: steps_per_tick }).await;
        }
        let acts = acts.unwrap_or(0.0);
        let mut from = 0.0;
        let mut events = [(acts, false), (samples.unwrap_or(period), samples.is_some()), (period, false)];
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (to, sample) in events {
            if to > from {
                // A part of a step counts as a step; a rounding error does not.
                let steps = libm::ceil((to - from) / self.clock.step() - 1e-9).max(1.0) as u32;
                self.pass(solver, if from < acts { &before } else { &drive }, Stretch { from, to, steps }).await?;
                from = to;
            }
            if sample {
                self.sampled = Some(*self.seen());
            }
        }
        Ok(())
    }

    /// Simulates one control period in which the drives update their torque `times` times: `renew` returns it for the state that the drives measure
    /// and for a duration (s). The brakes are released.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn drive_renewed(&mut self, times: u32, renew: impl FnMut(&State<N>, f64) -> [f64; N]) -> Result<(), Diverged> {
        now(self.drive_by(Solver::AtOnce, times, renew))
    }

    /// As [`Plant::drive_renewed`], with this solver.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub(crate) async fn drive_by(
        &mut self,
        solver: Solver<'_, N>,
        times: u32,
        mut renew: impl FnMut(&State<N>, f64) -> [f64; N],
    ) -> Result<(), Diverged> {
        self.begin_tick();
        if self.brake.take().is_some() {
            self.actuators.released();
        }
        let Clock { period, steps_per_tick } = self.clock;
        let instant = |turn: u32| period * f64::from(turn) / f64::from(times);
        for turn in 0..times {
            let (from, to) = (instant(turn), instant(turn + 1));
            let torque = renew(self.seen(), to - from);
            // The curve refers to the time of the last tick, so it is shifted only once per tick.
            let (_, drive) = self.actuators.drive(&torque, if turn == 0 { period } else { 0.0 }, from);
            self.pass(solver, &drive, Stretch { from, to, steps: steps_per_tick.div_ceil(times) }).await?;
        }
        Ok(())
    }

    /// As [`Plant::drive_by`], but not counted in the ledger, because the drives stop the arm.
    pub(crate) async fn stop_by(
        &mut self,
        solver: Solver<'_, N>,
        times: u32,
        renew: impl FnMut(&State<N>, f64) -> [f64; N],
    ) -> Result<(), Diverged> {
        let ledger = self.ledger.take();
        let passed = self.drive_by(solver, times, renew).await;
        self.ledger = ledger;
        passed
    }

    /// The instant at which a new torque takes effect, s into the tick.
    fn acts(&mut self) -> Option<f64> {
        let jitter = self.acting.as_mut()?;
        #[cfg(test)]
        calls::count(calls::Effect::ActuatorJitter);
        Some(jitter.draw())
    }

    /// The instant of the next tick's measurement, s into this one.
    fn samples(&mut self) -> Option<f64> {
        let jitter = self.sampling.as_mut()?;
        #[cfg(test)]
        calls::count(calls::Effect::SensorJitter);
        Some(self.clock.period - jitter.draw())
    }

    /// Simulates a part of a tick.
    async fn pass(&mut self, solver: Solver<'_, N>, drive: &Drive<N>, stretch: Stretch) -> Result<(), Diverged> {
        let Self { body, integrator, next_step, state, motors, ledger, .. } = self;
        let plan = Plan { integrator: *integrator, stretch, next: *next_step };
        if let Some(motors) = motors {
            let mut pair = BothSides { link: States::alone(state), motor: States::alone(&motors.state) };
            let (flow, mut plans) = (Elastic { body, motors: &*motors, drive }, [Some(plan)]);
            let [failed] = integrator::advance(&flow, &mut pair, &mut plans, |_| ());
            (*state, motors.state) = (pair.link.lane(0), pair.motor.lane(0));
            *next_step = plans[0].map_or(*next_step, |plan| plan.next);
            return failed.map_or(Ok(()), Err);
        }
        let mut passage = IntegrationRequest { state: *state, drive: *drive, plan };
        let passed = solver.pass(body, ledger.as_mut(), &mut passage).await;
        (*state, *next_step) = (passage.state, passage.plan.next);
        passed
    }

    /// Simulates one control period with the drives off and the brakes engaged. The arm decelerates from its state at the first such call, until it
    /// is driven again.
    pub fn brake(&mut self) {
        self.begin_tick();
        let (from, motor_from) = (self.state, self.motors().copied());
        let brake = self.brake.get_or_insert(Braking { from, motor_from, ticks: 0 });
        let begin = f64::from(brake.ticks) * self.clock.period;
        brake.ticks += 1;
        let end = f64::from(brake.ticks) * self.clock.period;
        if let Some(samples) = self.samples() {
            self.slow_down(begin + samples);
            self.sampled = Some(*self.seen());
        }
        self.slow_down(end);
    }

    /// Sets the state at `t` (s) after the brakes have engaged.
    fn slow_down(&mut self, t: f64) {
        let Some(brake) = &self.brake else {
            return;
        };
        self.state = braked(&brake.from, t);
        if let (Some(motors), Some(from)) = (&mut self.motors, &brake.motor_from) {
            motors.state = braked(from, t);
        }
    }
}
