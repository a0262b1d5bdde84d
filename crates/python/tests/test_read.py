"""Tests `Mesh.read`, which reads model files with the loaders of the command-line program."""

import gzip
import pickle
import struct
import warnings

import intertri
import numpy as np
import pytest

OBJ = "v 0.1 0 0\nv 1 0 0\nv 0 1 0\nv 1e-300 2 0\nf 1 2 3\nf 2 4 3\n"
PLY = """ply
format ascii 1.0
element vertex 4
property double x
property double y
property double z
element face 2
property list uchar int vertex_indices
end_header
0.1 0 0
1 0 0
0 1 0
1e-300 2 0
3 0 1 2
3 1 3 2
"""
VERTICES = [[0.1, 0, 0], [1, 0, 0], [0, 1, 0], [1e-300, 2, 0]]


@pytest.fixture(autouse=True)
def no_other_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("name", ["a.obj", "a.OBJ", "a.ply", "a.obj.gz", "no_ending"])
def test_coordinates_are_those_of_the_file(tmp_path, name):
    text = PLY if "ply" in name else OBJ
    path = write(tmp_path / name, gzip.compress(text.encode()) if name.endswith("gz") else text)
    for given in (path, str(path)):
        mesh = intertri.Mesh.read(given)
        assert mesh.dtype == np.float64 and mesh.vertices.tolist() == VERTICES
        assert mesh.faces.tolist() == [[0, 1, 2], [1, 3, 2]] and mesh.faces.dtype == np.uint32
        assert mesh.closest([0.4, 0.4, 1], [0, 0, -1], threads=1)["triangle"] == 0
    assert not mesh.vertices.flags.writeable and pickle.loads(pickle.dumps(mesh)).digest == mesh.digest


def test_floats_of_binary_files_stay_what_they_are(tmp_path):
    numbers = np.float32([[0, 0, 1], [0.1, 0, 0], [1, 0, 0], [0, 1, 0]])
    path = write(tmp_path / "a.stl", bytes(80) + struct.pack("<I", 1) + numbers.tobytes() + bytes(2))
    assert (intertri.Mesh.read(path).vertices == numbers[1:].astype(float)).all()


def test_subclasses_and_threads(tmp_path):
    class Mine(intertri.Mesh):
        pass

    assert type(Mine.read(write(tmp_path / "a.obj", OBJ), threads=2)) is Mine


def test_notes_warn_and_strict_refuses(tmp_path):
    path = write(tmp_path / "a.obj", OBJ + "f 1 2\nf 2 3\n")
    with pytest.warns(UserWarning, match=r"a.obj: faces with fewer than three corners, skipped: 2 .*line 7") as caught:
        assert len(intertri.Mesh.read(path)) == 2
    assert len(caught) == 1 and caught[0].filename == __file__
    with pytest.raises(ValueError, match="a.obj: faces with fewer.*; repair it, or leave out strict=True"):
        intertri.Mesh.read(path, strict=True)
    assert len(intertri.Mesh.read(write(path, OBJ), strict=True)) == 2


def test_vertices_without_a_face_may_be_anything(tmp_path):
    mesh = intertri.Mesh.read(write(tmp_path / "a.obj", "v nan 0 0\n" + OBJ.replace("f 1 2 3\nf 2 4 3", "f 2 3 4")))
    assert np.isnan(mesh.vertices[0, 0]) and np.isfinite(mesh.bounds).all()
    assert mesh.closest([0.4, 0.4, 1], [0, 0, -1])["triangle"] == 0
    mesh.save(tmp_path / "a.npz")
    assert intertri.load(tmp_path / "a.npz").closest([0.4, 0.4, 1], [0, 0, -1])["t"] == 1
    assert mesh.refit(mesh.vertices + 1) > 0 and mesh.closest([1.4, 1.4, 2], [0, 0, -1])["t"] == 1


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", r"a.obj:4: "),
        ("", "a.obj: the file is empty"),
        ("v 0 0 0\n", "no triangle"),
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite"),
    ],
)
def test_files_that_are_no_models(tmp_path, content, says):
    with pytest.raises(ValueError, match=says) as raised:
        intertri.Mesh.read(write(tmp_path / "a.obj", content))
    assert "\n" not in str(raised.value)


def test_files_that_cannot_be_opened(tmp_path):
    with pytest.raises(FileNotFoundError):
        intertri.Mesh.read(tmp_path / "none.obj")
    with pytest.raises(IsADirectoryError):
        intertri.Mesh.read(tmp_path)
