"""How the hearing computes: on two threads at most, BLAS on one, and with memory that stays mapped, in small pages.

What takes long is computed part by part (`on_threads`), and a second thread takes some of the parts where there is a
second core. Only the thread that called `computing` has one: what listens frame by frame beside it keeps its core.

A separation of ten seconds takes and frees some 200 MB in arrays of up to 30 MB. glibc hands most of that back to the
kernel, which fills every page with zeros before it gives it out again, some tens of thousands in a mission. numpy asks
for huge pages: while the heap still grows, each is 2 MB that the kernel has to find and to fill at once, where a small
one is mostly at hand.
"""

from __future__ import annotations

import ctypes
import math
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3  # M_.. of glibc's malloc.h
LARGEST = 32 << 20  # what is larger is mapped by itself all the same; glibc allows no more [bytes]
SET_THP_DISABLE = 41  # PR_.. of linux/prctl.h
KEPT = 128 << 20  # freed, at most, at the end of the heap: more hardly spares pages, and is resident [bytes]

Part = TypeVar("Part")


class _Threads(threading.local):
    """What the calling thread may use beside itself."""

    decided = False  # whether it is within `computing`
    second: ThreadPoolExecutor | None = None
    spent = 0.0  # CPU time of the second one [s]


_threads = _Threads()


@contextmanager
def computing(threads: int | None = None) -> Iterator[None]:
    """Compute on few threads, and from then on keep memory that was freed for what comes next, in small pages.

    Parameters
    ----------
    threads
        1 or 2, which `on_threads` may use; None: 2 where this process has as many cores. Within another `computing` of
        this thread that one decides.
    """
    keep_memory()
    small_pages()
    with threadpool_limits(limits=1):
        if _threads.decided:
            yield
            return
        second = (cores() if threads is None else threads) > 1
        _threads.decided = True
        _threads.second = ThreadPoolExecutor(1, thread_name_prefix="computing") if second else None
        try:
            yield
        finally:
            if _threads.second is not None:
                _threads.second.shutdown()
            _threads.second, _threads.decided = None, False


def cores() -> int:
    """Return how many cores this process may use, at least 1."""
    found = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(int(min(found, quota())), 1)


def quota(root: Path = Path("/")) -> float:
    """Return how many cores' time the control groups of this process may take, inf: all.

    Two threads would take that of one core in half of each period, and then all threads would wait for the next one,
    the pump, too. See cpu.max in cgroup-v2.rst of the kernel; ``root`` is that of the file system.
    """
    try:
        groups = (root / "proc/self/cgroup").read_text()
    except OSError:  # not Linux
        return math.inf
    top, least = root / "sys/fs/cgroup", math.inf
    for path in (line.removeprefix("0::/") for line in groups.splitlines() if line.startswith("0::/")):
        group = top / path
        for folder in (group, *group.parents):
            if folder.is_relative_to(top):
                least = min(least, _share(folder / "cpu.max"))
    return least


def _share(limit: Path) -> float:
    """Return what a file ``cpu.max`` allows [cores]: "MAX PERIOD" or "max PERIOD"; the root has none."""
    try:
        most, period = limit.read_text().split()
        return math.inf if most == "max" else int(most) / int(period)
    except (OSError, ValueError, ZeroDivisionError):
        return math.inf


def on_threads(compute: Callable[[Part], object], parts: Iterable[Part]) -> None:
    """Call ``compute`` with every part, in any order, some on the second thread of `computing`, and wait for all.

    No part may need what another one writes. An error is raised, that of the calling thread if both fail; parts that
    were not begun by then never are.
    """
    todo = deque(parts)

    def work() -> None:
        try:
            while todo:
                try:
                    part = todo.popleft()
                except IndexError:  # the other thread has just taken the last one
                    return
                compute(part)
        except BaseException:
            todo.clear()
            raise

    if _threads.second is None or len(todo) < 2:
        work()
        return
    errors = np.geterr()

    def help_out() -> float:
        began = time.thread_time()
        with np.errstate(**errors):
            work()
        return time.thread_time() - began

    try:
        helping = _threads.second.submit(help_out)
    except RuntimeError:  # the interpreter ends, and begins nothing on other threads any more
        work()
        return
    try:
        work()
    except BaseException:  # Ctrl-C, too
        if not helping.cancel():
            wait([helping])
        raise
    if not helping.cancel():
        _threads.spent += helping.result()


def cpu_time() -> float:
    """Return the CPU time of the calling thread, with that of its second one [s]; only differences mean something."""
    return time.thread_time() + _threads.spent


def keep_memory() -> bool:
    """Let the allocator keep what is freed for what comes next, up to `KEPT`; tell whether it is one that can: glibc's.

    See mallopt(3).
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    return mallopt is not None and bool(mallopt(MMAP_THRESHOLD, LARGEST) and mallopt(TRIM_THRESHOLD, KEPT))


def small_pages() -> bool:
    """Let the kernel give no huge pages to this process from now on; tell whether it is one that can: Linux.

    See PR_SET_THP_DISABLE in prctl(2).
    """
    prctl = getattr(ctypes.CDLL(None), "prctl", None) if sys.platform == "linux" else None
    return prctl is not None and prctl(SET_THP_DISABLE, *map(ctypes.c_ulong, (1, 0, 0, 0))) == 0
