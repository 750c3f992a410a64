//! Several runs together: each at its own pace, with their arms integrated in the lanes of one kernel.
//!
//! A run waits only for the integration of its arm over a part of a tick. When every run of a batch waits, the lanes (`plant::arm_lanes`) integrate
//! all arms at once, and the runs go on. It does not matter at which tick each run is, or which integrator it has. A run that ends is replaced by the
//! next one. Every run has the same results as alone; only a zero may have the other sign.

use crate::plant::arm_kernel::Shape;
use crate::plant::arm_lanes::{ArmLanes, LANES};
use crate::plant::solver::{IntegrationRequest, Lane, Solver, now};
use crate::plant::{Diverged, LoadedArm, Plant};
use core::cell::RefCell;
use core::future::Future;
use core::pin::Pin;
use core::task::{Context, Waker};
use std::any::Any;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// A run that waits for its arm: the solver that it is given integrates the arm.
pub(crate) trait Job<const N: usize> {
    /// Result of the call.
    type Outcome;

    /// The arm.
    fn plant(&self) -> &Plant<N>;

    /// Runs to the end.
    async fn run(self, solver: Solver<'_, N>) -> Self::Outcome;
}

/// Lanes for the arms seen so far.
#[derive(Clone, Debug, Default)]
pub struct Batch<const N: usize> {
    lanes: HashMap<Shape, ArmLanes<N>>,
}

/// Kernels that threads share, for arms with any number of joints. Each thread borrows a copy with its own memory, and gives it back with the kernels
/// that it has added.
#[derive(Debug, Default)]
pub struct Kernels(Mutex<Option<Box<dyn Any + Send>>>);

impl Kernels {
    /// A copy for arms of `N` joints.
    pub fn borrow<const N: usize>(&self) -> Batch<N> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.as_ref().and_then(|known| known.downcast_ref::<Batch<N>>()).cloned().unwrap_or_default()
    }

    /// Keeps a copy's kernels if it has more of them than are stored.
    pub fn give_back<const N: usize>(&self, batch: Batch<N>) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let held =
            known.as_ref().and_then(|known| known.downcast_ref::<Batch<N>>()).map_or(0, |known| known.lanes.len());
        if batch.lanes.len() > held {
            *known = Some(Box::new(batch));
        }
    }
}

/// Most shapes whose kernels are kept: a study has a few.
const SHAPES_MAX: usize = 64;

/// Fewest runs of a shape for which a kernel is compiled, because compilation takes as long as some runs.
const WORTH_A_KERNEL: usize = 4;

impl<const N: usize> Batch<N> {
    /// Runs all jobs. Returns the outcomes in the order of the jobs; a job that could not be created has its error there.
    pub(crate) fn run<T, E, J>(&mut self, jobs: impl IntoIterator<Item = Result<J, E>>) -> Vec<Result<T, E>>
    where
        J: Job<N, Outcome = Result<T, E>>,
    {
        let mut shapes: HashMap<Option<Shape>, Vec<(usize, J)>> = HashMap::new();
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
            match shape.and_then(|shape| self.lanes(shape, &jobs)) {
                Some(lanes) => side_by_side(lanes, jobs, &mut outcomes),
                None => {
                    for (place, job) in jobs {
                        outcomes[place] = Some(now(job.run(Solver::AtOnce)));
                    }
                }
            }
        }
        outcomes.into_iter().flatten().collect()
    }

    fn lanes<J: Job<N>>(&mut self, shape: Shape, jobs: &[(usize, J)]) -> Option<ArmLanes<N>> {
        if let Some(lanes) = self.lanes.get(&shape) {
            return Some(lanes.clone());
        }
        let (_, first) = jobs.first().filter(|_| jobs.len() >= WORTH_A_KERNEL)?;
        let lanes = ArmLanes::new(first.plant())?;
        if self.lanes.len() >= SHAPES_MAX {
            self.lanes.clear();
        }
        self.lanes.insert(shape, lanes.clone());
        Some(lanes)
    }
}

/// State that the runs of a batch share.
struct BatchState<const N: usize> {
    arms: ArmLanes<N>,
    /// Requests that wait for integration; afterwards, the completed ones.
    passages: [Option<IntegrationRequest<N>>; LANES],
    failed: [Option<Diverged>; LANES],
    solved: [u64; LANES],
}

/// A run under way, and the index of its outcome.
type Waiting<'a, T> = (usize, Pin<Box<dyn Future<Output = T> + 'a>>);

/// Runs jobs of one shape, with an arm in each lane.
fn side_by_side<J: Job<N>, const N: usize>(
    arms: ArmLanes<N>,
    jobs: Vec<(usize, J)>,
    outcomes: &mut [Option<J::Outcome>],
) {
    let (passages, failed, solved) = ([const { None }; LANES], [None; LANES], [0; LANES]);
    let meeting = RefCell::new(BatchState { arms, passages, failed, solved });
    let mut jobs = jobs.into_iter();
    let mut start = |lane: usize| -> Option<Waiting<'_, J::Outcome>> {
        let (place, job) = jobs.next()?;
        meeting.borrow_mut().arms.place(lane, job.plant());
        let own = BatchLane { meeting: &meeting, lane };
        Some((place, Box::pin(async move { job.run(Solver::InLane(&own)).await })))
    };
    let mut running: [_; LANES] = core::array::from_fn(&mut start);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        let mut waiting = false;
        for (lane, seat) in running.iter_mut().enumerate() {
            while let Some((place, run)) = seat {
                if run.as_mut().poll(&mut context).map(|outcome| outcomes[*place] = Some(outcome)).is_pending() {
                    waiting = true;
                    break;
                }
                *seat = start(lane);
            }
        }
        if !waiting {
            return;
        }
        let BatchState { arms, passages, failed, solved } = &mut *meeting.borrow_mut();
        (*failed, *solved) = arms.pass(passages);
    }
}

/// The lane of a run.
struct BatchLane<'a, const N: usize> {
    meeting: &'a RefCell<BatchState<N>>,
    lane: usize,
}

impl<const N: usize> Lane<N> for BatchLane<'_, N> {
    fn ask(&self, body: &LoadedArm<N>, request: &IntegrationRequest<N>) {
        let BatchState { arms, passages, .. } = &mut *self.meeting.borrow_mut();
        arms.push(self.lane, body.tip_wrench());
        passages[self.lane] = Some(*request);
    }

    fn take(&self, body: &LoadedArm<N>, request: &mut IntegrationRequest<N>) -> Result<(), Diverged> {
        let BatchState { passages, failed, solved, .. } = &mut *self.meeting.borrow_mut();
        if let Some(passed) = passages[self.lane].take() {
            request.arrive(&passed);
        }
        body.count(solved[self.lane]);
        failed[self.lane].map_or(Ok(()), Err)
    }
}
