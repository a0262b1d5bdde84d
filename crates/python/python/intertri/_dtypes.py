"""The numpy dtypes of the answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

HIT = np.dtype([("t", "<f8"), ("u", "<f8"), ("v", "<f8"), ("triangle", "<i4"), ("geometry", "<u4")])
"""A hit, 32 bytes in size.

``t``: the distance along the ray in multiples of the length of its direction, or infinity for a
miss. ``u``, ``v``: the weights of the second and third corner. The point is
``(1 - u - v) a + u b + v c``. ``triangle``: the row of ``Mesh.faces``, or -1 for a miss.
``geometry``: the number of the mesh, which is 0.
"""

HIT32 = np.dtype([("t", "<f4"), ("u", "<f4"), ("v", "<f4"), ("triangle", "<i4"), ("geometry", "<u4")])
"""A hit with t, u, and v in float32, 20 bytes in size. The fields mean the same as in `HIT`.

With ``mode="exact"``, t, u, and v are the true values, rounded once; with ``mode="certified"``,
they are the values in `HIT`, rounded. A t beyond the largest float32 becomes infinity, so use
``triangle`` to tell hits from misses.
"""

CROSSING = np.dtype(
    {
        "names": ["t", "u", "v", "triangle", "geometry", "leaves"],
        "formats": ["<f8", "<f8", "<f8", "<i4", "<u4", "?"],
        "offsets": [0, 8, 16, 24, 28, 32],
        "itemsize": 40,
    }
)
"""A crossing, 40 bytes in size: a hit, and whether the ray crosses in the direction of the normal
(``leaves``)."""

SCENE_HIT = np.dtype(
    {
        "names": ["t", "u", "v", "triangle", "geometry", "instance", "leaves"],
        "formats": ["<f8", "<f8", "<f8", "<i4", "<u4", "<i4", "?"],
        "offsets": [0, 8, 16, 24, 28, 32, 36],
        "itemsize": 40,
    }
)
"""A hit in a scene, 40 bytes in size: a hit, the instance (-1 for a miss), and whether the ray
crosses in the direction of the normal (``leaves``)."""

CROSSINGS = np.dtype([("signed", "<i8"), ("unsigned", "<i8")])
"""A ray's numbers of crossings: the crossings at which it leaves minus those at which it enters
(``signed``), and the total (``unsigned``)."""


NEAREST = np.dtype(
    [(name, "<f8") for name in ("distance", "x", "y", "z", "u", "v")] + [("triangle", "<i4"), ("geometry", "<u4")]
)
"""The closest point on a mesh to a given point, 56 bytes in size: its distance, its position, its
weights as in `HIT`, and its triangle. If there is no such point, the triangle is -1, the distance
is infinite, and x, y, and z are NaN. ``mesh.hit_points`` returns the points as rows (..., 3)."""

SCENE_NEAREST = np.dtype(
    {
        "names": [*(NEAREST.names or ()), "instance"],
        "formats": [*(NEAREST[name] for name in NEAREST.names or ()), "<i4"],
        "offsets": [*range(0, 48, 8), 48, 52, 56],
        "itemsize": 64,
    }
)
"""The closest point on a scene's instances, 64 bytes in size: the fields of `NEAREST`, and the
instance, or -1 if there is no such point."""

SEGMENT = np.dtype(
    {
        "names": ["start", "end", "u", "v", "triangle", "geometry", "medium"],
        "formats": ["<f8", "<f8", "<f8", "<f8", "<i4", "<u4", "<i4"],
        "itemsize": 48,
    }
)
"""A part of a ray in one medium, 48 bytes in size.

``start``, ``end``: the values of t where the segment starts and ends, in multiples of the length of
the direction. ``medium``: the number of the medium, or -1 outside. ``triangle``, ``geometry``,
``u``, ``v``: the wall at the end of the segment, a face of the mesh with the number ``geometry``,
as in `HIT`. The triangle is -1 if the ray ends there.
"""

MEDIUM_CROSSING = np.dtype([*((name, HIT[name]) for name in HIT.names or ()), ("left", "<i4"), ("entered", "<i4")])
"""The place where a ray passes from one medium into another, 40 bytes in size: a hit, whose
``geometry`` is the number of the mesh, the medium that the ray leaves, and the medium that it
enters, with -1 for outside. If a ray does not change its medium, the triangle is -1."""


class HitLists(NamedTuple):
    """Lists of hits, one list per ray. Ray ``i`` has ``hits[offsets[i]:offsets[i + 1]]``, in order
    of t."""

    offsets: NDArray[np.int64]
    """The bounds of the lists: shape (n + 1,), starting at 0."""
    hits: NDArray[np.void]
    """Rows of `HIT`, or of `CROSSING`."""

    @property
    def rays(self) -> NDArray[np.int64]:
        """For each hit, the index of its ray. ``pandas.DataFrame(lists.hits, index=lists.rays)``
        combines all lists in one table."""
        return _rays_of(self.offsets)


class SegmentLists(NamedTuple):
    """Lists of segments, one list per ray. Ray ``i`` has ``segments[offsets[i]:offsets[i + 1]]``,
    in order of t."""

    offsets: NDArray[np.int64]
    """The bounds of the lists: shape (n + 1,), starting at 0."""
    segments: NDArray[np.void]
    """Rows of `SEGMENT`."""

    @property
    def rays(self) -> NDArray[np.int64]:
        """For each segment, the index of its ray."""
        return _rays_of(self.offsets)


def _rays_of(offsets: NDArray[np.int64]) -> NDArray[np.int64]:
    """Returns, for each item in the lists, the index of its ray."""
    return np.repeat(np.arange(len(offsets) - 1, dtype=np.int64), np.diff(offsets))
