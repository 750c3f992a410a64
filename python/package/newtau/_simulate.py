"""Simulation of a scene."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional

import numpy as np

from . import _newtau
from ._files import Path


@dataclass(frozen=True)
class Simulation:
    """A simulated run of a scene: the closed loop of controller, drives and arm.

    Attributes:
        scene: Name of the scene.
        robot: Name of the arm.
        joint_names: Names of the joints, base first.
        period: Control period, s.
        duration: Simulated time, s.
        tracking_rms: Root mean square of reference minus actual position of each joint, rad or m, shape (n,).
        tracking_max: Largest magnitude of this error, rad or m, shape (n,).
        torque_rms: Root mean square of the commanded torque of each joint, N m or N, shape (n,).
        torque_peak: Largest magnitude of this torque, N m or N, shape (n,).
        faults: Faults, each with its tick: the arm brakes from then on.
        stopped: Reason for an early end; None if the run was complete.
        summary: All numbers of the summary, as ``newtau run --json`` prints them.
        record: One entry for each tick. Fields: ``t`` (s); ``q``, ``qd``, ``q_reference``, ``qd_reference`` (rad, m and their
            rates) and ``tau`` (commanded torque, N m or N), each with shape (n,); ``limits`` (shape (n,): sum of 1 position,
            2 velocity, 4 torque, 8 torque rate, 16 collision); ``fault`` (code, 0 for none); with an observer of external torques
            also ``tau_external`` (N m or N, shape (n,)).
    """

    scene: str
    robot: str
    joint_names: List[str]
    period: float
    duration: float
    tracking_rms: np.ndarray
    tracking_max: np.ndarray
    torque_rms: np.ndarray
    torque_peak: np.ndarray
    faults: List[Dict[str, Any]]
    stopped: Optional[str]
    summary: Dict[str, Any] = field(repr=False)
    record: np.ndarray = field(repr=False)


def _record(columns: Dict[str, np.ndarray], joints: int) -> np.ndarray:
    """Joins the columns to a structured array."""
    ticks = len(columns["t"])
    single = {"t", "fault"}
    fields = [(name, column.dtype, () if name in single else (joints,)) for name, column in columns.items()]
    record = np.empty(ticks, dtype=np.dtype(fields, align=True))
    for name, column in columns.items():
        record[name] = column if name in single else column.reshape(ticks, joints)
    return record


def simulate(scene: Path, duration: Optional[float] = None) -> Simulation:
    """Runs a scene on this computer, as ``newtau run`` does, and writes no file.

    Ctrl-C ends the run with KeyboardInterrupt.

    Args:
        scene: A scene file (TOML).
        duration: Simulated time, s. The default is the scene's.

    Raises:
        ValueError: The scene is wrong or cannot be run. The message has file, line and field, what was found and what was expected.
    """
    text, names, columns = _newtau.simulate(os.fspath(scene), None if duration is None else float(duration))
    summary = json.loads(text)
    vectors = {
        name: np.array(summary[name], dtype=np.float64)
        for name in ("tracking_rms", "tracking_max", "torque_rms", "torque_peak")
    }
    return Simulation(
        scene=summary["scene"],
        robot=summary["robot"],
        joint_names=names,
        period=summary["period"],
        duration=summary["duration"],
        faults=summary["faults"],
        stopped=summary["stopped"],
        summary=summary,
        record=_record(columns, len(names)),
        **vectors,
    )
