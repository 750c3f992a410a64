"""Dynamics of robot arms for NumPy.

>>> import newtau
>>> arm = newtau.load("robots/ur5.toml")                        # doctest: +SKIP
>>> tau = arm.inverse_dynamics(q, qd, qdd)                      # doctest: +SKIP

SI units and radians throughout. Arrays have the shape ``(n,)`` for one state of an arm with ``n`` joints, or ``(batch, n)`` for
many states.
"""

from ._newtau import Arm, __version__
from ._files import Payload, load
from ._check import Finding, check
from ._identify import Identification, Parameter, Reason, identify
from ._session import Session, SessionError, State
from ._simulate import Simulation, simulate

__all__ = [
    "Arm",
    "Finding",
    "Identification",
    "Parameter",
    "Payload",
    "Reason",
    "Session",
    "SessionError",
    "Simulation",
    "State",
    "__version__",
    "check",
    "identify",
    "load",
    "simulate",
]
