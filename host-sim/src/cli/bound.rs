//! `bound`: between what was found and what is proven, how wrong the torques of single precision are.

use crate::cli::BoundArgs;
use crate::cli::document::Document;
use crate::cli::dynamics::numbers;
use crate::cli::progress::progress_bar;
use crate::failure::{self, Failure};
use crate::run::record::JointLabel;
use crate::run::summary::engineering;
use crate::study::Subject;
use crate::study::torque_error::{Effort, Found, Region, State, TorqueError, positions, search};
use comfy_table::{CellAlignment, Table, presets};
use dynamics_core::trig::Method;
use dynamics_core::{Limits, Model};
use indicatif::ProgressBar;
use robot_compiler::kernel::Level;
use robot_compiler::{Robot, with_dof};
use serde::Serialize;
use std::path::Path;

/// Climbs for every joint, and steps of each.
const CLIMBS: (usize, usize) = (32, 3000);
/// The bound of one state is looked for with this part of the effort: it is smooth and has few tops.
const LESS: usize = 10;

/// What is known of an arm in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The robot's name.
    pub robot: String,
    /// The scene's name, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// `exact` or `regrouped`.
    pub level: &'static str,
    /// Random states that were looked at.
    pub samples: usize,
    /// Boxes that were looked at for each joint.
    pub boxes: usize,
    /// Of everything random.
    pub seed: u64,
    /// Every joint, base first.
    pub joints: Vec<JointAnswer>,
}

/// What is known of a joint's torque.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointAnswer {
    /// Its name.
    pub name: String,
    /// `N m` or `N`.
    pub unit: &'static str,
    /// Lowest and highest position, rad or m.
    pub position: (f64, f64),
    /// Greatest speed, rad/s or m/s.
    pub velocity: f64,
    /// Greatest acceleration, rad/s^2 or m/s^2.
    pub acceleration: f64,
    /// The actuator's limit, N m or N; not there where it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// The largest error that was found, N m or N.
    pub found: f64,
    /// Where: position, velocity, acceleration.
    pub found_at: [Vec<f32>; 3],
    /// The bound for that state alone.
    pub bound_there: f64,
    /// The largest bound of a single state that was found.
    pub one_state: f64,
    /// The bound for all states in one box.
    pub one_box: f64,
    /// No state exceeds it.
    pub proven: f64,
}

/// Print, or write into a document, what is known.
///
/// # Errors
/// [`Failure::Input`] for a file or an option that is wrong; [`Failure::Output`] where a document cannot be written.
pub fn run(args: &BoundArgs) -> Result<(), Failure> {
    let files: Vec<Subject> = args.files.iter().map(|path| load(path)).collect::<Result<_, _>>()?;
    let steps: u64 = files.iter().map(|file| work(file.file.robot.dof(), args)).sum();
    let document = args.write.as_deref().map(|path| Document::read(path, &["bound"])).transpose()?;
    let progress = progress_bar(Some(steps), "");
    let mut answers = Vec::new();
    for subject in &files {
        let found = with_dof!(subject.file.robot.dof(), N => {
            let model = subject.file.robot.model::<N>().map_err(Failure::input)?;
            answer(args, subject, &model, &progress)?
        });
        answers.push(found);
    }
    progress.finish_and_clear();
    if let Some(mut document) = document {
        document.put("bound", &markdown(&answers))?;
        return document.write();
    }
    let mut text = String::new();
    for answer in &answers {
        if args.json {
            text += &serde_json::to_string(answer).map_err(|error| Failure::Output(error.into()))?;
            text += "\n";
        } else {
            text += &answer.table();
        }
    }
    failure::print(&text)
}

/// A subject whose sine and cosine have known errors.
fn load(path: &Path) -> Result<Subject, Failure> {
    let subject = Subject::load(path)?;
    if subject.file.control.trig != Method::Polynomial {
        let (_, trig) = subject.file.control.names();
        return Err(Failure::Input(miette::miette!(
            help = "expected trig = \"polynomial\", whose errors over every float the bound starts from",
            "{}: control.trig: \"{trig}\" has no bound",
            path.display()
        )));
    }
    Ok(subject)
}

fn effort(args: &BoundArgs) -> Effort {
    Effort { samples: args.samples as usize, climbs: CLIMBS.0, steps: CLIMBS.1, seed: args.seed }
}

fn less(effort: &Effort) -> Effort {
    Effort { samples: effort.samples / LESS, climbs: effort.climbs / 4, ..*effort }
}

/// States and boxes that are looked at.
fn work(joints: usize, args: &BoundArgs) -> u64 {
    let effort = effort(args);
    let states: usize =
        [effort, less(&effort)].iter().map(|effort| effort.samples + joints * effort.climbs * effort.steps).sum();
    (states + joints * args.boxes as usize) as u64
}

fn answer<const N: usize>(
    args: &BoundArgs,
    subject: &Subject,
    model: &Model<f64, N>,
    progress: &ProgressBar,
) -> Result<Answer, Failure> {
    let file = &subject.file;
    let limits = model.links().map(|link| link.limits);
    let region = region(args, &file.robot, model, &limits)?;
    let level = Level::from(args.level);
    let arm = TorqueError::new(model, &file.scene(model), &file.live(model), level);
    let (bounds, effort) = (arm.bounds(), effort(args));
    let found = search(&region, &effort, |state| arm.error(state), progress);
    let at_one = |state: &State<N>| bounds.over(&Region::of(state));
    let one_state = search(&region, &less(&effort), at_one, progress);
    let proven = bounds.everywhere(&region, args.boxes as usize, progress);
    let one_box = bounds.over(&region);
    if let Some(i) = proven.iter().position(|x| !x.is_finite()) {
        return Err(Failure::Input(miette::miette!(
            help = "expected joint limits within which no torque overflows single precision, and angles up to 8192 rad",
            "joint {} ({}): there is no bound",
            i + 1,
            file.robot.joints[i].name
        )));
    }
    let joints = (0..N).map(|i| {
        let joint = &file.robot.joints[i];
        let Found { value, state: at } = found[i];
        JointAnswer {
            name: joint.name.clone(),
            unit: JointLabel { name: joint.name.clone(), kind: joint.spec.kind }.torque_unit(),
            position: region.inputs[0][i],
            velocity: region.inputs[1][i].1,
            acceleration: region.inputs[2][i].1,
            limit: Some(limits[i].torque).filter(|limit| limit.is_finite()),
            found: value,
            found_at: [at.q, at.qd, at.qdd].map(|all| all.to_vec()),
            bound_there: at_one(&at)[i],
            one_state: one_state[i].value,
            one_box: one_box[i],
            proven: proven[i],
        }
    });
    Ok(Answer {
        robot: file.robot.name.clone(),
        scene: subject.scene.clone(),
        level: level.name(),
        samples: effort.samples,
        boxes: args.boxes as usize,
        seed: effort.seed,
        joints: joints.collect(),
    })
}

/// Everywhere in the joint limits.
fn region<const N: usize>(
    args: &BoundArgs,
    robot: &Robot,
    model: &Model<f64, N>,
    limits: &[Limits<f64>; N],
) -> Result<Region<N>, Failure> {
    let given = |option: &str, values: &Option<Vec<f64>>| -> Result<Option<[f64; N]>, Failure> {
        let Some(values) = values else { return Ok(None) };
        if let Some(value) = values.iter().find(|x| !(**x >= 0.0 && x.is_finite())) {
            return Err(wrong(&format!("`--{option}` holds {value}; expected finite numbers of zero or more")));
        }
        numbers(option, values, "one for each joint").map(Some).map_err(|problem| wrong(&problem))
    };
    let velocity = given("velocity", &args.velocity)?.unwrap_or(limits.map(|limits| limits.velocity));
    if let Some(i) = velocity.iter().position(|x| !x.is_finite()) {
        let name = &robot.joints[i].name;
        return Err(wrong(&format!("joint {} ({name}) has no limit of velocity: give --velocity", i + 1)));
    }
    let acceleration = given("acceleration", &args.acceleration)?.unwrap_or(velocity.map(|speed| 5.0 * speed));
    let mut position = [(0.0, 0.0); N];
    for (i, link) in model.links().iter().enumerate() {
        let name = &robot.joints[i].name;
        position[i] = positions(link.kind, link.limits.position).ok_or_else(|| {
            wrong(&format!("joint {} ({name}) slides without limits: nothing bounds its force", i + 1))
        })?;
    }
    Ok(Region::new(position, velocity, acceleration))
}

fn wrong(problem: &str) -> Failure {
    Failure::Input(miette::miette!(help = "see `host-sim bound --help`", "{problem}"))
}

/// A share of the actuator's limit.
fn share(value: f64, limit: Option<f64>) -> String {
    limit.map_or_else(|| "-".to_owned(), |limit| format!("{:.1e}", value / limit))
}

fn ratio(a: f64, b: f64) -> String {
    if b > 0.0 { format!("{:.1}", a / b) } else { "-".to_owned() }
}

const HEADER: [&str; 8] =
    ["joint", "found", "one state", "proven", "proven / found", "limit", "found / limit", "proven / limit"];

impl Answer {
    fn rows(&self) -> impl Iterator<Item = [String; 8]> {
        self.joints.iter().map(|joint| {
            let number = |value| engineering(value, joint.unit);
            [
                joint.name.clone(),
                number(joint.found),
                number(joint.one_state),
                number(joint.proven),
                ratio(joint.proven, joint.found),
                joint.limit.map_or_else(|| "none".to_owned(), number),
                share(joint.found, joint.limit),
                share(joint.proven, joint.limit),
            ]
        })
    }

    /// For a person.
    fn table(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::UTF8_FULL_CONDENSED).set_header(HEADER);
        for row in self.rows() {
            table.add_row(row);
        }
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        let scene = self.scene.as_ref().map_or_else(String::new, |scene| format!(" in {scene}"));
        let mut text = format!("{}{scene}: torque error of f32 at level {}\n{table}\n", self.robot, self.level);
        text += "Everywhere in the joint limits the worst error lies\n";
        for joint in &self.joints {
            let number = |value| engineering(value, joint.unit);
            text += &format!("  {:<12} between {} and {}\n", joint.name, number(joint.found), number(joint.proven));
        }
        text + &format!("{} random states, {} boxes for each joint, seed {}\n", self.samples, self.boxes, self.seed)
    }
}

/// For a document.
fn markdown(answers: &[Answer]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = format!("| arm | {} |\n|{}\n", HEADER.join(" | "), "---|".repeat(HEADER.len() + 1));
    for answer in answers {
        for row in answer.rows() {
            let arm = answer.scene.as_ref().unwrap_or(&answer.robot).clone();
            text += &line(&[&[arm][..], &row].concat());
        }
    }
    text
}
