"""Tests `intertri.pyvista` and compares its results with those of PyVista itself."""

import numpy as np
import pytest
from conftest import box, icosphere

pyvista = pytest.importorskip("pyvista")

import intertri.pyvista  # noqa: E402
from intertri.pyvista import multi_ray_trace, ray_trace, select_interior_points  # noqa: E402


def poly(vertices, faces):
    return pyvista.PolyData.from_regular_faces(vertices, faces)


@pytest.fixture
def sphere(dtype):
    vertices, faces = icosphere(3)
    return poly(vertices.astype(dtype), faces)


def test_a_segment_meets_a_sphere_as_in_pyvista(sphere, rng):
    for _ in range(50):
        start, end = rng.uniform(-2, 2, (2, 3))
        ours, cells = ray_trace(sphere, start, end)
        theirs, their_cells = sphere.ray_trace(start, end)
        along = lambda points: sorted(((points - start) @ (end - start)).tolist())
        assert np.allclose(along(ours), along(theirs), atol=1e-6) and sorted(cells) == sorted(their_cells)
        assert along(ours) == ((ours - start) @ (end - start)).tolist() and cells.dtype == np.int64
        first, every = ray_trace(sphere, start, end, first_point=True)
        assert (first == ours[:1]).all() and (every == cells).all() and (not len(ours) or first.shape == (3,))


def test_points_that_cells_share_are_met_once(sphere):
    corner = sphere.points[17].astype(float)
    around = np.flatnonzero((sphere.regular_faces == 17).any(axis=1))
    points, cells = ray_trace(sphere, 2 * corner, [0, 0, 0])
    assert points.tolist() == [corner.tolist()] and cells.tolist() == [around.min()]
    points, cells = ray_trace(sphere, 2 * corner, -2 * corner)
    assert len(points) == len(cells) == 2


def test_the_ends_of_a_segment_count(sphere):
    a, b = sphere.points[[17, 300]].astype(float)
    points, cells = ray_trace(sphere, a, b)
    assert points.tolist() == [a.tolist(), b.tolist()]
    assert 17 in sphere.regular_faces[cells[0]] and 300 in sphere.regular_faces[cells[1]]
    assert ray_trace(sphere, a, 2 * a)[0].tolist() == [a.tolist()] and len(ray_trace(sphere, a, a)[0]) == 1
    assert ray_trace(sphere, [0, 0, 0], [0, 0, 0.5])[0].shape == (0, 3)


def test_cells_are_those_of_the_mesh_as_given():
    """Cell numbers refer to the original mesh, even if vertex and line cells precede its faces."""
    cube = pyvista.Cube()
    assert ray_trace(cube, [2, 0.1, 0.2], [-2, 0.1, 0.2])[1].tolist() == cube.ray_trace([2, 0.1, 0.2], [-2, 0.1, 0.2])[1].tolist()[::1]
    for faces in (cube.faces, cube.triangulate().faces):
        mixed = pyvista.PolyData(cube.points, faces=faces, lines=[2, 0, 1, 2, 1, 2], verts=[1, 0])
        points, cells = ray_trace(mixed, [2, 0.1, 0.2], [-2, 0.1, 0.2])
        assert np.allclose(points, [[0.5, 0.1, 0.2], [-0.5, 0.1, 0.2]])
        for point, cell in zip(points, cells):
            bounds = np.reshape(mixed.get_cell(cell).bounds, (3, 2))
            assert mixed.get_cell(cell).dimension == 2 and (bounds[:, 0] - 1e-6 <= point).all() and (point <= bounds[:, 1] + 1e-6).all()


def test_many_rays(sphere, rng):
    rays = rng.uniform(-2, 2, (300, 6))
    points, numbers, cells = multi_ray_trace(sphere, rays[:, :3], rays[:, 3:])
    mesh = intertri.Mesh(sphere)
    lists = mesh.all(rays)
    assert numbers.tolist() == lists.rays.tolist() and cells.tolist() == lists.hits["triangle"].tolist()
    assert (points == mesh.hit_points(lists.hits)).all() and len(points) > 50
    first, numbers, cells = multi_ray_trace(sphere, rays[:, :3], rays[:, 3:], first_point=True, retry=True)
    hits = mesh.closest(rays)
    assert numbers.tolist() == np.flatnonzero(hits["triangle"] >= 0).tolist()
    assert (cells == hits["triangle"][numbers]).all() and (first == mesh.hit_points(hits[numbers])).all()
    with pytest.raises(pyvista.core.errors.NotAllTrianglesError):
        multi_ray_trace(pyvista.Cube(), rays[:, :3], rays[:, 3:])


def test_interior_points(sphere, rng):
    cloud = pyvista.PolyData(rng.uniform(-1.2, 1.2, (500, 3)))
    theirs = cloud.select_interior_points(sphere)["selected_points"]
    selected = select_interior_points(cloud, sphere)
    assert selected is not cloud and "selected_points" not in cloud.array_names and selected.n_points == 500
    inside = selected["selected_points"]
    assert inside.dtype == bool and (inside == theirs).all() and 50 < inside.sum() < 450
    assert (select_interior_points(cloud, sphere, inside_out=True, method="cell_locator")["selected_points"] == ~inside).all()
    # Both selections contain the points on the surface.
    for turn in (False, True):
        assert select_interior_points(sphere, sphere, inside_out=turn)["selected_points"].all()
    grid = pyvista.ImageData(dimensions=(5, 5, 5), origin=(-1, -1, -1), spacing=(0.5, 0.5, 0.5))
    assert type(select_interior_points(grid, sphere)) is pyvista.ImageData
    assert not select_interior_points(cloud, pyvista.PolyData())["selected_points"].any()


def test_squares_and_twice_the_same_points_close_a_surface():
    cloud = pyvista.PolyData([[0.1, 0.2, 0.3], [0.1, 0.2, 0.7]])
    for cube in (pyvista.Cube(), poly(*box((-0.5,) * 3, (0.5,) * 3))):
        assert select_interior_points(cloud, cube)["selected_points"].tolist() == [True, False]


def test_open_surfaces(sphere):
    cloud = pyvista.PolyData([[0.0, 0, 0], [3.0, 0, 0]])
    turned = sphere.regular_faces.copy()
    turned[::2] = turned[::2, ::-1]
    for surface in (poly(sphere.points, sphere.regular_faces[1:]), poly(sphere.points, turned)):
        with pytest.raises(RuntimeError, match="Surface is not closed: repair it, or pass check_surface=False"):
            select_interior_points(cloud, surface)
        selected = select_interior_points(cloud, surface, check_surface=False)["selected_points"]
        assert selected.tolist() == [True, False]


def test_a_mesh_that_changes_in_place(sphere):
    ask = lambda: len(ray_trace(sphere, [0, 0, 0], [9, 0.1, 0.2])[0])
    assert ask() == 1
    points = sphere.points.view(np.ndarray)
    points[:] += np.array([0, 5, 0], points.dtype)
    assert ask() == 0
    points[:] -= np.array([0, 5, 0], points.dtype)
    assert ask() == 1


@pytest.mark.parametrize(
    ("ask", "error", "says"),
    [
        (lambda mesh: ray_trace(pyvista.ImageData(), [0, 0, 0], [1, 0, 0]), TypeError, "ray_trace takes a surface.*extract_surface"),
        (lambda mesh: ray_trace(mesh, [0, 0], [1, 0, 0]), ValueError, r"origin has shape \(2,\)"),
        (lambda mesh: ray_trace(mesh, [[0, 0, 0]], [1, 0, 0]), ValueError, r"origin and end_point have shapes \(1, 3\)"),
        (lambda mesh: multi_ray_trace(mesh, [[0, 0, 0]] * 2, [[1, 0, 0]] * 3), ValueError, "do not fit"),
        (lambda mesh: select_interior_points(mesh, mesh, method="x"), ValueError, "method is 'x'"),
        (lambda mesh: select_interior_points(mesh, mesh, locator_tolerance=1), ValueError, "locator_tolerance"),
        (lambda mesh: select_interior_points(mesh, [1]), TypeError, "not a list"),
    ],
)
def test_errors(ask, error, says, sphere):
    with pytest.raises(error, match=says):
        ask(sphere)
