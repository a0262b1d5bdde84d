"""Draws slices of a mesh's voxels: white outside, blue inside, and red if the voxel's centre is on
the surface.

    python slices.py slices.png [model.obj]

Without a model, the script draws a hollow ball on a block whose faces pass through voxel centres.
"""

import struct
import sys
import zlib

import intertri
import numpy as np

SIZE = 96
COLOURS = np.array([[255, 255, 255], [70, 110, 180], [210, 60, 50]], np.uint8)


def globe(rings, centre, radius, is_turned=False):
    """Returns the triangles (n, 3, 3) of a ball, inside out if `is_turned`."""
    a, b = np.arange(rings + 1) / rings * np.pi, np.arange(2 * rings) / rings * np.pi
    r = np.where(np.arange(rings + 1) % rings == 0, 0, np.sin(a))[:, None]
    unit = np.stack(np.broadcast_arrays(r * np.cos(b), np.cos(a)[:, None], r * np.sin(b)), axis=-1)
    corners = np.array(centre) + radius * unit
    beside = np.roll(corners, -1, axis=1)
    one = np.stack([corners[:-1], beside[:-1], corners[1:]], axis=2).reshape(-1, 3, 3)
    other = np.stack([beside[1:], corners[1:], beside[:-1]], axis=2).reshape(-1, 3, 3)
    both = np.concatenate([one, other])
    return both[:, ::-1] if is_turned else both


def block(low, high):
    """Returns the triangles (12, 3, 3) of a box."""
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)], float)
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return corners[[face for a, b, c, d in sides for face in ([a, b, c], [a, c, d])]]


def write_png(path, pixels):
    """Writes an RGB image (height, width, 3) as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))


def main():
    if len(sys.argv) > 2:
        mesh = intertri.Mesh.read(sys.argv[2])
    else:
        hollow = [globe(48, (0, 0, 0.3), 0.9), globe(48, (0.1, 0, 0.4), 0.6, is_turned=True)]
        mesh = intertri.Mesh(np.concatenate([*hollow, block((-1, -1, -1), (1, 1, -0.5))]))
    low, high = mesh.bounds
    spacing = (high - low).max() / (SIZE - 1)
    voxels = mesh.voxels(low, spacing, np.ceil((high - low) / spacing).astype(int) + 1)
    # Sixteen slices along x, four per row, with z upward.
    slices = voxels[np.linspace(0, len(voxels) - 1, 16).astype(int), :, ::-1].swapaxes(1, 2)
    slices = np.pad(slices, ((0, 0), (2, 2), (2, 2)))
    _, height, width = slices.shape
    picture = slices.reshape(4, 4, height, width).swapaxes(1, 2).reshape(4 * height, 4 * width)
    write_png(sys.argv[1], COLOURS[picture])
    counts = np.bincount(voxels.reshape(-1), minlength=3)
    print(f"{voxels.shape}: {counts[1]} voxels inside, {counts[2]} on the surface, {counts[0]} outside")


if __name__ == "__main__":
    main()
