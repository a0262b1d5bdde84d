"""Tests queries at points inside, outside, and on meshes, and checks `contains` in rational arithmetic."""

import intertri
import numpy as np
import oracle
import pytest
from conftest import box, icosphere

WAY = (3, 5, 7)


def test_contains_is_right(dtype, rng):
    vertices, faces = icosphere(1)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    points = rng.uniform(-1.1, 1.1, (150, 3)).astype(dtype)
    points[:42] = mesh.vertices
    points[42:60] = (mesh.triangles[:18, 0] + mesh.triangles[:18, 1]) / 2
    inside = mesh.contains(points)
    for point, is_in in zip(points, inside):
        on = any(oracle.squared_distance(triangle, point) == 0 for triangle in mesh.triangles)
        truth = on or sum(side for _, _, side in oracle.crossings(mesh.triangles, point, WAY)) != 0
        assert is_in == truth
    assert 20 < inside[60:].sum() < 70 and inside[:42].all()


def test_cavities_and_overlaps(dtype):
    outer, faces = box()
    inner = outer * 0.5
    hollow = intertri.Mesh(np.concatenate([outer, inner]).astype(dtype), np.concatenate([faces, faces[:, ::-1] + 8]))
    assert hollow.is_closed
    assert hollow.contains([[0, 0, 0], [0, 0, 0.75], [0, 0, 2], [0, 0, 0.5]]).tolist() == [False, True, False, True]
    twice = intertri.Mesh(np.concatenate([outer, outer + 0.5]).astype(dtype), np.concatenate([faces, faces + 8]))
    assert twice.winding_number([[0.2, 0.2, 0.3], [-0.9, -0.9, -0.9], [3, 0, 0]]).tolist() == [2, 1, 0]
    inside_out = intertri.Mesh(outer.astype(dtype), faces[:, ::-1])
    assert inside_out.winding_number([0, 0, 0]) == -1 and inside_out.contains([0, 0, 0])


def solid_angles(triangles, points):
    """Returns winding numbers from van Oosterom and Strackee's formula, summed over all triangles for each point."""
    a, b, c = (triangles[None, :, k].astype(float) - points[:, None].astype(float) for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    num = (a * np.cross(b, c)).sum(axis=2)
    den = la * lb * lc + (a * b).sum(axis=2) * lc + (b * c).sum(axis=2) * la + (c * a).sum(axis=2) * lb
    return np.arctan2(num, den).sum(axis=1) / (2 * np.pi)


def test_open_meshes_have_winding_numbers(dtype, rng):
    """Even in a mesh with holes, flipped faces, or duplicates, a point is inside if its winding number does not round to 0."""
    vertices, faces = icosphere(2)
    some = rng.uniform(size=len(faces))
    meshes = [faces[some < 0.8], np.where((some < 0.1)[:, None], faces[:, ::-1], faces), np.r_[faces, faces[some < 0.1]]]
    points = rng.uniform(-1.2, 1.2, (400, 3)).astype(dtype)
    for open_faces in meshes:
        mesh = intertri.Mesh(vertices.astype(dtype), open_faces)
        assert not mesh.is_closed
        truth, numbers = solid_angles(mesh.triangles, points), mesh.winding_number(points)
        assert numbers.dtype == np.float64 and np.abs(numbers - truth).max() < 1e-12
        sure = np.abs(np.abs(truth) % 1 - 0.5) > 1e-9
        inside = mesh.contains(points)
        assert (inside == (np.rint(truth) != 0))[sure].all() and 50 < inside.sum() < 350
        assert ((mesh.signed_distance(points) < 0) == inside)[sure].all()
        on = mesh.triangles[:, 0]
        assert np.isnan(mesh.winding_number(on)).all() and mesh.contains(on).all()
        assert (mesh.signed_distance(on) == 0).all()
    # A refit also updates the winding numbers.
    moved = mesh.vertices * dtype(2)
    mesh.refit(moved)
    assert np.abs(mesh.winding_number(points) - solid_angles(mesh.triangles, points)).max() < 1e-12


def test_shapes(rng):
    mesh = intertri.Mesh(*icosphere(2))
    points = rng.uniform(-1, 1, (4, 5, 3))
    assert mesh.contains(points).shape == (4, 5)
    assert (mesh.contains(points).ravel() == mesh.contains(points.reshape(-1, 3))).all()
    assert (mesh.contains(np.asfortranarray(points)) == mesh.contains(points)).all()
    assert not mesh.contains([np.nan, 0, 0])
    assert mesh.contains(points, threads=1).tolist() == mesh.contains(points, threads=2).tolist()
    for ask in (mesh.contains, mesh.winding_number, mesh.is_on_surface, mesh.signed_distance, mesh.closest_point):
        assert ask(points[0, 0]) == ask(points)[0, 0] and isinstance(ask(points[0, 0]), np.generic)


def test_more_points_than_are_put_in_order_at_once():
    """Results are in the order of the points, even if there are too many points to sort in one pass."""
    mesh = intertri.Mesh(*(lambda v, f: (v.astype(np.float32), f))(*box()))
    count = (1 << 22) + 5000
    points = np.zeros((count, 3), np.float32)
    points[:, 0] = np.random.default_rng(1).permutation(count) / np.float32(count / 2)
    assert (mesh.contains(points) == (points[:, 0] <= 1)).all()
    away = np.abs(points[:, 0].astype(float) - 1)
    assert (mesh.closest_point(points, radius=0.1)["distance"] == np.where(away <= 0.1, away, np.inf)).all()


def test_no_ray_leaks_and_every_count_is_right(dtype, rng):
    """From inside a closed mesh, the signed crossings of every ray sum to 1, even at corners and edges."""
    vertices, faces = icosphere(3)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    origin = np.array([0.125, 0.25, -0.125], dtype)
    corners = mesh.vertices - origin
    edges = (mesh.triangles[:, 0] + mesh.triangles[:, 1]) / dtype(2) - origin
    ways = np.concatenate([corners, edges, -corners]).astype(dtype)
    assert mesh.any(origin, ways).all()
    assert (mesh.count_crossings(origin, ways)["signed"] == 1).all()


def test_parity_does_not_depend_on_how_faces_are_turned(dtype, rng):
    vertices, faces = icosphere(2)
    is_turned = rng.random(len(faces)) < 0.5
    faces = np.where(is_turned[:, None], faces[:, ::-1], faces)
    mesh, whole = intertri.Mesh(vertices.astype(dtype), faces), intertri.Mesh(vertices.astype(dtype), icosphere(2)[1])
    points = np.concatenate([rng.uniform(-1.1, 1.1, (2000, 3)).astype(dtype), whole.vertices])
    assert not mesh.is_closed
    assert (mesh.contains(points, parity=True) == whole.contains(points)).all()
    assert (mesh.contains(points) != whole.contains(points)).any()
    twice = intertri.Mesh(*(np.concatenate([part, part + more]) for part, more in ((vertices, 0), (icosphere(2)[1], len(vertices)))))
    assert twice.contains([0, 0, 0]) and not twice.contains([0, 0, 0], parity=True)
