"""Time of inverse dynamics: newtau, a loop over Pinocchio's rnea, and a loop over dynibo, in one run.

    python python/bench.py [ROBOT ...]

Prints a table in Markdown. Every number is the smallest of several repetitions, in ns for each state.
"""

import os
import platform
import sys
import tempfile
import timeit
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pinocchio as pin

import newtau

ROBOTS = Path(__file__).resolve().parents[1] / "robots"


def nanoseconds(call, states):
    """Smallest time of a call, ns for each state."""
    timer = timeit.Timer(call)
    count, _ = timer.autorange()
    return min(timer.repeat(9, max(1, count // 4))) / max(1, count // 4) / states * 1e9


def pinocchio(arm):
    """The model of the arm, and a loop over its states."""
    model = pin.buildModelFromXML(arm.to_urdf())
    model.armature[:] = arm.rotor_inertia
    data = model.createData()

    def loop(q, qd, qdd):
        for k in range(len(q)):
            pin.rnea(model, data, q[k], qd[k], qdd[k])

    return model, loop


def dynibo_loop(arm):
    """A loop over dynibo's inverse dynamics; None if it is not installed or does not read the arm."""
    try:
        import dynibo

        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(arm.to_urdf())
            file.flush()
            robot = dynibo.Robot.from_urdf(file.name)
    except Exception as error:  # noqa: BLE001 - a peer that fails is left out, with its reason
        print(f"dynibo is left out: {type(error).__name__}: {error}", file=sys.stderr)
        return None

    def loop(q, qd, qdd):
        for k in range(len(q)):
            robot.inverse_dynamics(q[k], qd[k], qdd[k])

    return loop


def rows(name):
    """Rows of the table for one arm."""
    arm = newtau.load(ROBOTS / f"{name}.toml")
    model, loop = pinocchio(arm)
    if model.nq != arm.n:
        raise SystemExit(f"{name}: a joint without limits; Pinocchio has another configuration for it")
    other = dynibo_loop(arm)
    random = np.random.default_rng(0)
    for batch in (1, 100, 10_000):
        double = [random.uniform(-2, 2, (batch, arm.n)) for _ in range(3)]
        single = [each.astype(np.float32) for each in double]
        expected = np.array([pin.rnea(model, model.createData(), *row).copy() for row in zip(*double)][:100])
        error = np.abs(arm.inverse_dynamics(*double)[:100] - expected).max() / np.abs(expected).max()
        if not error < 1e-9:
            raise SystemExit(f"{name}: newtau and Pinocchio differ by {error:.1e}")
        theirs = nanoseconds(lambda: loop(*double), batch)
        third = nanoseconds(lambda: other(*double), batch) if other else None
        one = (lambda lists: [each[0] for each in lists]) if batch == 1 else (lambda lists: lists)
        ours = []
        for lists in (one(double), one(single)):
            out = np.empty_like(lists[0])
            ours.append(nanoseconds(lambda: arm.inverse_dynamics(*lists, out=out), batch))
        yield name, batch, theirs, third, *ours


def main():
    print("| arm | states | loop over `pin.rnea` | loop over dynibo | newtau float64 | times faster | newtau float32 | times faster |")
    print("|---|---|---|---|---|---|---|---|")
    for name in sys.argv[1:] or ["ur5", "puma560"]:
        for arm, batch, theirs, third, double, single in rows(name):
            middle = f"{third:,.0f}" if third else "-"
            print(
                f"| {arm} | {batch:,} | {theirs:,.0f} | {middle} | {double:,.0f} | {theirs / double:.1f} "
                f"| {single:,.0f} | {theirs / single:.1f} |"
            )
    packages = ", ".join(f"{each} {version(each)}" for each in ("newtau", "pin", "numpy", "dynibo") if each != "dynibo" or "dynibo" in sys.modules)
    print(f"\n{packages}, Python {platform.python_version()}, {platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
