"""A scene of several meshes with the interface of ``open3d.t.geometry.RaycastingScene``.

Names, shapes, and dtypes of the results are the same as in Open3D, so you only need to change the
import in a script:

>>> import numpy as np
>>> from intertri.open3d import RaycastingScene
>>> scene = RaycastingScene()
>>> scene.add_triangles(np.float32([[0, 0, 5], [1, 0, 5], [0, 1, 5]]), np.uint32([[0, 1, 2]]))
0
>>> answers = scene.cast_rays(np.float32([[0.25, 0.25, 0, 0, 0, 1], [9, 9, 0, 0, 0, 1]]))
>>> answers["t_hit"].numpy(), answers["geometry_ids"].numpy() == scene.INVALID_ID
(array([ 5., inf], dtype=float32), array([False,  True]))
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _arrays, _inputs
from .._arrays import F32, F64
from .._mesh import Mesh

__all__ = ["RaycastingScene", "Tensor"]


class Tensor(np.ndarray[Any, Any]):
    """A numpy array that also has those methods of Open3D's tensors that scripts typically call on
    results."""

    def numpy(self) -> NDArray[Any]:
        """Returns the same memory as a plain array."""
        return self.view(np.ndarray)

    def cpu(self) -> Tensor:
        """Returns the tensor itself, which is already in CPU memory."""
        return self

    def clone(self) -> Tensor:
        """Returns a copy."""
        return self.copy()

    def contiguous(self) -> Tensor:
        """Returns the tensor itself, or a copy whose memory is contiguous."""
        return _tensor(np.ascontiguousarray(self))

    def num_elements(self) -> int:
        """Returns the number of elements."""
        return self.size

    def isfinite(self) -> Tensor:
        """Returns whether each element is finite. A miss has an infinite ``t_hit``."""
        return _tensor(np.isfinite(self))

    def isinf(self) -> Tensor:
        """Returns whether each element is infinite."""
        return _tensor(np.isinf(self))

    def isnan(self) -> Tensor:
        """Returns whether each element is NaN."""
        return _tensor(np.isnan(self))

    def to(self, *args: Any, dtype: Any = None, device: Any = None, copy: bool = False) -> Tensor:
        """Converts to a numpy or Open3D dtype, or moves to a device, which must be the CPU."""
        for value in args:
            if isinstance(value, bool):
                copy = value
            elif _is_device(value):
                device = value
            else:
                dtype = value
        _check_device(device)
        return _tensor(self.astype(self.dtype if dtype is None else _numpy_dtype(dtype), copy=copy))

    def __getitem__(self, key: Any) -> Any:
        # A single element stays a tensor, as in Open3D.
        return _tensor(super().__getitem__(key))

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return _tensor(array)


def _tensor(values: Any) -> Tensor:
    return np.asarray(values).view(Tensor)


def _is_device(value: Any) -> bool:
    """Returns whether a value names a device, such as ``CPU:0``, and not a dtype."""
    return str(value).upper().startswith(("CPU", "CUDA", "SYCL"))


def _check_device(device: Any) -> None:
    if device is not None and not str(device).upper().startswith("CPU"):
        raise ValueError(f"device is {device}, but answers are computed on the CPU; pass CPU:0, or omit device")


def _numpy_dtype(dtype: Any) -> np.dtype[Any]:
    """Converts a numpy or Open3D dtype to a numpy dtype."""
    try:
        named: np.dtype[Any] = np.dtype(dtype)
    except TypeError:
        named = np.dtype(str(dtype).lower())
    return named


def _wrap_like(asked: Any) -> Callable[[NDArray[Any]], Any]:
    """Returns the function that converts an array to a result: an Open3D tensor if the query was
    one, otherwise a `Tensor`."""
    if type(asked).__module__.startswith("open3d"):
        return lambda array: type(asked).from_numpy(np.ascontiguousarray(array))
    return _tensor


def _array(value: Any, dtypes: tuple[np.dtype[Any], ...], last: int, name: str) -> NDArray[Any]:
    """Converts an Open3D tensor or a numpy array to an array (..., last). The dtype must be one of
    ``dtypes``."""
    array = _inputs.array(value, name)
    if array.dtype not in dtypes:
        raise TypeError(f"{name} has dtype {array.dtype}; it must be {' or '.join(map(str, dtypes))}")
    if array.ndim < 2 or array.shape[-1] != last:
        raise ValueError(f"{name} has shape {array.shape}; it must be (..., {last}) with two dimensions or more")
    return array


def _threads(nthreads: int) -> int | None:
    return nthreads or None


class _Built(NamedTuple):
    """The meshes of a scene as a single mesh."""

    mesh: Mesh
    starts: NDArray[np.int64]
    """The first face of each geometry, followed by the total number of faces."""
    normals: NDArray[np.floating[Any]]
    """The normal of each face, followed by the normal that stands for a miss."""


class RaycastingScene:
    """Triangle meshes that are queried together, with exact answers.

    The hierarchy over all meshes is built by the first query, and again after a mesh is added. A
    scene is float32, as in Open3D, until you add a mesh with float64 vertices. After that, it
    accepts rays and points in either dtype and answers in float64.

    Rays and points may be numpy arrays or Open3D tensors. If the query is an Open3D tensor, so are
    the results. Otherwise, each result is a `Tensor`, a numpy array with the most common methods of
    Open3D's tensors.

    Parameters
    ----------
    nthreads : int
        The number of threads for the build, or 0 for all.
    device
        Anything that names the CPU, where answers are always computed.
    """

    INVALID_ID = 4294967295
    """The geometry ID and primitive ID of a miss."""

    def __init__(self, nthreads: int = 0, device: Any = None) -> None:
        _check_device(device)
        self._nthreads = nthreads
        self._vertices: list[NDArray[np.floating[Any]]] = []
        self._faces: list[NDArray[np.uint32]] = []
        self._built: _Built | None = None

    @property
    def _dtype(self) -> np.dtype[Any]:
        return F64 if any(vertices.dtype == F64 for vertices in self._vertices) else F32

    def _query(self, value: Any, last: int, name: str) -> tuple[NDArray[Any], Callable[[NDArray[Any]], Any]]:
        """Returns rays or points in a dtype that the scene accepts, and the function that wraps
        their results."""
        return _array(value, (F32,) if self._dtype == F32 else (F32, F64), last, name), _wrap_like(value)

    def add_triangles(self, vertex_positions: Any, triangle_indices: Any = None) -> int:
        """Adds a mesh and returns its geometry ID. Pass vertices (n, 3) float32 or float64 and
        triangles (m, 3) uint32, or a single mesh from Open3D or any package that `intertri.Mesh`
        accepts."""
        if triangle_indices is None:
            arrays = _inputs.mesh_arrays(vertex_positions)
            if arrays is None:
                raise TypeError("add_triangles takes vertex_positions and triangle_indices, or a mesh")
            vertex_positions, indices = arrays
            triangle_indices = _arrays.face_rows(indices, len(vertex_positions))
        vertices = _array(vertex_positions, (F32, F64), 3, "vertex_positions")
        faces = _array(triangle_indices, (np.dtype(np.uint32),), 3, "triangle_indices")
        if faces.size and faces.max() >= len(vertices):
            raise IndexError(f"triangle_indices refer to vertex {faces.max()}, but there are {len(vertices)}")
        self._vertices.append(vertices.reshape(-1, 3).copy())
        self._faces.append(faces.reshape(-1, 3).copy())
        self._built = None
        return len(self._faces) - 1

    def _scene(self) -> _Built:
        """Returns all meshes as a single mesh, building it on first use."""
        if self._built is None:
            bases = np.cumsum([0] + [len(vertices) for vertices in self._vertices])
            starts = np.cumsum([0] + [len(faces) for faces in self._faces])
            vertices = np.concatenate([np.zeros((0, 3), self._dtype), *self._vertices])
            parts = [faces.astype(np.int64) + base for faces, base in zip(self._faces, bases)]
            faces = np.concatenate([np.zeros((0, 3), np.int64), *parts])
            a, b, c = np.moveaxis(vertices.astype(np.float64)[faces], 1, 0)
            normals = np.cross(b - a, c - a)
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            with np.errstate(divide="ignore", invalid="ignore"):
                normals = np.where(length > 0, normals / length, 0.0)
            normals = np.concatenate([normals, np.zeros((1, 3))]).astype(self._dtype)
            self._built = _Built(Mesh(vertices, faces, threads=_threads(self._nthreads)), starts, normals)
        return self._built

    def _ids(self, triangles: NDArray[np.int32]) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Returns the geometry and primitive IDs for triangles of the single mesh. A miss, -1,
        becomes `INVALID_ID`."""
        starts = self._scene().starts
        if len(starts) == 2:
            miss = (triangles < 0).astype(np.uint32)
            return np.negative(miss), triangles.view(np.uint32)
        geometry = np.searchsorted(starts, triangles, side="right") - 1
        primitive = np.where(geometry < 0, -1, triangles - starts[np.maximum(geometry, 0)])
        return geometry.astype(np.uint32), primitive.astype(np.uint32)

    def cast_rays(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """Finds the first hits of rays (..., 6), each an origin and a direction.

        Returns t_hit (...), infinite for a miss; geometry_ids and primitive_ids (...) uint32,
        `INVALID_ID` for a miss; primitive_uvs (..., 2); and primitive_normals (..., 3).
        Floating-point results are in the dtype of the scene.
        """
        rays, wrap = self._query(rays, 6, "rays")
        mesh, _, normals = self._scene()
        hits = mesh.closest(rays, threads=_threads(nthreads))
        geometry, primitive = self._ids(np.ascontiguousarray(hits["triangle"]))
        uvs = np.empty((*hits.shape, 2), mesh.dtype)
        uvs[..., 0], uvs[..., 1] = hits["u"], hits["v"]
        return {
            "t_hit": wrap(hits["t"].astype(mesh.dtype)),
            "geometry_ids": wrap(geometry),
            "primitive_ids": wrap(primitive),
            "primitive_uvs": wrap(uvs),
            "primitive_normals": wrap(normals[hits["triangle"]]),
        }

    def test_occlusions(self, rays: Any, tnear: float = 0.0, tfar: float = math.inf, nthreads: int = 0) -> Any:
        """Returns whether rays (..., 6) hit anything at tnear <= t < tfar: (...) bool."""
        rays, wrap = self._query(rays, 6, "rays")
        return wrap(self._scene().mesh.any(rays, t_min=tnear, t_max=tfar, threads=_threads(nthreads)))

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Any:
        """Counts the surfaces that rays (..., 6) cross: (...) int32. An edge or corner counts
        once."""
        rays, wrap = self._query(rays, 6, "rays")
        counts = self._scene().mesh.count_crossings(rays, threads=_threads(nthreads))
        return wrap(counts["unsigned"].astype(np.int32))

    def list_intersections(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """Finds all crossings of rays (..., 6), in order along each ray. An edge or corner counts
        once.

        Returns ray_splits (n + 1,) and ray_ids (m,) uint32, t_hit (m,), geometry_ids and
        primitive_ids (m,) uint32, and primitive_uvs (m, 2). The crossings of ray i are those from
        ray_splits[i] to ray_splits[i + 1].
        """
        rays, wrap = self._query(rays, 6, "rays")
        mesh = self._scene().mesh
        lists = mesh.crossings(rays, threads=_threads(nthreads))
        hits = lists.hits
        geometry, primitive = self._ids(np.ascontiguousarray(hits["triangle"]))
        return {
            "ray_splits": wrap(lists.offsets.astype(np.uint32)),
            "ray_ids": wrap(lists.rays.astype(np.uint32)),
            "t_hit": wrap(hits["t"].astype(mesh.dtype)),
            "geometry_ids": wrap(geometry),
            "primitive_ids": wrap(primitive),
            "primitive_uvs": wrap(np.stack([hits["u"], hits["v"]], axis=-1).astype(mesh.dtype)),
        }

    # ---- Points ----

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> dict[str, Any]:
        """Finds the closest point on the scene for each of the points (..., 3).

        Returns geometry_ids and primitive_ids (...) uint32, points and primitive_normals (..., 3),
        and primitive_uvs (..., 2).
        """
        points, wrap = self._query(query_points, 3, "query_points")
        mesh, _, normals = self._scene()
        found = mesh.closest_point(points, threads=_threads(nthreads))
        geometry, primitive = self._ids(np.ascontiguousarray(found["triangle"]))
        return {
            "points": wrap(mesh.hit_points(found).astype(mesh.dtype)),
            "geometry_ids": wrap(geometry),
            "primitive_ids": wrap(primitive),
            "primitive_uvs": wrap(np.stack([found["u"], found["v"]], axis=-1).astype(mesh.dtype)),
            "primitive_normals": wrap(normals[found["triangle"]]),
        }

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> Any:
        """Returns the distances of points (..., 3) to the scene: (...)."""
        points, wrap = self._query(query_points, 3, "query_points")
        mesh = self._scene().mesh
        return wrap(mesh.closest_point(points, threads=_threads(nthreads))["distance"].astype(mesh.dtype))

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """Returns the distances of points (..., 3) to the scene, negative inside: (...).

        `compute_occupancy` determines what is inside. ``nsamples`` must be odd but has no effect,
        because one exact ray is enough.
        """
        _odd(nsamples)
        points, wrap = self._query(query_points, 3, "query_points")
        mesh, threads = self._scene().mesh, _threads(nthreads)
        distance = mesh.closest_point(points, threads=threads)["distance"]
        inside = mesh._inside_or_odd(points, threads) & (distance > 0)
        return wrap(np.where(inside, -distance, distance).astype(mesh.dtype))

    def compute_occupancy(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """Returns 1 for points (..., 3) inside the scene or on it, otherwise 0: (...).

        If the meshes together are closed and consistently oriented, a point is inside if they wind
        around it. Parts may therefore overlap, whereas Open3D counts a point inside an even number
        of parts as outside. In any other scene, a point is inside if a ray from it crosses an odd
        number of faces, as in Open3D.
        """
        _odd(nsamples)
        points, wrap = self._query(query_points, 3, "query_points")
        mesh = self._scene().mesh
        return wrap(mesh._inside_or_odd(points, _threads(nthreads)).astype(mesh.dtype))

    # ---- Cameras ----

    @staticmethod
    def create_rays_pinhole(*args: Any, **named: Any) -> Any:
        """Creates the rays of a pinhole camera's image, (height, width, 6) float32.

        Pass either ``intrinsic_matrix`` (3, 3), ``extrinsic_matrix`` (4, 4) from world to camera,
        ``width_px``, and ``height_px``; or ``fov_deg`` (horizontal), ``center``, ``eye``, ``up``,
        ``width_px``, and ``height_px``.
        """
        by_matrix = ("intrinsic_matrix", "extrinsic_matrix", "width_px", "height_px")
        by_angle = ("fov_deg", "center", "eye", "up", "width_px", "height_px")
        names = by_angle if len(args) + len(named) == len(by_angle) else by_matrix
        given = dict(zip(names, args)) | named
        if set(given) != set(names):
            raise TypeError(f"create_rays_pinhole takes {', '.join(by_matrix)}, or {', '.join(by_angle)}")
        width, height = int(given["width_px"]), int(given["height_px"])

        def matrix(name: str, *shape: int) -> NDArray[np.float64]:
            array = np.asarray(_inputs.array(given[name], name), np.float64)
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}; it must be {shape}")
            return array

        if names is by_matrix:
            intrinsic, extrinsic = matrix("intrinsic_matrix", 3, 3), matrix("extrinsic_matrix", 4, 4)
            turn, eye = extrinsic[:3, :3], -extrinsic[:3, :3].T @ extrinsic[:3, 3]
        else:
            center, eye, up = matrix("center", 3), matrix("eye", 3), matrix("up", 3)
            focal = 0.5 * width / math.tan(0.5 * math.radians(float(given["fov_deg"])))
            intrinsic = np.array([[focal, 0, 0.5 * width], [0, focal, 0.5 * height], [0, 0, 1]])
            ahead = (center - eye) / np.linalg.norm(center - eye)
            right = np.cross(up, ahead)
            right /= np.linalg.norm(right)
            turn = np.stack([right, np.cross(ahead, right), ahead])
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        pixels = np.stack([x, y, np.ones_like(x)], axis=-1)
        rays = np.empty((height, width, 6), np.float32)
        rays[..., :3] = eye
        rays[..., 3:] = pixels @ np.linalg.inv(intrinsic).T @ turn
        return _wrap_like(given["intrinsic_matrix" if names is by_matrix else "eye"])(rays)


def _odd(nsamples: int) -> None:
    if nsamples < 1 or nsamples % 2 == 0:
        raise ValueError(f"nsamples is {nsamples}; it must be odd")
