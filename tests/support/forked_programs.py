"""Programs of this project start in 30 ms instead of 1 to 2 s: they are forked from a process that has imported them.

A test starts ``python -m ross_payload.cli ...`` by `subprocess`, as anybody would; most of what follows is import. So
`install` lets `subprocess.Popen` look whether the program is one of ours, and if so ask a server for it: a process
without threads that has imported the project's modules, forks, and lets the fork run the module as ``__main__`` with
the arguments, folder, environment and standard streams that were asked for. So it does with a script of ``tests``, and
with ``python -c``, if the program names one of our packages and does not care what is imported already (`sys.modules`).
The new process is a child of the server, which tells how it has ended when it is asked; it is signalled like any other.
A process and those that are forked from it have one server.

Whatever a fork could not do alike is started as usual: other users, process groups, ``preexec_fn``, inherited file
descriptors, and environments which differ in what is read while a program starts (`AT_START`), but for the places of
modules, PYTHONPATH, which a fork looks at again. Two forks share the seed of Python's hashes, but neither shares that
of the test.
"""

from __future__ import annotations

import atexit
import json
import os
import select
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import fork_server
from fork_server import LONGEST, OURS, PLACES

AT_START = ("PYTHON", "LD_", "LC_", "LANG", "OMP_", "OPENBLAS_", "MPL", "COVERAGE")
UNALIKE = ("preexec_fn", "pass_fds", "shell", "gid", "gids", "uid", "process_group", "executable")
TESTS = Path(__file__).resolve().parents[1]


def install() -> None:
    """Let `subprocess` fork the programs of this project from a server that is started with the first of them."""
    if sys.platform == "linux":
        subprocess.Popen = Forked  # type: ignore[misc]


def begin(wait: bool = True) -> None:
    """Start the server, if there is to be one and it is not there, and wait until it has imported everything."""
    if subprocess.Popen is Forked and (_server() and wait):
        _server().wait()


class Forked(subprocess.Popen):  # type: ignore[type-arg]
    """A process as `subprocess` knows it; forked, where that makes no difference."""

    _of_server = False

    def _execute_child(self, args: Any, executable: Any, preexec_fn: Any, close_fds: Any, *rest: Any) -> None:
        names = ("pass_fds", "cwd", "env", "startupinfo", "creationflags", "shell", "p2cread", "p2cwrite", "c2pread")
        names += ("c2pwrite", "errread", "errwrite", "restore_signals", "gid", "gids", "uid", "umask")
        names += ("start_new_session", "process_group")
        asked = dict(zip(names, rest, strict=False), executable=executable, preexec_fn=preexec_fn)
        words = [os.fspath(word) for word in args] if isinstance(args, list | tuple) else []
        environment = dict(os.environ if asked["env"] is None else asked["env"])
        unalike = any(asked.get(name) not in (None, (), False, -1) for name in UNALIKE)
        program = _program(words)
        if program is None or unalike or not close_fds or asked["umask"] != -1 or not _alike(environment):
            super()._execute_child(args, executable, preexec_fn, close_fds, *rest)
            return
        streams = [
            asked[name] if asked[name] != -1 else own for own, name in enumerate(("p2cread", "c2pwrite", "errwrite"))
        ]
        request = program | {
            "folder": os.fspath(asked["cwd"] or Path.cwd()),
            "environment": environment,
            "session": bool(asked["start_new_session"]),
            "niceness": os.getpriority(os.PRIO_PROCESS, 0),
        }
        self.pid = _server().fork(request, streams)
        self._of_server = self._child_created = True
        self._close_pipe_fds(*(asked[name] for name in names[6:12]))  # type: ignore[attr-defined]

    def _internal_poll(self, *arguments: Any, **options: Any) -> int | None:
        if not self._of_server:
            return super()._internal_poll(*arguments, **options)  # type: ignore[misc,no-any-return]
        if self.returncode is None and self._waitpid_lock.acquire(False):  # type: ignore[attr-defined]
            try:
                pid, status = self._try_wait(os.WNOHANG) if self.returncode is None else (0, 0)
                if pid == self.pid:
                    self._handle_exitstatus(status)  # type: ignore[attr-defined]
            finally:
                self._waitpid_lock.release()  # type: ignore[attr-defined]
        return self.returncode

    def _try_wait(self, wait_flags: int) -> tuple[int, int]:
        """Return the number and status of the process as os.waitpid(2) does."""
        if not self._of_server:
            return super()._try_wait(wait_flags)  # type: ignore[misc,no-any-return]
        if not _has_ended(self.pid, 0 if wait_flags & os.WNOHANG else None):
            return 0, 0
        return self.pid, _server().status(self.pid)


def _has_ended(pid: int, patience_ms: int | None) -> bool:
    """Whether a process has ended, at the latest after a while (None: whenever)."""
    descriptor = os.pidfd_open(pid)
    try:
        poll = select.poll()
        poll.register(descriptor, select.POLLIN)
        return bool(poll.poll(patience_ms))
    finally:
        os.close(descriptor)


def _program(words: list[str]) -> dict[str, Any] | None:
    """What is asked for, a module, a code or a script and its arguments, or None when it is none of ours."""
    if words[:1] != [sys.executable]:
        return None
    unbuffered = words[1:2] == ["-u"]
    how, what, *arguments = [*words[1 + unbuffered :], "", ""]
    asked = {"arguments": arguments[:-2], "unbuffered": unbuffered}
    if how == "-m" and what.partition(".")[0] in OURS:
        return asked | {"module": what}
    if how == "-c" and any(name in what for name in OURS) and "sys.modules" not in what:
        return asked | {"code": what}
    if how.endswith(".py") and Path(how).is_absolute() and Path(how).is_relative_to(TESTS):
        return asked | {"script": how, "arguments": words[2 + unbuffered :]}
    return None


def _alike(environment: dict[str, str]) -> bool:
    return _at_start(environment) == _server().environment


def _at_start(environment: Any) -> dict[str, str]:
    return {name: value for name, value in environment.items() if name.startswith(AT_START) and name != PLACES}


class Server:
    """The process that forks, as those see it that ask."""

    def __init__(self) -> None:
        self.environment = _at_start(os.environ)
        self._ours, theirs = _channel()
        command = [sys.executable, fork_server.__file__, str(theirs.fileno())]
        with theirs:
            self._process = _popen(command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL)
        self._owner = self._speaker = os.getpid()
        self._lock = threading.Lock()
        self._ready = False
        atexit.register(self.close)

    def wait(self) -> None:
        """Wait until it can fork."""
        with self._lock_of_this():
            self._ready = self._ready or bool(self._ours.recv(64))

    def fork(self, request: dict[str, Any], streams: list[int]) -> int:
        """Have a process forked that runs what is asked for with these standard streams; return its number."""
        return self._ask(request, streams)

    def status(self, pid: int) -> int:
        """Return the status of a process that has ended, and let its number be used again."""
        return self._ask({"ended": pid})

    def _ask(self, request: dict[str, Any], descriptors: Sequence[int] = ()) -> int:
        self.wait()
        with self._lock_of_this():
            socket.send_fds(self._ours, [json.dumps(request).encode()], descriptors)
            return int(self._ours.recv(64))

    def _lock_of_this(self) -> threading.Lock:
        """Return the lock of this process; one that was forked needs a lock and a channel of its own."""
        if self._speaker != os.getpid():
            shared = self._ours
            self._ours, theirs = _channel()
            with shared, theirs:
                socket.send_fds(shared, [b"{}"], [theirs.fileno()])
            self._speaker, self._lock, self._ready = os.getpid(), threading.Lock(), False
        return self._lock

    def close(self) -> None:
        """End the server; what it forked lives on."""
        if self._owner == os.getpid():
            self._ours.close()
            self._process.terminate()
            self._process.wait()


def _channel() -> tuple[socket.socket, socket.socket]:
    ends = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    for end in ends:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LONGEST)
    return ends


_popen = subprocess.Popen


@cache
def _server() -> Server:
    return Server()
