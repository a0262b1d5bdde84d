"""Converts users' arguments to the flat, contiguous arrays of one scalar type that the native
module reads."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _inputs, _memory

F32 = np.dtype(np.float32)
F64 = np.dtype(np.float64)

Floats: TypeAlias = NDArray[np.floating[Any]]


@dataclass(slots=True)
class Rays:
    """Rays as the native module reads them, and the shape of their answers."""

    count: int
    columns: int
    origins: Floats
    directions: Floats | None
    t_min: Floats
    t_max: Floats
    shape: tuple[int, ...]
    skip: NDArray[np.int32] | None = None

    @property
    def parts(self) -> tuple[Floats | None, ...]:
        """The arrays that a query reads."""
        return self.origins, self.directions, self.t_min, self.t_max

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.origins.dtype

    @property
    def width(self) -> int:
        """The number of rays in a row of an image, or 0 if the shape does not show it."""
        return self.shape[-1] if len(self.shape) > 1 else 0


def floats(values: ArrayLike, name: str) -> Floats:
    """Converts values to float32 or float64 without changing them."""
    array = _inputs.array(values, name)
    native = array.dtype.newbyteorder("=")
    if native in (F32, F64):
        return array.astype(native, copy=False)
    if array.dtype.kind in "iub":
        as_double = array.astype(F64)
        # A value of exactly 2**53 may have been rounded from 2**53 + 1.
        if array.dtype.itemsize > 4 and (np.abs(as_double) >= 2.0**53).any():
            raise ValueError(f"{name} has integers of 2**53 or beyond, which float64 may round")
        return as_double
    if array.dtype == np.float16:
        return array.astype(F32)
    if array.dtype == object and array.size == 0:
        return array.astype(F64)
    raise TypeError(f"{name} has dtype {array.dtype}; it must be float32, float64 or integer")


def fits_f32(array: Floats) -> bool:
    """Returns whether float32 can represent every value exactly."""
    if array.dtype == F32:
        return True
    with np.errstate(over="ignore"):
        return bool(np.array_equal(array, array.astype(F32), equal_nan=True))


def points(values: ArrayLike, name: str = "points") -> Floats:
    """Converts points of shape (..., 3) to floats."""
    array = floats(values, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        if array.size == 0 and array.ndim <= 1:
            return array.reshape(0, 3)
        raise ValueError(f"{name} has shape {array.shape}; it must be (..., 3)")
    return array


def grid(origin: ArrayLike, spacing: ArrayLike, shape: Any) -> tuple[Floats, Floats, tuple[int, int, int]]:
    """Checks the arguments that describe a grid. Returns its first point, and its spacing and
    number of points along each axis."""
    first, step = floats(origin, "origin").astype(F64), floats(spacing, "spacing").astype(F64)
    if first.shape != (3,) or step.shape not in ((), (3,)):
        raise ValueError(f"origin and spacing have shapes {first.shape} and {step.shape}; they must be (3,), or one spacing for all axes")
    if not (np.isfinite(first).all() and np.isfinite(step).all() and (step > 0).all()):
        raise ValueError(f"origin is {first.tolist()} and spacing {step.tolist()}; they must be finite, and spacing above 0")
    counts = _inputs.array(shape, "shape")
    if counts.shape != (3,) or counts.dtype.kind not in "iu" or (counts < 0).any():
        raise ValueError(f"shape is {shape}; it must be three voxel counts, (nx, ny, nz)")
    nx, ny, nz = (int(count) for count in counts)
    return first, np.broadcast_to(step, (3,)), (nx, ny, nz)


def flat(array: Floats, dtype: np.dtype[Any]) -> Floats:
    """Returns the values as a flat array, copied only if type, order, or alignment requires it."""
    return np.require(array, dtype, ["C", "A"]).reshape(-1)


def vertices_and_faces(
    vertices: ArrayLike, faces: ArrayLike | None
) -> tuple[Floats, NDArray[np.uint32]]:
    """Checks vertices (n, 3) and faces (m, 3). Triangles (m, 3, 3) become three vertices each."""
    corners = floats(vertices, "vertices")
    if faces is None:
        if corners.size == 0:
            corners = corners.reshape(0, 3, 3)
        if corners.ndim != 3 or corners.shape[1:] != (3, 3):
            raise ValueError(
                f"without faces, vertices must be triangles of shape (m, 3, 3), not {corners.shape}"
            )
        corners = corners.reshape(-1, 3)
        rows = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
    else:
        if corners.size == 0 and corners.ndim == 1:
            corners = corners.reshape(0, 3)
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise ValueError(f"vertices has shape {corners.shape}; it must be (n, 3)")
        rows = face_rows(faces, len(corners))
    check_finite(corners, rows)
    return corners, rows


def check_finite(corners: Floats, rows: NDArray[np.uint32]) -> None:
    """Raises an error if a face has a vertex that is not finite. Vertices without a face are
    ignored."""
    finite: NDArray[np.bool_] = np.logical_and.reduce(np.isfinite(corners), axis=1)
    if not finite.all():
        used = rows[~finite[rows].all(axis=1)]
        if len(used):
            row = int(used[~finite[used]].min())
            raise ValueError(f"vertex {row} is not finite: {corners[row].tolist()}")


def face_rows(faces: ArrayLike, count: int) -> NDArray[np.uint32]:
    """Checks faces (m, 3) against the number of vertices."""
    rows = _inputs.array(faces, "faces")
    if rows.size == 0:
        return np.zeros((0, 3), np.uint32)
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ValueError(f"faces has shape {rows.shape}; it must be (m, 3): triangles")
    if rows.dtype.kind not in "iu":
        raise TypeError(f"faces has dtype {rows.dtype}; it must be integer")
    if len(rows) >= 2**31 or count >= 2**32:
        raise ValueError("there are more than 2**31 faces or 2**32 vertices")
    wrong = (rows < 0) | (rows >= count)
    if wrong.any():
        row = int(np.argmax(wrong.any(axis=1)))
        wrong_rows = int(wrong.any(axis=1).sum())
        raise IndexError(
            f"face {row} is {rows[row].tolist()}, but there are {count} vertices"
            + (f" ({wrong_rows} faces are out of range)" if wrong_rows > 1 else "")
        )
    return rows.astype(np.uint32)


def vertex_rows(indices: ArrayLike, moved: Floats, count: int) -> NDArray[np.intp]:
    """Checks the indices of the vertices that move, one for each new position."""
    rows = _inputs.array(indices, "indices")
    if rows.size == 0:
        rows = rows.astype(np.intp)
    if rows.ndim != 1 or rows.dtype.kind not in "iu":
        raise TypeError(f"indices has dtype {rows.dtype} and shape {rows.shape}; it must be (n,) integers: rows of vertices")
    if moved.shape != (len(rows), 3):
        raise ValueError(f"vertices has shape {moved.shape}; it must be ({len(rows)}, 3), one row for each index")
    wrong = (rows < 0) | (rows >= count)
    if wrong.any():
        raise IndexError(f"indices has {rows[wrong][0]}, but there are {count} vertices")
    return rows.astype(np.intp)


def broadcast(shape: tuple[int, ...], other: tuple[int, ...], names: str) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(shape, other)
    except ValueError:
        raise ValueError(f"{names} have shapes that do not fit: {shape} and {other}") from None


def _column(value: ArrayLike, name: str, shape: tuple[int, ...]) -> tuple[Floats, bool]:
    """Converts a limit of t, which is one number for all rays or one per ray. Also returns whether
    it is a plain Python number, which takes the dtype of the rays."""
    is_weak = isinstance(value, (int, float)) and not isinstance(value, np.generic)
    array = floats(value, name)
    if array.ndim:
        try:
            array = np.broadcast_to(array, shape)
        except ValueError:
            raise ValueError(f"{name} has shape {array.shape}, but the rays have {shape}") from None
    return array, is_weak


def _plain_rays(
    origins: ArrayLike, directions: ArrayLike | None, t_min: ArrayLike, t_max: ArrayLike, mesh: np.dtype[Any]
) -> Rays | None:
    """Returns the rays if the native module can read their arrays without conversion, in the dtype
    of the mesh. This is the fast path."""
    low, high = _plain_end(t_min, mesh), _plain_end(t_max, mesh)
    if low is None or high is None or not _is_plain(origins, mesh):
        return None
    assert isinstance(origins, np.ndarray)
    shape = origins.shape
    if directions is None:
        if shape[-1] != 6:
            return None
        return Rays(origins.size // 6, 6, origins.reshape(-1), None, low, high, shape[:-1])
    if not _is_plain(directions, mesh):
        return None
    assert isinstance(directions, np.ndarray)
    if shape != directions.shape:
        # All rays share one origin or one direction.
        if len(shape) == 1:
            shape = directions.shape
        elif directions.ndim != 1:
            return None
    if origins.shape[-1] != 3 or directions.shape[-1] != 3 or 0 in shape:
        return None
    return Rays(math.prod(shape[:-1]), 3, origins.reshape(-1), directions.reshape(-1), low, high, shape[:-1])


def _is_plain(array: object, mesh: np.dtype[Any]) -> bool:
    return type(array) is np.ndarray and array.dtype is mesh and array.ndim > 0 and array.flags.c_contiguous and array.flags.aligned


_ENDS: dict[tuple[Any, object], Floats] = {
    (dtype, end): np.array([end], dtype) for dtype in (F32, F64) for end in (0.0, 1.0, math.inf)
}

for _end in _ENDS.values():
    _end.flags.writeable = False


def _plain_end(end: object, mesh: np.dtype[Any]) -> Floats | None:
    """Returns a limit in the dtype of the rays if it is a plain Python 0, 1, or infinity. Returns
    `None` for any other limit."""
    return _ENDS.get((mesh, end)) if type(end) in (float, int) else None


def rays(
    origins: ArrayLike,
    directions: ArrayLike | None,
    t_min: ArrayLike,
    t_max: ArrayLike,
    mesh: np.dtype[Any],
    names: tuple[str, str] = ("origins", "directions"),
) -> Rays:
    """Converts rays for a mesh of the given dtype: to float32 if the mesh is float32 and no ray
    loses precision, otherwise to float64."""
    plain = _plain_rays(origins, directions, t_min, t_max, mesh)
    if plain is not None:
        return plain
    first = floats(origins, names[0] if directions is not None else "rays")
    if directions is None:
        if first.size == 0 and first.ndim == 1:
            first = first.reshape(0, 6)
        if first.ndim == 0 or first.shape[-1] not in (6, 8):
            raise ValueError(f"rays have shape {first.shape}; without directions it must be (..., 6) or (..., 8)")
        columns, shape, second = first.shape[-1], first.shape[:-1], None
    else:
        columns = 3
        first, second = points(first, names[0]), points(directions, names[1])
        shape = broadcast(first.shape[:-1], second.shape[:-1], " and ".join(names))
    (low, low_is_weak), (high, high_is_weak) = _column(t_min, "t_min", shape), _column(t_max, "t_max", shape)
    if columns == 8 and not (low.ndim == high.ndim == 0 and low == 0 and high == math.inf):
        raise ValueError("rays of shape (..., 8) have their own t_min and t_max")

    strong = [first] + [second] * (second is not None) + [low] * (not low_is_weak) + [high] * (not high_is_weak)
    dtype = mesh
    if mesh == F32 and not all(fits_f32(array) for array in strong if array is not None):
        dtype = F64

    count = math.prod(shape)

    def numbers(array: Floats, row: tuple[int, ...]) -> Floats:
        """Returns all rows, or the single row that all rays share."""
        if array.size == math.prod(row):
            return flat(array, dtype)
        return flat(np.broadcast_to(array, shape + row), dtype)

    return Rays(
        count,
        columns,
        numbers(first, (columns,)),
        None if second is None else numbers(second, (3,)),
        numbers(low, ()),
        numbers(high, ()),
        shape,
    )


def numbers_of_faces(skip: ArrayLike, name: str, shape: tuple[int, ...], faces: int) -> NDArray[np.int32]:
    """Checks the triangles that rays of this shape skip, given as one number for all rays or one
    per ray."""
    numbers = _inputs.array(skip, name)
    if numbers.dtype.kind not in "iu" and numbers.size:
        raise TypeError(f"{name} has dtype {numbers.dtype}; it must be integer, such as hits['triangle']")
    try:
        numbers = np.broadcast_to(numbers, shape)
    except ValueError:
        raise ValueError(f"{name} has shape {numbers.shape}, but the rays have {shape}") from None
    wrong = (numbers < -1) | (numbers >= faces)
    if wrong.any():
        number = int(numbers[wrong].reshape(-1)[0])
        raise IndexError(f"{name} has {number}, but there are {faces} faces; -1 skips none")
    return np.ascontiguousarray(numbers, np.int32)


def answers(
    shape: tuple[int, ...], dtype: np.dtype[Any], out: NDArray[Any] | None, *asked: NDArray[Any] | None
) -> NDArray[Any]:
    """Returns the array for the answers: `out` if it is given, otherwise a new array."""
    if out is None:
        return _memory.empty(shape, dtype)
    if not isinstance(out, np.ndarray):
        raise TypeError(f"out must be a numpy array, not {type(out).__name__}")
    if out.dtype != dtype:
        raise TypeError(f"out has dtype {out.dtype}; it must be {dtype}")
    if out.shape != shape:
        raise ValueError(f"out has shape {out.shape}; it must be {shape}")
    if not (out.flags.c_contiguous and out.flags.aligned and out.flags.writeable):
        raise ValueError("out must be contiguous, aligned and writeable")
    if any(part is not None and np.may_share_memory(out, part) for part in asked):
        raise ValueError("out shares memory with the query; pass a separate array")
    return out


def mark_misses(found: NDArray[np.void], distance: str) -> None:
    """Sets the distances and weights of misses to NaN."""
    miss = found["triangle"] < 0
    for name in (distance, "u", "v"):
        found[name][miss] = math.nan


def as_bytes(array: NDArray[Any]) -> NDArray[np.uint8]:
    """Returns a view of a contiguous array's memory as bytes."""
    return array.reshape(-1).view(np.uint8)


def threads_of(threads: int | None) -> int | None:
    """Checks a thread count, where `None` means all threads."""
    if threads is None:
        return None
    if not isinstance(threads, (int, np.integer)) or isinstance(threads, bool):
        raise TypeError(f"threads must be an integer or None, not {type(threads).__name__}")
    if not 1 <= threads <= 1024:
        raise ValueError(f"threads is {threads}; it must be from 1 to 1024, or None for all")
    return int(threads)
