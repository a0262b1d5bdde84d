"""Exact ray traces and interior points for `pyvista.PolyData`.

The functions have the same parameters and results as pyvista's methods of the same names:

>>> import pyvista, intertri.pyvista
>>> sphere = pyvista.Sphere()
>>> points, cells = intertri.pyvista.ray_trace(sphere, [0, 0, 0], [1, 0, 0])
>>> points.round(3), len(cells)
(array([[0.499, 0.   , 0.   ]]), 1)
>>> selected = intertri.pyvista.select_interior_points(pyvista.Plane(), sphere)
>>> int(selected["selected_points"].sum())
69

A surface with polygons other than triangles is triangulated, but the results refer to the cells of
the original surface. The hierarchies of the last four surfaces are cached, keyed by a checksum of
points and faces. If you trace many rays one by one, create ``intertri.Mesh(surface)`` once and
query it.
"""

# pyvista's type annotations vary from version to version.
# pyright: reportAttributeAccessIssue=false, reportArgumentType=false, reportCallIssue=false

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import pyvista
from numpy.typing import ArrayLike, NDArray
from pyvista.core.errors import NotAllTrianglesError

from .._arrays import as_bytes, points
from .._intertri import checksum
from .._mesh import Mesh

Ints: TypeAlias = NDArray[np.int64]
Floats: TypeAlias = NDArray[np.float64]

__all__ = ["multi_ray_trace", "ray_trace", "select_interior_points"]


def ray_trace(
    mesh: Any,
    origin: ArrayLike,
    end_point: ArrayLike,
    first_point: bool = False,
    plot: bool = False,
    off_screen: bool | None = None,
) -> tuple[Floats, Ints]:
    """Finds where a segment, including its ends, meets a surface, like ``PolyData.ray_trace``.

    Returns
    -------
    (n, 3) float64, (n,) int64
        The points in order along the segment, and the cell of each point. If several cells share a
        point, the cell with the lowest number is returned. With ``first_point``, only the first
        point is returned, (3,), if there is one.
    """
    surface = _surface(mesh, "ray_trace")
    start, end = (points(value, name).astype(np.float64) for value, name in [(origin, "origin"), (end_point, "end_point")])
    if start.shape != (3,) or end.shape != (3,):
        raise ValueError(f"origin and end_point have shapes {start.shape} and {end.shape}; they must be (3,)")
    solid = surface.mesh
    hits = solid.all(start, end - start, t_max=1).hits
    starts, ends = solid.is_on_surface([start, end])
    if ends:
        # The end of the segment is added below, so drop the hits on triangles that contain it.
        hits = hits[[not _is_on(solid, hit, end) for hit in hits]]
    hits = hits[_is_next(hits["t"])]
    nearest = solid.closest_point([start, end])["triangle"]
    met, triangles = [solid.hit_points(hits)], [hits["triangle"]]
    if starts:
        met, triangles = [start[None], *met], [nearest[:1], *triangles]
    if ends and (start != end).any():
        met, triangles = [*met, end[None]], [*triangles, nearest[1:]]
    every, cells = np.concatenate(met), surface.cells[np.concatenate(triangles)]
    found = every[0] if first_point and len(every) else every
    if plot:
        _plot(mesh, np.array([start, end]), found, off_screen)
    return found, cells


def multi_ray_trace(
    mesh: Any, origins: ArrayLike, directions: ArrayLike, first_point: bool = False, retry: bool = False
) -> tuple[Floats, Ints, Ints]:
    """Finds where rays meet a surface of triangles in front of their origins, like
    ``PolyData.multi_ray_trace``, but without trimesh and Embree. ``retry`` has no effect, because
    no ray is lost.

    Returns
    -------
    (n, 3) float64, (n,) int64, (n,) int64
        The points in order along each ray, and the ray and the cell of each point. If several cells
        share a point, the cell with the lowest number is returned. With ``first_point``, only the
        first point of each ray is returned.
    """
    if not mesh.is_all_triangles:
        raise NotAllTrianglesError("multi_ray_trace takes a mesh of triangles; pass mesh.triangulate()")
    surface = _surface(mesh, "multi_ray_trace")
    start, way = points(origins, "origins"), points(directions, "directions")
    if first_point:
        hits = np.atleast_1d(surface.mesh.closest(start, way))
        rays = np.flatnonzero(hits["triangle"] >= 0)
        hits = hits[rays]
    else:
        lists = surface.mesh.all(start, way)
        once = _is_next(lists.rays) | _is_next(lists.hits["t"])
        rays, hits = lists.rays[once], lists.hits[once]
    return surface.mesh.hit_points(hits), rays, surface.cells[hits["triangle"]]


def select_interior_points(
    mesh: Any,
    surface: Any,
    *,
    method: str = "signed_distance",
    inside_out: bool = False,
    check_surface: bool = True,
    locator_tolerance: float | None = None,
) -> Any:
    """Returns a shallow copy of a data set with the array ``selected_points``, which is true for
    points inside a closed surface or on it, like ``DataSet.select_interior_points``.

    A point is inside if the surface winds around it. If ``check_surface`` is false and the surface is open or its faces
    are not consistently oriented, a point is inside if a ray from it crosses an odd number of faces.

    Parameters
    ----------
    mesh : pyvista.DataSet
    surface : pyvista.PolyData
    method, locator_tolerance
        Accepted for compatibility, but without effect: every answer is exact, so no tolerance is
        needed.
    inside_out : bool
        Whether to select the points outside the surface or on it instead.
    check_surface : bool
        Whether to reject an open surface, that is, one with an edge that is not used equally often
        in both directions. Points with the same coordinates count as the same point.

    Raises
    ------
    RuntimeError
        If the surface is open.
    """
    if method not in ("signed_distance", "cell_locator"):
        raise ValueError(f"method is {method!r}; it must be 'signed_distance' or 'cell_locator'")
    if locator_tolerance is not None and method == "signed_distance":
        raise ValueError("locator_tolerance cannot be used with the signed_distance method.")
    solid = _surface(surface, "select_interior_points").mesh
    if check_surface and not solid.is_closed:
        raise RuntimeError("Surface is not closed: repair it, or pass check_surface=False")
    at = np.asarray(mesh.points)
    selected = solid._inside_or_odd(at)
    if inside_out:
        selected = ~selected | solid.is_on_surface(at)
    out = mesh.copy(deep=False)
    out["selected_points"] = selected
    out.set_active_scalars("selected_points")
    return out


@dataclass(frozen=True, slots=True)
class _Key:
    """A cache key made of vertices and faces. Two keys are equal if their checksums match."""

    digest: tuple[Any, ...]
    vertices: NDArray[Any] = field(compare=False)
    faces: NDArray[Any] = field(compare=False)


@dataclass(frozen=True, slots=True)
class _Surface:
    """The hierarchy over a surface and the cell of each triangle."""

    mesh: Mesh
    cells: Ints


@functools.lru_cache(maxsize=4)
def _hierarchy(key: _Key) -> Mesh:
    return Mesh(key.vertices, key.faces)


def _surface(mesh: Any, name: str) -> _Surface:
    """Returns the triangles of a pyvista mesh, with a hierarchy that may come from the cache."""
    if not isinstance(mesh, pyvista.PolyData):
        hint = "; pass mesh.extract_surface()" if hasattr(mesh, "extract_surface") else ""
        raise TypeError(f"{name} takes a surface, pyvista.PolyData, not a {type(mesh).__name__}{hint}")
    # In cell order, points and lines come before faces.
    flat, cells = mesh, np.arange(mesh.n_verts + mesh.n_lines, mesh.n_cells)
    if not mesh.is_all_triangles:
        numbered = pyvista.PolyData()
        numbered.points, numbered.faces, numbered.strips = mesh.points, mesh.faces, mesh.strips
        numbered.cell_data["cell"] = cells
        flat = numbered.triangulate()
        cells = np.asarray(flat.cell_data["cell"], np.int64)
    vertices = np.ascontiguousarray(flat.points)
    faces = np.ascontiguousarray(np.asarray(flat.faces).reshape(-1, 4)[:, 1:])
    digest = (vertices.dtype, vertices.shape, faces.shape, checksum(as_bytes(vertices)), checksum(as_bytes(faces)))
    return _Surface(_hierarchy(_Key(digest, vertices.copy(), faces)), cells)


def _is_next(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Returns whether each value differs from the previous one."""
    differs = np.ones(len(values), bool)
    differs[1:] = values[1:] != values[:-1]
    return differs


def _is_on(mesh: Mesh, hit: NDArray[np.void], point: Floats) -> bool:
    """Returns whether a point lies exactly on the triangle of a hit."""
    return bool(Mesh(mesh.vertices[mesh.faces[hit["triangle"]]][None]).is_on_surface(point))


def _plot(mesh: Any, segment: Floats, met: Floats, off_screen: bool | None) -> None:
    """Shows a mesh, a segment, and where they meet."""
    plotter = pyvista.Plotter(off_screen=off_screen)
    plotter.add_mesh(mesh, label="Test Mesh")
    plotter.add_lines(segment, color="b", label="Ray Segment")
    if len(met):
        plotter.add_mesh(met, color="r", point_size=10, label="Intersection Points")
    plotter.add_legend()
    plotter.add_axes()
    plotter.show()
