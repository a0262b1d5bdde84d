"""Simulates a lidar that scans a house behind a tree and records every return of each pulse.

    python lidar.py [picture.png]

The coordinates are in UTM, as in survey data. Rounding to float32 would move them by up to a
quarter of a metre.
"""

import sys

import intertri
import numpy as np

ORIGIN = np.array([691_604.31, 5_335_802.77, 519.4])  # Munich, zone 32N


def quad(a, b, d):
    a, b, d = (np.array(point, float) for point in (a, b, d))
    return np.array([[a, b, b + d - a], [a, b + d - a, d]])


def scene():
    """Returns the triangles (n, 3, 3) of the ground, a house front with a window, and a crown of
    leaves."""
    random = np.random.default_rng(1)
    ground = quad((-40, -40, 0), (40, -40, 0), (-40, 40, 0))
    front = [quad((-15, 10, 0), (3, 10, 0), (-15, 10, 9)), quad((7, 10, 0), (15, 10, 0), (7, 10, 9))]
    window = [quad((3, 10, 0), (7, 10, 0), (3, 10, 2)), quad((3, 10, 6), (7, 10, 6), (3, 10, 9))]
    centres = random.normal(size=(3000, 1, 3)) * [1.3, 1.3, 1] + [-6, 5, 4.5]
    leaves = centres + random.normal(size=(3000, 3, 3)) * 0.1
    return ORIGIN + np.concatenate([ground, *front, *window, leaves])


def pulses(rows, columns):
    """Returns the directions (rows, columns, 3) of one sweep past the front, top row first."""
    up, around = np.meshgrid(np.linspace(0.55, -0.45, rows), np.linspace(-1.1, 1.1, columns), indexing="ij")
    return np.stack([np.cos(up) * np.sin(around), np.cos(up) * np.cos(around), np.sin(up)], axis=-1)


def main():
    corners = scene()
    mesh = intertri.Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    scanner, directions = ORIGIN + [0, -6, 2], pulses(256, 1024)

    # Find every return in order of distance; those of pulse i are hits[offsets[i]:offsets[i + 1]].
    lists = mesh.all(scanner, directions, t_max=60.0)
    returns = np.diff(lists.offsets)
    print(f"{returns.size} pulses, {len(lists.hits)} returns")
    for n in range(4):
        print(f"  {(returns == n).sum():6} pulses with {n} returns")
    print(f"  {(returns > 3).sum():6} pulses with more, at most {returns.max()}")

    # The last return of a pulse is behind all leaves that it hits. A last return on the ground
    # should be at the ground's height.
    last = lists.hits[lists.offsets[1:][returns > 0] - 1]
    height = mesh.hit_points(last[last["triangle"] < 2])[:, 2] - ORIGIN[2]
    print(f"ground: {len(height)} last returns, off by at most {np.abs(height).max():.1e} m")
    print(f"float32 would move the scanner by {np.abs(scanner.astype(np.float32) - scanner).max():.2f} m")

    if len(sys.argv) > 1:
        from PIL import Image

        first = mesh.closest(scanner, directions, t_max=60.0)["t"]
        near = np.where(first < 60, 255 * np.exp(-first / 12), 0).astype(np.uint8)
        Image.fromarray(near).save(sys.argv[1])


if __name__ == "__main__":
    main()
