//! Solver: who lets the arm move while a run waits.
//!
//! A run is the same source whether it is alone or beside others. Its only question to the outside is where the arm is after a stretch of
//! time under one torque curve, and there it may wait: [`AtOnce`] answers arm by arm, and [`crate::run::batch`] collects the questions of
//! several runs and answers them together.

use super::actuator::Drive;
use super::integrator::{self, Plan, Step};
use super::ledger::Ledger;
use super::state::{Diverged, State, States};
use super::{LoadedArm, Rigid};
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

/// A stretch of time that an arm with rigid joints passes under one torque curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IntegrationRequest<const N: usize> {
    /// State at its start; at its end when it has been passed.
    pub(super) state: State<N>,
    pub(super) drive: Drive<N>,
    pub(super) plan: Plan,
}

impl<const N: usize> IntegrationRequest<N> {
    /// Stand where this stretch has been passed; its torques stay as they were, and to copy them costs as much as the rest.
    pub(crate) fn arrive(&mut self, passed: &Self) {
        (self.state, self.plan) = (passed.state, passed.plan);
    }
}

/// Who lets the arm move.
pub(crate) trait Solver<const N: usize> {
    /// True if a run has the time to itself, so that it can say how long it took.
    fn alone(&self) -> bool {
        false
    }

    /// Pass a stretch; after an error, the state is the last good one.
    async fn pass(
        &self,
        body: &LoadedArm<N>,
        ledger: Option<&mut Ledger<N>>,
        passage: &mut IntegrationRequest<N>,
    ) -> Result<(), Diverged>;
}

/// Lets each arm move when it is asked, without waiting.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AtOnce;

impl<const N: usize> Solver<N> for AtOnce {
    fn alone(&self) -> bool {
        true
    }

    async fn pass(
        &self,
        body: &LoadedArm<N>,
        mut ledger: Option<&mut Ledger<N>>,
        passage: &mut IntegrationRequest<N>,
    ) -> Result<(), Diverged> {
        let IntegrationRequest { state, drive, plan } = passage;
        let mut point = States::alone(state);
        let mut plans = [Some(*plan)];
        let [failed] = integrator::advance(&Rigid { body, drive }, &mut point, &mut plans, |step| {
            if let Some(ledger) = &mut ledger {
                let Step { t, h, before, after } = *step;
                let ends = [(t, before.lane(0)), (t + h, after.lane(0))];
                ledger.step(
                    h,
                    &ends.map(|(t, s)| (body.acting(&drive.at(t), &s), s)),
                    body.friction.as_ref(),
                    &body.mechanism,
                );
            }
        });
        *state = point.lane(0);
        *plan = plans[0].unwrap_or(*plan);
        failed.map_or(Ok(()), Err)
    }
}

/// Result of a future that waits for nothing, as everything under [`AtOnce`] does.
pub(crate) fn now<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(result) = future.as_mut().poll(&mut context) {
            return result;
        }
    }
}
