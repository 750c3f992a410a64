"""The connection to a session, with a session that this test plays."""

import json
import socket
import threading

import numpy as np
import pytest

import newtau

STATE = {
    "tick": 7,
    "time": 0.0175,
    "state": "running",
    "text": "running",
    "q": [0.1, 0.2],
    "qd": [],
    "torque": [1.0, -2.0],
    "following": True,
    "heat": [None, 0.5],
    "timing": None,
    "age": 0.01,
    "of a later version": 1,
}


class Played:
    """A session that answers from a list, and keeps the lines that it received."""

    def __init__(self, folder, answers, pid=7, version=1):
        self.lines = []
        self.server = socket.create_server(("127.0.0.1", 0))
        self.file = folder / "newtau" / f"{pid}.json"
        self.file.parent.mkdir(exist_ok=True)
        address = f"127.0.0.1:{self.server.getsockname()[1]}"
        self.file.write_text(
            json.dumps({"newtau": version, "pid": pid, "scene": "arm.toml", "address": address, "token": "secret"})
        )
        hello = {"hello": {"scene": "arm.toml", "joints": ["a", "b"], "rate": 400.0, "range": [[-1, 1], [None, 2]]}}
        self.thread = threading.Thread(target=self._serve, args=([hello, *answers],))
        self.thread.start()

    def _serve(self, answers):
        connection, _ = self.server.accept()
        with connection, connection.makefile("r") as lines:
            for answer in answers:
                line = lines.readline()
                if not line:
                    return
                self.lines.append(json.loads(line))
                connection.sendall((json.dumps(answer) + "\n").encode())
            rest = lines.readline()
            assert rest == "", rest

    def end(self):
        self.thread.join()
        self.server.close()
        return self.lines


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder of sessions."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


def test_targets_are_sent_and_the_end_is_said(folder):
    played = Played(folder, [{"state": STATE}] * 3)
    with newtau.Session() as arm:
        assert arm.joint_names == ["a", "b"] and arm.rate == 400.0 and arm.scene == "arm.toml"
        np.testing.assert_array_equal(arm.range, [[-1, 1], [np.nan, 2]])
        state = arm.state()
        np.testing.assert_array_equal(state.q, [0.1, 0.2])
        assert state.qd.shape == (0,) and state.following and state.tick == 7 and state.age == 0.01
        arm.target(np.array([0.5, -0.5]))
    assert played.end() == [{"token": "secret"}, "state", {"target": [0.5, -0.5]}, "done"]


def test_after_an_exception_the_connection_is_closed_without_a_word(folder):
    played = Played(folder, [{"state": STATE}])
    with pytest.raises(ZeroDivisionError), newtau.Session() as arm:
        arm.target([0, 0])
        1 / 0
    assert played.end() == [{"token": "secret"}, {"target": [0.0, 0.0]}]


def test_refusals_say_why_and_what_is_no_number_is_not_sent(folder):
    played = Played(folder, [{"error": "enter `follow`"}, {"stopped": "holding"}, {"stopped": "fault 9"}])
    arm = newtau.Session(pid=7)
    with pytest.raises(newtau.SessionError, match="enter `follow`"):
        arm.target([0, 0])
    with pytest.raises(ValueError):
        arm.target([0, float("nan")])
    assert (arm.stop(), arm.stop(emergency=True)) == ("holding", "fault 9")
    arm.close()
    assert played.end() == [{"token": "secret"}, {"target": [0.0, 0.0]}, "stop", "emergency-stop"]


def test_one_session_is_found_and_several_are_named(folder):
    with pytest.raises(newtau.SessionError, match="no session"):
        newtau.Session()
    first = Played(folder, [], pid=7)
    (folder / "newtau" / "6.json").write_text("{")
    newtau.Session().close()
    first.end()
    both = [Played(folder, [], pid=8), Played(folder, [], pid=9)]
    first.file.unlink()
    with pytest.raises(newtau.SessionError, match="one of 8, 9"):
        newtau.Session()
    [played.end() for played in both]
    with pytest.raises(newtau.SessionError, match="process number 5"):
        newtau.Session(pid=5)


def test_another_version_is_not_spoken_to(folder):
    (folder / "newtau").mkdir()
    (folder / "newtau" / "7.json").write_text(
        json.dumps({"newtau": 2, "pid": 7, "scene": "", "address": "127.0.0.1:9", "token": ""})
    )
    with pytest.raises(newtau.SessionError, match="no session"):
        newtau.Session()
