//! dynibo in the comparison `cargo xtask bench --peers`: C functions with the signatures of `contestant.h`.
//!
//! dynibo's gravity is fixed at 9.80665 m/s^2; all other programs use 9.81. With `s^2 = 9.80665 / 9.81`, the torques of `(q, s qd, s^2 qdd)` under
//! its gravity are exactly `s^2` times those of `(q, qd, qdd)` under 9.81. The states are scaled once, before any measurement. The measured time
//! includes one additional multiplication for each result.

use dynibo::Robot;
use std::fmt::Write as _;
use std::sync::{LazyLock, Mutex, OnceLock};

const JOINTS: usize = 6;
const STATES: usize = 1024;

type ByState = [[f64; JOINTS]; STATES];

/// The first four pointers of `struct states`; other programs use the rest.
#[repr(C)]
pub struct AllStates<'a> {
    q: &'a ByState,
    qd: &'a ByState,
    qdd: &'a ByState,
    tau: &'a ByState,
}

/// `s^2`.
const SCALE: f64 = 9.80665 / 9.81;

/// Velocities, accelerations and torques that fit dynibo's gravity.
struct Scaled {
    qd: Box<ByState>,
    qdd: Box<ByState>,
    tau: Box<ByState>,
}

static SCALED: OnceLock<Scaled> = OnceLock::new();

fn scaled(states: &AllStates<'_>) -> &'static Scaled {
    let by = |all: &ByState, factor: f64| Box::new(all.map(|state| state.map(|x| factor * x)));
    SCALED.get_or_init(|| Scaled {
        qd: by(states.qd, SCALE.sqrt()),
        qdd: by(states.qdd, SCALE),
        tau: by(states.tau, SCALE),
    })
}

/// The arm of this run. If there is none, the reason is printed once.
static ARM: LazyLock<Mutex<Option<Robot>>> =
    LazyLock::new(|| Mutex::new(arm().map_err(|error| eprintln!("dynibo: PEERS_ARM: {error}")).ok()));

fn arm() -> Result<Robot, Box<dyn std::error::Error>> {
    let path = std::env::var("PEERS_ARM")?;
    let mut urdf = String::from("<robot name=\"arm\"><link name=\"link0\"/>");
    for (i, line) in std::fs::read_to_string(&path)?.lines().enumerate() {
        let n: Vec<f64> = line.split(' ').map(str::parse).collect::<Result<_, _>>()?;
        // Row by row: R = Rz(yaw) Ry(pitch) Rx(roll).
        let pitch = (-n[6]).atan2(n[0].hypot(n[3]));
        let (roll, yaw) =
            if pitch.cos() > 1e-9 { (n[7].atan2(n[8]), n[3].atan2(n[0])) } else { (0.0, (-n[1]).atan2(n[4])) };
        write!(
            urdf,
            "<link name=\"link{to}\"><inertial><origin xyz=\"{} {} {}\"/><mass value=\"{}\"/>\
             <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial></link>\
             <joint name=\"joint{to}\" type=\"continuous\"><origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>\
             <parent link=\"link{i}\"/><child link=\"link{to}\"/><axis xyz=\"0 0 1\"/></joint>",
            n[13],
            n[14],
            n[15],
            n[12],
            n[16],
            n[17],
            n[18],
            n[19],
            n[20],
            n[21],
            n[9],
            n[10],
            n[11],
            to = i + 1,
        )?;
    }
    urdf += "</robot>";
    let file = format!("{path}.urdf");
    std::fs::write(&file, urdf)?;
    Ok(Robot::from_urdf(&file)?)
}

/// Computes the results of all states; NaN if dynibo returns none, which the harness detects.
fn all(
    states: &AllStates<'_>,
    out: &mut ByState,
    one: impl Fn(&mut Robot, &Scaled, usize, &mut [f64; JOINTS]) -> bool,
) {
    let scaled = scaled(states);
    let mut arm = ARM.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    for (i, out) in out.iter_mut().enumerate() {
        let given = arm.as_mut().is_some_and(|robot| one(robot, scaled, i, out));
        *out = if given { out.map(|x| x * (1.0 / SCALE)) } else { [f64::NAN; JOINTS] };
    }
}

/// Torques.
#[unsafe(no_mangle)]
pub extern "C" fn inverse(states: &AllStates<'_>, out: &mut ByState) {
    all(states, out, |robot, scaled, i, out| {
        robot.inverse_dynamics(&states.q[i], &scaled.qd[i], &scaled.qdd[i], &[], out).is_ok()
    });
}

/// Accelerations.
#[unsafe(no_mangle)]
pub extern "C" fn forward(states: &AllStates<'_>, out: &mut ByState) {
    all(states, out, |robot, scaled, i, out| {
        robot.forward_dynamics(&states.q[i], &scaled.qd[i], &scaled.tau[i], &[], out).is_ok()
    });
}
