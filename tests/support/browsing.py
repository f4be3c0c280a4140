"""A Chromium that a test drives: where it is found, and what its pages ask for and complain of.

A process of a page costs more to start than most tests need in it. So there is one profile for all tests (`Profile`),
with a page that stays open and opens the others: they share its process. What a test leaves there is forgotten when it
ends: pages, cookies, and what was stored for the addresses it asked for.
"""

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

HERE = "127.0.0.1"
COMMANDS = ("chromium-headless-shell", "chromium", "chromium-browser")  # what Debian and Ubuntu call it
FLAGS = (
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-gpu",
    "--disable-quic",
    "--disable-sync",
    f"--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE {HERE}",
    "--no-first-run",
    "--no-sandbox",  # continuous integration is root in a container
    "--process-per-site",
)
CHANGED = "ERR_NETWORK_CHANGED"
TRIES = 5
PATIENCE_S = 60.0  # with a computer that is busy: far beyond what anything needs
FIRST_PAUSE, LONGEST_PAUSE = 10.0, 100.0  # [ms] between two looks
DUE_FRAMES = 5
FRAMES = """async (count) => {
  for (let index = 0; index < count; index++) await new Promise((drawn) => requestAnimationFrame(drawn));
}"""
LOCAL = ("about", "blob", "data")  # schemes that leave no machine


def chromium() -> Path | None:
    """The browser: $CHROMIUM, else the one of the system, best the one without windows: it costs a sixth less."""
    named = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, COMMANDS)), None)
    return None if named is None else Path(named)


def leaves(url: str) -> bool:
    """Whether a request goes to another machine."""
    place = urlsplit(url)
    return place.scheme not in LOCAL and place.hostname != HERE


class Profile:
    """A private window of a browser that is used by one test after the other."""

    def __init__(self, browser: Any) -> None:
        self.context = browser.new_context(service_workers="block")
        self.context.set_default_timeout(1000 * PATIENCE_S)
        self._kept = self.context.new_page()
        self._kept.route(
            "**/*", lambda route: route.fulfill(body="<title>stays open</title>", content_type="text/html")
        )
        self._kept.goto(f"http://{HERE}/")
        self._storage = self.context.new_cdp_session(self._kept)

    @contextmanager
    def watched(self) -> Iterator["Watched"]:
        """Watch what is opened in it, and forget it in the end."""
        watched = Watched(self.context, self._kept)
        try:
            yield watched
        finally:
            watched.close()
            self.context.clear_cookies()
            for origin in watched.origins:
                self._storage.send("Storage.clearDataForOrigin", {"origin": origin, "storageTypes": "all"})


@dataclass
class Watched:
    """Pages of a browser: what left the machine, and what went wrong on them."""

    context: Any
    opener: Any  # a page that stays open
    pages: list[Any] = field(default_factory=list)  # that were opened
    origins: set[str] = field(default_factory=set)  # of what was asked for
    strangers: list[str] = field(default_factory=list)  # URLs of other machines that were asked for
    errors: list[str] = field(default_factory=list)
    expected: list[str] = field(default_factory=list)  # parts of complaints that a test causes on purpose
    interrupted: int = 0  # loads that ended because the machine got or lost a network, as other tests make it do

    def __post_init__(self):
        self._heard = {
            "request": lambda request: self._asked(request.url),
            "console": self._console,
            "weberror": lambda error: self.errors.append(str(error.error)),
            "page": self._opened,
        }
        for event, call in self._heard.items():
            self.context.on(event, call)

    def new_page(self) -> Any:
        """Open a page."""
        with self.context.expect_page() as opened:
            self.opener.evaluate("void open('about:blank', '_blank')")
        return opened.value

    def open(self, page: Any, url: str) -> None:
        """Load a page to its end."""
        for _ in range(TRIES):
            before = self.interrupted
            page.goto(url)
            if self.interrupted == before:
                return
            page.goto("about:blank")

    def close_pages(self) -> None:
        """Close what is open."""
        for page in self.pages:
            page.close()

    def close(self) -> None:
        """Close what is open, and watch no more."""
        self.close_pages()
        for event, call in self._heard.items():
            self.context.remove_listener(event, call)

    def unexpected(self) -> list[str]:
        return [error for error in self.errors if not any(part in error for part in self.expected)]

    def _opened(self, page: Any) -> None:
        self.pages.append(page)
        page.on("websocket", lambda socket: self._asked(socket.url))

    def _asked(self, url: str) -> None:
        place = urlsplit(url)
        self.origins |= {f"{place.scheme}://{place.netloc}"} if place.scheme == "http" else set()
        if leaves(url):
            self.strangers.append(url)

    def _console(self, message: Any) -> None:
        if CHANGED in message.text:
            self.interrupted += 1
        elif message.type == "error":
            self.errors.append(f"{message.text} ({message.location.get('url', '')})")


def eventually(
    page: Any, claim: Callable[[], Any], patience: float = PATIENCE_S, what: Callable[[], str] = lambda: "it"
) -> None:
    """Let the page work until a claim holds; fail, and say ``what`` was claimed, when it never does."""
    end, pause = time.monotonic() + patience, FIRST_PAUSE
    while not claim():
        assert time.monotonic() < end, f"never became true: {what()}"
        page.wait_for_timeout(pause)
        pause = min(1.5 * pause, LONGEST_PAUSE)


def drawn(page: Any) -> None:
    """Let the page draw what is due: what changed, then what that makes it measure."""
    page.evaluate(FRAMES, DUE_FRAMES)
