//! A closed loop at constant crank speed: loads on its motor and joints at every step of a turn.

use dynamics_core::SinCos;
use dynamics_core::linkage::{
    Branch, CrankRange, GroundJoint, Linkage, LinkageError, LinkageForces, LinkagePosture, PlanarMotion,
};
use nalgebra::Vector2;
use robot_compiler::names::name;
use robot_compiler::{LinkageFile, Mechanism};
use serde::Serialize;
use sim::run::numbers::rms;
use std::f64::consts::{PI, TAU};

/// One step of the turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Crank angle, rad.
    pub angle: f64,
    /// Angle of the coupler (rod), rad, without jumps.
    pub coupler: f64,
    /// Angle of the follower, rad, without jumps; for a slider-crank the position of the slider's pin along the guide,
    /// m.
    pub output: f64,
    /// Positions of the links.
    pub posture: LinkagePosture<f64>,
    /// Motions of the links.
    pub motion: [PlanarMotion<f64>; 3],
    /// Forces in the joints.
    pub forces: LinkageForces<f64>,
}

/// The steps of a turn at which the loop closes and is not at a dead point.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Steps in the order of the crank's angle.
    pub steps: Vec<Step>,
    /// Number of steps at which the loop does not close.
    pub open: usize,
    /// Number of steps at dead points.
    pub dead: usize,
    /// Angle from one step to the next, rad.
    pub increment: f64,
}

/// Minimum, maximum, mean and root mean square over the steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
}

/// A crank angle at which the output reverses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeadCentre {
    /// Crank angle from 0 to one turn, rad.
    pub angle: f64,
    /// True if crank and coupler are stretched in line; otherwise they are folded.
    pub stretched: bool,
}

/// The crank angles at which the loop closes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// True if the loop closes at all angles.
    pub full_turn: bool,
    /// Otherwise the ends of the arcs from 0 to one turn, which are dead points, ascending, rad.
    pub ends: Vec<f64>,
}

/// Summary of a turn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TurnSummary {
    /// Name of the linkage.
    pub linkage: String,
    /// `four-bar` or `slider-crank`.
    pub kind: &'static str,
    /// Grashof class: which links turn fully; `None` for a slider-crank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// `open` or `crossed`.
    pub branch: &'static str,
    /// Speed of the crank, rad/s.
    pub speed: f64,
    /// Number of steps in the turn.
    pub steps: usize,
    /// Number of steps at which the loop does not close.
    pub steps_open: usize,
    /// Number of steps at dead points.
    pub steps_dead: usize,
    /// Crank angles at which the loop closes.
    pub crank_range: Range,
    /// Crank angles at which the follower or slider is momentarily at rest.
    pub dead_centres: Vec<DeadCentre>,
    /// Driving moment `M_0`, N m.
    pub driving_moment: Spread,
    /// Magnitudes of `F_0` to `F_3`, N.
    pub joint_forces: [Spread; 4],
    /// Moment of the slider on its guide, N m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide_moment: Option<Spread>,
    /// Magnitude of `F_3 - F_0`, N.
    pub shaking_force: Spread,
    /// Shaking moment about the crank's ground pivot, N m.
    pub shaking_moment: Spread,
    /// Angle of the coupler or rod, rad.
    pub coupler_angle: Spread,
    /// Angle of the follower, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub follower_angle: Option<Spread>,
    /// Position of the slider's pin, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slider_position: Option<Spread>,
    /// Smallest acute angle between coupler and follower, or between the rod and the guide's normal, rad.
    pub transmission_angle_min: f64,
}

/// Sine and cosine of an angle.
#[must_use]
pub fn turned(angle: f64) -> SinCos<f64> {
    let (sin, cos) = libm::sincos(angle);
    SinCos { sin, cos }
}

/// Turns the crank at this speed (rad/s), in this many steps.
#[must_use]
pub fn turn(linkage: &LinkageFile, branch: Branch, speed: f64, steps: u32) -> Turn {
    let increment = TAU / f64::from(steps);
    let mut turn = Turn { steps: Vec::with_capacity(steps as usize), open: 0, dead: 0, increment };
    for index in 0..steps {
        match step(linkage, branch, speed, f64::from(index) * increment) {
            Ok(step) => turn.add(step),
            Err(LinkageError::Dead(_)) => turn.dead += 1,
            Err(_) => turn.open += 1,
        }
    }
    turn
}

fn step(linkage: &LinkageFile, branch: Branch, speed: f64, angle: f64) -> Result<Step, LinkageError<f64>> {
    let posture = linkage.mechanism.posture(&turned(angle), branch)?;
    let motion = posture.coefficients()?.map(|k| k.motion(speed, 0.0));
    let forces = posture.forces(&motion, &linkage.gravity)?;
    let of = |direction: Vector2<f64>| libm::atan2(direction.y, direction.x);
    let output = match posture.ground {
        GroundJoint::Pin => of(posture.links[2].direction),
        GroundJoint::Guide => posture.links[2].outer.x,
    };
    Ok(Step { angle, coupler: of(posture.links[1].direction), output, posture, motion, forces })
}

impl Turn {
    /// Adds a step. Jumps of its angles by a full turn are removed, unless steps before it are missing.
    fn add(&mut self, mut step: Step) {
        if let Some(last) = self.steps.last().filter(|last| step.angle - last.angle < 1.5 * self.increment) {
            let onward = |angle: f64, last: f64| angle - TAU * ((angle - last) / TAU).round();
            step.coupler = onward(step.coupler, last.coupler);
            if step.posture.ground == GroundJoint::Pin {
                step.output = onward(step.output, last.output);
            }
        }
        self.steps.push(step);
    }

    /// Points of a curve over the crank's angle, with NaN where steps are missing.
    #[must_use]
    pub fn curve(&self, value: impl Fn(&Step) -> f64) -> Vec<(f64, f64)> {
        let near = |a: &Step, b: &Step| b.angle - a.angle < 1.5 * self.increment;
        let pieces = self.steps.chunk_by(near);
        let piece =
            |steps: &[Step]| -> Vec<(f64, f64)> { steps.iter().map(|step| (step.angle, value(step))).collect() };
        pieces.map(piece).collect::<Vec<_>>().join(&(f64::NAN, f64::NAN))
    }

    fn spread(&self, value: impl Fn(&Step) -> f64) -> Spread {
        let values: Vec<f64> = self.steps.iter().map(value).collect();
        Spread {
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean: values.iter().sum::<f64>() / values.len().max(1) as f64,
            rms: rms(values.iter().copied()),
        }
    }

    /// Summarises a turn with at least one step.
    #[must_use]
    pub fn summary(&self, linkage: &LinkageFile, branch: Branch, speed: f64) -> TurnSummary {
        let pin = matches!(linkage.mechanism, Mechanism::FourBar(_));
        let output = self.spread(|step| step.output);
        let sine = self.steps.iter().map(|step| step.posture.transmission().abs()).fold(1.0, f64::min);
        TurnSummary {
            linkage: linkage.name.clone(),
            kind: linkage.mechanism.kind(),
            class: match &linkage.mechanism {
                Mechanism::FourBar(four_bar) => Some(four_bar.class().to_string()),
                Mechanism::SliderCrank(_) => None,
            },
            branch: name(branch),
            speed,
            steps: self.steps.len() + self.open + self.dead,
            steps_open: self.open,
            steps_dead: self.dead,
            crank_range: range(&linkage.mechanism.crank_range()),
            dead_centres: dead_centres(&linkage.mechanism, branch),
            driving_moment: self.spread(|step| step.forces.driving_moment),
            joint_forces: core::array::from_fn(|i| self.spread(|step| step.forces.joints[i].norm())),
            guide_moment: (!pin).then(|| self.spread(|step| step.forces.guide_moment)),
            shaking_force: self.spread(|step| step.forces.shaking_force().norm()),
            shaking_moment: self.spread(|step| step.forces.shaking_moment()),
            coupler_angle: self.spread(|step| step.coupler),
            follower_angle: pin.then_some(output),
            slider_position: (!pin).then_some(output),
            transmission_angle_min: libm::asin(sine),
        }
    }
}

/// Angle from 0 to one turn, rad.
fn angle(turn: &SinCos<f64>) -> f64 {
    let angle = libm::atan2(turn.sin, turn.cos);
    if angle < 0.0 { angle + TAU } else { angle }
}

/// Converts a range to angles.
#[must_use]
pub fn range(range: &CrankRange<f64>) -> Range {
    let mut ends: Vec<f64> = range.ends().iter().flatten().map(angle).collect();
    ends.sort_by(f64::total_cmp);
    Range { full_turn: range.is_full_turn(), ends }
}

/// Dead centres within the loop's range.
fn dead_centres(mechanism: &Mechanism, branch: Branch) -> Vec<DeadCentre> {
    let [stretched, folded] = mechanism.dead_centres(branch);
    let named = |turn: Option<SinCos<f64>>, stretched| turn.map(|turn| DeadCentre { angle: angle(&turn), stretched });
    [named(stretched, true), named(folded, false)].into_iter().flatten().collect()
}

impl Range {
    /// Angle in the middle of an arc; 0 if the crank turns fully.
    #[must_use]
    pub fn middle(&self, mechanism: &Mechanism, branch: Branch) -> f64 {
        let after = self.ends.iter().skip(1).copied().chain(self.ends.first().map(|first| first + TAU));
        let middles = self.ends.iter().zip(after).map(|(from, to)| 0.5 * (from + to));
        let closes = |angle: &f64| mechanism.posture(&turned(*angle), branch).is_ok();
        middles.map(|angle| if angle > PI { angle - TAU } else { angle }).find(closes).unwrap_or(0.0)
    }
}
