"""Doing the tasks of a study on a Dask cluster, on other computers or on this one.

The client submits a bounded number of tasks at a time, those of one room together, and gives their results as they
come. A worker first computes what the rows depend on (code, versions of packages, voices) and is refused when that is
not what the client has. Whoever reaches a Dask scheduler can run code on its workers: see decision 0104.
"""

from __future__ import annotations

import contextlib
import logging
import signal
import socket
import time
import warnings
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from ross_payload.errors import ConfigError, OutputError, RossError
from ross_payload.plugins import install_line
from ross_sim.cache import fingerprint
from ross_sim.study.runs.study_case import Failure
from ross_sim.study.runs.study_store import difference
from ross_sim.study.runs.task_engine import Engine, Named

if TYPE_CHECKING:
    from distributed import Client

AHEAD = 3  # groups that are submitted, per thread of the cluster
TOGETHER = 8  # tasks of one room in a group, at most: what is lost with a worker
TRIES = 3  # of a task, before it counts as failed
CONNECT_TIMEOUT = "10s"  # for a scheduler to answer
LOOK = 5.0  # without a result, until the client looks which workers are there [s]
ALONE = 60.0  # that refused workers may be the only ones, while another one restarts [s]
LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, slots=True)
class Basis:
    """What rows depend on: a worker whose own is another is refused."""

    make: Callable[[], dict[str, Any]]  # the manifest, computed where it is called
    wanted: dict[str, Any]  # the client's

    @property
    def token(self) -> str:
        """A short name of what is wanted."""
        return fingerprint(**self.wanted)


@dataclass(frozen=True, slots=True)
class _Refused:
    """What a worker has found that must not give rows."""

    worker: str
    found: dict[str, Any] | str  # its own, or why it has none


@dataclass(frozen=True, slots=True)
class _Group:
    """Tasks that are submitted together."""

    tasks: tuple[Named, ...]
    workers: tuple[str, ...]  # that alone may do them; none: any


def cluster(address: str | None, workers: int, basis: Basis, say: Callable[[str], None]) -> Engine:
    """Do tasks on the cluster of a scheduler.

    Parameters
    ----------
    address
        Of the scheduler, ``tcp://HOST:PORT`` or ``tls://HOST:PORT``; None: so many ``workers`` are started here, with
        a scheduler that other computers cannot reach.
    basis
        What the rows depend on.
    say
        Takes a line for the user: where the dashboard is, which worker is refused.

    Raises
    ------
    ConfigError
        When Dask is not installed; while yielding, when no scheduler answers, or every worker is refused.
    OutputError
        While yielding, when the scheduler is lost.
    """
    try:
        import distributed  # noqa: F401 - said now, not in the middle
    except ModuleNotFoundError as error:
        raise ConfigError(f"--engine dask needs the package {error.name}: {install_line('cluster')}") from error

    def run(function: Callable[[Any], Any], tasks: Sequence[Any]) -> Generator[Any]:
        for name in list(logging.root.manager.loggerDict):  # what matters of it is said here
            if name.partition(".")[0] in ("distributed", "tornado"):
                logging.getLogger(name).setLevel(logging.CRITICAL)
        if address is not None:
            _resolve(address)
            say(f"connecting to the Dask scheduler at {address}, for {CONNECT_TIMEOUT.removesuffix('s')} s at most")
        with contextlib.ExitStack() as stack:
            client = stack.enter_context(_local(workers) if address is None else _remote(address))
            say(f"Dask dashboard: {client.dashboard_link}")
            yield from _Run(client, function, basis, say).results(tasks)

    return run


def grouped(tasks: Iterable[Named]) -> Iterator[tuple[Named, ...]]:
    """Put tasks of one room together, in the order in which their rooms come first."""
    rooms: dict[str, list[Named]] = {}
    for task in tasks:
        rooms.setdefault(task.room, []).append(task)
    for members in rooms.values():
        yield from (tuple(members[i : i + TOGETHER]) for i in range(0, len(members), TOGETHER))


class _Run:
    """One run of a study on a cluster."""

    def __init__(
        self, client: Client, function: Callable[[Any], Any], basis: Basis, say: Callable[[str], None]
    ) -> None:
        self._client, self._function, self._basis, self._say = client, function, basis, say
        self._address = str(client.scheduler_info()["address"])
        self._token = basis.token
        self._refused: dict[str, str] = {}
        self._tries: Counter[str] = Counter()
        self._waiting: deque[tuple[Named, ...]] = deque()
        self._window = AHEAD  # groups that are submitted at a time
        self._alone_since: float | None = None  # since when refused workers are the only ones [s]

    def results(self, tasks: Sequence[Named]) -> Generator[Any]:
        """Give the results of tasks as they come; one that fails to the end gives a `Failure`."""
        from distributed import CancelledError

        self._ask_workers()
        self._waiting.extend(grouped(tasks))
        running: dict[Any, _Group] = {}
        try:
            self._submit(running)
            while running or self._waiting:
                for future in self._done(running):
                    yield from self._arrived(future, running.pop(future).tasks)
                self._submit(running)
        except (CancelledError, OSError, TimeoutError) as error:
            raise OutputError(
                f"the Dask scheduler at {self._address} is lost; what was done is kept, and the same command goes on"
            ) from error
        finally:
            with contextlib.suppress(Exception):  # it may be lost, or this process about to end
                self._client.cancel(list(running))

    def _done(self, running: dict[Any, _Group]) -> Iterable[Any]:
        """Wait until groups are done; after a while without any, take back those that nobody who is there may do."""
        from distributed import wait

        if not running:
            time.sleep(LOOK)
            return ()
        try:
            done: set[Any] = wait(list(running), timeout=LOOK, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            there = set(self._client.nthreads())
        else:
            return done
        for future, group in list(running.items()):
            if group.workers and not there & set(group.workers) and not future.done():
                future.cancel()
                self._waiting.appendleft(running.pop(future).tasks)
        return ()

    def _submit(self, running: dict[Any, _Group]) -> None:
        """Keep the workers busy with a bounded number of groups; asks who is there when half of them are done."""
        if not self._waiting or len(running) * 2 > self._window:
            return
        threads = self._client.nthreads()
        allowed = tuple(sorted(set(threads) - set(self._refused)))
        if self._refused and not allowed:
            self._wait_for_others(list(threads))
            return
        self._alone_since = None
        self._window = AHEAD * max(sum(threads[worker] for worker in allowed), 1)
        only = allowed if self._refused else ()
        while self._waiting and len(running) < self._window:
            group = self._waiting.popleft()
            work = (self._function, group, self._basis.make, self._token)
            future = self._client.submit(_attempted, *work, pure=False, workers=list(only) or None)
            running[future] = _Group(group, only)

    def _wait_for_others(self, there: Sequence[str]) -> None:
        """Give nobody work; where refused workers are the only ones for too long, no other one will come."""
        if not there:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = time.monotonic()
        elif time.monotonic() - self._alone_since > ALONE:
            raise self._nobody()

    def _arrived(self, future: Any, group: tuple[Named, ...]) -> Generator[Any]:
        """Give what a group has given; what failed is tried again alone."""
        from distributed import KilledWorker

        error = future.exception()
        if isinstance(error, KilledWorker):
            if len(group) > 1:  # one of them ends its workers: which?
                self._waiting.extend((task,) for task in group)
            else:
                yield Failure(group[0].id, f"its worker died {error.allowed_failures + 1} times")
            return
        if error is not None:
            for task in group:
                yield from self._failed(task, Failure(task.id, f"{type(error).__name__}: {error}"))
            return
        done = future.result()
        if isinstance(done, _Refused):
            self._refuse(done.worker, done.found)
            self._waiting.appendleft(group)
            return
        for task, result in zip(group, done, strict=True):
            if isinstance(result, Failure):
                yield from self._failed(task, result)
            else:
                yield result

    def _failed(self, task: Named, failure: Failure) -> Generator[Failure]:
        self._tries[task.id] += 1
        if self._tries[task.id] < TRIES:
            self._waiting.append((task,))
        else:
            yield failure

    def _ask_workers(self) -> None:
        """Refuse workers that are there already; one that comes later is asked with its first group."""
        answers = self._client.run(_manifest, self._basis.make, on_error="return")
        for worker, answer in sorted(answers.items()):
            if answer != self._basis.wanted:
                self._refuse(worker, answer)
        if not answers:
            self._say("no worker has joined the scheduler yet; the tasks wait for one")
        elif len(self._refused) == len(answers):
            raise self._nobody()

    def _refuse(self, worker: str, found: dict[str, Any] | str | Exception) -> None:
        if worker not in self._refused:
            other = difference(found, self._basis.wanted) if isinstance(found, dict) else ""
            self._refused[worker] = other or (found if isinstance(found, str) else repr(found))
            self._say(f"worker {worker} is refused: {self._refused[worker]}")

    def _nobody(self) -> ConfigError:
        worker, reason = next(iter(self._refused.items()))
        return ConfigError(
            f"--engine: expected workers with the code and voices of this computer, got none among "
            f"{len(self._refused)}; {worker}: {reason}"
        )


def _manifest(make: Callable[[], dict[str, Any]]) -> dict[str, Any] | str:
    """What rows depend on here, or why that cannot be told."""
    try:
        return make()
    except RossError as error:
        return str(error)


_others: dict[str, dict[str, Any] | str | None] = {}  # by what is wanted; of this process


def _other(make: Callable[[], dict[str, Any]], token: str) -> dict[str, Any] | str | None:
    """What is found here, if it is something else than what is wanted; computed once."""
    if token not in _others:
        found = _manifest(make)
        _others[token] = None if not isinstance(found, str) and fingerprint(**found) == token else found
    return _others[token]


def _attempted(
    function: Callable[[Any], Any], group: Sequence[Any], make: Callable[[], dict[str, Any]], token: str
) -> list[Any] | _Refused:
    """Do a group of tasks on a worker, if its rows count."""
    from distributed import get_worker

    found = _other(make, token)
    if found is not None:
        return _Refused(get_worker().address, found)
    return [function(task) for task in group]


def _resolve(address: str) -> None:
    """Look whether the host of a scheduler has an address: Dask asks for it again until its time is over."""
    there = urlsplit(address)
    try:
        socket.getaddrinfo(there.hostname, there.port)
    except (OSError, UnicodeError) as error:
        raise ConfigError(f"--engine: expected a Dask scheduler at {address}, got no such host: {error}") from error


def _remote(address: str) -> Client:
    from distributed import Client

    try:
        return Client(address, timeout=CONNECT_TIMEOUT)
    except (OSError, ValueError, TypeError, RuntimeError) as error:  # TypeError: TLS without a certificate
        raise ConfigError(f"--engine: expected a Dask scheduler at {address}, got no answer: {error}") from error


@contextlib.contextmanager
def _local(workers: int) -> Iterator[Client]:
    """A scheduler and workers of this computer, which nobody else reaches."""
    import dask
    from distributed import Client, LocalCluster, WorkerPlugin

    class Deaf(WorkerPlugin):
        """A terminal sends Ctrl-C to the workers as well, and the client alone ends them."""

        def setup(self, worker: object) -> None:
            """Hear no Ctrl-C."""
            signal.signal(signal.SIGINT, signal.SIG_IGN)

    own = {
        "distributed.scheduler.allowed-failures": TRIES - 1,
        "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,  # else large arrays are given back at once
    }
    with (
        dask.config.set(own),
        warnings.catch_warnings(action="ignore", category=UserWarning),  # that the dashboard has another port
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host=LOOPBACK,
            dashboard_address=f"{LOOPBACK}:8787",
            silence_logs=logging.CRITICAL,
        ) as local,
        Client(local) as client,
    ):
        client.register_plugin(Deaf())
        yield client
