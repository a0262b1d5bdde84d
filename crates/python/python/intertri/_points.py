"""Point queries of a mesh: inside tests, winding numbers, voxels, and distances."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _memory
from ._arrays import F32, F64
from ._dtypes import NEAREST
from ._intertri import SURFACE
from ._rays import RayQueries


class PointQueries(RayQueries):
    """The part of `Mesh` that answers point queries."""

    __slots__ = ()

    def _points(self, values: ArrayLike) -> NDArray[np.floating[Any]]:
        """Converts points to the mesh's scalar type, or to float64 if the mesh's type would round
        them."""
        points = _arrays.points(values)
        fits = self.dtype != F32 or _arrays.fits_f32(points)
        return points.astype(self.dtype if fits else F64, copy=False)

    def _inside_or_odd(self, points: ArrayLike, threads: int | None = None) -> NDArray[np.bool_]:
        """Returns whether points are inside the mesh or on it. If the mesh is open or not
        consistently oriented, returns whether a ray from each point crosses an odd number of
        faces."""
        return self.contains(points, parity=not self.is_closed, threads=threads)

    def _winding(self, points: ArrayLike, threads: int | None, assume_closed: bool = True) -> NDArray[np.int32]:
        """Returns integer winding numbers, or `SURFACE` for points on the mesh."""
        at = self._points(points)
        numbers = _memory.empty(at.shape[:-1], np.int32)
        tree, threads = self._tree(at.dtype, threads), _arrays.threads_of(threads)
        tree.winding(_arrays.flat(at, at.dtype), assume_closed, threads, _arrays.as_bytes(numbers))
        return numbers

    def contains(
        self, points: ArrayLike, *, assume_closed: bool = False, parity: bool = False, threads: int | None = None
    ) -> NDArray[np.bool_]:
        """Returns whether points (..., 3) are inside the mesh or on it: (...) bool.

        A point is inside if the mesh winds around it: parts may overlap, and an inside-out part
        within another part is a cavity. This is exact for a closed mesh. In a mesh with holes,
        flipped faces, or duplicate faces, a point is inside if its `winding_number` is nearer to 1
        than to 0 (or to -1, if the whole mesh is inside out).

        Parameters
        ----------
        points : (..., 3)
            A point that is not finite is outside.
        assume_closed : bool
            If true, the mesh is assumed to be closed without a check, and only the crossings of one
            ray from each point are counted.
        parity : bool
            If true, a point is inside if a ray from it crosses an odd number of faces, regardless
            of their orientation. This is correct for meshes without holes whose faces are oriented
            at random. If faces are missing or duplicated, the answer depends on the ray.

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> solid = intertri.Mesh(corners, faces)
        >>> solid.contains([[1, 1, 1], [3, 3, 3], [1, 1, 2], [1, 1, 2.0000000000000004]])
        array([ True, False,  True, False])
        >>> intertri.Mesh(corners, faces[:3]).contains([[0.5, 0.5, 0.5], [1.5, 1.5, 1.5]])
        array([ True, False])
        """
        if parity:
            numbers = self._winding(points, threads)
            odd: NDArray[np.bool_] = (numbers % 2 != 0) | (numbers == SURFACE)
            return odd
        at = self._points(points)
        inside = _memory.empty(at.shape[:-1], np.bool_)
        tree, threads = self._tree(at.dtype, threads), _arrays.threads_of(threads)
        is_closed = assume_closed or self.is_closed
        tree.contains(_arrays.flat(at, at.dtype), is_closed, threads, _arrays.as_bytes(inside))
        return inside[()]

    def winding_number(
        self, points: ArrayLike, *, assume_closed: bool = False, threads: int | None = None
    ) -> NDArray[np.int32] | NDArray[np.float64]:
        """Returns the winding number of the mesh around points: (...) for points of shape (..., 3).

        For a closed mesh, or if ``assume_closed`` is true, the numbers are int32, exact, and 0 on
        the mesh itself. For any other mesh, they are float64: the sum of the faces' solid angles
        divided by 4 pi, to about 14 digits, or NaN on the mesh.

        The parameters are the same as for `contains`.

        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> intertri.Mesh(corners, faces + faces).winding_number([[1, 1, 1], [3, 3, 3]])
        array([2, 0], dtype=int32)
        >>> intertri.Mesh(corners, faces[:3]).winding_number([[1e-9, 1e-9, 1e-9], [2, 2, 0]]).round(6)
        array([0.875,   nan])
        """
        if not assume_closed and not self.is_closed:
            at = self._points(points)
            fractions = _memory.empty(at.shape[:-1], np.float64)
            tree, threads = self._tree(at.dtype, threads), _arrays.threads_of(threads)
            tree.winding_number(_arrays.flat(at, at.dtype), threads, _arrays.as_bytes(fractions))
            return fractions[()]
        numbers = self._winding(points, threads)
        return np.where(numbers == SURFACE, np.int32(0), numbers)[()]

    def is_on_surface(self, points: ArrayLike, *, threads: int | None = None) -> NDArray[np.bool_]:
        """Returns whether points lie exactly on the mesh: (...) bool for points of shape (..., 3).

        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> mesh.is_on_surface([[0.5, 0.5, 5], [0.5, 0.5000000000000001, 5]])
        array([ True, False])
        """
        on: NDArray[np.bool_] = self._winding(points, threads) == SURFACE
        return on

    def voxels(
        self,
        origin: ArrayLike,
        spacing: ArrayLike,
        shape: tuple[int, int, int],
        *,
        assume_closed: bool = False,
        threads: int | None = None,
    ) -> NDArray[np.uint8]:
        """Determines which voxels of a regular grid are inside the mesh. Returns a uint8 array of
        the given shape, with 0 outside, 1 inside, and 2 if the centre is exactly on the mesh.

        Each voxel is classified by its centre: ``voxels(...) != 0`` is the same as `contains` for
        the centres. A voxel that the surface cuts without touching its centre is either inside or
        outside. In a closed mesh, one ray classifies a whole column of voxels along the last axis,
        which is many times faster; in any other mesh, each centre is classified on its own.

        Parameters
        ----------
        origin : (3,)
            The centre of the first voxel. Voxel (i, j, k) has its centre at
            ``origin + spacing * (i, j, k)`` in float64.
        spacing : float or (3,)
            The distance between centres, above 0.
        shape : (nx, ny, nz)
            The number of voxels along each axis.
        assume_closed, threads
            As for `contains`.

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> solid = intertri.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> solid.voxels([0.5, 0.5, 1], 1, (1, 3, 4))
        array([[[1, 1, 2, 0],
                [1, 2, 0, 0],
                [2, 0, 0, 0]]], dtype=uint8)
        """
        first, step, counts = _arrays.grid(origin, spacing, shape)
        axes = [first[k] + step[k] * np.arange(counts[k], dtype=np.float64) for k in range(3)]
        dtype = self.dtype if self.dtype != F32 or all(map(_arrays.fits_f32, axes)) else F64
        found = _memory.empty(counts, np.uint8)
        tree, threads = self._tree(dtype, threads), _arrays.threads_of(threads)
        flat = [_arrays.flat(axis, dtype) for axis in axes]
        tree.voxels(flat, assume_closed or self.is_closed, threads, found.reshape(-1))
        return found

    def closest_point(
        self,
        points: ArrayLike,
        *,
        radius: float = math.inf,
        nan_misses: bool = False,
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """Finds the closest point on the mesh to each point.

        Parameters
        ----------
        points : (..., 3)
        radius : float
            The search radius. A point farther from the mesh than this has no nearest point.
        nan_misses : bool
            Whether distance, u, and v are NaN, instead of infinity and 0, if there is no nearest
            point.
        threads, out
            As for `closest`; ``out`` is of dtype `NEAREST`.

        Returns
        -------
        (...) `NEAREST`
            The fields are distance, x, y, z, u, v, triangle (-1 if there is no nearest point), and
            geometry. The triangle is the nearest in exact arithmetic. If several are equally near,
            it is the one with the lowest number. A point that is not finite has no nearest point.
            `hit_points` returns the nearest points as rows, and `hit_normals` returns the normals
            of their triangles.

        Examples
        --------
        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> near = mesh.closest_point([[0.25, 0.25, 7], [3, 0, 5]])
        >>> near["distance"], mesh.hit_points(near)[1]
        (array([2., 2.]), array([1., 0., 5.]))
        """
        at = self._points(points)
        if np.ndim(radius) != 0:
            raise TypeError("radius must be one number for all points; for one per point, compare the distances")
        if not radius >= 0:
            raise ValueError(f"radius is {radius}; it must not be negative")
        nearest, threads = _arrays.answers(at.shape[:-1], NEAREST, out, at), _arrays.threads_of(threads)
        tree = self._tree(at.dtype, threads)
        tree.closest_point(_arrays.flat(at, at.dtype), float(radius), threads, _arrays.as_bytes(nearest))
        if nan_misses:
            _arrays.mark_misses(nearest, "distance")
        return nearest if at.ndim > 1 or out is not None else nearest[()]

    def signed_distance(
        self, points: ArrayLike, *, assume_closed: bool = False, threads: int | None = None
    ) -> NDArray[np.float64]:
        """Returns the distances of points to the mesh, **negative inside**: (...) float64 for
        points of shape (..., 3).

        `contains` determines the sign, and the distance is 0 on the mesh. Distances are the same as
        for `closest_point`, or NaN for a point that is not finite. The parameters are the same as
        for `contains`. ``intertri.trimesh.signed_distance`` uses trimesh's sign, which is positive
        inside.

        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> solid = intertri.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> solid.signed_distance([[0.5, 1, 1], [-2, 1, 1], [0, 1, 1]])
        array([-0.5,  2. ,  0. ])
        """
        assume_closed = assume_closed or self.is_closed
        at = self._points(points)
        signed = _memory.empty(at.shape[:-1], np.float64)
        tree, threads = self._tree(at.dtype, threads), _arrays.threads_of(threads)
        tree.signed_distance(_arrays.flat(at, at.dtype), assume_closed, threads, _arrays.as_bytes(signed))
        return signed[()]
