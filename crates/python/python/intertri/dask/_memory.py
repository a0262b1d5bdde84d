"""Reuses memory for answers, because the system provides new memory page by page and tracing would
have to wait for it."""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MOST = 2


class _Loan:
    """Keeps memory alive while an array or a view of it exists: numpy holds a reference to the
    object from which an array was made."""

    def __init__(self, memory: NDArray[Any]) -> None:
        self.__array_interface__ = memory.__array_interface__


class Lender:
    """Lends arrays. When the last view of an array is gone, its memory can be lent again."""

    def __init__(self) -> None:
        self._idle: list[NDArray[Any]] = []

    def empty(self, count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
        """An uninitialized array."""
        try:
            memory = self._idle.pop()
        except IndexError:
            memory = None
        if memory is None or memory.shape != (count,) or memory.dtype != dtype:
            memory = np.empty(count, dtype)
        loan = _Loan(memory)
        weakref.finalize(loan, self._back, memory).atexit = False
        return np.asarray(loan)

    def _back(self, memory: NDArray[Any]) -> None:
        if len(self._idle) < _MOST:
            self._idle.append(memory)
