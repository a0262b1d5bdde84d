"""A pytest plugin that replaces Embree in trimesh with intertri, so that trimesh's own tests
exercise intertri:

    git clone https://github.com/mikedh/trimesh && cd trimesh
    PYTHONPATH=.../crates/python/tests:. python -m pytest -p in_trimesh tests/test_ray.py tests/test_ray_upstream.py

With INTERTRI_EVERYWHERE=1, it also replaces trimesh's Python engine and the closest points and
signed distances of trimesh.proximity.
"""

import os
import sys
import types

import intertri.trimesh
import trimesh
from intertri.trimesh import RayMeshIntersector

embree = types.ModuleType("trimesh.ray.ray_pyembree")
embree.RayMeshIntersector = RayMeshIntersector
sys.modules["trimesh.ray.ray_pyembree"] = trimesh.ray.ray_pyembree = embree
trimesh.ray.has_embree = True
if os.environ.get("INTERTRI_EVERYWHERE"):
    trimesh.ray.ray_triangle.RayMeshIntersector = RayMeshIntersector
    for name in ("ProximityQuery", "closest_point", "signed_distance"):
        setattr(trimesh.proximity, name, getattr(intertri.trimesh, name))


def pytest_report_header():
    return f"trimesh {trimesh.__version__} from {trimesh.__path__[0]}, with rays by intertri"
