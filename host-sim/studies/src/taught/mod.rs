//! Conversion of a hand-guided path to a motion: points and durations of a quintic that stays near the path.

mod path;

pub use path::Path;

use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, POINTS_MAX, Timing, Waypoint};
use robot_compiler::scene::joints;
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use std::path::Path as FilePath;

/// Largest factor by which a motion may be slowed down. If more is needed, the path does not fit this arm.
const SLOWEST: f64 = 10.0;
/// Shortest duration of a segment, s.
const SHORTEST: f64 = 0.02;

/// A motion near a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Taught {
    /// Its points, start first, rad or m.
    pub points: Vec<Vec<f64>>,
    /// Durations between them, s.
    pub durations: Vec<f64>,
    /// Largest distance of any joint from the path at the same time of the path, rad or m.
    pub error: f64,
    /// Factor by which the motion is slower than the path, so that the velocity limits hold.
    pub slower: f64,
}

impl Taught {
    /// Formats the table `[motion]` of a scene.
    #[must_use]
    pub fn toml(&self) -> String {
        let list = |q: &[f64]| q.iter().map(|q| format!("{q:.5}")).collect::<Vec<_>>().join(", ");
        let mut text = "[motion]\nkind = \"quintic\"\npoints = [\n".to_owned();
        for (index, q) in self.points.iter().enumerate() {
            text += &match index.checked_sub(1).and_then(|before| self.durations.get(before)) {
                Some(duration) => format!("    {{ q = [{}], duration = {duration:.4} }},\n", list(q)),
                None => format!("    {{ q = [{}] }},\n", list(q)),
            };
        }
        text + "]\n"
    }
}

/// Reads the path of a hand-guided arm from a log, and finds a motion near it. See [`taught`].
///
/// # Errors
/// Those of [`Path::load`] and [`taught`].
pub fn taught_from(log: &FilePath, scene: &SceneFile, tolerance: f64) -> Result<Taught, Failure> {
    with_dof!(scene.robot.dof(), N => taught::<N>(scene, &Path::load::<N>(log, scene)?, tolerance))
}

/// Finds the motion with the fewest points that stays within `tolerance` (rad or m) of the path in every joint, or the best one with [`POINTS_MAX`]
/// points.
///
/// Rests at both ends of the path are left out. Each further point is added where the motion so far is farthest from the path.
///
/// # Errors
/// [`Failure::Input`]: the path is at rest all the time, leaves the position limits by more than `tolerance`, or cannot be a motion of this arm.
pub fn taught<const N: usize>(scene: &SceneFile, path: &Path, tolerance: f64) -> Result<Taught, Failure> {
    let wrong = |problem: String| Failure::Input(miette::miette!("{}: {problem}", path.file.display()));
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    let limits = model.links().map(|link| link.limits);
    for (index, (t, q)) in path.samples.iter().enumerate() {
        for (i, limits) in limits.iter().enumerate() {
            let (lo, hi) = limits.position;
            if !(q[i] >= lo - tolerance && q[i] <= hi + tolerance) {
                let joint = &scene.robot.joints[i].name;
                let row = index + 1;
                return Err(wrong(format!(
                    "sample {row} at {t:.3} s: {joint} is at {:.4}, expected a path inside its limits, {lo} to {hi}",
                    q[i]
                )));
            }
        }
    }
    let inside = |q: &[f64]| -> [f64; N] {
        let q: [f64; N] = joints(q);
        std::array::from_fn(|i| q[i].clamp(limits[i].position.0, limits[i].position.1))
    };
    let samples: Vec<(f64, [f64; N])> = path.samples.iter().map(|(t, q)| (*t, inside(q))).collect();
    let moving = without_rests(&samples, tolerance)
        .ok_or_else(|| wrong(format!("no joint moves by more than {tolerance}; expected a path that was led")))?;
    let bounds = Bounds::from_limits(&limits);
    let mut knots = vec![0, moving.len() - 1];
    loop {
        let (motion, slower) = through(moving, &knots, &bounds).map_err(|error| wrong(error.to_string()))?;
        let (worst, error) = farthest(moving, &motion, slower);
        let place = knots.partition_point(|knot| *knot < worst);
        let apart = |a: usize, b: usize| moving[b].0 - moving[a].0 >= SHORTEST;
        // A point directly next to another one would only fit noise.
        let fits =
            knots.get(place).is_some_and(|after| place > 0 && apart(knots[place - 1], worst) && apart(worst, *after));
        if error <= tolerance || knots.len() == POINTS_MAX || !fits {
            let points = knots.iter().map(|knot| moving[*knot].1.to_vec()).collect();
            let durations = knots.windows(2).map(|pair| slower * (moving[pair[1]].0 - moving[pair[0]].0)).collect();
            return Ok(Taught { points, durations, error, slower });
        }
        knots.insert(place, worst);
    }
}

/// The path from the last sample of the rest at its start to the first sample of the rest at its end; `None` if it is at rest all the time.
fn without_rests<const N: usize>(samples: &[(f64, [f64; N])], tolerance: f64) -> Option<&[(f64, [f64; N])]> {
    let (first, last) = (samples.first()?, samples.last()?);
    let near = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.5 * tolerance);
    let start = samples.iter().position(|(_, q)| !near(q, &first.1))?.saturating_sub(1);
    let end = samples.iter().rposition(|(_, q)| !near(q, &last.1))? + 1;
    samples.get(start..=end.min(samples.len() - 1)).filter(|moving| moving.len() > 2)
}

/// The motion through these samples, slowed down until the velocity limits hold, and the factor.
fn through<const N: usize>(
    path: &[(f64, [f64; N])],
    knots: &[usize],
    bounds: &Bounds<f64, N>,
) -> Result<(Motion<f64, N>, f64), MotionError> {
    let points: Vec<Waypoint<f64, N>> = knots.iter().map(|knot| Waypoint::through(path[*knot].1)).collect();
    let mut slower = 1.0;
    loop {
        let durations: Vec<f64> = knots.windows(2).map(|pair| slower * (path[pair[1]].0 - path[pair[0]].0)).collect();
        match Motion::quintic(&points, Timing::Durations(&durations), bounds) {
            Ok(motion) => return Ok((motion, slower)),
            Err(MotionError::TooFast { .. }) if slower < SLOWEST => slower *= 1.05,
            Err(error) => return Err(error),
        }
    }
}

/// Index of the sample that is farthest from the motion, and its distance, rad or m.
fn farthest<const N: usize>(path: &[(f64, [f64; N])], motion: &Motion<f64, N>, slower: f64) -> (usize, f64) {
    let start = path[0].0;
    let distance = |(t, q): &(f64, [f64; N])| {
        let on = motion.sample(slower * (t - start)).q;
        on.iter().zip(q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let worst = path.iter().map(distance).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    worst.unwrap_or((0, 0.0))
}
