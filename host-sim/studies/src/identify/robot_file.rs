//! The robot file with the identified values.

use super::friction::{Written, friction};
use super::subject::Subject;
use dynamics_core::{Inertia, JointKind};
use identification::consistent::central;
use identification::identify::Identified;
use identification::log::Log;
use nalgebra::{Matrix3, Vector3};
use robot_compiler::emit::robot_file;
use robot_compiler::{Ends, Robot, UrdfArm};
use serde_json::{Value as Json, json};
use sim::failure::Failure;
use std::path::Path;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value};

/// A link's parameter counts as not seen if the data leave at least this share of its prior uncertainty.
const UNSEEN: f64 = 0.7;

/// Values of an identified arm for a robot file.
pub struct Numbers {
    /// Each link, in the frame of its data in the robot file.
    pub links: Vec<Link>,
    /// Reflected inertia of each rotor and its standard deviation, kg m^2.
    pub rotors: Vec<(f64, f64)>,
    /// Friction of each joint.
    pub friction: Vec<Written>,
    /// All parameters without the tool, in the model's frames.
    parameters: Vec<f64>,
}

/// A link, in the frame of its data in the robot file.
pub struct Link {
    /// Mass and its standard deviation, kg.
    pub mass: (f64, f64),
    /// Centre of mass, and the standard deviation of each coordinate, m.
    pub com: (Vector3<f64>, Vector3<f64>),
    /// Inertia about the centre of mass, kg m^2.
    pub inertia: Matrix3<f64>,
    /// Standard deviation of the moments of inertia about the link's origin, kg m^2.
    pub moments: Vector3<f64>,
    /// True if the data determine mass, centre of mass, and inertia.
    pub seen: [bool; 3],
}

impl Numbers {
    /// Takes the values from a model and the logs from which it was identified.
    pub(super) fn of(subject: &Subject, found: &Identified, logs: &[Log]) -> Self {
        let bodies = &found.bodies;
        let n = found.base.joints;
        let link = |link: usize| {
            let body_from_link = subject.robot.joints[link].spec.frame.link_from_body().inverse();
            let ten: [f64; 10] = core::array::from_fn(|k| bodies.parameters[10 * link + k]);
            let there = Inertia::from_parameters(&ten).in_parent(&body_from_link.rotation, &body_from_link.translation);
            let (mass, com, inertia) = central(&there.symmetric().parameters());
            let deviation = |k: usize| bodies.deviations[10 * link + k];
            // Rotate the deviations like the edges of a box, which gives an upper estimate.
            let turned = body_from_link.rotation.abs();
            let of_com = turned * Vector3::new(deviation(1), deviation(2), deviation(3)) / mass;
            let moments = turned * Vector3::new(deviation(4), deviation(7), deviation(9));
            let seen = |range: std::ops::Range<usize>| range.clone().any(|k| bodies.unseen[10 * link + k] < UNSEEN);
            Link {
                mass: (mass, deviation(0)),
                com: (com, of_com),
                inertia: (inertia + inertia.transpose()) * 0.5,
                moments,
                seen: [seen(0..1), seen(1..4), seen(4..10)],
            }
        };
        let rotor = |joint: usize| (bodies.parameters[10 * n + joint], bodies.deviations[10 * n + joint]);
        Self {
            links: (0..n).map(link).collect(),
            rotors: (0..n).map(rotor).collect(),
            friction: friction(subject, found, logs),
            parameters: bodies.parameters.clone(),
        }
    }

    /// All parameters, including what is fixed to the links.
    pub(super) fn parameters(&self, subject: &Subject) -> Vec<f64> {
        let mut all = self.parameters.clone();
        all.iter_mut().zip(subject.maker.fixed.iter().flatten()).for_each(|(sum, x)| *sum += x);
        all
    }

    /// Names of values that the data do not determine.
    #[must_use]
    pub fn unseen(&self, subject: &Subject) -> Vec<String> {
        let name = |joint: usize| &subject.robot.joints[joint].name;
        let of = |(joint, link): (usize, &Link)| {
            let parts = ["mass", "com", "inertia"].into_iter().zip(link.seen).filter(|(_, seen)| !seen);
            parts.map(|(part, _)| format!("{part} of {}", name(joint))).collect::<Vec<_>>()
        };
        self.links.iter().enumerate().flat_map(of).collect()
    }

    pub(super) fn json(&self, subject: &Subject) -> Json {
        let link = |(joint, link): (usize, &Link)| {
            let i = &link.inertia;
            json!({
                "name": subject.robot.joints[joint].name,
                "mass": link.mass.0, "mass_deviation": link.mass.1, "mass_before": subject.maker.links[joint][0],
                "com": link.com.0.as_slice(), "com_deviation": link.com.1.as_slice(),
                "inertia": { "xx": i.m11, "yy": i.m22, "zz": i.m33, "xy": i.m12, "xz": i.m13, "yz": i.m23 },
                "rotor": self.rotors[joint].0, "rotor_deviation": self.rotors[joint].1,
                "viscous": self.friction[joint].law.viscous, "coulomb": self.friction[joint].law.coulomb,
                "friction": self.friction[joint].json(),
                "seen": { "mass": link.seen[0], "com": link.seen[1], "inertia": link.seen[2] },
            })
        };
        self.links.iter().enumerate().map(link).collect()
    }

    /// Text of the robot file: a TOML file is edited in place, a URDF file is imported first.
    ///
    /// # Errors
    /// [`Failure::Input`]: the file cannot be read, or the result is not a valid robot.
    pub fn robot_file(&self, subject: &Subject, path: &Path, ends: Ends<'_>) -> Result<String, Failure> {
        let is_toml = path.extension().is_some_and(|extension| extension == "toml");
        let text = if is_toml {
            std::fs::read_to_string(path)
                .map_err(|error| Failure::Input(miette::miette!("{}: {error}", path.display())))?
        } else {
            robot_file(&UrdfArm::load(path, ends).map_err(Failure::input)?)
        };
        let wrong = |problem: String| Failure::Input(miette::miette!("{}: {problem}", path.display()));
        let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| wrong(error.to_string()))?;
        let joints = document.get_mut("joint").and_then(Item::as_array_of_tables_mut);
        for (joint, table) in joints.into_iter().flat_map(toml_edit::ArrayOfTables::iter_mut).enumerate() {
            self.edit(subject, joint, table);
        }
        // Every body is physically consistent now.
        document.remove("allow_unphysical");
        let head =
            "# Masses, mass centres, inertias, rotors and friction of `newtau identify`; deviations behind them.\n";
        // Remove the import's requests for values that are now filled in.
        let answered = |line: &&str| !["# ? rotor", "# ? friction"].iter().any(|asked| line.starts_with(asked));
        let text: Vec<String> = document.to_string().lines().filter(answered).map(str::to_owned).collect();
        let text = format!("{head}{}\n", text.join("\n"));
        Robot::from_toml_str(&text, "the identified robot").map_err(Failure::input)?;
        Ok(text)
    }

    fn edit(&self, subject: &Subject, joint: usize, table: &mut Table) {
        let link = &self.links[joint];
        let slides = subject.robot.joints[joint].spec.kind == JointKind::Prismatic;
        let (viscous_unit, force) = if slides { ("N s/m", "N") } else { ("N m s/rad", "N m") };
        let source = |seen: bool, text: String| if seen { text } else { format!("{text}: not seen, near the maker's") };
        set(table, "mass", number(link.mass.0).into(), &source(link.seen[0], format!("+- {:.2e} kg", link.mass.1)));
        let com: Array = link.com.0.iter().map(|x| number(*x)).collect();
        let [x, y, z]: [f64; 3] = link.com.1.into();
        set(table, "com", com.into(), &source(link.seen[1], format!("+- {x:.1e}, {y:.1e}, {z:.1e} m")));
        let i = &link.inertia;
        let entries = [("xx", i.m11), ("yy", i.m22), ("zz", i.m33), ("xy", i.m12), ("xz", i.m13), ("yz", i.m23)];
        let [x, y, z]: [f64; 3] = link.moments.into();
        let note = source(link.seen[2], format!("+- {x:.1e}, {y:.1e}, {z:.1e} kg m^2 about the link's origin"));
        set(table, "inertia", inline(&entries).into(), &note);
        let gear = subject.robot.joints[joint].spec.rotor.gear;
        let gear = if gear == 0.0 { 1.0 } else { gear };
        let (inertia, deviation) = self.rotors[joint];
        let rotor = inline(&[("inertia", inertia / (gear * gear)), ("gear", gear)]);
        set(table, "rotor", rotor.into(), &format!("+- {:.1e} kg m^2", deviation / (gear * gear)));
        let friction = &self.friction[joint];
        let entries: Vec<(&str, f64)> = friction.entries().iter().map(|(key, x, _)| (*key, *x)).collect();
        set(table, "friction", inline(&entries).into(), &friction.note(viscous_unit, force));
    }
}

/// Rounds to six digits after the first: more than any log determines, and still readable.
fn number(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

fn inline(entries: &[(&str, f64)]) -> InlineTable {
    entries.iter().map(|(key, x)| (*key, Value::from(number(*x)))).collect()
}

/// Sets a key with a comment after it; comments before it stay.
fn set(table: &mut Table, key: &str, value: Value, comment: &str) {
    let mut value = value;
    value.decor_mut().set_suffix(format!(" # {comment}"));
    value.decor_mut().set_prefix(" ");
    match table.get_mut(key) {
        Some(item) => *item = Item::Value(value),
        None => drop(table.insert(key, Item::Value(value))),
    }
}
