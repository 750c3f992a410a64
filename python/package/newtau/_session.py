"""Connection to a session of ``newtau drive`` or ``newtau connect`` that runs on this computer."""

from __future__ import annotations

import json
import os
import socket
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Iterable, List, Optional, Tuple, Type, Union

import numpy as np

# Longest wait for an answer, s. A stop is answered when the arm is held.
_ANSWER = 5.0


class SessionError(RuntimeError):
    """The session did what was not asked, or nothing: the text says why."""


@dataclass(frozen=True)
class State:
    """State of the arm of a session.

    Attributes:
        tick: Number of the control tick.
        time: Time of the tick since the session began, s.
        state: State of the safety state machine: ``"idle"``, ``"armed"``, ``"running"``, ``"holding"``, ``"fault"`` and others.
        text: The state in words.
        q: Position of each joint, rad or m, shape (n,). Empty while it is unknown.
        qd: Velocity of each joint, rad/s or m/s, shape (n,). Empty if the drives do not report it.
        torque: Commanded torque of each joint, N m or N, shape (n,). Empty while no torque acts.
        following: True while the arm follows targets.
        age: Time since the session had this state, s. None in a dry run, whose state changes only with a command.
    """

    tick: int
    time: float
    state: str
    text: str
    q: np.ndarray
    qd: np.ndarray
    torque: np.ndarray
    following: bool
    age: Optional[float] = None


def _folders() -> List[Path]:
    """Folders in which sessions of this user may be."""
    user = os.geteuid() if hasattr(os, "geteuid") else "sessions"
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    folders = [Path(runtime) / "newtau"] if os.path.isabs(runtime) else []
    folders += [Path(f"/run/user/{user}/newtau"), Path(tempfile.gettempdir()) / f"newtau-{user}", Path(f"/tmp/newtau-{user}")]
    unique = list(dict.fromkeys(folders))
    # What another user has put there is no session of this one.
    return [path for path in unique if path.is_dir() and (not hasattr(os, "geteuid") or path.stat().st_uid == user)]


class Session:
    """A session of ``newtau drive`` or ``newtau connect`` that runs on this computer under the same user.

    A person at its terminal homes and arms the arm, and gives it to this program with the command ``follow``. From then on
    :meth:`target` moves it, at most half as fast as the robot file allows. The session refuses targets outside the joints' limits. It
    stops and holds the arm when no target comes for 0.25 s (or for the time given to ``follow``), when this program ends, and when the
    person stops it.

    >>> with newtau.Session() as arm:                               # doctest: +SKIP
    ...     q = arm.state().q
    ...     for k in range(500):
    ...         q[0] += 0.001
    ...         state = arm.target(q)
    ...         time.sleep(0.01)

    At the end of ``with`` the arm stops and is held. After an exception it does too, and the session counts that as a fault of this
    program.

    Args:
        pid: Number of the session's process. Needed only if several sessions run.

    Raises:
        SessionError: No session runs, or several do, or it does not answer.
    """

    def __init__(self, pid: Optional[int] = None):
        name = "*.json" if pid is None else f"{pid}.json"
        files = sorted(file for folder in _folders() for file in folder.glob(name))
        # A program that was killed leaves a file whose socket does not answer.
        found: List[Tuple[dict, socket.socket, Any, dict]] = []
        for file in files:
            try:
                session = json.loads(file.read_text())
                found.append((session, *self._connect(session)))
            except (OSError, ValueError, KeyError, SessionError):
                continue
        for _, connection, *_ in found[1:]:
            connection.close()
        if len(found) > 1:
            found[0][1].close()
            numbers = ", ".join(str(session["pid"]) for session, *_ in found)
            raise SessionError(f"{len(found)} sessions run on this computer; expected pid, one of {numbers}")
        if not found:
            which = "no session" if pid is None else f"no session with the process number {pid}"
            raise SessionError(f"{which} of `newtau drive` or `newtau connect` runs under this user")
        _, self._socket, self._lines, hello = found[0]
        # One answer belongs to one line, whatever thread sent it.
        self._lock = threading.Lock()
        self.scene: str = hello["scene"]
        """Path of the scene."""
        self.joint_names: List[str] = hello["joints"]
        """Names of the joints, base first."""
        self.rate: float = hello["rate"]
        """Control ticks per second."""
        self.range: np.ndarray = np.array(hello["range"], dtype=np.float64)
        """Lowest and highest position of each joint, rad or m, shape (n, 2). NaN where there is no limit."""

    @staticmethod
    def _connect(session: dict) -> Tuple[socket.socket, Any, dict]:
        if session["newtau"] != 1:
            raise SessionError(f"the session speaks version {session['newtau']}, expected 1")
        host, port = session["address"].rsplit(":", 1)
        connection = socket.create_connection((host, int(port)), timeout=_ANSWER)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        lines = connection.makefile("r", encoding="utf-8", newline="\n")
        return connection, lines, Session._exchange(connection, lines, {"token": session["token"]})["hello"]

    @staticmethod
    def _exchange(connection: socket.socket, lines: Any, ask: Union[str, dict]) -> dict:
        # json writes NaN, which is no JSON: it is refused here, before it is sent.
        connection.sendall((json.dumps(ask, allow_nan=False) + "\n").encode())
        line = lines.readline()
        if not line:
            raise SessionError("the session has ended")
        answer = json.loads(line)
        if "error" in answer:
            raise SessionError(answer["error"])
        return answer

    def _ask(self, ask: Union[str, dict]) -> dict:
        try:
            with self._lock:
                return self._exchange(self._socket, self._lines, ask)
        except OSError as error:
            raise SessionError(f"the session does not answer: {error}") from error

    def _state(self, answer: dict) -> State:
        # A newer session may tell more.
        fields = {name: value for name, value in answer["state"].items() if name in State.__dataclass_fields__}
        for name in ("q", "qd", "torque"):
            fields[name] = np.array(fields[name], dtype=np.float64)
        return State(**fields)

    def state(self) -> State:
        """State of the arm in the last tick that the session knows.

        Raises:
            SessionError: The session has ended.
        """
        return self._state(self._ask("state"))

    def target(self, q: Iterable[float]) -> State:
        """Sends the arm to these positions, and returns its state. A later target replaces an earlier one.

        Args:
            q: Position of each joint, rad or m, shape (n,), inside :attr:`range`.

        Raises:
            SessionError: The arm follows no targets, or no longer: the text says why.
            ValueError: A position is NaN or infinite.
        """
        return self._state(self._ask({"target": [float(value) for value in q]}))

    def done(self) -> State:
        """Ends the targets: the arm stops and is held.

        Raises:
            SessionError: The session has ended.
        """
        return self._state(self._ask("done"))

    def stop(self, emergency: bool = False) -> str:
        """Stops the arm along its path, as Esc does at the terminal. Returns what the arm does then.

        Args:
            emergency: Emergency stop (fault 9): the safe action of the scene, after which an arm without brakes may sink.

        Raises:
            SessionError: The session has ended, or did not confirm.
        """
        return self._ask("emergency-stop" if emergency else "stop")["stopped"]

    def close(self) -> None:
        """Closes the connection. An arm that still follows targets stops and is held."""
        self._lines.close()
        self._socket.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        try:
            if kind is None:
                self.done()
        finally:
            self.close()

