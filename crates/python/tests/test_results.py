"""Results in pandas data frames, and misses as NaN."""

import math

import intertri
import numpy as np
import pytest
from conftest import box, icosphere

MESH = intertri.Mesh(*icosphere(2))
RAYS = np.random.default_rng(3).uniform(-2, 2, (100, 6))
POINTS = RAYS[:, :3]
RESULTS = {
    "closest": MESH.closest(RAYS),
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


def test_misses_are_nan_where_asked():
    plain, marked = MESH.closest(RAYS), MESH.closest(RAYS, nan_misses=True)
    miss = plain["triangle"] < 0
    assert miss.any() and not miss.all() and np.isinf(plain["t"][miss]).all()
    for name in ("t", "u", "v"):
        assert np.isnan(marked[name][miss]).all() and (marked[name][~miss] == plain[name][~miss]).all()
    assert (marked["triangle"] == plain["triangle"]).all()
    away, out = [9, 9, 9], np.zeros(1, intertri.HIT)
    assert math.isnan(MESH.closest(away, [0, 0, 1], nan_misses=True)["t"])
    assert np.isnan(MESH.closest([away], [0, 0, 1], nan_misses=True, out=out)["t"]).all() and np.isnan(out["t"]).all()
    near = MESH.closest_point([away, [0, 0, 0]], radius=2, nan_misses=True)
    assert np.isnan(near["distance"]).tolist() == np.isnan(near["u"]).tolist() == [True, False]


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
