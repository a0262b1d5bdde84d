"""Tests that invalid arguments raise an error that states the problem, and never crash the
process."""

import math

import intertri
import numpy as np
import pytest
from conftest import box

MESH = intertri.Mesh(*box())


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "says"),
    [
        (np.zeros((4, 2)), [[0, 1, 2]], ValueError, r"vertices has shape \(4, 2\); it must be \(n, 3\)"),
        (np.zeros(9), [[0, 1, 2]], ValueError, "vertices has shape"),
        (np.zeros((4, 3)), [[0, 1, 2, 3]], ValueError, r"faces has shape \(1, 4\).*triangles"),
        (np.zeros((4, 3)), [0, 1, 2], ValueError, "faces has shape"),
        (np.zeros((4, 3)), [[0.0, 1, 2]], TypeError, "faces has dtype float64"),
        (np.zeros((4, 3)), [[0, 1, 4]], IndexError, r"face 0 is \[0, 1, 4\], but there are 4 vertices"),
        (np.zeros((4, 3)), [[0, 1, 2], [0, -1, 2]], IndexError, r"face 1 is \[0, -1, 2\]"),
        (np.zeros((4, 3)), np.full((1000000, 3), 7), IndexError, "1000000 faces are out of range"),
        (np.zeros((4, 3)), np.array([[2**64 - 1, 0, 1]], np.uint64), IndexError, "out of range|but there are"),
        ([[0, 0, math.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], ValueError, "vertex 0 is not finite"),
        ([[0, 0, 0], [1, 0, math.inf], [0, 1, 0]], [[0, 1, 2]], ValueError, "vertex 1 is not finite"),
        (np.zeros((4, 3), complex), [[0, 1, 2]], TypeError, "complex128"),
        (np.zeros((4, 3), np.longdouble), [[0, 1, 2]], TypeError, "longdouble|float128"),
        (np.zeros((4, 3), object), [[0, 1, 2]], TypeError, "object"),
        ([["a", "b", "c"]], [[0, 0, 0]], TypeError, "dtype"),
        (np.array([[2**60 + 1, 0, 0]]), [[0, 0, 0]], ValueError, "2\\*\\*53"),
        (np.array([[0, -(2**53) - 1, 0]]), [[0, 0, 0]], ValueError, "2\\*\\*53"),
        (np.zeros((4, 3)), None, ValueError, r"\(m, 3, 3\)"),
    ],
)
def test_meshes(vertices, faces, error, says):
    with pytest.raises(error, match=says):
        intertri.Mesh(vertices, faces)


@pytest.mark.parametrize(
    ("arguments", "options", "error", "says"),
    [
        (([0, 0], [0, 0, 1]), {}, ValueError, r"origins has shape \(2,\)"),
        ((np.zeros((4, 3)), np.zeros((5, 3))), {}, ValueError, "do not fit"),
        ((np.zeros((4, 7)),), {}, ValueError, r"\(\.\.\., 6\) or \(\.\.\., 8\)"),
        ((5.0, [0, 0, 1]), {}, ValueError, "origins has shape"),
        ((np.zeros((4, 3), complex), [0, 0, 1]), {}, TypeError, "complex128"),
        (([0, 0, None], [0, 0, 1]), {}, TypeError, "object"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"t_max": [1, 2, 3]}, ValueError, "t_max has shape"),
        ((np.zeros((4, 8)),), {"t_max": 3}, ValueError, "their own"),
        ((np.zeros((4, 8)),), {"t_min": np.zeros(4)}, ValueError, "their own"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"mode": "fast"}, ValueError, "fast.* is neither"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"threads": 0}, ValueError, "threads is 0"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"threads": -1}, ValueError, "threads is -1"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"threads": 10**30}, ValueError, "threads is 10"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"threads": 1.5}, TypeError, "threads must be an integer"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"out": np.zeros(4)}, TypeError, "out has dtype"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"out": np.zeros(5, intertri.HIT)}, ValueError, "out has shape"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"out": np.zeros(8, intertri.HIT)[::2]}, ValueError, "contiguous"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"out": [0] * 4}, TypeError, "numpy array"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"dtype": np.float32}, TypeError, r"float32.*; it must be intertri\.HIT or intertri\.HIT32"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"dtype": "HIT32"}, TypeError, "dtype is HIT32; it must be"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"dtype": intertri.HIT32, "out": np.zeros(4, intertri.HIT)}, TypeError, "pass only one"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"dtype": intertri.HIT, "out": np.zeros(4, intertri.HIT32)}, TypeError, "pass only one"),
        ((np.zeros((4, 3)), [0, 0, 1]), {"out": np.zeros(5, intertri.HIT32)}, ValueError, "out has shape"),
    ],
)
def test_rays(arguments, options, error, says):
    with pytest.raises(error, match=says):
        MESH.closest(*arguments, **options)


def test_out_must_be_writeable():
    out = np.zeros(1, intertri.HIT)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="writeable"):
        MESH.closest([[0, 0, 5]], [0, 0, -1], out=out)


def test_out_that_is_the_input_is_refused():
    memory = np.zeros(4 * 4, np.float64)
    out = memory.view(intertri.HIT)
    with pytest.raises(ValueError, match="shares memory"):
        MESH.closest(memory[:12].reshape(4, 3), [0, 0, 1], out=out)


def test_limits():
    with pytest.raises(ValueError, match="limit is -1"):
        MESH.all([0, 0, 5], [0, 0, -1], limit=-1)
    assert len(MESH.all([0.1, 0.2, 5], [0, 0, -1], limit=10**30).hits) == 2
    assert len(MESH.all([0.1, 0.2, 5], [0, 0, -1], limit=0).hits) == 0


def test_open_meshes_are_answered():
    vertices, faces = box()
    lid = intertri.Mesh(vertices, faces[1:])
    assert not lid.is_closed and MESH.is_closed
    assert lid.contains([[0, 0, 0], [0, 0, 3]]).tolist() == [True, False]
    assert lid.contains([[0, 0, 0]], assume_closed=True).shape == (1,)
    with pytest.raises(ValueError, match=r"points has shape \(2,\)"):
        MESH.contains([0, 0])


def test_the_mesh_keeps_its_own():
    vertices, faces = box()
    mesh = intertri.Mesh(vertices, faces)
    digest = mesh.digest
    vertices[:] = 7
    faces[:] = 0
    assert mesh.contains([0, 0, 0]) and mesh.digest == digest == intertri.Mesh(*box()).digest
    assert digest == "c5c7f9926185fb20e39c10c404009c3520014531a8bad149a0fadc1685016890"
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1
