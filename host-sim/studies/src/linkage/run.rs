//! Motion of a closed loop under a constant moment on the crank, from its single equation of motion.

use super::turn::turned;
use dynamics_core::linkage::{Branch, CrankForm, Linkage, LinkageError};
use robot_compiler::LinkageFile;
use robot_compiler::names::name;
use serde::Serialize;

/// Smallest sine of the angle between coupler and follower (for a slider-crank, between rod and the guide's normal). The simulation stops below it,
/// because the inertia at the crank grows with the reciprocal squared.
const NEAR_DEAD: f64 = 0.02;

/// Relative energy error at which the simulation stops.
const LOST: f64 = 1e-3;

/// State of the crank and energies at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time, s.
    pub time: f64,
    /// Crank angle, rad.
    pub angle: f64,
    /// Crank speed, rad/s.
    pub speed: f64,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Potential energy, J.
    pub potential: f64,
    /// Work of the moment since the start, J.
    pub work: f64,
}

/// Initial state and inputs of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Assembly of the loop.
    pub branch: Branch,
    /// Moment on the crank, N m.
    pub moment: f64,
    /// Crank angle, rad.
    pub angle: f64,
    /// Crank speed, rad/s.
    pub speed: f64,
    /// Number of steps.
    pub steps: u32,
    /// Length of a step, s.
    pub time_step: f64,
}

/// A simulated motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// States at the start and at the end of every step.
    pub moments: Vec<Moment>,
    /// Reason why the motion ended early; `None` if it did not.
    pub stopped: Option<String>,
}

/// Summary of a motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary {
    /// Name of the linkage.
    pub linkage: String,
    /// `four-bar` or `slider-crank`.
    pub kind: &'static str,
    /// `open` or `crossed`.
    pub branch: &'static str,
    /// Moment on the crank, N m.
    pub moment: f64,
    /// Simulated time, s.
    pub duration: f64,
    /// Length of a step, s.
    pub time_step: f64,
    /// Crank angle at the start, rad.
    pub angle_start: f64,
    /// Crank angle at the end, rad, including whole turns.
    pub angle_end: f64,
    /// Crank speed at the start, rad/s.
    pub speed_start: f64,
    /// Crank speed at the end, rad/s.
    pub speed_end: f64,
    /// Least crank speed, rad/s.
    pub speed_min: f64,
    /// Greatest crank speed, rad/s.
    pub speed_max: f64,
    /// Gain of kinetic and potential energy, J.
    pub energy_gain: f64,
    /// Work of the moment, J.
    pub work: f64,
    /// Greatest difference between gain and work during the motion, J.
    pub balance_error: f64,
    /// [`RunSummary::balance_error`] divided by the greatest energy.
    pub balance_error_relative: f64,
    /// Reason why the motion ended early; `None` if it did not.
    pub stopped: Option<String>,
}

/// Simulates from the start.
///
/// # Errors
/// The start is not a valid state: the loop does not close, is at a dead point, or has no inertia.
pub fn run(linkage: &LinkageFile, start: &Start) -> Result<Run, LinkageError<f64>> {
    let form = |angle: f64| {
        let posture = linkage.mechanism.posture(&turned(angle), start.branch)?;
        let form = CrankForm::new(&posture, &posture.coefficients()?, &linkage.gravity);
        Ok::<_, LinkageError<f64>>((posture, form))
    };
    let rate = |[angle, speed]: [f64; 2]| {
        Ok::<_, LinkageError<f64>>([speed, form(angle)?.1.acceleration(start.moment, speed)?])
    };
    let moment = |time: f64, [angle, speed]: [f64; 2]| {
        let (posture, form) = form(angle)?;
        let (kinetic, potential) = (form.kinetic_energy(speed), posture.potential_energy(&linkage.gravity));
        let work = start.moment * (angle - start.angle);
        let near = (posture.transmission().abs() < NEAR_DEAD).then(|| posture.ground.dead_point());
        Ok::<_, LinkageError<f64>>((Moment { time, angle, speed, kinetic, potential, work }, near))
    };
    let mut state = [start.angle, start.speed];
    rate(state)?;
    let (first, _) = moment(0.0, state)?;
    let mut run = Run { moments: Vec::with_capacity(start.steps as usize + 1), stopped: None };
    run.moments.push(first);
    let mut greatest = first.size();
    for index in 1..=start.steps {
        let time = f64::from(index) * start.time_step;
        let next = runge_kutta(state, start.time_step, rate).and_then(|next| Ok((next, moment(time, next)?)));
        let (next, (now, near)) = match next {
            Ok(next) => next,
            Err(error) => {
                run.stopped = Some(format!("the crank came to an end of its range: {error}"));
                break;
            }
        };
        greatest = greatest.max(now.size());
        let lost = now.balance(&first).abs();
        if lost.is_nan() || lost > LOST * greatest {
            run.stopped = Some("the steps are too long: the energy is no longer that of the work".to_owned());
            break;
        }
        state = next;
        run.moments.push(now);
        if let Some(point) = near {
            run.stopped = Some(format!("a dead point is 0.02 rad away, where {point}"));
            break;
        }
    }
    Ok(run)
}

/// One step of the classical Runge-Kutta method of fourth order.
fn runge_kutta<E>(
    [angle, speed]: [f64; 2],
    step: f64,
    rate: impl Fn([f64; 2]) -> Result<[f64; 2], E>,
) -> Result<[f64; 2], E> {
    let after = |part: f64, [a, b]: [f64; 2]| [angle + part * step * a, speed + part * step * b];
    let first = rate([angle, speed])?;
    let second = rate(after(0.5, first))?;
    let third = rate(after(0.5, second))?;
    let fourth = rate(after(1.0, third))?;
    let mean = |i: usize| (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) / 6.0;
    Ok(after(1.0, [mean(0), mean(1)]))
}

impl Moment {
    /// Scale of the energy balance, J.
    fn size(&self) -> f64 {
        self.kinetic + self.potential.abs() + self.work.abs()
    }

    /// Energy balance since `first`: gain of energy minus work, J.
    fn balance(&self, first: &Self) -> f64 {
        self.kinetic + self.potential - first.kinetic - first.potential - self.work
    }
}

impl Run {
    /// Summarises a motion.
    #[must_use]
    pub fn summary(&self, linkage: &LinkageFile, start: &Start) -> RunSummary {
        let (first, last) = (self.moments[0], self.moments[self.moments.len() - 1]);
        let fold = |value: fn(&Moment) -> f64, with: fn(f64, f64) -> f64| {
            self.moments.iter().map(value).fold(value(&first), with)
        };
        let balance_error = self.moments.iter().map(|now| now.balance(&first).abs()).fold(0.0, f64::max);
        let greatest = fold(Moment::size, f64::max);
        RunSummary {
            linkage: linkage.name.clone(),
            kind: linkage.mechanism.kind(),
            branch: name(start.branch),
            moment: start.moment,
            duration: last.time,
            time_step: start.time_step,
            angle_start: first.angle,
            angle_end: last.angle,
            speed_start: first.speed,
            speed_end: last.speed,
            speed_min: fold(|now| now.speed, f64::min),
            speed_max: fold(|now| now.speed, f64::max),
            energy_gain: last.kinetic + last.potential - first.kinetic - first.potential,
            work: last.work,
            balance_error,
            balance_error_relative: if greatest > 0.0 { balance_error / greatest } else { 0.0 },
            stopped: self.stopped.clone(),
        }
    }
}
