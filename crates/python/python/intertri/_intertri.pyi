"""The native part. `intertri.Mesh` is the interface."""

import os
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ._arrays import Rays

__version__: str
SURFACE: int

def checksum(bytes: NDArray[np.uint8]) -> int: ...
def read_model(path: str | os.PathLike[str]) -> tuple[NDArray[np.float64], NDArray[np.uint32], list[str]]: ...

class _Tree:
    def closest(
        self, rays: Rays, mode: str, threads: int | None, width: int, out: NDArray[np.uint8]
    ) -> None: ...
    def triangles(
        self, rays: Rays, mode: str, threads: int | None, width: int, out: NDArray[np.uint8]
    ) -> None: ...
    def any(
        self, rays: Rays, mode: str, threads: int | None, width: int, out: NDArray[np.bool_]
    ) -> None: ...
    def visible(
        self, rays: Rays, threads: int | None, width: int, bits: int, out: NDArray[np.bool_]
    ) -> None: ...
    @staticmethod
    def spawn_rays(
        vertices: NDArray[Any],
        faces: NDArray[np.uint32],
        hits: NDArray[np.uint8],
        directions: NDArray[Any],
        threads: int | None,
        out: NDArray[Any],
    ) -> None: ...
    def all(
        self, rays: Rays, mode: str, threads: int | None, width: int, limit: int | None
    ) -> tuple[NDArray[np.int64], NDArray[np.uint64]]: ...
    def crossings(
        self, rays: Rays, threads: int | None, width: int
    ) -> tuple[NDArray[np.int64], NDArray[np.uint64]]: ...
    def count_crossings(
        self, rays: Rays, threads: int | None, width: int, out: NDArray[np.uint8]
    ) -> None: ...
    def winding(
        self, points: NDArray[Any], assume_closed: bool, threads: int | None, out: NDArray[np.uint8]
    ) -> None: ...
    def winding_number(
        self, points: NDArray[Any], threads: int | None, out: NDArray[np.uint8]
    ) -> None: ...
    def voxels(
        self, axes: list[NDArray[Any]], assume_closed: bool, threads: int | None, out: NDArray[np.uint8]
    ) -> None: ...
    def closest_point(
        self, points: NDArray[Any], radius: float, threads: int | None, out: NDArray[np.uint8]
    ) -> None: ...
    def signed_distance(
        self, points: NDArray[Any], assume_closed: bool, threads: int | None, out: NDArray[np.uint8]
    ) -> None: ...

    def seconds(self, rays: Rays, threads: int | None, times: int) -> tuple[float, float]: ...
    def to_bytes(self) -> bytes: ...
    def refit(self, vertices: NDArray[Any], faces: NDArray[np.uint32], threads: int | None) -> float: ...
    @staticmethod
    def is_closed(vertices: NDArray[Any], faces: NDArray[np.uint32]) -> bool: ...
    @staticmethod
    def inspect(vertices: NDArray[Any], faces: NDArray[np.uint32]) -> tuple[str, list[int]]: ...

@final
class Tree32(_Tree):
    def __new__(
        cls, vertices: NDArray[Any], faces: NDArray[np.uint32], threads: int | None
    ) -> Tree32: ...
    @staticmethod
    def from_bytes(saved: bytes, triangles: int) -> Tree32: ...

@final
class Tree64(_Tree):
    def __new__(
        cls, vertices: NDArray[Any], faces: NDArray[np.uint32], threads: int | None
    ) -> Tree64: ...
    @staticmethod
    def from_bytes(saved: bytes, triangles: int) -> Tree64: ...

class _Media:
    def medium_at(self, points: NDArray[Any], threads: int | None, out: NDArray[np.uint8]) -> None: ...
    def next_crossing(self, rays: Rays, threads: int | None, width: int, out: NDArray[np.uint8]) -> None: ...
    def segments(
        self, rays: Rays, threads: int | None, width: int
    ) -> tuple[NDArray[np.int64], NDArray[np.uint64]]: ...

@final
class Media32(_Media):
    def __new__(
        cls, meshes: list[tuple[NDArray[Any], NDArray[np.uint32]]], filled: list[int], threads: int | None
    ) -> Media32: ...

@final
class Media64(_Media):
    def __new__(
        cls, meshes: list[tuple[NDArray[Any], NDArray[np.uint32]]], filled: list[int], threads: int | None
    ) -> Media64: ...
