"""How tasks get done: a seam of ten lines.

An engine is a function of a function and its tasks that yields results as they come, in any order. On a Dask cluster
it would be ``lambda function, tasks: (result for _, result in as_completed(client.map(function, tasks),
with_results=True))``.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Any

from ross_payload.errors import OutputError

Engine = Callable[[Callable[[Any], Any], Sequence[Any]], Generator[Any]]


def serial(function: Callable[[Any], Any], tasks: Sequence[Any]) -> Generator[Any]:
    """Do one task after the other in this process."""
    yield from map(function, tasks)


def processes(workers: int) -> Engine:
    """Do tasks in so many fresh processes of this machine, with one numeric thread each.

    Raises
    ------
    OutputError
        While yielding, when a process dies.
    """

    def run(function: Callable[[Any], Any], tasks: Sequence[Any]) -> Generator[Any]:
        os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_obedient)
        try:
            for done in as_completed([pool.submit(function, task) for task in tasks]):
                yield done.result()
            pool.shutdown()
        except BrokenProcessPool as error:
            raise OutputError("a worker process died (killed, or out of memory)") from error
        finally:
            _end(pool)

    return run


def _obedient() -> None:
    """Let the parent alone react to Ctrl-C, and end when it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=[parent], daemon=True).start()


def _end_with(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


def _end(pool: ProcessPoolExecutor) -> None:
    """End the processes of a pool at once, whatever they do, and wait until its thread has seen it.

    That thread closes a pipe as its last act. Until it has, the exit hook of `concurrent.futures` may write to that
    pipe after looking whether it is open, and fail with a traceback after all was said and kept. A second Ctrl-C must
    not cut the wait short: it would leave the same race.
    """
    for process in list((pool._processes or {}).values()):
        process.kill()
    with _deaf():
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _deaf() -> Generator[None]:
    """Do not hear Ctrl-C for a moment; other threads than the main one never do."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
