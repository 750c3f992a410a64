use super::{Id, Names, Quantity, Role};

fn names() -> Names {
    Names::new(&["turn".to_owned(), "lift".to_owned(), "shoulder_pan_joint".to_owned()])
}

#[test]
fn names_of_usual_programs_are_understood() {
    use Quantity::{Current, Name, Position, StampNanoseconds, StampSeconds, Tick, Time, Torque, Velocity};
    use Role::{Actual, Commanded, Derived, Plain};
    let n = Id::Number;
    for (text, quantity, role, id) in [
        ("q_1", Position, Plain, n(1)),
        ("q1 [deg]", Position, Plain, n(1)),
        ("q1_deg", Position, Plain, n(1)),
        ("q1/rad", Position, Plain, n(1)),
        ("q_deg_1", Position, Plain, n(1)),
        ("speed_rad_s_2", Velocity, Plain, n(2)),
        ("q1_reference", Position, Commanded, n(1)),
        ("position[0]", Position, Plain, n(0)),
        ("position[0] (rad)", Position, Plain, n(0)),
        ("joint_1.position", Position, Plain, n(1)),
        ("actual_q_0", Position, Actual, n(0)),
        ("target_q_0", Position, Commanded, n(0)),
        ("actual_current_0", Current, Actual, n(0)),
        ("actual_current_as_torque_0", Torque, Actual, n(0)),
        ("target_moment_0", Torque, Commanded, n(0)),
        ("current_position_2", Position, Actual, n(2)),
        ("sensed_2", Position, Actual, n(2)),
        ("/joint_states/position[0]", Position, Plain, n(0)),
        ("/joint_states/turn/position", Position, Plain, Id::Joint(0)),
        ("/joint_states/shoulder_pan_joint/effort", Torque, Plain, Id::Joint(2)),
        ("shoulder_pan_vel", Velocity, Plain, Id::Joint(2)),
        ("effort[lift]", Torque, Plain, Id::Joint(1)),
        ("/desired_states/turn/position", Position, Commanded, Id::Joint(0)),
        ("/controller/state/actual/positions[2]", Position, Actual, n(2)),
        ("field.effort5", Torque, Plain, n(5)),
        ("/joint_states/name[3]", Name, Plain, n(3)),
        ("tau_J_d[6]", Torque, Commanded, n(6)),
        ("tau_filtered_1", Torque, Derived, n(1)),
        ("motor_1_torque [mN m]", Torque, Plain, n(1)),
        ("Joint1Pos", Position, Plain, n(1)),
        ("qd1 / (rad/s)", Velocity, Plain, n(1)),
        ("velocity_1_rad/s", Velocity, Plain, n(1)),
        ("i_q_1 [A]", Current, Plain, n(1)),
        ("turn", Position, Plain, Id::Joint(0)),
        ("turn [N m]", Torque, Plain, Id::Joint(0)),
        ("J4", Position, Plain, n(4)),
        ("time [ms]", Time, Plain, Id::None),
        ("__time", Time, Plain, Id::None),
        ("Time_s", Time, Plain, Id::None),
        ("/joint_states/header/stamp", Time, Plain, Id::None),
        ("header.stamp.secs", StampSeconds, Plain, Id::None),
        ("/joint_states/header/stamp/nanosec", StampNanoseconds, Plain, Id::None),
        ("tick", Tick, Plain, Id::None),
    ] {
        let meaning = names().meaning(text).unwrap_or_else(|| panic!("{text}"));
        assert_eq!((meaning.quantity, meaning.role, meaning.id), (quantity, role, id), "{text}: {meaning:?}");
    }
}

#[test]
fn other_columns_are_left_alone() {
    for text in [
        "limits1",
        "fault",
        "external1",
        "tip_fx",
        "actual_TCP_pose_0",
        "actual_TCP_force_2",
        "joint_temperatures_0",
        "tau_ext_1",
        "id_1",
        "i_d_1",
        "O_T_EE[0]",
        "qdd_1",
        "/errors/turn/position",
        "",
        "#3",
        "robot_mode",
    ] {
        assert_eq!(names().meaning(text), None, "{text}");
    }
}

#[test]
fn units_of_headings_are_kept_and_unknown_ones_named() {
    for (text, unit) in [
        ("q1 [deg]", "deg"),
        ("q1(deg)", "deg"),
        ("q1_deg", "deg"),
        ("q_deg_1", "deg"),
        ("tau_Nm_2", "N m"),
        ("speed_deg_s_2", "deg/s"),
        ("qd_1_rad_s", "rad/s"),
        ("tau_1 [mN m]", "mN m"),
        ("tau_1 [N cm]", "N cm"),
        ("tau1_Nm", "N m"),
        ("turn_effort_mNm", "mN m"),
        ("qd_1 [rpm]", "rpm"),
        ("qd1 / (rad/s)", "rad/s"),
        ("t in ms", "ms"),
        ("time_ns", "ns"),
        ("position[0] [deg]", "deg"),
        ("current_2 [mA]", "mA"),
    ] {
        assert_eq!(names().meaning(text).and_then(|meaning| meaning.unit).map(|unit| unit.name), Some(unit), "{text}");
    }
    let furlongs = names().meaning("q1 [furlong]").unwrap();
    assert_eq!((furlongs.unit, furlongs.unknown_unit.as_deref()), (None, Some("furlong")));
    assert_eq!(names().meaning("q1 (measured)").unwrap().role, Role::Actual);
    assert_eq!(names().meaning("q_1").unwrap().unit, None);
}
