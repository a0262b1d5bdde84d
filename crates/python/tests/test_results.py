"""Tests converting results to pandas data frames, replacing misses with NaN, and reusing memory for results."""

import math
import os
from concurrent.futures import ThreadPoolExecutor

import intertri
import numpy as np
import pytest
from conftest import box, icosphere
from intertri import _memory

MESH = intertri.Mesh(*icosphere(2))
RAYS = np.random.default_rng(3).uniform(-2, 2, (100, 6))
POINTS = RAYS[:, :3]
RESULTS = {
    "closest": MESH.closest(RAYS),
    "closest in float32": MESH.closest(RAYS, dtype=intertri.HIT32),
    "closest_triangle": MESH.closest_triangle(RAYS),
    "any": MESH.any(RAYS),
    "visible": MESH.visible(POINTS, [5, 5, 5]),
    "spawn_rays": MESH.spawn_rays(MESH.closest(RAYS), [0, 0, 1]),
    "all": MESH.all(RAYS).hits,
    "crossings": MESH.crossings(RAYS).hits,
    "count_crossings": MESH.count_crossings(RAYS),
    "closest_point": MESH.closest_point(POINTS),
    "contains": MESH.contains(POINTS),
    "winding_number": MESH.winding_number(POINTS),
    "signed_distance": MESH.signed_distance(POINTS),
    "hit_points": MESH.hit_points(MESH.closest(RAYS)),
}


@pytest.mark.parametrize("name", RESULTS)
def test_pandas_takes_every_result(name):
    pandas = pytest.importorskip("pandas")
    result = RESULTS[name]
    frame = pandas.DataFrame(result)
    assert len(frame) == len(result) > 0
    if result.dtype.names:
        assert tuple(frame.columns) == result.dtype.names
        for column in frame:
            assert np.array_equal(frame[column], result[column], equal_nan=frame[column].dtype.kind == "f")
            assert frame[column].dtype != object


def test_a_frame_of_lists_by_rays():
    pandas = pytest.importorskip("pandas")
    lists = MESH.all(RAYS)
    frame = pandas.DataFrame(lists.hits, index=lists.rays)
    assert len(frame) == len(lists.hits) and len(frame.loc[[lists.rays[0]]]) == lists.offsets[lists.rays[0] + 1]


def test_points_of_nearest_are_rows():
    near = MESH.closest_point(POINTS.reshape(10, 10, 3))
    points = MESH.hit_points(near)
    assert points.shape == (10, 10, 3) and (points[..., 1] == near["y"]).all()
    assert np.allclose(np.linalg.norm(points - POINTS.reshape(10, 10, 3), axis=-1), near["distance"], rtol=1e-14)
    assert MESH.hit_points(near[0, 0]).tolist() == points[0, 0].tolist()
    outward = np.einsum("ijk,ijk->ij", MESH.hit_normals(near), points)
    assert (outward > 0.9).all()


@pytest.mark.parametrize("dtype", [intertri.HIT, intertri.HIT32], ids=["float64", "float32"])
def test_misses_are_nan_where_asked(dtype):
    plain, marked = MESH.closest(RAYS, dtype=dtype), MESH.closest(RAYS, nan_misses=True, dtype=dtype)
    miss = plain["triangle"] < 0
    assert miss.any() and not miss.all() and np.isinf(plain["t"][miss]).all()
    for name in ("t", "u", "v"):
        assert np.isnan(marked[name][miss]).all() and (marked[name][~miss] == plain[name][~miss]).all()
    assert (marked["triangle"] == plain["triangle"]).all()
    away, out = [9, 9, 9], np.zeros(1, dtype)
    assert math.isnan(MESH.closest(away, [0, 0, 1], nan_misses=True, dtype=dtype)["t"])
    assert np.isnan(MESH.closest([away], [0, 0, 1], nan_misses=True, out=out)["t"]).all() and np.isnan(out["t"]).all()
    near = MESH.closest_point([away, [0, 0, 0]], radius=2, nan_misses=True)
    assert np.isnan(near["distance"]).tolist() == np.isnan(near["u"]).tolist() == [True, False]


def test_the_dtype_of_out_decides():
    hits = MESH.closest(RAYS, dtype=intertri.HIT32)
    assert intertri.HIT32.itemsize == 20 and hits.nbytes == 20 * len(RAYS)
    assert MESH.closest(RAYS).dtype == MESH.closest(RAYS, dtype=intertri.HIT).dtype == intertri.HIT
    out = np.zeros(len(RAYS), intertri.HIT32)
    for options in ({}, {"dtype": intertri.HIT32}):
        out["t"] = -1
        assert MESH.closest(RAYS, out=out, **options) is out and (out == hits).all()
    one = MESH.closest(RAYS[0], dtype=intertri.HIT32)
    assert isinstance(one, np.void) and one == hits[0] and isinstance(one["t"], np.float32)
    assert MESH.closest(np.zeros((0, 6)), dtype=intertri.HIT32).dtype == intertri.HIT32


def test_hits_in_float32_can_be_passed_on():
    wide, hits = MESH.closest(RAYS), MESH.closest(RAYS, dtype=intertri.HIT32)
    is_hit = wide["triangle"] >= 0
    points = MESH.hit_points(hits)
    assert points.dtype == np.float64 and np.allclose(points, MESH.hit_points(wide), atol=1e-7, equal_nan=True)
    assert np.array_equal(MESH.hit_normals(hits), MESH.hit_normals(wide), equal_nan=True)
    rays = MESH.spawn_rays(hits, -RAYS[:, 3:])
    assert np.array_equal(np.isnan(rays[:, 0]), ~is_hit)
    assert (MESH.closest_triangle(rays) != hits["triangle"])[is_hit].all()


def test_inside_goes_by_winding_or_by_odd_crossings():
    vertices, faces = box()
    points = [[0.1, 0.2, 0.3], [0, 0, 1.7], [1, 0.5, 0.25]]
    turned = faces.copy()
    turned[::2] = turned[::2, ::-1]
    for rows, inside in [(faces, [True, False, True]), (turned, [True, False])]:
        mesh = intertri.Mesh(vertices, rows)
        assert mesh._inside_or_odd(points[: len(inside)]).tolist() == inside
    twice = intertri.Mesh(vertices, np.concatenate([faces, faces]))
    assert twice._inside_or_odd(points).tolist() == [True, False, True]


def test_rays_start_at_nearest_points():
    near = MESH.closest_point(POINTS)
    away = MESH.hit_normals(near)
    for ways in (away, -away):
        rays = MESH.spawn_rays(near, ways)
        assert np.allclose(rays[:, :3], MESH.hit_points(near), atol=1e-12)
        assert (MESH.closest_triangle(rays) != near["triangle"]).all()


@pytest.fixture
def many():
    """Returns a mesh, and enough rays for the memory of their results to be kept for reuse."""
    vertices, faces = icosphere(2)
    ways = np.random.default_rng(3).normal(size=(50_000, 3)).astype(np.float32)
    _memory._idle.clear()
    return intertri.Mesh(vertices.astype(np.float32), faces), ways


def test_memory_is_reused_when_the_last_view_is_gone(many):
    mesh, ways = many
    hits = mesh.closest([0, 0, 0], ways)
    assert hits.nbytes > _memory.LEAST and hits.flags.c_contiguous and hits.flags.writeable and type(hits) is np.ndarray
    where, view, truth = hits.ctypes.data, hits["t"][::2], hits["t"][::2].copy()
    del hits
    others = [mesh.closest([0, 0, 0], -ways), mesh.closest([0, 0, 0], 2 * ways)]
    assert all(other.ctypes.data != where for other in others) and (view == truth).all()
    del view
    again = mesh.closest([0, 0, 0], -ways)
    assert again.ctypes.data == where and (again == others[0]).all()
    assert mesh.any([0, 0, 0], ways).all() and not _memory._idle


def test_memory_of_hits_in_float32_is_reused(many):
    mesh, ways = many
    ways = np.concatenate([ways, -ways])
    hits = mesh.closest([0, 0, 0], ways, dtype=intertri.HIT32)
    where, truth = hits.ctypes.data, hits.copy()
    assert _memory.LEAST < hits.nbytes == 20 * len(ways)
    del hits
    again = mesh.closest([0, 0, 0], ways, dtype=intertri.HIT32)
    assert again.ctypes.data == where and (again == truth).all()


def test_idle_memory_is_bounded_and_fits(many, monkeypatch):
    mesh, ways = many
    monkeypatch.setattr(_memory, "MOST", 3 << 21)
    hits = [mesh.closest([0, 0, 0], ways) for _ in range(5)]
    assert hits[0].nbytes <= 1 << 21
    del hits
    assert len(_memory._idle) == 3
    large = _memory.empty((3 << 21,), np.uint8)
    del large
    assert [len(block) for block in _memory._idle] == [3 << 21]
    # A small array does not tie up a large block.
    small = _memory.empty((1 << 20,), np.uint8)
    assert len(_memory._idle) == 1
    del small
    # A block larger than the limit is not kept.
    large = _memory.empty((4 << 21,), np.uint8)
    del large
    assert sum(map(len, _memory._idle)) <= _memory.MOST


def test_idle_memory_is_given_up_before_an_allocation_fails(many, monkeypatch):
    mesh, ways = many
    mesh.closest([0, 0, 0], ways)
    assert len(_memory._idle) == 1

    def fails(*_, **__):
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(_memory.mmap, "mmap", fails)
    assert _memory.empty((8 << 21,), np.uint8).size == 8 << 21
    assert not _memory._idle
    with pytest.raises((MemoryError, ValueError)):
        _memory.empty((1 << 60,), np.float64)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="os.fork is not available")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_does_not_write_its_parents_answers(many):
    mesh, ways = many
    hits = mesh.closest([0, 0, 0], ways)
    truth = hits.copy()
    child = os.fork()
    if child == 0:
        hits["t"] = -1
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0 and (hits == truth).all()


def test_threads_never_share_memory(many):
    mesh, ways = many
    truth = [mesh.closest([0, 0, 0], ways * scale, threads=1)["t"].copy() for scale in (1, 2, 4, 8)]

    def work(number):
        for _ in range(50):
            hits = mesh.closest([0, 0, 0], ways * (1 << number), threads=1)
            if not (hits["t"] == truth[number]).all():
                return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(4)))
