//! Locations of an arm's numbers in a TOML file.

use crate::describe::diagnostics::Source;
use crate::describe::draft::{DraftBody, JointPlaces, Place, Remark, RemarkKind, bones, own_joint, skeleton};
use crate::describe::robot::Robot;
use crate::read::table::Table;
use dynamics_core::Body;
use nalgebra::Vector3;

/// The links and the tool, each in the frame of its joint.
pub(super) fn bodies(robot: &Robot, joints: &[Table<'_>], tool: Option<&Table<'_>>) -> Vec<DraftBody> {
    let bones = bones(&skeleton(robot));
    let links = robot.joints.iter().zip(joints).zip(bones).enumerate().map(|(index, ((joint, table), bone))| {
        let mut points = own_joint(&joint.spec, Vector3::z());
        points.push(bone.end);
        body(index, &joint.spec.body, bone.centre, points, table)
    });
    let last = robot.dof().saturating_sub(1);
    // A tool's data are given relative to the tip.
    let tool = tool.filter(|_| robot.tool.body != Body::massless()).map(|table| {
        let held = &robot.tool.body;
        DraftBody { fixed: true, ..body(last, held, held.com, vec![Vector3::zeros()], table) }
    });
    links.chain(tool).collect()
}

fn body(joint: usize, body: &Body, centre: Vector3<f64>, points: Vec<Vector3<f64>>, table: &Table<'_>) -> DraftBody {
    let [mass, com, inertia] = ["mass", "com", "inertia"].map(|key| table.place(key));
    DraftBody { joint, fixed: false, body: *body, centre, points, mass, com, inertia }
}

/// Locations of a joint's other numbers.
pub(super) fn joint(table: &Table<'_>, root: &Table<'_>) -> JointPlaces {
    let limit = |key| table.place_in("limits", key);
    let drive = |key: &str| table.place_in("drive", key);
    // A named actuator has its ranges elsewhere. An H-bridge has no torque range: its current is used instead.
    let either = |keys: [&str; 2]| keys.map(drive).into_iter().find(|place| place.given);
    let torque = either(["torque", "actuator"]).unwrap_or_else(|| drive("current_max"));
    JointPlaces {
        position: limit("position"),
        turns_on: false,
        velocity: limit("velocity"),
        torque: limit("torque"),
        rotor: table.place("rotor"),
        friction: table.place("friction"),
        encoder: table.place("encoder"),
        drive_torque: torque,
        drive_position: either(["position", "actuator"]).unwrap_or_else(|| drive("position")),
        heat: [table.place_in("heat", "rated"), drive("actuator")]
            .into_iter()
            .find(|place| place.given)
            .unwrap_or_else(|| table.place("heat")),
        rest: root.place("rest"),
    }
}

/// Angles of placements and rows.
pub(super) fn angles(joints: &[Table<'_>], tool: Option<&Table<'_>>, root: &Table<'_>) -> Vec<(Place, f64)> {
    let in_placement = |table: &Table<'_>, key: &str| {
        let place = table.place_in(key, "rpy");
        let value = table.table(key).ok().flatten().and_then(|table| table.get("rpy"));
        let all = value.and_then(|value| value.numbers(3, "").ok()).unwrap_or_default();
        all.into_iter().map(move |angle| (place.clone(), angle)).collect::<Vec<_>>()
    };
    let in_row = |table: &Table<'_>, row: &str, key: &str| {
        let value =
            table.table(row).ok().flatten().and_then(|table| table.get(key)).and_then(|value| value.finite("").ok());
        value.map(|angle| (table.place_in(row, key), angle))
    };
    let mut found: Vec<(Place, f64)> = in_placement(root, "mounting");
    for table in joints.iter().chain(tool) {
        found.extend(in_placement(table, "placement"));
        let rows = [("dh", "alpha"), ("dh", "theta"), ("mdh", "alpha"), ("mdh", "theta")];
        found.extend(rows.into_iter().filter_map(|(row, key)| in_row(table, row, key)));
    }
    found
}

/// Lines that begin with `# ?` and name no key: questions that `import` left open. Missing keys have their own rules.
pub(super) fn open_lines(source: &Source) -> Vec<Remark> {
    let mut start = 0;
    let mut found = Vec::new();
    for line in source.text.split_inclusive('\n') {
        let text = line.trim();
        let question = text.strip_prefix("# ?").map(str::trim).filter(|rest| {
            let key = rest.split([' ', '=']).next().unwrap_or_default();
            !rest.is_empty() && !["rotor", "friction"].contains(&key)
        });
        if let Some(question) = question {
            found.push(Remark {
                kind: RemarkKind::Open,
                place: Place { span: start..start + line.trim_end().len(), field: String::new(), given: true },
                problem: format!("an open question: {question}"),
                advice: "answer it in the file, then take the line out".to_owned(),
            });
        }
        start += line.len();
    }
    found
}
