"""Tests that answers do not depend on the chunks or the number of workers, even if a worker is
lost."""

import os
import signal

import intertri
import numpy as np
import pytest
from conftest import icosphere

da = pytest.importorskip("dask.array")
distributed = pytest.importorskip("distributed")

import intertri.dask  # noqa: E402

COUNT = 300_000


@pytest.fixture(scope="module")
def mesh():
    vertices, faces = icosphere(4)
    return intertri.Mesh(vertices.astype(np.float32), faces)


@pytest.fixture(scope="module")
def rays():
    return np.random.default_rng(5).uniform(-1.5, 1.5, (COUNT, 6)).astype(np.float32)


@pytest.fixture(scope="module")
def truth(mesh, rays):
    return intertri.dask.digest(mesh.closest(rays))


@pytest.fixture(params=[1, 2])
def client(request):
    with distributed.LocalCluster(n_workers=request.param, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


def test_without_a_cluster(mesh, rays, truth):
    assert intertri.dask.digest(intertri.dask.closest(mesh, da.from_array(rays, chunks=(70_001, 6)))) == truth


@pytest.mark.parametrize("chunk", [COUNT, 100_000, 33_333])
def test_any_chunking_and_number_of_workers(client, mesh, rays, truth, chunk):
    shared = intertri.dask.share(mesh, client)
    hits = intertri.dask.closest(shared, da.from_array(rays, chunks=(chunk, 3)))
    assert hits.shape == (COUNT,) and hits.dtype == intertri.HIT
    assert intertri.dask.digest(hits) == truth
    blocks = da.from_array(rays, chunks=(chunk, 6))
    assert (intertri.dask.any(shared, blocks).compute() == mesh.any(rays)).all()
    assert (intertri.dask.count_crossings(shared, blocks).compute() == mesh.count_crossings(rays)).all()
    points = da.from_array(rays[:, :3], chunks=(chunk, 3))
    assert (intertri.dask.contains(shared, points).compute() == mesh.contains(rays[:, :3])).all()


def test_a_mesh_is_built_once_a_worker(client, mesh, rays):
    shared = intertri.dask.share(mesh, client)
    intertri.dask.closest(shared, da.from_array(rays, chunks=(20_000, 6))).compute()
    kept = client.run(lambda: list(intertri.dask._meshes))
    assert all(digests == [mesh.digest] for digests in kept.values())


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal")
def test_a_killed_worker_loses_nothing(mesh, rays, truth, tmp_path):
    flag = str(tmp_path / "killed")

    def kill_once(block, block_info=None):
        if block_info[0]["chunk-location"][0] == 12 and not os.path.exists(flag):
            open(flag, "w").close()
            os.kill(os.getpid(), signal.SIGKILL)
        return block

    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            blocks = da.from_array(rays, chunks=(10_000, 6)).map_blocks(kill_once, dtype=rays.dtype)
            hits = intertri.dask.closest(intertri.dask.share(mesh, client), blocks).persist()
            assert intertri.dask.digest(hits) == truth
    assert os.path.exists(flag)


def test_zarr(mesh, rays, truth, tmp_path):
    zarr = pytest.importorskip("zarr")
    array = zarr.create_array(str(tmp_path / "rays.zarr"), shape=rays.shape, chunks=(50_000, 6), dtype=rays.dtype)
    array[:] = rays
    hits = intertri.dask.closest(mesh, da.from_zarr(str(tmp_path / "rays.zarr")))
    intertri.dask.to_zarr(hits, str(tmp_path / "hits.zarr"))
    assert intertri.dask.digest(intertri.dask.from_zarr(str(tmp_path / "hits.zarr"))) == truth


def test_parquet(mesh, rays, truth, tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("dask.dataframe")
    import pyarrow.parquet
    names = ["ox", "oy", "oz", "dx", "dy", "dz"]
    (tmp_path / "rays").mkdir()
    for number, part in enumerate(np.array_split(rays, 4)):
        table = pyarrow.table({name: part[:, k] for k, name in enumerate(names)})
        pyarrow.parquet.write_table(table, tmp_path / "rays" / f"part-{number:03}.parquet")
    hits = intertri.dask.closest(mesh, intertri.dask.from_parquet(tmp_path / "rays", names))
    assert intertri.dask.digest(hits) == truth


def test_errors(mesh):
    with pytest.raises(ValueError, match=r"\(n, 6\) or \(n, 8\)"):
        intertri.dask.closest(mesh, da.zeros((5, 3)))
