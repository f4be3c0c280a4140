"""The extension in one container: payload and ground station's page side by side, and a front page that BlueOS finds.

    /opt/ross/bin/python start.py [--check]

BlueOS looks for whatever listens on all addresses, and asks it for `/` and `/register_service`; that is the front page
here. It tells how the payload is and links to the ground station's page, which needs the token that the log shows. A
payload that ends is started again; one that refuses its configuration, when the file has changed, and every minute, for
what it did not find may be a device that is plugged in later. `--check` exits with 0 while all is well.
"""

from __future__ import annotations

import html
import json
import os
import secrets
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from pathlib import Path
from time import monotonic
from typing import Any

from ross_payload import __version__
from ross_payload.service.health_command import in_words
from ross_payload.service.health_socket import asked

ROSS = Path(sys.executable).with_name("ross")
ICON = resources.files("ross_payload.ground.web") / "assets" / "icon.svg"
LOOK_S = 0.5
AGAIN_S = 2.0  # until what has ended is started again
REFUSED_S = 60.0  # the same, when it has refused a file that is as it was
GOING_S = 8.0  # that both may take to end: Docker kills after 10
BAD_INPUT = 2  # exit code
SERVICE = {
    "name": "RoSS payload",
    "description": "Two microphones that turn to listen: where people talk, and the voice that you ask for",
    "icon": "mdi-ear-hearing",
    "company": "The RoSS payload authors",
    "version": __version__,
    "webpage": "",
    "api": "",
    "new_page": False,
}
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta http-equiv="refresh" content="5"><title>RoSS payload</title>
<style>body {{ font: 1.1em/1.5 sans-serif; max-width: 40em; margin: 2em auto; padding: 0 1em }}</style>
</head><body><h1><img src="/icon.svg" alt="" width="32"> RoSS payload {version}</h1>
<p role="status">{state}</p><p>{advice}</p>
<p><a href="http://{host}:{port}/" target="_blank">Open the ground station's page</a>.
It asks for a token, which the log of this extension shows.</p></body></html>
"""


@dataclass(frozen=True, slots=True)
class Settings:
    """Where everything is; the variables of the environment are for tries outside an image."""

    config: Path = field(default_factory=lambda: Path(os.environ.get("ROSS_CONFIG", "/etc/ross/ross.toml")))
    state: Path = field(default_factory=lambda: Path(os.environ.get("STATE_DIRECTORY", "/state")))
    host: str = field(default_factory=lambda: os.environ.get("ROSS_HOST", "0.0.0.0"))  # noqa: S104  BlueOS finds no other
    front: int = field(default_factory=lambda: int(os.environ.get("ROSS_FRONT_PORT", "8764")))
    page: int = field(default_factory=lambda: int(os.environ.get("ROSS_PAGE_PORT", "8765")))
    telemetry: str = field(default_factory=lambda: os.environ.get("ROSS_TELEMETRY", "udpin:127.0.0.1:14555"))


class Child:
    """A program that is started again when it ends: when it has refused its file, soon after that has changed."""

    def __init__(self, command: Iterable[object], file: Path | None = None) -> None:
        self._command = [str(word) for word in command]
        self._file = file
        self._process: subprocess.Popen[bytes] | None = None
        self._ended_at, self._code, self._tried = -AGAIN_S, 0, 0

    @property
    def refused(self) -> bool:
        """Whether it has refused its file, as it is."""
        return self._code == BAD_INPUT and self._file is not None and self._tried == _changed(self._file)

    def look(self) -> None:
        """Start it when it does not run and may."""
        if self._process is not None and self._process.poll() is not None:
            self._ended_at, self._code, self._process = monotonic(), self._process.returncode, None
        if self._process is None and monotonic() >= self._ended_at + (REFUSED_S if self.refused else AGAIN_S):
            if self._file is not None:
                self._tried = _changed(self._file)
                if not self._tried:
                    return
            self._code, self._process = 0, subprocess.Popen(self._command)

    def end(self, seconds: float) -> None:
        """Have it end in good order, or kill it."""
        if self._process is None:
            return
        self._process.terminate()
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self._process.kill()


def _changed(file: Path) -> int:
    """Return when a file was changed [ns]; 0: it is not there."""
    try:
        return file.stat().st_mtime_ns
    except OSError:
        return 0


class Extension:
    """Both programs, and what the front page tells of them."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.payload = Child([ROSS, "run", settings.config], settings.config)
        page = ["ground", settings.telemetry, "--host", settings.host, "--port", settings.page]
        self.page = Child([ROSS, *page, "--token-file", token_file(settings)])

    def told(self) -> tuple[bool, str, str]:
        """Return whether all is well, how the payload is, and what to do."""
        config = self.settings.config
        if not config.is_file():
            advice = f"Put its description there with the file browser, as userdata/ross/{config.name}, and it starts."
            return True, f"There is no {config} yet.", advice
        if self.payload.refused:
            return (
                True,
                "The payload refuses its configuration.",
                f"The log says why. Change {config}, or plug in what is missing: within a minute it starts again.",
            )
        try:
            values = asked(self.settings.state)
        except (OSError, ValueError):
            return False, "The payload does not answer.", "It may be starting; else the log says why."
        return not values.get("late"), in_words(values), ""


def token_file(settings: Settings) -> Path:
    """Return the file with the page's token, made for its owner alone when it is missing, and show the token."""
    path = settings.state / "page-token"
    if not path.exists():
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:  # noqa: PTH123
            file.write(secrets.token_urlsafe(24) + "\n")
    print(f"the token of the page: {path.read_text().strip()}", flush=True)
    return path


class Front(BaseHTTPRequestHandler):
    """The front page; nothing can be changed by it."""

    timeout = 5.0
    server_version, sys_version = "ross", ""

    def __init__(self, extension: Extension, *request: Any) -> None:
        self._extension = extension
        super().__init__(*request)

    def do_GET(self) -> None:
        """Answer a request."""
        if self.path == "/":
            self._answer(self._page().encode(), "text/html; charset=utf-8")
        elif self.path == "/register_service":
            self._answer(json.dumps(SERVICE).encode(), "application/json")
        elif self.path == "/icon.svg":
            self._answer(ICON.read_bytes(), "image/svg+xml")
        elif self.path == "/well":
            well, state, _ = self._extension.told()
            self._answer(state.encode(), "text/plain; charset=utf-8", 200 if well else 503)
        else:
            self.send_error(404)

    def _page(self) -> str:
        host = self.headers.get("Host", "localhost").rpartition(":")[0] or "localhost"
        _, state, advice = self._extension.told()
        port = self._extension.settings.page
        escaped = (html.escape(text) for text in (state, advice, host))
        return PAGE.format(
            version=__version__, port=port, **dict(zip(("state", "advice", "host"), escaped, strict=True))
        )

    def _answer(self, body: bytes, kind: str, status: int = 200) -> None:
        self.send_response(status)
        for name, value in {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "Content-Security-Policy": "default-src 'none'; img-src 'self'; style-src 'unsafe-inline'",
        }.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing: BlueOS asks again and again."""


def check(settings: Settings) -> int:
    """Ask the extension that runs here whether all is well."""
    try:
        connection = HTTPConnection("127.0.0.1", settings.front, timeout=5)
        connection.request("GET", "/well")
        answer = connection.getresponse()
    except OSError as error:
        print(f"the front page does not answer: {error.strerror or 'in time'}")
        return 1
    print(answer.read().decode())
    return 0 if answer.status == 200 else 1


def main() -> int:
    """Run the extension until SIGTERM."""
    settings, ended = Settings(), threading.Event()
    if sys.argv[1:] == ["--check"]:
        return check(settings)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    extension = Extension(settings)
    with ThreadingHTTPServer((settings.host, settings.front), partial(Front, extension)) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        while not ended.wait(LOOK_S):
            extension.payload.look()
            extension.page.look()
        server.shutdown()
    extension.payload.end(GOING_S)
    extension.page.end(1.0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
