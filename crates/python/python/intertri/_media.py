"""Media: closed meshes, each filled with a medium."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _memory
from ._arrays import F32, F64, Rays
from ._dtypes import MEDIUM_CROSSING, SEGMENT, SegmentLists
from ._intertri import Media32, Media64
from ._mesh import Mesh


class Media:
    """Closed meshes, each filled with a medium that rays pass through.

    Meshes may be nested, touch, or overlap. If a point is inside several of them, the last one in
    the list determines its medium, so list them from the outside in. A point outside all of them
    has the medium -1. Crossings at the same t are processed together, so there is no gap between
    solids that touch. Answers are always exact.

    Parameters
    ----------
    meshes : sequence
        Each is a `Mesh`, or anything that `Mesh` accepts. The media are float32 if all meshes are
        float32, and float64 otherwise.
    media : (n,) integer, optional
        The number of the medium that fills each mesh, 0 or above. Meshes with the same number form
        one medium. By default, each mesh is filled with a medium of its own, numbered by the mesh's
        position in ``meshes``.
    threads : int, optional
        The number of threads for the build; all by default.

    Raises
    ------
    ValueError
        If a mesh is not closed; the message states which mesh it is and where it is open.

    Examples
    --------
    >>> import numpy as np, intertri
    >>> corners = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]])
    >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> rock, ore = intertri.Mesh(2 * corners, faces), intertri.Mesh(corners, faces)
    >>> media = intertri.Media([rock, ore], [7, 3])
    >>> media.medium_at([[1, 1, 1], [2, 2, 2], [9, 9, 9]])
    array([ 3,  7, -1], dtype=int32)
    >>> crossing = media.next_crossing([0.5, 0.5, 1], [1, 0, 0])
    >>> float(crossing["t"]), int(crossing["left"]), int(crossing["entered"])
    (2.0, 3, 7)
    """

    __slots__ = ("_made", "_meshes", "_numbers", "dtype")

    dtype: np.dtype[Any]
    """``float32`` or ``float64``: the type of the coordinates."""

    def __init__(
        self, meshes: Sequence[Any], media: ArrayLike | None = None, *, threads: int | None = None
    ) -> None:
        if isinstance(meshes, Mesh):
            raise TypeError("meshes must be a sequence of meshes; for a single mesh, pass [mesh]")
        self._meshes = tuple(mesh if isinstance(mesh, Mesh) else Mesh(mesh) for mesh in meshes)
        count = len(self._meshes)
        numbers = np.arange(count) if media is None else np.asarray(media)
        if numbers.shape != (count,) or (numbers.dtype.kind not in "iu" and count):
            raise ValueError(f"media has shape {numbers.shape} and dtype {numbers.dtype}; it must be an integer for each of {count} meshes")
        if ((numbers < 0) | (numbers >= 2**31)).any():
            raise ValueError("media must be from 0 to 2**31 - 1; -1 means outside")
        self._numbers = numbers.astype(np.int32)
        self._numbers.flags.writeable = False
        self.dtype = F32 if count and all(mesh.dtype == F32 for mesh in self._meshes) else F64
        self._made: dict[np.dtype[Any], Media32 | Media64] = {}
        self._native(self.dtype, threads)

    def _native(self, dtype: np.dtype[Any], threads: int | None) -> Media32 | Media64:
        """Returns the hierarchy for a scalar type, building it on first use."""
        made = self._made.get(dtype)
        if made is None:
            arrays = [(_arrays.flat(mesh.vertices, dtype), mesh.faces.reshape(-1)) for mesh in self._meshes]
            kind = Media32 if dtype == F32 else Media64
            made = kind(arrays, self._numbers.tolist(), _arrays.threads_of(threads))
            made = self._made.setdefault(dtype, made)
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._meshes, self._numbers)

    def __len__(self) -> int:
        return len(self._meshes)

    def __repr__(self) -> str:
        count = len(self._meshes)
        return f"{type(self).__name__}({count} mesh{'' if count == 1 else 'es'}, {self.dtype})"

    @property
    def media(self) -> NDArray[np.int32]:
        """The medium that fills each mesh, (n,), read-only."""
        return self._numbers

    def _rays(self, origins: ArrayLike, directions: ArrayLike | None, t_min: ArrayLike, t_max: ArrayLike) -> Rays:
        return _arrays.rays(origins, directions, t_min, t_max, self.dtype)

    def medium_at(self, points: ArrayLike, *, threads: int | None = None) -> NDArray[np.int32]:
        """Returns the medium at each point: (...) int32 for points of shape (..., 3), or -1
        outside.

        A point on a wall belongs to the side that lies in the direction (0.53721, 0.35137,
        0.76691).
        """
        at = _arrays.points(points)
        at = at.astype(self.dtype if self.dtype != F32 or _arrays.fits_f32(at) else F64, copy=False)
        found = _memory.empty(at.shape[:-1], np.int32)
        native, threads = self._native(at.dtype, threads), _arrays.threads_of(threads)
        native.medium_at(_arrays.flat(at, at.dtype), threads, _arrays.as_bytes(found))
        return found[()]

    def next_crossing(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        threads: int | None = None,
    ) -> NDArray[np.void]:
        """Finds where each ray first enters another medium: (...) `MEDIUM_CROSSING`.

        Pass rays as for ``Mesh.closest``. A ray that starts on a wall is initially in the medium
        that it goes into.
        """
        rays = self._rays(origins, directions, t_min, t_max)
        found = _memory.empty(rays.shape, MEDIUM_CROSSING)
        native, threads = self._native(rays.dtype, threads), _arrays.threads_of(threads)
        native.next_crossing(rays, threads, rays.width, _arrays.as_bytes(found))
        return found if rays.shape else found[()]

    def segments(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        threads: int | None = None,
    ) -> SegmentLists:
        """Cuts rays into segments where the medium changes.

        The segments of a ray cover it from ``t_min`` to ``t_max``: each starts where the previous
        one ends. A segment whose ends round to the same t is omitted. If the rays have more than
        one dimension, they are numbered in C order.

        >>> import numpy as np, intertri
        >>> corners = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]])
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> media = intertri.Media([intertri.Mesh(2 * corners, faces), intertri.Mesh(corners, faces)])
        >>> lists = media.segments([[-1, 0.5, 0.5]], [1, 0, 0])
        >>> lists.segments["end"], lists.segments["medium"]
        (array([ 1.,  4.,  8., inf]), array([-1,  1,  0, -1], dtype=int32))
        """
        rays = self._rays(origins, directions, t_min, t_max)
        native, threads = self._native(rays.dtype, threads), _arrays.threads_of(threads)
        offsets, segments = native.segments(rays, threads, rays.width)
        return SegmentLists(offsets, segments.view(SEGMENT))

    def lengths(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        threads: int | None = None,
    ) -> NDArray[np.float64]:
        """Returns the length of each ray within each medium: (..., m) float64.

        The columns are in the order of ``np.unique(media.media)``.

        Lengths are in coordinate units, regardless of the length of the direction. For a segment
        from a to b, pass ``origins=a, directions=b - a, t_max=1``.

        >>> import numpy as np, intertri
        >>> corners = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]])
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> media = intertri.Media([intertri.Mesh(2 * corners, faces), intertri.Mesh(corners, faces)])
        >>> media.lengths([[-1, 0.5, 0.5], [9, 9, 9]], [3, 0, 0])
        array([[4., 3.],
               [0., 0.]])
        """
        rays = self._rays(origins, directions, t_min, t_max)
        kinds = np.unique(self._numbers)
        lists = self.segments(origins, directions, t_min=t_min, t_max=t_max, threads=threads)
        inside = lists.segments["medium"] >= 0
        segments, ray = lists.segments[inside], lists.rays[inside]
        directions = rays.directions
        if directions is None:
            directions = rays.origins.reshape(-1, rays.columns)[:, 3 + (rays.columns == 8) :][:, :3]
        sizes = np.linalg.norm(directions.reshape(-1, 3).astype(np.float64), axis=-1)
        lengths = (segments["end"] - segments["start"]) * np.broadcast_to(sizes, (rays.count,))[ray]
        column = np.searchsorted(kinds, segments["medium"])
        sums = np.bincount(ray * len(kinds) + column, lengths, rays.count * len(kinds))
        return sums.astype(np.float64, copy=False).reshape(*rays.shape, len(kinds))
