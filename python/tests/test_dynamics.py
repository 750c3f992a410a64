"""The functions agree with each other."""

import numpy as np
import pytest
from conftest import robot_file, states

import newtau


def test_forward_dynamics_undoes_inverse_dynamics(arm):
    q, qd, qdd = states(arm.n, 100)
    tau = arm.inverse_dynamics(q, qd, qdd)
    assert np.allclose(arm.forward_dynamics(q, qd, tau), qdd, rtol=1e-7, atol=1e-7)
    # Negative control: another torque gives another acceleration.
    assert not np.allclose(arm.forward_dynamics(q, qd, tau + 1.0), qdd, rtol=1e-3, atol=1e-3)


def test_mass_matrix_is_the_derivative_of_the_torques(arm):
    q, _, qdd = states(arm.n, 30)
    rest = np.zeros(arm.n)
    moved = arm.inverse_dynamics(q, rest, qdd) - arm.gravity(q)
    matrix = arm.mass_matrix(q)
    assert np.allclose(np.einsum("bij,bj->bi", matrix, qdd), moved, rtol=1e-10, atol=1e-10)
    assert np.array_equal(matrix, matrix.transpose(0, 2, 1))
    assert np.all(np.linalg.eigvalsh(matrix) > 0.0)


def test_regressor_times_parameters_are_the_torques(arm):
    q, qd, qdd = states(arm.n, 30)
    linear = arm.regressor(q, qd, qdd) @ arm.parameters + arm.rotor_inertia * qdd
    assert np.allclose(linear, arm.inverse_dynamics(q, qd, qdd), rtol=1e-10, atol=1e-10)
    assert len(arm.parameter_names) == len(arm.parameters) == 10 * arm.n


def test_jacobian_is_the_derivative_of_the_tip_pose(arm):
    (q, qd, _), step = states(arm.n), 1e-6
    before, after = arm.tip_pose(q - step * qd), arm.tip_pose(q + step * qd)
    rate, rotation = (after - before) / (2 * step), arm.tip_pose(q)[:3, :3]
    spin = rate[:3, :3] @ rotation.T
    expected = np.concatenate([rate[:3, 3], [spin[2, 1], spin[0, 2], spin[1, 0]]])
    assert np.allclose(arm.jacobian(q) @ qd, expected, atol=1e-7)


def test_gravity_and_payload_act_at_the_tip():
    plain = newtau.load(robot_file("ur5"), gravity=(0, 0, -1.62))
    loaded = newtau.load(robot_file("ur5"), gravity=(0, 0, -1.62), payload=newtau.Payload(2.0, com=(0.1, 0, 0)))
    assert np.array_equal(plain.gravity_vector, [0, 0, -1.62])
    q, qd, qdd = states(6)
    pose, jacobian = plain.tip_pose(q), plain.jacobian(q)
    arm = pose[:3, :3] @ [0.1, 0, 0]
    point = jacobian[:3] + np.cross(jacobian[3:].T, arm).T
    assert np.allclose(loaded.gravity(q) - plain.gravity(q), point.T @ [0, 0, 2.0 * 1.62], atol=1e-12)
    linear = loaded.regressor(q, qd, qdd) @ loaded.parameters + loaded.rotor_inertia * qdd
    assert np.allclose(linear, loaded.inverse_dynamics(q, qd, qdd), rtol=1e-10)


def test_gravity_turns_with_the_base_unless_it_is_given(tmp_path):
    text = robot_file("ur5").read_text()
    assert "mounting" not in text and text.count("\n[[joint]]") >= 1
    turned = tmp_path / "wall.toml"
    # Rolled by 90 degrees: the world's -z axis is the base's -y axis.
    turned.write_text(text.replace("\n[[joint]]", "\nmounting = { rpy = [1.5707963267948966, 0.0, 0.0] }\n\n[[joint]]", 1))
    upright, wall = newtau.load(robot_file("ur5")), newtau.load(turned)
    assert np.array_equal(upright.gravity_vector, [0, 0, -9.81])
    assert np.allclose(wall.gravity_vector, [0, -9.81, 0], atol=1e-12)
    q = states(6)[0]
    assert np.allclose(wall.gravity(q), newtau.load(robot_file("ur5"), gravity=(0, -9.81, 0)).gravity(q), atol=1e-12)
    assert not np.allclose(wall.gravity(q), upright.gravity(q), atol=0.1)
    given = newtau.load(turned, gravity=(0, 0, -1.62))
    assert np.array_equal(given.gravity_vector, [0, 0, -1.62])


def test_angles_beyond_the_range_give_nan(arms):
    arm = arms["ur5"]
    assert np.isnan(arm.gravity(np.full(6, 2.0**20 + 1))).any()
    assert np.isnan(arm.gravity(np.full(6, 8193, np.float32))).any()
    assert not np.isnan(arm.gravity(np.full(6, 8191, np.float32))).any()


@pytest.mark.parametrize(
    "options, message",
    [
        ({"gravity": (0, 1)}, r"gravity: found shape \(2,\); expected \(3,\)"),
        ({"gravity": (0, 0, np.nan)}, "gravity: .*expected finite numbers"),
        ({"gravity": "down"}, "gravity: cannot convert"),
        ({"payload": newtau.Payload(-1.0)}, "payload: .*mass"),
        ({"tip": "tool0"}, "ur5.toml: tip: given for a TOML robot"),
    ],
)
def test_wrong_options_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        newtau.load(robot_file("ur5"), **options)


def test_a_wrong_file_names_line_field_found_and_expected(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(robot_file("planar2r").read_text().replace("mass = ", "mass = -", 1))
    with pytest.raises(ValueError, match=r"arm.toml:\d+:\d+: .*mass.*; expected a mass of zero or more"):
        newtau.load(file)
    with pytest.raises(ValueError, match="nowhere.toml"):
        newtau.load(tmp_path / "nowhere.toml")


def test_properties(arms):
    arm = arms["stanford"]
    assert (arm.n, arm.joint_types.count("prismatic"), len(arm.joint_names)) == (6, 1, 6)
    assert arm.position_limits.shape == (6, 2) and arm.velocity_limits.shape == arm.torque_limits.shape == (6,)
    assert "stanford" in repr(arm).lower() and arm.name
    for name in ("inverse_dynamics", "mass_matrix", "jacobian", "regressor", "tip_pose"):
        assert "shape" in getattr(type(arm), name).__doc__
