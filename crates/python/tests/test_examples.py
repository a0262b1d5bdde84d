"""The examples that need nothing but numpy, as a user runs them."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("name, line", [("lidar", "pulses with 2 returns"), ("sky_view", "by formula 0.5547")])
def test_examples(name, line):
    run = subprocess.run([sys.executable, FOLDER / f"{name}.py"], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert line in run.stdout
