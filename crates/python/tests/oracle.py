"""Computes the exact answers with a plain loop in rational arithmetic, directly from the
definitions and independently of the package."""

from fractions import Fraction
from math import inf, isfinite

import numpy as np


def _exact(row):
    return tuple(Fraction(float(x)) for x in row)


def _minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def _sign(x):
    return (x > 0) - (x < 0)


def _volumes(triangle, origin, direction):
    a, b, c = (_minus(_exact(corner), origin) for corner in triangle)
    normals = _cross(b, c), _cross(c, a), _cross(a, b)
    return normals, [_dot(direction, n) for n in normals], _dot(a, normals[0])


def _in(t, t_min, t_max):
    return (t > 0 and (t_min == -inf or t >= Fraction(float(t_min)))
            and (t_max == inf or isfinite(t_max) and t < Fraction(float(t_max))))


def hit(triangle, origin, direction, t_min=0.0, t_max=inf):
    """Returns (t, u, v) of the hit on the closed triangle, or None."""
    origin, direction = _exact(origin), _exact(direction)
    _, (u, v, w), t = _volumes(triangle, origin, direction)
    d = u + v + w
    side = _sign(d)
    if side == 0 or _sign(t) != side or any(_sign(x) == -side for x in (u, v, w)):
        return None
    return (t / d, v / d, w / d) if _in(t / d, t_min, t_max) else None


def single(x):
    """Returns the float32 nearest to a fraction. Rounding to float64 first could give another one."""
    about = np.float32(float(x))
    near = about, np.nextafter(about, np.float32(-inf)), np.nextafter(about, np.float32(inf))
    # Of two that are equally near, the even one is right.
    return min(near, key=lambda y: (abs(Fraction(float(y)) - x), y.view(np.uint32) % 2))


def crossing(triangle, origin, direction, t_min=0.0, t_max=inf):
    """Returns (t, side) of the crossing, or None. An edge or corner counts for only one of its
    triangles. A side of 1 means that the ray leaves the solid."""
    origin, direction = _exact(origin), _exact(direction)
    normals, volumes, t = _volumes(triangle, origin, direction)
    side = _sign(t)
    if side == 0:
        return None
    for normal, volume in zip(normals, volumes):
        first = next((x for x in (volume, *normal) if x != 0), 0)
        if _sign(first) != side:
            return None
    t = t / sum(volumes)
    return (t, side) if _in(t, t_min, t_max) else None


def all_hits(triangles, origin, direction, t_min=0.0, t_max=inf):
    """Returns [(t, u, v, triangle)] sorted by t, then by triangle."""
    hits = []
    for number, triangle in enumerate(triangles):
        found = hit(triangle, origin, direction, t_min, t_max)
        if found:
            hits.append((*found, number))
    return sorted(hits, key=lambda hit: (hit[0], hit[3]))


def closest(triangles, origin, direction, t_min=0.0, t_max=inf):
    """Returns (t, u, v, triangle), or None."""
    return next(iter(all_hits(triangles, origin, direction, t_min, t_max)), None)


def crossings(triangles, origin, direction, t_min=0.0, t_max=inf):
    """Returns [(t, triangle, side)] sorted by t, then by triangle."""
    found = []
    for number, triangle in enumerate(triangles):
        one = crossing(triangle, origin, direction, t_min, t_max)
        if one:
            found.append((one[0], number, one[1]))
    return sorted(found)


def squared_distance(triangle, point):
    """Returns the square of the distance from a point to a closed triangle."""
    p = _exact(point)
    a, b, c = (_exact(corner) for corner in triangle)
    ab, ac = _minus(b, a), _minus(c, a)
    n = _cross(ab, ac)
    best = None
    if any(n):
        # The weights of the foot of the perpendicular show whether it is inside the triangle.
        ap = _minus(p, a)
        v = _dot(_cross(ap, ac), n) / _dot(n, n)
        w = _dot(_cross(ab, ap), n) / _dot(n, n)
        if v >= 0 and w >= 0 and v + w <= 1:
            best = _dot(ap, n) ** 2 / _dot(n, n)
    for start, end in ((a, b), (b, c), (c, a)):
        way, to = _minus(end, start), _minus(p, start)
        length = _dot(way, way)
        s = max(Fraction(0), min(Fraction(1), _dot(to, way) / length)) if length else Fraction(0)
        rest = _minus(to, tuple(s * x for x in way))
        distance = _dot(rest, rest)
        best = distance if best is None else min(best, distance)
    return best
