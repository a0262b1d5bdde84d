"""Tests the trimesh interface, including each kind of problem that trimesh users have reported."""

import copy
import pickle

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

import intertri.trimesh  # noqa: E402
from intertri.trimesh import RayMeshIntersector, install  # noqa: E402


def wall():
    """Returns a wall at UTM coordinates, and the wall's normal."""
    vertices = np.array([[528980.85, 183526.1, 0], [528980.85, 183526.1, 3],
                         [528982.3, 183523.55, 0], [528982.3, 183523.55, 3]])
    mesh = install(trimesh.Trimesh(vertices, [[1, 0, 2], [1, 2, 3]], process=False))
    normal = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[0])
    return mesh, normal / np.linalg.norm(normal)


@pytest.mark.parametrize("distance", [1e-1, 1e-2, 1e-3, 1e-6, 1e-9])
def test_48_a_ray_that_leaves_a_wall_at_utm_coordinates(distance):
    """Rays away from the wall must miss it, and rays toward it must hit it. The issue report called this unfixable."""
    mesh, normal = wall()
    middle = mesh.vertices[[0, 2]].mean(axis=0) + [0, 0, 1]
    for side in (1, -1):
        origin = middle + side * distance * normal
        assert not mesh.ray.intersects_any([origin], [side * normal])[0]
        assert mesh.ray.intersects_any([origin], [-side * normal])[0]
        assert len(mesh.ray.intersects_id([origin], [-side * normal])[0]) == 1


def test_331_points_on_the_surface_do_not_hit_it():
    """From points sampled exactly on a box, outward rays hit nothing. Inward rays hit the far side
    first and cross the surface twice."""
    mesh = install(trimesh.creation.box())
    points, faces = trimesh.sample.sample_surface(mesh, 200, seed=0)
    normals = mesh.face_normals[faces]
    assert mesh.contains(points).all()
    assert not mesh.ray.intersects_any(points, normals).any()
    assert len(mesh.ray.intersects_id(points, normals)[0]) == 0
    first = mesh.ray.intersects_first(points, -normals)
    assert np.allclose(mesh.face_normals[first], -normals)
    triangles, rays = mesh.ray.intersects_id(points, -normals)
    assert (np.bincount(rays, minlength=200) == 2).all()
    assert (mesh.face_normals[triangles[::2]] == normals).all()


def test_1496_any_and_first_agree_at_corners():
    inner = install(trimesh.creation.box(extents=[40] * 3).subdivide_to_size(5))
    outer = trimesh.creation.box(extents=[60] * 3).subdivide_to_size(5)
    origins = np.zeros_like(outer.vertices)
    assert inner.ray.intersects_any(origins, outer.vertices).all()
    assert (inner.ray.intersects_first(origins, outer.vertices) >= 0).all()
    triangles, rays = inner.ray.intersects_id(origins, outer.vertices)
    assert (np.bincount(rays, minlength=len(origins)) == 1).all()


def test_2317_silhouettes_are_hit():
    mesh = install(trimesh.creation.box(extents=[2, 2, 2]))
    origins = [[x, y, 5] for x in (-1, 0, 1) for y in (-1, 0, 1)]
    assert mesh.ray.intersects_any(origins, [[0, 0, -1]] * 9).all()
    assert (mesh.ray.intersects_first(origins, [[0, 0, -1]] * 9) >= 0).all()


@pytest.mark.parametrize("scale", [1e-4, 1e-3, 1, 1e4, 1e8])
@pytest.mark.parametrize("distance", [0.5, 10, 1e7])
def test_2504_two_crossings_whatever_the_scale(scale, distance):
    mesh = install(trimesh.creation.box(extents=[scale] * 3).subdivide().subdivide())
    origins = np.array([[x, y, distance] for x in (0, 0.125, 0.2) for y in (0, 0.25, 0.3)]) * scale
    triangles, rays, places = mesh.ray.intersects_id(origins, np.tile([0, 0, -1.0], (9, 1)), return_locations=True)
    assert (np.bincount(rays, minlength=9) == 2).all()
    assert np.allclose(places[:, 2].reshape(9, 2), np.array([0.5, -0.5]) * scale, rtol=1e-9, atol=scale * distance * 1e-15)


def test_457_a_cylinder_is_crossed_twice_through_its_axis():
    mesh = install(trimesh.creation.cylinder(radius=1, height=4, sections=32))
    assert len(mesh.ray.intersects_id([[0, 0, -5]], [[0, 0, 1]])[0]) == 2


def test_2462_coplanar_rays_miss():
    mesh = install(trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.1, 0.3, 0], [0, 0.3, 0]], [[0, 1, 2], [0, 2, 3]], process=False))
    places, rays, triangles = mesh.ray.intersects_location([[-0.5, 0.1, 0]], [[1, 0, 0]])
    assert places.shape == (0, 3) and rays.shape == (0,) and triangles.shape == (0,)


def test_181_1786_contains_is_the_same_each_time():
    mesh = install(trimesh.creation.icosphere())
    points = np.concatenate([np.random.default_rng(0).uniform(-1, 1, (500, 3)), mesh.vertices * 0.5, mesh.vertices])
    first = mesh.contains(points)
    assert first[500:].all() and 150 < first[:500].sum() < 400
    assert all((mesh.contains(points) == first).all() for _ in range(20))


def test_1180_every_ray_toward_a_corner_hits():
    mesh = install(trimesh.creation.icosphere(subdivisions=4))
    places, rays, triangles = mesh.ray.intersects_location(
        np.zeros_like(mesh.vertices), mesh.vertices, multiple_hits=False)
    assert len(places) == len(rays) == len(triangles) == len(mesh.vertices)
    assert np.allclose(places, mesh.vertices)


def test_2534_a_cavity_is_outside():
    outer, inner = trimesh.creation.box(), trimesh.creation.box(extents=[0.1] * 3)
    inner.invert()
    mesh = install(trimesh.util.concatenate([outer, inner]))
    assert mesh.contains([[0, 0, 0], [0.2, 0, 0]]).tolist() == [False, True]


def test_open_meshes_and_turned_faces_go_by_parity():
    mesh = trimesh.creation.box()
    faces = mesh.faces.copy()
    faces[::2] = faces[::2, ::-1]
    turned = install(trimesh.Trimesh(mesh.vertices, faces, process=False))
    assert not turned.is_winding_consistent
    assert turned.contains([[0.1, 0.2, 0.3], [0, 0, 0.7]]).tolist() == [True, False]


def test_max_hits_and_order():
    boxes = [trimesh.creation.box(extents=[1, 1, 1 + 2 * k]) for k in range(5)]
    mesh = install(trimesh.util.concatenate(boxes))
    triangles, rays, places = mesh.ray.intersects_id(
        [[0.1, 0.2, 20], [9, 9, 9], [0.1, 0.2, -20]], [[0, 0, -1], [0, 0, -1], [0, 0, 1]], return_locations=True)
    assert rays.tolist() == [0] * 10 + [2] * 10
    assert (np.diff(places[:10, 2]) < 0).all() and (np.diff(places[10:, 2]) > 0).all()
    with pytest.warns(UserWarning, match="1 of 2 rays cross the mesh more than max_hits=3 times.*max_hits=10"):
        triangles, rays = mesh.ray.intersects_id([[0.1, 0.2, 20], [9, 9, 9]], [[0, 0, -1]] * 2, max_hits=3)
    assert rays.tolist() == [0] * 3


def test_unknown_options_are_refused():
    mesh = install(trimesh.creation.box())
    for ask in (mesh.ray.intersects_first, mesh.ray.intersects_any, mesh.ray.intersects_location):
        with pytest.raises(TypeError, match="nonsense"):
            ask([[0, 0, 5]], [[0, 0, -1]], nonsense=1)


def test_dtypes_shapes_and_errors():
    mesh = install(trimesh.creation.box())
    for answer in mesh.ray.intersects_id([[0, 0, 5]], [[0, 0, -1]]):
        assert answer.dtype == np.int64
    assert mesh.ray.intersects_any([[0, 0, 5]], [[0, 0, -1]]).dtype == bool
    assert mesh.ray.intersects_first([], []).shape == (0,)
    with pytest.raises(ValueError, match="don't match"):
        mesh.ray.intersects_any([[0, 0, 5]] * 2, [[0, 0, -1]])
    with pytest.raises(ValueError, match=r"\(n,3\)"):
        mesh.ray.contains_points([0, 0, 0])


def test_the_mesh_may_change_and_travel():
    mesh = install(trimesh.creation.box())
    assert mesh.ray.intersects_any([[0.7, 0, 5]], [[0, 0, -1]]).tolist() == [False]
    mesh.apply_scale(2)
    assert mesh.ray.intersects_any([[0.7, 0, 5]], [[0, 0, -1]]).tolist() == [True]
    for other in (pickle.loads(pickle.dumps(mesh)).ray, pickle.loads(pickle.dumps(mesh.ray)),
                  copy.deepcopy(mesh.ray), copy.copy(mesh.ray)):
        assert isinstance(other, RayMeshIntersector)
        assert other.intersects_any([[0.7, 0, 5]], [[0, 0, -1]]).tolist() == [True]


def bodies():
    return trimesh.util.concatenate([trimesh.creation.box(), trimesh.creation.icosphere(2).apply_translation([3, 0, 0])])


@pytest.mark.parametrize(
    "make",
    [
        lambda mesh: mesh.copy(),
        copy.copy,
        copy.deepcopy,
        lambda mesh: pickle.loads(pickle.dumps(mesh)),
        lambda mesh: mesh.split()[0],
        lambda mesh: mesh.submesh([[0, 1, 2]])[0],
        lambda mesh: mesh.submesh([[0, 1, 2]], append=True),
        lambda mesh: mesh.subdivide(),
        lambda mesh: mesh.subdivide_to_size(0.5, return_index=True)[0],
        lambda mesh: mesh.subdivide_loop(),
        lambda mesh: mesh.union(trimesh.creation.box(extents=[3, 3, 3])),
        lambda mesh: mesh + mesh.copy().apply_translation([0, 9, 0]),
        lambda mesh: mesh.copy().copy().subdivide().split()[-1],
    ],
)
def test_what_is_made_of_a_mesh_asks_intertri_too(make):
    mesh = install(bodies())
    made = make(mesh)
    assert made is not mesh and isinstance(made, trimesh.Trimesh) and isinstance(made, type(mesh))
    assert isinstance(made.ray, RayMeshIntersector) and isinstance(made.nearest, intertri.trimesh.ProximityQuery)
    assert made.ray.mesh is made and mesh.ray.mesh is mesh
    # The new mesh queries its own faces, not those of the original mesh.
    above = made.triangles_center[:1] + made.face_normals[:1] / 64
    assert made.ray.intersects_any(above, -made.face_normals[:1]).all()
    assert np.allclose(made.nearest.on_surface(above)[1], 1 / 64) and len(made.ray.intertri) == len(made.faces)


def test_an_installed_mesh_is_what_it_was(capsys):
    plain, mesh = trimesh.creation.box(), install(trimesh.creation.box())
    assert repr(plain) == repr(mesh) and isinstance(mesh, trimesh.Trimesh) and type(plain) is trimesh.Trimesh
    assert type(install(mesh)) is type(mesh) and mesh.is_watertight and mesh.volume == plain.volume
    points = [[0, 0, 0.9], [0.1, 0, 0]]
    assert np.allclose(mesh.nearest.signed_distance(points), plain.nearest.signed_distance(points))
    sphere = install(trimesh.primitives.Sphere(radius=2))
    assert isinstance(sphere.copy().ray, RayMeshIntersector) and isinstance(sphere, trimesh.primitives.Sphere)
    assert sphere.copy().primitive.radius == 2


def test_what_is_no_mesh_is_not_installed():
    scene = trimesh.Scene(trimesh.creation.box())
    with pytest.raises(TypeError, match="install takes a trimesh.Trimesh, not a Scene; pass each mesh of scene.geometry"):
        install(scene)
    with pytest.raises(TypeError, match="not a PointCloud"):
        install(trimesh.PointCloud([[0, 0, 0]]))


def test_signed_distance_and_closest_points():
    mesh = install(trimesh.creation.icosphere(subdivisions=3))
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (300, 3))
    theirs, ours = trimesh.proximity.signed_distance(mesh, points), intertri.trimesh.signed_distance(mesh, points)
    assert np.allclose(theirs, ours, atol=1e-12) and (ours > 0).any() and (ours < 0).any()
    for a, b in zip(trimesh.proximity.closest_point(mesh, points), intertri.trimesh.closest_point(mesh, points)):
        assert a.dtype.kind == b.dtype.kind and np.allclose(a[:0], b[:0])
    there, distance, face = intertri.trimesh.closest_point(mesh, points)
    assert np.allclose(np.linalg.norm(there - points, axis=1), distance) and np.allclose(distance, abs(theirs))
    query = intertri.trimesh.ProximityQuery(mesh)
    assert (query.signed_distance(points) == ours).all() and (query.on_surface(points)[2] == face).all()
    assert np.allclose(query.vertex(points)[0], mesh.nearest.vertex(points)[0])


def test_a_closest_point_on_an_edge_or_a_corner_has_the_face_that_faces_most(rng):
    """The normal of the returned face shows which side of the mesh a point is on, even near a sharp edge or a corner."""
    corners = [[-1, 0.5, 0], [1, 0.5, 0], [0, -1, -0.5], [0, -1, 0.5]]
    mesh = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]]).subdivide().subdivide()
    away = np.concatenate([rng.uniform(-3, 3, (300, 3)), [[0, 1, 0.25], [0, 1, -0.25]], mesh.vertices])
    there, distance, face = intertri.trimesh.closest_point(mesh, away)
    facing = np.einsum("ij,ij->i", mesh.face_normals[face], away - there)
    on_edge = 0
    for point, near, of_face in zip(away, there, facing):
        every = trimesh.triangles.closest_point(mesh.triangles, np.tile(near, (len(mesh.faces), 1)))
        at = np.flatnonzero(np.linalg.norm(every - near, axis=1) < 1e-9)
        assert of_face >= (mesh.face_normals[at] @ (point - near)).max() - 1e-9
        on_edge += len(at) > 1
    outside = intertri.trimesh.signed_distance(mesh, away) < -1e-9
    assert on_edge > 100 and outside.sum() > 100 and (facing[outside] > 0).all()
    assert face[300] != face[301]


def test_rays_start_on_an_edge_or_a_corner():
    """A ray that points inward from a corner or an edge crosses the surface at its start and at the far side."""
    mesh = install(trimesh.creation.box(extents=[2, 2, 2]))
    corner, edge = [1.0, 1, 1], [1.0, 1, 0.25]
    inward, outward = [-1, -0.9, -0.8], [1, 0.9, 0.8]
    triangles, rays = mesh.ray.intersects_id([corner, corner, edge, edge], [inward, outward, inward, outward])
    assert np.bincount(rays, minlength=4).tolist() == [2, 0, 2, 0]
