"""Scenes of movable mesh instances."""

from __future__ import annotations

import math
import os
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _inputs, _memory
from ._arrays import F64
from ._dtypes import SCENE_HIT, SCENE_NEAREST, HitLists
from ._intertri import SURFACE, NativeScene
from ._mesh import Mesh

ALL = 0xFFFFFFFF
"""The mask with all bits set."""


class Scene:
    """Instances of meshes. Each instance is placed by a matrix and can move between queries.

    A vertex (x, y, z) is at ``((m[0, 0] * x + m[0, 1] * y) + m[0, 2] * z) + m[0, 3]`` along the
    first axis, and so on, in float64. Results are the same, bit for bit, as for a single mesh of
    all placed triangles. Instances share the hierarchy of their mesh, so a thousand placements take
    little more memory than one. A scene keeps each mesh as it was when it was added: a later
    ``refit`` of the mesh does not move its instances.

    Changes take effect when you commit them. A query uses the last commit made before the query
    started.

    Parameters
    ----------
    scene : trimesh.Scene or sequence of meshes, optional
        The instances to add and commit. For a trimesh scene, each node with faces becomes an
        instance, and nodes with the same geometry share its hierarchy. In a list or tuple, each
        item is a `Mesh`, or anything that `Mesh` accepts as a mesh, such as an Open3D geometry. It
        becomes an instance in its own coordinates, numbered by its position in the list. If the
        same object occurs several times, its instances share one mesh.

    Examples
    --------
    >>> import numpy as np, intertri
    >>> mesh = intertri.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> scene, moved = intertri.Scene(), np.eye(4)
    >>> moved[:3, 3] = [0, 0, 5]
    >>> near, far = scene.add(mesh, moved), scene.add(mesh, moved @ moved)
    >>> scene.commit()
    >>> hit = scene.closest([0.2, 0.2, 0], [0, 0, 1])
    >>> int(hit["instance"]) == near, float(hit["t"])
    (True, 5.0)
    """

    __slots__ = ("__weakref__", "_native")

    def __init__(self, scene: Any = None) -> None:
        self._native = NativeScene()
        if scene is None:
            return
        if hasattr(scene, "graph"):
            meshes: dict[str, Mesh] = {}
            for node in scene.graph.nodes_geometry:
                matrix, name = scene.graph[node]
                if hasattr(scene.geometry[name], "faces"):
                    mesh = meshes.get(name) or meshes.setdefault(name, Mesh(scene.geometry[name]))
                    self.add(mesh, matrix)
        elif isinstance(scene, (list, tuple)):
            made: dict[int, Mesh] = {}
            for mesh in scene:
                self.add(made.get(id(mesh)) or made.setdefault(id(mesh), _mesh(mesh)))
        else:
            raise TypeError(f"scene must be a trimesh.Scene or a list of meshes, not {type(scene).__name__}")
        self.commit()

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        count = len(self)
        return f"{type(self).__name__}({count} instance{'' if count == 1 else 's'})"

    def add(self, mesh: Mesh, matrix: ArrayLike | None = None) -> int:
        """Adds an instance of a mesh and returns its number.

        Parameters
        ----------
        mesh : Mesh
        matrix : (4, 4) or (3, 4), optional
            The placement. All entries must be finite, and the fourth row, if there is one, must be
            0, 0, 0, 1. By default, the mesh keeps its own coordinates.
        """
        if not isinstance(mesh, Mesh):
            raise TypeError(f"mesh must be an intertri.Mesh, not {type(mesh).__name__}")
        rows = _matrices(np.eye(4) if matrix is None else matrix, 1)
        return self._native.add(mesh._tree(mesh.dtype, None), rows[0].tolist())

    def place(self, instance: ArrayLike, matrix: ArrayLike) -> None:
        """Moves an instance, or many at once: ``instance`` (n,) and ``matrix`` (n, 4, 4) or (n, 3, 4).

        Raises
        ------
        IndexError, ValueError
            If an instance does not exist, or an entry is not finite. In that case, nothing changes.
        """
        numbers = _inputs.array(instance, "instance")
        if numbers.dtype.kind not in "iu" and numbers.size:
            raise TypeError(f"instance has dtype {numbers.dtype}; it must be integer")
        if numbers.ndim > 1:
            raise ValueError(f"instance has shape {numbers.shape}; it must be (n,)")
        numbers = numbers.reshape(-1)
        for number in numbers[(numbers < 0) | (numbers >= 1 << 31)][:1].tolist():
            raise IndexError(f"the scene has no instance {number}")
        self._native.place(np.ascontiguousarray(numbers, np.uint32), _matrices(matrix, len(numbers)).reshape(-1))

    def remove(self, instance: int) -> None:
        """Removes an instance. An instance added later may reuse its number."""
        self._native.remove(_number(instance))

    def show(self, instance: int, visible: bool = True) -> None:
        """Shows an instance to all queries or hides it from them, by setting all bits of its mask
        or none."""
        self.set_mask(instance, ALL if visible else 0)

    def hide(self, instance: int) -> None:
        """Hides an instance from queries."""
        self.show(instance, False)

    def set_mask(self, instance: int, mask: int) -> None:
        """Sets the 32-bit mask of an instance, which initially has all bits set.

        A query sees an instance if their masks share a bit.

        >>> import numpy as np, intertri
        >>> pane, at = intertri.Mesh([[0, 0, 3], [1, 0, 3], [0, 1, 3]], [[0, 1, 2]]), np.eye(4)
        >>> scene = intertri.Scene()
        >>> glass, wall = scene.add(pane), scene.add(pane, at)
        >>> scene.set_mask(glass, 0b01)
        >>> scene.set_mask(wall, 0b10)
        >>> scene.commit()
        >>> int(scene.closest([0.2, 0.2, 0], [0, 0, 1], mask=0b10)["instance"]) == wall
        True
        """
        self._native.set_mask(_number(instance), _mask(mask))

    def commit(self, *, threads: int | None = None) -> None:
        """Makes all changes visible to the queries that start after this call."""
        self._native.commit(_arrays.threads_of(threads))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene, including uncommitted changes, to a file that `Scene.load` reads.

        The file contains each mesh once, and the numbers, placements, and masks of all instances.
        Its bytes are the same on every machine. Rust's ``Scene::load`` reads it, too.

        >>> import intertri, tempfile, os
        >>> scene = intertri.Scene([intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     scene.save(os.path.join(folder, "a.scene"))
        ...     intertri.Scene.load(os.path.join(folder, "a.scene"))
        Scene(1 instance)
        """
        saved = self._native.to_bytes()
        with open(path, "wb") as file:
            file.write(saved)

    @classmethod
    def load(cls: type[AnyScene], path: str | os.PathLike[str]) -> AnyScene:
        """Loads a scene written by `Scene.save` and commits it.

        Raises
        ------
        ValueError
            If the file is not a saved scene, is damaged, or was written by a later version.

        Notes
        -----
        Loading never runs code from a file. The file has a checksum but no signature; sign it if
        you need authenticity.
        """
        with open(path, "rb") as file:
            saved = file.read()
        try:
            return _revive(cls, saved)
        except ValueError as error:
            raise ValueError(f"{os.fspath(path)}: {error}") from None

    def __reduce__(self) -> tuple[Any, ...]:
        return _revive, (type(self), self._native.to_bytes()), getattr(self, "__dict__", None)

    def closest(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mask: int = ALL,
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """Finds the closest hit of each ray. The arguments are the same as for `Mesh.closest`.

        A ray can hit only instances whose masks share a bit with ``mask``. If several hits have the
        same t, the lowest instance number wins, then the lowest triangle number.

        Returns
        -------
        (...) `SCENE_HIT`
            The fields are t, u, v, triangle and instance (both -1 for a miss), geometry, and
            leaves, which is true if the ray crosses in the direction of the triangle's normal.
        """
        rays = _arrays.rays(origins, directions, t_min, t_max, F64)
        hits = _arrays.answers(rays.shape, SCENE_HIT, out, *rays.parts)
        self._native.closest(rays, _mask(mask), _arrays.threads_of(threads), _arrays.as_bytes(hits))
        return hits if rays.shape or out is not None else hits[()]

    def any(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mask: int = ALL,
        threads: int | None = None,
        out: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.bool_]:
        """Returns whether each ray hits anything: (...) bool."""
        rays = _arrays.rays(origins, directions, t_min, t_max, F64)
        found = _arrays.answers(rays.shape, np.dtype(bool), out, *rays.parts)
        self._native.any(rays, _mask(mask), _arrays.threads_of(threads), found.reshape(-1))
        return found if rays.shape or out is not None else found[()]

    def all(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mask: int = ALL,
        threads: int | None = None,
    ) -> HitLists:
        """Finds every hit of each ray, in order of t: `HitLists` of `SCENE_HIT`."""
        rays = _arrays.rays(origins, directions, t_min, t_max, F64)
        offsets, hits = self._native.all(rays, _mask(mask), _arrays.threads_of(threads))
        return HitLists(offsets, hits.view(SCENE_HIT))

    def crossings(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = math.inf,
        mask: int = ALL,
        threads: int | None = None,
    ) -> HitLists:
        """Finds every crossing of each ray, in order of t, as `Mesh.crossings` does: `HitLists` of
        `SCENE_HIT`."""
        rays = _arrays.rays(origins, directions, t_min, t_max, F64)
        offsets, hits = self._native.crossings(rays, _mask(mask), _arrays.threads_of(threads))
        return HitLists(offsets, hits.view(SCENE_HIT))

    def closest_point(
        self,
        points: ArrayLike,
        *,
        radius: float = math.inf,
        mask: int = ALL,
        threads: int | None = None,
        out: NDArray[np.void] | None = None,
    ) -> NDArray[np.void]:
        """Finds the point on any instance that is nearest to each point.

        The arguments are the same as for `Mesh.closest_point`. If several triangles are equally
        near, the lowest instance number wins, then the lowest triangle number.

        Returns
        -------
        (...) `SCENE_NEAREST`
            The fields of `NEAREST`, and instance, which is -1 if there is no nearest point.

        Examples
        --------
        >>> import numpy as np, intertri
        >>> floor, up = intertri.Mesh([[-9, 0, -9], [9, 0, -9], [0, 0, 9]], [[0, 1, 2]]), np.eye(4)
        >>> up[1, 3] = 4
        >>> scene = intertri.Scene()
        >>> lower, upper = scene.add(floor), scene.add(floor, up)
        >>> scene.commit()
        >>> near = scene.closest_point([0, 3, 0])
        >>> int(near["instance"]) == upper, float(near["distance"])
        (True, 1.0)
        """
        at = _arrays.points(points).astype(F64)
        if np.ndim(radius) != 0:
            raise TypeError("radius must be one number for all points; for one per point, compare the distances")
        if not radius >= 0:
            raise ValueError(f"radius is {radius}; it must not be negative")
        nearest, threads = _arrays.answers(at.shape[:-1], SCENE_NEAREST, out, at), _arrays.threads_of(threads)
        flat, mask = _arrays.flat(at, F64), _mask(mask)
        self._native.closest_point(flat, float(radius), mask, threads, _arrays.as_bytes(nearest))
        return nearest if at.ndim > 1 or out is not None else nearest[()]

    def winding_number(
        self, points: ArrayLike, *, mask: int = ALL, threads: int | None = None
    ) -> NDArray[np.int32]:
        """Returns the winding number of all instances combined around each point: (...) int32 for
        points of shape (..., 3).

        Every instance is assumed to be closed. A point on the surface of an instance has the number
        0. A point inside two overlapping instances has the number 2, and a mirrored instance counts
        as -1.
        """
        numbers = self._winding(points, mask, threads)
        return np.where(numbers == SURFACE, np.int32(0), numbers)[()]

    def contains(self, points: ArrayLike, *, mask: int = ALL, threads: int | None = None) -> NDArray[np.bool_]:
        """Returns whether points are on an instance or have a nonzero `winding_number`: (...) bool
        for points of shape (..., 3)."""
        inside: NDArray[np.bool_] = self._winding(points, mask, threads) != 0
        return inside

    def _winding(self, points: ArrayLike, mask: int, threads: int | None) -> NDArray[np.int32]:
        """Returns winding numbers, or `SURFACE` for points on an instance."""
        at = _arrays.points(points).astype(F64)
        numbers = _memory.empty(at.shape[:-1], np.int32)
        threads = _arrays.threads_of(threads)
        self._native.winding(_arrays.flat(at, F64), _mask(mask), threads, _arrays.as_bytes(numbers))
        return numbers


AnyScene = TypeVar("AnyScene", bound=Scene)


def _revive(cls: type[AnyScene], saved: bytes) -> AnyScene:
    """Restores a scene from its saved bytes and commits it."""
    scene = cls.__new__(cls)
    scene._native = NativeScene.from_bytes(saved)
    return scene


def _mesh(mesh: Any) -> Mesh:
    """Converts a mesh of any supported package to a `Mesh`."""
    return mesh if isinstance(mesh, Mesh) else Mesh(mesh)


def _mask(mask: int) -> int:
    """Checks a 32-bit mask."""
    if not isinstance(mask, (int, np.integer)) or isinstance(mask, bool):
        raise TypeError(f"mask must be an integer, not {type(mask).__name__}")
    if not 0 <= mask <= ALL:
        raise ValueError(f"mask is {mask}; it must have at most 32 bits")
    return int(mask)


def _number(instance: int) -> int:
    """Checks the number of an instance."""
    if not isinstance(instance, (int, np.integer)) or isinstance(instance, bool):
        raise TypeError(f"instance must be an integer, not {type(instance).__name__}")
    if not 0 <= instance < 1 << 31:
        raise IndexError(f"the scene has no instance {instance}")
    return int(instance)


def _matrices(matrix: ArrayLike, count: int) -> NDArray[np.float64]:
    """Converts matrices to rows of twelve values."""
    numbers = _arrays.floats(matrix, "matrix").astype(F64)
    if numbers.ndim == 2:
        numbers = numbers[np.newaxis]
    if numbers.ndim != 3 or numbers.shape[1:] not in ((4, 4), (3, 4)) or len(numbers) != count:
        raise ValueError(f"matrix has shape {np.shape(matrix)}; it must be (4, 4) or (3, 4), one for each instance")
    if numbers.shape[1] == 4 and (numbers[:, 3] != [0, 0, 0, 1]).any():
        raise ValueError("matrix must have 0, 0, 0, 1 in its fourth row")
    if not np.isfinite(numbers).all():
        raise ValueError("matrix must be finite")
    return np.ascontiguousarray(numbers[:, :3].reshape(-1, 12))
