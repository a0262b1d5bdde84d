"""Converts arrays and meshes from other packages to numpy arrays."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

READ_IT = "to read a model, call Mesh.read(path)"


def array(values: Any, name: str) -> NDArray[Any]:
    """Converts anything that contains numbers, including tensors from other packages, to a numpy
    array."""
    if type(values) is np.ndarray:
        return values
    if isinstance(values, (str, bytes, os.PathLike)):
        raise TypeError(f"{name} is {values!r:.60}; it must be an array of numbers")
    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked entries; fill them, or remove their rows")
    if not isinstance(values, (np.ndarray, np.generic)):
        # Try the object's own conversion to numpy first. Reading Open3D's tensors through DLPack
        # takes seconds.
        why = None
        if callable(getattr(values, "numpy", None)):
            try:
                return np.asarray(values.numpy())
            except Exception as error:
                why = (str(error).splitlines() or [""])[0]
        if hasattr(values, "__dlpack__"):
            try:
                return np.from_dlpack(values)
            except Exception as error:
                why = why or (str(error).splitlines() or [""])[0]
        if why is not None:
            raise TypeError(f"{name} is a {type(values).__name__} that numpy cannot read: {why}")
    try:
        return np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} has rows of different lengths") from None


def mesh_arrays(mesh: Any) -> tuple[Any, Any] | None:
    """Returns the vertices and faces of a mesh from intertri, trimesh, Open3D, pyvista, or meshio,
    or `None` for anything else."""
    if isinstance(mesh, (np.ndarray, list, tuple)):
        return None
    if isinstance(mesh, (str, bytes, os.PathLike)):
        raise TypeError(f"Mesh takes arrays or a mesh, not the path {mesh!r:.60}; {READ_IT}")
    if hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):
        return array(mesh.vertex.positions, "vertices"), array(mesh.triangle.indices, "faces")
    for faces in ("faces", "triangles"):
        if hasattr(mesh, "vertices") and hasattr(mesh, faces):
            return array(mesh.vertices, "vertices"), array(getattr(mesh, faces), "faces")
    if hasattr(mesh, "points") and hasattr(mesh, "cells_dict"):
        return array(mesh.points, "vertices"), _meshio_faces(mesh.cells_dict)
    if hasattr(mesh, "points") and hasattr(mesh, "is_all_triangles"):
        if not mesh.is_all_triangles:
            raise ValueError("the mesh has faces that are not triangles; pass mesh.triangulate()")
        return array(mesh.points, "vertices"), array(mesh.faces, "faces").reshape(-1, 4)[:, 1:]
    if hasattr(mesh, "geometry") and hasattr(mesh, "to_mesh"):
        raise TypeError("Mesh takes one mesh, not a scene; pass scene.to_mesh()")
    if hasattr(mesh, "extract_surface"):
        raise TypeError(f"Mesh takes a surface, not a {type(mesh).__name__}; pass mesh.extract_surface().triangulate()")
    return None


def _meshio_faces(cells: dict[str, Any]) -> Any:
    """Returns the triangles among meshio's cells."""
    flat = {"vertex", "line", "triangle"}
    others = sorted(set(cells) - flat)
    if others:
        raise ValueError(f"the mesh has cells that are not triangles ({', '.join(others)}); pass only its triangles")
    return cells.get("triangle", np.zeros((0, 3), np.int64))
