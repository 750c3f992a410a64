"""Torques have the bits of the Rust core."""

import json
from pathlib import Path

import numpy as np
import pytest

GOLDEN = json.loads((Path(__file__).parent / "golden" / "inverse_dynamics.json").read_text())


def differences(arms, name):
    """Number of golden rows with other bits."""
    unsigned = {"float64": np.uint64, "float32": np.uint32}[name]
    count = 0
    for row in GOLDEN:
        lists = [np.array(row[key], dtype=name) for key in ("q", "qd", "qdd")]
        expected = np.array([int(bits, 16) for bits in row[name]], dtype=unsigned)
        arm = arms[row["robot"]]
        found = [arm.inverse_dynamics(*lists), arm.inverse_dynamics(*(np.tile(each, (40, 1)) for each in lists))[37]]
        count += any(not np.array_equal(each.view(unsigned), expected) for each in found)
    return count


@pytest.mark.parametrize("name", ["float64", "float32"])
def test_torques_have_the_bits_of_the_core(arms, name):
    assert len(GOLDEN) == 40 and differences(arms, name) == 0


def test_one_bit_in_a_golden_row_is_noticed(arms, monkeypatch):
    row = GOLDEN[9]
    changed = f"{int(row['float64'][1], 16) ^ 1:016x}"
    monkeypatch.setitem(row, "float64", [row["float64"][0], changed, *row["float64"][2:]])
    assert differences(arms, "float64") == 1
