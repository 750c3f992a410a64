//! An arm among boxes, above a floor.

use super::shape::{Shape, pose};
use dynamics_core::joint::JointKind;
use dynamics_core::kinematics::link_poses;
use dynamics_core::trig::Libm;
use dynamics_core::{Model, Trig};
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Number of random postures that decide if a pair is always too near.
const POSTURES: usize = 100;
/// Range of a joint without limits in these postures, rad or m.
const FREE: f64 = std::f64::consts::PI;

/// A shape that is fixed to a link, to the base, or to the world.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name for messages; shapes of one link share it.
    pub name: String,
    /// 0 for the base and the world, otherwise the number of the joint that moves it, from 1.
    pub frame: usize,
    body: Body,
    obstacle: bool,
}

#[derive(Clone, Debug)]
enum Body {
    Solid(Shape),
    /// Half-space below a height (m) along a direction, in base axes.
    Floor(Vector, f64),
}

impl Part {
    /// Shape of a link, in the model's frame of that link (z along the joint); `frame` 0 is the base.
    #[must_use]
    pub fn link(name: &str, frame: usize, shape: Shape) -> Self {
        Self { name: name.to_owned(), frame, body: Body::Solid(shape), obstacle: false }
    }

    /// An obstacle that is fixed in the base frame.
    #[must_use]
    pub fn obstacle(name: &str, shape: Shape) -> Self {
        Self { name: name.to_owned(), frame: 0, body: Body::Solid(shape), obstacle: true }
    }

    /// Floor at `height`, m, along the unit vector `up` in base axes.
    #[must_use]
    pub fn floor(up: &Vector3<f64>, height: f64) -> Self {
        let body = Body::Floor(Vector::new(up.x, up.y, up.z), height);
        Self { name: "floor".to_owned(), frame: 0, body, obstacle: true }
    }

    fn reach(&self) -> f64 {
        match &self.body {
            Body::Solid(shape) => shape.reach(),
            Body::Floor(..) => 0.0,
        }
    }
}

/// Reason why a pair of parts is not judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// They share a joint.
    Neighbours,
    /// They overlap, or are nearer than the clearance, in every posture that was tried.
    AlwaysNear,
    /// They overlap in the rest pose.
    OverlapAtRest,
}

impl Reason {
    /// Description for reports.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Neighbours => "neighbours",
            Self::AlwaysNear => "too near in every posture",
            Self::OverlapAtRest => "overlap in the rest pose",
        }
    }
}

/// Two parts that are judged.
#[derive(Clone, Debug)]
pub(crate) struct Pair<const N: usize> {
    /// Index of the part nearer to the base.
    near: usize,
    far: usize,
    /// Upper bound on the motion of a point of the far part relative to the near part, m, when a joint moves by 1 rad or 1 m.
    pub(crate) per_joint: [f64; N],
}

/// An arm and its surroundings.
#[derive(Clone, Debug)]
pub struct Cell<const N: usize> {
    model: Model<f64, N>,
    parts: Vec<Part>,
    pub(super) pairs: Vec<Pair<N>>,
    /// Names of pairs that are not judged, with the reason.
    pub exempt: Vec<(String, String, Reason)>,
}

/// Smallest gap in a posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Lower bound, m; below zero the parts overlap.
    pub gap: f64,
    /// Index of the pair; [`Cell::names`] gives its names.
    pub pair: usize,
}

impl<const N: usize> Cell<N> {
    /// Creates a cell from the parts of an arm and of its surroundings, which must keep a distance of `required`, m.
    ///
    /// Not judged are neighbours, links that are nearer than `required` in every posture tried, and links that overlap at `rest`. An obstacle is not
    /// judged against the base, because the arm stands on it, nor against the first link if that is too near in every posture.
    #[must_use]
    pub fn new(model: &Model<f64, N>, parts: Vec<Part>, rest: &[f64; N], required: f64) -> Self {
        let mut cell = Self { model: *model, parts, pairs: Vec::new(), exempt: Vec::new() };
        for near in 0..cell.parts.len() {
            for far in 0..cell.parts.len() {
                let (a, b) = (&cell.parts[near], &cell.parts[far]);
                // The far part is the one that moves; two parts of one frame never move relative to each other.
                if a.frame < b.frame {
                    cell.pairs.push(Pair { near, far, per_joint: per_joint(model, a.frame, b) });
                }
            }
        }
        let always = cell.always_near(required);
        let at_rest = cell.poses(rest);
        let reasons: Vec<Option<Reason>> = cell
            .pairs
            .iter()
            .zip(always)
            .map(|(pair, always)| {
                let (near, far) = (&cell.parts[pair.near], &cell.parts[pair.far]);
                match near.obstacle {
                    true if far.frame == 1 && always => Some(Reason::AlwaysNear),
                    true => None,
                    false if far.frame - near.frame == 1 => Some(Reason::Neighbours),
                    false if always => Some(Reason::AlwaysNear),
                    false if cell.gap_of(pair, &at_rest) <= 0.0 => Some(Reason::OverlapAtRest),
                    false => None,
                }
            })
            .collect();
        for (pair, reason) in cell.pairs.iter().zip(&reasons) {
            if let Some(reason) = reason {
                let named = (cell.parts[pair.near].name.clone(), cell.parts[pair.far].name.clone(), *reason);
                if !cell.exempt.contains(&named) {
                    cell.exempt.push(named);
                }
            }
        }
        let mut kept = reasons.iter().map(Option::is_none);
        cell.pairs.retain(|_| kept.next().unwrap_or(true));
        cell
    }

    /// True for each pair that is nearer than `required` in every posture of a random sample.
    fn always_near(&self, required: f64) -> Vec<bool> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut always = vec![true; self.pairs.len()];
        for _ in 0..POSTURES {
            let q: [f64; N] = core::array::from_fn(|i| {
                let (lo, hi) = self.model.links()[i].limits.position;
                let share = f64::from(random.next_u32()) / f64::from(u32::MAX);
                let end = |x: f64, free: f64| if x.is_finite() { x } else { free };
                end(lo, -FREE) * (1.0 - share) + end(hi, FREE) * share
            });
            let poses = self.poses(&q);
            for (always, pair) in always.iter_mut().zip(&self.pairs) {
                *always = *always && self.gap_of(pair, &poses) < required.max(f64::MIN_POSITIVE);
            }
        }
        always
    }

    /// Poses of the base and of every link.
    pub(crate) fn poses(&self, q: &[f64; N]) -> Vec<Pose> {
        let links = link_poses(&self.model, &Libm.sin_cos_all(q), q);
        let moved = links.iter().map(|place| pose(&place.rotation, &place.translation));
        std::iter::once(Pose::IDENTITY).chain(moved).collect()
    }

    /// Lower bound on the gap of a pair, m.
    pub(crate) fn gap_of(&self, pair: &Pair<N>, poses: &[Pose]) -> f64 {
        self.gap_if_below(pair, poses, f64::INFINITY)
    }

    /// Lower bound on the gap of a pair, m. If a cheaper bound is not below `enough`, returns that one.
    pub(crate) fn gap_if_below(&self, pair: &Pair<N>, poses: &[Pose], enough: f64) -> f64 {
        let (near, far) = (&self.parts[pair.near], &self.parts[pair.far]);
        match (&near.body, &far.body) {
            (Body::Solid(a), Body::Solid(b)) => {
                let (here, there) = (&poses[near.frame], &poses[far.frame]);
                let rough = a.gap_of_balls(here, b, there);
                if rough >= enough { rough } else { a.gap(here, b, there) }
            }
            (Body::Floor(up, height), Body::Solid(shape)) => shape.above(&poses[far.frame], *up, *height),
            (_, Body::Floor(..)) => f64::INFINITY,
        }
    }

    /// Smallest gap in a posture; `None` if no pair is judged.
    #[must_use]
    pub fn posture(&self, q: &[f64; N]) -> Option<Gap> {
        let poses = self.poses(q);
        let mut least: Option<Gap> = None;
        for (index, pair) in self.pairs.iter().enumerate() {
            let gap = self.gap_if_below(pair, &poses, least.map_or(f64::INFINITY, |least| least.gap));
            if least.is_none_or(|least| gap < least.gap) {
                least = Some(Gap { gap, pair: index });
            }
        }
        least
    }

    /// True if every gap in a posture is at least `required`, m.
    #[must_use]
    pub fn is_clear(&self, q: &[f64; N], required: f64) -> bool {
        let poses = self.poses(q);
        self.pairs.iter().all(|pair| self.gap_if_below(pair, &poses, required) >= required)
    }

    /// Names of the two parts of a pair.
    #[must_use]
    pub fn names(&self, pair: usize) -> (&str, &str) {
        let pair = &self.pairs[pair];
        (&self.parts[pair.near].name, &self.parts[pair.far].name)
    }
}

/// Upper bound on the motion of a point of a part relative to a frame, m, when a joint moves by 1 rad or 1 m.
///
/// A point turns about the axis of joint `k` at a radius of at most the path length from that joint to the part, plus the part's own reach. The path
/// follows the links in between; a prismatic joint in it adds its largest travel. If joint `k` is prismatic, every point moves by exactly its travel.
fn per_joint<const N: usize>(model: &Model<f64, N>, from: usize, part: &Part) -> [f64; N] {
    let links = model.links();
    let slide = |k: usize| match links[k].kind {
        JointKind::Prismatic => links[k].limits.position.0.abs().max(links[k].limits.position.1.abs()),
        JointKind::Revolute => 0.0,
    };
    core::array::from_fn(|k| {
        if k < from || k >= part.frame {
            return 0.0;
        }
        match links[k].kind {
            JointKind::Prismatic => 1.0,
            JointKind::Revolute => {
                (k + 1..part.frame).map(|m| links[m].translation.norm() + slide(m)).sum::<f64>() + part.reach()
            }
        }
    })
}
