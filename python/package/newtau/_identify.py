"""Identification of an arm's model from logs of its motion."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Union

import numpy as np

from . import _newtau
from ._files import Path, reject_masked, vector


@dataclass(frozen=True)
class Reason:
    """A reason for a verdict that is not "trusted".

    Attributes:
        kind: Short name, such as "little_motion".
        grade: The verdict that this reason causes.
        text: The reason in words.
        options: Options of the command line that correct the logs, one list for each possible explanation.
    """

    kind: str
    grade: str
    text: str
    options: List[Any] = field(default_factory=list)


@dataclass(frozen=True)
class Parameter:
    """A base parameter: a combination of inertial parameters that the torques depend on. SI units.

    Attributes:
        name: The combination.
        value: The value of physically consistent bodies.
        least_squares: The value before physical consistency is enforced.
        deviation: Standard deviation of the least-squares value.
        before: The value of the robot file.
    """

    name: str
    value: float
    least_squares: float
    deviation: float
    before: float


@dataclass(frozen=True)
class Identification:
    """An identified model.

    Attributes:
        robot: Name of the arm.
        verdict: "trusted", "doubtful" or "refused".
        reasons: Reasons for the verdict, the worst first; empty if it is "trusted".
        parameters: Base parameters.
        joints: For each joint its torque errors and its friction, as ``newtau identify --json`` prints them.
        robot_file: Text of a robot file (TOML) with the identified numbers; None unless the model is trusted, or doubtful and
            accepted.
        notes: How the logs were interpreted.
        details: All results, as ``newtau identify --json`` prints them.
    """

    robot: str
    verdict: str
    reasons: List[Reason]
    parameters: List[Parameter]
    joints: List[Dict[str, Any]] = field(repr=False)
    robot_file: Optional[str] = field(repr=False)
    notes: List[str] = field(repr=False)
    details: Dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class _Request:
    robot: str
    logs: List[str]
    validate: List[str]
    tip: Optional[str]
    base: Optional[str]
    gravity: Optional[Sequence[float]]
    degrees: bool
    torque_per_ampere: Optional[List[float]]
    columns: Optional[str]
    trust: float
    plain_friction: bool
    accept_doubtful: bool


def _paths(files: Union[Path, Sequence[Path]]) -> List[str]:
    if isinstance(files, (str, os.PathLike)):
        return [os.fspath(files)]
    return [os.fspath(file) for file in files]


def _torque_constants(value: Union[float, Sequence[float], None]) -> Optional[List[float]]:
    """Returns one number for all joints, or one for each joint; None if there is none."""
    if value is None:
        return None
    reject_masked("torque_per_ampere", value)
    expected = "expected one number for all joints, or a list with one number for each joint, N m/A"
    try:
        constants = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"torque_per_ampere: found {value!r} ({error}); {expected}") from None
    if constants.ndim > 1:
        raise ValueError(f"torque_per_ampere: found shape {constants.shape}; {expected}")
    return [float(k) for k in np.atleast_1d(constants)]


def identify(
    robot: Path,
    logs: Union[Path, Sequence[Path]],
    *,
    validate: Union[Path, Sequence[Path]] = (),
    tip: Optional[str] = None,
    base: Optional[str] = None,
    gravity: Optional[Sequence[float]] = None,
    degrees: bool = False,
    torque_per_ampere: Union[float, Sequence[float], None] = None,
    columns: Optional[str] = None,
    trust: float = 0.3,
    plain_friction: bool = False,
    accept_doubtful: bool = False,
) -> Identification:
    """Estimates masses, inertias and friction of an arm from logs of its motion, as ``newtau identify`` does.

    A log is a text file with a header: time, and for each joint position and torque (or current), optionally velocity.

    Args:
        robot: A URDF file or a robot file. Its geometry is used unchanged; its masses are the starting values.
        logs: Log files to identify from.
        validate: Log files to judge the result with.
        tip: For a URDF file: the link at the tip of the arm.
        base: For a URDF file: the link at the base of the arm.
        gravity: Gravitational acceleration in the base frame, m/s^2, shape (3,).
        degrees: True if the logs have angles in degrees.
        torque_per_ampere: Torque per ampere, N m/A: one number for all joints, or a list with one number for each joint. For logs with
            currents instead of torques. The default is the torque constant of the robot file.
        columns: Names of the columns, such as ``"q=pos_{},tau=effort_{},t=stamp"``.
        trust: Relative uncertainty of the masses and second moments in the robot file.
        plain_friction: True to use offset, viscous and Coulomb friction only.
        accept_doubtful: True to get a robot file from a doubtful model too.

    Raises:
        ValueError: A file cannot be read, or a log is wrong.
    """
    request = _Request(
        robot=os.fspath(robot),
        logs=_paths(logs),
        validate=_paths(validate),
        tip=tip,
        base=base,
        gravity=vector("gravity", gravity),
        degrees=bool(degrees),
        torque_per_ampere=_torque_constants(torque_per_ampere),
        columns=columns,
        trust=float(trust),
        plain_friction=bool(plain_friction),
        accept_doubtful=bool(accept_doubtful),
    )
    found = json.loads(_newtau.identify(request))
    verdict = found["verdict"]
    return Identification(
        robot=found["robot"],
        verdict=verdict["grade"],
        reasons=[Reason(**reason) for reason in verdict["reasons"]],
        parameters=[Parameter(**parameter) for parameter in found.get("parameters", [])],
        joints=found.get("joints", []),
        robot_file=found.get("robot_file"),
        notes=found.get("notes", []),
        details=found,
    )
