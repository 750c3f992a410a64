//! JSON schemas of the messages.
//!
//! The schemas of Foxglove's messages have the names and fields of its SDK (`schemas/jsonschema` of github.com/foxglove/foxglove-sdk, MIT; npm
//! `@foxglove/schemas`). A test compares ours with that package.

use serde_json::{Value, json};

/// Schema of an object with these fields, of which some are required.
fn object(title: &str, fields: Value, required: &[&str]) -> Value {
    json!({ "title": title, "type": "object", "properties": fields, "required": required })
}

fn number(what: &str) -> Value {
    json!({ "type": "number", "description": what })
}

fn time() -> Value {
    let fields = json!({
        "sec": { "type": "integer", "minimum": 0 },
        "nsec": { "type": "integer", "minimum": 0, "maximum": 999_999_999 },
    });
    json!({ "title": "time", "type": "object", "properties": fields })
}

fn axes(title: &str, axes: &[&str]) -> Value {
    let fields = axes.iter().map(|axis| ((*axis).to_owned(), json!({ "type": "number" }))).collect();
    object(title, Value::Object(fields), axes)
}

fn list(of: Value) -> Value {
    json!({ "type": "array", "items": of })
}

pub(super) fn text() -> Value {
    object("std_msgs/String", json!({ "data": { "type": "string" } }), &["data"])
}

pub(super) fn frame_transforms() -> Value {
    let fields = json!({
        "timestamp": time(),
        "parent_frame_id": { "type": "string" },
        "child_frame_id": { "type": "string" },
        "translation": axes("foxglove.Vector3", &["x", "y", "z"]),
        "rotation": axes("foxglove.Quaternion", &["x", "y", "z", "w"]),
    });
    let required = ["timestamp", "parent_frame_id", "child_frame_id", "translation", "rotation"];
    let transform = object("foxglove.FrameTransform", fields, &required);
    object("foxglove.FrameTransforms", json!({ "transforms": list(transform) }), &["transforms"])
}

pub(super) fn joint_states() -> Value {
    let fields = json!({
        "name": { "type": "string" },
        "position": { "type": "number" },
        "velocity": { "type": "number" },
        "acceleration": { "type": "number" },
        "effort": { "type": "number" },
    });
    let joint = object("foxglove.JointState", fields, &["name"]);
    let fields = json!({ "timestamp": time(), "joints": list(joint) });
    object("foxglove.JointStates", fields, &["timestamp", "joints"])
}

pub(super) fn tick() -> Value {
    let terms = json!({
        "inertia": number("D(q) qdd at the reference, the rotors' included"),
        "velocity": number("C(q, qd) qd at the reference"),
        "gravity": number("G(q) at the reference, with payload and wrench at the tip"),
    });
    let joint = json!({
        "name": { "type": "string" },
        "reference": number("rad or m"),
        "reference_velocity": number("rad/s or m/s"),
        "position": number("rad or m"),
        "velocity": number("rad/s or m/s"),
        "torque": number("commanded, N m or N"),
        "limits": {
            "type": "integer",
            "minimum": 0,
            "maximum": 31,
            "description": "that acted: the sum of 1 position, 2 velocity, 4 torque, 8 torque rate, 16 collision",
        },
        "external": number("torque from outside, N m or N"),
        "terms": object("newtau.Terms", terms, &["inertia", "velocity", "gravity"]),
    });
    let wrench = json!({
        "force": axes("newtau.Force", &["x", "y", "z"]),
        "moment": axes("newtau.Moment", &["x", "y", "z"]),
    });
    let fields = json!({
        "timestamp": time(),
        "tick": { "type": "integer", "minimum": 0 },
        "joints": list(closed(object("newtau.Joint", joint, &["name", "limits"]))),
        "fault": { "type": "integer", "minimum": 0, "description": "code of the fault in force; 0: none" },
        "fault_text": { "type": "string" },
        "state": { "type": "integer", "minimum": 0, "description": "of the safety state machine" },
        "tip_wrench": object("newtau.TipWrench", wrench, &["force", "moment"]),
    });
    closed(object("newtau.Tick", fields, &["timestamp", "tick", "joints", "fault"]))
}

pub(super) fn link_frame() -> Value {
    let fields = json!({
        "way": { "enum": ["sent", "received"], "type": "string" },
        "missed": { "type": "integer", "minimum": 0, "maximum": 255 },
        "micros": { "type": "integer", "minimum": 0 },
        "frame": { "type": "string", "pattern": "^([0-9a-f]{2})*$", "description": "postcard, as on the wire" },
    });
    closed(object("newtau.Frame", fields, &["way", "missed", "micros", "frame"]))
}

/// Adds to a schema that no other fields are allowed.
fn closed(mut schema: Value) -> Value {
    schema["additionalProperties"] = Value::Bool(false);
    schema
}
