#!/usr/bin/env python3
"""Joint torques of URDF arms from Pinocchio, for `tests/urdf_corpus.rs`.

Usage: python tests/tools/urdf_torques.py FOLDER > tests/data/urdf_torques.txt
needs `pip install pin`; FOLDER is the one that `example-robot-data` was unpacked into. Three random states per arm:
joint positions within 2 rad (prismatic 0.3 m), velocities within 2, accelerations within 5, gravity -9.81 along z.
Joints beside the chain are held at zero (`buildReducedModel`).
"""
import pathlib
import sys

import numpy as np
import pinocchio as pin

ARMS = [
    ("asr_twodof_description/urdf/TwoDofs.urdf", None, []),
    ("finger_edu_description/robots/finger_edu.urdf", None, []),
    ("hextilt_description/urdf/hextilt_flying_arm_5.urdf", None, []),
    ("kinova_description/robots/kinova.urdf", None, []),
    ("so_arm_description/urdf/so101.urdf", None, []),
    ("ur_description/urdf/ur3_robot.urdf", None, []),
    ("ur_description/urdf/ur5_robot.urdf", None, []),
    ("ur_description/urdf/ur5_gripper.urdf", None, []),
    ("ur_description/urdf/ur10_robot.urdf", None, []),
    ("pr2_description/urdf/pr2.urdf", "head_tilt_link", ["torso_lift_joint", "head_pan_joint", "head_tilt_joint"]),
]


def main():
    folder = pathlib.Path(sys.argv[1])
    random = np.random.default_rng(2024)
    print("# URDF file; tip link; q; qd; qdd; tau. Pinocchio", pin.__version__, "rnea on files of example-robot-data 6.0.0")
    for name, tip, keep in ARMS:
        model = pin.buildModelFromUrdf(str(next(folder.rglob(pathlib.Path(name).name))))
        if keep:
            locked = [model.getJointId(j) for j in list(model.names)[1:] if j not in keep]
            model = pin.buildReducedModel(model, locked, pin.neutral(model))
            assert list(model.names)[1:] == keep, list(model.names)
        data = model.createData()
        for _ in range(3):
            angle = random.uniform(-2, 2, model.nv)
            # A continuous joint is a cosine and a sine in Pinocchio.
            q = pin.integrate(model, pin.neutral(model), angle)
            qd, qdd = random.uniform(-2, 2, model.nv), random.uniform(-5, 5, model.nv)
            tau = pin.rnea(model, data, q, qd, qdd)
            columns = [" ".join(f"{x:.17g}" for x in v) for v in (angle, qd, qdd, tau)]
            print("; ".join([name, tip or "-", *columns]))


main()
