#!/usr/bin/env python3
"""Steps of MuJoCo for an arm of ours: what they cost, their errors, and whether they go where ours go.

    mujoco_steps.py ROBOT SCENE LOG_WITH_FRICTION LOG_WITHOUT

Builds the arm of a robot file, with the payload of the scene's model, as MuJoCo's own model: nothing is shared with the project's reader. The
torques are those of the logs, held for a tick. Prints a JSON object: for each method and friction the nanoseconds of a step and, for each length
of a step, the largest difference in position from MuJoCo's own finest integration; and how far that is from our logs.
"""

import csv
import json
import pathlib
import sys
import time
import tomllib

import mujoco
import numpy as np

STEPS = 20_000
REPEATS = 5
# Lengths of a step, s, of which the control period is a multiple; the last is the reference.
LENGTHS = [1e-3 / 2**k for k in range(6)]
FINEST = 1e-3 / 2**8


def turn(axis, angle):
    quaternion, matrix = np.zeros(4), np.zeros(9)
    mujoco.mju_axisAngle2Quat(quaternion, np.array(axis, float), angle)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def tensor(body):
    inertia = body.get("inertia", {})
    get = lambda key: float(inertia.get(key, 0.0))
    xx, yy, zz, xy, xz, yz = (get(key) for key in ("xx", "yy", "zz", "xy", "xz", "yz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def joined(bodies):
    """Mass, mass centre and inertia about it of bodies that move as one."""
    mass = sum(body[0] for body in bodies)
    centre = sum(body[0] * body[1] for body in bodies) / mass
    inertia = np.zeros((3, 3))
    for own, place, about in bodies:
        arm = place - centre
        inertia += about + own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, centre, inertia


def numbers(values):
    return " ".join(repr(float(x)) for x in np.asarray(values).flatten())


def build(robot, payload, step, method, rubs):
    """The arm as a model of MuJoCo's: classical DH, the joint's frame before the link's own."""
    opened, tensors, origin, rotation = [], [], np.zeros(3), np.eye(3)
    joints = robot["joint"]
    for number, joint in enumerate(joints):
        dh = joint["dh"]
        theta, alpha = float(dh.get("theta", 0.0)), float(dh.get("alpha", 0.0))
        link = turn([0, 0, 1], theta) @ turn([1, 0, 0], alpha)
        reach = turn([0, 0, 1], theta) @ np.array([float(dh.get("a", 0.0)), 0.0, float(dh.get("d", 0.0))])
        bodies = [(float(joint["mass"]), link @ np.array(joint["com"], float) + reach, link @ tensor(joint) @ link.T)]
        if number + 1 == len(joints) and payload:
            about = link @ tensor(payload) @ link.T
            bodies.append((float(payload["mass"]), link @ np.array(payload["com"], float) + reach, about))
        mass, centre, inertia = joined([body for body in bodies if body[0] > 0] or [(1e-9, *bodies[0][1:])])
        principal, axes = np.linalg.eigh(inertia)
        tensors.append((principal, axes * np.sign(np.linalg.det(axes))))
        rotor, friction = joint.get("rotor", {}), joint.get("friction", {})
        armature = float(rotor.get("inertia", 0.0)) * float(rotor.get("gear", 1.0)) ** 2
        rubbing = f'damping="{friction.get("viscous", 0.0)}" frictionloss="{friction.get("coulomb", 0.0)}"' if rubs else ""
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, rotation.flatten())
        opened.append(
            f'<body pos="{numbers(origin)}" quat="{numbers(quaternion)}"><inertial pos="{numbers(centre)}" mass="{mass!r}" '
            f'diaginertia="1 1 1"/><joint axis="0 0 1" armature="{armature!r}" {rubbing}/>'
        )
        origin, rotation = reach, link
    text = (
        f'<mujoco><compiler angle="radian" boundmass="0" boundinertia="0"/>'
        f'<option timestep="{step}" integrator="{method}" gravity="0 0 -9.81"><flag contact="disable"/></option>'
        f'<worldbody>{"".join(opened)}{"</body>" * len(opened)}</worldbody></mujoco>'
    )
    model = mujoco.MjModel.from_xml_string(text)
    # Written afterwards: the compiler refuses tensors that no body has, and two links' of the Puma's published ones are such.
    for body, (principal, axes) in enumerate(tensors, start=1):
        model.body_inertia[body] = principal
        mujoco.mju_mat2Quat(model.body_iquat[body], axes.flatten())
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def nanoseconds(model, start):
    """The fastest of some repeats, each of many steps within MuJoCo."""
    best = float("inf")
    for _ in range(REPEATS):
        data = mujoco.MjData(model)
        data.qpos[:] = start
        began = time.perf_counter()
        mujoco.mj_step(model, data, STEPS)
        best = min(best, time.perf_counter() - began)
    return best / STEPS * 1e9


def read(path):
    """Torques and positions of a log, tick by tick, and the length of a tick."""
    rows = list(csv.DictReader(path.open()))
    joints = range(1, 1 + sum(name.startswith("tau") for name in rows[0]))
    torques = np.array([[float(row[f"tau{k}"]) for k in joints] for row in rows])
    positions = np.array([[float(row[f"q{k}"]) for k in joints] for row in rows])
    return torques, positions, float(rows[1]["t"]) - float(rows[0]["t"])


def path(model, log, step):
    """Positions at the ticks of a log under its torques."""
    torques, positions, tick = log
    data = mujoco.MjData(model)
    model.opt.timestep = step
    data.qpos[:] = positions[0]
    found = [data.qpos.copy()]
    for torque in torques[:-1]:
        data.qfrc_applied[:] = torque
        mujoco.mj_step(model, data, round(tick / step))
        found.append(data.qpos.copy())
    return np.array(found)


def apart(one, other):
    return float(np.abs(one - other).max())


def main():
    robot, scene = (tomllib.loads(pathlib.Path(path).read_text()) for path in sys.argv[1:3])
    payload = scene.get("model", {}).get("payload")
    logs = {True: read(pathlib.Path(sys.argv[3])), False: read(pathlib.Path(sys.argv[4]))}
    start = scene["motion"]["points"][0]["q"]
    model = lambda method, rubs: build(robot, payload, LENGTHS[2], method, rubs)
    finest = {rubs: path(model("RK4", rubs), logs[rubs], FINEST) for rubs in (False, True)}
    steps = [
        {
            "method": method,
            "friction": rubs,
            "ns": nanoseconds(model(method, rubs), start),
            "errors": [[step, apart(path(model(method, rubs), logs[rubs], step), finest[rubs])] for step in LENGTHS],
        }
        for method in ("RK4", "Euler")
        for rubs in (False, True)
    ]
    far = {rubs: apart(finest[rubs], logs[rubs][1]) for rubs in (False, True)}
    print(json.dumps({"version": mujoco.__version__, "steps": steps, "apart": far[False], "apart_with_friction": far[True]}))


if __name__ == "__main__":
    main()
