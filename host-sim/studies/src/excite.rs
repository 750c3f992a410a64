//! Design of excitation motions within the limits of a robot file and with clearance, and their output as a file.

mod judge;
mod motion;
mod request;
mod surroundings;

pub use request::{ExciteRequest, Kind};
pub use surroundings::Surroundings;

use dynamics_core::control::trajectory::{FourierSpec, MotionError};
use dynamics_core::{Model, Term};
use identification::arm::Chain;
use identification::base::Base;
use identification::excite::{FourierSeries, Room, SearchSettings, Subject, excite, postures};
use judge::Watched;
use motion::{QuinticPoint, fastest_ramp, quintic, rests, sweeps};
use nalgebra::Vector3;
use robot_compiler::{Ends, SceneFile, with_dof};
use serde_json::{Value, json};
use sim::failure::Failure;

/// Share of a position range that stays free at each end.
const MARGIN: f64 = 0.05;
/// Assumed torque limit of a joint without one, N m or N, for the expected noise.
const TORQUE: f64 = 100.0;
/// Assumed speed limit of a joint without one, rad/s or m/s.
const SPEED: f64 = 1.0;

/// A designed motion as a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Designed {
    /// One-line description.
    pub line: String,
    /// Contents of the file, TOML.
    pub toml: String,
    /// Result for `--json`.
    pub json: Value,
}

/// Designs a motion for the scene's arm, whose chain in a URDF robot has these ends; `tick` is called after every try.
///
/// # Errors
/// [`Failure::Input`]: a centre outside the limits or without clearance, shapes that cannot be read, or no motion found that keeps limits and
/// clearance.
pub fn design(
    scene: &SceneFile,
    request: &ExciteRequest,
    ends: Ends<'_>,
    tick: &dyn Fn(),
) -> Result<Designed, Failure> {
    with_dof!(scene.robot.dof(), N => design_for::<N>(scene, request, ends, tick))
}

fn design_for<const N: usize>(
    scene: &SceneFile,
    request: &ExciteRequest,
    ends: Ends<'_>,
    tick: &dyn Fn(),
) -> Result<Designed, Failure> {
    let around = &request.surroundings;
    let wrong = |expected: &str, found: String| {
        Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}"))
    };
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    let gravity = match scene.model.gravity {
        Term::Constant(gravity) => gravity,
        Term::Absent | Term::Live => scene.plant.gravity,
    };
    let room = room(&model, request).map_err(|found| wrong("a centre for each joint, inside its limits", found))?;
    let up = if gravity.norm() > 0.0 { -gravity.normalize() } else { Vector3::z() };
    let judged = surroundings::judged(scene, &model, &up, around, ends)?;
    let watched = Watched { model: &model, judged: &judged, around, centre: &room.centre, period: request.period };
    watched.check_start()?;
    let chain = Chain::new(model, gravity);
    let base = Base::of(&chain);
    let beta = base.of_parameters(&chain.parameters());
    let subject = Subject { arm: &chain, base: &base, beta: beta.as_slice(), workspace: &watched };
    let nothing = || {
        wrong(
            "another --centre, less --swing, more --torque, or less --clearance",
            format!("none of the motions tried keeps limits and clearance{}", watched.nearest_at_centre()),
        )
    };
    let no_motion = |error: MotionError| wrong("a longer --period or less --speed", error.to_string());
    let (motion, mut designed) = match request.kind() {
        Kind::Series => {
            let search = SearchSettings {
                harmonics: request.harmonics,
                period: request.period,
                tries: request.tries,
                seed: request.seed,
            };
            let series = excite(&subject, &room, &search, tick).ok_or_else(nothing)?;
            let (motion, spec) =
                fastest_ramp(&model, &room.centre, request.period, request.periods, [&series.sine, &series.cosine])
                    .map_err(no_motion)?;
            (motion, file(&base, request, &series, &spec))
        }
        Kind::Friction => {
            let tried = (0..20).map(|k| sweeps(&room, 0.6 * 0.85_f64.powi(k)));
            let clear = |points: &Vec<QuinticPoint>| {
                quintic::<N>(points).is_ok_and(|motion| judged.cell.keeps(&motion, around.clearance))
            };
            let points = tried.into_iter().find(clear).ok_or_else(nothing)?;
            let line = "Friction: slow sweeps of all joints at two steady speeds";
            (quintic(&points).map_err(no_motion)?, through(line, &points))
        }
        Kind::Static => {
            let found = postures(&subject, &room, 15, request.seed, tick);
            if found.len() < 4 {
                return Err(nothing());
            }
            let points = rests(&found);
            (quintic(&points).map_err(no_motion)?, through("Gravity: postures with rests", &points))
        }
    };
    let (comments, value) = watched.state(&motion)?;
    designed.line += comments.lines().next().map_or("", |line| line.trim_start_matches('#'));
    designed.toml = designed.toml.replacen('\n', &format!("\n{comments}"), 1);
    designed.json["clearance"] = value;
    Ok(designed)
}

fn room<const N: usize>(model: &Model<f64, N>, request: &ExciteRequest) -> Result<Room, String> {
    let limits: Vec<_> = model.links().iter().map(|link| link.limits).collect();
    let middle =
        |(lo, hi): (f64, f64)| if lo.is_finite() && hi.is_finite() { 0.5 * (lo + hi) } else { 0.0_f64.clamp(lo, hi) };
    let centre = request.centre.clone().unwrap_or_else(|| limits.iter().map(|l| middle(l.position)).collect());
    if centre.len() != N {
        return Err(format!("--centre: {} numbers for {N} joints", centre.len()));
    }
    let mut position = Vec::new();
    for (joint, (limits, q)) in limits.iter().zip(&centre).enumerate() {
        let (lo, hi) = limits.position;
        let free = if limits.range().is_finite() { MARGIN * limits.range() } else { 0.0 };
        let inside = ((lo + free).max(q - request.swing), (hi - free).min(q + request.swing));
        if !(inside.0 < *q && *q < inside.1) {
            return Err(format!("--centre: joint {} at {q}, with limits {lo} to {hi}", joint + 1));
        }
        position.push(inside);
    }
    let finite = |x: f64, otherwise: f64| if x.is_finite() { x } else { otherwise };
    let velocity: Vec<f64> = limits.iter().map(|l| request.speed * finite(l.velocity, SPEED)).collect();
    Ok(Room {
        centre,
        position,
        acceleration: velocity.iter().map(|v| request.acceleration.unwrap_or(v / request.speed / 0.4)).collect(),
        velocity,
        torque: limits.iter().map(|l| request.torque * l.torque).collect(),
        noise: limits.iter().map(|l| request.noise * finite(l.torque, TORQUE)).collect(),
    })
}

fn list(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(|x| format!("{x:.5}")).collect();
    format!("[{}]", texts.join(", "))
}

fn file<const N: usize>(
    base: &Base,
    request: &ExciteRequest,
    series: &FourierSeries,
    spec: &FourierSpec<f64, N>,
) -> Designed {
    let line = format!(
        "Excitation: {} harmonics of {:.3} Hz, {:.1} s, condition {:.1}, seed {}.",
        request.harmonics,
        request.period.recip(),
        spec.duration,
        series.condition,
        request.seed
    );
    let often = f64::from(request.periods).sqrt();
    let deviations: Vec<f64> = series.deviations.iter().map(|d| d / often).collect();
    let notes: Vec<String> = (0..base.len()).map(|k| format!("#   {:.1e}  {}", deviations[k], base.name(k))).collect();
    let block = |name: &str, all: &[[f64; N]]| {
        let rows: Vec<String> = all[..request.harmonics].iter().map(|a| format!("    {},\n", list(a))).collect();
        format!("{name} = [\n{}]\n", rows.concat())
    };
    let toml = format!(
        "# {line}\n# Deviations to be expected, kg, kg m, kg m^2:\n{}\n[motion]\nkind = \"fourier\"\ncentre = {}\nperiod = {:?}\n\
         duration = {:?}\nramp = {:?}\n{}{}",
        notes.join("\n"),
        list(&spec.centre),
        spec.period,
        spec.duration,
        spec.ramp,
        block("sine", &spec.sine),
        block("cosine", &spec.cosine),
    );
    let named: Vec<Value> =
        (0..base.len()).map(|k| json!({ "name": base.name(k), "deviation": deviations[k] })).collect();
    let json = json!({
        "condition": series.condition,
        "log_det": series.information,
        "duration": spec.duration,
        "rank": base.len(),
        "parameters": named,
    });
    Designed { line, toml, json }
}

/// Quintic segments through points, as a file.
fn through(line: &str, points: &[QuinticPoint]) -> Designed {
    let point = |(index, (q, duration, dwell)): (usize, &QuinticPoint)| {
        let way = if index == 0 { String::new() } else { format!(", duration = {duration:.3}") };
        let rest = if *dwell > 0.0 { format!(", dwell = {dwell:.3}") } else { String::new() };
        format!("    {{ q = {}{way}{rest} }},\n", list(q))
    };
    let rows: Vec<String> = points.iter().enumerate().map(point).collect();
    let total: f64 = points.iter().enumerate().map(|(k, p)| p.2 + if k == 0 { 0.0 } else { p.1 }).sum();
    let line = format!("{line}, {total:.1} s.");
    let toml = format!("# {line}\n[motion]\nkind = \"quintic\"\npoints = [\n{}]\n", rows.concat());
    Designed { json: json!({ "duration": total, "points": points.len() }), line, toml }
}
