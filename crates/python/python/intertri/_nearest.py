"""Nearest points of meshes in float64.

The triangle is found in float32, on a copy of the mesh about its middle; the point on it, its distance and its weights are
then computed in float64. So of triangles that are nearly as near it may be the second, farther by at most 2**-21 of the
distance or of the mesh's size, whichever is larger.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import _arrays
from ._arrays import F32
from ._dtypes import NEAREST
from ._intertri import Tree32, closest_point

Doubles: TypeAlias = NDArray[np.float64]


class Copy:
    """A copy of a mesh in float32 about its middle."""

    def __init__(self, vertices: Doubles, faces: NDArray[np.uint32], threads: int | None) -> None:
        self._vertices, self._faces = vertices, faces
        used = vertices[faces.ravel()] if len(faces) else np.zeros((1, 3))
        self._middle = (used.min(axis=0) / 2 + used.max(axis=0) / 2).astype(np.float64)
        self._tree = Tree32(self._about(vertices).reshape(-1), faces.reshape(-1), threads)

    def _about(self, points: Doubles) -> NDArray[np.float32]:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.ascontiguousarray(points - self._middle, F32)

    def find(self, points: Doubles, radius: float, threads: int | None, out: NDArray[np.void]) -> None:
        """Fills `out`, (n,) `NEAREST`, for points (n, 3)."""
        reach = math.inf if math.isinf(radius) else radius * (1 + 1e-6) + self._slack(points)
        closest_point(self._tree, self._about(points).reshape(-1), reach, threads, _arrays.as_bytes(out))
        found = np.flatnonzero(out["triangle"] >= 0)
        corners = self._vertices[self._faces[out["triangle"][found]]]
        nearest, out["u"][found], out["v"][found] = on_triangles(points[found], corners)
        out["point"][found] = nearest
        out["distance"][found] = np.linalg.norm(points[found] - nearest, axis=1)
        far = out["distance"] > radius
        if far.any():
            out[far] = np.array((math.inf, (math.nan,) * 3, math.nan, math.nan, -1, 0), NEAREST)

    def _slack(self, points: Doubles) -> float:
        """How far float32 may move a point or a vertex."""
        sizes = [np.abs(part - self._middle).max(initial=0.0) for part in (points, self._vertices)]
        return float(max(sizes)) * 2.0**-20


def _dot(a: Doubles, b: Doubles) -> Doubles:
    product: Doubles = np.einsum("ij,ij->i", a, b)
    return product


def on_triangles(points: Doubles, corners: NDArray[Any]) -> tuple[Doubles, Doubles, Doubles]:
    """The nearest points of triangles (n, 3, 3), one a point, and their weights u and v."""
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, ac, ap, bp, cp = b - a, c - a, points - a, points - b, points - c
    d1, d2, d3, d4, d5, d6 = _dot(ab, ap), _dot(ac, ap), _dot(ab, bp), _dot(ac, bp), _dot(ab, cp), _dot(ac, cp)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = 1 / (va + vb + vc)
        u, v = vb * inside, vc * inside
        # From the last to the first, so that the first that holds has the last word. The weights are those of b and c.
        s = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        edge = (va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0)
        u, v = np.where(edge, 1 - s, u), np.where(edge, s, v)
        edge = (vb <= 0) & (d2 >= 0) & (d6 <= 0)
        u, v = np.where(edge, 0.0, u), np.where(edge, d2 / (d2 - d6), v)
        corner = (d6 >= 0) & (d5 <= d6)
        u, v = np.where(corner, 0.0, u), np.where(corner, 1.0, v)
        edge = (vc <= 0) & (d1 >= 0) & (d3 <= 0)
        u, v = np.where(edge, d1 / (d1 - d3), u), np.where(edge, 0.0, v)
        corner = (d3 >= 0) & (d4 <= d3)
        u, v = np.where(corner, 1.0, u), np.where(corner, 0.0, v)
        corner = (d1 <= 0) & (d2 <= 0)
        u, v = np.where(corner, 0.0, u), np.where(corner, 0.0, v)
    return a + u[:, None] * ab + v[:, None] * ac, u, v
