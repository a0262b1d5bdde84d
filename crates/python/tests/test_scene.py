"""Tests that a scene of instances returns the same results as a single mesh of all its triangles."""

import copy
import os
import pickle
import signal

import intertri
import numpy as np
import pytest
from conftest import box, camera, icosphere


def placed(mesh, matrix):
    """Returns the triangles of an instance, transformed as documented."""
    x, y, z = np.moveaxis(mesh.triangles.astype(np.float64), -1, 0)
    return np.stack([((row[0] * x + row[1] * y) + row[2] * z) + row[3] for row in np.asarray(matrix)[:3]], axis=-1)


def matrices(rng, count):
    """Returns random matrices that rotate, shear, and scale, except that every fourth matrix is a reflection."""
    all = np.tile(np.eye(4), (count, 1, 1))
    all[:, :3, :3] = rng.uniform(-1, 1, (count, 3, 3)) * rng.choice([0.1, 1, 3], (count, 1, 1))
    all[:, :3, 3] = rng.uniform(-3, 3, (count, 3))
    all[::4, :3, :3] = np.diag([1.0, -1.0, 1.0])
    return all


def rays(rng, corners, count):
    origins = rng.uniform(-5, 5, (count, 3))
    targets = corners.reshape(-1, 3)[rng.integers(3 * len(corners), size=count)]
    targets[::3] = rng.uniform(-3, 3, targets[::3].shape)
    return origins, targets - origins


def check(scene, instances, rng):
    """Compares all query results with those of a single mesh of all triangles. `instances` is {number: (mesh, matrix)}."""
    numbers = sorted(instances)
    parts = [placed(*instances[number]) for number in numbers]
    flat = intertri.Mesh(np.concatenate(parts))
    first = np.cumsum([0] + [len(part) for part in parts])
    origins, ways = rays(rng, flat.triangles, 3000)

    def same(found, truth):
        is_hit = truth["triangle"] >= 0
        which = np.searchsorted(first, truth["triangle"], side="right") - 1
        assert (found["triangle"][is_hit] == (truth["triangle"] - first[which])[is_hit]).all()
        assert (found["instance"] == np.where(is_hit, np.array(numbers)[which], -1)).all()
        assert (found["triangle"][~is_hit] == -1).all()
        for field in "tuv":
            assert (found[field] == truth[field]).all()

    closest = scene.closest(origins, ways)
    same(closest, flat.closest(origins, ways))
    assert 500 < (closest["triangle"] >= 0).sum()
    assert (scene.any(origins, ways) == flat.any(origins, ways)).all()
    for found, truth in [(scene.all(origins, ways), flat.all(origins, ways)),
                         (scene.crossings(origins, ways), flat.crossings(origins, ways))]:
        assert (found.offsets == truth.offsets).all()
        same(found.hits, truth.hits)
        if "leaves" in truth.hits.dtype.names:
            assert (found.hits["leaves"] == truth.hits["leaves"]).all()
    points = np.concatenate([origins[:500], rng.choice(flat.triangles.reshape(-1, 3), 200)])
    for radius in (np.inf, 0.5):
        near, truth = scene.closest_point(points, radius=radius), flat.closest_point(points, radius=radius)
        found = truth["triangle"] >= 0
        which = np.searchsorted(first, truth["triangle"], side="right") - 1
        assert (near["instance"] == np.where(found, np.array(numbers)[which], -1)).all()
        assert (near["triangle"] == np.where(found, truth["triangle"] - first[which], -1)).all()
        for field in ("distance", "x", "y", "z", "u", "v"):
            assert np.array_equal(near[field], truth[field], equal_nan=True)
    assert (scene.winding_number(points) == flat.winding_number(points, assume_closed=True)).all()
    assert (scene.contains(points) == flat.contains(points, assume_closed=True)).all()
    for threads in (1, 2):
        assert (scene.closest(origins, ways, threads=threads) == closest).all()


def test_a_scene_answers_as_the_mesh_of_its_triangles(rng):
    vertices, faces = icosphere(2)
    meshes = [intertri.Mesh(vertices.astype(np.float32), faces), intertri.Mesh(*box())]
    scene, instances = intertri.Scene(), {}
    for i, matrix in enumerate(matrices(rng, 12)):
        instances[scene.add(meshes[i % 2], matrix)] = meshes[i % 2], matrix
    scene.commit()
    assert len(scene) == 12 and repr(scene) == "Scene(12 instances)"
    check(scene, instances, rng)

    # Move several instances in one call, remove one, and hide one. Nothing changes before the commit.
    before = scene.closest([0, 0, -9], [0.01, 0.02, 1])
    moved = matrices(rng, 5)
    scene.place(np.arange(5), moved)
    scene.remove(7)
    scene.hide(8)
    assert scene.closest([0, 0, -9], [0.01, 0.02, 1]) == before
    scene.commit()
    for number, matrix in enumerate(moved):
        instances[number] = instances[number][0], matrix
    hidden = instances.pop(8)
    del instances[7]
    check(scene, instances, rng)
    scene.show(8)
    scene.commit(threads=1)
    check(scene, instances | {8: hidden}, rng)


def test_queries_see_what_shares_a_bit_with_their_mask(rng):
    scene, mesh = intertri.Scene(), intertri.Mesh(*box())
    placements = matrices(rng, 8)
    instances = {scene.add(mesh, matrix): (mesh, matrix) for matrix in placements}
    for number in instances:
        scene.set_mask(number, 1 << number % 2)
    scene.commit()
    odd = intertri.Scene()
    numbers = {odd.add(mesh, placements[number]): number for number in range(1, 8, 2)}
    odd.commit()
    origins, ways = rays(rng, np.concatenate([placed(*pair) for pair in instances.values()]), 1000)
    seen, alone = scene.closest(origins, ways, mask=0b10), odd.closest(origins, ways)
    assert (seen["t"] == alone["t"]).all() and (seen["triangle"] >= 0).sum() > 50
    renamed = np.array([numbers.get(number, -1) for number in range(-1, 4)])
    assert (seen["instance"] == renamed[alone["instance"] + 1]).all()
    assert (scene.any(origins, ways, mask=0b10) == odd.any(origins, ways)).all()
    assert (scene.all(origins, ways, mask=0b10).offsets == odd.all(origins, ways).offsets).all()
    assert (scene.crossings(origins, ways, mask=0b10).offsets == odd.crossings(origins, ways).offsets).all()
    near, truth = scene.closest_point(origins, mask=0b10), odd.closest_point(origins)
    assert (near["distance"] == truth["distance"]).all()
    assert (scene.contains(origins, mask=0b10) == odd.contains(origins)).all()
    assert not scene.any(origins, ways, mask=0b100).any() and not scene.any(origins, ways, mask=0).any()
    for wrong, error in [(-1, ValueError), (1 << 32, ValueError), (1.0, TypeError), (True, TypeError)]:
        with pytest.raises(error, match="mask"):
            scene.any(origins, ways, mask=wrong)
        with pytest.raises(error, match="mask"):
            scene.set_mask(0, wrong)


def test_shapes_are_as_of_a_mesh():
    scene = intertri.Scene()
    assert not scene.any([0, 0, 0], [0, 0, 1]) and scene.closest([0, 0, 0], [0, 0, 1])["instance"] == -1
    scene.add(intertri.Mesh(*box()))
    scene.commit()
    assert scene.closest(np.zeros((2, 3, 3)), [0, 0, 1]).shape == (2, 3)
    out = np.empty(4, intertri.SCENE_HIT)
    assert scene.closest(np.zeros((4, 3)), [0, 0, 2.0], out=out) is out
    assert (out["t"] == 0.5).all() and out["leaves"].all()


def test_errors_say_what_to_do():
    scene, mesh = intertri.Scene(), intertri.Mesh(*box())
    number = scene.add(mesh, np.eye(4)[:3])
    bad = np.eye(4)
    bad[1, 2] = np.nan
    for wrong, message in [(bad, "finite"), (np.eye(3), r"shape \(3, 3\)"), (2 * np.eye(4), "fourth row")]:
        with pytest.raises(ValueError, match=message):
            scene.add(mesh, wrong)
        with pytest.raises(ValueError, match=message):
            scene.place(number, wrong)
    for call in (scene.remove, scene.hide, lambda number: scene.place(number, np.eye(4))):
        for missing in (5, -1):
            with pytest.raises(IndexError, match=f"no instance {missing}"):
                call(missing)
    with pytest.raises(TypeError, match="must be an intertri.Mesh"):
        scene.add(box())
    with pytest.raises(ValueError, match="one for each"):
        scene.place([number, number], np.eye(4))


def test_nodes_of_trimesh_become_instances(rng):
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=2)
    theirs = trimesh.Scene()
    for matrix in matrices(rng, 6):
        theirs.add_geometry(ball, geom_name="ball", transform=matrix)
    scene = intertri.Scene(theirs)
    assert len(scene) == 6
    nodes = [theirs.graph[node] for node in theirs.graph.nodes_geometry]
    meshes = {name: intertri.Mesh(theirs.geometry[name]) for _, name in nodes}
    check(scene, {i: (meshes[name], matrix) for i, (matrix, name) in enumerate(nodes)}, rng)


def saved_scene(rng):
    """Returns an uncommitted scene with a gap in its instance numbers, and a dict of its instances."""
    meshes = [intertri.Mesh(*box()), intertri.Mesh(box()[0].astype(np.float32) * np.float32(0.7), box()[1])]
    scene, instances = intertri.Scene(), {}
    for i, matrix in enumerate(matrices(rng, 10)):
        instances[scene.add(meshes[i % 2], matrix)] = meshes[i % 2], matrix
    scene.remove(3)
    del instances[3]
    scene.set_mask(5, 0b10)
    return scene, instances


def test_saved_scenes_come_back(rng, tmp_path):
    scene, instances = saved_scene(rng)
    # Uncommitted changes are saved.
    scene.save(tmp_path / "a.scene")
    loaded = intertri.Scene.load(tmp_path / "a.scene")
    scene.commit()
    assert len(loaded) == 9
    for other in (loaded, pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)):
        assert type(other) is intertri.Scene
        check(other, instances, np.random.default_rng(1))
        assert other.any([0, 0, -9], [0, 0, 1], mask=0b01) == scene.any([0, 0, -9], [0, 0, 1], mask=0b01)
        # Adding a mesh to the copy reuses the free number and leaves the original scene unchanged.
        assert other.add(intertri.Mesh(*box())) == 3
        assert len(scene) == 9
    again = tmp_path / "b.scene"
    scene.save(again)
    assert again.read_bytes() == (tmp_path / "a.scene").read_bytes()


def test_instances_share_their_mesh_in_a_file(tmp_path):
    mesh, scene = intertri.Mesh(*icosphere(3)), intertri.Scene()
    sizes = []
    for count in (1, 101):
        while len(scene) < count:
            scene.add(mesh)
        scene.save(tmp_path / "a.scene")
        sizes.append((tmp_path / "a.scene").stat().st_size)
    assert 100 * 104 <= sizes[1] - sizes[0] < 100 * 104 + 128


def test_damaged_scenes_are_value_errors(rng, tmp_path):
    scene, _ = saved_scene(rng)
    path = tmp_path / "a.scene"
    scene.save(path)
    good = path.read_bytes()
    for place in range(0, len(good), 37):
        for bytes in (good[:place], good[:place] + b"%c" % (good[place] ^ 4) + good[place + 1 :]):
            path.write_bytes(bytes)
            with pytest.raises(ValueError, match="a.scene: ") as error:
                intertri.Scene.load(path)
            assert "\n" not in str(error.value)
    path.write_bytes(good + b"x")
    with pytest.raises(ValueError, match="followed by more bytes"):
        intertri.Scene.load(path)
    with pytest.raises(FileNotFoundError):
        intertri.Scene.load(tmp_path / "b.scene")


def test_several_meshes_become_instances(rng):
    a, b = intertri.Mesh(*icosphere(2)), intertri.Mesh(box()[0] + [0.5, 0, 2], box()[1])
    scene = intertri.Scene([a, b, a])
    check(scene, dict(enumerate([(a, np.eye(4)), (b, np.eye(4)), (a, np.eye(4))])), rng)
    assert len(intertri.Scene([])) == 0
    for wrong in (a, 5, "a"):
        with pytest.raises(TypeError, match="must be a trimesh.Scene or a list of meshes"):
            intertri.Scene(wrong)


def test_meshes_of_other_packages_become_instances(rng):
    trimesh = pytest.importorskip("trimesh")
    ball, cube = trimesh.creation.icosphere(2), trimesh.creation.box()
    cube.apply_translation([0.5, 0, 2])
    scene = intertri.Scene([ball, cube, ball])
    meshes = [intertri.Mesh(ball), intertri.Mesh(cube)]
    check(scene, {0: (meshes[0], np.eye(4)), 1: (meshes[1], np.eye(4)), 2: (meshes[0], np.eye(4))}, rng)


def test_geometries_of_open3d_become_instances(rng):
    o3d = pytest.importorskip("open3d")
    ball, cube = o3d.geometry.TriangleMesh.create_sphere(1.0, 10), o3d.geometry.TriangleMesh.create_box()
    cube.translate([0.5, 0, 2])
    scene = intertri.Scene([ball, cube])
    check(scene, {0: (intertri.Mesh(ball), np.eye(4)), 1: (intertri.Mesh(cube), np.eye(4))}, rng)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="os.fork is not available")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_loads_scenes_that_need_threads():
    saved = pickle.dumps(intertri.Scene([intertri.Mesh(*icosphere(3))] * 1000))
    assert len(pickle.loads(saved)) == 1000
    child = os.fork()
    if child == 0:
        # The parent's thread pool has no threads in the child, so waiting for them would never end.
        signal.alarm(30)
        os._exit(0 if len(pickle.loads(saved)) == 1000 else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_pictures_of_scenes_are_those_of_single_rays(rng):
    """Compares an image, which is traced tile by tile in packets, with rays traced one at a time."""
    scene, _ = saved_scene(rng)
    scene.commit()
    eye, ways = camera(100, [1, 2, 9])
    hits, any_hit = scene.closest(eye, ways), scene.any(eye, ways)
    assert hits.shape == any_hit.shape == (100, 100) and 0 < any_hit.sum() < any_hit.size
    for y, x in np.argwhere(any_hit)[::97].tolist() + [[0, 0], [99, 99]]:
        assert scene.closest(eye, ways[y, x]) == hits[y, x] and scene.any(eye, ways[y, x]) == any_hit[y, x]
