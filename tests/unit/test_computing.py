"""Memory that was freed is used again as it is, in small pages; BLAS computes on one thread, the hearing on two."""

import math
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from ross_payload.computing import computing, cpu_time, keep_memory, on_threads, quota, small_pages
from ross_payload.interfaces import Scene
from ross_payload.separation.refined import Refined
from ross_payload.separation.refiner_features import trained_for

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
    """Pages that are given again when 96 MB are taken for the sixth time."""
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


def test_every_part_is_computed_once_on_both_threads() -> None:
    meet = threading.Barrier(2, timeout=10)
    seen: list[tuple[int, str]] = []

    def compute(part: int) -> None:
        if part < 2:
            meet.wait()  # the first two parts need two threads at once
        seen.append((part, threading.current_thread().name))

    with computing(threads=2):
        on_threads(compute, range(20))
    assert sorted(part for part, _ in seen) == list(range(20))
    assert len({name for _, name in seen}) == 2


def test_without_a_second_thread_parts_are_computed_one_after_the_other() -> None:
    names: list[str] = []

    def compute(part: int) -> None:
        names.append(f"{part} {threading.current_thread().name}")

    wanted = [f"{part} {threading.current_thread().name}" for part in range(3)]
    on_threads(compute, range(3))
    with computing(threads=1), computing(threads=2):  # the outer one decides
        on_threads(compute, range(3))
    assert names == 2 * wanted


@pytest.mark.parametrize(
    ("outer", "inner", "cores"),
    [("max 100000", "100000 100000", 1), ("150000 100000", "max 100000", 1.5), ("max 100000", "max 100000", math.inf)],
)
def test_a_second_thread_needs_the_time_of_a_second_core(tmp_path: Path, outer: str, inner: str, cores: float) -> None:
    group = tmp_path / "sys/fs/cgroup/machine/payload"
    group.mkdir(parents=True)
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/self/cgroup").write_text("1:cpu:/elsewhere\n0::/machine/payload\n")
    (group / "cpu.max").write_text(f"{inner}\n")
    (group.parent / "cpu.max").write_text(f"{outer}\n")
    assert quota(tmp_path) == cores


@pytest.mark.parametrize("groups", [None, "", "0::/\n", "0::/../away\n"])
def test_without_control_groups_nothing_is_limited(tmp_path: Path, groups: str | None) -> None:
    if groups is not None:
        (tmp_path / "proc/self").mkdir(parents=True)
        (tmp_path / "proc/self/cgroup").write_text(groups)
    assert quota(tmp_path) == math.inf


ENDING = """
import atexit
import threading
import time
from ross_payload.computing import computing, on_threads

def listen():
    with computing(threads=2):
        while True:
            on_threads(lambda _: time.sleep(0.001), range(4))

threading.Thread(target=listen, daemon=True).start()
time.sleep(0.2)
atexit.register(time.sleep, 0.3)  # called when pools of threads take nothing any more
"""


def test_a_thread_that_computes_to_the_end_of_the_program_says_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, check=True)
    assert done.stderr == ""


def test_another_thread_computes_alone() -> None:
    names: set[str] = set()

    def listen() -> None:
        on_threads(lambda _: names.add(threading.current_thread().name), range(50))

    with computing(threads=2):
        listening = threading.Thread(target=listen, name="listening")
        listening.start()
        listening.join()
    assert names == {"listening"}


@pytest.mark.parametrize("fails", [0, 1, 7])
def test_the_first_error_ends_it_and_is_raised(fails: int) -> None:
    begun: list[int] = []

    def compute(part: int) -> None:
        begun.append(part)
        if part == fails:
            raise ZeroDivisionError
        time.sleep(0.001)

    with computing(threads=2), pytest.raises(ZeroDivisionError):
        on_threads(compute, range(1000))
    assert len(begun) < 100
    after = len(begun)
    time.sleep(0.02)
    assert len(begun) == after


def test_ctrl_c_is_not_lost_to_an_error_of_the_second_thread() -> None:
    meet, caller = threading.Barrier(2, timeout=10), threading.current_thread()

    def compute(_: int) -> None:
        meet.wait()
        if threading.current_thread() is caller:
            raise KeyboardInterrupt
        raise ZeroDivisionError

    with computing(threads=2), pytest.raises(KeyboardInterrupt):
        on_threads(compute, range(2))


def test_what_numpy_says_of_errors_is_the_same_on_both_threads() -> None:
    meet, told = threading.Barrier(2, timeout=10), list[str]()

    def compute(_: int) -> None:
        meet.wait()
        told.append(np.geterr()["divide"])

    with computing(threads=2), np.errstate(divide="raise"):
        on_threads(compute, range(2))
    assert told == ["raise", "raise"]


def test_the_time_of_the_second_thread_counts() -> None:
    meet = threading.Barrier(2, timeout=10)

    def compute(_: int) -> None:
        meet.wait()
        until = time.thread_time() + 0.05
        while time.thread_time() < until:
            pass

    with computing(threads=2):
        before = cpu_time()
        on_threads(compute, range(2))
    assert cpu_time() - before >= 0.1


def test_two_threads_separate_to_the_last_bit_as_one_does() -> None:
    rng = np.random.default_rng(3)
    frequencies = np.arange(1025) * 7.8125
    assert trained_for(frequencies)
    shape = (2, 1025, 60)  # several parts of every loop
    spectrogram = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    scene = Scene(frequencies, 0.05, 343.0, 2, tau=np.array([-1e-4, 1e-4]))
    with computing(threads=1):
        alone = Refined().batch(spectrogram, scene)
    with computing(threads=2):
        both = Refined().batch(spectrogram, scene)
    np.testing.assert_array_equal(alone.signals, both.signals)
