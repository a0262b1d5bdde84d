"""Tests that `skip`, `visible`, and `spawn_rays` keep surfaces from shadowing themselves."""

import math

import intertri
import numpy as np
import pytest
from conftest import box, camera, icosphere

TRIANGLE = np.array([[0.1, 0.2, 0.3], [1.3, 0.1, 0.7], [0.4, 1.1, 0.2]])
LIGHT = np.array([3.0, 1.0, 4.0])


def test_a_face_does_not_shade_its_centre():
    mesh = intertri.Mesh(TRIANGLE, [[0, 1, 2]])
    centre = TRIANGLE.mean(axis=0)
    # Rounding puts the centre behind the face.
    assert mesh.any(centre, LIGHT - centre, t_max=1)
    assert not mesh.any(centre, LIGHT - centre, t_max=1, skip=0)
    assert mesh.visible(centre, LIGHT) and mesh.visible(LIGHT, centre)


def test_a_vertex_does_not_hide_itself():
    mesh = intertri.Mesh(TRIANGLE, [[0, 1, 2]])
    assert mesh.any(LIGHT, TRIANGLE[0] - LIGHT, t_max=1)
    assert mesh.visible(LIGHT, TRIANGLE).all() and mesh.visible(TRIANGLE, LIGHT).all()
    assert not mesh.visible(LIGHT, 2 * TRIANGLE.mean(axis=0) - LIGHT)


@pytest.mark.parametrize("where", ["centres", "vertices", "edges"])
def test_lit_faces_of_a_sphere_are_lit(dtype, where):
    """Faces of a convex body are lit if they face the light and dark if they face away from it."""
    vertices, faces = icosphere(3)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    corners = mesh.triangles.astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    height = ((LIGHT - corners[:, 0]) * normals).sum(axis=1) / np.linalg.norm(normals, axis=1)
    weights = {"centres": [1, 1, 1], "vertices": [1, 0, 0], "edges": [1, 1, 0]}[where]
    points = np.average(mesh.triangles, axis=1, weights=weights).astype(dtype)
    light = LIGHT.astype(dtype)
    lit = height > 1e-3
    by_accident = mesh.any(points, light - points, t_max=1)[lit]
    assert lit.sum() > 200 and (where != "centres" or by_accident.sum() > 50), by_accident.sum()
    assert mesh.visible(points, light)[lit].all() and mesh.visible(light, points)[lit].all()
    if where == "centres":
        assert not mesh.visible(points, light)[height < -1e-3].any()
        own = np.arange(len(faces))
        assert not mesh.any(points, light - points, t_max=1, skip=own)[lit].any()
        assert mesh.visible(points, light, skip_a=own, skip_b=-1)[lit].all()


def test_points_of_float32_on_a_mesh_of_float64():
    vertices, faces = icosphere(3)
    mesh = intertri.Mesh(vertices, faces)
    corners = mesh.triangles
    height = ((LIGHT - corners[:, 0]) * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).sum(axis=1)
    points = corners.mean(axis=1).astype(np.float32)
    assert mesh.visible(points, LIGHT)[height > 1e-6].all()
    # Float64 points are used unchanged, and some of them are inside the sphere.
    assert not mesh.visible(points.astype(np.float64), LIGHT)[height > 1e-6].all()


def rays_of(mesh, rng, count=300):
    vertices = mesh.triangles[rng.integers(0, len(mesh), count)].mean(axis=1)
    ways = rng.normal(size=(count, 3))
    return vertices.astype(mesh.dtype), ways.astype(mesh.dtype)


def test_skipping_is_as_a_mesh_without_the_face(dtype, rng):
    vertices, faces = icosphere(1)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    origins, ways = rays_of(mesh, rng)
    first = mesh.closest(origins, ways)
    skip = np.where(rng.random(len(origins)) < 0.2, -1, first["triangle"])
    assert (skip >= 0).sum() > 100
    closest = mesh.closest(origins, ways, skip=skip)
    triangles, any_hit = mesh.closest_triangle(origins, ways, skip=skip), mesh.any(origins, ways, skip=skip)
    lists, crossings = mesh.all(origins, ways, skip=skip), mesh.crossings(origins, ways, skip=skip)
    counts = mesh.count_crossings(origins, ways, skip=skip)
    for i, number in enumerate(skip):
        kept = np.delete(np.arange(len(faces)), [number] if number >= 0 else [])
        other = intertri.Mesh(mesh.vertices, faces[kept])
        numbers = np.append(kept, -1)

        def renamed(hits):
            hits = hits.copy()
            hits["triangle"] = numbers[hits["triangle"]]
            return hits

        hit = renamed(other.closest(origins[i], ways[i]).reshape(1))[0]
        assert closest[i] == hit and triangles[i] == hit["triangle"] and any_hit[i] == (hit["triangle"] >= 0)
        assert closest[i] == mesh.closest(origins[i], ways[i], skip=int(number))
        ours = lists.hits[lists.offsets[i]:lists.offsets[i + 1]]
        assert (ours == renamed(other.all(origins[i], ways[i]).hits)).all()
        ours = crossings.hits[crossings.offsets[i]:crossings.offsets[i + 1]]
        assert (ours == renamed(other.crossings(origins[i], ways[i]).hits)).all()
        assert counts[i] == other.count_crossings(origins[i], ways[i])
    assert (closest != first).any()


def test_skip_in_pictures_and_on_threads(dtype):
    """An image with one origin is traced in tiles only if no triangle is skipped, but the results must not differ."""
    vertices, faces = icosphere(4)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    eye, ways = (array.astype(dtype) for array in camera(160, [1, 2, 3]))
    first = mesh.closest(eye, ways)
    assert (mesh.closest(eye, ways, skip=-1) == first).all()
    second = mesh.closest(eye, ways, skip=first["triangle"])
    assert (second["triangle"] != first["triangle"])[first["triangle"] >= 0].all()
    lists = mesh.all(eye, ways, limit=2)
    behind = np.full(first.size, -1)
    has_two = np.diff(lists.offsets) == 2
    behind[has_two] = lists.hits["triangle"][lists.offsets[1:][has_two] - 1]
    assert (second["triangle"].reshape(-1) == behind).all()
    for threads in (1, 2):
        assert (mesh.closest(eye, ways, skip=first["triangle"], threads=threads) == second).all()
        assert (mesh.visible(eye, ways, threads=threads) == mesh.visible(ways, eye)).all()


@pytest.mark.parametrize("moved", [0, 528_980.447])
def test_spawned_rays_leave_the_surface(dtype, rng, moved):
    vertices, faces = icosphere(2)
    mesh = intertri.Mesh((vertices + moved).astype(dtype), faces)
    eye, ways = camera(60, [1, 2, 3])
    hits = mesh.closest((eye + moved).astype(dtype), ways.astype(dtype))
    normals = np.cross(*(mesh.triangles[:, k] - mesh.triangles[:, 0] for k in (1, 2)))
    out = normals[hits["triangle"]]
    is_hit = hits["triangle"] >= 0
    assert is_hit.sum() > 500
    around = rng.normal(size=out.shape)
    for sign in (1, -1):
        # Send every ray to the same side of its triangle.
        along = (around * out).sum(axis=-1, keepdims=True)
        ways = (sign * np.sign(along) * around).astype(dtype)
        rays = mesh.spawn_rays(hits, ways)
        assert rays.dtype == dtype and rays.shape == (*hits.shape, 6)
        assert (rays[..., 3:] == ways).all() and np.isnan(rays[~is_hit][:, :3]).all()
        again = mesh.closest(rays)
        assert (again["triangle"] != hits["triangle"])[is_hit].all() and (again["triangle"][~is_hit] == -1).all()
        # Outward rays hit nothing except near an edge; inward rays hit the far side. Far from the
        # origin, rounding deforms the sphere too much for this check.
        assert moved or (sign < 0) == ((again["triangle"] >= 0)[is_hit].mean() > 0.99)
        corners = mesh.triangles[hits["triangle"][is_hit]].astype(np.float64)
        u, v = hits["u"][is_hit][:, None], hits["v"][is_hit][:, None]
        points = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
        assert abs(rays[is_hit][:, :3] - points).max() <= 8 * np.finfo(dtype).eps * abs(points).max() * 8
        # Rays spawned from misses hit nothing, whatever the interval.
        assert not mesh.any(rays[~is_hit], t_min=-math.inf, t_max=1).any()


def test_spawned_rays_of_lists_and_single_hits(dtype):
    mesh = intertri.Mesh(*box())
    lists = mesh.crossings([[0.1, 0.2, 5], [9, 9, 9]], [0, 0, -1])
    rays = mesh.spawn_rays(lists.hits, [0, 0, 1])
    assert rays.shape == (2, 6) and mesh.closest_triangle(rays)[0] == -1 and mesh.closest_triangle(rays)[1] >= 0
    hit = mesh.closest([0.1, 0.2, 5], [0, 0, -1])
    assert mesh.spawn_rays(hit, [0, 0, 1]).shape == (6,)
    assert mesh.spawn_rays(hit, np.ones((4, 5, 3))).shape == (4, 5, 6)


def test_visible_shapes_and_threads(dtype):
    vertices, faces = icosphere(2)
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    assert mesh.visible([0, 0, 0], [0, 0, 0.5]) is np.True_ or mesh.visible([0, 0, 0], [0, 0, 0.5])
    assert not mesh.visible([0, 0, 0], [3, 1, 4]) and mesh.visible(np.zeros((2, 1, 3)), np.ones((4, 3))).shape == (2, 4)
    out = np.zeros(2, bool)
    assert mesh.visible([[2, 2, 2], [math.nan, 0, 0]], LIGHT, out=out) is out and out.tolist() == [True, False]
    assert mesh.visible(np.zeros((0, 3)), LIGHT).shape == (0,)


@pytest.mark.parametrize(
    ("ask", "error", "says"),
    [
        (lambda mesh: mesh.any([0, 0, 5], [0, 0, -1], skip=12), IndexError, "skip has 12, but there are 12 faces"),
        (lambda mesh: mesh.any([0, 0, 5], [0, 0, -1], skip=-2), IndexError, "skip has -2.*-1 skips none"),
        (lambda mesh: mesh.any([0, 0, 5], [0, 0, -1], skip=0.5), TypeError, "skip has dtype float64"),
        (lambda mesh: mesh.any([[0, 0, 5]], [0, 0, -1], skip=[1, 2]), ValueError, r"skip has shape \(2,\)"),
        (lambda mesh: mesh.visible([0, 0], [0, 0, 1]), ValueError, r"a has shape \(2,\)"),
        (lambda mesh: mesh.visible([0, 0, 1], [0, 0]), ValueError, r"b has shape \(2,\)"),
        (lambda mesh: mesh.visible([0, 0, 1], [0, 0, 0], skip_b=12), IndexError, "skip_b has 12"),
        (lambda mesh: mesh.spawn_rays([1, 2], [0, 0, 1]), TypeError, "hits has dtype int64"),
        (lambda mesh: mesh.spawn_rays(np.zeros(1, intertri.CROSSINGS), [0, 0, 1]), TypeError, "closest, closest_point, all"),
        (lambda mesh: mesh.spawn_rays(np.zeros(3, intertri.HIT), np.zeros((2, 3))), ValueError, "hits and directions"),
        (lambda mesh: mesh.spawn_rays(np.full(1, 12, intertri.HIT), [0, 0, 1]), IndexError, "12 faces"),
    ],
)
def test_errors(ask, error, says):
    with pytest.raises(error, match=says):
        ask(intertri.Mesh(*box()))
