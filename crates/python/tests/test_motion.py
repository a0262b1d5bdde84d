"""Files, motion, and nearest points."""

import math
import threading

import intertri
import numpy as np
import oracle
import pytest
from conftest import box, camera, icosphere


@pytest.fixture
def mesh(dtype):
    vertices, faces = icosphere(3)
    return intertri.Mesh(vertices.astype(dtype), faces)


def hits_of(mesh):
    eye, ways = camera(60, [1, 2, 3])
    return mesh.closest(eye.astype(mesh.dtype), ways.astype(mesh.dtype))


@pytest.mark.parametrize("moved", [0, 528_980.447])
def test_nearest_points_are_right(dtype, rng, moved):
    vertices, faces = icosphere(1)
    mesh = intertri.Mesh((vertices + moved).astype(dtype), faces)
    points = (rng.uniform(-2, 2, (60, 3)) + moved).astype(dtype)
    points[:10], points[10:15] = mesh.vertices[:10], moved
    near = mesh.closest_point(points)
    for point, found in zip(points, near):
        squares = [oracle.squared_distance(triangle, point) for triangle in mesh.triangles]
        assert found["triangle"] == squares.index(min(squares))
        assert math.isclose(found["distance"], math.sqrt(min(squares)), rel_tol=1e-15)
        # The point is rounded, where it is.
        assert np.linalg.norm(found["point"] - point) == pytest.approx(found["distance"], abs=1e-14 + 1e-15 * moved)
    assert (near["distance"][:10] == 0).all()
    signed = mesh.signed_distance(points)
    assert (abs(signed) == near["distance"]).all()
    assert ((signed < 0) == (mesh.contains(points) & (near["distance"] > 0))).all() and (signed < 0).sum() > 3
    assert np.isnan(mesh.signed_distance([math.nan, 0, 0])) and not np.signbit(signed[:10]).any()


def test_radius_and_shapes(dtype):
    mesh = intertri.Mesh(np.array([[[0, 0, 5], [1, 0, 5], [0, 1, 5]]], dtype))
    ask = lambda **radius: int(mesh.closest_point([0.25, 0.25, 7], **radius)["triangle"])
    assert ask() == ask(radius=2) == 0 and ask(radius=1.9) == -1
    none = mesh.closest_point([0.25, 0.25, 7], radius=1)
    assert none["distance"] == math.inf and np.isnan(none["point"]).all()
    assert mesh.closest_point(np.zeros((2, 4, 3))).shape == (2, 4)
    out = np.zeros(5, intertri.NEAREST)
    assert mesh.closest_point(np.zeros((5, 3)), out=out) is out and (out["distance"] == 5).all()
    with pytest.raises(ValueError, match="radius is -1"):
        ask(radius=-1)
    with pytest.raises(ValueError, match="radius is nan"):
        ask(radius=math.nan)
    assert mesh.closest_point([math.nan, 0, 0])["triangle"] == -1


def test_a_saved_mesh_answers_alike(mesh, tmp_path):
    mesh.save(tmp_path / "mesh.npz")
    loaded = intertri.load(tmp_path / "mesh.npz")
    assert loaded.dtype == mesh.dtype and loaded.digest == mesh.digest
    assert (hits_of(loaded) == hits_of(mesh)).all()


def test_bad_files(mesh, tmp_path):
    path = tmp_path / "mesh.npz"
    mesh.save(path)
    whole = path.read_bytes()
    for cut in (0, 1, 10, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:cut])
        with pytest.raises((ValueError, OSError)):
            intertri.load(path)
    for at in range(0, len(whole), len(whole) // 61):
        broken = bytearray(whole)
        broken[at] ^= 0x55
        path.write_bytes(broken)
        try:
            intertri.load(path)
        except (ValueError, IndexError, OSError, NotImplementedError, RuntimeError):
            pass
    np.savez(path, vertices=mesh.vertices, faces=mesh.faces, tree=np.ones(7, np.uint8))
    with pytest.raises(ValueError):
        intertri.load(path)
    np.savez(path, vertices=mesh.vertices)
    with pytest.raises(ValueError, match="holds no mesh"):
        intertri.load(path)
    with pytest.raises(OSError):
        intertri.load(tmp_path / "nothing.npz")


def test_a_tree_of_another_mesh_is_refused(mesh, tmp_path):
    vertices, faces = box()
    other = intertri.Mesh(vertices.astype(mesh.dtype), faces)
    path = tmp_path / "mesh.npz"
    tree = np.frombuffer(other.__reduce__()[1][2], np.uint8)
    np.savez(path, vertices=mesh.vertices, faces=mesh.faces, tree=tree)
    with pytest.raises(ValueError, match="a hierarchy of 12 triangles, not 1280"):
        intertri.load(path)
    other = intertri.Mesh(mesh.vertices.astype(np.float64 if mesh.dtype == np.float32 else np.float32), mesh.faces)
    np.savez(path, vertices=mesh.vertices, faces=mesh.faces, tree=np.frombuffer(other.__reduce__()[1][2], np.uint8))
    with pytest.raises(ValueError, match=f"the saved hierarchy are f{8 * other.dtype.itemsize}"):
        intertri.load(path)


def test_refit_answers_as_a_new_mesh(mesh, rng):
    vertices, faces = mesh.vertices.copy(), mesh.faces
    for twist in (0.0, 0.3, 2.0):
        turned = vertices.astype(float)
        angle = twist * turned[:, 1]
        turned[:, 0], turned[:, 2] = (np.cos(angle) * turned[:, 0] - np.sin(angle) * turned[:, 2],
                                      np.sin(angle) * turned[:, 0] + np.cos(angle) * turned[:, 2])
        turned = turned.astype(mesh.dtype)
        ratio = mesh.refit(turned)
        # Of a tree that was built anew it were 1.
        assert 0 < ratio < 10 and (ratio != 1) == (twist > 0)
        new = intertri.Mesh(turned, faces)
        assert mesh.digest == new.digest and (mesh.vertices == turned).all()
        assert (hits_of(mesh) == hits_of(new)).all() and (hits_of(mesh)["triangle"] >= 0).any()
        assert mesh.contains([0, 0, 0])


def test_refit_errors_change_nothing(mesh):
    before, digest = hits_of(mesh), mesh.digest
    with pytest.raises(ValueError, match="as before"):
        mesh.refit(mesh.vertices[1:])
    bad = mesh.vertices.copy()
    bad[3, 1] = math.nan
    with pytest.raises(ValueError, match="vertex 3 is not finite"):
        mesh.refit(bad)
    if mesh.dtype == np.float32:
        with pytest.raises(TypeError, match="float64"):
            mesh.refit(mesh.vertices * np.float64(1 / 3))
    assert mesh.digest == digest and (hits_of(mesh) == before).all()


def test_queries_while_a_mesh_moves(dtype):
    """Each answer is that of one position, old or new, whole."""
    corners = np.array([[-9, -9, 5], [9, -9, 5], [0, 9, 5]], dtype)
    many = np.concatenate([corners + dtype([0, 0, k]) for k in range(100)])
    mesh = intertri.Mesh(many, np.arange(300).reshape(-1, 3))
    ways, done = np.tile(dtype([0, 0, 1]), (20_000, 1)), threading.Event()

    def move():
        for step in range(60):
            mesh.refit(many + dtype([0, 0, step % 2]))
        done.set()

    mover = threading.Thread(target=move)
    mover.start()
    seen = set()
    while not done.is_set():
        found = np.unique(mesh.closest([0, 0, 0], ways, threads=1)["t"])
        assert len(found) == 1
        seen.add(float(found[0]))
    mover.join()
    assert seen <= {5.0, 6.0}
