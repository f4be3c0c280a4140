"""A Chromium that a test drives: where it is found, and what its pages ask for and complain of."""

import os
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

HERE = "127.0.0.1"
FLAGS = (
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-gpu",
    "--disable-quic",
    "--disable-sync",
    f"--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE {HERE}",
    "--no-first-run",
    "--no-sandbox",  # continuous integration is root in a container
)
CHANGED = "ERR_NETWORK_CHANGED"
TRIES = 5
LOCAL = ("about", "blob", "data")  # schemes that leave no machine


def chromium() -> Path | None:
    """The browser: $CHROMIUM, else the one of the system."""
    named = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    return None if named is None else Path(named)


def leaves(url: str) -> bool:
    """Whether a request goes to another machine."""
    place = urlsplit(url)
    return place.scheme not in LOCAL and place.hostname != HERE


@dataclass
class Watched:
    """A browser's private window: what left the machine, and what went wrong on its pages."""

    context: Any
    strangers: list[str] = field(default_factory=list)  # URLs of other machines that were asked for
    errors: list[str] = field(default_factory=list)
    expected: list[str] = field(default_factory=list)  # parts of complaints that a test causes on purpose
    interrupted: int = 0  # loads that ended because the machine got or lost a network, as other tests make it do

    def __post_init__(self):
        self.context.set_default_timeout(15_000)
        self.context.on("request", lambda request: self._asked(request.url))
        self.context.on("console", self._console)
        self.context.on("weberror", lambda error: self.errors.append(str(error.error)))
        self.context.on("page", lambda page: page.on("websocket", lambda socket: self._asked(socket.url)))

    def open(self, page: Any, url: str) -> None:
        """Load a page to its end."""
        for _ in range(TRIES):
            before = self.interrupted
            page.goto(url)
            if self.interrupted == before:
                return
            page.goto("about:blank")

    def unexpected(self) -> list[str]:
        return [error for error in self.errors if not any(part in error for part in self.expected)]

    def _asked(self, url: str) -> None:
        if leaves(url):
            self.strangers.append(url)

    def _console(self, message: Any) -> None:
        if CHANGED in message.text:
            self.interrupted += 1
        elif message.type == "error":
            self.errors.append(f"{message.text} ({message.location.get('url', '')})")


def eventually(page: Any, claim: Callable[[], Any], patience: float = 20.0) -> None:
    """Let the page work until a claim holds; fail when it never does."""
    end = time.monotonic() + patience
    while not claim():
        assert time.monotonic() < end, "it never became true"
        page.wait_for_timeout(20)
