"""How the hearing computes: BLAS on one thread, and with memory that stays mapped, in small pages.

A separation of ten seconds takes and frees some 200 MB in arrays of up to 30 MB. glibc hands most of that back to the
kernel, which fills every page with zeros before it gives it out again, some tens of thousands in a mission. numpy asks
for huge pages: while the heap still grows, each is 2 MB that the kernel has to find and to fill at once, where a small
one is mostly at hand.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3  # M_.. of glibc's malloc.h
LARGEST = 32 << 20  # what is larger is mapped by itself all the same; glibc allows no more [bytes]
SET_THP_DISABLE = 41  # PR_.. of linux/prctl.h
KEPT = 128 << 20  # freed, at most, at the end of the heap: more hardly spares pages, and is resident [bytes]


@contextmanager
def computing() -> Iterator[None]:
    """Compute on one thread, and from then on keep memory that was freed for what comes next, in small pages."""
    keep_memory()
    small_pages()
    with threadpool_limits(limits=1):
        yield


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
