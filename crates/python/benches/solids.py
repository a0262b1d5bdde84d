"""Compares the answers and the speed of inside/outside tests with those of libigl, Open3D, trimesh,
and Manifold.

    pip install libigl open3d trimesh manifold3d scipy rtree
    python solids.py table
    python solids.py speed [--points 1000000]

`table` shows how many of 2,000 points each package classifies differently in damaged boxes than in
the undamaged box. A point counts only if its winding number in the damaged box, a sum of solid
angles in float64, still puts it on the correct side. `speed` measures millions of points per second
on one core, as the best of several runs. Contenders that would need minutes for a million points
get fewer points.
"""

import argparse
import os
import time

import intertri
import numpy as np


def box(cells=2):
    """Returns a box from -1 to 1, with `cells` × `cells` squares per side: triangles (n, 3, 3)."""
    at = np.linspace(-1, 1, cells + 1)
    triangles = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for i in range(cells):
                for j in range(cells):
                    square = np.empty((4, 3))
                    square[:, axis] = side
                    square[:, (axis + 1) % 3] = at[[i, i + 1, i + 1, i]]
                    square[:, (axis + 2) % 3] = at[[j, j, j + 1, j + 1]]
                    if side < 0:
                        square = square[::-1]
                    triangles += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return np.array(triangles)


def damaged():
    """Returns fifteen boxes as triangles (n, 3, 3), keyed by the kind of damage."""
    whole = box()
    top = (whole[:, :, 2] == 1).all(axis=1)
    rng = np.random.default_rng(57)

    def turned(which):
        triangles = whole.copy()
        triangles[which] = triangles[which, ::-1]
        return triangles

    cracked = whole.copy()
    cracked[::5, 0] += 0.01
    jittered = whole + rng.normal(size=whole.shape) * 0.003
    corner = whole[top][0]
    fin = np.array([[corner[0], corner[1], [0.3, 0.2, 1.8]]])
    inner_fin = np.array([[corner[0], corner[1], [0.1, 0.2, 0.3]]])
    junction = [triangle for triangle in whole[1:]]
    a, b, c = whole[0]
    middle = (a + b) / 2
    junction += [[a, middle, c], [middle, b, c]]
    gap = [triangle for triangle in whole[1:]]
    moved = middle + [0.02, 0.03, 0.05]
    gap += [[a, moved, c], [moved, b, c]]
    return {
        "whole": whole,
        "inside out": whole[:, ::-1],
        "one face turned": turned([3]),
        "a third of the faces turned": turned(np.arange(0, len(whole), 3)),
        "one face doubled": np.concatenate([whole, whole[:1]]),
        "all faces doubled": np.concatenate([whole, whole]),
        "one extra face and its opposite": np.concatenate([whole, whole[:1], whole[:1, ::-1]]),
        "one face missing": whole[1:],
        "no lid": whole[~top],
        "cracked": cracked,
        "corners jittered per face": jittered,
        "a fin outside": np.concatenate([whole, fin]),
        "a fin inside": np.concatenate([whole, inner_fin]),
        "T-junction": np.array(junction),
        "T-junction with a gap": np.array(gap),
    }


def indexed(triangles):
    """Converts triangles to vertices and faces, and merges duplicate vertices."""
    vertices, where = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, where.reshape(-1, 3)


def solid_angles(triangles, points):
    """Computes winding numbers with van Oosterom and Strackee's formula, summed over all triangles
    for each point."""
    a, b, c = (triangles[None, :, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
    dot = lambda x, y: (x * y).sum(axis=-1)  # noqa: E731
    volume = dot(a, np.cross(b, c))
    return np.arctan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb).sum(axis=1) / (2 * np.pi)


def with_intertri(vertices, faces):
    mesh = intertri.Mesh(vertices, faces)
    return lambda points: mesh.contains(points, threads=1)


def with_parity(vertices, faces):
    mesh = intertri.Mesh(vertices, faces)
    return lambda points: mesh.contains(points, parity=True, threads=1)


def with_libigl(vertices, faces):
    import igl

    faces = faces.astype(np.int64)
    return lambda points: np.abs(igl.winding_number(vertices.astype(float), faces, points.astype(float))) > 0.5


def with_fast_libigl(vertices, faces):
    import igl

    faces = faces.astype(np.int64)
    return lambda points: np.abs(igl.fast_winding_number(vertices.astype(float), faces, points.astype(float))) > 0.5


def with_open3d(vertices, faces):
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(np.float32(vertices), np.uint32(faces))
    return lambda points: scene.compute_occupancy(np.float32(points), nthreads=1, nsamples=1).numpy() > 0


def with_open3d_votes(vertices, faces):
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(np.float32(vertices), np.uint32(faces))
    return lambda points: scene.compute_occupancy(np.float32(points), nthreads=1, nsamples=7).numpy() > 0


def with_trimesh(vertices, faces):
    import trimesh
    from trimesh.ray.ray_triangle import RayMeshIntersector

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    return RayMeshIntersector(mesh).contains_points


def with_manifold(vertices, faces):
    import manifold3d

    mesh = manifold3d.Mesh64(np.ascontiguousarray(vertices, float), np.ascontiguousarray(faces, np.uint64))
    mesh.merge()
    solid = manifold3d.Manifold(mesh)
    if solid.status() != manifold3d.Error.NoError:
        raise ValueError(solid.status().name)

    def contains(points):
        # Manifold has no point test, so intersect a tiny tetrahedron at each point with the solid.
        tiny = manifold3d.Manifold.tetrahedron().scale([1e-6] * 3)
        inside = [(tiny.translate(point.tolist()) ^ solid).volume() > 0 for point in points]
        return np.array(inside)

    return contains


ALL = {
    "intertri": with_intertri,
    "intertri, parity": with_parity,
    "libigl exact": with_libigl,
    "libigl fast": with_fast_libigl,
    "Open3D": with_open3d,
    "Open3D, 7 votes": with_open3d_votes,
    "trimesh": with_trimesh,
    "Manifold": with_manifold,
}


def table():
    rng = np.random.default_rng(7)
    points = np.float32(rng.uniform(-1.5, 1.5, (2000, 3))).astype(float)
    truth = (np.abs(points) < 1).all(axis=1)
    print("| box | edges open, turned, uneven | clear points |", " | ".join(ALL), "|")
    print("| --- " * (3 + len(ALL)) + "|")
    for name, triangles in damaged().items():
        numbers = np.abs(solid_angles(triangles, points))
        # Skip points that the damage moves to the other side, because no answer for them is clearly
        # correct.
        clear = (numbers > 0.5) == truth
        row = []
        for make in ALL.values():
            vertices, faces = indexed(triangles)
            try:
                wrong = (make(vertices, faces)(points) != truth)[clear].sum()
                row.append(str(wrong))
            except (ValueError, RuntimeError) as error:
                row.append(f"refuses: {error}")
        report = intertri.Mesh(*indexed(triangles)).inspect()
        edges = ", ".join(str(report[kind]) for kind in ("open", "turned", "uneven"))
        print(f"| {name} | {edges} | {clear.sum()} |", " | ".join(row), "|", flush=True)


def globe(rings, missing):
    """Returns a globe without the faces that lie entirely at y >= `missing`."""
    a = np.arange(rings + 1) / rings * np.pi
    b = np.arange(2 * rings) / rings * np.pi
    r = np.sin(a)
    r[[0, -1]] = 0
    grid = np.stack([r[:, None] * np.cos(b), np.broadcast_to(np.cos(a)[:, None], (rings + 1, 2 * rings)), r[:, None] * np.sin(b)], -1)
    grid = np.float32(grid)
    next_to = np.roll(grid, -1, axis=1)
    one = np.stack([grid[:-1], next_to[:-1], grid[1:]], axis=2).reshape(-1, 3, 3)
    other = np.stack([next_to[1:], grid[1:], next_to[:-1]], axis=2).reshape(-1, 3, 3)
    triangles = np.concatenate([one, other])
    same = lambda i, j: (triangles[:, i] == triangles[:, j]).all(axis=1)  # noqa: E731
    triangles = triangles[~(same(0, 1) | same(1, 2) | same(2, 0))]
    return triangles[(triangles[:, :, 1] < missing).any(axis=1)]


def speed(count):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    rng = np.random.default_rng(7)
    points = np.float32(rng.uniform(-1.2, 1.2, (count, 3)))
    contenders = {
        "intertri": (with_intertri, count, 5),
        "libigl exact": (with_libigl, 200, 1),
        "libigl fast": (with_fast_libigl, 20_000, 2),
        "Open3D": (with_open3d, count, 3),
    }
    print("| mesh | triangles | open edges |", " | ".join(contenders), "| ratio to each of the others |")
    print("| --- " * (4 + len(contenders)) + "|")
    for name, triangles in (
        ("globe", globe(100, 2)),
        ("globe with a hole", globe(50, 0.71)),
        ("globe with small holes", globe(100, 2)[np.arange(39_600) % 120 > 0]),
    ):
        vertices, faces = indexed(triangles)
        mesh = intertri.Mesh(vertices, faces)
        rates = []
        for make, most, turns in contenders.values():
            classify, some = make(vertices, faces), points[:most]
            classify(some[:64])
            best = np.inf
            for _ in range(turns):
                began = time.perf_counter()
                classify(some)
                best = min(best, time.perf_counter() - began)
            rates.append(len(some) / best / 1e6)
        report = mesh.inspect()
        ratios = ", ".join(f"{rates[0] / rate:.1f}" for rate in rates[1:])
        rates = " | ".join(f"{rate:.3g}" for rate in rates)
        print(f"| {name} | {len(mesh)} | {report['open']} | {rates} | {ratios} |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["table", "speed"])
    parser.add_argument("--points", type=int, default=1_000_000)
    given = parser.parse_args()
    table() if given.what == "table" else speed(given.points)
