"""Memory that was freed is used again as it is, in small pages, and BLAS computes on one thread."""

import subprocess
import sys

import pytest
from threadpoolctl import threadpool_info

from ross_payload.computing import computing, keep_memory, small_pages

FAULTS = """
import resource
import numpy as np
from ross_payload.computing import keep_memory

{keep}
for turn in range(6):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    arrays = [np.ones(400_000) for _ in range(30)]  # 96 MB
    del arrays
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(keep: str) -> int:
    """Pages that are given anew when 96 MB are taken for the sixth time."""
    done = subprocess.run([sys.executable, "-c", FAULTS.format(keep=keep)], capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.mark.skipif(not keep_memory(), reason="hardware: another allocator than glibc's")
def test_memory_that_was_freed_is_not_asked_for_again() -> None:
    assert faults("pass") > 10_000
    assert faults("keep_memory()") < 100


PAGES = """
import ctypes
from ross_payload.computing import computing

SET, GET = 41, 42  # PR_.._THP_DISABLE
call = ctypes.CDLL(None).prctl
call(SET, *map(ctypes.c_ulong, (0, 0, 0, 0)))  # a child has what its parent has
print(call(GET, *map(ctypes.c_ulong, (0, 0, 0, 0))))
with computing():
    print(call(GET, *map(ctypes.c_ulong, (0, 0, 0, 0))))
"""


@pytest.mark.skipif(not small_pages(), reason="hardware: another kernel than Linux")
def test_no_huge_page_is_given_while_it_computes() -> None:
    done = subprocess.run([sys.executable, "-c", PAGES], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["0", "1"]


def test_matrices_are_multiplied_on_one_thread() -> None:
    with computing():
        assert {pool["num_threads"] for pool in threadpool_info()} == {1}
