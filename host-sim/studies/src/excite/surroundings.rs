//! Shapes of an arm and of the objects around it.

use crate::clearance::arm::{capsules, length, usual_radius};
use crate::clearance::cell::{Cell, Part};
use crate::clearance::mesh::points;
use crate::clearance::shape::Shape;
use clap::Args;
use dynamics_core::Model;
use dynamics_core::joint::JointKind;
use nalgebra::{Matrix3, Vector3};
use robot_compiler::{Ends, Geometry, LinkShape, SceneFile};
use sim::failure::Failure;
use std::path::{Path, PathBuf};

/// A mesh longer than this many arm lengths is in another unit than metres.
const TOO_LONG: f64 = 10.0;

/// Obstacles around an arm, and the clearance to keep.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct Surroundings {
    /// Height of a floor against gravity, in the base frame, m.
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true)]
    pub floor: Option<f64>,
    /// A box along the axes of the base frame: its centre and its edges, m. May be given several times.
    #[arg(long = "box", value_name = "X,Y,Z,DX,DY,DZ", allow_hyphen_values = true)]
    pub boxes: Vec<String>,
    /// Smallest distance from the floor, from boxes, and between links, m.
    #[arg(long, value_name = "DISTANCE", default_value_t = 0.02, allow_hyphen_values = true)]
    pub clearance: f64,
    /// Radius of links without collision shapes, one for all or one for each, m. Without it, 6 % of the arm's length.
    #[arg(long, value_name = "R1,R2,..", value_delimiter = ',')]
    pub radius: Vec<f64>,
}

impl Surroundings {
    /// Checks the numbers that need no robot.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if let Some(radius) = self.radius.iter().find(|radius| !(**radius > 0.0 && radius.is_finite())) {
            return Err(wrong("radii above zero, m", format!("--radius {radius}")));
        }
        if !(self.clearance >= 0.0 && self.clearance.is_finite()) {
            return Err(wrong("a distance of zero or more, m", format!("--clearance {}", self.clearance)));
        }
        if let Some(height) = self.floor.filter(|height| !height.is_finite()) {
            return Err(wrong("a finite height, m", format!("--floor {height}")));
        }
        self.boxes().map(|_| ())
    }

    /// Centre and edges of each box, m.
    fn boxes(&self) -> Result<Vec<[f64; 6]>, Failure> {
        let numbers = |text: &String| {
            let found: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
            let six = found.and_then(|found| <[f64; 6]>::try_from(found).ok());
            six.ok_or_else(|| wrong("six numbers X,Y,Z,DX,DY,DZ: centre and edges, m", format!("--box {text}")))
        };
        self.boxes.iter().map(numbers).collect()
    }
}

/// An arm with its surroundings, and remarks on the shapes.
pub(super) struct JudgedSurroundings<const N: usize> {
    pub(super) cell: Cell<N>,
    /// Sources of the shapes, and parts that they do not contain.
    pub(super) notes: Vec<String>,
}

/// Name of a link: its number, and the joint that moves it.
fn link_name(scene: &SceneFile, frame: usize) -> String {
    let name = frame.checked_sub(1).and_then(|i| scene.robot.joints.get(i)).map(|joint| joint.name.as_str());
    name.map_or_else(|| "base".to_owned(), |name| format!("link {frame} ({name})"))
}

/// Collects the shapes of the scene's arm and of its surroundings.
///
/// # Errors
/// [`Failure::Input`]: a number of radii that is neither 1 nor the number of joints, a box without size, a prismatic joint without limits, a mesh
/// that is damaged or in millimetres.
pub(super) fn judged<const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    up: &Vector3<f64>,
    around: &Surroundings,
    ends: Ends<'_>,
) -> Result<JudgedSurroundings<N>, Failure> {
    let slides = |(_, joint): &(usize, &robot_compiler::RobotJoint)| {
        joint.spec.kind == JointKind::Prismatic && !joint.spec.limits.range().is_finite()
    };
    if let Some((_, joint)) = scene.robot.joints.iter().enumerate().find(slides) {
        return Err(wrong(
            "limits of position of every slide: without them nothing is known of what it can hit",
            format!("{}: joint {} slides without limits", scene.robot.path.display(), joint.name),
        ));
    }
    let radius: Vec<f64> = match around.radius.as_slice() {
        [] => vec![usual_radius(model); N],
        [one] => vec![*one; N],
        many if many.len() == N => many.to_vec(),
        many => {
            let found = format!("--radius: {} numbers for {N} joints", many.len());
            return Err(wrong("one radius for all links, or one for each", found));
        }
    };
    let Described { mut parts, mut notes, incomplete } = described(scene, model, ends)?;
    let mut lines = Vec::new();
    for frame in 0..=N {
        let name = link_name(scene, frame);
        if incomplete.contains(&frame) || !parts.iter().any(|part| part.frame == frame) {
            let radius = radius[frame.saturating_sub(1)];
            parts.extend(capsules(model, frame, &name, radius));
            lines.push((name, radius));
        }
    }
    if let Some((_, first)) = lines.first() {
        let guessed = if around.radius.is_empty() { ", the radius assumed as 6 % of the arm's length" } else { "" };
        let each = |(name, radius): &(String, f64)| format!("{name} {radius:.3} m");
        let which = if lines.len() > N && around.radius.len() <= 1 {
            format!("all links {first:.3} m")
        } else {
            lines.iter().map(each).collect::<Vec<_>>().join(", ")
        };
        notes.push(format!(
            "capsules from joint over mass centre to joint{guessed}: {which}; --radius gives the true ones"
        ));
    }
    if let Some(height) = around.floor {
        parts.push(Part::floor(up, height));
    }
    for (index, [x, y, z, dx, dy, dz]) in around.boxes()?.iter().enumerate() {
        let (centre, edges) = (Vector3::new(*x, *y, *z), Vector3::new(*dx, *dy, *dz));
        let shape = edges.iter().all(|edge| *edge > 0.0).then(|| Shape::cuboid(&Matrix3::identity(), &centre, &edges));
        let Some(shape) = shape.flatten() else {
            let found = format!("--box: {x},{y},{z},{dx},{dy},{dz}");
            return Err(wrong("six finite numbers: the centre, and three edges above zero, m", found));
        };
        parts.push(Part::obstacle(&format!("box {}", index + 1), shape));
    }
    notes.push(
        "not in the shapes: cables, a gripper or a tool past the tip, and how far the arm strays from this reference"
            .to_owned(),
    );
    let zero = core::array::from_fn(|i| {
        let (lo, hi) = model.links()[i].limits.position;
        0.0_f64.clamp(lo, hi)
    });
    let rest = scene.robot.rest.as_ref().and_then(|rest| rest.as_slice().try_into().ok()).unwrap_or(zero);
    Ok(JudgedSurroundings { cell: Cell::new(model, parts, &rest, around.clearance), notes })
}

fn wrong(expected: &str, found: String) -> Failure {
    Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}"))
}

/// Collision shapes of a URDF robot.
#[derive(Default)]
struct Described {
    parts: Vec<Part>,
    /// Remarks on the shapes.
    notes: Vec<String>,
    /// Frames of links with an unusable mesh.
    incomplete: Vec<usize>,
}

/// Reads the collision shapes of a URDF robot, with remarks.
fn described<const N: usize>(scene: &SceneFile, model: &Model<f64, N>, given: Ends<'_>) -> Result<Described, Failure> {
    let file = &scene.robot.path;
    // A robot without a file, as in tests, has no shapes.
    if !file.is_file() {
        return Ok(Described::default());
    }
    let (base, tip) = ends(scene, given);
    let shapes = LinkShape::load(file, Ends { base: base.as_deref(), tip: tip.as_deref() }).map_err(Failure::input)?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let (mut found, mut meshes) = (Described::default(), 0);
    for LinkShape { link, frame, place, geometry } in &shapes {
        let name = link_name(scene, *frame);
        let (turn, at) = (&place.rotation, &place.translation);
        let shape = match geometry {
            Geometry::Box(edges) => Shape::cuboid(turn, at, edges),
            Geometry::Sphere(radius) => Shape::hull(&[*at], *radius),
            Geometry::Cylinder { radius, length } => Shape::cylinder(turn, at, *radius, *length),
            Geometry::Mesh { file: named, scale } => {
                match read_mesh(named, folder, link, TOO_LONG * length(model), scale)? {
                    Ok(points) => {
                        meshes += 1;
                        Shape::hull(&points.iter().map(|p| at + turn * p).collect::<Vec<_>>(), 0.0)
                    }
                    Err(reason) => {
                        found.notes.push(format!("no mesh of {link} ({name}): {reason}; a capsule in its place"));
                        found.incomplete.push(*frame);
                        continue;
                    }
                }
            }
        };
        found.parts.extend(shape.map(|shape| Part::link(&name, *frame, shape)));
    }
    if !found.parts.is_empty() {
        let count = found.parts.len();
        let form =
            format!("{count} collision shapes of {}, convex hulls of {meshes} meshes among them", file.display());
        found.notes.insert(0, form);
    }
    Ok(found)
}

/// Ends of a URDF robot's chain: from the command line, or from the scene.
fn ends(scene: &SceneFile, given: Ends<'_>) -> (Option<String>, Option<String>) {
    if given.base.is_some() || given.tip.is_some() {
        return (given.base.map(str::to_owned), given.tip.map(str::to_owned));
    }
    let text = std::fs::read_to_string(&scene.path).unwrap_or_default();
    let document = text.parse::<toml_edit::DocumentMut>().unwrap_or_default();
    let end = |key: &str| document.get(key).and_then(toml_edit::Item::as_str).map(str::to_owned);
    (end("base"), end("tip"))
}

/// Points of a mesh in its frame, m; the inner error is the reason why there are none.
fn read_mesh(
    named: &str,
    folder: &Path,
    link: &str,
    longest: f64,
    scale: &Vector3<f64>,
) -> Result<Result<Vec<Vector3<f64>>, String>, Failure> {
    let form = Path::new(named).extension().map(|extension| extension.to_ascii_lowercase());
    if !form.is_some_and(|form| form == "stl" || form == "obj") {
        return Ok(Err(format!("{named} is neither STL nor OBJ")));
    }
    let Some(path) = resolved(named, folder) else { return Ok(Err(format!("{named} is not there"))) };
    let place = format!("{}: mesh of link {link}", path.display());
    let bytes = std::fs::read(&path).map_err(|error| wrong("a mesh that can be read", format!("{place}: {error}")))?;
    let found = points(&bytes).map_err(|error| wrong("an STL or OBJ mesh", format!("{place}: {error}")))?;
    let scaled: Vec<Vector3<f64>> = found.iter().map(|p| p.component_mul(scale)).collect();
    let far = scaled.iter().map(|p| p.norm()).fold(0.0, f64::max);
    if far > longest {
        let expected = "a mesh in metres, or a `scale` for one in millimetres: scale=\"0.001 0.001 0.001\"";
        return Err(wrong(
            expected,
            format!("{place}: a point is {far:.1} m from the origin: is the file in millimetres?"),
        ));
    }
    Ok(Ok(scaled))
}

/// Finds the file of a mesh. `package://NAME/REST` is searched as `NAME/REST` and `REST` in the robot file's folder and those above it.
fn resolved(named: &str, folder: &Path) -> Option<PathBuf> {
    if let Some(inside) = named.strip_prefix("package://") {
        let rest = inside.split_once('/').map_or(inside, |(_, rest)| rest);
        let folder = folder.canonicalize().ok()?;
        let all = folder.ancestors().flat_map(|above| [above.join(inside), above.join(rest)]);
        return all.into_iter().find(|path| path.is_file());
    }
    let path = folder.join(named.strip_prefix("file://").unwrap_or(named));
    path.is_file().then_some(path)
}
