"""Tests ray queries, comparing their results bit for bit with those of rational arithmetic."""

import math

import intertri
import numpy as np
import oracle
import pytest
from conftest import box, camera, icosphere


def aimed(mesh, rng, count):
    """Returns difficult rays: most aim at corners or edge midpoints, some run along an axis, and some are random."""
    corners = mesh.triangles
    origins = (mesh.vertices.mean(axis=0) + rng.uniform(-2, 2, (count, 3))).astype(mesh.dtype)
    picked = corners[rng.integers(len(corners), size=count)]
    middle = (picked[:, 0] / 2 + picked[:, 1] / 2).astype(mesh.dtype)
    target = np.where(np.arange(count)[:, None] % 2 == 0, picked[:, 0], middle)
    directions = (target - origins).astype(mesh.dtype)
    directions[::5] = rng.uniform(-1, 1, (len(directions[::5]), 3))
    directions[1::7, 0] = 0
    directions[2::7, :2] = 0
    origins[2::7, :2] = picked[2::7, 0, :2]
    return origins, directions


def rounded(hit):
    """Returns the exact t, u, and v, each rounded once."""
    return [float(x) for x in hit[:3]]


@pytest.fixture(params=["sphere", "box", "far"])
def mesh(request, dtype):
    vertices, faces = icosphere(2) if request.param != "box" else box()
    if request.param == "far":
        vertices = vertices * 0.25 + [148376, 1234, -223423]
    return intertri.Mesh(vertices.astype(dtype), faces)


def test_closest_is_right(mesh, rng):
    origins, directions = aimed(mesh, rng, 120)
    hits = mesh.closest(origins, directions)
    found = 0
    for hit, origin, direction in zip(hits, origins, directions):
        truth = oracle.closest(mesh.triangles, origin, direction)
        if truth is None:
            assert hit["triangle"] == -1 and hit["t"] == math.inf
        else:
            found += 1
            assert hit["triangle"] == truth[3]
            assert [hit["t"], hit["u"], hit["v"]] == rounded(truth)
    assert found > 20
    assert (mesh.any(origins, directions) == (hits["triangle"] >= 0)).all()
    assert (mesh.closest_triangle(origins, directions) == hits["triangle"]).all()


def test_hits_in_float32_are_rounded_once(mesh, rng):
    origins, directions = aimed(mesh, rng, 120)
    wide, hits = mesh.closest(origins, directions), mesh.closest(origins, directions, dtype=intertri.HIT32)
    assert hits.dtype == intertri.HIT32 and (hits["triangle"] == wide["triangle"]).all() and not hits["geometry"].any()
    for hit, origin, direction in zip(hits, origins, directions):
        triangle = hit["triangle"]
        truth = oracle.hit(mesh.triangles[triangle], origin, direction) if triangle >= 0 else None
        expected = [math.inf, 0, 0] if truth is None else [oracle.single(x) for x in truth]
        assert [hit["t"], hit["u"], hit["v"]] == expected
        assert mesh.closest(origin, direction, dtype=intertri.HIT32) == hit
    assert (hits["triangle"] >= 0).sum() > 20


@pytest.mark.parametrize("count", [1, 2, 5000])
def test_float32_is_not_rounded_from_float64(count):
    """The hit's t is so close to the middle between 1 and the next float32 that float64 rounds it to the middle."""
    n = 2.0**30 - 1
    mesh = intertri.Mesh(np.array([[-9, -9, n + 64], [9, -9, n + 64], [0, 9, n + 64]]), [[0, 1, 2]])
    rays = np.tile([0, 0, 0, 0, 0, n], (count, 1))
    assert np.float32(mesh.closest(rays)["t"].max()) == 1
    assert (mesh.closest(rays, dtype=intertri.HIT32)["t"] == np.float32(1 + 2.0**-23)).all()


def test_float32_beyond_its_range():
    """A distance that float32 cannot hold becomes infinity or 0; the triangle still shows that it is a hit."""
    mesh = intertri.Mesh(np.array([[-1e9, -1e9, 1], [1e9, -1e9, 1], [0, 1e9, 1]]), [[0, 1, 2]])
    hits = mesh.closest([0, 0, 0], [[0, 0, 1e-300], [0, 0, 1e300]], dtype=intertri.HIT32)
    assert hits["t"].tolist() == [math.inf, 0] and (hits["triangle"] == 0).all()


def test_forms_of_rays_agree_in_float32(dtype, rng):
    """Compares images in every form, intervals, `skip`, and thread counts with shuffled rays."""
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(dtype), f))(*icosphere(4)))
    eye, directions = camera(160, [1, 0.5, 3])
    eye, directions = eye.astype(dtype), directions.astype(dtype)
    flat = directions.reshape(-1, 3)
    rays = np.insert(np.concatenate([np.broadcast_to(eye, flat.shape), flat], axis=1), [3, 6], [0, np.inf], axis=1)
    ask = lambda *rays, **options: mesh.closest(*rays, dtype=intertri.HIT32, **options).reshape(-1)
    shuffled = rng.permutation(len(flat))
    hits = ask(rays[shuffled])[np.argsort(shuffled)]
    assert 0.1 < (hits["triangle"] >= 0).mean() < 0.9
    for threads in (1, 2):
        for form in ((eye, directions), (eye, flat), (rays[:, :3], rays[:, 4:7]), (rays[:, [0, 1, 2, 4, 5, 6]],), (rays,)):
            assert (ask(*form, threads=threads) == hits).all()
    for options in ({"t_max": 2.5}, {"t_min": 2.5}, {"skip": hits["triangle"]}):
        wide = mesh.closest(eye, flat, **options)
        assert (ask(eye, flat, **options)["triangle"] == wide["triangle"]).all()
        assert (wide["triangle"] != hits["triangle"]).any()


def test_all_and_crossings_are_right(mesh, rng):
    origins, directions = aimed(mesh, rng, 80)
    lists, crossed = mesh.all(origins, directions), mesh.crossings(origins, directions)
    counts = mesh.count_crossings(origins, directions)
    assert lists.offsets[-1] == len(lists.hits) > 20 and crossed.offsets[-1] == len(crossed.hits) > 20
    firsts = np.unique(lists.rays, return_index=True)[1]
    assert (mesh.all(origins, directions, limit=1).hits == lists.hits[firsts]).all()
    for i, (origin, direction) in enumerate(zip(origins, directions)):
        truth = oracle.all_hits(mesh.triangles, origin, direction)
        hits = lists.hits[lists.offsets[i] : lists.offsets[i + 1]]
        assert hits["triangle"].tolist() == [hit[3] for hit in truth]
        assert [[h["t"], h["u"], h["v"]] for h in hits] == [rounded(hit) for hit in truth]
        truth = oracle.crossings(mesh.triangles, origin, direction)
        hits = crossed.hits[crossed.offsets[i] : crossed.offsets[i + 1]]
        assert hits["triangle"].tolist() == [triangle for _, triangle, _ in truth]
        assert hits["t"].tolist() == [float(t) for t, _, _ in truth]
        assert hits["leaves"].tolist() == [side == 1 for _, _, side in truth]
        assert counts[i].tolist() == (sum(side for _, _, side in truth), len(truth))


def test_intervals(dtype):
    mesh = intertri.Mesh(np.array([[[0, 0, 5], [1, 0, 5], [0, 1, 5]]], dtype))
    query = lambda **ends: int(mesh.closest([0.25, 0.25, 0], [0, 0, 1], **ends)["triangle"])
    assert query(t_min=5) == 0 and query(t_max=5) == -1
    assert query(t_min=np.nextafter(dtype(5), dtype(6))) == -1 and query(t_max=np.nextafter(dtype(5), dtype(6))) == 0
    assert query(t_min=math.nan) == -1 and query(t_min=6, t_max=4) == -1 and query(t_min=-3) == 0
    t_max = np.array([4, 5, 6], dtype)
    assert mesh.any([0.25, 0.25, 0], np.tile(dtype([0, 0, 1]), (3, 1)), t_max=t_max).tolist() == [False, False, True]
    rays = np.array([[0.25, 0.25, 0, 0, 0, 0, 1, 6], [0.25, 0.25, 0, 0, 0, 0, 1, 5]], dtype)
    assert mesh.closest(rays)["triangle"].tolist() == [0, -1]
    assert mesh.closest(rays, t_min=np.float64(0), t_max=np.float64(np.inf))["triangle"].tolist() == [0, -1]


def test_numpy_interval_ends_keep_their_precision():
    """The hit's t is 2/3, which float32 rounds up. A plain Python float is converted to the dtype of the rays."""
    mesh = intertri.Mesh(np.float32([[[0, 0, 2], [1, 0, 2], [0, 1, 2]]]))
    ray = np.float32([0.25, 0.25, 0]), np.float32([0, 0, 3])
    t = mesh.closest(*ray)["t"]
    assert isinstance(t, np.float64) and t < np.float32(t)
    assert not any(mesh.any(*ray, t_max=end) for end in (t, np.asarray(t)))
    assert mesh.any(*ray, t_max=float(t)) and mesh.any(*ray, t_max=np.float32(t))
    assert mesh.any(*ray, t_min=t) and not mesh.any(*ray, t_min=float(t))


def test_nan_and_infinity_miss(dtype):
    mesh = intertri.Mesh(np.array([[[0, 0, 5], [1, 0, 5], [0, 1, 5]]], dtype))
    for bad in (math.nan, math.inf, -math.inf):
        assert mesh.closest([bad, 0, 0], [0, 0, 1])["triangle"] == -1
        assert mesh.closest([0.2, 0.2, 0], [0, 0, bad])["triangle"] == -1
    assert mesh.closest([0.2, 0.2, 0], [0, 0, 0])["triangle"] == -1


def test_forms_of_rays_agree(dtype, rng):
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(dtype), f))(*icosphere(2)))
    eye, directions = camera(40, [0, 0.5, 4])
    eye, directions = eye.astype(dtype), directions.astype(dtype)
    flat = directions.reshape(-1, 3)
    hits = mesh.closest(np.broadcast_to(eye, flat.shape), flat)
    assert (hits["triangle"] >= 0).sum() > 100
    six = np.concatenate([np.broadcast_to(eye, flat.shape), flat], axis=1)
    eight = np.insert(np.insert(six, 3, 0, axis=1), 7, np.inf, axis=1)
    assert (mesh.closest(eye, flat) == hits).all()
    assert (mesh.closest(eye, directions).ravel() == hits).all() and mesh.closest(eye, directions).shape == (40, 40)
    assert (mesh.closest(six) == hits).all() and (mesh.closest(eight) == hits).all()
    assert (mesh.closest(np.asfortranarray(six)) == hits).all()
    assert (mesh.closest(eye, np.repeat(flat, 2, axis=0)[::2]) == hits).all()
    assert (mesh.closest(eye, flat[::-1])[::-1] == hits).all()
    assert (mesh.closest(eye.astype(">" + eye.dtype.str[1:]), flat) == hits).all()
    padded = np.zeros(flat.nbytes + 1, np.uint8)
    padded[1:] = flat.view(np.uint8).ravel()
    unaligned = padded[1:].view(flat.dtype).reshape(-1, 3)
    assert not unaligned.flags.aligned and (mesh.closest(eye, unaligned) == hits).all()
    one = [mesh.closest(eye, direction) for direction in flat[:50]]
    assert all(a == b for a, b in zip(one, hits))


@pytest.mark.parametrize("size", [31, 64, 100, 200, 333])
def test_order_of_pictures_changes_nothing(dtype, size, rng):
    """Images are traced in tiles, but the hits do not depend on the row length, the ray order, or missing pixels."""
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(dtype), f))(*icosphere(4)))
    eye, directions = camera(size, [1, 0.5, 3])
    eye, flat = eye.astype(dtype), directions.astype(dtype).reshape(-1, 3)
    shuffled = rng.permutation(len(flat))
    hits = np.empty(len(flat), intertri.HIT)
    hits[shuffled] = mesh.closest(eye, flat[shuffled])
    assert (hits["triangle"] >= 0).mean() > 0.1
    assert (mesh.closest(eye, flat) == hits).all()
    assert (mesh.closest(eye, flat.reshape(size, size, 3)).ravel() == hits).all()
    cut = len(flat) - 17
    assert (mesh.closest(eye, flat[:cut]) == hits[:cut]).all() and (mesh.closest(eye, flat[17:]) == hits[17:]).all()
    assert (mesh.closest_triangle(eye, flat) == hits["triangle"]).all()
    assert (mesh.any(eye, flat) == (hits["triangle"] >= 0)).all()


@pytest.mark.parametrize("width,height", [(131, 100), (64, 70), (33, 200), (259, 33)])
def test_lists_of_pictures(dtype, width, height, rng):
    """Compares all hits and crossings of an image, in every ray layout, with those of shuffled rays."""
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(dtype), f))(*icosphere(4)))
    eye, directions = camera(260, [1, 0.5, 3])
    top, left = (260 - height) // 2, (260 - width) // 2
    flat = directions.astype(dtype)[top : top + height, left : left + width].reshape(-1, 3)
    count = len(flat) - 5
    t_max = rng.uniform(2, 4, count).astype(dtype)
    rays = np.zeros((count, 8), dtype)
    rays[:, :3], rays[:, 4:7], rays[:, 7] = eye, flat[:count], t_max
    forms = [((eye.astype(dtype), rays[:, 4:7]), {"t_max": t_max}), ((rays[:, :3], rays[:, 4:7]), {"t_max": t_max}),
             ((rays[:, [0, 1, 2, 4, 5, 6]],), {"t_max": t_max}), ((rays,), {})]
    shuffled = rng.permutation(count)
    back = np.argsort(shuffled)
    for query in (mesh.all, mesh.crossings):
        truth = query(rays[shuffled])
        rows = np.split(truth.hits, truth.offsets[1:-1])
        hits, counts = np.concatenate([rows[i] for i in back]), np.diff(truth.offsets)[back]
        assert (counts > 1).any()
        for given, ends in forms:
            lists = query(*given, **ends)
            assert (np.diff(lists.offsets) == counts).all() and (lists.hits == hits).all()
    closest = mesh.closest(rays[shuffled])[back]
    assert all((mesh.closest(*given, **ends) == closest).all() for given, ends in forms)


@pytest.mark.parametrize("width,height", [(2048, 9), (1024, 64), (500, 37)])
def test_wide_pictures(dtype, width, height, rng):
    """Traces scans with few, long rows, where the thread count determines how many rows are traced together."""
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(dtype), f))(*icosphere(4)))
    around, up = np.meshgrid(np.linspace(0, 6.2, width), np.linspace(-0.4, 0.4, height))
    directions = np.stack([np.cos(around), np.sin(around), up], axis=-1).astype(dtype)[:, :-1]
    eye = np.array([1.5, 0, 0], dtype)
    shuffled = rng.permutation(directions.size // 3)
    truth = np.empty(directions.shape[:2], intertri.HIT)
    truth.reshape(-1)[shuffled] = mesh.closest(eye, directions.reshape(-1, 3)[shuffled])
    assert 0.02 < (truth["triangle"] >= 0).mean() < 0.9
    counts = mesh.count_crossings(eye, directions.reshape(-1, 3)[shuffled])["unsigned"]
    for threads in (1, 2, 7):
        assert (mesh.closest(eye, directions, threads=threads) == truth).all()
        assert (mesh.closest(eye, directions.reshape(-1, 3), threads=threads).reshape(truth.shape) == truth).all()
        lists = mesh.crossings(eye, directions, threads=threads)
        assert (np.diff(lists.offsets)[shuffled] == counts).all()
        nearest = lists.hits["t"][lists.offsets[:-1][np.diff(lists.offsets) > 0]]
        assert (nearest == truth["t"][truth["triangle"] >= 0]).all()


def test_threads_and_out_change_nothing(dtype):
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(dtype), f))(*icosphere(4)))
    eye, directions = camera(400, [1, 0.5, 3])
    eye, directions = eye.astype(dtype), directions.astype(dtype).reshape(-1, 3)
    hits = mesh.closest(eye, directions)
    out = np.zeros(len(directions), intertri.HIT)
    for threads in (1, 2, 3):
        assert mesh.closest(eye, directions, threads=threads, out=out) is out
        assert (out == hits).all()
        assert (mesh.all(eye, directions, threads=threads).hits == mesh.all(eye, directions).hits).all()
    found = np.zeros(len(directions), bool)
    assert mesh.any(eye, directions, out=found) is found and (found == (hits["triangle"] >= 0)).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_crossings_of_a_diagonal(dtype):
    """Each ray through a square's diagonal crosses the square exactly once, even if its barycentric weights are inexact."""
    for n in range(2, 90):
        square = np.array([[0, 0, 1], [n, 0, 1], [0, n, 1], [n, n, 1]], dtype)
        mesh = intertri.Mesh(square, [[0, 1, 2], [3, 2, 1]])
        k = np.arange(1, n)
        lists = mesh.crossings(np.stack([k, n - k, 0 * k], axis=1).astype(dtype), np.array([0, 0, 1], dtype))
        assert (np.diff(lists.offsets) == 1).all() and (lists.hits["t"] == 1).all(), n


@pytest.mark.parametrize("few", [False, True])
def test_lists_from_many_chunks(few, rng):
    """Traces rays that end between parallel walls, so that the expected hits are known, on 1, 2, and 5 threads."""
    walls = np.arange(1, 6)
    corners = np.array([[-9, -9, 0], [9, -9, 0], [0, 18, 0]])
    mesh = intertri.Mesh(np.float32((corners + walls[:, None, None] * [0, 0, 1]).reshape(-1, 3)), np.arange(15).reshape(5, 3))
    count = 50_000
    hits = rng.integers(0, 2 if few else 6, count)
    origins = np.float32(rng.uniform(-1, 1, (count, 3)) * [1, 1, 0])
    ends = np.cumsum(hits)
    expected = np.arange(ends[-1]) - np.repeat(ends - hits, hits)
    assert (ends[-1] <= count) == few
    for threads in (1, 2, 5):
        for query in (mesh.all, mesh.crossings):
            lists = query(origins, [0, 0, 1], t_max=np.float32(hits + 0.5), threads=threads)
            assert (lists.offsets[1:] == ends).all() and lists.offsets[0] == 0
            assert (lists.hits["triangle"] == expected).all() and (lists.hits["t"] == expected + 1).all()
            assert lists.hits.flags.writeable and (len(lists.hits) == ends[-1])


def test_certified(rng):
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(np.float32), f))(*icosphere(3)))
    eye, directions = camera(64, [1, 0.5, 3])
    eye, directions = eye.astype(np.float32), directions.astype(np.float32)
    exact, certified = mesh.closest(eye, directions), mesh.closest(eye, directions, mode="certified")
    assert (exact["triangle"] == certified["triangle"]).mean() > 0.99
    hit = exact["triangle"] >= 0
    assert np.allclose(exact["t"][hit], certified["t"][hit], rtol=1e-9)
    rounded = mesh.closest(eye, directions, mode="certified", dtype=intertri.HIT32)
    assert (rounded == certified.astype(intertri.HIT32)).all()


def test_float64_rays_keep_their_precision():
    """Traces rays that pass within 1e-12 of an edge of a float32 mesh. Rounded to float32, they would be identical."""
    mesh = intertri.Mesh(np.float32([[[0, 0, 5], [1, 0, 5], [0, 1, 5]]]))
    origins = np.array([[0.5, 0.5 - 1e-12, 0], [0.5, 0.5, 0], [0.5, 0.5 + 1e-12, 0]])
    assert mesh.any(origins, [0, 0, 1]).tolist() == [True, True, False]
    assert mesh.any(origins.astype(np.float32), np.float32([0, 0, 1])).tolist() == [True, True, True]
    assert mesh.contains(origins, assume_closed=True).tolist() == [False] * 3


def test_empty():
    nothing = intertri.Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), int))
    assert len(nothing) == 0 and nothing.bounds is None
    assert nothing.closest([0, 0, 0], [0, 0, 1])["triangle"] == -1
    mesh = intertri.Mesh(*box())
    none = np.zeros((0, 3))
    assert mesh.closest(none, none).shape == (0,) and mesh.any(none, [0, 0, 1]).shape == (0,)
    assert mesh.all(none, none).offsets.tolist() == [0] and len(mesh.all(none, none).hits) == 0
    assert mesh.crossings(none, none).offsets.tolist() == [0]
    assert mesh.contains(none).shape == (0,) and mesh.closest([], []).shape == (0,)
    assert mesh.closest(np.zeros((4, 0, 3)), [0, 0, 1]).shape == (4, 0)
