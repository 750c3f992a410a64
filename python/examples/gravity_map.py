"""Gravity torque of a UR5 over shoulder and elbow angles, drawn with matplotlib.

    python python/examples/gravity_map.py [FILE.png]

Without a file name, a window opens.
"""

import sys
from pathlib import Path

import numpy as np

import newtau


def shoulder_torques(arm, count=200):
    """Returns the two axes (rad) and the magnitude of the second joint's gravity torque (N m) on their grid."""
    axis = np.linspace(-np.pi, np.pi, count)
    shoulder, elbow = np.meshgrid(axis, axis)
    q = np.zeros((count * count, arm.n))
    q[:, 1], q[:, 2] = shoulder.ravel(), elbow.ravel()
    # One call for all postures.
    return axis, np.abs(arm.gravity(q)[:, 1]).reshape(count, count)


def main():
    import matplotlib

    if len(sys.argv) > 1:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    arm = newtau.load(Path(__file__).resolve().parents[2] / "robots" / "ur5.toml", payload=newtau.Payload(3.0))
    axis, torque = shoulder_torques(arm)
    figure, axes = plt.subplots(figsize=(6, 5), layout="constrained")
    image = axes.pcolormesh(np.degrees(axis), np.degrees(axis), torque, shading="nearest")
    limit = arm.torque_limits[1]
    if np.isfinite(limit) and torque.max() > limit:
        axes.contour(np.degrees(axis), np.degrees(axis), torque, levels=[limit], colors="red")
    axes.set(xlabel=f"{arm.joint_names[1]}, degrees", ylabel=f"{arm.joint_names[2]}, degrees")
    axes.set_title(f"{arm.name} with 3 kg: torque that holds {arm.joint_names[1]}")
    figure.colorbar(image, label="N m")
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=120)
    else:
        plt.show()


if __name__ == "__main__":
    main()
