"""Arms and states that the tests share."""

from pathlib import Path

import numpy as np
import pytest

import newtau

ROOT = Path(__file__).resolve().parents[2]
ROBOTS = ["planar2r", "planar3r", "puma560", "scara", "stanford", "ur5"]


def robot_file(name):
    """Path of a robot file of this repository."""
    return ROOT / "robots" / f"{name}.toml"


@pytest.fixture(scope="session")
def arms():
    """Arms by name."""
    return {name: newtau.load(robot_file(name)) for name in ROBOTS}


@pytest.fixture(params=ROBOTS)
def arm(request, arms):
    """Every arm in turn."""
    return arms[request.param]


def states(n, batch=None, dtype=np.float64, seed=1):
    """Random q, qd and a third list, each with shape (n,) or (batch, n)."""
    random = np.random.default_rng(seed)
    shape = (n,) if batch is None else (batch, n)
    return [random.uniform(-3.0, 3.0, shape).astype(dtype) for _ in range(3)]


def same_bits(a, b):
    """True if both arrays have the same type, shape and bits."""
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
