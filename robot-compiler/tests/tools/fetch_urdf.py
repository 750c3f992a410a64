#!/usr/bin/env python3
"""Fetch the URDF files that `tests/urdf_corpus.rs` reads.

Usage: python3 fetch_urdf.py FOLDER, by default `target/robot-data` of the workspace. Needs pip, installs nothing: the wheel of
`example-robot-data` is downloaded (131 MB), its .urdf files are unpacked (3 MB), and the wheel is thrown away. The files
belong to their authors and are not committed. Does nothing when they are there.
"""
import pathlib
import subprocess
import sys
import tempfile
import zipfile

PACKAGE = "example-robot-data==6.0.0"


def main():
    workspace = pathlib.Path(__file__).resolve().parents[3]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else workspace / "target" / "robot-data"
    done = folder / PACKAGE
    if done.exists():
        print(f"{PACKAGE}: there already")
        return
    with tempfile.TemporaryDirectory() as place:
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary", ":all:"]
        subprocess.run([*pip, "--dest", place, PACKAGE], check=True)
        wheel = next(pathlib.Path(place).glob("*.whl"))
        with zipfile.ZipFile(wheel) as archive:
            names = [name for name in archive.namelist() if name.endswith(".urdf")]
            archive.extractall(folder, names)
    done.touch()
    print(f"{PACKAGE}: {len(names)} URDF files in {folder}")


main()
