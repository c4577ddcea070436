"""Work in slices by several threads. ctypes lets other threads run during a call into C."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from ._arrays import whole

__all__ = ["in_slices"]

THREADS_MAX = 1024


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def in_slices(
    work: Callable[[int, int], None], count: int, size: int, threads: int | None
) -> None:
    """Calls work(a, b) for all of 0 .. count, at most `size` a time; threads None: as many
    as there are cores. An exception, an interrupt too, ends it soon."""
    most = cores() if threads is None else whole(threads, "threads", 1, THREADS_MAX)
    slices = [(a, min(a + size, count)) for a in range(0, count, size)]
    if min(most, len(slices)) <= 1:
        for a, b in slices:
            work(a, b)
        return
    pool = ThreadPoolExecutor(min(most, len(slices)))
    try:
        for done in [pool.submit(work, a, b) for a, b in slices]:
            done.result()
    finally:
        pool.shutdown(cancel_futures=True)
