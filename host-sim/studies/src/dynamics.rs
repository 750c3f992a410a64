//! Inverse and forward dynamics of states given as JSON lines.

use super::numbers::numbers;
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::kinematics::tip_pose;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::model::Link;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, JointKind, Live, Model, Real, Scene, Term, Trig, Wrench};
use nalgebra::Vector3;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{Robot, with_dof};
use serde::{Deserialize, Serialize};
use sim::failure::Failure;
use std::io::{BufRead, Read as _, Write};

/// Longest accepted line, bytes.
const LINE_MAX: usize = 64 << 10;

/// State whose dynamics are requested.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DynamicsRequest {
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Joint velocity, rad/s or m/s; zero if not given.
    pub qd: Option<Vec<f64>>,
    /// Joint acceleration, rad/s^2 or m/s^2; zero if not given.
    pub qdd: Option<Vec<f64>>,
    /// Actuator torque for forward dynamics, N m or N.
    pub tau: Option<Vec<f64>>,
    /// Force (N) and moment (N m) of the environment on the robot at the tip's origin, in tip axes.
    pub wrench_tip: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Option<Vec<f64>>,
}

/// Dynamics of a state. Single-precision results are converted to doubles exactly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DynamicsResult {
    /// Inverse dynamics `D qdd + C qd + G - J^T w`, N m or N.
    pub tau: Vec<f64>,
    /// Gravity torque `G(q)`, N m or N.
    pub gravity: Vec<f64>,
    /// Velocity torque `C(q, qd) qd`, N m or N.
    pub coriolis_qd: Vec<f64>,
    /// Rows of the mass matrix `D(q)`, kg m^2, kg m or kg.
    pub mass_matrix: Vec<Vec<f64>>,
    /// Accelerations under the given torques, rad/s^2 or m/s^2; `None` without torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub qdd: Option<Vec<f64>>,
    /// Pose of the tip in the base frame.
    pub tip: TipPose,
}

/// Pose of the tip in the base frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TipPose {
    /// Rows of the rotation matrix `base_from_tip`.
    pub rotation: [[f64; 3]; 3],
    /// Origin of the tip frame, m.
    pub position: [f64; 3],
}

/// Arm and arithmetic of the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Computation {
    /// True to include the rotors of the robot file.
    pub rotors: bool,
    /// Floating-point type to compute in.
    pub scalar: ScalarChoice,
}

/// Answers every line of the input for a robot, under the gravity of its base. See [`answer_all`].
///
/// # Errors
/// As [`answer_all`]; [`Failure::Input`] for a robot that is not possible.
pub fn answer_lines(
    robot: &Robot,
    how: Computation,
    source: &str,
    input: &mut dyn BufRead,
    output: &mut dyn Write,
) -> Result<(), Failure> {
    let floor: [f64; 3] = robot.gravity().into();
    with_dof!(robot.dof(), N => {
        let mut model = robot.model::<N>().map_err(Failure::input)?;
        if !how.rotors {
            model = Model::from_checked(model.links().map(|link| Link { rotor: 0.0, ..link }), *model.tip());
        }
        match how.scalar {
            ScalarChoice::F64 => answer_all(&model, &floor, source, input, output),
            ScalarChoice::F32 => answer_all(&model.cast::<f32>(), &floor, source, input, output),
        }
    })
}

/// Answers every line of the input and skips empty lines. `floor` is the gravity for lines that give none, m/s^2. `source` names the input in errors.
///
/// # Errors
/// [`Failure::Input`] with the number of the first invalid line; the lines before it have been answered.
/// [`Failure::Output`] if an answer cannot be written.
pub fn answer_all<S: Real, const N: usize>(
    model: &Model<S, N>,
    floor: &[f64; 3],
    source: &str,
    input: &mut dyn BufRead,
    output: &mut dyn Write,
) -> Result<(), Failure>
where
    Libm: Trig<S>,
{
    let mut line = Vec::new();
    for index in 0_usize.. {
        let at = |problem: String| {
            let help = format!("expected {{\"q\": [{N} numbers], ..}}; see `newtau help model dynamics`");
            Failure::Input(miette::miette!(help = help, "{source}, line {}: {problem}", index + 1))
        };
        line.clear();
        let count = (&mut *input).take(LINE_MAX as u64 + 1).read_until(b'\n', &mut line);
        match count.map_err(|error| at(format!("cannot be read: {error}")))? {
            0 => break,
            length if length > LINE_MAX => return Err(at(format!("longer than {LINE_MAX} bytes"))),
            _ => {}
        }
        // Windows programs may begin a text with a byte order mark.
        let text = if index == 0 { line.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&line) } else { &line };
        let line = std::str::from_utf8(text).map_err(|e| at(format!("byte {} is not UTF-8", e.valid_up_to() + 1)))?;
        let line = line.strip_suffix('\n').unwrap_or(line);
        if line.trim().is_empty() {
            continue;
        }
        let answer = read(line).and_then(|question| answer(model, floor, &question)).map_err(at)?;
        let text = serde_json::to_string(&answer).map_err(|error| Failure::Output(error.into()))?;
        writeln!(output, "{text}").map_err(Failure::Output)?;
    }
    Ok(())
}

/// Parses a line as a request; the error describes the problem.
fn read(line: &str) -> Result<DynamicsRequest, String> {
    // serde would accept a list as the fields in their order.
    if !line.trim_start().starts_with('{') {
        return Err("not a JSON object".to_owned());
    }
    serde_json::from_str(line).map_err(|error| {
        let text = error.to_string();
        // Every line is its own document, so only the column is useful.
        let what = text.split(" at line ").next().unwrap_or(&text);
        // Escape control characters, which a terminal would execute.
        let printable = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
        let shown: String = what.chars().take(200).map(printable).collect();
        format!("{shown} (column {})", error.column())
    })
}

/// Computes the dynamics of one state.
///
/// # Errors
/// A list has the wrong length, the scalar cannot hold a number, or a result is not finite.
pub fn answer<S: Real, const N: usize>(
    model: &Model<S, N>,
    floor: &[f64; 3],
    question: &DynamicsRequest,
) -> Result<DynamicsResult, String>
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
    let gravity = question.gravity.as_deref().unwrap_or(floor);
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
    let lost = model
        .links()
        .iter()
        .zip(&turn)
        .position(|(link, turn)| link.kind == JointKind::Revolute && !turn.sin.is_finite());
    if let Some(i) = lost {
        let angle = q[i].to_f64();
        return Err(format!("entry {} of `q`, {angle:e} rad, is too large for the scalar's sine and cosine", i + 1));
    }
    let matrix = mass_matrix(&dynamics, &turn, &q, &all);
    let tip = tip_pose(model, &turn, &q);
    let accelerations = match tau_in {
        Some(tau) => Some(
            forward_dynamics(&dynamics, &turn, &q, &qd, &tau, &all)
                .map_err(|singular| format!("no accelerations follow from `tau`: {singular}"))?,
        ),
        None => None,
    };
    let answer = DynamicsResult {
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

fn list<S: Real>(name: &str, values: &[S]) -> Result<Vec<f64>, String> {
    if values.iter().all(|x| x.is_finite()) {
        Ok(values.iter().map(|x| x.to_f64()).collect())
    } else {
        Err(format!("the numbers are too large: `{name}` overflows"))
    }
}
