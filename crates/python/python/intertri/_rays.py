"""Ray queries of a mesh: hits, crossings, visibility, and results derived from hits."""

from __future__ import annotations

import math
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _memory
from ._arrays import F32, Rays
from ._dtypes import CROSSING, CROSSINGS, HIT, HIT32, NEAREST, HitLists
from ._triangles import Triangles, native

Mode: TypeAlias = Literal["exact", "certified"]


class RayQueries(Triangles):
    """The part of `Mesh` that answers ray queries."""

    __slots__ = ()

    def _rays(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None,
        t_min: ArrayLike,
        t_max: ArrayLike,
        skip: ArrayLike | None = None,
    ) -> Rays:
        rays = _arrays.rays(origins, directions, t_min, t_max, self.dtype)
        if skip is not None:
            rays.skip = _arrays.numbers_of_faces(skip, "skip", rays.shape, len(self)).reshape(-1)
        return rays

    def closest(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        skip: ArrayLike | None = None,
        nan_misses: bool = False,
        mode: Mode = "exact",
        threads: int | None = None,
        dtype: np.dtype[np.void] | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """Finds the closest hit of each ray.

        Parameters
        ----------
        origins, directions : (..., 3)
            The origins and directions of rays, in shapes that broadcast, so one origin can serve
            all rays. A direction need not have unit length. If ``directions`` is omitted,
            ``origins`` contains whole rays of shape (..., 6): origin, direction; or (..., 8):
            origin, t_min, direction, t_max. A contiguous (n, 8) float32 array is read in place.
        t_min, t_max : float or (...)
            A hit counts if t > 0 and t_min <= t < t_max, in multiples of the direction's length. A plain Python number
            takes the dtype of the rays; numpy scalars and arrays keep theirs.
        skip : integer or (...), optional
            The triangle that each ray ignores, such as the one that it starts on, or -1 for none.
        nan_misses : bool
            Whether t, u, and v of misses are NaN instead of infinity and 0, which is convenient for
            plots and means.
        mode : "exact" or "certified"
        threads : int, optional
            The number of threads; all by default.
        dtype : `HIT` or `HIT32`, optional
            `HIT32` stores t, u, and v in float32. The default is the dtype of ``out``, or `HIT`.
        out : (...) `HIT` or `HIT32`, optional
            A contiguous array for the answers; reusing one saves an allocation.

        Returns
        -------
        (...) `HIT` or `HIT32`
            The fields are t, u, v, triangle, and geometry. For a miss, the triangle is -1 and t is
            infinite. A ray misses if a component of its origin or direction is NaN or infinite.

        Raises
        ------
        ValueError, TypeError
            If shapes do not broadcast, a dtype is not numeric, or ``dtype`` and ``out`` disagree.

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
        rays = self._rays(origins, directions, t_min, t_max, skip)
        dtype = _hit_dtype(dtype, out)
        hits = _arrays.answers(rays.shape, dtype, out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.closest(rays, mode, threads, rays.width, dtype is HIT32, _arrays.as_bytes(hits))
        if nan_misses:
            _arrays.mark_misses(hits, "t")
        return hits if rays.shape or out is not None else hits[()]

    def closest_triangle(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        skip: ArrayLike | None = None,
        mode: Mode = "exact",
        threads: int | None = None,
        out: NDArray[np.int32] | None = None,
    ) -> NDArray[np.int32]:
        """Finds only the triangles of the closest hits, which is faster than `closest`: (...)
        int32, or -1 for a miss.

        The parameters are the same as for `closest`.

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.closest_triangle([0, 0, 0], [[0, 0, 1], [1, 0, 0]])
        array([ 0, -1], dtype=int32)
        """
        rays = self._rays(origins, directions, t_min, t_max, skip)
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
        skip: ArrayLike | None = None,
        mode: Mode = "exact",
        threads: int | None = None,
        out: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.bool_]:
        """Returns whether each ray hits anything: (...) bool.

        The parameters are the same as for `closest`. To check whether a point is in shadow, use
        `visible`: a ray that starts on a surface may hit that surface, because its origin is
        rounded.

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.any([0, 0, 0], [[0, 0, 10], [0, 0, 1]], t_max=1)
        array([ True, False])
        """
        rays = self._rays(origins, directions, t_min, t_max, skip)
        any_hit = _arrays.answers(rays.shape, np.dtype(np.bool_), out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.any(rays, mode, threads, rays.width, any_hit.reshape(-1))
        return any_hit if rays.shape or out is not None else any_hit[()]

    def visible(
        self,
        a: ArrayLike,
        b: ArrayLike,
        *,
        skip_a: ArrayLike | None = None,
        skip_b: ArrayLike | None = None,
        threads: int | None = None,
        out: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.bool_]:
        """Returns whether the points ``a`` and ``b`` see each other: (...) bool. The answer is
        always exact.

        The surfaces on which the points lie do not hide them. A point lies on a triangle if it is
        at most 16 rounding units away from it. One unit is ``2**-52`` times the largest coordinate
        of both points and the triangle, or ``2**-23`` times that coordinate for float32 points.
        Therefore, no surface shadows itself because a point was rounded, not even next to an edge.
        Any other triangle hides ``b`` if the ray from ``a`` in direction ``b - a`` hits it with t
        strictly between 0 and 1.

        Parameters
        ----------
        a, b : (..., 3)
            Points in shapes that broadcast, so one light can serve all points. The query is fastest
            if all ``a`` or all ``b`` are the same. Points that are not finite see nothing.
        skip_a, skip_b : integer or (...), optional
            The triangles on which the points lie, or -1 for none. Pass them if you know them and
            the points are not accurate to 16 rounding units.
        threads, out
            As for `any`.

        Examples
        --------
        >>> import numpy as np, intertri
        >>> mesh = intertri.Mesh([[0.1, 0.2, 0.3], [1.3, 0.1, 0.7], [0.4, 1.1, 0.2]], [[0, 1, 2]])
        >>> light = [3, 1, 4]
        >>> mesh.visible([mesh.vertices.mean(axis=0), mesh.vertices[0], [0, 0, -1]], light)
        array([ True,  True, False])
        """
        a, b = np.asarray(a), np.asarray(b)
        rays = _arrays.rays(a, b, 0.0, math.inf, self.dtype, ("a", "b"))
        if skip_a is not None or skip_b is not None:
            skips = [(skip_a, "skip_a"), (skip_b, "skip_b")]
            faces = [
                _arrays.numbers_of_faces(-1 if skip is None else skip, name, rays.shape, len(self))
                for skip, name in skips
            ]
            rays.skip = np.stack(faces, axis=-1).reshape(-1)
        is_single = rays.dtype == F32 or any(np.dtype(x.dtype).itemsize <= 4 and x.dtype.kind == "f" for x in (a, b))
        visible = _arrays.answers(rays.shape, np.dtype(np.bool_), out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.visible(rays, threads, rays.width, 23 if is_single else 52, visible.reshape(-1))
        return visible if rays.shape or out is not None else visible[()]

    def spawn_rays(
        self, hits: NDArray[np.void], directions: ArrayLike, *, threads: int | None = None
    ) -> NDArray[np.floating[Any]]:
        """Returns rays that start at hits of the mesh: (..., 6), origin and direction, in the dtype
        of the mesh.

        A ray starts at the rounded hit, or a few units in the last place away on the side to which
        it goes. In "exact" mode, it never hits the triangle that it starts on, but near an edge it
        may hit an adjacent triangle. To check whether a point sees a light, use `visible`.

        Parameters
        ----------
        hits : (...) `HIT`, `HIT32`, `CROSSING`, or `NEAREST`
            The result of `closest`, `all`, `crossings`, or `closest_point` for this mesh. Rays of
            `HIT32` start where the weights in float32 place the hit.
        directions : (..., 3)
            The directions of the rays, which are rounded to the dtype of the mesh.

        Returns
        -------
        (..., 6)
            The origins are NaN for misses, so rays that start at misses hit nothing.

        Examples
        --------
        >>> import intertri
        >>> mesh = intertri.Mesh([[0.1, 0.2, 0.3], [1.3, 0.1, 0.7], [0.4, 1.1, 0.2]], [[0, 1, 2]])
        >>> hits = mesh.closest([[0.5, 0.4, 4], [0.6, 0.5, 4], [9, 9, 9]], [0, 0, -1])
        >>> bounced = mesh.spawn_rays(hits, [0, 0.1, 1])
        >>> mesh.any(bounced)
        array([False, False, False])
        """
        found = self._hits(hits)
        ways = _arrays.points(directions, "directions").astype(self.dtype, copy=False)
        shape = _arrays.broadcast(found.shape, ways.shape[:-1], "hits and directions")
        rows = _memory.empty(shape, HIT)
        for name in HIT.names or ():
            rows[name] = found[name] if name in (found.dtype.names or ()) else 0
        rays = _memory.empty((*shape, 6), self.dtype)
        native(self.dtype).spawn_rays(
            self._at.vertices.reshape(-1),
            self._faces.reshape(-1),
            _arrays.as_bytes(rows),
            _arrays.flat(np.broadcast_to(ways, (*shape, 3)), self.dtype),
            _arrays.threads_of(threads),
            rays.reshape(-1),
        )
        return rays

    def thickness(self, hits: NDArray[np.void], *, threads: int | None = None) -> NDArray[np.float64]:
        """Returns the thickness of a solid at each hit: the distance to the next triangle, measured
        straight into the solid.

        The direction into the solid is opposite to the normal (see `hit_normals`), so corners must
        run counter-clockwise as seen from outside. The triangle that was hit is ignored.

        Parameters
        ----------
        hits : (...) `HIT`, `HIT32`, `CROSSING`, or `NEAREST`
            The result of `closest`, `all`, `crossings`, or `closest_point` for this mesh.

        Returns
        -------
        (...) float64
            The thickness, which is infinite if there is nothing behind the hit, and NaN for misses.

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> solid = intertri.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> solid.thickness(solid.closest([[1, 0.5, -1], [9, 9, 9]], [0, 0, 1]))
        array([2.5, nan])
        """
        inward = (-self.hit_normals(hits)).astype(self.dtype)
        rays = self.spawn_rays(hits, inward, threads=threads)
        found = self.closest(rays, threads=threads)["t"] * np.linalg.norm(inward.astype(np.float64), axis=-1)
        return np.where(np.isnan(inward).any(axis=-1), math.nan, found)[()]

    def all(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        skip: ArrayLike | None = None,
        limit: int | None = None,
        mode: Mode = "exact",
        threads: int | None = None,
    ) -> HitLists:
        """Finds every hit of each ray, in order of t. Hits with the same t are ordered by triangle.

        A hit on an edge counts for every triangle that shares the edge. To count surfaces, use
        `crossings`.

        Parameters
        ----------
        origins, directions, t_min, t_max, mode, threads
            As for `closest`. If the rays have more than one dimension, they are numbered in C
            order.
        limit : int, optional
            The maximum number of hits per ray. The nearest hits are kept.

        Returns
        -------
        HitLists
            ``offsets`` (n + 1,) int64 and ``hits`` (m,) `HIT`: ray i has
            ``hits[offsets[i]:offsets[i + 1]]``. ``lists.rays`` contains the index of the ray of
            each hit.

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
        rays = self._rays(origins, directions, t_min, t_max, skip)
        most = _limit_of(limit)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        offsets, hits = tree.all(rays, mode, threads, rays.width, most)
        return HitLists(offsets, hits.view(HIT))

    def crossings(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        skip: ArrayLike | None = None,
        threads: int | None = None,
    ) -> HitLists:
        """Finds every crossing of each ray with the mesh, in order of t. The answers are always
        exact.

        An edge or corner counts once. If a ray passes through the surface at an edge, it crosses
        one of the two triangles. If it only touches the silhouette at an edge or corner, it crosses
        an even number of triangles or none.

        Returns
        -------
        HitLists
            As for `all`, with `CROSSING` for the hits: ``leaves`` is true if the ray crosses in the
            direction of the normal, that is, out of a mesh whose corners run counter-clockwise as
            seen from outside.

        Examples
        --------
        >>> import intertri
        >>> square = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5], [1, 1, 5]], [[0, 1, 2], [3, 2, 1]])
        >>> on_the_diagonal = [0.5, 0.5, 0], [0, 0, 1]
        >>> len(square.crossings(*on_the_diagonal).hits), len(square.all(*on_the_diagonal).hits)
        (1, 2)
        """
        rays = self._rays(origins, directions, t_min, t_max, skip)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        offsets, hits = tree.crossings(rays, threads, rays.width)
        return HitLists(offsets, hits.view(CROSSING))

    def count_crossings(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        skip: ArrayLike | None = None,
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """Counts how often each ray crosses the mesh: (...) `CROSSINGS`.

        An edge or corner counts once. ``signed`` is the number of crossings at which the ray leaves
        minus the number at which it enters. For a closed mesh and a ray without limits, it is the
        winding number of the origin, regardless of the direction. ``unsigned`` is the number of
        `crossings`.

        >>> import intertri
        >>> square = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5], [1, 1, 5]], [[0, 1, 2], [3, 2, 1]])
        >>> counts = square.count_crossings([[0.5, 0.5, 0], [0.5, 0.5, 9]], [[0, 0, 1], [0, 0, -1]])
        >>> counts["signed"], counts["unsigned"]
        (array([ 1, -1]), array([1, 1]))
        """
        rays = self._rays(origins, directions, t_min, t_max, skip)
        counts = _arrays.answers(rays.shape, CROSSINGS, out, *rays.parts)
        tree, threads = self._tree(rays.dtype, threads), _arrays.threads_of(threads)
        tree.count_crossings(rays, threads, rays.width, _arrays.as_bytes(counts))
        return counts if rays.shape or out is not None else counts[()]

    def hit_points(self, hits: NDArray[np.void]) -> NDArray[np.float64]:
        """Returns the positions of hits: (..., 3) float64, computed from the weights u and v, or
        NaN for misses. For answers of `closest_point`, returns their x, y, and z.

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.hit_points(mesh.closest([[0.25, 0.5, 0], [9, 9, 9]], [0, 0, 1]))
        array([[0.25, 0.5 , 5.  ],
               [ nan,  nan,  nan]])
        """
        if np.asarray(hits).dtype == NEAREST:
            near = self._hits(hits)
            return np.stack([near[name] for name in "xyz"], axis=-1)
        found, corners = self._corners(hits)
        u, v = (np.asarray(found[name], np.float64)[..., None] for name in "uv")
        points: NDArray[np.float64] = (1 - u - v) * corners[..., 0, :] + u * corners[..., 1, :] + v * corners[..., 2, :]
        return points

    def hit_normals(self, hits: NDArray[np.void]) -> NDArray[np.float64]:
        """Returns the unit normals of the triangles that were hit: (..., 3) float64, or NaN for
        misses. The normals point to the side from which the corners run counter-clockwise.

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.hit_normals(mesh.closest([0.25, 0.5, 0], [0, 0, 1]))
        array([0., 0., 1.])
        """
        _, corners = self._corners(hits)
        normals = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
        unit: NDArray[np.float64] = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
        return unit

    def _hits(self, hits: NDArray[np.void]) -> NDArray[np.void]:
        """Checks that hits have a suitable dtype and refer to faces of this mesh."""
        found = np.asarray(hits)
        if not {"u", "v", "triangle"} <= set(found.dtype.names or ()):
            raise TypeError(f"hits has dtype {found.dtype}; pass what closest, closest_point, all or crossings returned")
        if found.size and found["triangle"].max() >= len(self):
            raise IndexError(f"hits refer to triangle {found['triangle'].max()}, but there are {len(self)} faces")
        return found

    def _corners(self, hits: NDArray[np.void]) -> tuple[NDArray[np.void], NDArray[np.float64]]:
        """Returns hits and the corners of their triangles (..., 3, 3) in float64, or NaN for
        misses."""
        found = self._hits(hits)
        numbers = np.asarray(found["triangle"])
        is_hit = numbers >= 0
        corners = np.full((*found.shape, 3, 3), np.nan)
        corners[is_hit] = self._at.vertices[self._faces[numbers[is_hit]]]
        return found, corners


def _hit_dtype(dtype: np.dtype[np.void] | None, out: NDArray[np.void] | None) -> np.dtype[np.void]:
    """Returns the dtype of the hits that a query writes: `HIT` or `HIT32`."""
    given = out.dtype if isinstance(out, np.ndarray) else None
    if dtype is None:
        return HIT32 if given is not None and given == HIT32 else HIT
    if dtype not in (HIT, HIT32):
        raise TypeError(f"dtype is {dtype}; it must be intertri.HIT or intertri.HIT32")
    if given is not None and given != dtype:
        raise TypeError(f"out has dtype {given}, but dtype is {dtype}; pass only one of them, or the same dtype in both")
    return HIT32 if dtype == HIT32 else HIT


def _limit_of(limit: int | None) -> int | None:
    """Checks the limit of hits per ray."""
    if limit is None:
        return None
    if not isinstance(limit, (int, np.integer)) or isinstance(limit, bool):
        raise TypeError(f"limit must be an integer or None, not {type(limit).__name__}")
    if limit < 0:
        raise ValueError(f"limit is {limit}; it must not be negative")
    return min(int(limit), 2**32 - 1)
