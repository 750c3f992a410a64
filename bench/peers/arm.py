#!/usr/bin/env python3
"""A robot file as plain numbers for the peers, one joint a line.

    arm.py robots/ur5.toml OUTPUT

Reads the file as robots/golden/make.py does, sharing nothing with the project's own reader. A line is

    rotation of the joint in its parent's frame (9, row by row), its origin there (3),
    mass, mass centre (3), inertia about it (xx xy xz yy yz zz), both in the joint's own frame

and every joint turns about its own z. What is mounted on the last link is part of it; rotors are left out.
"""

import pathlib
import sys
import tomllib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "robots/golden"))
import make  # noqa: E402

Z = np.array([0.0, 0.0, 1.0])


def lines(robot):
    link = make.pin.SE3.Identity()
    joints = []
    for joint in robot["joint"]:
        before, after, axis = make.frames(joint)
        if joint["type"] != "revolute" or not np.array_equal(axis, Z):
            sys.exit(f"{joint['name']}: the peers' harness knows joints that turn about z alone")
        joints.append((link * before, make.inertia(joint).se3Action(after)))
        link = after
    tool = robot.get("tool", {})
    tip = link * make.placement(tool.get("placement", tool))
    place, body = joints[-1]
    held = make.inertia(tool)
    if held.mass > 0:
        joints[-1] = (place, body + held.se3Action(tip))
    for place, body in joints:
        centre = body.lever if body.mass > 0 else np.zeros(3)
        yield [*place.rotation.flatten(), *place.translation, body.mass, *centre, *body.inertia[np.triu_indices(3)]]


def snapped(number):
    """Dust of a product of rotations to zero: a generator must not keep terms that the arm does not have."""
    return 0.0 if abs(number) < 1e-15 else number


def main():
    robot = tomllib.loads(pathlib.Path(sys.argv[1]).read_text())
    text = "".join(" ".join(repr(float(snapped(number))) for number in line) + "\n" for line in lines(robot))
    pathlib.Path(sys.argv[2]).write_text(text)


if __name__ == "__main__":
    main()
