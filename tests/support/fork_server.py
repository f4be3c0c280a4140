"""The process from which programs of this project are forked (`forked_programs`): a program of its own.

It answers every request that comes by a channel: an empty one opens another channel, ``{"ended": number}`` asks for the
status of a process, and everything else for a process (`_become`).
"""

from __future__ import annotations

import atexit
import gc
import importlib
import importlib.util
import json
import os
import pkgutil
import select
import signal
import socket
import sys
import threading
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

OURS = ("ross_payload", "ross_sim")
HEAVY = ("aiohttp.web", "matplotlib.figure", "matplotlib.backends.backend_agg", "pyroomacoustics", "scipy.signal")
HEAVY += ("distributed.cli.dask_scheduler", "distributed.cli.dask_worker")
UNUSED = ("ross_sim.study.train", "ross_sim.study.baselines")
PLACES = "PYTHONPATH"
LONGEST = 1 << 20  # bytes of one request
READY = b"ready"


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
    """Do what is asked; return a request in the process that is forked for it, or None when nobody asks any more."""
    channels = [control]
    while channels:
        for channel in select.select(channels, [], [])[0]:
            try:
                data, descriptors, *_ = socket.recv_fds(channel, LONGEST, 3)
                request = json.loads(data) if data else None
                if request is None:
                    channels.remove(channel)
                    channel.close()
                elif not request:
                    channels.append(socket.socket(fileno=descriptors[0]))
                    channels[-1].send(READY)
                elif "ended" in request:
                    channel.send(str(os.waitpid(request["ended"], 0)[1]).encode())
                else:
                    if (number := os.fork()) == 0:
                        for each in channels:
                            each.close()
                        return request | {"streams": descriptors}
                    for descriptor in descriptors:
                        os.close(descriptor)
                    channel.send(str(number).encode())
            except ConnectionError:  # who asked has gone, which the next round finds
                continue
    return None


def _become(request: dict[str, Any]) -> Any:
    """Make this process the one that was asked for; return the code to run and the module to run it in."""
    if request["session"]:
        os.setsid()
    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, request["niceness"])
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
    control.send(READY)
    asked = serve(control)
    if asked is not None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        _run(*_become(asked))
