"""Runs intertri on a cluster, with rays and answers in dask arrays.

>>> import numpy as np, dask.array, intertri, intertri.dask
>>> mesh = intertri.Mesh([[0, 0, 5], [1, 0, 5], [0, 1, 5]], [[0, 1, 2]])
>>> rays = dask.array.from_array(np.float32([[0.2, 0.2, 0, 0, 0, 1], [9, 9, 0, 0, 0, 1]]), chunks=(1, 6))
>>> intertri.dask.closest(mesh, rays).compute()["triangle"]
array([ 0, -1], dtype=int32)

The mesh is sent to each worker once, and each worker process builds the hierarchy once. Each block
of rays is one task; about a million rays per block is best. Answers do not depend on blocks,
workers, or CPUs; `digest` hashes them for comparison. If a worker dies, dask reruns its tasks.
"""

# dask's type annotations vary from version to version.
# pyright: reportAttributeAccessIssue=false, reportArgumentType=false, reportAssignmentType=false, reportCallIssue=false

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from typing import Any

import dask.array as da
from dask.base import tokenize
import numpy as np
from numpy.typing import NDArray

from .._dtypes import CROSSINGS, HIT
from .._mesh import Mesh
from .._rays import Mode

__all__ = ["SharedMesh", "any", "closest", "contains", "count_crossings", "digest", "from_parquet", "from_zarr", "share", "to_zarr"]

PROGRAM_HIT = np.dtype([("triangle", "<i8"), ("t", "<f8"), ("u", "<f8"), ("v", "<f8")])
"""The record layout of ``intertri trace --raw``, which `digest` hashes."""


class SharedMesh:
    """A mesh that `share` has sent to every worker."""

    def __init__(self, digest: str, payload: Any) -> None:
        self.digest = digest
        self.payload = payload


def share(mesh: Mesh, client: Any = None) -> SharedMesh:
    """Sends a mesh once to every worker of a ``distributed`` client.

    Pass the result to the functions below in place of the mesh. If ``client`` is omitted, the
    current client is used; if there is none, the mesh stays in this process.

    Workers that join later fetch the mesh from the others.
    """
    client = client or _client()
    if client is None:
        return SharedMesh(mesh.digest, mesh)
    payload = _Payload(mesh.digest, mesh.vertices, mesh.faces)
    return SharedMesh(mesh.digest, client.scatter(payload, broadcast=True, hash=False))


def closest(mesh: Mesh | SharedMesh, rays: da.Array, *, mode: Mode = "exact", threads: int = 1) -> da.Array:
    """Finds the closest hits of rays (n, 6) or (n, 8). Returns an array (n,) of `intertri.HIT` with
    the same blocks as the rays.

    ``threads`` is the number of threads for each block. A worker runs as many blocks at once as it
    has threads, so the default of 1 is best unless workers have a single thread but many cores.
    """
    return _blocks("closest", mesh, rays, HIT, mode=mode, threads=threads)


def any(mesh: Mesh | SharedMesh, rays: da.Array, *, mode: Mode = "exact", threads: int = 1) -> da.Array:
    """Returns whether rays (n, 6) or (n, 8) hit anything: an array (n,) of bool."""
    return _blocks("any", mesh, rays, np.dtype(bool), mode=mode, threads=threads)


def count_crossings(mesh: Mesh | SharedMesh, rays: da.Array, *, threads: int = 1) -> da.Array:
    """Counts how often rays (n, 6) or (n, 8) cross the mesh: an array (n,) of
    `intertri.CROSSINGS`."""
    return _blocks("count_crossings", mesh, rays, CROSSINGS, threads=threads)


def contains(
    mesh: Mesh | SharedMesh, points: da.Array, *, assume_closed: bool = False, threads: int = 1
) -> da.Array:
    """Returns whether points (n, 3) are inside: an array (n,) of bool."""
    options = {"assume_closed": assume_closed, "threads": threads}
    return _blocks("contains", mesh, points, np.dtype(bool), columns=(3,), **options)


def from_parquet(path: Any, columns: list[str] | None = None, **options: Any) -> da.Array:
    """Reads rays from parquet, one block per partition. ``columns`` lists either six columns
    (origin and direction) or eight (ox, oy, oz, t_min, dx, dy, dz, and t_max). By default, all
    columns of the file are used, in their order."""
    import dask.dataframe as dd

    frame = dd.read_parquet(path, columns=columns, **options)
    return frame.to_dask_array(lengths=True)


def from_zarr(path: Any, **options: Any) -> da.Array:
    """Reads closest hits that `to_zarr` wrote: an array (n,) of `intertri.HIT`."""
    fields = {name: da.from_zarr(path, component=name, **options) for name in HIT.names or ()}
    return da.map_blocks(_join, *fields.values(), dtype=HIT, meta=np.empty((0,), HIT))


def to_zarr(hits: da.Array, path: Any, **options: Any) -> None:
    """Writes closest hits into a zarr group, one array for each field (t, u, v, triangle,
    geometry), in the blocks of ``hits``. ``options``, such as ``compressors=None``, are passed to
    ``create_array``."""
    import zarr

    # Write all chunks, so that zarr need not compare their contents with the fill value.
    options.setdefault("config", {"write_empty_chunks": True})

    size = max(hits.chunks[0], default=1) or 1
    if set(hits.chunks[0][:-1]) - {size}:
        hits = hits.rechunk({0: size})
    group = zarr.open_group(path, mode="w")
    names = HIT.names or ()
    targets = [
        group.create_array(name, shape=hits.shape, chunks=(size,), dtype=HIT[name], **options) for name in names
    ]
    da.store([hits[name] for name in names], targets, lock=False)


def digest(hits: da.Array | NDArray[np.void]) -> str:
    """Returns the SHA-256 hash of closest hits, in order. It does not depend on the chunks or the
    number of workers, and is the same as the hash of the output of ``intertri trace --raw``. Blocks
    are fetched one at a time.

    >>> import numpy as np, intertri, intertri.dask
    >>> intertri.dask.digest(np.zeros(0, intertri.HIT))[:8]
    'e3b0c442'
    """
    state = hashlib.sha256()
    if isinstance(hits, np.ndarray):
        state.update(_program_bytes(hits))
    else:
        for block in hits.blocks:
            state.update(_program_bytes(block.compute()))
    return state.hexdigest()


def _program_bytes(hits: NDArray[np.void]) -> bytes:
    rows = np.empty(hits.shape, PROGRAM_HIT)
    for name in PROGRAM_HIT.names or ():
        rows[name] = hits[name]
    return rows.tobytes()


# ---- On the workers ----


class _Payload:
    """A mesh as it is sent to workers: its arrays, and the hash under which workers cache it."""

    def __init__(self, digest: str, vertices: NDArray[Any], faces: NDArray[np.uint32]) -> None:
        self.digest, self.vertices, self.faces = digest, vertices, faces


_KEPT = 4
_meshes: OrderedDict[str, Mesh] = OrderedDict()
_lock = threading.Lock()


def _mesh_of(payload: Mesh | _Payload) -> Mesh:
    """Returns the mesh in this process, built by the first task that needs it. The last few meshes
    are kept."""
    if isinstance(payload, Mesh):
        return payload
    with _lock:
        mesh = _meshes.get(payload.digest)
        if mesh is None:
            mesh = Mesh(payload.vertices, payload.faces)
            _meshes[payload.digest] = mesh
        _meshes.move_to_end(payload.digest)
        while len(_meshes) > _KEPT:
            _meshes.popitem(last=False)
        return mesh


def _join(*fields: NDArray[Any]) -> NDArray[np.void]:
    """Assembles hits from their fields."""
    hits = np.empty(fields[0].shape, HIT)
    for name, field in zip(HIT.names or (), fields):
        hits[name] = field
    return hits


def _answer(block: NDArray[Any], payload: Any, query: str, options: dict[str, Any]) -> NDArray[Any]:
    """Computes the answers of a block, on a worker."""
    answers: NDArray[Any] = getattr(_mesh_of(payload), query)(block, **options)
    return answers


def _blocks(
    query: str,
    mesh: Mesh | SharedMesh,
    rows: da.Array,
    dtype: np.dtype[Any],
    columns: tuple[int, ...] = (6, 8),
    **options: Any,
) -> da.Array:
    if rows.ndim != 2 or rows.shape[1] not in columns:
        wanted = " or ".join(f"(n, {count})" for count in columns)
        raise ValueError(f"the array has shape {rows.shape}; it must be {wanted}")
    if rows.numblocks[1] != 1:
        rows = rows.rechunk({1: -1})
    shared = mesh if isinstance(mesh, SharedMesh) else share(mesh)
    return da.map_blocks(
        _answer,
        rows,
        payload=shared.payload,
        query=query,
        options=options,
        dtype=dtype,
        drop_axis=1,
        meta=np.empty((0,), dtype),
        name=f"intertri-{query}-{tokenize(rows.name, shared.digest, query, options)}",
    )


def _client() -> Any:
    """Returns the current client, if there is one."""
    try:
        from distributed import get_client

        return get_client()
    except (ImportError, ValueError):
        return None
