//! Runs side by side: each at its own pace, their arms' equations of motion solved together.
//!
//! A run waits only for its arm's acceleration. When every run of a batch waits, the [kernel](crate::plant::arm_kernel) answers all of them
//! at once and they go on, whatever each is at: another tick, another stage of its integrator, another integrator. A run that ends makes
//! room for the next. Every run has the results that it has alone; only a zero may have the other sign.

use crate::plant::arm_kernel::{ArmKernel, Shape};
use crate::plant::dynamics::Mechanism;
use crate::plant::solver::{AtOnce, Solver, now};
use crate::plant::Plant;
use core::cell::RefCell;
use core::future::{Future, poll_fn};
use core::pin::Pin;
use core::task::{Context, Poll, Waker};
use std::collections::HashMap;

/// A run that waits for its arm's acceleration: whatever it computes, it computes with the solver that it is given.
pub(crate) trait Job<const N: usize> {
    /// What comes of it.
    type Outcome;

    /// The arm.
    fn plant(&self) -> &Plant<N>;

    /// Run to the end.
    async fn run(self, solver: &impl Solver<N>) -> Self::Outcome;
}

/// Kernels of the arms seen so far.
#[derive(Clone, Debug, Default)]
pub struct Batch<const N: usize> {
    kernels: HashMap<Shape, ArmKernel<N>>,
}

/// Fewest runs of a shape for which a kernel is made: it costs as much as some runs.
const WORTH_A_KERNEL: usize = 4;

impl<const N: usize> Batch<N> {
    /// Run all jobs; the outcomes in their order, and in their places those of jobs that could not be.
    pub(crate) fn run<T, E, J>(&mut self, jobs: impl IntoIterator<Item = Result<J, E>>) -> Vec<Result<T, E>>
    where
        J: Job<N, Outcome = Result<T, E>>,
    {
        let mut shapes: HashMap<Shape, Vec<(usize, J)>> = HashMap::new();
        let mut outcomes = Vec::new();
        for (place, job) in jobs.into_iter().enumerate() {
            outcomes.push(match job {
                Ok(job) => {
                    shapes.entry(job.plant().shape()).or_default().push((place, job));
                    None
                }
                Err(error) => Some(Err(error)),
            });
        }
        for (shape, jobs) in shapes {
            match self.kernel(&shape, &jobs) {
                Some(kernel) => side_by_side(kernel, jobs, &mut outcomes),
                None => {
                    for (place, job) in jobs {
                        outcomes[place] = Some(now(job.run(&AtOnce)));
                    }
                }
            }
        }
        outcomes.into_iter().flatten().collect()
    }

    fn kernel<J: Job<N>>(&mut self, shape: &Shape, jobs: &[(usize, J)]) -> Option<ArmKernel<N>> {
        if let Some(kernel) = self.kernels.get(shape) {
            return Some(kernel.clone());
        }
        let first = jobs.first().filter(|_| jobs.len() >= WORTH_A_KERNEL)?;
        let kernel = ArmKernel::new(first.1.plant())?;
        self.kernels.insert(shape.clone(), kernel.clone());
        Some(kernel)
    }
}

/// A run on its way, and the place of its outcome.
type Waiting<'a, T> = (usize, Pin<Box<dyn Future<Output = T> + 'a>>);

/// Run jobs of one shape in the lanes of its kernel.
fn side_by_side<J: Job<N>, const N: usize>(
    kernel: ArmKernel<N>,
    jobs: Vec<(usize, J)>,
    outcomes: &mut [Option<J::Outcome>],
) {
    let lanes = kernel.lanes();
    let kernel = RefCell::new(kernel);
    let mut jobs = jobs.into_iter();
    let mut start = |lane: usize| -> Option<Waiting<'_, J::Outcome>> {
        let (place, job) = jobs.next()?;
        kernel.borrow_mut().place(lane, job.plant());
        let solver = Lane { kernel: &kernel, lane };
        Some((place, Box::pin(async move { job.run(&solver).await })))
    };
    let mut running: Vec<_> = (0..lanes).map(&mut start).collect();
    let mut context = Context::from_waker(Waker::noop());
    loop {
        let mut waiting = false;
        for (lane, seat) in running.iter_mut().enumerate() {
            while let Some((place, run)) = seat {
                match run.as_mut().poll(&mut context) {
                    Poll::Pending => {
                        waiting = true;
                        break;
                    }
                    Poll::Ready(outcome) => {
                        outcomes[*place] = Some(outcome);
                        *seat = start(lane);
                    }
                }
            }
        }
        if !waiting {
            return;
        }
        kernel.borrow_mut().solve();
    }
}

/// A lane of a kernel.
struct Lane<'a, const N: usize> {
    kernel: &'a RefCell<ArmKernel<N>>,
    lane: usize,
}

impl<const N: usize> Solver<N> for Lane<'_, N> {
    async fn acceleration(
        &self,
        mechanism: &Mechanism<N>,
        q: &[f64; N],
        qd: &[f64; N],
        drive: &[f64; N],
        qdd: &mut [f64; N],
    ) -> bool {
        self.kernel.borrow_mut().ask(self.lane, q, qd, drive, mechanism.tip_wrench());
        let mut asked = false;
        poll_fn(|_| if core::mem::replace(&mut asked, true) { Poll::Ready(()) } else { Poll::Pending }).await;
        self.kernel.borrow().answer(self.lane, qdd)
    }
}
