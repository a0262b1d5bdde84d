"""Compares a cluster of two processes with two threads in one process. Rays and answers are stored
in zarr.

    python cluster.py MODEL.obj FOLDER [--rays 100] [--workers 2]

Writes the rays and the answers to FOLDER in blocks, at 24 bytes per ray and 32 bytes per answer.
Prints how long the two threads take to trace, how long each worker takes, and how long the whole
run takes with and without tracing. Also prints a hash of all answers.
"""

import argparse
import shutil
import time
from pathlib import Path

import dask.array as da
import intertri
import intertri.dask
import numpy as np
import trimesh
import zarr
from distributed import Client, LocalCluster

BLOCK = 1_000_000


def some_rays(mesh, number, count):
    """Returns the rays of a block. Each goes from one random point in the mesh's bounding box to
    another. The block's number is the seed."""
    rng = np.random.default_rng(number)
    low, high = mesh.bounds
    a, b = (rng.uniform(low, high, (count, 3)).astype(np.float32) for _ in range(2))
    return np.concatenate([a, b - a], axis=1)


def timed():
    """Makes the worker on which this function runs record the time that each block takes."""
    from intertri.dask import _answer as answer

    if hasattr(answer, "seconds"):
        return

    def _answer(*arguments, **options):
        began = time.perf_counter()
        found = answer(*arguments, **options)
        _answer.seconds.append(time.perf_counter() - began)
        return found

    _answer.seconds = []
    intertri.dask._answer = _answer


def taken():
    seconds = list(intertri.dask._answer.seconds)
    intertri.dask._answer.seconds.clear()
    return seconds


def by_threads(mesh, where, threads):
    """Returns the seconds that threads take to trace each of the first ten blocks from memory into
    a reused array. The script calls it before and after the cluster runs, because the machine's
    speed varies."""
    rays, out, times = zarr.open_array(where), np.empty(BLOCK, intertri.HIT), []
    for first in range(0, min(rays.shape[0], 10 * BLOCK), BLOCK):
        block = rays[first : first + BLOCK]
        mesh.closest(block[:1000], threads=threads, out=out[:1000])
        began = time.perf_counter()
        mesh.closest(block, threads=threads, out=out)
        times.append(time.perf_counter() - began)
    return times


def untraced(block):
    """Reads a block of rays without tracing it. Returns an array of the same size as the answers,
    filled with values from the rays."""
    hits = np.zeros(len(block), intertri.HIT)
    hits["t"], hits["u"], hits["v"] = block[:, 0], block[:, 1], block[:, 2]
    return hits


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rays", type=int, default=100, help="number of blocks of a million rays")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    loaded = trimesh.load(given.model, process=False, force="mesh", skip_materials=True)
    mesh = intertri.Mesh(np.float32(loaded.vertices), loaded.faces)
    where, count = str(given.folder / "rays.zarr"), given.rays * BLOCK
    if not Path(where).exists():
        array = zarr.create_array(where, shape=(count, 6), chunks=(BLOCK, 6), dtype="f4", compressors=None)
        for number in range(given.rays):
            array[number * BLOCK : (number + 1) * BLOCK] = some_rays(mesh, number, BLOCK)
    times = by_threads(mesh, where, given.workers)
    with LocalCluster(n_workers=given.workers, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            client.run(timed)
            shared = intertri.dask.share(mesh, client)
            blocks = da.from_zarr(where)
            intertri.dask.closest(shared, blocks[:BLOCK * given.workers]).compute()
            client.run(taken)
            copied, answered = str(given.folder / "copied.zarr"), str(given.folder / "hits.zarr")
            began = time.perf_counter()
            copy = blocks.map_blocks(untraced, dtype=intertri.HIT, drop_axis=1, meta=np.empty(0, intertri.HIT))
            intertri.dask.to_zarr(copy, copied, compressors=None)
            copy_took = time.perf_counter() - began
            shutil.rmtree(copied)
            began = time.perf_counter()
            intertri.dask.to_zarr(intertri.dask.closest(shared, blocks), answered, compressors=None)
            took = time.perf_counter() - began
            traced = sum(sum(seconds) for seconds in client.run(taken).values())
    times += by_threads(mesh, where, given.workers)
    print(f"{given.workers} threads trace {count} rays in about {np.mean(times) * given.rays:.2f} s")
    print(f"{given.workers} processes trace for {traced / given.workers:.2f} s each")
    print(f"from zarr to zarr {took:.2f} s; without tracing {copy_took:.2f} s")
    began = time.perf_counter()
    print(intertri.dask.digest(intertri.dask.from_zarr(answered)), f"({time.perf_counter() - began:.1f} s)")


if __name__ == "__main__":
    main()
