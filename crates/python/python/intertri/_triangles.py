"""The data of a mesh: its vertices, its faces, and the hierarchies over them."""

from __future__ import annotations

import hashlib
import threading
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _inputs
from ._arrays import F32
from ._intertri import Tree32, Tree64


# The number of bytes to hash between two checks for signals.
_PIECE = 1 << 24


@dataclass(slots=True)
class Position:
    """The positions of the vertices and everything derived from them. When vertices move, the mesh
    gets a new `Position`, so a thread that still uses the old `Position` cannot leave stale data in
    the new one."""

    vertices: NDArray[np.floating[Any]]
    trees: dict[np.dtype[Any], Tree32 | Tree64] = field(default_factory=dict)
    digest: str | None = None
    is_closed: bool | None = None


class Triangles:
    """Triangles and the hierarchy over them; see `Mesh`."""

    __slots__ = ("__weakref__", "_at", "_faces", "_moving")

    _at: Position
    _faces: NDArray[np.uint32]
    _moving: threading.Lock

    def __init__(
        self, vertices: Any = None, faces: ArrayLike | None = None, *, threads: int | None = None
    ) -> None:
        if vertices is None:
            raise TypeError("Mesh needs vertices and faces, or a mesh of another package")
        if faces is None:
            vertices, faces = _inputs.mesh_arrays(vertices) or (vertices, None)
        vertices = _inputs.array(vertices, "vertices")
        corners, rows = _arrays.vertices_and_faces(vertices, faces)
        if np.may_share_memory(corners, vertices):
            corners = corners.copy()
        corners = np.ascontiguousarray(corners)
        self._keep(corners, rows)
        self._tree(corners.dtype, threads)

    def _keep(self, corners: NDArray[np.floating[Any]], rows: NDArray[np.uint32]) -> None:
        """Takes ownership of vertices and faces."""
        corners.flags.writeable = rows.flags.writeable = False
        self._at, self._faces, self._moving = Position(corners), rows, threading.Lock()

    def _tree(self, dtype: np.dtype[Any], threads: int | None) -> Tree32 | Tree64:
        """Returns the hierarchy for a scalar type, building it on first use."""
        at = self._at
        tree = at.trees.get(dtype)
        if tree is None:
            corners = _arrays.flat(at.vertices, dtype)
            tree = native(dtype)(corners, self._faces.reshape(-1), _arrays.threads_of(threads))
            tree = at.trees.setdefault(dtype, tree)
        return tree

    def _saved(self) -> tuple[NDArray[np.floating[Any]], NDArray[np.uint32], bytes]:
        """Returns vertices, faces, and the hierarchy over them, all for the same position."""
        with self._moving:
            return self._at.vertices, self._faces, self._tree(self.dtype, None).to_bytes()

    @property
    def vertices(self) -> NDArray[np.floating[Any]]:
        """The vertices, (n, 3), read-only."""
        return self._at.vertices

    @property
    def faces(self) -> NDArray[np.uint32]:
        """Indices into `vertices`, (m, 3), read-only."""
        return self._faces

    @property
    def dtype(self) -> np.dtype[Any]:
        """``float32`` or ``float64``: the type of the coordinates."""
        return self._at.vertices.dtype

    @property
    def triangles(self) -> NDArray[np.floating[Any]]:
        """The corners of the faces, (m, 3, 3), as a new array."""
        return self._at.vertices[self._faces]

    @property
    def bounds(self) -> NDArray[np.floating[Any]] | None:
        """The lowest and highest corners of the faces' bounding box, (2, 3), or ``None`` if there
        are no faces."""
        if not len(self._faces):
            return None
        is_used = np.zeros(len(self._at.vertices), bool)
        is_used[self._faces] = True
        used = self._at.vertices[is_used]
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @property
    def digest(self) -> str:
        """A hash of dtype, vertices, and faces. Equal meshes have equal hashes on every machine.

        >>> import intertri
        >>> intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]]).digest[:8]
        '37cdf29a'
        """
        at = self._at
        if at.digest is None:
            little = at.vertices.dtype.newbyteorder("<")
            state = hashlib.sha256(f"{little.str} {at.vertices.shape} {self._faces.shape}".encode())
            for part in (np.ascontiguousarray(at.vertices, little), np.ascontiguousarray(self._faces, "<u4")):
                # Hash the data in pieces, so that signals are handled between them.
                content = _arrays.as_bytes(part)
                for start in range(0, len(content), _PIECE):
                    state.update(content[start : start + _PIECE].data)
            at.digest = state.hexdigest()
        return at.digest

    def __len__(self) -> int:
        return len(self._faces)

    def __repr__(self) -> str:
        faces, vertices = len(self._faces), len(self._at.vertices)
        count = f"{faces} face{'' if faces == 1 else 's'}, {vertices} vert{'ex' if vertices == 1 else 'ices'}"
        return f"{type(self).__name__}({count}, {self.dtype})"

    def refit(
        self, vertices: ArrayLike, *, indices: ArrayLike | None = None, threads: int | None = None
    ) -> float:
        """Moves the vertices to new positions.

        Positions are (n, 3) for the same faces, or (m, 3, 3) for a mesh made of triangles. With
        ``indices``, only the listed rows of `vertices` move.

        This is many times faster than building a new mesh. The answers are the same as those of a
        new mesh, but the more the faces move relative to each other, the longer queries take. A
        query that runs in another thread at the same time uses either all old positions or all new
        ones.

        Parameters
        ----------
        vertices : (n, 3)
            The new positions of all vertices, or of those in ``indices``.
        indices : (n,) integer, optional
            Rows of `vertices`. If a row occurs twice, its last position is used.
        threads : int, optional
            The number of threads that refit the hierarchy; all by default.

        Returns
        -------
        float
            The estimated slowdown of ray queries compared with a freshly built tree, as a factor.
            If it exceeds 1.5, build a new mesh.

        Raises
        ------
        ValueError
            If the number of vertices differs, or a vertex of a face is not finite. In that case,
            the mesh is unchanged.
        IndexError
            If ``indices`` contains a vertex that does not exist. In that case, the mesh is
            unchanged.
        MemoryError, KeyboardInterrupt
            If memory runs out or the call is interrupted. In that case, the vertices keep their old
            positions, and the next query rebuilds the hierarchy.

        Examples
        --------
        >>> import intertri
        >>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
        >>> ratio = mesh.refit([[0, 0, 7], [1, 0, 7], [0, 1, 7]])
        >>> mesh.closest([0.2, 0.2, 0], [0, 0, 1])["t"]
        np.float64(7.0)
        >>> ratio = mesh.refit([[0, 0, 3]], indices=[0])
        >>> mesh.vertices[:, 2]
        array([3., 7., 7.])
        """
        moved = _arrays.floats(vertices, "vertices")
        if self.dtype == F32 and not _arrays.fits_f32(moved):
            raise TypeError("vertices are float64 and the mesh is float32: pass vertices.astype(np.float32)")
        rows = None if indices is None else _arrays.vertex_rows(indices, moved, len(self.vertices))
        if rows is None and moved.ndim == 3 and moved.shape[1:] == (3, 3):
            moved = moved.reshape(-1, 3)
        if rows is None and moved.shape != self.vertices.shape:
            raise ValueError(f"vertices has shape {moved.shape}; it must be {self.vertices.shape}, as before")
        with self._moving:
            if rows is None:
                corners = np.array(moved, self.dtype, order="C")
            else:
                corners = self._at.vertices.copy()
                corners[rows] = moved
            _arrays.check_finite(corners, self._faces)
            corners.flags.writeable = False
            tree = self._tree(self.dtype, threads)
            try:
                ratio = tree.refit(corners.reshape(-1), self._faces.reshape(-1), _arrays.threads_of(threads))
            except BaseException:
                # The tree may be only partly refitted, so drop it.
                self._at = Position(self._at.vertices)
                raise
            self._at = Position(corners, {self.dtype: tree})
        return ratio

    @property
    def is_closed(self) -> bool:
        """Whether each edge is used equally often in both directions, so that the mesh has an inside."""
        at = self._at
        if at.is_closed is None:
            ask = native(at.vertices.dtype).is_closed
            at.is_closed = ask(at.vertices.reshape(-1), self._faces.reshape(-1))
        return at.is_closed

    def inspect(self) -> dict[str, int | str]:
        """Reports why the mesh is not closed and which faces occur more than once.

        Two edges or two faces are the same if their corners have the same coordinates.

        Returns
        -------
        dict
            ``open``: edges that belong to a single face. ``turned``: edges along which both faces
            run in the same direction, so that one of the faces is flipped. ``uneven``: edges of
            three or more faces that do not pair up. ``doubled``: faces that repeat another with the
            same orientation. ``opposed``: faces that repeat another with the opposite orientation,
            so that the two cancel. ``text``: a report in words, with the first edge or face of each
            kind.

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> print(intertri.Mesh(corners, [[1, 2, 0], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).inspect()["text"])
        3 edges lie between triangles with opposite orientations, the first at triangle 0 from [4.0, 0.0, 0.0] to [0.0, 4.0, 0.0]
        """  # noqa: E501
        text, rows = self._defects()
        report: dict[str, int | str] = {defect: len(rows[defect]) for defect in rows}
        return report | {"text": text}

    def defects(self) -> dict[str, NDArray[np.int64]]:
        """All edges and faces that `inspect` counts.

        Returns
        -------
        dict
            ``open``, ``turned``, and ``uneven``: edges as rows of two vertices, (n, 2), in the
            direction of the first face at the edge. ``doubled`` and ``opposed``: rows of a face and
            the earlier face that it repeats, (n, 2).

        Examples
        --------
        >>> import intertri
        >>> corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        >>> intertri.Mesh(corners, [[0, 1, 3], [0, 3, 2], [1, 2, 3]]).defects()["open"]
        array([[0, 1],
               [2, 0],
               [1, 2]])
        """
        faces, (_, defects) = self._faces, self._defects()
        for defect in ("open", "turned", "uneven"):
            face, corner = defects[defect].T
            ends = np.stack([faces[face, corner], faces[face, (corner + 1) % 3]], axis=1)
            defects[defect] = ends.astype(np.int64)
        return defects

    def _defects(self) -> tuple[str, dict[str, NDArray[np.int64]]]:
        """Returns the defects in words, and as rows of two numbers: a face and a corner for each
        edge, and a face and the earlier face for each repeated face."""
        at = self._at
        text, lists = native(at.vertices.dtype).inspect(at.vertices.reshape(-1), self._faces.reshape(-1))
        names = ("open", "turned", "uneven", "doubled", "opposed")
        return text, {name: rows.reshape(-1, 2) for name, rows in zip(names, lists)}


def native(dtype: np.dtype[Any]) -> type[Tree32] | type[Tree64]:
    """Returns the hierarchy class for a scalar type."""
    return Tree32 if dtype == F32 else Tree64
