"""A mesh, as users make, save and load it."""

from __future__ import annotations

import os
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from . import _arrays
from ._arrays import F32, F64
from ._points import PointQueries
from ._rays import RayQueries
from ._triangles import native


class Mesh(RayQueries, PointQueries):
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

    __slots__ = ()

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, self._saved()

    def __copy__(self) -> Mesh:
        return _restore(*self.__reduce__()[1])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes vertices, faces and hierarchy to a file, for `intertri.load`, the same on every machine.

        It is one of numpy's ``.npz`` files: ``vertices``, ``faces``, and ``tree``, the bytes of a saved hierarchy.

        >>> import intertri, tempfile, os
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     mesh.save(os.path.join(folder, "mesh.npz"))
        ...     intertri.load(os.path.join(folder, "mesh.npz"))
        Mesh(1 face, 3 vertices, float64)
        """
        vertices, faces, tree = self._saved()
        little = vertices.astype(vertices.dtype.newbyteorder("<"), copy=False)
        with open(path, "wb") as file:
            np.savez(file, vertices=little, faces=faces.astype("<u4", copy=False), tree=np.frombuffer(tree, np.uint8))


def _restore(vertices: NDArray[np.floating[Any]], faces: NDArray[np.uint32], tree: bytes) -> Mesh:
    """A mesh from its saved state."""
    mesh = Mesh.__new__(Mesh)
    corners, rows = _arrays.vertices_and_faces(vertices, faces)
    mesh._keep(corners.copy(), rows.copy())
    mesh._at.trees[corners.dtype] = native(corners.dtype).from_bytes(tree, len(rows))
    return mesh


def load(path: str | os.PathLike[str]) -> Mesh:
    """A mesh that `Mesh.save` wrote, with its hierarchy.

    Raises
    ------
    ValueError
        If the file is none of those, damaged, or of a later version. Whatever a file holds, nothing of it is run.
    OSError
        If it cannot be read.
    MemoryError
        If it needs more memory than there is.
    """
    with open(path, "rb") as file:
        try:
            return _read(file)
        except (OSError, MemoryError):
            raise
        except Exception as error:
            # Of a damaged file the readers of zip and of numpy raise whatever their code runs into.
            why = (str(error).splitlines() or [type(error).__name__])[0]
            raise ValueError(f"{os.fspath(path)} holds no mesh: {why}") from None


def _read(file: BinaryIO) -> Mesh:
    """A mesh from an open file."""
    saved = np.load(file, allow_pickle=False)
    if isinstance(saved, np.ndarray):
        raise ValueError("it is a single array")
    with saved:
        vertices, faces, tree = arrays = [saved[name] for name in ("vertices", "faces", "tree")]
    # What is no array in the file comes as bytes.
    types = [array.dtype.newbyteorder("=") for array in arrays if isinstance(array, np.ndarray)]
    if len(types) < 3 or types[0] not in (F32, F64) or types[1:] != [np.uint32, np.uint8]:
        raise ValueError("its arrays have other types")
    return _restore(vertices, faces, tree.tobytes())
