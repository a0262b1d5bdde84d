"""Exact versions of trimesh's ray interface, `contains`, and signed distance, in float64.

>>> import trimesh, intertri.trimesh
>>> mesh = intertri.trimesh.install(trimesh.creation.box())
>>> mesh.ray.intersects_first([[0, 0, 5]], [[0, 0, -1]]) >= 0
array([ True])
>>> mesh.contains([[0, 0, 0], [0, 0, 0.7]])
array([ True, False])
"""

# trimesh's type annotations vary from version to version.
# pyright: reportAttributeAccessIssue=false, reportArgumentType=false, reportAssignmentType=false, reportCallIssue=false

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from trimesh.caching import Cache

from .. import _mesh

Ints: TypeAlias = NDArray[np.int64]
Floats: TypeAlias = NDArray[np.float64]

__all__ = ["ProximityQuery", "RayMeshIntersector", "closest_point", "install", "signed_distance"]


def install(mesh: Any) -> Any:
    """Makes a trimesh mesh query intertri: ``mesh.ray`` becomes a `RayMeshIntersector` and
    ``mesh.nearest`` a `ProximityQuery`, so ``mesh.contains`` and all other methods that use rays
    are exact. Returns the mesh.

    Copies and pickles of the mesh, and the meshes that its methods return, such as ``split``,
    ``subdivide``, and ``+``, query intertri as well. The class of the mesh becomes a subclass of
    its former class.
    """
    if not isinstance(mesh, trimesh.Trimesh):
        hint = "; pass each mesh of scene.geometry.values()" if hasattr(mesh, "geometry") else ""
        raise TypeError(f"install takes a trimesh.Trimesh, not a {type(mesh).__name__}{hint}")
    base: Any = type(mesh)
    if not issubclass(base, _Installed):
        mesh.__class__ = _installed(base)
    _equip(mesh)
    return mesh


def _equip(mesh: Any) -> None:
    mesh.ray = RayMeshIntersector(mesh)
    mesh.nearest = ProximityQuery(mesh)


class _Installed:
    """Marks the classes of meshes that query intertri."""

    __slots__ = ()


# Methods of trimesh that return new meshes.
_MAKERS = (
    "copy",
    "split",
    "submesh",
    "subdivide",
    "subdivide_to_size",
    "subdivide_loop",
    "slice_plane",
    "simplify_quadric_decimation",
    "unwrap",
    "union",
    "difference",
    "intersection",
    "convex_decomposition",
    "to_mesh",
    "__add__",
    "__radd__",
)


@functools.cache
def _installed(base: type) -> type:
    """Returns a subclass of a mesh class. Its instances query intertri, as do the meshes that their
    methods return."""

    def initialize(self: Any, *args: Any, **options: Any) -> None:
        base.__init__(self, *args, **options)  # type: ignore[misc]
        _equip(self)

    def reduce(self: Any, protocol: Any) -> tuple[Any, ...]:
        return _empty, (base,), self.__dict__

    makers = {name: _installing(getattr(base, name)) for name in _MAKERS if hasattr(base, name)}
    own = {"__init__": initialize, "__reduce_ex__": reduce, "__module__": base.__module__, "__doc__": base.__doc__}
    return type(base.__name__, (base, _Installed), makers | own)


def _installing(method: Callable[..., Any]) -> Callable[..., Any]:
    """Wraps a method so that it installs intertri in the meshes that it returns."""

    @functools.wraps(method)
    def call(*args: Any, **options: Any) -> Any:
        made = method(*args, **options)
        for mesh in made if isinstance(made, (list, tuple)) else [made]:
            if isinstance(mesh, trimesh.Trimesh):
                install(mesh)
        return made

    return call


def _empty(base: type) -> Any:
    """Creates an empty mesh for a pickle to fill."""
    return object.__new__(_installed(base))


class RayMeshIntersector:
    """Ray queries of a mesh, with the interface of ``trimesh.ray.ray_pyembree.RayMeshIntersector``.

    `intersects_first`, `intersects_any`, and every call with ``multiple_hits=False`` find the
    closest hit in front of the origin, with t > 0. An edge or corner belongs to all its triangles,
    so no ray slips through.

    With ``multiple_hits=True``, the answers are crossings, in order along the ray. Each surface
    counts once, even if the ray meets one of its edges or corners. A ray that starts exactly on the
    mesh is assumed to come from outside, so it crosses the mesh at its origin if it goes in.

    Parameters
    ----------
    geometry : trimesh.Trimesh
        The hierarchy is built on first use, and again after the mesh has changed.
    scale_to_box : bool
        Accepted for compatibility, but without effect.
    """

    def __init__(self, geometry: Any, scale_to_box: bool = True) -> None:
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._cache = Cache(id_function=geometry.__hash__)

    @property
    def intertri(self) -> _mesh.Mesh:
        """The `intertri.Mesh` that answers the queries."""
        self._cache.verify()
        if "mesh" not in self._cache:
            vertices = np.asarray(self.mesh.vertices, np.float64).reshape(-1, 3)
            faces = np.asarray(self.mesh.faces, np.int64).reshape(-1, 3)
            self._cache["mesh"] = _mesh.Mesh(vertices, faces)
        found: _mesh.Mesh = self._cache["mesh"]
        return found

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True, **options: Any
    ) -> tuple[Floats, Ints, Ints]:
        """Finds where rays meet the mesh: locations (m, 3), and the ray (m,) and face (m,) of each
        location."""
        triangles, rays, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits, return_locations=True, **options
        )
        return locations, rays, triangles

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int = 100,
        return_locations: bool = False,
    ) -> tuple[Any, ...]:
        """Returns the faces that rays meet (m,), the rays that meet them (m,), and, with
        ``return_locations``, the locations (m, 3).

        Parameters
        ----------
        ray_origins, ray_directions : (n, 3) float
        multiple_hits : bool
            Whether to return all crossings or only the closest hit.
        max_hits : int
            The maximum number of hits per ray. The nearest hits are kept; if others are dropped, a
            warning says so.
        """
        origins, directions = _rays(ray_origins, ray_directions)
        if multiple_hits:
            rays, triangles, t = self._crossings(origins, directions, max_hits)
        else:
            hits = self.intertri.closest(origins, directions)
            rays = np.flatnonzero(hits["triangle"] >= 0)
            triangles, t = hits["triangle"][rays], hits["t"][rays]
        if not return_locations:
            return triangles.astype(np.int64), rays
        return triangles.astype(np.int64), rays, origins[rays] + t[:, None] * directions[rays]

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Ints:
        """Returns the face that each ray meets first, or -1 for none: (n,)."""
        return self.intertri.closest_triangle(*_rays(ray_origins, ray_directions)).astype(np.int64)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> NDArray[np.bool_]:
        """Returns whether each ray meets the mesh: (n,)."""
        return self.intertri.any(*_rays(ray_origins, ray_directions))

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Returns whether points are inside the mesh or on it: (n,).

        In a closed mesh with consistently oriented faces, a point is inside if the mesh winds
        around it. In any other mesh, it is inside if a ray from it crosses an odd number of faces.
        """
        at = np.asarray(points, np.float64)
        if at.ndim != 2 or at.shape[1] != 3:
            raise ValueError("points must be (n,3)")
        return self.intertri._inside_or_odd(at)

    def _crossings(
        self, origins: Floats, directions: Floats, max_hits: int
    ) -> tuple[Ints, NDArray[np.int32], Floats]:
        """Returns the crossings in order along each ray: ray, triangle, and t."""
        mesh = self.intertri
        lists = mesh.crossings(origins, directions)
        hits, rays = lists.hits, lists.rays
        triangles, t = hits["triangle"], hits["t"]
        counts = np.diff(lists.offsets)
        start = self._entered_at_start(origins, directions, lists.offsets, hits["leaves"])
        if start is not None:
            entering, faces = start
            counts[entering] += 1
            at = lists.offsets[entering]
            rays = np.insert(rays, at, entering)
            triangles = np.insert(triangles, at, faces)
            t = np.insert(t, at, 0.0)
        if counts.size and counts.max() > max_hits:
            cut = int((counts > max_hits).sum())
            warnings.warn(
                f"{cut} of {len(counts)} rays cross the mesh more than max_hits={max_hits} times; "
                f"pass max_hits={counts.max()} to get all crossings",
                stacklevel=3,
            )
            first = np.repeat(np.cumsum(counts) - counts, counts)
            near = np.arange(len(rays)) - first < max_hits
            rays, triangles, t = rays[near], triangles[near], t[near]
        return rays, triangles, t

    def _entered_at_start(
        self, origins: Floats, directions: Floats, offsets: Ints, leaves: NDArray[np.bool_]
    ) -> tuple[Ints, NDArray[np.int32]] | None:
        """Returns the rays that start on the mesh and go in, each with a face on which it
        starts."""
        mesh = self.intertri
        if not len(origins) or not len(mesh):
            return None
        if (origins == origins[0]).all():
            starting = np.arange(len(origins) if mesh.is_on_surface(origins[0]) else 0)
        else:
            starting = np.flatnonzero(mesh.is_on_surface(origins))
        ways = directions[starting]
        starting = starting[np.isfinite(ways).all(axis=1) & ways.any(axis=1)]
        if not len(starting):
            return None
        faces: NDArray[np.int32] = mesh.closest_point(origins[starting])["triangle"]
        if mesh.is_closed:
            # A ray that later leaves the mesh more often than it enters must enter at its origin.
            sides = np.concatenate([[0], np.cumsum(np.where(leaves, 1, -1))])
            enters = (sides[offsets[1:]] - sides[offsets[:-1]])[starting] != 0
        else:
            a, b, c = np.moveaxis(mesh.triangles[faces], 1, 0)
            enters = np.einsum("ij,ij->i", np.cross(b - a, c - a), directions[starting]) < 0
        return starting[enters], faces[enters]

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        state.pop("_cache", None)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._cache = Cache(id_function=self.mesh.__hash__)

    def __deepcopy__(self, *_: Any) -> RayMeshIntersector:
        return self.__copy__()

    def __copy__(self) -> RayMeshIntersector:
        return RayMeshIntersector(self.mesh, self._scale_to_box)


def _rays(origins: ArrayLike, directions: ArrayLike) -> tuple[Floats, Floats]:
    """Converts rays to arrays (n, 3)."""
    start, way = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
    if start.size == 0 and way.size == 0:
        return start.reshape(0, 3), way.reshape(0, 3)
    if start.shape != way.shape:
        raise ValueError("Ray origin and direction don't match!")
    if start.ndim != 2 or start.shape[1] != 3:
        raise ValueError(f"rays have shape {start.shape}; it must be (n, 3)")
    return start, way


# ---- Points ----


def _asked(mesh: Any) -> RayMeshIntersector:
    """Returns the intersector of a mesh: the installed intersector, or else a new one."""
    ray = getattr(mesh, "ray", None)
    return ray if isinstance(ray, RayMeshIntersector) else RayMeshIntersector(mesh)


# The number of candidates to compare at a time.
_MANY = 1 << 20


def _closest(mesh: Any, asked: RayMeshIntersector, points: ArrayLike) -> tuple[Floats, Floats, Ints]:
    """Returns the closest points, distances, and faces. If faces share the edge or corner where the
    closest point is, the face most turned toward the query point is chosen, as in trimesh: its
    normal shows on which side of the surface the query point is."""
    at = np.asarray(points, np.float64)
    if at.ndim != 2 or at.shape[1] != 3:
        raise ValueError(f"points have shape {at.shape}; it must be (n, 3)")
    found = asked.intertri.closest_point(at)
    near, distance, faces = asked.intertri.hit_points(found), found["distance"], found["triangle"].astype(np.int64)
    # Even if the exact weights u and v add up to 1, the rounded weights may not.
    without = np.stack([1 - found["u"] - found["v"] <= 2**-52, found["u"] == 0, found["v"] == 0], axis=-1)
    shared = np.flatnonzero(without.any(axis=-1) & (distance > 0) & (faces >= 0))
    if len(shared) == 0:
        return near, distance, faces
    around = np.sort(np.asarray(mesh.vertex_faces), axis=1)
    normals, corners = np.asarray(mesh.face_normals), np.asarray(mesh.faces)
    for rows in np.array_split(shared, 1 + len(shared) * around.shape[1] // _MANY):
        # Find the first and the last corner with a nonzero weight. At a corner, both are that
        # corner; on an edge, they are its ends.
        ends = [without[rows].argmin(axis=1), 2 - without[rows, ::-1].argmin(axis=1)]
        first, last = (corners[faces[rows], end] for end in ends)
        others = around[first]
        facing = np.einsum("ijk,ik->ij", normals[others], at[rows] - near[rows])
        # A degenerate face has no normal, so exclude it.
        fits = (others >= 0) & (corners[others] == last[:, None, None]).any(axis=-1) & normals[others].any(axis=-1)
        facing[~fits] = -np.inf
        best = facing.argmax(axis=1)[:, None]
        faces[rows] = np.where(fits.any(axis=1), np.take_along_axis(others, best, 1)[:, 0], faces[rows])
    return near, distance, faces


def closest_point(mesh: Any, points: ArrayLike) -> tuple[Floats, Floats, Ints]:
    """Returns the closest points on the mesh (n, 3), distances (n,), and faces (n,), like
    ``trimesh.proximity.closest_point``.

    Unless `install` has been called, each call builds the hierarchy.
    """
    return _closest(mesh, _asked(mesh), points)


def signed_distance(mesh: Any, points: ArrayLike) -> Floats:
    """Returns distances to the mesh (n,), **positive inside** and 0 on it, like
    ``trimesh.proximity.signed_distance``.

    The sign comes from `RayMeshIntersector.contains_points`, not from a normal.
    """
    return ProximityQuery(mesh).signed_distance(points)


class ProximityQuery:
    """Point queries of a mesh, with `on_surface`, `signed_distance`, and `vertex` as in
    ``trimesh.proximity.ProximityQuery``."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh
        self._asked = _asked(mesh)

    def on_surface(self, points: ArrayLike) -> tuple[Floats, Floats, Ints]:
        """See `closest_point`."""
        return _closest(self._mesh, self._asked, points)

    def signed_distance(self, points: ArrayLike) -> Floats:
        """See the `signed_distance` function."""
        at = np.asarray(points, np.float64)
        distance: Floats = self._asked.intertri.closest_point(at)["distance"]
        signed: Floats = np.where(self._asked.contains_points(at), distance, -distance)
        return signed

    def vertex(self, points: ArrayLike) -> tuple[Floats, Ints]:
        """Finds the closest vertex of the mesh with trimesh's own tree: distances (n,) and vertices
        (n,)."""
        found: tuple[Floats, Ints] = self._mesh.kdtree.query(points)
        return found
