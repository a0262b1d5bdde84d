"""Tests the Open3D-compatible scene, comparing it with Open3D's own scene if Open3D is installed."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import box, icosphere
from intertri.open3d import RaycastingScene, Tensor


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


def test_results_have_the_methods_that_scripts_call(scene, rng):
    ask = rays(rng)
    ask[0, 0] = [9, 9, 9, 1, 0, 0]
    ans = scene.cast_rays(ask)
    t = ans["t_hit"]
    hit = t.isfinite()
    assert type(hit) is type(t) is Tensor and (hit.numpy() == np.isfinite(t.numpy())).all()
    # The hit locations, computed as in Open3D's tutorial.
    points = ask[hit][:, :3] + ask[hit][:, 3:] * t[hit].reshape((-1, 1))
    assert points.shape == (hit.numpy().sum(), 3) and t[hit].isfinite().all().item()
    assert t[0].numpy().shape == (40,) and t[0][0].numpy() == math.inf and t[0, 0].item() == math.inf
    assert t[0, 0].isinf() and not t.isnan().any() and ans["geometry_ids"][0][0].cpu() == scene.INVALID_ID
    assert t[hit].max().numpy() < 9 and (t * 2)[0].clone().numpy()[0] == math.inf
    changed = t.clone()
    changed[:] = 0
    assert (changed.numpy() == 0).all() and (t.numpy() != 0).all()
    assert t.T.contiguous().flags.c_contiguous and t.num_elements() == 1200
    for double in (t.to(np.float64), t.to("float64"), t.to(dtype=np.float64), t.to("CPU:0", np.float64)):
        assert type(double) is Tensor and double.dtype == np.float64 and (double == t).all()
    assert t.to("CPU:0").cpu().dtype == np.float32 and t.to("cpu", copy=True).numpy().base is not t
    with pytest.raises(ValueError, match="device is CUDA:0, but answers are computed on the CPU; pass CPU:0"):
        t.to("CUDA:0")


def test_devices():
    scene = RaycastingScene(device="CPU:0", nthreads=2)
    scene.add_triangles(*meshes()[0])
    assert scene.test_occlusions(np.float32([[0, 0, 5, 0, 0, -1]])).all()
    with pytest.raises(ValueError, match="device is SYCL:0"):
        RaycastingScene(device="SYCL:0")


def test_a_scene_in_float64():
    """Traces rays that start a nanometre away from a wall at UTM coordinates."""
    wall = np.array([[528980.85, 183526.1, 0], [528980.85, 183526.1, 3], [528982.3, 183523.55, 0]])
    scene = RaycastingScene()
    scene.add_triangles(*meshes()[0])
    assert scene.cast_rays(np.zeros((1, 6), np.float32))["t_hit"].dtype == np.float32
    scene.add_triangles(wall, np.uint32([[1, 0, 2]]))
    normal = np.cross(wall[1] - wall[0], wall[2] - wall[0])
    normal /= np.linalg.norm(normal)
    start = wall.mean(axis=0) + 1e-9 * normal
    answers = scene.cast_rays([[*start, *normal], [*start, *-normal]] * np.ones(1))
    assert answers["geometry_ids"].tolist() == [scene.INVALID_ID, 1]
    for name in ("t_hit", "primitive_uvs", "primitive_normals"):
        assert answers[name].dtype == np.float64, name
    points = start[None] + normal
    assert scene.compute_closest_points(points)["points"].dtype == scene.compute_distance(points).dtype == np.float64
    assert scene.compute_signed_distance(points).dtype == scene.compute_occupancy(points).dtype == np.float64
    assert scene.list_intersections(np.zeros((1, 6)))["t_hit"].dtype == np.float64
    assert scene.cast_rays(np.float32([[0, 0, 5, 0, 0, -1]]))["geometry_ids"].tolist() == [0]


def test_meshes_are_added_as_they_are():
    vertices, faces = meshes()[1]
    for mesh in [SimpleNamespace(vertices=vertices, faces=faces.astype(np.int64)),
                 SimpleNamespace(vertex=SimpleNamespace(positions=vertices), triangle=SimpleNamespace(indices=faces))]:
        scene = RaycastingScene()
        assert scene.add_triangles(mesh) == 0
        assert scene.count_intersections(np.float32([[2.5, 0.1, 5, 0, 0, -1]])).tolist() == [2]
    with pytest.raises(TypeError, match="add_triangles takes vertex_positions and triangle_indices, or a mesh"):
        RaycastingScene().add_triangles(vertices)


def test_inside_is_where_the_scene_winds_around_or_odd():
    vertices, faces = (array.copy() for array in meshes()[1])
    points = np.float32([[2.5, 0.1, 0.2], [2.5, 0.1, 0.7]])
    scene = RaycastingScene()
    for _ in range(2):
        # In the second round, two copies of the cube coincide.
        scene.add_triangles(vertices, faces)
        assert scene.compute_occupancy(points).tolist() == [1, 0]
    faces[::2] = faces[::2, ::-1]
    scene = RaycastingScene()
    scene.add_triangles(vertices, faces)
    assert scene.compute_occupancy(points).tolist() == [1, 0]
    assert np.sign(scene.compute_signed_distance(points)).tolist() == [-1, 1]
    assert scene.compute_signed_distance(vertices[:1]).tolist() == [0]


def test_tensors_of_open3d_are_answered_by_such():
    o3d = pytest.importorskip("open3d")
    scene = RaycastingScene(device=o3d.core.Device("CPU:0"))
    assert scene.add_triangles(o3d.t.geometry.TriangleMesh.create_box()) == 0
    legacy = RaycastingScene()
    assert legacy.add_triangles(o3d.geometry.TriangleMesh.create_box()) == 0
    ask = o3d.core.Tensor([[0.25, 0.5, -1, 0, 0, 1], [9, 9, 9, 1, 0, 0]], dtype=o3d.core.float32)
    for ans in (scene.cast_rays(ask), scene.list_intersections(ask)):
        assert all(isinstance(value, o3d.core.Tensor) for value in ans.values())
        assert ans["t_hit"].dtype == o3d.core.float32 and ans["geometry_ids"].dtype == o3d.core.uint32
    t = scene.cast_rays(ask)["t_hit"]
    hit = t.isfinite()
    points = ask[hit][:, :3] + ask[hit][:, 3:] * t[hit].reshape((-1, 1))
    assert points.numpy().tolist() == [[0.25, 0.5, 0]]
    assert o3d.t.geometry.PointCloud(points).point.positions.shape == [1, 3]
    assert scene.count_intersections(ask).cpu().numpy().tolist() == [2, 0]
    assert scene.test_occlusions(ask).to(o3d.core.int32)[0] == 1
    assert isinstance(scene.compute_distance(ask[:, :3]), o3d.core.Tensor)
    # NumPy rays give NumPy results, which still accept Open3D's dtypes and devices.
    ours = scene.cast_rays(ask.numpy())["t_hit"].to(o3d.core.float64).to(o3d.core.Device("CPU:0"))
    assert ours.dtype == np.float64 and type(ours) is Tensor
    assert isinstance(scene.create_rays_pinhole(60, *(o3d.core.Tensor(x) for x in ([0., 0, 0], [0., 0, 5], [0., 1, 0])), 8, 8),
                      o3d.core.Tensor)


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
    ours, there = scene.cast_rays(ask), theirs.cast_rays(o3d.core.Tensor(ask))
    assert set(ours) == set(there)
    same = ours["geometry_ids"] == there["geometry_ids"].numpy()
    assert same.mean() > 0.999
    for name in ours:
        theirs_of = there[name].numpy()
        assert ours[name].shape == theirs_of.shape and ours[name].dtype == theirs_of.dtype
        close = np.isclose(ours[name], theirs_of, atol=1e-3) | (ours[name] == theirs_of)
        assert close[same].mean() > 0.995, name
    in_kind = scene.cast_rays(o3d.core.Tensor(ask))
    for name in ours:
        assert in_kind[name].shape == there[name].shape and in_kind[name].dtype == there[name].dtype
        assert (in_kind[name].numpy() == ours[name].numpy()).all()
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
