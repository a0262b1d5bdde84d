"""Compares the speed and answers of intertri, Open3D, and trimesh with Embree.

    python beside.py FOLDER_OF_MODELS [--rays 1024] [--only bunny] [--seconds 0.6]

Everything runs in one process, with numpy arrays as input and output. Prints tables in Markdown.
The contenders take turns. Each rate is the best of several turns, in millions per second. Where
answers differ, rational arithmetic determines whether the ray meets the triangle that each
contender reports, and which of these triangles is nearer.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
import oracle  # noqa: E402


def scenes(folder):
    import trimesh

    for name, file in (("bunny", "stanford-bunny.obj"), ("kitchen", "kitchen.obj")):
        mesh = trimesh.load(Path(folder) / file, process=False, force="mesh", skip_materials=True)
        yield name, np.float32(mesh.vertices), np.asarray(mesh.faces)
    sphere = trimesh.creation.icosphere(subdivisions=7)
    yield "sphere", np.float32(sphere.vertices), np.asarray(sphere.faces)


def camera(vertices, faces, size):
    """Returns the rays of an image, row by row: origins and directions, (n, 3) float32."""
    used = vertices[np.unique(faces)].astype(float)
    low, high = used.min(axis=0), used.max(axis=0)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low) / 2
    ahead = np.array([-0.4, -0.3, -1.0])
    ahead /= np.linalg.norm(ahead)
    eye = middle - ahead * reach * 2.2
    right = np.cross(ahead, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    x = np.linspace(-0.42, 0.42, size)
    ways = ahead + x[None, :, None] * right - x[:, None, None] * up
    ways = (ways / np.linalg.norm(ways, axis=-1, keepdims=True)).reshape(-1, 3).astype(np.float32)
    return np.broadcast_to(eye.astype(np.float32), ways.shape).copy(), ways


def diffuse(mesh, origins, ways, rng):
    """Returns as many rays as there are camera rays. They start at the image's hits and go in
    random directions away from the surface."""
    hits = mesh.closest(origins, ways)
    hit = hits["triangle"] >= 0
    a, b, c = np.moveaxis(mesh.triangles[hits["triangle"][hit]].astype(float), 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    toward = ways[hit]
    normals *= -np.sign(np.einsum("ij,ij->i", normals, toward))[:, None]
    places = origins[hit] + hits["t"][hit, None] * toward
    size = np.ptp(mesh.vertices, axis=0).max()
    some = rng.normal(size=places.shape)
    some = some / np.linalg.norm(some, axis=1, keepdims=True) + normals
    some /= np.linalg.norm(some, axis=1, keepdims=True)
    starts = (places + normals * size * 1e-4).astype(np.float32)
    again = np.resize(np.arange(len(starts)), len(origins))
    return starts[again], some.astype(np.float32)[again]


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def kinds(mesh, origins, ways, rng):
    """Yields the rays of users besides an image in rows: name, origins, directions, and t_max for
    rays that only ask whether they hit anything."""
    count, half = len(origins), int(len(origins) ** 0.5) // 2
    hits = mesh.closest(origins, ways)
    hit = hits["triangle"] >= 0
    a, b, c = np.moveaxis(mesh.triangles[hits["triangle"][hit]].astype(float), 1, 0)
    normals = unit(np.cross(b - a, c - a))
    normals *= -np.sign(np.einsum("ij,ij->i", normals, ways[hit]))[:, None]
    size = np.ptp(mesh.vertices, axis=0).max()
    starts = origins[hit] + hits["t"][hit, None] * ways[hit] + 1e-4 * size * normals

    yield "rows", origins, ways, None
    order = rng.permutation(count)
    yield "shuffled", origins[order], ways[order], None
    ahead = ways[count // 2 + half]
    right = unit(np.cross(ahead, [0, 1, 0]))
    up = np.cross(right, ahead)
    x = np.linspace(-0.5, 0.5, 2 * half) * size
    plane = (origins[0] + x[None, :, None] * right - x[:, None, None] * up).reshape(-1, 3)
    yield "orthographic, rows", plane, np.broadcast_to(ahead, plane.shape), None
    yield "toward the sun", starts, np.broadcast_to(unit(np.array([0.4, 1.0, 0.3])), starts.shape), np.inf
    # A scanner that moves past the model, with 64 lasers.
    turn = np.linspace(0, 200 * np.pi, count // 64 * 64)
    lift = np.tile(np.linspace(-0.5, 0.5, 64), count // 64)
    along = np.stack([np.linspace(-1, 1, len(turn)), 0 * turn + 0.2, 0 * turn + 1.2], 1)
    lasers = np.stack([np.cos(turn) * np.cos(lift), np.sin(lift), np.sin(turn) * np.cos(lift)], 1)
    yield "scanner", mesh.vertices.mean(axis=0) + size * along, lasers, None
    # Sixteen short rays a point.
    some = slice(None, None, max(1, 16 * len(starts) // count))
    bent = unit(rng.normal(size=(len(starts[some]), 16, 3)))
    bent = unit(bent + 1.001 * normals[some, None])
    yield "occlusion", np.repeat(starts[some], 16, 0), (0.1 * size * bent).reshape(-1, 3), 1.0


def kinds_of(name, vertices, faces, rays, threads, seconds, rng):
    import intertri
    import open3d as o3d

    mesh = intertri.Mesh(vertices, faces)
    nthreads = threads or 0
    scene = o3d.t.geometry.RaycastingScene(nthreads=nthreads)
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(faces.astype(np.uint32)))
    title = f"{threads or 'all'} thread{'s' * (threads != 1)}"
    print(f"\n### {name}, t, u, v in float32, {title}\n\n| rays | with `out=` | default | Open3D | ratio |")
    print("| --- | --- | --- | --- | --- |")
    for kind, origins, ways, t_max in kinds(mesh, *rays, rng):
        origins, ways = (np.ascontiguousarray(x, dtype=np.float32) for x in (origins, ways))
        tensor = o3d.core.Tensor(np.concatenate([origins, ways], axis=1))
        if t_max is None:
            out = np.empty(len(origins), intertri.HIT32)
            contenders = {
                "out": lambda: mesh.closest(origins, ways, threads=threads, out=out),
                "default": lambda: mesh.closest(origins, ways, threads=threads, dtype=intertri.HIT32),
                "Open3D": lambda: scene.cast_rays(tensor, nthreads=nthreads),
            }
        else:
            out, far = np.empty(len(origins), bool), float(t_max)
            contenders = {
                "out": lambda: mesh.any(origins, ways, t_max=far, threads=threads, out=out),
                "default": lambda: mesh.any(origins, ways, t_max=far, threads=threads),
                "Open3D": lambda: scene.test_occlusions(tensor, tfar=far, nthreads=nthreads),
            }
        rates, _ = best(contenders, len(origins), seconds)
        ours, default, theirs = rates.values()
        print(f"| {kind} | {ours:.3g} | {default:.3g} | {theirs:.3g} | {ours / theirs:.2f} |", flush=True)


def best(contenders, count, seconds):
    """Returns the rate of each contender, in millions per second, and its last answer, both keyed
    by name."""
    rates, answers = {name: 0.0 for name in contenders}, {}
    for name, ask in contenders.items():
        answers[name] = ask()
    spent = 0.0
    while spent < seconds * len(contenders):
        for name, ask in contenders.items():
            began = time.perf_counter()
            answers[name] = ask()
            took = time.perf_counter() - began
            spent += took
            rates[name] = max(rates[name], count / took / 1e6)
    return rates, answers


def verdicts(mesh, origins, ways, ours, theirs, most=200):
    """Counts how often each of two contenders is correct on the rays for which they disagree,
    according to rational arithmetic."""
    differ = np.flatnonzero(ours != theirs)
    corners, said = mesh.triangles, {"ours": 0, "theirs": 0, "tie": 0}
    for i in differ[:most]:
        a = oracle.hit(corners[ours[i]], origins[i], ways[i]) if ours[i] >= 0 else None
        b = oracle.hit(corners[theirs[i]], origins[i], ways[i]) if theirs[i] >= 0 else None
        if a and b and a[0] == b[0]:
            said["tie"] += 1
        elif a and (not b or a[0] < b[0]) or ours[i] < 0 and not b:
            said["ours"] += 1
        else:
            said["theirs"] += 1
    return f"{len(differ)} differ" + (f" ({min(len(differ), most)} judged: " + ", ".join(
        f"{k} {v}" for k, v in said.items() if v) + ")" if len(differ) else "")


def table(title, rates, notes):
    print(f"\n### {title}\n\n| | million/s | |\n| --- | --- | --- |")
    for name, rate in rates.items():
        print(f"| {name} | {rate:.3g} | {notes.get(name, '')} |")
    sys.stdout.flush()


def rays_of(name, kind, vertices, faces, rays, threads, seconds):
    import intertri
    import intertri.trimesh
    import open3d as o3d
    import trimesh

    origins, ways = rays
    mesh = intertri.Mesh(vertices, faces)
    scene = o3d.t.geometry.RaycastingScene(nthreads=threads or 0)
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(faces.astype(np.uint32)))
    six = np.concatenate([origins, ways], axis=1)
    tensor, wide = o3d.core.Tensor(six), (origins.astype(float), ways.astype(float))
    out, found = np.empty(len(six), intertri.HIT), np.empty(len(six), np.int32)

    # Include the conversions from and to numpy, as in a user's program.
    def cast():
        return {key: value.numpy() for key, value in scene.cast_rays(tensor, nthreads=threads or 0).items()}

    contenders = {
        "intertri: closest": lambda: mesh.closest(origins, ways, threads=threads),
        "intertri: closest, out": lambda: mesh.closest(origins, ways, threads=threads, out=out),
        "intertri: closest_triangle, out": lambda: mesh.closest_triangle(origins, ways, threads=threads, out=found),
        "Open3D: cast_rays": cast,
    }
    if threads == 1:
        tm = trimesh.Trimesh(vertices, faces, process=False)
        embree = trimesh.ray.ray_pyembree.RayMeshIntersector(tm)
        contenders["trimesh + embreex: intersects_first"] = lambda: embree.intersects_first(*wide)
    else:
        tm = trimesh.Trimesh(vertices, faces, process=False)
        ours = intertri.trimesh.RayMeshIntersector(tm)
        contenders["intertri in trimesh: intersects_first, f64"] = lambda: ours.intersects_first(*wide)
    rates, answers = best(contenders, len(six), seconds)
    native = mesh._tree(mesh.dtype, None).seconds(mesh._rays(origins, ways, 0.0, np.inf), threads, 5)
    rates["the call in Rust, rays as given"] = len(six) / native[0] / 1e6
    rates["the call in Rust, rays by tiles"] = len(six) / native[1] / 1e6
    truth = answers["intertri: closest"]["triangle"]
    notes = {"Open3D: cast_rays": verdicts(mesh, origins, ways, truth, answers["Open3D: cast_rays"]["primitive_ids"].view(np.int32))}
    for other in ("trimesh + embreex: intersects_first", "intertri in trimesh: intersects_first, f64"):
        if other in answers:
            notes[other] = verdicts(mesh, origins, ways, truth, answers[other])
    table(f"{name}, {kind}, {threads or 'all'} thread{'s' * (threads != 1)}", rates, notes)


def lists_of(name, vertices, faces, rays, threads, seconds):
    import intertri
    import intertri.trimesh
    import open3d as o3d
    import trimesh

    origins, ways = rays
    mesh = intertri.Mesh(vertices, faces)
    wide = origins.astype(float), ways.astype(float)
    tm = trimesh.Trimesh(vertices, faces, process=False)
    embree = trimesh.ray.ray_pyembree.RayMeshIntersector(tm)
    ours = intertri.trimesh.RayMeshIntersector(tm)
    scene = o3d.t.geometry.RaycastingScene(nthreads=threads or 0)
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(faces.astype(np.uint32)))
    tensor = o3d.core.Tensor(np.concatenate([origins, ways], axis=1))
    contenders = {
        "intertri: all": lambda: mesh.all(origins, ways, threads=threads),
        "intertri: crossings": lambda: mesh.crossings(origins, ways, threads=threads),
        "Open3D: list_intersections": lambda: scene.list_intersections(tensor, nthreads=threads or 0)["t_hit"].numpy(),
    }
    if threads == 1:
        contenders["trimesh + embreex: intersects_id"] = lambda: embree.intersects_id(*wide)
    else:
        contenders["intertri in trimesh: intersects_id, f64"] = lambda: ours.intersects_id(*wide)
    rates, answers = best(contenders, len(origins), seconds)
    notes = {"intertri: all": f"{len(answers['intertri: all'].hits)} hits",
             "intertri: crossings": f"{len(answers['intertri: crossings'].hits)} hits",
             "Open3D: list_intersections": f"{len(answers['Open3D: list_intersections'])} hits"}
    for other in ("trimesh + embreex: intersects_id", "intertri in trimesh: intersects_id, f64"):
        if other in answers:
            notes[other] = f"{len(answers[other][0])} hits"
    table(f"{name}, all hits, {threads or 'all'} thread{'s' * (threads != 1)}", rates, notes)


def points_of(name, vertices, faces, count, threads, seconds, rng):
    import intertri
    import open3d as o3d
    import trimesh

    mesh = intertri.Mesh(vertices, faces)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    points = rng.uniform(low, high, (count, 3)).astype(np.float32)
    some = points[: count // 20]
    tm = trimesh.Trimesh(vertices, faces, process=False)
    scene = o3d.t.geometry.RaycastingScene(nthreads=threads or 0)
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(faces.astype(np.uint32)))
    tensor, fewer = o3d.core.Tensor(points), o3d.core.Tensor(some)
    nthreads, closed = threads or 0, {"assume_closed": not mesh.is_closed, "threads": threads}
    contenders = {
        "intertri: contains": lambda: mesh.contains(points, **closed),
        "Open3D: compute_occupancy": lambda: scene.compute_occupancy(tensor, nthreads=nthreads).numpy(),
    }
    if threads == 1:
        embree = trimesh.ray.ray_pyembree.RayMeshIntersector(tm)
        contenders["trimesh + embreex: contains"] = lambda: embree.contains_points(points)
    rates, answers = best(contenders, count, seconds)
    notes = {key: f"{(answers[key].astype(bool) != answers['intertri: contains']).sum()} differ"
             for key in answers if key != "intertri: contains"}
    title = f"{threads or 'all'} thread{'s' * (threads != 1)}"
    table(f"{name}, contains, {title}", rates, notes)
    contenders = {
        "intertri: signed_distance": lambda: mesh.signed_distance(some, **closed),
        "Open3D: compute_signed_distance": lambda: scene.compute_signed_distance(fewer, nthreads=nthreads).numpy(),
    }
    rates, answers = best(contenders, len(some), seconds)
    apart = abs(answers["intertri: signed_distance"] - answers["Open3D: compute_signed_distance"])
    table(f"{name}, signed distance, {title}", rates, {"Open3D: compute_signed_distance": f"at most {apart.max():.2g} apart"})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models")
    parser.add_argument("--rays", type=int, default=1024, help="rays per side of the image")
    parser.add_argument("--only", help="run only this scene")
    parser.add_argument("--ask", default="primary,diffuse,kinds,lists,points")
    parser.add_argument("--threads", default="1,0", help="thread counts, 0 for all")
    parser.add_argument("--seconds", type=float, default=0.6, help="seconds per contender")
    given = parser.parse_args()
    import intertri

    for name, vertices, faces in scenes(given.models):
        if given.only and name != given.only:
            continue
        rng = np.random.default_rng(1)
        print(f"\n## {name}: {len(faces)} triangles, {given.rays**2} rays")
        primary = camera(vertices, faces, given.rays)
        for threads in (int(t) or None for t in given.threads.split(",")):
            if "primary" in given.ask:
                rays_of(name, "primary", vertices, faces, primary, threads, given.seconds)
            if "diffuse" in given.ask:
                rays = diffuse(intertri.Mesh(vertices, faces), *primary, rng)
                rays_of(name, "diffuse", vertices, faces, rays, threads, given.seconds)
            if "kinds" in given.ask:
                kinds_of(name, vertices, faces, primary, threads, given.seconds, rng)
            if "lists" in given.ask:
                lists_of(name, vertices, faces, primary, threads, given.seconds)
            if "points" in given.ask:
                points_of(name, vertices, faces, given.rays**2, threads, given.seconds, rng)


if __name__ == "__main__":
    main()
