"""Ray/triangle queries over numpy arrays. *Trace in f32. Answer in f64. Or exactly.*

>>> import numpy as np, intertri
>>> mesh = intertri.Mesh([[-9, 0, -9], [9, 0, -9], [0, 0, 9]], [[0, 1, 2]])
>>> mesh.closest([0, 1, 0], [0, -0.5, 1])["t"]
np.float64(2.0)

Start with `Mesh`. A `Scene` contains moving instances of meshes. `Media` represents solids that
rays pass through, each filled with a material. `intertri.trimesh` makes trimesh meshes answer ray
queries exactly, `intertri.open3d` has the interface of Open3D's scenes, `intertri.pyvista` provides
pyvista's ray traces and interior points, and `intertri.dask` runs queries on a cluster.
"""

from ._dtypes import (
    CROSSING,
    CROSSINGS,
    HIT,
    HIT32,
    MEDIUM_CROSSING,
    NEAREST,
    SCENE_HIT,
    SCENE_NEAREST,
    SEGMENT,
    HitLists,
    SegmentLists,
)
from ._intertri import __version__
from ._media import Media
from ._mesh import Mesh, load
from ._scene import Scene

__all__ = [
    "CROSSING",
    "CROSSINGS",
    "HIT",
    "HIT32",
    "MEDIUM_CROSSING",
    "NEAREST",
    "SCENE_HIT",
    "SCENE_NEAREST",
    "SEGMENT",
    "HitLists",
    "Media",
    "Mesh",
    "Scene",
    "SegmentLists",
    "load",
    "__version__",
]
