//! Motions worth recording: limits of a robot file, and the motion as a file.

use crate::failure::Failure;
use dynamics_core::control::trajectory::{Bounds, FourierSpec, HARMONICS_MAX, Motion, MotionError};
use dynamics_core::kinematics::{link_poses, tip_pose};
use dynamics_core::trig::Libm;
use dynamics_core::{Model, Term, Trig};
use identification::arm::Chain;
use identification::base::Base;
use identification::excite::{Room, Search, Series, Subject, excite, postures};
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use serde_json::{Value, json};

/// Share of a position range that is left free at either end.
const MARGIN: f64 = 0.05;
/// Torque limit of a joint that has none, N m or N, for the expected noise.
const TORQUE: f64 = 100.0;
/// Speed limit of a joint that has none, rad/s or m/s.
const SPEED: f64 = 1.0;
/// Rest in a posture, s, and the time from one to the next.
const REST: (f64, f64) = (1.5, 2.5);
/// Steady speeds of the slow sweeps, as shares of the allowed speed.
const SLOW: (f64, f64) = (0.05, 0.2);

/// What sort of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A Fourier series per joint.
    Series,
    /// Slow sweeps at steady speeds.
    Friction,
    /// Postures with rests.
    Static,
}

/// What is wanted: the options of `excite`.
#[derive(Clone, Debug, PartialEq)]
pub struct Wishes {
    /// What sort of motion.
    pub kind: Kind,
    /// Centre, rad or m.
    pub centre: Option<Vec<f64>>,
    /// Widest swing to either side, rad or m.
    pub swing: f64,
    /// Share of speed limits.
    pub speed: f64,
    /// Acceleration, rad/s^2 or m/s^2.
    pub acceleration: Option<f64>,
    /// Share of torque limits.
    pub torque: f64,
    /// Lowest height, m.
    pub above: Option<f64>,
    /// Period, s.
    pub period: f64,
    /// Number of periods.
    pub periods: u32,
    /// Number of harmonics.
    pub harmonics: usize,
    /// Noise of torques as a share of their limits.
    pub noise: f64,
    /// Motions to try.
    pub tries: usize,
    /// Seed.
    pub seed: u64,
}

/// A motion as a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Designed {
    /// One line for a person.
    pub line: String,
    /// The file.
    pub toml: String,
    /// What `--json` prints.
    pub json: Value,
}

/// Design a motion for the scene's arm; `tick` is called after every try.
///
/// # Errors
/// [`Failure::Input`]: a centre outside the limits, or nothing found that keeps them.
pub fn design<const N: usize>(scene: &SceneFile, wishes: &Wishes, tick: &dyn Fn()) -> Result<Designed, Failure> {
    let wrong = |expected: &str, found: String| {
        Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}"))
    };
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    let gravity = match scene.model.gravity {
        Term::Constant(gravity) => gravity,
        Term::Absent | Term::Live => scene.plant.gravity,
    };
    let room = room(&model, wishes).map_err(|found| wrong("a centre for each joint, inside its limits", found))?;
    let chain = Chain::new(model, gravity);
    let base = Base::of(&chain);
    let beta = base.of_parameters(&chain.parameters());
    let allowed = |q: &[f64]| wishes.above.is_none_or(|height| lowest(&model, &gravity, q) >= height);
    let subject = Subject { arm: &chain, base: &base, beta: beta.as_slice(), allowed: &allowed };
    let nothing = || {
        wrong(
            "a lower --above, another --centre, less --swing or more --torque",
            "no motion keeps limits and workspace".to_owned(),
        )
    };
    match wishes.kind {
        Kind::Series => {
            let search =
                Search { harmonics: wishes.harmonics, period: wishes.period, tries: wishes.tries, seed: wishes.seed };
            let series = excite(&subject, &room, &search, tick).ok_or_else(nothing)?;
            with_ramp(&model, &base, &room, wishes, &series)
                .map_err(|error| wrong("a longer --period or less --speed", error.to_string()))
        }
        Kind::Friction => Ok(sweeps(&room)),
        Kind::Static => {
            let found = postures(&subject, &room, 15, wishes.seed, tick);
            if found.len() < 4 { Err(nothing()) } else { Ok(rests(&found)) }
        }
    }
}

fn room<const N: usize>(model: &Model<f64, N>, wishes: &Wishes) -> Result<Room, String> {
    let limits: Vec<_> = model.links().iter().map(|link| link.limits).collect();
    let middle =
        |(lo, hi): (f64, f64)| if lo.is_finite() && hi.is_finite() { 0.5 * (lo + hi) } else { 0.0_f64.clamp(lo, hi) };
    let centre = wishes.centre.clone().unwrap_or_else(|| limits.iter().map(|l| middle(l.position)).collect());
    if centre.len() != N {
        return Err(format!("--centre: {} numbers for {N} joints", centre.len()));
    }
    let mut position = Vec::new();
    for (joint, (limits, q)) in limits.iter().zip(&centre).enumerate() {
        let (lo, hi) = limits.position;
        let free = if limits.range().is_finite() { MARGIN * limits.range() } else { 0.0 };
        let inside = ((lo + free).max(q - wishes.swing), (hi - free).min(q + wishes.swing));
        if !(inside.0 < *q && *q < inside.1) {
            return Err(format!("--centre: joint {} at {q}, with limits {lo} to {hi}", joint + 1));
        }
        position.push(inside);
    }
    let finite = |x: f64, otherwise: f64| if x.is_finite() { x } else { otherwise };
    let velocity: Vec<f64> = limits.iter().map(|l| wishes.speed * finite(l.velocity, SPEED)).collect();
    Ok(Room {
        centre,
        position,
        acceleration: velocity.iter().map(|v| wishes.acceleration.unwrap_or(v / wishes.speed / 0.4)).collect(),
        velocity,
        torque: limits.iter().map(|l| wishes.torque * l.torque).collect(),
        noise: limits.iter().map(|l| wishes.noise * finite(l.torque, TORQUE)).collect(),
    })
}

/// Height of the lowest of the tip and the links' origins from the third on, against gravity, m.
fn lowest<const N: usize>(model: &Model<f64, N>, gravity: &Vector3<f64>, q: &[f64]) -> f64 {
    let q: [f64; N] = core::array::from_fn(|i| q[i]);
    let turn = Libm.sin_cos_all(&q);
    let up = if gravity.norm() > 0.0 { -gravity.normalize() } else { Vector3::z() };
    let tip = tip_pose(model, &turn, &q).translation.dot(&up);
    link_poses(model, &turn, &q).iter().skip(2).map(|pose| pose.translation.dot(&up)).fold(tip, f64::min)
}

/// The series as a motion, with ramps long enough for the limits.
fn with_ramp<const N: usize>(
    model: &Model<f64, N>,
    base: &Base,
    room: &Room,
    wishes: &Wishes,
    series: &Series,
) -> Result<Designed, MotionError> {
    let bounds = Bounds::from_limits(&model.links().map(|link| link.limits));
    let harmonics = |list: &[Vec<f64>]| -> [[f64; N]; HARMONICS_MAX] {
        core::array::from_fn(|k| core::array::from_fn(|i| list.get(k).map_or(0.0, |a| round(a[i]))))
    };
    let mut ramp = 0.15 * wishes.period;
    loop {
        let spec = FourierSpec {
            centre: core::array::from_fn(|i| round(room.centre[i])),
            sine: harmonics(&series.sine),
            cosine: harmonics(&series.cosine),
            period: wishes.period,
            duration: f64::from(wishes.periods) * wishes.period + 2.0 * ramp,
            ramp,
        };
        match Motion::fourier(&spec, &bounds) {
            Ok(_) => return Ok(file(base, wishes, series, &spec)),
            Err(error) if ramp > 2.0 * wishes.period => return Err(error),
            Err(_) => ramp *= 1.4,
        }
    }
}

/// Five places: a hundredth of a milliradian.
fn round(x: f64) -> f64 {
    (x * 1e5).round() / 1e5
}

fn list(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(|x| format!("{x:.5}")).collect();
    format!("[{}]", texts.join(", "))
}

fn file<const N: usize>(base: &Base, wishes: &Wishes, series: &Series, spec: &FourierSpec<f64, N>) -> Designed {
    let line = format!(
        "Excitation: {} harmonics of {:.3} Hz, {:.1} s, condition {:.1}, seed {}.",
        wishes.harmonics,
        wishes.period.recip(),
        spec.duration,
        series.condition,
        wishes.seed
    );
    let often = f64::from(wishes.periods).sqrt();
    let deviations: Vec<f64> = series.deviations.iter().map(|d| d / often).collect();
    let notes: Vec<String> = (0..base.len()).map(|k| format!("#   {:.1e}  {}", deviations[k], base.name(k))).collect();
    let block = |name: &str, all: &[[f64; N]]| {
        let rows: Vec<String> = all[..wishes.harmonics].iter().map(|a| format!("    {},\n", list(a))).collect();
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

/// A quintic through points: position, duration of the way there, rest.
fn through(line: &str, points: &[(Vec<f64>, f64, f64)]) -> Designed {
    let point = |(index, (q, duration, dwell)): (usize, &(Vec<f64>, f64, f64))| {
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

/// There and back between the ends at two steady speeds: a quintic passes evenly spaced points at their mean speed.
fn sweeps(room: &Room) -> Designed {
    const WAY: [(f64, bool); 14] = [
        (0.0, false),
        (0.5, false),
        (1.0, false),
        (0.333, false),
        (-0.333, false),
        (-1.0, false),
        (-0.333, true),
        (0.333, true),
        (1.0, true),
        (0.333, true),
        (-0.333, true),
        (-1.0, true),
        (-0.5, false),
        (0.0, false),
    ];
    let swing: Vec<f64> =
        room.centre.iter().zip(&room.position).map(|(q, (lo, hi))| 0.6 * (q - lo).min(hi - q)).collect();
    let mut before = 0.0;
    let points: Vec<(Vec<f64>, f64, f64)> = WAY
        .iter()
        .map(|&(place, fast)| {
            let share = if fast { SLOW.1 } else { SLOW.0 };
            let needs = |(a, v): (&f64, &f64)| a * (place - before).abs() / (share * v);
            let duration = swing.iter().zip(&room.velocity).map(needs).fold(0.1, f64::max);
            before = place;
            (room.centre.iter().zip(&swing).map(|(q, a)| round(q + a * place)).collect(), duration, 0.0)
        })
        .collect();
    through("Friction: slow sweeps of all joints at two steady speeds", &points)
}

/// Postures with rests; the first is the last.
fn rests(found: &[Vec<f64>]) -> Designed {
    let mut points: Vec<(Vec<f64>, f64, f64)> =
        found.iter().map(|q| (q.iter().map(|q| round(*q)).collect(), REST.1, REST.0)).collect();
    points.extend(found.first().map(|q| (q.iter().map(|q| round(*q)).collect(), REST.1, 0.0)));
    through("Gravity: postures with rests", &points)
}
