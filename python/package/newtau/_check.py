"""Checks of a robot file."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import List, Optional, Sequence

from . import _newtau
from ._files import Path, vector


@dataclass(frozen=True)
class Finding:
    """An impossible, improbable or missing value of a robot file.

    Attributes:
        severity: "wrong" (no physics allows it, or the arm cannot hold itself), "doubt" (improbable), or "note" (missing).
        rule: Name of the rule that found it, such as "gyration".
        file: The file.
        line: Line, counted from 1; None if the whole file is meant.
        column: Column, counted from 1, or None.
        field: The field, as a path: "joint 2 (elbow).inertia.xx".
        problem: What was found.
        advice: What to measure or write instead.
    """

    severity: str
    rule: str
    file: str
    line: Optional[int]
    column: Optional[int]
    field: str
    problem: str
    advice: str

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line is not None else self.file
        return f"{self.severity}: {place}: {self.field}: {self.problem}; {self.advice}"


def check(
    path: Path,
    *,
    tip: Optional[str] = None,
    base: Optional[str] = None,
    gravity: Optional[Sequence[float]] = None,
    scene: Optional[Path] = None,
) -> List[Finding]:
    """Checks a robot file for impossible, placeholder and missing values, as ``newtau check`` does.

    Args:
        path: A URDF file or a robot file (TOML).
        tip: For a URDF file: the link at the tip of the arm.
        base: For a URDF file: the link at the base of the arm.
        gravity: Gravitational acceleration in the base frame, m/s^2, shape (3,).
        scene: A scene of this robot, to check its safety settings too.

    Returns:
        The findings, the worst first. An empty list means that no rule objects.

    Raises:
        ValueError: The file cannot be read, or its format is wrong.
    """
    scene_path = None if scene is None else os.fspath(scene)
    text = _newtau.check(os.fspath(path), tip, base, vector("gravity", gravity), scene_path)
    return [Finding(**finding) for finding in json.loads(text)["findings"]]
