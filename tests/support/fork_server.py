"""Programs of this project start in 30 ms instead of 1 to 2 s: they are forked from a process that has imported them.

A test starts ``python -m ross_payload.cli ...`` by `subprocess`, as anybody would; most of what follows is import. So
`install` lets `subprocess.Popen` look whether the program is one of ours, and if so ask a server for it: a process
without threads that has imported the project's modules, forks, and lets the fork run the module as ``__main__`` with
the arguments, folder, environment and standard streams that were asked for. So it does with a script of ``tests``, and
with ``python -c``, if the program names one of our packages and does not care what is imported already (`sys.modules`).
The new process is a child of the test (`PR_SET_CHILD_SUBREAPER`, prctl(2)): it is waited for and signalled like any
other.

Whatever a fork could not do alike is started as usual: other users, process groups, ``preexec_fn``, inherited file
descriptors, and environments which differ in what is read while a program starts (`AT_START`), but for the places of
modules, PYTHONPATH, which a fork looks at again. Two forks share the seed of Python's hashes, but neither shares that
of the test.
"""

from __future__ import annotations

import array
import atexit
import ctypes
import gc
import importlib
import importlib.util
import json
import os
import pkgutil
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

AT_START = ("PYTHON", "LD_", "LC_", "LANG", "OMP_", "OPENBLAS_", "MPL", "MAVLINK", "COVERAGE")
OURS = ("ross_payload", "ross_sim")
HEAVY = ("aiohttp.web", "matplotlib.figure", "matplotlib.backends.backend_agg", "pyroomacoustics", "scipy.signal")
UNUSED = ("ross_sim.study.train", "ross_sim.study.baselines")
SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER
PLACES = "PYTHONPATH"
UNALIKE = ("preexec_fn", "pass_fds", "shell", "gid", "gids", "uid", "process_group", "executable")
TESTS = Path(__file__).resolve().parents[1]
LONGEST = 1 << 20  # bytes of one request


def install() -> None:
    """Let `subprocess` fork the programs of this project from a server that is started with the first of them."""
    if sys.platform == "linux":
        subprocess.Popen = Forked  # type: ignore[misc]


def begin() -> None:
    """Start the server, if there is to be one, and wait until it has imported everything."""
    if subprocess.Popen is Forked:
        _server().wait()


class Forked(subprocess.Popen):  # type: ignore[type-arg]
    """A process as `subprocess` knows it; forked, where that makes no difference."""

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
        }
        self.pid = _server().fork(request, streams)
        self._child_created = True
        self._close_pipe_fds(*(asked[name] for name in names[6:12]))  # type: ignore[attr-defined]


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
    """The process that forks."""

    def __init__(self) -> None:
        ctypes.CDLL(None, use_errno=True).prctl(SUBREAPER, 1, 0, 0, 0)
        self.environment = _at_start(os.environ)
        self._ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for end in (self._ours, theirs):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LONGEST)
        command = [sys.executable, str(Path(__file__).resolve()), str(theirs.fileno())]
        with theirs:
            self._process = _popen(command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL)
        atexit.register(self.close)
        self._ready = False

    def wait(self) -> None:
        """Wait until it can fork."""
        self._ready = self._ready or bool(self._ours.recv(64))

    def fork(self, request: dict[str, Any], streams: list[int]) -> int:
        """Have a process forked that runs what is asked for with these standard streams; return its number."""
        descriptors = array.array("i", streams)
        self.wait()
        data = json.dumps(request).encode()
        self._ours.sendmsg([data], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, descriptors)])
        return int(self._ours.recv(64))

    def close(self) -> None:
        """End the server; what it forked lives on."""
        self._ours.close()
        self._process.wait()


_popen = subprocess.Popen


@cache
def _server() -> Server:
    return Server()


# ---- in the server


def _load() -> None:
    """Import what the programs of this project import sooner or later."""
    sys.modules["sounddevice"] = None  # type: ignore[assignment]  # asks at once which devices there are
    for name in HEAVY:
        importlib.import_module(name)
    for package in OURS:
        top = importlib.import_module(package)
        for found in pkgutil.walk_packages(top.__path__, f"{package}."):
            if not found.name.endswith("__main__") and not found.name.startswith(UNUSED):
                try:
                    importlib.import_module(found.name)
                except ImportError:
                    continue  # an extra that is not there
    del sys.modules["sounddevice"]
    gc.collect()
    gc.freeze()


def serve(control: socket.socket) -> dict[str, Any] | None:
    """Fork for every request; return it in the fork, and None in the server when nobody can ask any more."""
    while True:
        data, ancillary, *_ = control.recvmsg(LONGEST, socket.CMSG_SPACE(3 * 4))
        if not data:
            return None
        streams = array.array("i")
        for *_, descriptors in ancillary:
            streams.frombytes(descriptors[: 3 * streams.itemsize])
        number = _forked(control)
        if number is None:
            control.close()
            return json.loads(data) | {"streams": list(streams)}
        for descriptor in streams:
            os.close(descriptor)
        control.send(str(number).encode())


def _forked(control: socket.socket) -> int | None:
    """Fork twice, so that the new process is the server's no more; return its number, and None within it."""
    reading, writing = os.pipe()
    between = os.fork()
    if between == 0:
        grandchild = os.fork()
        if grandchild:
            os.write(writing, str(grandchild).encode())
            os._exit(0)
        os.close(reading)
        os.close(writing)
        return None
    os.close(writing)
    number = int(os.read(reading, 32))
    os.close(reading)
    os.waitpid(between, 0)
    return number


def _become(request: dict[str, Any]) -> Any:
    """Make this process the one that was asked for; return the code to run and the module to run it in."""
    if request["session"]:
        os.setsid()
    for own, descriptor in enumerate(request["streams"]):
        os.dup2(descriptor, own)
        os.close(descriptor) if descriptor > 2 else None
    os.chdir(request["folder"])
    before = os.environ.get(PLACES, "").split(os.pathsep)
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.stdin = open(0, closefd=False)  # noqa: SIM115 - Python does not close them either
    sys.stdout = open(1, "w", buffering=1 if os.isatty(1) else -1, closefd=False)  # noqa: SIM115
    sys.stdout.reconfigure(write_through=request["unbuffered"])
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace", closefd=False)  # noqa: SIM115
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr
    places = os.environ.get(PLACES, "")
    first = str(Path(request["script"]).parent if "script" in request else Path.cwd())
    sys.path[:] = [first, *filter(None, places.split(os.pathsep))] + [
        place for place in sys.path[1:] if place not in before
    ]
    return _main_module(request)


def _main_module(request: dict[str, Any]) -> Any:
    """Make the module ``__main__``; return the code to run and where to run it."""
    main = ModuleType("__main__")
    main.__dict__["__builtins__"] = __builtins__
    sys.modules["__main__"] = main
    if "code" in request:
        sys.argv = ["-c", *request["arguments"]]
        return compile(request["code"], "<string>", "exec"), main.__dict__
    if "script" in request:
        main.__file__ = request["script"]
        sys.argv = [request["script"], *request["arguments"]]
        return compile(Path(request["script"]).read_bytes(), request["script"], "exec"), main.__dict__
    name = request["module"]
    spec = importlib.util.find_spec(name)
    if spec is not None and spec.submodule_search_locations is not None:
        spec = importlib.util.find_spec(f"{name}.__main__")
    assert spec is not None and spec.loader is not None, name
    main.__spec__, main.__file__, main.__loader__, main.__package__ = spec, spec.origin, spec.loader, spec.parent
    sys.argv = [str(spec.origin), *request["arguments"]]
    return spec.loader.get_code(spec.name), main.__dict__  # type: ignore[attr-defined]


def _run(code: Any, space: dict[str, Any]) -> None:
    """Run a program and end as Python ends, but for the modules: to take down what was never used takes 70 ms."""
    status = 0
    try:
        exec(code, space)  # noqa: S102 - as `runpy` does
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if not isinstance(end.code, int | None):
            sys.stderr.write(f"{end.code}\n")
    except BaseException as error:
        sys.excepthook(type(error), error, error.__traceback__)
        status = -signal.SIGINT if isinstance(error, KeyboardInterrupt) else 1
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    if status < 0:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)
    os._exit(status & 0xFF)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the one of the tests ends them, and us
    _load()
    control = socket.socket(fileno=int(sys.argv[1]))
    control.send(b"ready")
    asked = serve(control)
    if asked is not None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        _run(*_become(asked))
