//! Solver: the interface through which a run waits for the integration of its arm.
//!
//! A run has the same source whether it runs alone or with others. It asks only one question of the outside: the arm's state after an interval of
//! time under one torque curve. There it may wait. [`Solver::AtOnce`] integrates each arm immediately; [`crate::run::batch`] collects the requests of
//! several runs and integrates their arms together.

use super::actuator::Drive;
use super::integrator::{self, Plan, Step};
use super::ledger::Ledger;
use super::state::{Diverged, State, States};
use super::{LoadedArm, Rigid};
use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::{Context, Poll, Waker};

/// A request to integrate an arm with rigid joints over an interval of time under one torque curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IntegrationRequest<const N: usize> {
    /// State at the start of the interval; after the integration, state at its end.
    pub(super) state: State<N>,
    pub(super) drive: Drive<N>,
    pub(super) plan: Plan,
}

impl<const N: usize> IntegrationRequest<N> {
    /// Takes over state and plan of the completed request. The torques have not changed, and copying them too would take as long as the rest.
    pub(crate) fn arrive(&mut self, passed: &Self) {
        (self.state, self.plan) = (passed.state, passed.plan);
    }
}

/// A lane of a batch, which integrates several arms together.
pub(crate) trait Lane<const N: usize> {
    /// Leaves a request to the batch.
    fn ask(&self, body: &LoadedArm<N>, request: &IntegrationRequest<N>);

    /// Takes the completed request. After an error, its state is the last good one.
    fn take(&self, body: &LoadedArm<N>, request: &mut IntegrationRequest<N>) -> Result<(), Diverged>;
}

/// Integration of the arm. One type for both kinds: the loop that waits for it is compiled once.
#[derive(Clone, Copy)]
pub(crate) enum Solver<'a, const N: usize> {
    /// Integrates immediately, without waiting.
    AtOnce,
    /// Waits for a batch. An arm with a ledger is not put into a lane.
    InLane(&'a dyn Lane<N>),
}

impl<const N: usize> Solver<'_, N> {
    /// True if a run does not share its time with others, so that it can report how long it took.
    pub(crate) fn alone(self) -> bool {
        matches!(self, Self::AtOnce)
    }

    /// Integrates over an interval. After an error, the state is the last good one.
    pub(crate) async fn pass(
        self,
        body: &LoadedArm<N>,
        ledger: Option<&mut Ledger<N>>,
        request: &mut IntegrationRequest<N>,
    ) -> Result<(), Diverged> {
        match self {
            Self::AtOnce => at_once(body, ledger, request),
            Self::InLane(lane) => {
                lane.ask(body, request);
                let mut asked = false;
                poll_fn(|_| if core::mem::replace(&mut asked, true) { Poll::Ready(()) } else { Poll::Pending }).await;
                lane.take(body, request)
            }
        }
    }
}

fn at_once<const N: usize>(
    body: &LoadedArm<N>,
    mut ledger: Option<&mut Ledger<N>>,
    request: &mut IntegrationRequest<N>,
) -> Result<(), Diverged> {
    let IntegrationRequest { state, drive, plan } = request;
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

/// Result of a future that never waits, such as everything with [`Solver::AtOnce`].
pub(crate) fn now<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(result) = future.as_mut().poll(&mut context) {
            return result;
        }
    }
}
