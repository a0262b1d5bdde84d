"""Keeps memory for answers and reuses it. The system provides new memory page by page, so a fast
query would spend much of its time waiting for pages."""

from __future__ import annotations

import contextlib
import math
import mmap
import weakref
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

LEAST = 1 << 20
"""The minimum size in bytes of an array that gets its own block. Smaller arrays come from numpy,
because the C library reuses their memory anyway."""

MOST = 1 << 28
"""The maximum total size of idle blocks in bytes."""

_PAGE = 1 << 21
"""The size of a huge page in bytes. Block sizes are multiples of it."""

_idle: list[mmap.mmap] = []


class _Loan:
    """Owns a block that is in use; the arrays in the block are made from this object. numpy keeps
    the object alive as long as one of these arrays, or a view of one, exists."""

    def __init__(self, block: mmap.mmap) -> None:
        self.__array_interface__ = np.frombuffer(block, np.uint8).__array_interface__


def empty(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """Returns an uninitialized array. Once its last view is gone, its memory is reused for another
    array."""
    dtype = np.dtype(dtype)
    size = math.prod(shape) * dtype.itemsize
    if size < LEAST:
        return np.empty(shape, dtype)
    block = _idle_block(size) or _new_block(size)
    if block is None:
        # Release all idle blocks first. If memory is still short, numpy raises a MemoryError.
        _idle.clear()
        return np.empty(shape, dtype)
    loan = _Loan(block)
    weakref.finalize(loan, _give_back, block).atexit = False
    return np.asarray(loan)[:size].view(dtype).reshape(shape)


def _idle_block(size: int) -> mmap.mmap | None:
    """Returns the smallest idle block that is large enough, or `None` if more than half of that
    block would be wasted."""
    for block in sorted(_idle, key=len):
        if size <= len(block) <= max(2 * size, _PAGE):
            # Another thread may have taken this block.
            with contextlib.suppress(ValueError):
                _idle.remove(block)
                return block
    return None


def _new_block(size: int) -> mmap.mmap | None:
    """Returns a new block from the system, or `None` if memory has run out."""
    size = -(-size // _PAGE) * _PAGE
    try:
        # Shared memory, the default, would let a forked process overwrite its parent's answers.
        block = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE) if hasattr(mmap, "MAP_PRIVATE") else mmap.mmap(-1, size)
    except (OSError, OverflowError, ValueError):
        return None
    _advise(block, "MADV_HUGEPAGE")
    return block


def _give_back(block: mmap.mmap) -> None:
    """Keeps a block for the next array. While it is idle, the system may reclaim its pages if
    memory becomes short."""
    _advise(block, "MADV_FREE")
    _idle.append(block)
    while sum(map(len, _idle)) > MOST:
        # Drop the oldest block, unless another thread has taken it.
        with contextlib.suppress(IndexError):
            _idle.pop(0)


def _advise(block: mmap.mmap, advice: str) -> None:
    """Gives the system a hint about a block, if the platform supports it."""
    if hasattr(mmap, advice):
        with contextlib.suppress(OSError):
            block.madvise(getattr(mmap, advice))
