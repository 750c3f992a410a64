//! `dynamics`: inverse and forward dynamics of states given as JSON lines.

use crate::cli::{DynamicsArgs, Presence, Scalar as ScalarName};
use crate::failure::Failure;
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::kinematics::tip_pose;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Real, Scene, Term, Trig, Wrench};
use nalgebra::Vector3;
use robot_compiler::{Robot, with_dof};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write, stdin, stdout};
use std::path::Path;

/// Gravity on a floor, m/s^2.
pub(crate) const FLOOR: [f64; 3] = [0.0, 0.0, -9.81];

/// A state to work on.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Joint velocity; zero if not given.
    pub qd: Option<Vec<f64>>,
    /// Joint acceleration; zero if not given.
    pub qdd: Option<Vec<f64>>,
    /// Actuator torque, to get accelerations from, N m or N.
    pub tau: Option<Vec<f64>>,
    /// Force (N) and moment (N m) of the environment on the robot at the tip's origin, in tip axes.
    pub wrench_tip: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Option<Vec<f64>>,
}

/// What there is to say about a state. Single-precision results are given as the doubles that they exactly are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// `D qdd + C qd + G - J^T w`, N m or N.
    pub tau: Vec<f64>,
    /// `G(q)`, N m or N.
    pub gravity: Vec<f64>,
    /// `C(q, qd) qd`, N m or N.
    pub coriolis_qd: Vec<f64>,
    /// `D(q)`, rows.
    pub mass_matrix: Vec<Vec<f64>>,
    /// Accelerations under the given torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub qdd: Option<Vec<f64>>,
    /// Pose of the tip in the base frame.
    pub tip: TipPose,
}

/// Pose of the tip in the base frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TipPose {
    /// `base_from_tip`, rows.
    pub rotation: [[f64; 3]; 3],
    /// Origin, m.
    pub position: [f64; 3],
}

/// Answer every line of the input on standard output.
///
/// # Errors
/// [`Failure::Input`] for a robot or a line that is wrong; the lines before it have been answered.
pub fn run(args: &DynamicsArgs) -> Result<(), Failure> {
    let robot = Robot::load(&args.robot).map_err(Failure::input)?;
    let source = name_of(&args.input);
    let input: Box<dyn BufRead> = if args.input == Path::new("-") {
        Box::new(stdin().lock())
    } else {
        let opened = File::open(&args.input);
        let file = opened.map_err(|error| Failure::Input(miette::miette!("{source} cannot be read: {error}")))?;
        Box::new(BufReader::new(file))
    };
    let mut output = BufWriter::new(stdout().lock());
    let done = with_dof!(robot.dof(), N => {
        let mut model = robot.model::<N>().map_err(Failure::input)?;
        if args.rotor == Presence::Absent {
            model = Model::from_checked(model.links().map(|link| dynamics_core::model::Link { rotor: 0.0, ..link }), *model.tip());
        }
        match args.scalar {
            ScalarName::F64 => answer_all(&model, &source, input, &mut output),
            ScalarName::F32 => answer_all(&model.cast::<f32>(), &source, input, &mut output),
        }
    });
    match (done, output.flush()) {
        // Whoever reads has seen enough, as `head` has.
        (Err(Failure::Output(error)), _) | (_, Err(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        (Err(failure), _) => Err(failure),
        (Ok(()), flushed) => flushed.map_err(Failure::Output),
    }
}

fn name_of(input: &Path) -> String {
    if input == Path::new("-") { "standard input".to_owned() } else { input.display().to_string() }
}

/// Answer every line of the input; empty ones are passed over. `source` is what errors call the input.
///
/// # Errors
/// [`Failure::Input`] with the number of the first line that is wrong; the lines before it have been answered.
/// [`Failure::Output`]: an answer cannot be written.
pub fn answer_all<S: Real, const N: usize>(
    model: &Model<S, N>,
    source: &str,
    input: impl BufRead,
    mut output: impl Write,
) -> Result<(), Failure>
where
    Libm: Trig<S>,
{
    for (index, line) in input.split(b'\n').enumerate() {
        let at = |problem: String| {
            let help = format!("expected {{\"q\": [{N} numbers], ..}}; see `host-sim dynamics --help`");
            Failure::Input(miette::miette!(help = help, "{source}, line {}: {problem}", index + 1))
        };
        let line = line.map_err(|error| at(format!("cannot be read: {error}")))?;
        let line = std::str::from_utf8(&line).map_err(|e| at(format!("byte {} is not UTF-8", e.valid_up_to() + 1)))?;
        if line.trim().is_empty() {
            continue;
        }
        let answer = read(line).and_then(|question| answer(model, &question)).map_err(at)?;
        let text = serde_json::to_string(&answer).map_err(|error| Failure::Output(error.into()))?;
        writeln!(output, "{text}").map_err(Failure::Output)?;
    }
    Ok(())
}

/// A line as a question, or what is wrong with it.
fn read(line: &str) -> Result<Question, String> {
    // serde would take a list as the fields in their order.
    if !line.trim_start().starts_with('{') {
        return Err("not a JSON object".to_owned());
    }
    serde_json::from_str(line).map_err(|error| {
        let text = error.to_string();
        // Every line is its own document: only the column is news.
        let what = text.split(" at line ").next().unwrap_or(&text);
        format!("{what} (column {})", error.column())
    })
}

/// What there is to say about one state, or what is wrong with it.
///
/// # Errors
/// A list of the wrong length, a number that the scalar cannot hold, a result that is none.
pub fn answer<S: Real, const N: usize>(model: &Model<S, N>, question: &Question) -> Result<Answer, String>
where
    Libm: Trig<S>,
{
    let joints = |name, values: &Option<Vec<f64>>| match values {
        Some(values) => numbers::<S, N>(name, values, "one for each joint"),
        None => Ok([S::zero(); N]),
    };
    let q = numbers::<S, N>("q", &question.q, "one for each joint")?;
    let (qd, qdd) = (joints("qd", &question.qd)?, joints("qdd", &question.qdd)?);
    let tau_in = question.tau.as_ref().map(|tau| numbers::<S, N>("tau", tau, "one for each joint")).transpose()?;
    let gravity = question.gravity.as_deref().unwrap_or(&FLOOR);
    let gravity = Vector3::from(numbers::<S, 3>("gravity", gravity, "gx, gy, gz")?);
    let wrench = question.wrench_tip.as_deref().unwrap_or(&[0.0; 6]);
    let [fx, fy, fz, mx, my, mz] = numbers::<S, 6>("wrench_tip", wrench, "fx, fy, fz, mx, my, mz")?;
    let wrench = Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) };

    let scene = Scene { gravity: Term::Live, tip_wrench: Term::Live, ..Scene::with_gravity(gravity, model) };
    let dynamics = Dynamics::new(*model, scene);
    let none = Live::zero();
    let weight = Live { gravity, ..none };
    let all = Live { tip_wrench: wrench, ..weight };
    let zero = [S::zero(); N];
    let turn = Libm.sin_cos_all(&q);
    let matrix = mass_matrix(&dynamics, &turn, &q, &all);
    let tip = tip_pose(model, &turn, &q);
    let accelerations = match tau_in {
        Some(tau) => Some(
            forward_dynamics(&dynamics, &turn, &q, &qd, &tau, &all)
                .map_err(|singular| format!("no accelerations follow from `tau`: {singular}"))?,
        ),
        None => None,
    };
    let answer = Answer {
        tau: list("tau", &dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &all))?,
        gravity: list("gravity", &dynamics.inverse_dynamics(&turn, &q, &zero, &zero, &weight))?,
        coriolis_qd: list("coriolis_qd", &dynamics.inverse_dynamics(&turn, &q, &qd, &zero, &none))?,
        mass_matrix: (0..N)
            .map(|i| list("mass_matrix", &core::array::from_fn::<S, N, _>(|j| matrix[(i, j)])))
            .collect::<Result<_, _>>()?,
        qdd: accelerations.map(|qdd| list("qdd", &qdd)).transpose()?,
        tip: TipPose {
            rotation: core::array::from_fn(|i| core::array::from_fn(|j| tip.rotation[(i, j)].to_f64())),
            position: core::array::from_fn(|i| tip.translation[i].to_f64()),
        },
    };
    Ok(answer)
}

/// `K` finite numbers.
pub(crate) fn numbers<S: Real, const K: usize>(name: &str, values: &[f64], meaning: &str) -> Result<[S; K], String> {
    let wrong = |_| {
        let count = |n: usize| if n == 1 { "1 number".to_owned() } else { format!("{n} numbers") };
        format!("`{name}` has {}; expected {}: {meaning}", count(values.len()), count(K))
    };
    let values: [f64; K] = values.try_into().map_err(wrong)?;
    let cast = values.map(S::literal);
    match cast.iter().position(|x| !x.is_finite()) {
        None => Ok(cast),
        Some(i) => Err(format!("entry {} of `{name}`, {:e}, is too large for the scalar", i + 1, values[i])),
    }
}

fn list<S: Real>(name: &str, values: &[S]) -> Result<Vec<f64>, String> {
    if values.iter().all(|x| x.is_finite()) {
        Ok(values.iter().map(|x| x.to_f64()).collect())
    } else {
        Err(format!("the numbers are too large: `{name}` overflows"))
    }
}
