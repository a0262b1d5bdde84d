"""Saves a mesh to a file or a pickle, as arrays with a checksum that ties them together.

``binding`` is an XXH64 checksum of the other members. It detects damage as well as a tree that was
built for other vertices or faces. It does not show who wrote the file: sign it if you need
authenticity.
"""

from __future__ import annotations

import errno
import io
import os
import zipfile
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _inputs
from ._arrays import F32, F64
from ._intertri import Tree32, Tree64, checksum
from ._triangles import native

NOT_OURS = "it is damaged, or not a file that Mesh.save wrote"
MEMBERS = ("vertices", "faces", "tree", "binding")

Saved = tuple[NDArray[np.floating[Any]], NDArray[np.uint32], bytes, int]
"""The vertices, the faces, the bytes of the hierarchy, and their checksum."""


def binding(vertices: NDArray[np.floating[Any]], faces: NDArray[np.uint32], tree: bytes) -> int:
    """Returns a checksum of vertices, faces, and hierarchy, including types and shapes. It is the
    same on every machine."""
    little = vertices.dtype.newbyteorder("<")
    parts = [
        np.frombuffer(f"{little.str} {vertices.shape} {faces.shape}".encode(), np.uint8),
        _arrays.as_bytes(np.ascontiguousarray(vertices, little)),
        _arrays.as_bytes(np.ascontiguousarray(faces, "<u4")),
        np.frombuffer(tree, np.uint8),
    ]
    return checksum(_arrays.as_bytes(np.array([checksum(part) for part in parts], "<u8")))


def revive(
    vertices: Any, faces: Any, tree: Any, bound: Any
) -> tuple[NDArray[np.floating[Any]], NDArray[np.uint32], Tree32 | Tree64]:
    """Restores vertices, faces, and hierarchy from their saved state.

    Raises
    ------
    ValueError
        If the three do not belong together.
    """
    arrays = isinstance(vertices, np.ndarray) and isinstance(faces, np.ndarray) and isinstance(tree, bytes)
    if not arrays or vertices.dtype.newbyteorder("=") not in (F32, F64) or faces.dtype.newbyteorder("=") != np.uint32:
        raise ValueError("its members do not have the types of a mesh's vertices, faces, and tree")
    if binding(vertices, faces, tree) != bound:
        raise ValueError("its vertices, faces and tree do not belong together, or are damaged; save the mesh again")
    try:
        corners, rows = _arrays.vertices_and_faces(vertices, faces)
    except IndexError as error:
        raise ValueError(str(error)) from None
    return corners.copy(), rows.copy(), native(corners.dtype).from_bytes(tree, len(rows))


def write(path: str | os.PathLike[str], saved: Saved) -> None:
    """Writes the state of a mesh to a file."""
    vertices, faces, tree, bound = saved
    arrays: dict[str, NDArray[Any]] = {
        "vertices": vertices.astype(vertices.dtype.newbyteorder("<"), copy=False),
        "faces": faces.astype("<u4", copy=False),
        "tree": np.frombuffer(tree, np.uint8),
        "binding": np.array(bound, "<u8"),
    }
    with open(path, "wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type, unused-ignore]


def read(path: str | os.PathLike[str]) -> tuple[Any, ...]:
    """Reads the state of a mesh from a file, for `revive`."""
    with open(path, "rb") as file:
        try:
            return _members(file)
        except OSError as error:
            # A damaged file may contain invalid offsets, which raise an `OSError` with `EINVAL` or
            # without an errno. Any other errno comes from the system.
            if error.errno not in (None, errno.EINVAL):
                raise
            raise ValueError(f"{NOT_OURS}; {_inputs.READ_IT}") from None
        except (ValueError, MemoryError):
            raise
        except Exception as error:
            # On damaged input, zipfile and numpy's header reader raise many kinds of exceptions.
            why = (str(error).splitlines() or [type(error).__name__])[0]
            raise ValueError(f"{NOT_OURS} ({why}); {_inputs.READ_IT}") from None


def _members(file: BinaryIO) -> tuple[Any, ...]:
    """Reads the members of an archive."""
    with zipfile.ZipFile(file) as archive:
        there = set(archive.namelist())
        missing = [name for name in MEMBERS if f"{name}.npy" not in there]
        if missing == ["binding"]:
            raise ValueError(
                "it was written by an older version, which did not bind its tree to its vertices: "
                "load both with numpy and call Mesh(vertices, faces).save(path)"
            )
        if missing:
            raise ValueError(f"it has no member {' and '.join(missing)}")
        vertices, faces, tree, bound = (_array(archive.read(f"{name}.npy"), name) for name in MEMBERS)
    return vertices, faces, tree.tobytes(), int(bound) if bound.shape == () else None


def _array(content: bytes, name: str) -> NDArray[Any]:
    """Parses the array of a member. numpy's own reader would allocate as much memory as the header
    claims."""
    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    if version != (1, 0):
        raise ValueError(f"{name} has an unknown header")
    shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(file)
    numbers = np.frombuffer(content, np.uint8, offset=file.tell())
    array = numbers.view(dtype)
    return array.reshape(shape, order="F" if is_fortran else "C")
