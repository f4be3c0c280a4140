"""How tasks get done: one after the other, in processes of this computer, or on a cluster (`dask_engine`).

An engine is a function of a function and its tasks that yields results as they come, in any order.
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
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from typing import Any, Protocol

from ross_payload.errors import OutputError

Engine = Callable[[Callable[[Any], Any], Sequence[Any]], Generator[Any]]


class Named(Protocol):
    """A task."""

    @property
    def id(self) -> str:
        """What it is called in the journal."""

    @property
    def room(self) -> str:
        """Tasks of one room share impulse responses, which are computed once if they are done together."""


@dataclass(frozen=True, slots=True)
class EngineChoice:
    """Who does the tasks."""

    workers: int | None = None  # processes of this computer; None: one per core
    dask: bool = False
    scheduler: str | None = None  # of a Dask cluster, tcp://HOST:PORT; None: one of this computer

    @property
    def processes(self) -> int:
        """How many processes of this computer there shall be."""
        return self.workers or os.cpu_count() or 1


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
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_obedient)
        try:
            with _interrupts_deferred(), _one_thread_each():
                futures = [pool.submit(function, task) for task in tasks]
            for done in as_completed(futures):
                yield done.result()
            pool.shutdown()
        except BrokenProcessPool as error:
            raise OutputError("a worker process died (killed, or out of memory)") from error
        finally:
            _end(pool)

    return run


@contextmanager
def _one_thread_each() -> Generator[None]:
    """Let the libraries of processes that are started meanwhile have one thread; the environment is as before then."""
    before = dict(os.environ)
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
    try:
        yield
    finally:
        for name in set(os.environ) - set(before):
            del os.environ[name]
        os.environ.update(before)


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
    not cut this short: it would leave the same race, or processes that nobody ends.
    """
    with _interrupts_ignored():
        for process in list((pool._processes or {}).values()):
            process.kill()
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _interrupts_ignored() -> Generator[None]:
    """Ignore Ctrl-C; other threads than the main one never hear it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _interrupts_deferred() -> Generator[None]:
    """Let Ctrl-C count at the end, and never in processes that are started meanwhile.

    Cut short, `ProcessPoolExecutor.submit` leaves a process or a thread that the pool does not know of. A terminal
    sends the signal to the workers as well, and to ignore it they must first have imported this module: until then
    (seconds, where nothing is compiled yet) it would end them with a traceback each. They inherit the mask.
    """
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # others neither hear it nor pass it on
        yield
        return
    interrupted = threading.Event()
    before = signal.signal(signal.SIGINT, lambda number, frame: interrupted.set())
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)  # one that is pending comes now
        signal.signal(signal.SIGINT, before)
    if interrupted.is_set():
        raise KeyboardInterrupt
