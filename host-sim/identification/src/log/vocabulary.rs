//! Words in column names, and the quantities that they mean.

/// Quantity of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Quantity {
    Time,
    /// Whole seconds of a stamp, and its nanoseconds in a second column.
    StampSeconds,
    StampNanoseconds,
    Tick,
    Position,
    Velocity,
    Torque,
    Current,
    /// Text: name of the joint for the readings with the same index.
    Name,
}

pub(super) const ACTUAL: &[&str] =
    &["actual", "act", "measured", "meas", "msr", "sensed", "feedback", "fbk", "fb", "sensor", "present"];
pub(super) const DERIVED: &[&str] = &["filtered", "filt", "estimated", "est", "smoothed", "smooth", "raw"];
pub(super) const COMMANDED: &[&str] = &[
    "target",
    "desired",
    "des",
    "d",
    "commanded",
    "command",
    "commands",
    "cmd",
    "ref",
    "reference",
    "set",
    "setpoint",
    "goal",
    "demand",
    "demanded",
    "planned",
    "nominal",
    "request",
    "requested",
];
/// Words without information about the quantity.
pub(super) const FILLERS: &[&str] = &[
    "joint", "joints", "jnt", "j", "axis", "axes", "state", "states", "data", "field", "msg", "value", "val", "link",
    "arm", "robot",
];
pub(super) const MOTOR: &[&str] = &["motor", "motors", "drive", "drives", "actuator", "servo", "rotor"];
/// Words of topics that contain other quantities.
pub(super) const OTHER: &[&str] =
    &["error", "errors", "wrench", "temperature", "voltage", "acceleration", "accelerations", "limit", "limits"];

pub(super) const WORDS: &[(Quantity, &[&str])] = &[
    (
        Quantity::Position,
        &["q", "position", "positions", "pos", "angle", "angles", "theta", "qpos", "angular position"],
    ),
    (
        Quantity::Velocity,
        &[
            "qd",
            "dq",
            "qdot",
            "q dot",
            "velocity",
            "velocities",
            "vel",
            "speed",
            "speeds",
            "v",
            "omega",
            "dtheta",
            "theta dot",
            "qvel",
            "angular velocity",
        ],
    ),
    (
        Quantity::Torque,
        &[
            "tau",
            "torque",
            "torques",
            "effort",
            "efforts",
            "force",
            "forces",
            "moment",
            "moments",
            "trq",
            "tq",
            "current as torque",
        ],
    ),
    (Quantity::Current, &["current", "currents", "i", "cur", "curr", "amps", "amp", "iq", "i q"]),
    (Quantity::Name, &["name", "names"]),
];

pub(super) const TIME: &[&str] = &[
    "time",
    "t",
    "times",
    "timestamp",
    "timestamps",
    "time stamp",
    "stamp",
    "seconds",
    "secs",
    "sec",
    "elapsed",
    "elapsed time",
    "header stamp",
    "rosbag timestamp",
    "bag time",
    "ros time",
    "sim time",
    "time elapsed",
    "clock",
];
pub(super) const STAMP_SECONDS: &[&str] =
    &["stamp sec", "stamp secs", "header stamp sec", "header stamp secs", "tv sec", "time sec", "time secs"];
pub(super) const STAMP_NANOSECONDS: &[&str] = &[
    "stamp nsec",
    "stamp nsecs",
    "stamp nanosec",
    "header stamp nsec",
    "header stamp nsecs",
    "header stamp nanosec",
    "tv nsec",
    "nsec",
    "nsecs",
    "nanosec",
    "time nsec",
    "time nsecs",
    "time nanosec",
];
