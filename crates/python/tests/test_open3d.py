"""The interface of Open3D's scenes; beside Open3D itself where it is installed."""

import numpy as np
import pytest
from conftest import box, icosphere
from intertri.open3d import RaycastingScene


def meshes():
    sphere, cube = icosphere(3), box()
    return [(sphere[0].astype(np.float32), sphere[1].astype(np.uint32)),
            ((cube[0] * 0.5 + [2.5, 0, 0]).astype(np.float32), cube[1].astype(np.uint32))]


def rays(rng):
    origins = rng.uniform(-4, 4, (30, 40, 3))
    targets = rng.uniform([-1, -1, -1], [3, 1, 1], (30, 40, 3))
    return np.concatenate([origins, targets - origins], axis=-1).astype(np.float32)


@pytest.fixture
def scene():
    scene = RaycastingScene()
    for number, (vertices, faces) in enumerate(meshes()):
        assert scene.add_triangles(vertices, faces) == number
    return scene


def test_shapes_and_types(scene, rng):
    hits = scene.cast_rays(rays(rng))
    wanted = {"t_hit": ((), np.float32), "geometry_ids": ((), np.uint32), "primitive_ids": ((), np.uint32),
              "primitive_uvs": ((2,), np.float32), "primitive_normals": ((3,), np.float32)}
    assert set(hits) == set(wanted)
    for name, (last, dtype) in wanted.items():
        assert hits[name].shape == (30, 40, *last) and hits[name].dtype == dtype
        assert type(hits[name].numpy()) is np.ndarray
    miss = hits["geometry_ids"] == scene.INVALID_ID
    assert 0.1 < miss.mean() < 0.9 and {0, 1} <= set(np.unique(hits["geometry_ids"]).tolist())
    assert (np.isinf(hits["t_hit"]) == miss).all() and (hits["primitive_ids"][miss] == scene.INVALID_ID).all()
    assert hits["primitive_ids"][hits["geometry_ids"] == 1].max() < 12
    assert (hits["primitive_normals"][miss] == 0).all()
    assert np.allclose(np.linalg.norm(hits["primitive_normals"][~miss], axis=-1), 1)


def test_one_mesh_and_none(rng):
    scene = RaycastingScene()
    assert (scene.cast_rays(rays(rng))["geometry_ids"] == scene.INVALID_ID).all()
    scene.add_triangles(*meshes()[0])
    hits = scene.cast_rays(rays(rng))
    assert set(np.unique(hits["geometry_ids"]).tolist()) == {0, scene.INVALID_ID}


def test_lists_and_counts(scene, rng):
    ask = rays(rng)
    lists, counts = scene.list_intersections(ask), scene.count_intersections(ask)
    assert counts.dtype == np.int32 and counts.shape == (30, 40)
    assert (np.diff(lists["ray_splits"]) == counts.ravel()).all() and counts.max() >= 4
    assert (np.bincount(lists["ray_ids"], minlength=1200) == counts.ravel()).all()
    hits = scene.cast_rays(ask)
    first = lists["ray_splits"][:-1][counts.ravel() > 0]
    hit = counts > 0
    assert (lists["t_hit"][first] == hits["t_hit"][hit]).all()
    assert (lists["geometry_ids"][first] == hits["geometry_ids"][hit]).all()
    assert (scene.test_occlusions(ask) == (hits["t_hit"] < np.inf)).all()
    assert (scene.test_occlusions(ask, tnear=0.25, tfar=0.5).sum()) < hit.sum()


def test_points(scene, rng):
    points = rng.uniform([-2, -2, -2], [4, 2, 2], (10, 20, 3)).astype(np.float32)
    occupancy, signed = scene.compute_occupancy(points), scene.compute_signed_distance(points, nsamples=3)
    assert occupancy.dtype == np.float32 and set(np.unique(occupancy).tolist()) == {0.0, 1.0}
    assert ((signed < 0) == (occupancy == 1)).all()
    assert (abs(signed) == scene.compute_distance(points)).all()
    near = scene.compute_closest_points(points)
    assert np.allclose(np.linalg.norm(near["points"] - points, axis=-1), abs(signed), atol=1e-6)


def test_errors(scene):
    with pytest.raises(TypeError, match="float64"):
        scene.cast_rays(np.zeros((3, 6)))
    with pytest.raises(ValueError, match=r"\(\.\.\., 6\)"):
        scene.cast_rays(np.zeros((3, 5), np.float32))
    with pytest.raises(IndexError, match="vertex 9"):
        scene.add_triangles(np.zeros((3, 3), np.float32), np.array([[0, 1, 9]], np.uint32))
    with pytest.raises(ValueError, match="odd"):
        scene.compute_occupancy(np.zeros((3, 3), np.float32), nsamples=2)
    with pytest.raises(TypeError, match="create_rays_pinhole takes"):
        scene.create_rays_pinhole(60)


def test_beside_open3d(scene, rng):
    o3d = pytest.importorskip("open3d")
    theirs = o3d.t.geometry.RaycastingScene()
    for vertices, faces in meshes():
        theirs.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(faces))
    ask = rays(rng)
    ours, there = scene.cast_rays(o3d.core.Tensor(ask)), theirs.cast_rays(o3d.core.Tensor(ask))
    assert set(ours) == set(there)
    same = ours["geometry_ids"] == there["geometry_ids"].numpy()
    assert same.mean() > 0.999
    for name in ours:
        theirs_of = there[name].numpy()
        assert ours[name].shape == theirs_of.shape and ours[name].dtype == theirs_of.dtype
        close = np.isclose(ours[name], theirs_of, atol=1e-3) | (ours[name] == theirs_of)
        assert close[same].mean() > 0.995, name
    lists, there = scene.list_intersections(ask), theirs.list_intersections(o3d.core.Tensor(ask))
    assert set(lists) == set(there)
    for name in lists:
        assert lists[name].dtype == there[name].numpy().dtype and lists[name].ndim == there[name].numpy().ndim, name
    points = rng.uniform([-2, -2, -2], [4, 2, 2], (500, 3)).astype(np.float32)
    tensor = o3d.core.Tensor(points)
    assert (scene.compute_occupancy(points) == theirs.compute_occupancy(tensor, nsamples=3).numpy()).mean() > 0.99
    assert np.allclose(scene.compute_distance(points), theirs.compute_distance(tensor).numpy(), atol=1e-5)
    near, there = scene.compute_closest_points(points), theirs.compute_closest_points(tensor)
    assert set(near) == set(there) and all(near[k].shape == there[k].numpy().shape for k in near)
    eye, up, center = (np.float32(x) for x in ([1, 2, 5], [0, 1, 0.1], [0.5, 0, 0]))
    by_angle = dict(fov_deg=50, center=center, eye=eye, up=up, width_px=30, height_px=20)
    assert np.allclose(scene.create_rays_pinhole(**by_angle), theirs.create_rays_pinhole(**by_angle).numpy(), atol=1e-5)
    intrinsic = np.array([[40.0, 0, 15], [0, 42, 10], [0, 0, 1]])
    extrinsic = np.eye(4)
    extrinsic[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    extrinsic[:3, 3] = [0.3, -0.2, 4]
    assert np.allclose(scene.create_rays_pinhole(intrinsic, extrinsic, 30, 20),
                       theirs.create_rays_pinhole(intrinsic, extrinsic, 30, 20).numpy(), atol=1e-5)
