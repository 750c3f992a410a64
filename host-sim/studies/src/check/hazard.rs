//! Hazard figures of an arm for a person near it: mass, speed, force, and stopping distance.
//!
//! They follow from the limits of the robot file and the settings of a scene. **These limits are software**: a fault of the software, the board or a
//! drive may exceed them.

use crate::numbers::digits;
use crate::posture_search::{ROUGH, minimise_to, ranges};
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::statics::holding_torque;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::safety::SafeAction;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, JointKind, Trig, Wrench};
use nalgebra::{SVector, Vector3};
use robot_compiler::SceneFile;
use robot_compiler::scene::{axis_to_tip, joints};
use serde::Serialize;

/// Class I of ISO 10218-1:2025: mass, kg, force, N, and tip speed, m/s, that the manipulator itself can reach, **not limited by robot or safety
/// functions**. Source: "New Standards for Industrial Robots", Dit, Inail, ESREL 2025, paper P3635.
pub const CLASS_I: (f64, f64, f64) = (10.0, 50.0, 0.25);

/// Hazard figures. `None` means unbounded, because a joint lacks the limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hazard {
    /// Name of the scene; `None` for the default scene.
    pub scene: Option<String>,
    /// Mass of all moving parts, including the scene's payload, kg.
    pub moving_mass: f64,
    /// Greatest tip speed found with all joints within their velocity limits, m/s.
    pub tip_speed: Option<f64>,
    /// Upper bound of the tip speed in any posture, m/s.
    pub tip_speed_bound: Option<f64>,
    /// Greatest kinetic energy found with all joints within their velocity limits, including rotors, J.
    pub kinetic_energy: Option<f64>,
    /// Greatest static force of the tip within the torque limits, N, where the scene's motion starts, along a direction in which one joint moves the
    /// tip. Along a direction in which a stretched or folded arm cannot move, the force has no upper bound.
    pub tip_force: Option<f64>,
    /// Longest time from an event to the torque that reacts to it, s.
    pub reaction_time: f64,
    /// Longest time from an event to rest, s.
    pub stopping_time: Option<f64>,
    /// Upper bound of the tip's path from an event to rest, m.
    pub stopping_distance: Option<f64>,
    /// Time that the brakes need to engage, s; 0 without brakes. If the scene specifies 0, which no brake reaches, the time of slow brakes.
    pub brake_delay: f64,
    /// True if `brake_delay` is assumed, not specified.
    pub brake_delay_assumed: bool,
    /// Distance that gravity alone moves each joint from rest in that time, in its worst posture found, rad or m.
    pub sag: Vec<f64>,
    /// Joint that can hold the least undeclared mass at the tip in the first motion after homing: its index and that mass, kg. `None` without a
    /// scene, or without limits of the first motion.
    pub undeclared: Option<(usize, f64)>,
}

/// Assumed engaging time of unknown brakes, s.
const BRAKE_DELAY: f64 = 0.1;

/// Computes the figures of a scene's arm under this gravity; `None` if no model can be made of the arm.
pub(super) fn hazard<const N: usize>(
    file: &SceneFile,
    scene: Option<String>,
    gravity: &Vector3<f64>,
) -> Option<Hazard> {
    let model = file.robot.model::<N>().ok()?;
    let chain = Chain::new(&model, &Inertia::zero());
    let limits = model.links().map(|link| link.limits);
    let (bounds, middle) = ranges(&model);
    let posture = |q: &[f64; N]| chain.posture(&Libm.sin_cos_all(q), q);
    let velocity = finite(limits.map(|limits| limits.velocity));
    let reach = axis_to_tip(&model);
    let bounded = reach.iter().all(|reach| reach.is_finite());
    let tip_speed = velocity.map(|velocity| {
        let speed = |q: &[f64; N]| {
            let columns = columns(&posture(q));
            most(|signs: &[f64; N]| (0..N).map(|i| columns[i] * (signs[i] * velocity[i])).sum::<Vector3<f64>>().norm())
        };
        -minimise_to(ROUGH, &bounds, &middle, |q| -speed(q)).value
    });
    let kinetic_energy = velocity.map(|velocity| {
        let (dynamics, live) = (Dynamics::new(model, file.scene(&model)), file.live(&model));
        let energy = |q: &[f64; N]| {
            let mass = mass_matrix(&dynamics, &Libm.sin_cos_all(q), q, &live);
            most(|signs: &[f64; N]| {
                let qd = SVector::<f64, N>::from_fn(|i, _| signs[i] * velocity[i]);
                0.5 * (qd.transpose() * mass * qd)[(0, 0)]
            })
        };
        -minimise_to(ROUGH, &bounds, &middle, |q| -energy(q)).value
    });
    let tip_force = finite(limits.map(|limits| limits.torque)).map(|torque| {
        let posture = posture(&joints(file.motion.start()));
        let gravity = holding_torque(&posture, gravity, &Wrench::zero());
        let columns = columns(&posture);
        let force = |u: &Vector3<f64>| {
            let of_joint = |i: usize| (torque[i] + gravity[i].abs()) / columns[i].dot(u).abs();
            (0..N).map(of_joint).fold(f64::INFINITY, f64::min)
        };
        let directions = columns.iter().filter_map(|column| column.try_normalize(f64::MIN_POSITIVE));
        directions.map(|u| force(&u)).filter(|force| force.is_finite()).fold(0.0, f64::max)
    });
    let reaction_time = reaction_time(file);
    // The default scene does not specify brakes; an arm with a rest pose most likely has none.
    let has_brakes = file.safety.safe_action == SafeAction::Brake && (scene.is_some() || file.safety.rest.is_none());
    let brake_delay_assumed = !file.safety.brake_delay_given || file.safety.brake_delay == 0.0;
    let brake_delay = match (has_brakes, file.safety.brake_delay) {
        (false, _) => 0.0,
        (true, 0.0) => BRAKE_DELAY,
        (true, delay) => delay,
    };
    let sag = if brake_delay > 0.0 {
        let (dynamics, live) = (Dynamics::new(model, file.scene(&model)), file.live(&model));
        let acceleration = |q: &[f64; N], i: usize| {
            let mass = mass_matrix(&dynamics, &Libm.sin_cos_all(q), q, &live);
            let weight = SVector::<f64, N>::from(holding_torque(&posture(q), gravity, &Wrench::zero()));
            mass.cholesky().map_or(0.0, |mass| mass.solve(&weight)[i].abs())
        };
        let worst = |i: usize| -minimise_to(ROUGH, &bounds, &middle, |q| -acceleration(q, i)).value;
        (0..N).map(|i| 0.5 * worst(i) * brake_delay * brake_delay).collect()
    } else {
        Vec::new()
    };
    let undeclared = file.safety.first_motion.filter(|_| scene.is_some()).and_then(|share| {
        let torque = finite(limits.map(|limits| limits.torque))?;
        // Torque per kilogram at the tip, as a share of the torque that remains for it.
        let load = |q: &[f64; N], i: usize| {
            let posture = posture(q);
            let weight = holding_torque(&posture, gravity, &Wrench::zero())[i].abs();
            let left = (share * torque[i]).min(torque[i] - weight).max(f64::MIN_POSITIVE);
            columns(&posture)[i].dot(gravity).abs() / left
        };
        let masses = (0..N).map(|i| (i, -1.0 / minimise_to(ROUGH, &bounds, &middle, |q| -load(q, i)).value));
        masses.filter(|(_, mass)| mass.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    });
    let deceleration: [f64; N] = joints(&file.safety.deceleration);
    let stopping = velocity.map(|velocity| {
        let way = |i: usize| velocity[i] * reaction_time + 0.5 * velocity[i] * velocity[i] / deceleration[i];
        let time = (0..N).map(|i| velocity[i] / deceleration[i]).fold(0.0, f64::max);
        (reaction_time + time, (0..N).map(|i| reach[i] * way(i)).sum::<f64>())
    });
    Some(Hazard {
        scene,
        moving_mass: moving_mass(file),
        tip_speed,
        tip_speed_bound: velocity.filter(|_| bounded).map(|v| (0..N).map(|i| reach[i] * v[i]).sum()),
        kinetic_energy,
        tip_force,
        reaction_time,
        stopping_time: stopping.map(|(time, _)| time),
        stopping_distance: stopping.filter(|_| bounded).map(|(_, way)| way),
        brake_delay,
        brake_delay_assumed,
        sag,
        undeclared,
    })
}

/// Mass of the links, the tool and the scene's true payload, kg.
fn moving_mass(file: &SceneFile) -> f64 {
    let links: f64 = file.robot.joints.iter().map(|joint| joint.spec.body.mass).sum();
    links + file.robot.tool.body.mass + file.plant.payload.map_or(0.0, |body| body.mass)
}

/// Reaction time, s: `age_max` ticks in which an old measurement may be used, one tick until the next decision, one tick for the reply of a CAN
/// drive, and the latency of the torque.
fn reaction_time(file: &SceneFile) -> f64 {
    let reply = if file.robot.joints.iter().all(|joint| joint.has_own_loop()) { 1.0 } else { 0.0 };
    (f64::from(file.control.age_max) + 1.0 + reply) * file.period() + file.safety.latency
}

/// Returns the numbers if all are finite.
fn finite<const N: usize>(numbers: [f64; N]) -> Option<[f64; N]> {
    numbers.iter().all(|x| x.is_finite()).then_some(numbers)
}

/// Velocity of the tip at unit speed of each joint, in base axes.
fn columns<const N: usize>(posture: &Posture<f64, N>) -> [Vector3<f64>; N] {
    core::array::from_fn(|i| {
        let link = &posture.links[i];
        match link.kind {
            JointKind::Revolute => link.axis.cross(&(posture.tip.translation - link.origin)),
            JointKind::Prismatic => link.axis,
        }
    })
}

/// Largest value over all signs of the joints except the first one's, because a speed or an energy is the same in both directions. A function that is
/// convex in each joint's velocity is largest at the ends.
fn most<const N: usize>(of: impl Fn(&[f64; N]) -> f64) -> f64 {
    let signs = |bits: usize| core::array::from_fn(|i| if i > 0 && bits >> (i - 1) & 1 == 1 { -1.0 } else { 1.0 });
    (0..1_usize << N.saturating_sub(1)).map(|bits| of(&signs(bits))).fold(0.0, f64::max)
}

impl Hazard {
    /// The figures as text, each with its formula and the limit of class I.
    #[must_use]
    pub fn text(&self) -> String {
        let or = |x: Option<f64>, unit: &str| x.map_or("unbounded".to_owned(), |x| format!("{} {unit}", digits(x)));
        let (mass, force, speed) = CLASS_I;
        let class = [format!("{mass} kg"), format!("{force} N"), format!("{speed} m/s"), "-".to_owned()];
        let [mass, force, speed, none] = class.each_ref().map(String::as_str);
        let bound =
            self.tip_speed_bound.map_or(String::new(), |bound| format!("; no posture exceeds {} m/s", digits(bound)));
        let largest_speed = format!("largest |sum J_i qd_i| over postures, |qd_i| at its limit{bound}");
        let rows = [
            ("moving mass", or(Some(self.moving_mass), "kg"), mass, "links, tool and payload"),
            ("tip speed", or(self.tip_speed, "m/s"), speed, &largest_speed),
            (
                "tip force",
                or(self.tip_force, "N"),
                force,
                "at the motion's start: max over u = J_k / |J_k| of min_i (tau_i + |G_i|) / |J_i . u|",
            ),
            ("energy", or(self.kinetic_energy, "J"), none, "largest qd^T M qd / 2 over postures, rotors included"),
            (
                "reaction",
                or(Some(1e3 * self.reaction_time), "ms"),
                none,
                "t = age_max T + T (tick) + T (reply of a drive on CAN) + latency",
            ),
            ("time to rest", or(self.stopping_time, "s"), none, "t + max v_i / a_i, a_i the scene's `deceleration`"),
            (
                "tip's way to rest",
                or(self.stopping_distance, "m"),
                none,
                "at most sum r_i (v_i t + v_i^2 / (2 a_i)), r_i axis to tip",
            ),
        ];
        let scene = self.scene.as_deref().map_or("the default scene".to_owned(), |name| format!("scene {name}"));
        let mut text =
            format!("\nnear a person ({scene}): what the limits allow, beside class I of ISO 10218-1:2025\n\n");
        for (name, value, class, formula) in rows {
            text += &format!("  {name:<18}{value:>12}{class:>11}   {formula}\n");
        }
        if !self.sag.is_empty() {
            let of = |(i, way): (usize, &f64)| format!("{} {}", i + 1, digits(*way));
            let joints: Vec<String> = self.sag.iter().enumerate().map(of).collect();
            let assumed = if self.brake_delay_assumed { ", assumed" } else { "" };
            let falls = match self.scene {
                Some(_) => "After a fault the arm falls until its brakes have engaged",
                None => "If the arm has brakes, it falls after a fault until they have engaged",
            };
            text += &format!(
                "\n  {falls} ({} ms{assumed}). From rest, by joint, rad or m: {}.\n  \
                 s_i = t^2 / 2 max |(M^-1 G)_i| over postures; a joint that moves goes |qd_i| t farther.\n",
                digits(1e3 * self.brake_delay),
                joints.join(", ")
            );
        }
        if let Some((joint, mass)) = self.undeclared {
            text += &format!(
                "\n  In the first motion after homing an undeclared mass of {} kg at the tip is held in every posture; with more, joint {} may sink.\n  \
                 m = min over postures of min(first_motion tau_i, tau_i - |G_i|) / |J_i . g|; friction is not counted.\n",
                digits(mass),
                joint + 1
            );
        }
        text + "\n  Limits are software. Class I counts what the arm can do without them, so that no setting here makes a class I robot.\n"
    }
}
