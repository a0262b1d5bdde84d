"""A scene of several meshes with the interface of ``open3d.t.geometry.RaycastingScene``.

Names, shapes and dtypes of the results are Open3D's, so that a script changes an import:

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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._mesh import Mesh

__all__ = ["RaycastingScene", "Tensor"]


class Tensor(np.ndarray[Any, Any]):
    """A numpy array that also answers to ``numpy()`` and ``cpu()``, as Open3D's tensors do."""

    def numpy(self) -> NDArray[Any]:
        """The same memory as a plain array."""
        return self.view(np.ndarray)

    def cpu(self) -> Tensor:
        """Itself: it is there already."""
        return self


def _tensor(array: NDArray[Any]) -> Tensor:
    return array.view(Tensor)


def _array(value: Any, dtype: type[Any], last: int, name: str) -> NDArray[Any]:
    """An array (..., last) of a tensor of Open3D or numpy, which must have the dtype as there."""
    array = np.asarray(value.numpy() if hasattr(value, "numpy") else value)
    if array.dtype != dtype:
        raise TypeError(f"{name} has dtype {array.dtype}; it must be {np.dtype(dtype)}")
    if array.ndim < 2 or array.shape[-1] != last:
        raise ValueError(f"{name} has shape {array.shape}; it must be (..., {last}) with two dimensions or more")
    return array


def _threads(nthreads: int) -> int | None:
    return nthreads or None


class RaycastingScene:
    """Triangle meshes in float32, asked together; answers are exact.

    The hierarchy over all meshes is built with the first query, and again after a mesh was added.
    """

    INVALID_ID = 4294967295
    """What a miss has for geometry and primitive."""

    def __init__(self, nthreads: int = 0) -> None:
        self._nthreads = nthreads
        self._vertices: list[NDArray[np.float32]] = []
        self._faces: list[NDArray[np.uint32]] = []
        self._built: tuple[Mesh, NDArray[np.int64], NDArray[np.float32]] | None = None

    def add_triangles(self, vertex_positions: Any, triangle_indices: Any = None) -> int:
        """Adds a mesh: vertices (n, 3) float32 and triangles (m, 3) uint32, or an object with
        ``vertex.positions`` and ``triangle.indices``, as Open3D's meshes. Returns its geometry ID."""
        if triangle_indices is None:
            mesh = vertex_positions
            vertex_positions, triangle_indices = mesh.vertex.positions, mesh.triangle.indices
            triangle_indices = np.asarray(
                triangle_indices.numpy() if hasattr(triangle_indices, "numpy") else triangle_indices
            ).astype(np.uint32)
        vertices = _array(vertex_positions, np.float32, 3, "vertex_positions")
        faces = _array(triangle_indices, np.uint32, 3, "triangle_indices")
        if faces.size and faces.max() >= len(vertices):
            raise IndexError(f"triangle_indices name vertex {faces.max()}, but there are {len(vertices)}")
        self._vertices.append(vertices.reshape(-1, 3).copy())
        self._faces.append(faces.reshape(-1, 3).copy())
        self._built = None
        return len(self._faces) - 1

    def _scene(self) -> tuple[Mesh, NDArray[np.int64], NDArray[np.float32]]:
        """All meshes as one, the first face of each, and the normals of faces with that of a miss at the end."""
        if self._built is None:
            bases = np.cumsum([0] + [len(vertices) for vertices in self._vertices])
            starts = np.cumsum([0] + [len(faces) for faces in self._faces])
            vertices = np.concatenate([np.zeros((0, 3), np.float32), *self._vertices])
            parts = [faces.astype(np.int64) + base for faces, base in zip(self._faces, bases)]
            faces = np.concatenate([np.zeros((0, 3), np.int64), *parts])
            a, b, c = np.moveaxis(vertices.astype(np.float64)[faces], 1, 0)
            normals = np.cross(b - a, c - a)
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            with np.errstate(divide="ignore", invalid="ignore"):
                normals = np.where(length > 0, normals / length, 0.0).astype(np.float32)
            normals = np.concatenate([normals, np.zeros((1, 3), np.float32)])
            self._built = Mesh(vertices, faces, threads=_threads(self._nthreads)), starts, normals
        return self._built

    def _ids(self, triangles: NDArray[np.int32]) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Geometry and primitive of triangles of the whole; a miss, -1, becomes `INVALID_ID`."""
        starts = self._scene()[1]
        if len(starts) == 2:
            miss = (triangles < 0).astype(np.uint32)
            return np.negative(miss), triangles.view(np.uint32)
        geometry = np.searchsorted(starts, triangles, side="right") - 1
        primitive = np.where(geometry < 0, -1, triangles - starts[np.maximum(geometry, 0)])
        return geometry.astype(np.uint32), primitive.astype(np.uint32)

    def cast_rays(self, rays: Any, nthreads: int = 0) -> dict[str, Tensor]:
        """The first hits of rays (..., 6) float32, origin and direction.

        Returns t_hit (...) float32, inf for a miss; geometry_ids and primitive_ids (...) uint32, `INVALID_ID`
        for a miss; primitive_uvs (..., 2) and primitive_normals (..., 3) float32.
        """
        rays = _array(rays, np.float32, 6, "rays")
        mesh, _, normals = self._scene()
        hits = mesh.closest(rays, threads=_threads(nthreads))
        geometry, primitive = self._ids(np.ascontiguousarray(hits["triangle"]))
        uvs = np.empty((*hits.shape, 2), np.float32)
        uvs[..., 0], uvs[..., 1] = hits["u"], hits["v"]
        return {
            "t_hit": _tensor(hits["t"].astype(np.float32)),
            "geometry_ids": _tensor(geometry),
            "primitive_ids": _tensor(primitive),
            "primitive_uvs": _tensor(uvs),
            "primitive_normals": _tensor(normals[hits["triangle"]]),
        }

    def test_occlusions(self, rays: Any, tnear: float = 0.0, tfar: float = math.inf, nthreads: int = 0) -> Tensor:
        """Whether rays (..., 6) float32 hit anything from tnear to before tfar: (...) bool."""
        rays = _array(rays, np.float32, 6, "rays")
        mesh = self._scene()[0]
        return _tensor(mesh.any(rays, t_min=tnear, t_max=tfar, threads=_threads(nthreads)))

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Tensor:
        """How many surfaces rays (..., 6) float32 cross, each edge and corner once: (...) int32."""
        rays = _array(rays, np.float32, 6, "rays")
        counts = self._scene()[0].count_crossings(rays, threads=_threads(nthreads))
        return _tensor(counts["unsigned"].astype(np.int32))

    def list_intersections(self, rays: Any, nthreads: int = 0) -> dict[str, Tensor]:
        """All crossings of rays (..., 6) float32, in order along each ray, each edge and corner once.

        Returns ray_splits (n + 1,) and ray_ids (m,) uint32, t_hit (m,) float32, geometry_ids and primitive_ids
        (m,) uint32, primitive_uvs (m, 2) float32. Those of ray i are from ray_splits[i] to ray_splits[i + 1].
        """
        rays = _array(rays, np.float32, 6, "rays")
        lists = self._scene()[0].crossings(rays, threads=_threads(nthreads))
        hits = lists.hits
        geometry, primitive = self._ids(np.ascontiguousarray(hits["triangle"]))
        return {
            "ray_splits": _tensor(lists.offsets.astype(np.uint32)),
            "ray_ids": _tensor(lists.rays.astype(np.uint32)),
            "t_hit": _tensor(hits["t"].astype(np.float32)),
            "geometry_ids": _tensor(geometry),
            "primitive_ids": _tensor(primitive),
            "primitive_uvs": _tensor(np.stack([hits["u"], hits["v"]], axis=-1).astype(np.float32)),
        }

    # ---- Points ----

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> dict[str, Tensor]:
        """The closest points on the scene to points (..., 3) float32.

        Returns points (..., 3) float32, geometry_ids and primitive_ids (...) uint32, primitive_uvs (..., 2) and
        primitive_normals (..., 3) float32.
        """
        points = _array(query_points, np.float32, 3, "query_points")
        mesh, _, normals = self._scene()
        found = mesh.closest_point(points, threads=_threads(nthreads))
        geometry, primitive = self._ids(np.ascontiguousarray(found["triangle"]))
        return {
            "points": _tensor(found["point"].astype(np.float32)),
            "geometry_ids": _tensor(geometry),
            "primitive_ids": _tensor(primitive),
            "primitive_uvs": _tensor(np.stack([found["u"], found["v"]], axis=-1).astype(np.float32)),
            "primitive_normals": _tensor(normals[found["triangle"]]),
        }

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> Tensor:
        """The distances of points (..., 3) float32 to the scene: (...) float32."""
        points = _array(query_points, np.float32, 3, "query_points")
        found = self._scene()[0].closest_point(points, threads=_threads(nthreads))
        return _tensor(found["distance"].astype(np.float32))

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Tensor:
        """The distances of points (..., 3) float32 to the scene, negative inside: (...) float32.

        ``nsamples`` is taken and not needed: no ray is in doubt. An open scene is asked along one direction.
        """
        _odd(nsamples)
        points = _array(query_points, np.float32, 3, "query_points")
        mesh, threads = self._scene()[0], _threads(nthreads)
        return _tensor(mesh.signed_distance(points, assume_closed=True, threads=threads).astype(np.float32))

    def compute_occupancy(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Tensor:
        """1 for points (..., 3) float32 inside of the scene or on it, else 0: (...) float32."""
        _odd(nsamples)
        points = _array(query_points, np.float32, 3, "query_points")
        inside = self._scene()[0].contains(points, assume_closed=True, threads=_threads(nthreads))
        return _tensor(inside.astype(np.float32))

    # ---- Cameras ----

    @staticmethod
    def create_rays_pinhole(*args: Any, **named: Any) -> Tensor:
        """The rays of a picture, (height, width, 6) float32.

        Either ``intrinsic_matrix`` (3, 3), ``extrinsic_matrix`` (4, 4) from world to camera, ``width_px``,
        ``height_px``; or ``fov_deg``, across, ``center``, ``eye``, ``up``, ``width_px``, ``height_px``.
        """
        by_matrix = ("intrinsic_matrix", "extrinsic_matrix", "width_px", "height_px")
        by_angle = ("fov_deg", "center", "eye", "up", "width_px", "height_px")
        names = by_angle if len(args) + len(named) == len(by_angle) else by_matrix
        given = dict(zip(names, args)) | named
        if set(given) != set(names):
            raise TypeError(f"create_rays_pinhole takes {', '.join(by_matrix)}, or {', '.join(by_angle)}")
        width, height = int(given["width_px"]), int(given["height_px"])

        def matrix(name: str, *shape: int) -> NDArray[np.float64]:
            value = given[name]
            array = np.asarray(value.numpy() if hasattr(value, "numpy") else value, np.float64)
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
        return _tensor(rays)


def _odd(nsamples: int) -> None:
    if nsamples < 1 or nsamples % 2 == 0:
        raise ValueError(f"nsamples is {nsamples}; it must be odd")
