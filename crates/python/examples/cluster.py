"""Finds the closest hits of rays in a zarr array on a cluster. Copy and adapt this script.

    python cluster.py mesh.npz rays.zarr hits.zarr                       two processes on this machine
    python cluster.py mesh.npz rays.zarr hits.zarr --scheduler tcp://head:8786

On a real cluster, pass the scheduler's address and paths that every worker can reach, such as paths
on a shared file system or "s3://bucket/rays.zarr". Start workers with `dask worker tcp://head:8786
--nworkers N --nthreads T`, where N times T is the machine's number of cores. Each block is
processed by one thread. Blocks of about a million rays keep the scheduler's overhead small. Every
worker must have the same version of intertri installed.
"""

import argparse

import dask.array as da
import intertri
import intertri.dask
from distributed import Client, LocalCluster


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", help="written by Mesh.save")
    parser.add_argument("rays", help="zarr array (n, 6) or (n, 8), float32 or float64, in chunks of whole rays")
    parser.add_argument("hits", help="zarr group to write")
    parser.add_argument("--scheduler", help="address of a cluster; by default, processes on this machine")
    given = parser.parse_args()
    cluster = given.scheduler or LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        mesh = intertri.dask.share(intertri.load(given.mesh), client)
        hits = intertri.dask.closest(mesh, da.from_zarr(given.rays))
        intertri.dask.to_zarr(hits, given.hits)
        print(intertri.dask.digest(intertri.dask.from_zarr(given.hits)))


if __name__ == "__main__":
    main()
