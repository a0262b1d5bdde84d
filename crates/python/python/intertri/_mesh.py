"""A mesh, and what rays and points ask of it."""

from __future__ import annotations

import hashlib
import math
import os
import zipfile
import zlib
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays
from ._arrays import F32, F64, Rays
from ._dtypes import CROSSING, CROSSINGS, HIT, NEAREST, HitLists
from ._intertri import SURFACE, Tree32, Tree64, closest_point
from ._nearest import Copy

Mode: TypeAlias = Literal["exact", "certified"]


class Mesh:
    """Triangles, and the hierarchy over them.

    Parameters
    ----------
    vertices : (n, 3) float32 or float64
        Corners, kept as they are: float32 stays float32, float64 stays float64. Integers become float64.
        Without ``faces``, triangles of shape (m, 3, 3).
    faces : (m, 3) integer, optional
        Rows of ``vertices``. Both sides of a face can be hit.
    threads : int, optional
        Threads that build, all by default.

    Raises
    ------
    ValueError
        If a shape is wrong or a vertex is not finite.
    TypeError
        If a dtype would lose digits: ``longdouble``, complex, objects.
    IndexError
        If a face names a vertex that is not there.
    MemoryError
        If there is too little memory.

    Answers
    -------
    They do not depend on the order of rays, the number of threads, or the CPU. With ``mode="exact"``, the
    default, hit or miss and the triangle are right for the coordinates as given, and t, u and v are the true
    values rounded once. An edge or corner belongs to every triangle that has it, so no ray slips through; of
    equal t the lowest triangle wins. With ``mode="certified"`` they are those of a plain loop in float64.

    Float64 rays keep their digits: a float32 mesh that meets rays which float32 cannot hold answers them in
    float64, through a second hierarchy that it makes then. Pass ``rays.astype(np.float32)`` to do without.

    Ctrl-C ends a long query with ``KeyboardInterrupt``. Queries let other threads of Python run.

    Examples
    --------
    >>> import numpy as np, intertri
    >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
    >>> mesh
    Mesh(1 face, 3 vertices, float64)
    >>> hit = mesh.closest([0.25, 0.5, 0], [0, 0, 2])
    >>> float(hit["t"]), int(hit["triangle"])
    (2.5, 0)
    """

    __slots__ = ("__weakref__", "_copy", "_digest", "_faces", "_open", "_trees", "_vertices")

    _vertices: NDArray[np.floating[Any]]
    _faces: NDArray[np.uint32]
    _trees: dict[np.dtype[Any], Tree32 | Tree64]
    _copy: Copy | None
    _digest: str | None
    _open: str | None

    def __init__(
        self, vertices: ArrayLike, faces: ArrayLike | None = None, *, threads: int | None = None
    ) -> None:
        corners, rows = _arrays.vertices_and_faces(vertices, faces)
        if corners is vertices or np.may_share_memory(corners, np.asarray(vertices)):
            corners = corners.copy()
        corners = np.ascontiguousarray(corners)
        corners.flags.writeable = rows.flags.writeable = False
        self._vertices, self._faces = corners, rows
        self._trees = {}
        self._copy = self._digest = self._open = None
        self._tree(corners.dtype, threads)

    def _tree(self, dtype: np.dtype[Any], threads: int | None) -> Tree32 | Tree64:
        """The hierarchy over a scalar, made when it is first asked for."""
        tree = self._trees.get(dtype)
        if tree is None:
            corners = _arrays.flat(self._vertices, dtype)
            tree = _native(dtype)(corners, self._faces.reshape(-1), _arrays.threads_of(threads))
            self._trees[dtype] = tree
        return tree

    # ---- What it is ----

    @property
    def vertices(self) -> NDArray[np.floating[Any]]:
        """Corners, (n, 3), read-only."""
        return self._vertices

    @property
    def faces(self) -> NDArray[np.uint32]:
        """Rows of `vertices`, (m, 3), read-only."""
        return self._faces

    @property
    def dtype(self) -> np.dtype[Any]:
        """``float32`` or ``float64``: what the coordinates are kept in."""
        return self._vertices.dtype

    @property
    def triangles(self) -> NDArray[np.floating[Any]]:
        """Corners of the faces, (m, 3, 3), a new array."""
        return self._vertices[self._faces]

    @property
    def bounds(self) -> NDArray[np.floating[Any]] | None:
        """The smallest and largest corner of the box around the faces, (2, 3); ``None`` without faces."""
        if not len(self._faces):
            return None
        used = self._vertices[np.unique(self._faces)]
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @property
    def digest(self) -> str:
        """A hash of dtype, vertices and faces: equal meshes have equal ones, on every machine.

        >>> import intertri
        >>> intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]]).digest[:8]
        '37cdf29a'
        """
        if self._digest is None:
            state = hashlib.sha256(f"{self.dtype.str} {self._vertices.shape} {self._faces.shape}".encode())
            little = self.dtype.newbyteorder("<")
            state.update(np.ascontiguousarray(self._vertices, little).data)
            state.update(np.ascontiguousarray(self._faces, "<u4").data)
            self._digest = state.hexdigest()
        return self._digest

    def __len__(self) -> int:
        return len(self._faces)

    def __repr__(self) -> str:
        faces, vertices = len(self._faces), len(self._vertices)
        s = "" if faces == 1 else "s"
        return f"Mesh({faces} face{s}, {vertices} vertices, {self.dtype})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (self._vertices, self._faces, self._tree(self.dtype, None).to_bytes())

    def __copy__(self) -> Mesh:
        return _restore(*self.__reduce__()[1])

    # ---- Files and motion ----

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes vertices, faces and hierarchy to a file, for `intertri.load`, the same on every machine.

        It is one of numpy's ``.npz`` files: ``vertices``, ``faces``, and ``tree``, the bytes of a saved hierarchy, of
        float32 alone.

        >>> import intertri, tempfile, os
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     mesh.save(os.path.join(folder, "mesh.npz"))
        ...     intertri.load(os.path.join(folder, "mesh.npz"))
        Mesh(1 face, 3 vertices, float64)
        """
        tree = np.frombuffer(self._tree(self.dtype, None).to_bytes(), np.uint8)
        with open(path, "wb") as file:
            np.savez(file, vertices=self._vertices, faces=self._faces, tree=tree)

    def refit(self, vertices: ArrayLike, *, threads: int | None = None) -> float:
        """Moves the vertices: new positions (n, 3) of the same faces, or (m, 3, 3) of a mesh made of triangles.

        In float32 it takes a small part of the time of a new mesh; in float64 all of it. Answers are those of a new mesh, but the more the faces
        move against each other, the longer queries take. A query that runs meanwhile in another thread answers for
        the old positions or for the new.

        Returns
        -------
        float
            About how many times as long rays take as in the tree when it was built: above 1.5 it is time for a new
            mesh.

        Raises
        ------
        ValueError
            If there are more vertices or fewer, or one is not finite: nothing has changed.

        Examples
        --------
        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> ratio = mesh.refit([[0, 0, 7], [1, 0, 7], [0, 1, 7]])
        >>> mesh.closest([0.2, 0.2, 0], [0, 0, 1])["t"]
        np.float64(7.0)
        """
        moved = _arrays.floats(vertices, "vertices")
        if moved.ndim == 3 and moved.shape[1:] == (3, 3):
            moved = moved.reshape(-1, 3)
        if moved.shape != self._vertices.shape:
            raise ValueError(f"vertices has shape {moved.shape}; it must be {self._vertices.shape}, as before")
        if self.dtype == F32 and not _arrays.fits_f32(moved):
            raise TypeError("vertices are float64 and the mesh is float32: pass vertices.astype(np.float32)")
        corners, _ = _arrays.vertices_and_faces(moved.astype(self.dtype), self._faces[:0])
        tree = self._tree(self.dtype, threads)
        ratio = tree.refit(corners.reshape(-1), self._faces.reshape(-1), _arrays.threads_of(threads))
        corners.flags.writeable = False
        self._vertices, self._trees = corners, {self.dtype: tree}
        self._copy = self._digest = self._open = None
        return ratio

    # ---- Rays ----

    def _rays(
        self, origins: ArrayLike, directions: ArrayLike | None, t_min: ArrayLike, t_max: ArrayLike
    ) -> Rays:
        return _arrays.rays(origins, directions, t_min, t_max, self.dtype)

    def closest(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mode: Mode = "exact",
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """The closest hit of each ray.

        Parameters
        ----------
        origins, directions : (..., 3)
            Where rays start and where they go, of shapes that broadcast: one origin may serve all. A direction
            need not have unit length. Or, without ``directions``, whole rays of shape (..., 6), origin and
            direction, or (..., 8), origin, t_min, direction, t_max; contiguous (n, 8) of float32 are read
            where they are.
        t_min, t_max : float or (...)
            A hit counts where t > 0 and t_min <= t < t_max, in multiples of the direction's length.
        mode : "exact" or "certified"
        threads : int, optional
            Threads that answer, all by default.
        out : (...) `HIT`, optional
            Where answers go: a contiguous array that is given again saves new memory.

        Returns
        -------
        (...) `HIT`
            Fields t, u, v, triangle (-1 for a miss, where t is infinite) and geometry. Rays with a NaN or an
            infinity miss.

        Raises
        ------
        ValueError, TypeError
            If shapes do not fit, or a dtype is none of numbers.

        Examples
        --------
        >>> import numpy as np, intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> hits = mesh.closest([0, 0, 0], [[0, 0, 1], [1, 1, 10], [1, 0, 0]])
        >>> hits["t"].tolist()
        [5.0, 0.5, inf]
        >>> hits["triangle"]
        array([ 0,  0, -1], dtype=int32)
        """
        rays = self._rays(origins, directions, t_min, t_max)
        hits = _arrays.answers(rays.shape, HIT, out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.closest(rays, mode, threads, rays.width, _arrays.as_bytes(hits))
        return hits if rays.shape or out is not None else hits[()]

    def closest_triangle(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mode: Mode = "exact",
        threads: int | None = None,
        out: NDArray[np.int32] | None = None,
    ) -> NDArray[np.int32]:
        """The triangles of `closest` alone, which is faster: (...) int32, -1 for a miss.

        Parameters are those of `closest`.

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.closest_triangle([0, 0, 0], [[0, 0, 1], [1, 0, 0]])
        array([ 0, -1], dtype=int32)
        """
        rays = self._rays(origins, directions, t_min, t_max)
        triangles = _arrays.answers(rays.shape, np.dtype(np.int32), out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.triangles(rays, mode, threads, rays.width, _arrays.as_bytes(triangles))
        return triangles if rays.shape or out is not None else triangles[()]

    def any(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mode: Mode = "exact",
        threads: int | None = None,
        out: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything: (...) bool.

        Parameters are those of `closest`. For shadows let directions run from the surface to the light, and
        ``t_max`` be 1.

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.any([0, 0, 0], [[0, 0, 10], [0, 0, 1]], t_max=1)
        array([ True, False])
        """
        rays = self._rays(origins, directions, t_min, t_max)
        any_hit = _arrays.answers(rays.shape, np.dtype(np.bool_), out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.any(rays, mode, threads, rays.width, any_hit.reshape(-1))
        return any_hit if rays.shape or out is not None else any_hit[()]

    def all(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        limit: int | None = None,
        mode: Mode = "exact",
        threads: int | None = None,
    ) -> HitLists:
        """Every hit of each ray, in order of t; of equal t, of the triangle.

        A point on an edge belongs to each triangle that has it. To count surfaces, ask `crossings`.

        Parameters
        ----------
        origins, directions, t_min, t_max, mode, threads
            As for `closest`; rays of more dimensions count in C order.
        limit : int, optional
            At most so many hits a ray, the nearest.

        Returns
        -------
        HitLists
            ``offsets`` (n + 1,) int64 and ``hits`` (m,) `HIT`: those of ray i are
            ``hits[offsets[i]:offsets[i + 1]]``. ``lists.rays`` names the ray of each hit.

        Examples
        --------
        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5], [0, 0, 7]], [[0, 1, 2], [3, 1, 2]])
        >>> lists = mesh.all([[0, 0, 0], [9, 9, 0]], [0, 0, 1])
        >>> lists.offsets
        array([0, 2, 2])
        >>> lists.hits["t"], lists.hits["triangle"], lists.rays
        (array([5., 7.]), array([0, 1], dtype=int32), array([0, 0]))
        """
        rays = self._rays(origins, directions, t_min, t_max)
        most = _limit_of(limit)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        offsets, hits = tree.all(rays, mode, threads, most)
        return HitLists(offsets, hits.view(HIT))

    def crossings(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        threads: int | None = None,
    ) -> HitLists:
        """Where each ray crosses the mesh, each edge and corner once, in order of t.

        Where a surface goes on across an edge, the ray crosses one of the two triangles; where it only
        touches a silhouette, an even number of triangles or none. Always exact.

        Returns
        -------
        HitLists
            As of `all`, with `CROSSING` for hits: ``leaves`` tells whether the ray runs with the normal, out
            of a mesh whose corners run counter-clockwise as seen from outside.

        Examples
        --------
        >>> import intertri
        >>> square = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5], [1, 1, 5]], [[0, 1, 2], [3, 2, 1]])
        >>> on_the_diagonal = [0.5, 0.5, 0], [0, 0, 1]
        >>> len(square.crossings(*on_the_diagonal).hits), len(square.all(*on_the_diagonal).hits)
        (1, 2)
        """
        rays = self._rays(origins, directions, t_min, t_max)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        offsets, hits = tree.crossings(rays, threads)
        return HitLists(offsets, hits.view(CROSSING))

    def count_crossings(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """How often each ray crosses the mesh, each edge and corner once: (...) `CROSSINGS`.

        ``signed`` is leaving less entering. Of a closed mesh and a ray without end it is the winding number
        of the origin, whatever the direction. ``unsigned`` is the number of `crossings`.

        >>> import intertri
        >>> square = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5], [1, 1, 5]], [[0, 1, 2], [3, 2, 1]])
        >>> counts = square.count_crossings([[0.5, 0.5, 0], [0.5, 0.5, 9]], [[0, 0, 1], [0, 0, -1]])
        >>> counts["signed"], counts["unsigned"]
        (array([ 1, -1]), array([1, 1]))
        """
        rays = self._rays(origins, directions, t_min, t_max)
        counts = _arrays.answers(rays.shape, CROSSINGS, out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.count_crossings(rays, threads, rays.width, _arrays.as_bytes(counts))
        return counts if rays.shape or out is not None else counts[()]

    # ---- Points ----

    def _points(self, values: ArrayLike) -> NDArray[np.floating[Any]]:
        """Points in the scalar that loses nothing."""
        points = _arrays.points(values)
        fits = self.dtype != F32 or _arrays.fits_f32(points)
        return points.astype(self.dtype if fits else _arrays.F64, copy=False)

    def _winding(self, points: ArrayLike, threads: int | None) -> NDArray[np.int32]:
        """Winding numbers, `SURFACE` on the mesh."""
        at = self._points(points)
        numbers = np.empty(at.shape[:-1], np.int32)
        tree, threads = self._tree(at.dtype, threads), _arrays.threads_of(threads)
        tree.winding(_arrays.flat(at, at.dtype), threads, _arrays.as_bytes(numbers))
        return numbers

    def contains(
        self, points: ArrayLike, *, assume_closed: bool = False, threads: int | None = None
    ) -> NDArray[np.bool_]:
        """Whether points are inside the mesh or on it: (...) bool for points of shape (..., 3). Always exact.

        Inside is where the mesh winds around: parts may overlap, and a part that is turned inside out within
        another is a cavity.

        Parameters
        ----------
        points : (..., 3)
            One that is not finite is outside.
        assume_closed : bool
            An open mesh has no inside, and is an error. If true, crossings along one direction decide.

        Raises
        ------
        ValueError
            If the mesh is open.

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> solid = intertri.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> solid.contains([[1, 1, 1], [3, 3, 3], [1, 1, 2], [1, 1, 2.0000000000000004]])
        array([ True, False,  True, False])
        """
        if not assume_closed:
            self._must_be_closed()
        inside: NDArray[np.bool_] = self._winding(points, threads) != 0
        return inside

    def winding_number(
        self, points: ArrayLike, *, assume_closed: bool = False, threads: int | None = None
    ) -> NDArray[np.int32]:
        """How often the mesh winds around points: (...) int32 for points of shape (..., 3); 0 on the mesh itself.

        Parameters and errors are those of `contains`.

        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> intertri.Mesh(corners, faces + faces).winding_number([[1, 1, 1], [3, 3, 3]])
        array([2, 0], dtype=int32)
        """
        if not assume_closed:
            self._must_be_closed()
        numbers = self._winding(points, threads)
        return np.where(numbers == SURFACE, np.int32(0), numbers)

    def is_on_surface(self, points: ArrayLike, *, threads: int | None = None) -> NDArray[np.bool_]:
        """Whether points lie exactly on the mesh: (...) bool for points of shape (..., 3).

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.is_on_surface([[0.5, 0.5, 5], [0.5, 0.5000000000000001, 5]])
        array([ True, False])
        """
        on: NDArray[np.bool_] = self._winding(points, threads) == SURFACE
        return on

    def closest_point(
        self,
        points: ArrayLike,
        *,
        radius: float = math.inf,
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """The point of the mesh that is nearest to each point.

        Parameters
        ----------
        points : (..., 3)
        radius : float
            How far to look: a point that is farther from the mesh has none.
        threads, out
            As for `closest`; ``out`` is of dtype `NEAREST`.

        Returns
        -------
        (...) `NEAREST`
            Fields distance, point, u, v, triangle (-1 for none) and geometry. In float32 the triangle is truly the
            nearest, and of those that are equally near the lowest. In float64 it is found on a copy in float32 about
            the mesh's middle, so it may be one that is farther by 2**-21 of the distance or of the mesh's size;
            distance and point are those of this triangle, in float64.

        Examples
        --------
        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> near = mesh.closest_point([[0.25, 0.25, 7], [3, 0, 5]])
        >>> near["distance"], near["point"][1]
        (array([2., 2.]), array([1., 0., 5.]))
        """
        at = self._points(points)
        if not radius >= 0:
            raise ValueError(f"radius is {radius}; it must not be negative")
        nearest, threads = _arrays.answers(at.shape[:-1], NEAREST, out, at), _arrays.threads_of(threads)
        if at.dtype == F32:
            tree = self._tree(F32, threads)
            assert isinstance(tree, Tree32)
            closest_point(tree, _arrays.flat(at, F32), float(radius), threads, _arrays.as_bytes(nearest))
        else:
            if self._copy is None:
                self._copy = Copy(self._vertices.astype(F64, copy=False), self._faces, threads)
            self._copy.find(np.ascontiguousarray(at, np.float64).reshape(-1, 3), radius, threads, nearest.reshape(-1))
        return nearest if at.ndim > 1 or out is not None else nearest[()]

    def signed_distance(
        self, points: ArrayLike, *, assume_closed: bool = False, threads: int | None = None
    ) -> NDArray[np.float64]:
        """Distances of points to the mesh, **negative inside**: (...) float64 for points of shape (..., 3).

        The sign is that of `contains`, exact; 0 on the mesh. Distances are those of `closest_point`. Parameters and errors are those of `contains`.
        ``intertri.trimesh.signed_distance`` has trimesh's sign, positive inside.

        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> solid = intertri.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> solid.signed_distance([[0.5, 1, 1], [-2, 1, 1], [0, 1, 1]])
        array([-0.5,  2. ,  0. ])
        """
        inside = self.contains(points, assume_closed=assume_closed, threads=threads)
        distance = self.closest_point(points, threads=threads)["distance"]
        signed: NDArray[np.float64] = np.where(inside & (distance > 0), -distance, distance)
        return signed

    @property
    def is_closed(self) -> bool:
        """Whether every edge is run along as often one way as the other, so that the mesh has an inside."""
        return self._open_edge() is None

    def _open_edge(self) -> str | None:
        """Says which edge is open."""
        if self._open is None:
            tree = self._tree(self.dtype, None)
            self._open = tree.open_edge(self._vertices.reshape(-1), self._faces.reshape(-1)) or ""
        return self._open or None

    def _must_be_closed(self) -> None:
        where = self._open_edge()
        if where is not None:
            raise ValueError(f"the mesh is open: {where}; assume_closed=True asks all the same")


def _restore(vertices: NDArray[np.floating[Any]], faces: NDArray[np.uint32], tree: bytes) -> Mesh:
    """A mesh from its saved state."""
    mesh = Mesh.__new__(Mesh)
    corners, rows = _arrays.vertices_and_faces(vertices, faces)
    corners, rows = corners.copy(), rows.copy()
    corners.flags.writeable = rows.flags.writeable = False
    mesh._vertices, mesh._faces = corners, rows
    mesh._copy = mesh._digest = mesh._open = None
    flat = _arrays.flat(corners, corners.dtype)
    mesh._trees = {corners.dtype: _native(corners.dtype).from_bytes(tree, flat, rows.reshape(-1))}
    return mesh


def load(path: str | os.PathLike[str]) -> Mesh:
    """A mesh that `Mesh.save` wrote: in float32 several times faster than it was built; in float64 it is built anew.

    Raises
    ------
    ValueError
        If the file is none of those, damaged, or of a later version. Whatever a file holds, nothing of it is run.
    OSError
        If it cannot be read.
    """
    with open(path, "rb") as file:
        try:
            with np.load(file, allow_pickle=False) as saved:
                vertices, faces, tree = saved["vertices"], saved["faces"], saved["tree"]
        except (KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise ValueError(f"{os.fspath(path)} holds no mesh: {error}") from None
    if vertices.dtype not in (F32, F64) or faces.dtype != np.uint32 or tree.dtype != np.uint8:
        raise ValueError(f"{os.fspath(path)} holds no mesh: its arrays have other types")
    return _restore(vertices, faces, tree.tobytes())


def _native(dtype: np.dtype[Any]) -> type[Tree32] | type[Tree64]:
    """The class of hierarchies over a scalar."""
    return Tree32 if dtype == F32 else Tree64


def _limit_of(limit: int | None) -> int | None:
    """At most so many hits a ray."""
    if limit is None:
        return None
    if not isinstance(limit, (int, np.integer)) or isinstance(limit, bool):
        raise TypeError(f"limit must be an integer or None, not {type(limit).__name__}")
    if limit < 0:
        raise ValueError(f"limit is {limit}; it must not be negative")
    return min(int(limit), 2**32 - 1)
