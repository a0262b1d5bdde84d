"""Tests inputs from other packages, and error messages that say what to pass instead."""

from types import SimpleNamespace

import intertri
import numpy as np
import pytest
from conftest import box, icosphere

VERTICES, FACES = box()
DIGEST = intertri.Mesh(VERTICES, FACES).digest


class Tensor:
    """A tensor that NumPy can read only through DLPack."""

    def __init__(self, array, device="cpu"):
        self._array, self._device = array, device

    def __dlpack__(self, **options):
        if self._device != "cpu":
            raise BufferError("cannot export from another device")
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()

    def numpy(self):
        raise TypeError(f"can't convert {self._device} device type tensor to numpy\nand more")


class OwnNumpy:
    """A tensor like Open3D's: quick to convert with its own `numpy`, but slow through DLPack or row by row."""

    by_dlpack = False

    def __init__(self, array):
        self._array = array

    def numpy(self):
        return self._array

    def __dlpack__(self, **options):
        # With a real tensor, reading through DLPack may take seconds.
        OwnNumpy.by_dlpack = True
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()

    def __len__(self):
        return len(self._array)

    def __getitem__(self, row):
        raise AssertionError("read row by row")


@pytest.mark.parametrize("tensor", [Tensor, OwnNumpy])
def test_tensors_are_taken(tensor):
    mesh = intertri.Mesh(tensor(VERTICES), tensor(FACES.astype(np.int32)))
    assert mesh.digest == DIGEST
    origins, ways = np.float32([[0.1, 0.2, 5]]), np.float32([[0, 0, -1]])
    assert mesh.closest(tensor(origins), tensor(ways))["t"] == mesh.closest(origins, ways)["t"] == 4
    assert mesh.contains(tensor(origins)).tolist() == [False] and not OwnNumpy.by_dlpack


def test_tensors_on_a_device_say_what_to_do():
    with pytest.raises(TypeError, match="vertices is a Tensor that numpy cannot read: can't convert cuda") as raised:
        intertri.Mesh(Tensor(VERTICES, "cuda"), FACES)
    assert "\n" not in str(raised.value)


def test_meshes_of_others_are_taken():
    quads = np.concatenate([np.full((len(FACES), 1), 3), FACES], axis=1).reshape(-1)
    for mesh in [
        SimpleNamespace(vertices=VERTICES, faces=FACES),
        SimpleNamespace(vertices=VERTICES, triangles=FACES),
        SimpleNamespace(vertex=SimpleNamespace(positions=OwnNumpy(VERTICES)), triangle=SimpleNamespace(indices=Tensor(FACES))),
        SimpleNamespace(points=VERTICES, cells_dict={"line": [[0, 1]], "triangle": FACES}),
        SimpleNamespace(points=VERTICES, faces=quads, is_all_triangles=True),
        intertri.Mesh(VERTICES, FACES),
    ]:
        assert intertri.Mesh(mesh).digest == DIGEST


def test_meshes_of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.creation.icosphere(2)
    assert len(intertri.Mesh(mesh)) == len(mesh.faces)
    with pytest.raises(TypeError, match="scene.to_mesh"):
        intertri.Mesh(trimesh.Scene(mesh))


def test_meshes_of_pyvista():
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.Sphere()
    ours = intertri.Mesh(mesh)
    assert len(ours) == mesh.n_cells and ours.dtype == mesh.points.dtype
    with pytest.raises(ValueError, match="triangulate"):
        intertri.Mesh(pyvista.Cube())
    with pytest.raises(TypeError, match="extract_surface"):
        intertri.Mesh(pyvista.ImageData(dimensions=(2, 2, 2)))


def test_meshes_of_meshio():
    meshio = pytest.importorskip("meshio")
    assert intertri.Mesh(meshio.Mesh(VERTICES, [("triangle", FACES)])).digest == DIGEST
    with pytest.raises(ValueError, match="not triangles .tetra"):
        intertri.Mesh(meshio.Mesh(VERTICES, [("tetra", [[0, 1, 2, 4]])]))


@pytest.mark.parametrize(
    ("ask", "error", "says"),
    [
        (lambda mesh: intertri.Mesh(), TypeError, "Mesh needs vertices and faces"),
        (lambda mesh: intertri.Mesh("x.obj"), TypeError, "not the path 'x.obj'; to read a model, call Mesh.read"),
        (lambda mesh: intertri.Mesh("x.obj", FACES), TypeError, "vertices is 'x.obj'; it must be an array"),
        (lambda mesh: intertri.Mesh([[0, 0, 0], [1]], FACES), ValueError, "vertices has rows of different lengths"),
        (lambda mesh: intertri.Mesh(np.ma.masked_less(VERTICES, 0), FACES), ValueError, "vertices has masked entries"),
        (lambda mesh: mesh.any(np.ma.masked_less(VERTICES, 0), [0, 0, 1]), ValueError, "origins has masked entries"),
        (lambda mesh: mesh.closest_point(VERTICES, radius=np.ones(8)), TypeError, "radius must be one number"),
    ],
)
def test_messages(ask, error, says):
    with pytest.raises(error, match=says):
        ask(intertri.Mesh(VERTICES, FACES))


def test_models_are_no_saved_meshes(tmp_path):
    (tmp_path / "x.obj").write_text("v 0 0 0\n")
    with pytest.raises(ValueError, match="x.obj contains no mesh: .*Mesh.read"):
        intertri.load(tmp_path / "x.obj")


def test_what_is_wrong_with_a_mesh_is_told():
    """Inspects meshes with a missing, flipped, or duplicated face. The last mesh also has a flipped
    duplicate."""
    turned = FACES[:1, ::-1]
    cases = [
        (FACES[1:], "open", "3 edges belong to only one triangle, the first at triangle"),
        (np.concatenate([turned, FACES[1:]]), "turned", "3 edges lie between triangles with opposite orientations"),
        (np.concatenate([FACES, FACES[:1]]), "uneven", "1 triangle repeats another the same way round: triangle"),
        (np.concatenate([FACES, FACES[:1], turned]), "opposed", "1 triangle repeats another the other way round"),
    ]
    for faces, defect, says in cases:
        report = intertri.Mesh(VERTICES, faces).inspect()
        assert says in report["text"] and report[defect] in (1, 3), report
    assert intertri.Mesh(VERTICES, FACES).inspect()["text"] == "closed"


def test_defects_are_listed(dtype):
    """Expects each edge as a pair of vertices in the direction of its first face, and each repeated
    face with its earlier copy."""
    # The slanted face is missing, the second face is flipped, and the first face appears twice
    # more, once flipped.
    faces = [[0, 2, 1], [1, 0, 3], [0, 3, 2], [2, 1, 0], [0, 1, 2]]
    mesh = intertri.Mesh(np.array(VERTICES, dtype)[:4], faces)
    defects, report = mesh.defects(), mesh.inspect()
    assert {defect: rows.tolist() for defect, rows in defects.items()} == {
        "open": [[3, 1], [3, 2]],
        "turned": [[0, 3]],
        "uneven": [[2, 1], [1, 0]],
        "doubled": [[3, 0]],
        "opposed": [[4, 0]],
    }
    for defect, rows in defects.items():
        assert rows.shape == (report[defect], 2) and rows.dtype == np.int64
    for rows in intertri.Mesh(np.array(VERTICES, dtype), FACES).defects().values():
        assert rows.shape == (0, 2) and rows.dtype == np.int64


def test_turned_faces_are_turned_back(dtype):
    """Checks that orient restores the flipped faces of a sphere, even if the sphere has a hole."""
    vertices, faces = icosphere(2)
    damaged = faces.copy()
    turned = np.random.default_rng(5).permutation(len(faces))[:40]
    damaged[turned] = damaged[turned][:, [0, 2, 1]]

    class Named(intertri.Mesh):
        """A subclass with its own constructor."""

        def __init__(self, name, faces):
            self.name = name
            super().__init__(vertices.astype(dtype), faces)

    mesh = Named("globe", damaged)
    assert mesh.inspect()["turned"] > 0 and not mesh.is_closed
    mended = mesh.orient(threads=1)
    assert type(mended) is Named and mended.dtype == dtype and mended.is_closed
    assert np.array_equal(mended.faces, faces) and np.array_equal(mesh.faces, damaged)
    assert mended.winding_number([0, 0, 0]) == 1
    hole = Named("hole", damaged[1:]).orient()
    assert np.array_equal(hole.faces, faces[1:]) and hole.inspect()["turned"] == 0
    assert len(hole.defects()["open"]) == 3
    assert len(intertri.Mesh(np.zeros((1, 3)), np.zeros((0, 3), int)).orient()) == 0


def test_repr():
    assert repr(intertri.Mesh(np.zeros((1, 3)), np.zeros((0, 3), int))) == "Mesh(0 faces, 1 vertex, float64)"


def test_points_and_normals_of_hits(dtype):
    vertices, faces = icosphere(2)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    rays = np.random.default_rng(3).uniform(-2, 2, (100, 6)).astype(dtype)
    hits = mesh.closest(rays)
    is_hit = hits["triangle"] >= 0
    points, normals = mesh.hit_points(hits), mesh.hit_normals(hits)
    on_rays = rays[:, :3] + hits["t"][:, None] * rays[:, 3:].astype(float)
    assert np.allclose(points[is_hit], on_rays[is_hit], rtol=0, atol=1e-14) and is_hit.any()
    assert np.isnan(points[~is_hit]).all() and np.isnan(normals[~is_hit]).all() and not is_hit.all()
    assert np.allclose(np.linalg.norm(normals[is_hit], axis=1), 1)
    assert ((normals * points).sum(axis=1)[is_hit] > 0.9).all()
    one = mesh.closest(rays[is_hit][0])
    assert mesh.hit_points(one).shape == mesh.hit_normals(one).shape == (3,)
    with pytest.raises(TypeError, match="hits has dtype"):
        mesh.hit_points(points)
