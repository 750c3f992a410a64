"""Source text of the inverse dynamics."""

import shutil
import subprocess

import pytest
from conftest import robot_file

import newtau


def test_rust_text_has_the_kernel(arm):
    text = arm.kernel(language="rust")
    assert text == arm.kernel()
    assert "impl InverseDynamics<f32, " in text and arm.name in text
    assert "impl InverseDynamics<f64, " in arm.kernel(scalar="f64")


@pytest.mark.parametrize("scalar", ["f32", "f64"])
def test_c_text_compiles(arm, scalar, tmp_path):
    text = arm.kernel(language="c", scalar=scalar)
    assert "void arm_kernel_inverse_dynamics(" in text
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("gcc is not here")
    source = tmp_path / "kernel.c"
    source.write_text(text)
    command = [compiler, "-std=c99", "-Wall", "-Werror", "-c", str(source), "-o", str(tmp_path / "kernel.o")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_gravity_and_payload_are_in_the_text():
    plain = newtau.load(robot_file("ur5"))
    moon = newtau.load(robot_file("ur5"), gravity=(0, 0, -1.62))
    loaded = newtau.load(robot_file("ur5"), payload=newtau.Payload(3.0, com=(0, 0, 0.05)))
    assert len({each.kernel("c") for each in (plain, moon, loaded)}) == 3


def test_an_unknown_language_is_rejected(arm):
    with pytest.raises(ValueError, match="language: found ada: expected one of rust, c"):
        arm.kernel(language="ada")
    with pytest.raises(ValueError, match="scalar: found f16: expected one of f32, f64"):
        arm.kernel(scalar="f16")
