"""The mesh that users create, save, and load."""

from __future__ import annotations

import os
import warnings
from typing import Any, TypeVar

from . import _archive
from ._intertri import read_model
from ._points import PointQueries
from ._triangles import native


AnyMesh = TypeVar("AnyMesh", bound="Mesh")


class Mesh(PointQueries):
    """Triangles and the hierarchy over them.

    Parameters
    ----------
    vertices : (n, 3) float32 or float64
        Corners: float32 stays float32, float64 stays float64, and integers become float64. To omit
        ``faces``, pass triangles of shape (m, 3, 3), or a mesh from trimesh, Open3D, pyvista, or
        meshio. Arrays and tensors of other packages work too, through DLPack if they support it.
    faces : (m, 3) integer, optional
        Rows of ``vertices``. Both sides of a face can be hit.
    threads : int, optional
        The number of threads for the build; all by default.

    Raises
    ------
    ValueError
        If a shape is wrong or a vertex is not finite.
    TypeError
        If converting a dtype could lose information: ``longdouble``, complex, or objects.
    IndexError
        If a face refers to a vertex that does not exist.
    MemoryError
        If there is not enough memory.

    Answers
    -------
    Answers do not depend on the order of rays, the number of threads, or the CPU. With
    ``mode="exact"``, the default, hits, misses, and triangles are exact for the coordinates as
    given, and t, u, and v are the true values, rounded once. An edge or corner belongs to every
    triangle that shares it, so no ray slips through. If several hits have the same t, the triangle
    with the lowest number wins. With ``mode="certified"``, answers match those of a plain loop in
    float64.

    Float64 rays are not rounded: if float32 cannot represent them, a float32 mesh builds and uses a
    second hierarchy, in float64. Pass ``rays.astype(np.float32)`` to avoid this.

    Ctrl-C ends a long call with ``KeyboardInterrupt``, and a call that runs out of memory raises
    ``MemoryError``. Other Python threads can run during a call.

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

    @classmethod
    def read(
        cls: type[AnyMesh], path: str | os.PathLike[str], *, strict: bool = False, threads: int | None = None
    ) -> AnyMesh:
        """Reads a model from an OBJ, PLY, STL, or glTF file, which may be compressed with gzip.

        Vertices keep their order and become float64. Decimal numbers are rounded to the nearest
        float64, and numbers stored as float32 or float64 keep their values. Polygons are split into
        triangles.

        Parameters
        ----------
        path
            The extension determines the format. If the extension is unknown, the first bytes of the
            file determine it.
        strict : bool
            By default, a ``UserWarning`` reports what was omitted, repaired, or guessed, such as
            faces with fewer than three corners. If true, such problems raise an error.
        threads : int, optional
            The number of threads for the build; all by default.

        Raises
        ------
        OSError
            If the file cannot be opened.
        ValueError
            If the file is damaged or is not in one of these formats; the message states the line.
        MemoryError
            If the model needs more memory than is available.

        Examples
        --------
        >>> import intertri, pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "one.obj")
        ...     _ = path.write_text("v 0 0 0.1\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n")
        ...     intertri.Mesh.read(path)
        Mesh(1 face, 3 vertices, float64)
        """
        # A file that cannot be opened raises Python's own error.
        open(path, "rb").close()
        vertices, faces, notes = read_model(path)
        if notes and strict:
            raise ValueError(f"{os.fspath(path)}: {'; '.join(notes)}; repair it, or leave out strict=True")
        for note in notes:
            warnings.warn(f"{os.fspath(path)}: {note}", stacklevel=2)
        mesh = cls.__new__(cls)
        mesh._keep(vertices.reshape(-1, 3), faces.reshape(-1, 3))
        mesh._tree(mesh.dtype, threads)
        return mesh

    def __reduce__(self) -> tuple[Any, ...]:
        return _revive, (type(self), *self._state()), getattr(self, "__dict__", None)

    def __copy__(self) -> Mesh:
        revive, parts, attributes = self.__reduce__()
        mesh: Mesh = revive(*parts)
        if attributes:
            mesh.__dict__.update(attributes)
        return mesh

    def _state(self) -> _archive.Saved:
        vertices, faces, tree = self._saved()
        return vertices, faces, tree, _archive.binding(vertices, faces, tree)

    def orient(self: AnyMesh, *, threads: int | None = None) -> AnyMesh:
        """Returns a copy of the mesh in which each connected piece is oriented consistently and
        outward.

        Two faces are connected if they share an edge that belongs to no other face. Each piece is
        turned outward separately, even the wall of a cavity. An open piece is turned outward as
        seen from the middle of its bounding box. A one-sided piece, such as a Möbius strip, stays
        as it is, and `inspect` still counts ``turned`` edges. A face is turned by swapping its last
        two corners.

        Parameters
        ----------
        threads : int, optional
            The number of threads for the build; all by default.

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> mesh = intertri.Mesh(corners, [[1, 2, 0], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).orient()
        >>> mesh.is_closed, mesh.faces[0].tolist()
        (True, [1, 0, 2])
        """
        vertices, faces = self._at.vertices, self._faces.copy()
        turned = native(vertices.dtype).orient(vertices.reshape(-1), faces.reshape(-1))
        faces[turned] = faces[turned][:, [0, 2, 1]]
        mesh = type(self).__new__(type(self))
        mesh._keep(vertices, faces)
        mesh._tree(mesh.dtype, threads)
        return mesh

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes vertices, faces, and hierarchy to a file for `intertri.load`.

        The file is the same on every machine. It is a numpy ``.npz`` file with ``vertices``,
        ``faces``, ``tree`` (the bytes of the saved hierarchy), and ``binding`` (a checksum of the
        three).

        >>> import intertri, tempfile, os
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     mesh.save(os.path.join(folder, "mesh.npz"))
        ...     intertri.load(os.path.join(folder, "mesh.npz"))
        Mesh(1 face, 3 vertices, float64)
        """
        _archive.write(path, self._state())


def _revive(cls: type[Mesh], *parts: Any) -> Mesh:
    """Restores a mesh from its saved state."""
    vertices, faces, tree = _archive.revive(*parts)
    mesh = cls.__new__(cls)
    mesh._keep(vertices, faces)
    mesh._at.trees[vertices.dtype] = tree
    return mesh


def _restore(*_: Any) -> Mesh:
    """Replaces a function to which pickles from older versions refer. Raises an error that explains
    what to do."""
    raise ValueError(
        "this mesh was pickled by an older version, which did not bind its tree to its vertices: "
        "build it again with Mesh(vertices, faces)"
    )


def load(path: str | os.PathLike[str]) -> Mesh:
    """Loads a mesh and its hierarchy from a file that `Mesh.save` wrote.

    Raises
    ------
    ValueError
        If the file was not written by `Mesh.save`, is damaged, has another version, or has members
        that do not belong together. Nothing in the file is run as code. A checksum is not a
        signature: sign the file if you need authenticity.
    OSError
        If the file cannot be read.
    MemoryError
        If the mesh needs more memory than is available.
    """
    try:
        return _revive(Mesh, *_archive.read(path))
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)} contains no mesh: {error}") from None
