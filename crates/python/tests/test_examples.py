"""Runs the examples that need no packages besides numpy, as a user would."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize(
    "name, paths, line",
    [
        ("lidar", [], "pulses with 2 returns"),
        ("sky_view", [], "by formula 0.5547"),
        ("slices", ["slices.png"], "325924 voxels inside, 11202 on the surface"),
    ],
)
def test_examples(name, paths, line, tmp_path):
    command = [sys.executable, FOLDER / f"{name}.py", *paths]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert line in run.stdout
