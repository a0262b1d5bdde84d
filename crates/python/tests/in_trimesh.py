"""A plugin of pytest that puts intertri in the place of Embree in trimesh, to run trimesh's own tests with it:

    git clone https://github.com/mikedh/trimesh && cd trimesh
    PYTHONPATH=.../crates/python/tests:. python -m pytest -p in_trimesh tests/test_ray.py tests/test_ray_upstream.py

With INTERTRI_EVERYWHERE=1 it takes the place of the engine in Python, too, and that of trimesh.proximity's closest points
and signed distances.
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
    return f"trimesh {trimesh.__version__} from {trimesh.__path__[0]}, its rays by intertri"
