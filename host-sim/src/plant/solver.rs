//! Solver: who solves the arm's equations of motion while a run waits.
//!
//! A run is the same source whether it is alone or beside others. Its only question to the outside is the acceleration of the arm, and there
//! it may wait: [`AtOnce`] answers state by state, and [`crate::run::batch`] collects the questions of several runs and answers them together.

use super::dynamics::Mechanism;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

/// Who solves the equations of motion.
pub(crate) trait Solver<const N: usize> {
    /// Write the joint accelerations to `qdd`; false where [`Mechanism::acceleration`] has none.
    async fn acceleration(
        &self,
        mechanism: &Mechanism<N>,
        q: &[f64; N],
        qd: &[f64; N],
        drive: &[f64; N],
        qdd: &mut [f64; N],
    ) -> bool;
}

/// Solves each state when it is asked, without waiting.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AtOnce;

impl<const N: usize> Solver<N> for AtOnce {
    #[inline]
    async fn acceleration(
        &self,
        mechanism: &Mechanism<N>,
        q: &[f64; N],
        qd: &[f64; N],
        drive: &[f64; N],
        qdd: &mut [f64; N],
    ) -> bool {
        let found = mechanism.acceleration(q, qd, drive);
        *qdd = found.unwrap_or(*qdd);
        found.is_some()
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
