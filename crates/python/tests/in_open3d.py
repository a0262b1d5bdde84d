"""A pytest plugin that replaces Open3D's RaycastingScene with intertri's, so that Open3D's own
tests exercise intertri:

    git clone --depth 1 https://github.com/isl-org/Open3D && cd Open3D/python/test
    PYTHONPATH=.../crates/python/tests python -m pytest -p in_open3d t/geometry/test_raycasting_scene.py
"""

import intertri.open3d
import open3d

open3d.t.geometry.RaycastingScene = intertri.open3d.RaycastingScene


def pytest_report_header():
    return f"Open3D {open3d.__version__}, with intertri's RaycastingScene"
