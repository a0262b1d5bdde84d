"""Tests media along rays, thickness, and voxels."""

import copy
import pickle

import intertri
import numpy as np
import pytest
from conftest import box, icosphere

UTM = np.array([500_123.0, 4_649_776.0, 311.0])


def boxes(dtype, offset=(0, 0, 0)):
    """Returns two blocks that touch, and a third that overlaps both."""
    corners = [box((0, 0, 0), (2, 2, 2)), box((2, 0, 0), (4, 2, 2)), box((1, 0.5, 0.5), (3, 1.5, 1.5))]
    return [intertri.Mesh((vertices + offset).astype(dtype), faces) for vertices, faces in corners]


def test_segments_have_no_gaps(dtype):
    offset = (0, 0, 0) if dtype == np.float32 else UTM
    media = intertri.Media(boxes(dtype, offset), [5, 5, 8])
    assert media.dtype == dtype and media.media.tolist() == [5, 5, 8]
    origin = np.array([-1, 1, 1]) + offset
    lists = media.segments([origin, origin], [[1, 0, 0], [0, 2, 0]])
    assert lists.offsets.tolist() == [0, 5, 6] and lists.rays.tolist() == [0] * 5 + [1]
    # The third block covers part of the wall between the others. Elsewhere, the medium is the same
    # on both sides of the wall.
    assert lists.segments["medium"].tolist() == [-1, 5, 8, 5, -1, -1]
    assert lists.segments["end"].tolist() == [1, 2, 4, 5, np.inf, np.inf]
    assert (lists.segments["start"][1:5] == lists.segments["end"][:4]).all()
    assert lists.segments["geometry"].tolist()[:4] == [0, 2, 2, 1]
    assert lists.segments["triangle"][4] == -1 and (lists.segments["triangle"][:4] >= 0).all()
    assert media.lengths([origin, origin], [[1, 0, 0], [0, 2, 0]]).tolist() == [[2, 2], [0, 0]]
    assert media.lengths(origin, [2, 0, 0], t_max=1.5).tolist() == [1, 1]
    whole = np.concatenate([origin, [2, 0, 0]]).astype(dtype)
    assert media.lengths(whole).tolist() == [2, 2]
    eight = np.concatenate([origin, [0], [2, 0, 0], [1.5]]).astype(dtype)
    assert media.lengths(eight).tolist() == [1, 1]


def test_touching_solids_have_nothing_between_them(dtype):
    media = intertri.Media(boxes(dtype)[:2])
    rays = [[-1, 1, 1], [-1, 0.25, 0.25], [2, 1, 1], [3, 1, 1], [2, 1, -1]], [[1, 0, 0], [1, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1]]
    found = media.next_crossing(*rays, t_min=[1.5, 0, 0, 0, 0])
    assert found["t"].tolist() == [3, 1, 2, 1, 1]
    assert found["left"].tolist() == [0, -1, 1, 1, -1]
    # A ray in the plane of the wall is treated as if it were shifted along x.
    assert found["entered"].tolist() == [1, 0, -1, 0, 1]
    assert media.next_crossing([9, 9, 9], [1, 0, 0])["triangle"] == -1
    assert media.medium_at([[1, 1, 1], [2, 1, 1], [0, 0, 0], [4, 2, 2], [np.nan, 0, 0]]).tolist() == [0, 1, 0, -1, -1]


def test_batches_are_single_rays(rng):
    vertices, faces = icosphere(2)
    meshes = [intertri.Mesh(vertices * size, faces) for size in (1, 0.8, 0.5)]
    meshes.append(intertri.Mesh(vertices * 0.6 + [0.4, 0, 0], faces))
    media = intertri.Media(meshes, [3, 1, 3, 2])
    origins, ways = rng.uniform(-1, 1, (2, 5000, 3))
    ways[:1000] = meshes[3].vertices[rng.integers(0, len(vertices), 1000)] - origins[:1000]
    found, lists = media.next_crossing(origins, ways), media.segments(origins, ways, threads=1)
    at = media.medium_at(origins)
    for i in range(0, 5000, 7):
        assert media.next_crossing(origins[i], ways[i]) == found[i]
        alone = media.segments(origins[i], ways[i]).segments
        assert (alone == lists.segments[lists.offsets[i] : lists.offsets[i + 1]]).all()
        assert media.medium_at(origins[i]) == at[i] == alone["medium"][0]
    middle = np.minimum(lists.segments["end"], 100) / 2 + lists.segments["start"] / 2
    points = origins[lists.rays] + middle[:, None] * ways[lists.rays]
    # The midpoint of a segment as short as a rounding error may round to the other side of a wall.
    clear = np.min([mesh.closest_point(points)["distance"] for mesh in meshes], axis=0) > 1e-14
    assert (media.medium_at(points) == lists.segments["medium"])[clear].all() and clear.mean() > 0.99
    # Float64 rays keep their precision in float32 meshes.
    single = intertri.Media([intertri.Mesh(vertices.astype(np.float32), faces)])
    assert single.dtype == np.float32 and single.next_crossing([0.1, 0.2, 0.3], [1, 0, 0])["entered"] == -1
    for other in (copy.copy(media), pickle.loads(pickle.dumps(media))):
        assert (other.next_crossing(origins, ways) == found).all() and repr(other) == "Media(4 meshes, float64)"


def test_what_is_no_media_is_refused():
    vertices, faces = box()
    closed, is_open = intertri.Mesh(vertices, faces), intertri.Mesh(vertices, faces[:-1])
    with pytest.raises(ValueError, match=r"mesh 1 is not a solid: the mesh is not closed: 3 edges"):
        intertri.Media([closed, is_open])
    with pytest.raises(TypeError, match="pass \\[mesh\\]"):
        intertri.Media(closed)
    for media in ([1], [1.5, 2], [[1, 2]], [-1, 0], [2**31, 0]):
        with pytest.raises(ValueError, match="media"):
            intertri.Media([closed, closed], media)
    nothing = intertri.Media([])
    assert nothing.medium_at([[0, 0, 0]]).tolist() == [-1] and nothing.lengths([[0, 0, 0]], [1, 0, 0]).shape == (1, 0)


def test_thickness(dtype, rng):
    vertices, faces = box((0, 0, 0), (1, 2, 3))
    mesh = intertri.Mesh(vertices.astype(dtype), faces)
    hits = mesh.closest([[-1, 1.5, 1.25], [0.5, 9, 1.25], [0.25, 0.5, -7], [5, 5, 5]], [[1, 0, 0], [0, -1, 0], [0, 0, 1], [1, 0, 0]])
    assert mesh.thickness(hits)[:3].tolist() == [1, 2, 3] and np.isnan(mesh.thickness(hits)[3])
    assert mesh.thickness(hits[1]) == 2
    inside_out = intertri.Mesh(vertices.astype(dtype), faces[:, ::-1])
    assert inside_out.thickness(inside_out.closest([-1, 1.5, 1.25], [1, 0, 0])) == np.inf
    sphere = intertri.Mesh(*icosphere(4))
    hits = sphere.closest(rng.normal(size=(100, 3)) * 0.1, rng.normal(size=(100, 3)))
    assert (abs(sphere.thickness(hits) - 2) < 0.02).all()


def centres(origin, spacing, shape):
    axes = [origin[k] + np.broadcast_to(spacing, 3)[k] * np.arange(shape[k]) for k in range(3)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("grid", [((-1.5, -1.5, -1.5), 0.25, (13, 12, 14)), ((-1.1, -1.2, -1.3), (0.1, 0.2, 0.3), (20, 12, 9))])
def test_voxels_are_points(dtype, grid, closed):
    shapes = [box(), icosphere(2)] if closed else [(box()[0], box()[1][:-1])]
    for vertices, faces in shapes:
        mesh = intertri.Mesh(vertices.astype(dtype), faces)
        voxels = mesh.voxels(*grid)
        points = centres(*grid)
        assert voxels.dtype == np.uint8 and voxels.shape == grid[2]
        assert ((voxels != 0) == mesh.contains(points)).all()
        assert ((voxels == 2) == mesh.is_on_surface(points)).all()
        assert (voxels == mesh.voxels(*grid, threads=1)).all()
        assert 100 < (voxels == 1).sum() < voxels.size - 100


def test_voxels_far_away():
    vertices, faces = icosphere(3)
    mesh = intertri.Mesh(vertices + UTM, faces)
    grid = (UTM - 1.2, 0.0625, (40, 40, 40))
    assert ((mesh.voxels(*grid) != 0) == mesh.contains(centres(*grid))).all()


def test_what_is_no_grid_is_refused():
    mesh = intertri.Mesh(*box())
    for grid in [((0, 0), 1, (2, 2, 2)), ((0, 0, 0), 0, (2, 2, 2)), ((0, 0, 0), (1, 1), (2, 2, 2)), ((0, 0, 0), -1, (2, 2, 2)),
                 ((np.nan, 0, 0), 1, (2, 2, 2)), ((0, 0, 0), 1, (2, 2)), ((0, 0, 0), 1, (2, 2, -1)), ((0, 0, 0), 1, (2, 2.5, 2))]:
        with pytest.raises(ValueError, match="origin|spacing|shape"):
            mesh.voxels(*grid)
    assert mesh.voxels((0, 0, 0), 1, (0, 2, 2)).shape == (0, 2, 2)
    with pytest.raises(MemoryError):
        mesh.voxels((0, 0, 0), 1, (10**6, 10**6, 10**6))
