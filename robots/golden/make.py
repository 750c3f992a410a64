#!/usr/bin/env python3
"""Reference data for the arms in robots/, from Pinocchio.

    python3 -m venv venv && venv/bin/pip install pin==4.1.0
    venv/bin/python robots/golden/make.py robots/*.toml        # writes shipped/ and regressor/ here

Reads the robot files with Python's own TOML parser and builds the arm with Pinocchio's own joints, so it shares
nothing with the project's code. Fields and conventions: robots/golden/README.md. The states are seeded by the arm's name.
"""

import json
import math
import pathlib
import random
import sys
import tomllib

import numpy as np
import pinocchio as pin

STATES = 20
REGRESSORS = 3
GRAVITY = np.array([0.0, 0.0, -9.81])


def turn(axis, angle):
    """Rotation about a coordinate axis; right angles exact, as in the project's own reading of a table."""
    s, c = (0.0 if abs(v) < 1e-15 else v for v in (math.sin(angle), math.cos(angle)))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    r = np.eye(3)
    r[i, i], r[i, j], r[j, i], r[j, j] = c, -s, s, c
    return r


def shift(axis, length):
    p = np.zeros(3)
    p[axis] = length
    return pin.SE3(np.eye(3), p)


def rotated(axis, angle):
    return pin.SE3(turn(axis, angle), np.zeros(3))


def frames(joint):
    """(parent link frame -> joint frame, joint frame -> link frame), the joint about or along z or the given axis."""
    identity = pin.SE3.Identity()
    if "dh" in joint:
        row = joint["dh"]
        after = rotated(2, row.get("theta", 0)) * shift(2, row.get("d", 0))
        return identity, after * shift(0, row.get("a", 0)) * rotated(0, row.get("alpha", 0)), np.array([0.0, 0.0, 1.0])
    if "mdh" in joint:
        row = joint["mdh"]
        before = rotated(0, row.get("alpha", 0)) * shift(0, row.get("a", 0))
        return before, rotated(2, row.get("theta", 0)) * shift(2, row.get("d", 0)), np.array([0.0, 0.0, 1.0])
    return placement(joint["placement"]), identity, np.array(joint["axis"], dtype=float)


def placement(table):
    roll, pitch, yaw = table.get("rpy", [0, 0, 0])
    rotation = turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)
    return pin.SE3(rotation, np.array(table.get("xyz", [0, 0, 0]), dtype=float))


def inertia(table):
    t = table.get("inertia", {})
    g = lambda key: float(t.get(key, 0.0))
    tensor = np.array([[g("xx"), g("xy"), g("xz")], [g("xy"), g("yy"), g("yz")], [g("xz"), g("yz"), g("zz")]])
    return pin.Inertia(float(table.get("mass", 0.0)), np.array(table.get("com", [0, 0, 0]), dtype=float), tensor)


def build(robot):
    """The Pinocchio model, the tip frame's id, and the reflected rotor inertias."""
    model = pin.Model()
    model.gravity.linear = GRAVITY
    parent, link = 0, pin.SE3.Identity()
    rotor = []
    for joint in robot["joint"]:
        before, after, axis = frames(joint)
        kind = pin.JointModelRevoluteUnaligned if joint["type"] == "revolute" else pin.JointModelPrismaticUnaligned
        parent = model.addJoint(parent, kind(axis), link * before, joint["name"])
        link = after
        model.appendBodyToJoint(parent, inertia(joint), link)
        motor = joint.get("rotor", {"inertia": 0.0, "gear": 0.0})
        rotor.append(motor["gear"] ** 2 * motor["inertia"])
    tool = robot.get("tool", {})
    tip = link * placement(tool.get("placement", tool))
    model.appendBodyToJoint(parent, inertia(tool), tip)
    frame = model.addFrame(pin.Frame("tip", parent, 0, tip, pin.FrameType.OP_FRAME))
    return model, frame, np.array(rotor)


def drawn(rng, joint):
    """A position inside the limits; a whole turn, or 0.1 to 0.8 m, where there are none."""
    low, high = joint.get("limits", {}).get("position", [-math.inf, math.inf])
    free = (-math.pi, math.pi) if joint["type"] == "revolute" else (0.1, 0.8)
    return rng.uniform(low if math.isfinite(low) else free[0], high if math.isfinite(high) else free[1])


def state(model, frame, rotor, robot, rng):
    data = model.createData()
    n = model.nv
    q = np.array([drawn(rng, joint) for joint in robot["joint"]])
    qd, qdd = (np.array([rng.uniform(-size, size) for _ in range(n)]) for size in (2.0, 5.0))
    wrench = np.array([rng.uniform(-30, 30) for _ in range(3)] + [rng.uniform(-5, 5) for _ in range(3)])
    tau = pin.rnea(model, data, q, qd, qdd)
    gravity = pin.computeGeneralizedGravity(model, data, q).copy()
    nle = pin.nonLinearEffects(model, data, q, qd).copy()
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T + np.diag(rotor)
    pin.framesForwardKinematics(model, data, q)
    tip = data.oMf[frame].copy()
    jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.ReferenceFrame.LOCAL)
    tau_in = np.array([rng.uniform(-1, 1) for _ in range(n)]) * np.abs(tau).max()
    tau = tau + rotor * qdd
    numbers = {
        "q": q, "qd": qd, "qdd": qdd, "tau_in": tau_in, "wrench_tip": wrench,
        "tau": tau, "gravity": gravity, "coriolis_qd": nle - gravity, "M": mass,
        "qdd_fd": np.linalg.solve(mass, tau_in - nle),
        "tau_wrench": tau - jacobian.T @ wrench,
        "qdd_fd_wrench": np.linalg.solve(mass, tau_in + jacobian.T @ wrench - nle),
        "tip_R": tip.rotation, "tip_p": tip.translation,
    }
    return {key: value.tolist() for key, value in numbers.items()}


def regressor(model, head, states):
    """Pinocchio's own columns at the first states: the entries row by row, joint by joint."""
    data = model.createData()
    rows = []
    for s in states[:REGRESSORS]:
        motion = [np.array(s[key]) for key in ("q", "qd", "qdd")]
        matrix = pin.computeJointTorqueRegressor(model, data, *motion)
        rows.append({**{key: s[key] for key in ("q", "qd", "qdd")}, "regressor": matrix.tolist()})
    lines = ",\n".join("  " + json.dumps(row) for row in rows)
    return json.dumps(head)[:-1] + ',\n "states": [\n' + lines + "\n ]}\n"


def main():
    folder = pathlib.Path(__file__).parent / "shipped"
    columns = pathlib.Path(__file__).parent / "regressor"
    folder.mkdir(exist_ok=True)
    columns.mkdir(exist_ok=True)
    for path in map(pathlib.Path, sys.argv[1:]):
        robot = tomllib.loads(path.read_text())
        model, frame, rotor = build(robot)
        rng = random.Random(path.stem)
        states = [state(model, frame, rotor, robot, rng) for _ in range(STATES)]
        head = {"robot": path.stem, "generator": f"pinocchio {pin.__version__} (f64)", "gravity": GRAVITY.tolist()}
        lines = ",\n".join("  " + json.dumps(s) for s in states)
        text = json.dumps(head)[:-1] + ',\n "states": [\n' + lines + "\n ]}\n"
        (folder / f"{path.stem}.json").write_text(text)
        (columns / f"{path.stem}.json").write_text(regressor(model, head, states))
        print(f"{path}: {len(states)} states")


if __name__ == "__main__":
    main()
