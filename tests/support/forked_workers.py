"""Tests run in processes that are forked from the one that has collected them: what all need is imported once.

`ForkedWorkers` takes the place of pytest's loop over the tests. It runs stages, one after the other. The workers of a
stage take its tests from a queue, file by file, since those of a file share fixtures; when no file is left, they take
half of what another has left. Beside a stage that leaves the processors time (`Stage.spare`), or has fewer workers left
than it may have, those of the ``spare`` stage begin with tests of a later one.

A worker sends its reports in the form that pytest has for it. One that ends before it is told to has failed the test
that it ran, and another takes its place.
"""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import groupby
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import monotonic
from typing import Any, NoReturn

import pytest
from _pytest import runner  # as plug-ins that run a test again have it


@dataclass(frozen=True)
class Stage:
    """Lanes that run beside each other, in so many processes."""

    lanes: tuple[str, ...]
    workers: int
    niceness: int = 0
    spare: bool = False  # whether it leaves the processors time, for more than its end
    quiet: bool = False  # whether nothing of another stage runs beside it

    def __str__(self) -> str:
        return ", ".join(self.lanes)


class Queue:
    """Numbers of tests that wait, file by file."""

    def __init__(self, numbers: Iterable[int], file_of: Callable[[int], Path]) -> None:
        self._files = deque(deque(own) for _, own in groupby(numbers, file_of))
        self._taken: list[deque[int]] = []

    def take(self) -> deque[int]:
        """Return the tests of the next file, or half of what another has left of its own."""
        if self._files:
            self._taken.append(self._files.popleft())
        else:
            most = max(self._taken, key=len, default=deque[int]())
            half = [most.pop() for _ in range((len(most) + 1) // 2)]
            self._taken.append(deque(reversed(half)))
        self._taken = [own for own in self._taken if own]
        return self._taken[-1] if self._taken else deque()

    def give_back(self, numbers: Iterable[int]) -> None:
        """Let these be the next."""
        self._files.extendleft([deque(numbers)] if numbers else [])

    def clear(self) -> None:
        """Let nothing wait any more."""
        for own in (*self._taken, self._files):
            own.clear()


@dataclass(eq=False)
class Worker:
    """A process that runs tests; it knows one more than it runs, and so which fixtures to keep."""

    stage: Stage
    pid: int
    connection: Connection
    ended: int  # a descriptor that can be read when the process has ended (pidfd_open(2))
    own: deque[int] = field(default_factory=deque)  # of its file
    told: deque[int] = field(default_factory=deque)  # what it runs, and what comes then
    last: int = -1
    stays: bool = True

    def tell(self, number: int | None) -> None:
        """Tell what comes then; None: nothing."""
        self.stays = number is not None
        self.told += () if number is None else (number,)
        with suppress(OSError):  # it has ended, which is heard of elsewhere
            self.connection.send(number)


class ForkedWorkers:
    """The loop over the tests, for `pytest.main(plugins=[...])`; ``prepare`` is called in every worker of a stage."""

    def __init__(self, stages: Iterable[Stage], spare: Stage, prepare: Callable[[Stage], None]) -> None:
        self._stages, self._spare, self._prepare = tuple(stages), spare, prepare
        self._workers: list[Worker] = []
        self._begun = self._done = 0

    @staticmethod
    def runs(config: pytest.Config) -> bool:
        """Whether this runs the tests; not so when somebody wants to look into them, or asks for other workers."""
        there = any(isinstance(plugin, ForkedWorkers) for plugin in config.pluginmanager.get_plugins())
        option = config.option
        return there and not (
            option.collectonly or option.usepdb or option.trace or getattr(option, "numprocesses", None)
        )

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Run every stage."""
        if not self.runs(session.config) or (
            session.testsfailed and not session.config.option.continue_on_collection_errors
        ):
            return None  # pytest knows what to do
        self._session, self._hook = session, session.config.hook
        self._folder = session.config._tmp_path_factory.getbasetemp()  # type: ignore[attr-defined]
        self._queues = {stage.lanes: self._queue_of(stage) for stage in self._stages}
        lanes = {lane for stage in self._stages for lane in stage.lanes}
        if left := [item for item in session.items if not any(map(item.get_closest_marker, lanes))]:
            raise pytest.UsageError(f"{left[0].nodeid}: no stage runs it")
        try:
            for stage in self._stages:
                self._run(stage)
        finally:
            for worker in self._workers:
                worker.connection.close()  # which it sees after its test
            for worker in self._workers:
                os.waitpid(worker.pid, 0)
        if session.shouldfail:
            raise session.Failed(session.shouldfail)
        if session.shouldstop:
            raise session.Interrupted(session.shouldstop)
        if self._done < len(session.items):
            raise session.Interrupted(f"{len(session.items) - self._done} tests have not run")
        return True

    def _queue_of(self, stage: Stage) -> Queue:
        items = self._session.items
        fit = [
            number for number, item in enumerate(items) if any(item.get_closest_marker(lane) for lane in stage.lanes)
        ]
        return Queue(fit, lambda number: items[number].path)

    def _run(self, stage: Stage) -> None:
        terminal, began = self._session.config.get_terminal_writer(), monotonic()
        for worker in self._of(self._spare):
            if worker.stays and not stage.spare:
                worker.tell(None)
        while not stage.spare and self._of(self._spare):
            self._hear()
        self._begin(stage)
        if not self._of(stage):
            return
        terminal.line(f"\n{stage}: {stage.workers} at a time")
        while self._of(stage):
            if self._leaves_time(stage):
                self._begin(self._spare)
            self._hear()
        terminal.line(f"\n{stage}: {monotonic() - began:.0f} s")

    def _leaves_time(self, stage: Stage) -> bool:
        if stage.quiet or stage.lanes == self._spare.lanes:
            return False
        return stage.spare or len(self._of(stage)) < stage.workers

    def _of(self, stage: Stage) -> list[Worker]:
        return [worker for worker in self._workers if worker.stage is stage]

    def _begin(self, stage: Stage) -> None:
        """Have as many workers of a stage as it has work for."""
        while len(self._of(stage)) < stage.workers and (own := self._queues[stage.lanes].take()):
            ours, theirs = Pipe()
            self._begun += 1
            sys.stdout.flush()
            sys.stderr.flush()
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # what runs after a fork swallows exceptions
            pid = os.fork()
            if pid == 0:
                signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
                for other in self._workers:
                    other.connection.close()
                ours.close()
                self._work(stage, theirs)
            theirs.close()
            worker = Worker(stage, pid, ours, os.pidfd_open(pid), own)
            self._workers.append(worker)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
            worker.tell(own.popleft())
            self._go_on(worker)

    def _go_on(self, worker: Worker) -> None:
        if worker.stays:
            worker.own = worker.own or self._queues[worker.stage.lanes].take()
            worker.tell(worker.own.popleft() if worker.own else None)

    def _hear(self) -> None:
        """Wait until a worker says something or ends, and deal with it."""
        ready = wait([place for worker in self._workers for place in (worker.connection, worker.ended)])
        for worker in list(self._workers):
            with suppress(EOFError, ConnectionResetError):
                while worker.connection in ready and worker.connection.poll():
                    self._take(worker, *worker.connection.recv())
            if worker.ended in ready:
                self._bury(worker)

    def _take(self, worker: Worker, what: str, told: dict[str, Any]) -> None:
        if what == "report":
            self._hook.pytest_runtest_logreport(
                report=self._hook.pytest_report_from_serializable(config=self._session.config, data=told)
            )
        elif what == "warning":
            from xdist.workermanage import unserialize_warning_message

            told["warning_message"] = unserialize_warning_message(told["warning_message"])
            self._hook.pytest_warning_recorded.call_historic(kwargs=told)
        else:
            worker.last = worker.told.popleft()
            self._done += 1
            if self._session.shouldfail or self._session.shouldstop:
                for queue in self._queues.values():
                    queue.clear()
            self._go_on(worker)

    def _bury(self, worker: Worker) -> None:
        """Forget a worker that has ended; when it was not to, its test has failed."""
        status = os.waitstatus_to_exitcode(os.waitpid(worker.pid, 0)[1])
        self._workers.remove(worker)
        worker.connection.close()
        os.close(worker.ended)
        if status == 0 and not worker.told:
            return
        self._done += bool(worker.told)
        item = self._session.items[worker.told.popleft() if worker.told else worker.last]
        self._queues[worker.stage.lanes].give_back([*worker.told, *worker.own])
        worker.own.clear()
        how = f"was ended by {signal.Signals(-status).name}" if status < 0 else f"ended with {status}"
        self._hook.pytest_runtest_logreport(
            report=pytest.TestReport(
                item.nodeid, item.location, {}, "failed", f"the process of this test {how}", "call"
            )
        )
        self._begin(worker.stage)

    def _work(self, stage: Stage, connection: Connection) -> NoReturn:
        """Run tests as long as there are any, in a process of its own."""
        config, items = self._session.config, self._session.items
        try:
            own = self._folder / f"worker{self._begun}"
            own.mkdir(mode=0o700)
            config._tmp_path_factory._basetemp = own  # type: ignore[attr-defined]
            capture = config.pluginmanager.getplugin("capturemanager")
            capture.stop_global_capturing()  # its files are those of all workers
            capture.start_global_capturing()
            capture.suspend_global_capture()
            config.pluginmanager.register(_Teller(connection))
            self._prepare(stage)
            number = connection.recv()
            while number is not None:
                following = connection.recv()
                nextitem = None if following is None else items[following]
                config.hook.pytest_runtest_protocol(item=items[number], nextitem=nextitem)
                connection.send(("done", {}))
                number = following
            os._exit(0)
        except (EOFError, BrokenPipeError, KeyboardInterrupt):
            pass  # nobody waits for it any more
        except BaseException:
            traceback.print_exc()
        with suppress(BaseException):
            runner.pytest_sessionfinish(self._session)  # ends what the test has begun
        os._exit(1)


class _Teller:
    """A worker's part: it tells what pytest says of a test."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._runs = False  # before, it hears of what was warned of until now

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool:
        self._runs = True
        for report in runner.runtestprotocol(item, log=False, nextitem=nextitem):
            told = item.config.hook.pytest_report_to_serializable(config=item.config, report=report)
            self._connection.send(("report", told))
        return True

    def pytest_warning_recorded(self, warning_message: Any, when: str, nodeid: str, location: Any) -> None:
        if not self._runs:
            return
        from xdist.remote import serialize_warning_message  # pytest, too, has to import it first

        told = {"warning_message": serialize_warning_message(warning_message), "when": when}
        self._connection.send(("warning", told | {"nodeid": nodeid, "location": location}))
