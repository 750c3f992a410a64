//! Conversion of an arm from a URDF file to a TOML robot file, which a person then completes.

use super::angles::roll_pitch_yaw;
use crate::describe::cut::{JointGaps, UrdfArm};
use crate::describe::robot::RobotJoint;
use dynamics_core::{Body, Dh, Frame, JointKind, Limits, Tool};
use nalgebra::{Matrix3, Vector3};

const HEAD: &str = "\
# Written by `newtau import`. SI units and radians; the keys stand in robots/README.md.
#
# From the URDF: placements, axes, masses, inertias, limits, friction. Fixed links are merged into the moving link that carries them.
# Every gap is marked `# ?` with its reason, and `newtau check` reports it until it is filled. What is ideal is said so: rotor = {
# inertia = 0, gear = 1 }, friction = {}, a limit of inf. Encoders and drives are for arms that a board moves.

";

const ROTOR: &str = "# ? rotor = { inertia = , gear = } # the motor's, kg m^2, and its turns per turn of the joint";
const ROTOR_SLIDE: &str =
    "# ? rotor = { inertia = , gear = } # the motor's, kg m^2, and its radians per metre of the joint";
const ENCODER: &str = "# encoder = { counts_per_turn = } # of the joint";
const ENCODER_SLIDE: &str = "# encoder = { counts_per_metre = } # of the joint";
const DRIVE: &str = "# [joint.drive] # kind = \"mit\", \"damiao\", \"robstride\", \"myactuator\" or \"pwm\": for every joint, or for none";

/// TOML text of an arm, which [`Robot::from_toml_str`](crate::Robot::from_toml_str) reads.
///
/// Lengths, masses, inertias, axes and limits read back as the same numbers. Rotations are written as roll, pitch and
/// yaw, rad, that give the same matrix. If no such angles are found, the matrix differs in the last place.
#[must_use]
pub fn robot_file(arm: &UrdfArm) -> String {
    let robot = &arm.robot;
    let mut text = HEAD.to_owned();
    text += &format!("name = {}\nsource = {}\n", quoted(&robot.name), quoted(&robot.source));
    if let Some(reason) = &robot.allow_unphysical {
        text += &format!("allow_unphysical = {}\n", quoted(reason));
    }
    if !arm.held.is_empty() {
        text += &format!("# Held still, and carried along: {}.\n", arm.held.join(", "));
    }
    text += &format!("# The arm stands on the link {}.\n", arm.base);
    if let Some(rotation) = &robot.mounting {
        let [x, y, z] = <[f64; 3]>::from(robot.gravity()).map(|g| (g * 1e4).round() / 1e4 + 0.0);
        text += &format!("# The base is turned: gravity is ({x}, {y}, {z}) m/s^2 in its frame.\n");
        text += &format!("mounting = {{ rpy = {} }}\n", vector(&roll_pitch_yaw(rotation)));
    }
    for remark in &arm.remarks {
        text += &format!("# ? {}\n", one_line(remark));
    }
    let none = JointGaps::default();
    for (i, (joint, links)) in robot.joints.iter().zip(&arm.links).enumerate() {
        text += &joint_table(joint, links, arm.gaps.get(i).unwrap_or(&none));
    }
    text + &tool_table(&robot.tool, &arm.tip)
}

fn joint_table(joint: &RobotJoint, links: &[String], gaps: &JointGaps) -> String {
    let spec = &joint.spec;
    let slides = spec.kind == JointKind::Prismatic;
    let (link, merged) = links.split_first().map_or(("", &[][..]), |(link, merged)| (link.as_str(), merged));
    let mut lines = vec![String::new(), "[[joint]]".to_owned()];
    lines.push(format!("name = {} # moves the link {link}", quoted(&joint.name)));
    if !merged.is_empty() {
        lines.push(format!("# with {}", merged.join(", ")));
    }
    lines.push(format!("type = \"{}\"", if slides { "prismatic" } else { "revolute" }));
    lines.extend(frame(&spec.frame));
    let mut body = body(&spec.body);
    if let (Some(reason), Some(mass)) = (&gaps.body, body.first_mut()) {
        *mass += &format!(" # ? {}", one_line(reason));
    }
    lines.extend(body);
    lines.push(match (spec.rotor.reflected() > 0.0, slides) {
        (true, _) => format!("rotor = {{ inertia = {:?}, gear = {:?} }}", spec.rotor.inertia, spec.rotor.gear),
        (false, slides) => {
            let line = if slides { ROTOR_SLIDE } else { ROTOR };
            gaps.gear.as_ref().map_or(line.to_owned(), |(gear, name)| {
                let line = line.replace("gear = }", &format!("gear = {gear:?} }}"));
                format!("{line}; the gear is the reduction of the transmission {}", one_line(name))
            })
        }
    });
    lines.push(joint.friction.map_or_else(
        || "# ? friction = { viscous = , coulomb = } # on the joint's side of the gear".to_owned(),
        |friction| format!("friction = {{ viscous = {:?}, coulomb = {:?} }}", friction.viscous, friction.coulomb),
    ));
    lines.push(limits(&spec.limits, gaps));
    lines.push(if slides { ENCODER_SLIDE } else { ENCODER }.to_owned());
    lines.push(DRIVE.to_owned());
    lines.join("\n") + "\n"
}

/// Writes the limits that are present, and the names of the missing ones.
fn limits(limits: &Limits<f64>, gaps: &JointGaps) -> String {
    let (lo, hi) = limits.position;
    let all = [
        (
            "position",
            gaps.position.is_none() || lo.is_finite() || hi.is_finite(),
            format!("[{}, {}]", bound(lo), bound(hi)),
        ),
        ("velocity", limits.velocity.is_finite(), bound(limits.velocity)),
        ("torque", limits.torque.is_finite(), bound(limits.torque)),
        ("torque_rate", limits.torque_rate.is_finite(), bound(limits.torque_rate)),
    ];
    let given: Vec<String> =
        all.iter().filter(|(_, there, _)| *there).map(|(key, _, value)| format!("{key} = {value}")).collect();
    let reasons = [&gaps.position, &gaps.velocity, &gaps.torque, &None];
    // Only arms with drives need a torque rate, so it never counts as missing.
    let missing = all.iter().zip(reasons).take(3).filter(|((_, there, _), reason)| !there || reason.is_some());
    let named = |((key, ..), reason): (&(&str, bool, String), &Option<String>)| {
        reason.as_ref().map_or((*key).to_owned(), |reason| format!("{key} ({})", one_line(reason)))
    };
    let missing: Vec<String> = missing.map(named).collect();
    let note = if missing.is_empty() { String::new() } else { format!(" # ? {}", missing.join(", ")) };
    format!("limits = {{ {} }}{note}", given.join(", ")).replace("{  }", "{}")
}

fn frame(frame: &Frame) -> Vec<String> {
    let row = |key: &str, dh: &Dh| {
        let Dh { a, alpha, d, theta } = dh;
        vec![format!("{key} = {{ a = {a:?}, alpha = {alpha:?}, d = {d:?}, theta = {theta:?} }}")]
    };
    match frame {
        Frame::ClassicalDh(dh) => row("dh", dh),
        Frame::ModifiedDh(dh) => row("mdh", dh),
        Frame::Placement { rotation, translation, axis } => {
            vec![placement(rotation, translation), format!("axis = {}", vector(axis.as_slice()))]
        }
    }
}

fn placement(rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> String {
    let xyz = vector(translation.as_slice());
    if *rotation == Matrix3::identity() {
        return format!("placement = {{ xyz = {xyz} }}");
    }
    format!("placement = {{ xyz = {xyz}, rpy = {} }}", vector(&roll_pitch_yaw(rotation)))
}

fn body(body: &Body) -> Vec<String> {
    let mut lines = vec![format!("mass = {:?}", body.mass)];
    if body.mass != 0.0 || body.com != Vector3::zeros() {
        lines.push(format!("com = {}", vector(body.com.as_slice())));
    }
    let i = &body.inertia;
    if *i != Matrix3::zeros() {
        let entries = [("xx", i.m11), ("yy", i.m22), ("zz", i.m33), ("xy", i.m12), ("xz", i.m13), ("yz", i.m23)];
        let there = entries.iter().enumerate().filter(|(index, (_, value))| *index < 3 || *value != 0.0);
        let list: Vec<String> = there.map(|(_, (key, value))| format!("{key} = {value:?}")).collect();
        lines.push(format!("inertia = {{ {} }}", list.join(", ")));
    }
    lines
}

fn tool_table(tool: &Tool, tip: &str) -> String {
    let mut lines = vec![String::new(), "[tool]".to_owned(), format!("# The tip frame is that of the link {tip}.")];
    lines.push(placement(&tool.rotation, &tool.translation));
    if tool.body != Body::massless() {
        lines.extend(body(&tool.body));
    }
    lines.join("\n") + "\n"
}

/// A number that may be infinite, as TOML writes it.
fn bound(x: f64) -> String {
    format!("{x:?}")
}

fn vector(numbers: &[f64]) -> String {
    format!("{numbers:?}")
}

/// Text of the URDF in a comment: names may hold line breaks.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}
