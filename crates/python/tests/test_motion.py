"""Tests saving and loading meshes, refitting meshes that move, and finding nearest points."""

import base64
import copy
import hashlib
import math
import os
import subprocess
import sys
import threading
import zlib
from pathlib import Path
from types import SimpleNamespace

import intertri
import numpy as np
import oracle
import pytest
from conftest import box, camera, icosphere
from intertri import _archive, _triangles
from intertri._triangles import native


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
        # `hit_points` rounds its results.
        assert np.linalg.norm(mesh.hit_points(found) - point) == pytest.approx(found["distance"], abs=1e-14 + 1e-15 * moved)
    assert (near["distance"][:10] == 0).all()
    signed = mesh.signed_distance(points)
    assert (abs(signed) == near["distance"]).all()
    assert ((signed < 0) == (mesh.contains(points) & (near["distance"] > 0))).all() and (signed < 0).sum() > 3
    assert np.isnan(mesh.signed_distance([math.nan, 0, 0])) and not np.signbit(signed[:10]).any()


def test_triangles_without_area_are_segments_and_points(dtype):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5], [7, 5, 5], [6, 5, 5]], dtype)
    mesh = intertri.Mesh(corners, [[0, 1, 2], [3, 4, 5], [3, 3, 3]])
    near = mesh.closest_point(np.array([[6, 5, 6], [4, 5, 5]], dtype))
    assert near["distance"].tolist() == [1, 1] and near["triangle"].tolist() == [1, 1]
    assert mesh.hit_points(near).tolist() == [[6, 5, 5], [5, 5, 5]]
    assert mesh.signed_distance(np.array([6, 5, 6], dtype), assume_closed=True) == 1
    # A copy returns the same result. The refit then makes a degenerate triangle nondegenerate and
    # another triangle degenerate.
    assert copy.deepcopy(mesh).closest_point(np.array([6, 5, 6], dtype)) == near[0]
    corners[5], corners[1] = [6, 7, 5], [0, 2, 0]
    mesh.refit(corners)
    near = mesh.closest_point(np.array([[6, 6, 6], [0, 1.5, 3]], dtype))
    assert near["distance"].tolist() == [1, 3] and near["triangle"].tolist() == [1, 0]


def test_radius_and_shapes(dtype):
    mesh = intertri.Mesh(np.array([[[0, 0, 5], [1, 0, 5], [0, 1, 5]]], dtype))
    ask = lambda **radius: int(mesh.closest_point([0.25, 0.25, 7], **radius)["triangle"])
    assert ask() == ask(radius=2) == 0 and ask(radius=1.9) == -1
    none = mesh.closest_point([0.25, 0.25, 7], radius=1)
    assert none["distance"] == math.inf and np.isnan(mesh.hit_points(none)).all()
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


# A saved hierarchy of two meshes (a triangle at z = 5 and one at z = 7), made with
# `Bvh::from_meshes` and `to_bytes`.
TWO_MESHES = (
    b"c-rgq3<>h&<&t7zU|?VYVh{}ij10)&N4)?uiU32N#M1+nf@#wjp^6VMplTHDR7+!%Hw*!p=Kzw2iaS8*3}eP{LC+i$W~jXkXy(s+c_YyLw%dD<"
    b"90!uT095{*pjL*E<qLNRuc00{CM3VW0l$2MJrMuLg9*q#aKJAQBq#t36a$d|AK<}Y|KY)unokH2vY)W|pd^PY{9tl08UQ5#&oK"
)


def save_bound(path, vertices, faces, tree):
    """Saves the arrays in the format that `Mesh.save` writes."""
    bound = np.array(_archive.binding(vertices, faces, tree), np.uint64)
    np.savez(path, vertices=vertices, faces=faces, tree=np.frombuffer(tree, np.uint8), binding=bound)


def test_other_files(mesh, tmp_path):
    path = tmp_path / "mesh.npz"
    out_of_range = mesh.faces.copy()
    out_of_range[3, 1] = len(mesh.vertices)
    for vertices, faces, tree, says in [
        (mesh.vertices, mesh.faces, bytes(7), "cut off|not a saved hierarchy"),
        (mesh.vertices.astype(np.float16), mesh.faces, b"", "its members do not have the types"),
        (mesh.vertices, out_of_range, b"", r"face 3 is \["),
    ]:
        save_bound(path, vertices, faces, tree)
        with pytest.raises(ValueError, match=f"mesh.npz contains no mesh: .*({says})"):
            intertri.load(path)
    np.savez(path, vertices=mesh.vertices)
    with pytest.raises(ValueError, match="contains no mesh: it has no member faces and tree"):
        intertri.load(path)
    two, faces = zlib.decompress(base64.b85decode(TWO_MESHES)), np.uint32([[0, 1, 2]] * 2)
    save_bound(path, np.zeros((3, 3), np.float32), faces, two)
    with pytest.raises(ValueError, match="contains no mesh: its tree has 2 meshes instead of one"):
        intertri.load(path)
    np.save(tmp_path / "mesh.npy", mesh.vertices)
    with pytest.raises(ValueError, match="contains no mesh: .*not a file that Mesh.save wrote"):
        intertri.load(tmp_path / "mesh.npy")


def test_a_file_of_the_other_byte_order(mesh, tmp_path):
    mesh.save(tmp_path / "mesh.npz")
    with np.load(tmp_path / "mesh.npz") as saved:
        arrays = {name: saved[name].astype(saved[name].dtype.newbyteorder(">")) for name in saved}
    np.savez(tmp_path / "other.npz", **arrays)
    assert intertri.load(tmp_path / "other.npz").digest == mesh.digest


def test_a_tree_of_another_mesh_is_refused(mesh, tmp_path):
    vertices, faces = box()
    other = intertri.Mesh(vertices.astype(mesh.dtype), faces)
    path = tmp_path / "mesh.npz"
    save_bound(path, mesh.vertices, mesh.faces, other._saved()[2])
    with pytest.raises(ValueError, match="its tree has 12 triangles, not 1280"):
        intertri.load(path)
    other = intertri.Mesh(mesh.vertices.astype(np.float64 if mesh.dtype == np.float32 else np.float32), mesh.faces)
    save_bound(path, mesh.vertices, mesh.faces, other._saved()[2])
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
        # If the triangles have not moved, the ratio is 1.
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


def test_refit_of_some_vertices(mesh, rng):
    moved = mesh.vertices.copy()
    rows = rng.permutation(len(moved))[:50]
    moved[rows] *= mesh.dtype.type(1.25)
    new = intertri.Mesh(moved, mesh.faces)
    assert mesh.refit(moved[rows], indices=rows) > 0
    assert mesh.digest == new.digest and (hits_of(mesh) == hits_of(new)).all() and (mesh.vertices == moved).all()
    # If a vertex is listed twice, its last position wins; an empty list changes nothing.
    mesh.refit([[9, 9, 9], moved[5]], indices=[5, 5])
    mesh.refit(np.zeros((0, 3)), indices=[])
    assert mesh.digest == new.digest
    for indices, error, says in [
        ([len(moved)], IndexError, f"indices has {len(moved)}, but there are {len(moved)} vertices"),
        ([-1], IndexError, "indices has -1"),
        ([0, 1], ValueError, r"vertices has shape \(1, 3\); it must be \(2, 3\), one row for each index"),
        ([0.5], TypeError, "indices has dtype float64"),
        ([[0]], TypeError, r"shape \(1, 1\)"),
    ]:
        with pytest.raises(error, match=says):
            mesh.refit([[0, 0, 0]], indices=indices)
    with pytest.raises(ValueError, match="vertex 7 is not finite"):
        mesh.refit([[0, 0, math.nan]], indices=[7])
    assert mesh.digest == new.digest and (hits_of(mesh) == hits_of(new)).all()


@pytest.fixture
def wall():
    """A float32 wall at z = 1, and a function that returns its vertices at another z."""
    at = lambda z: np.float32([[-9, -9, z], [9, -9, z], [0, 9, z]])
    return intertri.Mesh(at(1), [[0, 1, 2]]), at


class Meanwhile:
    """Forwards calls to `inner`, and calls `does` before returning each result."""

    def __init__(self, inner, does):
        self.inner, self.does = inner, does

    def __call__(self, *args):
        answer = self.inner(*args)
        self.does()
        return answer

    def __getattr__(self, name):
        return Meanwhile(getattr(self.inner, name), self.does)


def test_a_tree_that_is_late_is_not_kept(wall, monkeypatch):
    """Moves the mesh while its float64 hierarchy is being built."""
    mesh, at = wall
    third = 1 / 3  # not a float32
    with monkeypatch.context() as patch:
        patch.setattr(_triangles, "native", lambda dtype: Meanwhile(native(dtype), lambda: mesh.refit(at(2))))
        assert mesh.closest([third, 0, 0], [0, 0, 1])["t"] == 1
    assert mesh.closest([third, 0, 0], [0, 0, 1])["t"] == 2


def test_a_digest_that_is_late_is_not_kept(wall, monkeypatch):
    mesh, at = wall
    before, after = (intertri.Mesh(at(z), mesh.faces).digest for z in (1, 2))
    with monkeypatch.context() as patch:
        make = lambda start: SimpleNamespace(update=(state := hashlib.sha256(start)).update,
                                             hexdigest=Meanwhile(state.hexdigest, lambda: mesh.refit(at(2))))
        patch.setattr(_triangles, "hashlib", SimpleNamespace(sha256=make))
        assert mesh.digest == before
    assert mesh.digest == after


def test_an_open_edge_that_is_late_is_not_kept(monkeypatch):
    vertices, faces = box()
    mesh = intertri.Mesh(vertices[faces])
    torn = mesh.vertices.copy()
    torn[0] += 1
    with monkeypatch.context() as patch:
        patch.setattr(_triangles, "native", lambda dtype: Meanwhile(native(dtype), lambda: mesh.refit(torn)))
        assert mesh.is_closed
    assert not mesh.is_closed


def test_what_is_saved_is_of_one_position(wall):
    mesh, at = wall
    mesh = intertri.Mesh(np.concatenate([at(k) for k in range(1, 3001)]), np.arange(9000).reshape(-1, 3))
    original, done = mesh.vertices, threading.Event()

    def move():
        for step in range(200):
            mesh.refit(original + np.float32([0, 0, step % 2]))
        done.set()

    mover = threading.Thread(target=move)
    mover.start()
    while not done.is_set():
        other = copy.copy(mesh)
        assert other.closest([0, 0, 0], [0, 0, 1])["t"] == other.vertices[0, 2]
    mover.join()


def test_refits_of_two_threads_come_one_after_the_other(wall):
    mesh, at = wall
    other = threading.Thread(target=mesh.refit, args=[at(3)])
    (dtype, tree), = mesh._at.trees.items()
    once = iter([other.start])
    mesh._at.trees[dtype] = Meanwhile(tree, lambda: [(start(), other.join(0.2)) for start in once])
    mesh.refit(at(2))
    other.join()
    assert mesh.closest([0, 0, 0], [0, 0, 1])["t"] == mesh.vertices[0, 2] == 3


NO_MEMORY = """
import numpy as np, intertri, resource, sys
sys.path.insert(0, {tests!r})
from conftest import icosphere
vertices, faces = icosphere(5)
vertices = vertices.astype(np.{dtype})
mesh = intertri.Mesh(vertices, faces)
far = vertices * 2
ray = np.array([[0, 0, 9, 0.01, 0.02, -1]], vertices.dtype)
before, after = mesh.closest(ray), intertri.Mesh(far, faces).closest(ray)
errors = set()
for more in range(1000):
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (more << 16), -1))
    try:
        mesh.refit(far)
        error = None
    except MemoryError as raised:
        error = str(raised)
    resource.setrlimit(resource.RLIMIT_AS, (-1, -1))
    assert (mesh.closest(ray) == (after if error is None else before)).all(), (more, error)
    if error is None:
        break
    errors.add(error)
print(error, errors)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /proc/self/statm")
def test_a_refit_without_memory_changes_nothing(dtype):
    script = NO_MEMORY.format(tests=str(Path(__file__).parent), dtype=dtype.__name__)
    # The allocator must return freed memory to the system at once, so that no refit can reuse it.
    malloc = {"MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "4096", "MALLOC_TRIM_THRESHOLD_": "4096"}
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300,
                         env=os.environ | malloc)
    assert out.returncode == 0 and out.stdout.startswith("None"), out
    assert "refitting needs more memory than is available" in out.stdout, out


def test_queries_while_a_mesh_moves(dtype):
    """Checks that all results of one call reflect the same position of the mesh, either old or
    new."""
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
