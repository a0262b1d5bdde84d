"""Traces all rays in one call with libigl's f64 tree, through libigl's Python package.

tracer.h describes the protocol between this program and the benchmark.
"""

import sys

import igl
import numpy as np


def main(path):
    content = open(path, "rb").read()
    at = 0

    def take(kind, count):
        nonlocal at
        values = np.frombuffer(content, kind, count, at)
        at += values.nbytes
        return values

    triangles = int(take("<u8", 1)[0])
    corners = take("<f8", 9 * triangles).reshape(-1, 3).copy()
    any_hit, count = bool(take("<u8", 1)[0]), int(take("<u8", 1)[0])
    rays = take("<f8", 7 * count).reshape(-1, 7)
    # Merge equal corners into one vertex, as in the indexed meshes that users of libigl have.
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    faces = np.ascontiguousarray(index.reshape(-1, 3), dtype=np.int64)
    tree = igl.AABB()
    tree.init(vertices, faces)
    origins, directions = (np.ascontiguousarray(rays[:, i : i + 3]) for i in (0, 3))
    ends = rays[:, 6]
    answers = np.full(count, -1, "<i4")
    print("ready", flush=True)
    for line in sys.stdin:
        if line.strip() == "answers":
            answers.tofile(path + ".answers")
        else:
            part = slice(*map(int, line.split()))
            found, t, _ = tree.intersect_ray_first(vertices, faces, origins[part], directions[part])
            found = np.where(t <= ends[part], found, -1)
            answers[part] = np.where(found >= 0, 0, -1) if any_hit else found
        print("done", flush=True)


main(sys.argv[1])
