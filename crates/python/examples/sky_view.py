"""Computes, for points on the ground of a town, how much of the view is sky and how much of it each
house fills.

    python sky_view.py [picture.png]

The town is in UTM coordinates, millions of metres from the origin, where adjacent float32 values
are half a metre apart.
"""

import sys

import intertri
import numpy as np

ORIGIN = np.array([691_604.31, 5_335_802.77, 519.4])  # Munich, zone 32N


def box(low, high):
    """Returns the walls and the roof of a house: 8 corners and 10 triangles."""
    corners = np.array(np.meshgrid(*zip(low, high), indexing="ij")).reshape(3, -1).T
    quads = np.array([[0, 4, 5, 1], [4, 6, 7, 5], [6, 2, 3, 7], [2, 0, 1, 3], [1, 5, 7, 3]])
    return corners, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def directions(count):
    """Returns upward directions, cosine-weighted, so that the share of rays reaching a surface is
    its view factor."""
    i = np.arange(count)
    radius, angle = np.sqrt((i + 0.5) / count), i * np.pi * (3 - np.sqrt(5))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)], axis=-1)


def town():
    """Returns the mesh of a town and the number of the house to which each triangle belongs."""
    random = np.random.default_rng(1)
    houses = []
    for x in range(0, 240, 40):
        for y in range(0, 240, 60):
            height = random.uniform(8, 30)
            houses.append(box(ORIGIN + [x, y, 0], ORIGIN + [x + 24, y + 44, height]))
    vertices = np.concatenate([corners for corners, _ in houses])
    faces = np.concatenate([8 * i + triangles for i, (_, triangles) in enumerate(houses)])
    return intertri.Mesh(vertices, faces), np.repeat(np.arange(len(houses)), 10)


def view_factors(mesh, house, points, rays):
    """Returns the fraction of each point's hemisphere that is filled by each house, followed by the
    sky. The fractions add up to one."""
    triangle = mesh.closest_triangle(points[:, None], rays)
    seen = np.where(triangle < 0, house.max() + 1, house[triangle])
    return np.stack([np.bincount(row, minlength=house.max() + 2) for row in seen]) / len(rays)


def main():
    rays = directions(2000)

    # A long street, 20 m wide, between walls 15 m high. In the middle of the street, the sky view
    # factor is the cosine of the angle at which the walls rise above the horizon.
    walls = [box(ORIGIN + [x, -1e5, 0], ORIGIN + [x + 1, 1e5, 15]) for x in (-11, 10)]
    street = intertri.Mesh(np.concatenate([walls[0][0], walls[1][0]]), np.concatenate([walls[0][1], walls[1][1] + 8]))
    middle = view_factors(street, np.repeat([0, 1], 10), ORIGIN[None], rays)[0]
    left, right, sky = middle
    print(f"street: sky {sky:.4f}, by formula {np.cos(np.arctan(15 / 10)):.4f}, walls {left:.4f}, {right:.4f}")

    mesh, house = town()
    x, y = np.meshgrid(np.arange(-8, 236, 2.0), np.arange(-8, 236, 2.0))
    points = (ORIGIN + np.stack([x, y, np.zeros_like(x)], axis=-1)).reshape(-1, 3)
    # Points inside houses see only the roofs and walls from inside.
    views = np.concatenate([view_factors(mesh, house, part, rays) for part in np.array_split(points, 16)])
    sky = views[:, -1]
    print(f"town: {len(mesh)} triangles, {len(points) * len(rays)} rays, sky {sky[sky > 0].min():.3f} to {sky.max():.3f}")
    most = views[sky > 0][:, :-1].max()
    print(f"one house fills at most {most:.3f} of a view")

    if len(sys.argv) > 1:
        from PIL import Image

        grey = (255 * sky.reshape(x.shape)[::-1]).astype(np.uint8)
        Image.fromarray(grey).resize((488, 488), Image.Resampling.NEAREST).save(sys.argv[1])


if __name__ == "__main__":
    main()
