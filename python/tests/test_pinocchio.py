"""Comparison with Pinocchio, which reads the same arm from the URDF that newtau writes."""

import numpy as np
import pytest
from conftest import states

import newtau

pin = pytest.importorskip("pinocchio")


class Peer:
    """The arm as Pinocchio computes it."""

    def __init__(self, arm):
        self.model = pin.buildModelFromXML(arm.to_urdf())
        self.model.armature[:] = arm.rotor_inertia
        self.model.gravity.linear[:] = arm.gravity_vector
        self.data = self.model.createData()
        self.tip = self.model.nframes - 1

    def position(self, q):
        """A configuration: joints without limits are a cosine and a sine there."""
        turning = [joint.nq == 2 for joint in self.model.joints[1:]]
        return np.concatenate([[np.cos(x), np.sin(x)] if turns else [x] for x, turns in zip(q, turning)])

    def inverse_dynamics(self, q, qd, qdd):
        return pin.rnea(self.model, self.data, self.position(q), qd, qdd).copy()

    def mass_matrix(self, q):
        upper = np.triu(pin.crba(self.model, self.data, self.position(q)))
        return upper + np.triu(upper, 1).T

    def forward_dynamics(self, q, qd, tau):
        return pin.aba(self.model, self.data, self.position(q), qd, tau).copy()

    def jacobian(self, q):
        frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.computeFrameJacobian(self.model, self.data, self.position(q), self.tip, frame).copy()

    def tip_pose(self, q):
        pin.framesForwardKinematics(self.model, self.data, self.position(q))
        return self.data.oMf[self.tip].homogeneous


def error(found, expected):
    """Largest difference, relative to the largest number."""
    return np.abs(found - expected).max() / np.abs(expected).max()


def test_all_functions_agree(arm):
    peer = Peer(arm)
    lists = states(arm.n, 200)
    for name, inputs in [("inverse_dynamics", 3), ("mass_matrix", 1), ("forward_dynamics", 3), ("jacobian", 1), ("tip_pose", 1)]:
        found = getattr(arm, name)(*lists[:inputs])
        expected = np.array([getattr(peer, name)(*row) for row in zip(*lists[:inputs])])
        assert error(found, expected) < 1e-9, name


def test_single_precision_agrees_to_its_own_rounding(arms):
    arm = arms["ur5"]
    lists = states(6, 200, np.float32)
    expected = np.array([Peer(arm).inverse_dynamics(*row) for row in zip(*(each.astype(np.float64) for each in lists))])
    assert 1e-9 < error(arm.inverse_dynamics(*lists), expected) < 2e-6


def test_another_mass_is_noticed(arms, tmp_path):
    text = arms["ur5"].to_urdf()
    # The first link turns about a vertical axis; the second one is lifted.
    second = text.split('<mass value="')[2]
    mass, rest = second.split('"', 1)
    changed = text.replace(f'<mass value="{mass}"{rest}', f'<mass value="{float(mass) * 1.001}"{rest}')
    assert changed != text
    file = tmp_path / "arm.urdf"
    file.write_text(changed)
    lists = states(6, 50)
    peer = Peer(arms["ur5"])
    expected = np.array([peer.inverse_dynamics(*row) for row in zip(*lists)])
    assert error(newtau.load(file).inverse_dynamics(*lists), expected) > 1e-6


def test_a_urdf_is_the_same_arm(arm, tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(arm.to_urdf())
    again = newtau.load(file)
    lists = states(arm.n, 20)
    assert error(again.inverse_dynamics(*lists), arm.inverse_dynamics(*lists)) < 1e-12
    with pytest.raises(ValueError, match="nowhere"):
        newtau.load(file, tip="nowhere")
