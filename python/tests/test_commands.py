"""Check, simulation and identification."""

import numpy as np
import pytest
from conftest import ROOT, robot_file

import newtau

TRAPS = ROOT / "host-sim" / "tests" / "fixtures" / "traps.urdf"


def test_check_returns_findings_with_their_place():
    findings = newtau.check(TRAPS)
    wrong = [finding for finding in findings if finding.severity == "wrong"]
    assert wrong and findings[: len(wrong)] == wrong
    assert all(finding.file.endswith("traps.urdf") and finding.problem and finding.advice for finding in findings)
    assert any(finding.line and finding.line > 1 for finding in findings)
    # Negative control: an arm of the repository has nothing wrong.
    assert not [finding for finding in newtau.check(robot_file("ur5")) if finding.severity == "wrong"]


def test_check_of_a_missing_file_is_a_value_error(tmp_path):
    with pytest.raises(ValueError, match="nowhere.urdf"):
        newtau.check(tmp_path / "nowhere.urdf")


@pytest.fixture(scope="module")
def run():
    return newtau.simulate(ROOT / "scenes" / "planar2r_swing.toml")


def test_simulate_returns_summary_and_record(run):
    record = run.record
    assert run.stopped is None and not run.faults and run.joint_names
    assert record["q"].shape == (len(record), 2) and record.dtype["q"].base == np.float64
    assert np.allclose(np.diff(record["t"]), run.period)
    errors = record["q_reference"] - record["q"]
    assert np.allclose(np.abs(errors).max(axis=0), run.tracking_max)
    assert np.allclose(np.abs(record["tau"]).max(axis=0), run.torque_peak)
    assert len(record) == run.summary["ticks"]


def test_a_simulation_repeats_to_the_bit_and_follows_its_duration(run):
    short = newtau.simulate(ROOT / "scenes" / "planar2r_swing.toml", duration=0.05)
    assert short.duration == pytest.approx(0.05)
    count = len(short.record)
    assert 0 < count < len(run.record)
    assert short.record["tau"].tobytes() == run.record["tau"][:count].tobytes()


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan"), 1e12])
def test_an_impossible_duration_is_a_value_error(duration):
    with pytest.raises(ValueError, match="duration"):
        newtau.simulate(ROOT / "scenes" / "planar2r_swing.toml", duration=duration)


def write_log(run, path, torque=1.0, effort="tau"):
    """Writes the record of a run as a log."""
    record, n = run.record, len(run.joint_names)
    names = ["t"] + [f"{name}{k}" for name in ("q", "qd", effort) for k in range(1, n + 1)]
    table = np.column_stack([record["t"], record["q"], record["qd"], torque * record["tau"]])
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="")


def test_identify_returns_verdict_and_parameters(run, tmp_path):
    log = tmp_path / "log.csv"
    write_log(run, log)
    found = newtau.identify(robot_file("planar2r"), log)
    assert found.verdict in ("trusted", "doubtful", "refused")
    assert found.parameters and all(np.isfinite(parameter.value) for parameter in found.parameters)
    assert (found.robot_file is not None) == (found.verdict == "trusted")
    assert found.verdict == "trusted" or found.reasons
    assert len(found.joints) == 2


def test_a_log_with_reversed_torques_is_refused(run, tmp_path):
    log = tmp_path / "reversed.csv"
    write_log(run, log, torque=-1.0)
    found = newtau.identify(robot_file("planar2r"), log)
    assert found.verdict == "refused" and found.reasons and found.robot_file is None


@pytest.mark.parametrize("constants", [0.1, [0.1, 0.1], np.float64(0.1), np.array(0.1), np.array([0.1, 0.1]), (0.1,)])
def test_currents_have_one_torque_constant_for_all_joints_or_one_for_each(run, tmp_path, constants):
    log = tmp_path / "currents.csv"
    write_log(run, log, torque=10.0, effort="i")
    with pytest.raises(ValueError, match="torque-per-ampere"):
        newtau.identify(robot_file("planar2r"), log)
    torques = tmp_path / "torques.csv"
    write_log(run, torques)
    found = newtau.identify(robot_file("planar2r"), log, torque_per_ampere=constants)
    expected = newtau.identify(robot_file("planar2r"), torques)
    # Negative control: another constant gives other parameters.
    other = newtau.identify(robot_file("planar2r"), log, torque_per_ampere=0.2)
    values, good, bad = ([parameter.value for parameter in each.parameters] for each in (found, expected, other))
    assert np.allclose(values, good, rtol=1e-5, atol=1e-7) and not np.allclose(values, bad, rtol=1e-2)


@pytest.mark.parametrize("constants", ["many", [[0.1, 0.1]], object()])
def test_an_impossible_torque_constant_is_a_value_error(run, tmp_path, constants):
    log = tmp_path / "currents.csv"
    write_log(run, log, effort="i")
    with pytest.raises(ValueError, match="^torque_per_ampere: found .*; expected one number for all joints, or a list"):
        newtau.identify(robot_file("planar2r"), log, torque_per_ampere=constants)


def test_identify_without_a_log_is_a_value_error():
    with pytest.raises(ValueError, match="logs: found no file"):
        newtau.identify(robot_file("planar2r"), [])
