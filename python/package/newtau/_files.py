"""Robot files, gravity and payload."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Optional, Sequence, Tuple, Union

import numpy as np

from . import _newtau

Path = Union[str, "os.PathLike[str]"]
Triple = Tuple[float, float, float]


@dataclass(frozen=True)
class Payload:
    """A body at the tip of an arm, in the axes of the tip frame.

    Attributes:
        mass: Mass, kg.
        com: Mass centre in the tip frame, m, shape (3,).
        inertia: Inertia tensor about the mass centre, kg m^2, shape (3, 3). The default is a point mass.
    """

    mass: float
    com: Sequence[float] = (0.0, 0.0, 0.0)
    inertia: Sequence[Sequence[float]] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def reject_masked(name: str, value: object) -> None:
    """Raises TypeError for a masked array, because NumPy would read the numbers under its mask."""
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name}: found a masked array; expected numbers without a mask, such as {name}.filled(0.0)")


def numbers(name: str, value: object, shape: Tuple[int, ...]) -> np.ndarray:
    """Returns an array of float64; raises ValueError with the argument's name if its shape is another one."""
    reject_masked(name, value)
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: cannot convert {value!r} to an array of numbers: {error}") from None
    if array.shape != shape:
        raise ValueError(f"{name}: found shape {array.shape}; expected {shape}")
    return array


def vector(name: str, value: Optional[Sequence[float]]) -> Optional[Triple]:
    """Returns three numbers, or None."""
    if value is None:
        return None
    x, y, z = numbers(name, value, (3,)).tolist()
    return x, y, z


def load(
    path: Path,
    *,
    tip: Optional[str] = None,
    base: Optional[str] = None,
    gravity: Optional[Sequence[float]] = None,
    payload: Optional[Payload] = None,
) -> _newtau.Arm:
    """Reads an arm from a robot file.

    Args:
        path: A URDF file (``.urdf``, ``.xml``) or a robot file (``.toml``).
        tip: For a URDF file: the link at the tip of the arm. The default is the end of the only chain.
        base: For a URDF file: the link at the base of the arm. The default is the root.
        gravity: Gravitational acceleration in the base frame, m/s^2, shape (3,). The default is (0, 0, -9.81), turned if the file
            turns the base.
        payload: A body at the tip. The default is none.

    Raises:
        ValueError: The file cannot be read, is wrong, or describes no possible arm. The message has file, line, column and field,
            what was found, and what was expected.
    """
    body = None
    if payload is not None:
        inertia = numbers("payload.inertia", payload.inertia, (3, 3)).tolist()
        com = numbers("payload.com", payload.com, (3,)).tolist()
        body = (float(payload.mass), com, inertia)
    return _newtau.load(os.fspath(path), tip, base, vector("gravity", gravity), body)
