//! The transition system for the checker, and readable traces.

use super::event::{Step, TAIL};
use super::judge::Rule;
use super::scene::{Numbers, Setup};
use super::state::{State, Uncounted};
use core::fmt::{Debug, Write as _};
use joint_io::frames::Frames;
use session::meter::Meter;
use stateright::{Checker, Model, Property};
use std::marker::PhantomData;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Largest number of control periods of the undisturbed session; the search begins with its states.
const NOMINAL: usize = 140;

/// The transition system of a setup.
pub struct Explorer<F, const N: usize> {
    setup: Setup,
    numbers: Numbers<N>,
    meter: Meter<Uncounted>,
    /// Rules with a reported first violation, as bits. Without this the checker would keep the last counterexample, which is a longest one.
    found: AtomicU32,
    /// Time after which no state is continued. The checker's own timeout does not end a depth-first search.
    deadline: Option<Instant>,
    /// True if the search has ended and the checker repeats paths to print them: the deadline no longer applies.
    ended: AtomicBool,
    frames: PhantomData<fn() -> F>,
}

impl<F: Frames + Clone + Debug, const N: usize> Explorer<F, N> {
    /// The transition system of a setup.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        Self {
            setup,
            numbers: Numbers::new(&setup),
            meter: Meter::new(Uncounted),
            found: AtomicU32::new(0),
            deadline: None,
            ended: AtomicBool::new(false),
            frames: PhantomData,
        }
    }

    /// False for the first state that breaks the rule.
    fn holds(&self, rule: Rule, state: &State<F, N>) -> bool {
        let bit = 1 << rule as u32;
        state.judge.holds(rule) || self.found.fetch_or(bit, Ordering::Relaxed) & bit != 0
    }

    /// True if the time of the search is over.
    fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| !self.ended.load(Ordering::Relaxed) && Instant::now() >= deadline)
    }

    /// The states of an undisturbed session, each once.
    #[must_use]
    pub fn nominal(&self) -> Vec<State<F, N>> {
        let mut states = vec![State::new(&self.setup, self.numbers)];
        while states.len() < NOMINAL {
            let next = states[states.len() - 1].next(&self.setup, &self.meter, Step::Tick);
            if states.contains(&next) {
                break;
            }
            let broken = !next.judge.all_hold();
            states.push(next);
            if broken {
                break;
            }
        }
        states
    }

    /// The next state.
    #[must_use]
    pub fn step(&self, state: &State<F, N>, step: Step) -> State<F, N> {
        state.next(&self.setup, &self.meter, step)
    }

    /// Describes a state in one line.
    #[must_use]
    pub fn line(state: &State<F, N>) -> String {
        let mut line = format!("{:?}", state.machine());
        let _ = write!(line, "{}", if state.session.homed() { ", homed" } else { "" });
        let _ = write!(line, ", brakes {}", if state.joints.brake().0 { "open" } else { "closed" });
        for (i, drive) in state.world.axes.iter().enumerate() {
            let power = match (drive.dark, drive.is_on()) {
                (0, true) => "on",
                (0, false) => "off",
                _ => "dark",
            };
            let _ =
                write!(line, "; joint {i} {power} {:.2} N m at {:.4} rad {:.3} rad/s", drive.torque, drive.q, drive.qd);
        }
        line
    }

    /// A path as text.
    #[must_use]
    pub fn trace(&self, first: &State<F, N>, steps: &[Step]) -> String {
        let phase = self.nominal().iter().position(|state| state == first).unwrap_or(usize::MAX);
        let mut text = format!("  period {phase} of the session: {}\n", Self::line(first));
        let mut state = first.clone();
        let mut ticks = 0;
        for step in steps {
            if let Step::Event(event) = step {
                state = self.step(&state, *step);
                let _ = writeln!(text, "       {event:?}");
                continue;
            }
            let periods = if *step == Step::Tail { TAIL } else { 1 };
            for _ in 0..periods {
                if !state.judge.all_hold() {
                    break;
                }
                state = self.step(&state, Step::Tick);
                ticks += 1;
                let _ = writeln!(text, "  {ticks:3}  {}", Self::line(&state));
            }
        }
        text
    }
}

impl<F: Frames + Clone + Debug, const N: usize> Model for Explorer<F, N> {
    type State = State<F, N>;
    type Action = Step;

    fn init_states(&self) -> Vec<Self::State> {
        self.nominal()
    }

    fn actions(&self, state: &Self::State, actions: &mut Vec<Step>) {
        if !state.judge.all_hold() || self.is_over() {
            return;
        }
        if state.left > 0 {
            actions.push(Step::Tick);
            state.events(&self.setup, actions);
        } else {
            actions.push(Step::Tail);
        }
    }

    fn next_state(&self, last: &Self::State, step: Step) -> Option<Self::State> {
        Some(last.next(&self.setup, &self.meter, step))
    }

    fn properties(&self) -> Vec<Property<Self>> {
        macro_rules! rules {
            ($($rule:ident),*) => {
                vec![$(Property::always(Rule::$rule.name(), |explorer: &Self, state: &State<F, N>| explorer.holds(Rule::$rule, state))),*]
            };
        }
        rules!(
            EveryRequestIsAnsweredOnce,
            TheStrongestRequestWins,
            NobodyFallsWithoutAHost,
            BrakesOpenOnlyWhenAllDrivesAreOn,
            BrakesCloseWhenADriveIsOff,
            StopWinsWithinOnePeriod,
            HomingEndsWithTheZero,
            NoOldTrajectoryRuns,
            NoJointFallsWhileArmed,
            TorqueCarriesTheArmWhenBrakesOpen
        )
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct Explored {
    /// Number of different states.
    pub states: usize,
    /// Number of steps.
    pub steps: usize,
    /// Length of the longest path from an initial state.
    pub depth: usize,
    /// Duration of the search, s.
    pub seconds: f64,
    /// True if the search is complete: there are no more states within the budget of events, at any depth.
    pub complete: bool,
    /// Broken rules, each with a path to the violation; a shortest one if the search was breadth first.
    pub broken: Vec<(&'static str, String)>,
}

impl core::fmt::Display for Explored {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { states, steps, depth, seconds, complete, broken } = self;
        let end = if *complete { "to its end" } else { "cut off" };
        write!(f, "{states} states, {steps} steps, depth {depth}, {seconds:.1} s, {end}")?;
        for (rule, trace) in broken {
            write!(f, "\nbroken: {rule}\n{trace}")?;
        }
        Ok(())
    }
}

/// Bounds of a search.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Time limit, s.
    pub seconds: u64,
    /// Number of threads.
    pub threads: usize,
    /// True for depth first: the pending states fit into memory, but a counterexample is not a shortest one. A search that is cut off has then
    /// explored all continuations of some states and none of others.
    pub depth_first: bool,
}

/// Searches a setup, breadth first unless the bounds say otherwise.
#[must_use]
pub fn explore<F: Frames + Clone + Debug + Send + Sync + 'static, const N: usize>(
    setup: Setup,
    bounds: Bounds,
) -> Explored {
    let begun = Instant::now();
    let deadline = Some(begun + Duration::from_secs(bounds.seconds));
    let builder = Explorer::<F, N> { deadline, ..Explorer::new(setup) }.checker().threads(bounds.threads);
    if bounds.depth_first {
        explored::<F, N>(setup, bounds, begun, &builder.spawn_dfs().join())
    } else {
        explored::<F, N>(setup, bounds, begun, &builder.spawn_bfs().join())
    }
}

/// Result of a search that has ended.
fn explored<F: Frames + Clone + Debug + Send + Sync + 'static, const N: usize>(
    setup: Setup,
    bounds: Bounds,
    begun: Instant,
    checker: &impl Checker<Explorer<F, N>>,
) -> Explored {
    let seconds = begun.elapsed().as_secs_f64();
    checker.model().ended.store(true, Ordering::Relaxed);
    let explorer = Explorer::<F, N>::new(setup);
    let mut broken: Vec<_> = checker
        .discoveries()
        .into_iter()
        .map(|(name, path)| {
            let all = path.into_vec();
            let steps: Vec<Step> = all.iter().filter_map(|(_, step)| *step).collect();
            (name, all.first().map_or(String::new(), |(first, _)| explorer.trace(first, &steps)))
        })
        .collect();
    broken.sort_unstable();
    Explored {
        states: checker.unique_state_count(),
        steps: checker.state_count(),
        depth: checker.max_depth(),
        seconds,
        complete: checker.is_done() && seconds < bounds.seconds as f64,
        broken,
    }
}
