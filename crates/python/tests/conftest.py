"""Meshes and rays that the tests share."""

import numpy as np
import pytest


def icosphere(steps):
    """Returns a sphere of 20 * 4**steps triangles, counter-clockwise as seen from outside."""
    g = (1 + 5**0.5) / 2
    vertices = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g],
                [0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    faces = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
             [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
             [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]
    vertices = np.array(vertices, float)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    faces = np.array(faces)
    for _ in range(steps):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, where = np.unique(edges, axis=0, return_inverse=True)
        middle = vertices[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        ab, bc, ca = (len(vertices) + where.reshape(-1, 3)).T
        a, b, c = faces.T
        vertices = np.concatenate([vertices, middle])
        faces = np.concatenate([np.stack(f, axis=1) for f in
                                ([a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca])])
    return vertices, faces


def box(low=(-1, -1, -1), high=(1, 1, 1)):
    """Returns a box of 12 triangles, counter-clockwise as seen from outside."""
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)], float)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return corners, np.array([face for a, b, c, d in quads for face in ([a, b, c], [a, c, d])])


def camera(size, eye, target=(0, 0, 0), spread=0.6):
    """Returns the rays of an image: the eye (3,), and unit directions (size, size, 3), row by
    row."""
    eye = np.array(eye, float)
    ahead = np.array(target, float) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.3, 1, 0.1])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    x = np.linspace(-spread, spread, size)
    ways = ahead + x[None, :, None] * right + -x[:, None, None] * up
    return eye, ways / np.linalg.norm(ways, axis=-1, keepdims=True)


@pytest.fixture
def rng():
    return np.random.default_rng(12345)


@pytest.fixture(params=[np.float32, np.float64], ids=["f32", "f64"])
def dtype(request):
    return request.param
