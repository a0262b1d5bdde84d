"""What rays ask of a mesh."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays
from ._arrays import Rays
from ._dtypes import CROSSING, CROSSINGS, HIT, HitLists
from ._triangles import Triangles

Mode: TypeAlias = Literal["exact", "certified"]


class RayQueries(Triangles):
    """Queries by rays."""

    __slots__ = ()

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
            A hit counts where t > 0 and t_min <= t < t_max, in multiples of the direction's length. A plain number
            of Python takes the rays' dtype; numpy's scalars and arrays keep theirs.
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
        offsets, hits = tree.all(rays, mode, threads, rays.width, most)
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
        offsets, hits = tree.crossings(rays, threads, rays.width)
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


def _limit_of(limit: int | None) -> int | None:
    """At most so many hits a ray."""
    if limit is None:
        return None
    if not isinstance(limit, (int, np.integer)) or isinstance(limit, bool):
        raise TypeError(f"limit must be an integer or None, not {type(limit).__name__}")
    if limit < 0:
        raise ValueError(f"limit is {limit}; it must not be negative")
    return min(int(limit), 2**32 - 1)
