"""Makes the pictures of the ground's page that the manual shows: `python docs/tour.py`.

The demo's mission is flown, and its telemetry log is shown: as a recording, and said again over UDP by a payload.
"""

import os
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from PIL import Image
from playwright.sync_api import Browser, Page, ViewportSize, sync_playwright

from ross_payload.ground.web.app import in_background
from ross_sim.sitl.page_observer import free_port

STATIC = Path(__file__).parent / "_static"
PAYLOAD = "1-191"
SEED = "0"
COLOURS = 96
SETTLED = 5  # times that the payload says it is alive before the picture is taken
BEAT = 300  # [ms]
HEARTBEAT = 0  # message id


@dataclass(frozen=True)
class View:
    """One picture: what is shown, at which share of the mission, on which screen."""

    name: str
    moment: float
    scheme: Literal["dark", "light"]
    width: int
    height: int
    live: bool


VIEWS = (
    View("page-live", 0.97, "light", 1280, 860, live=True),
    View("page-exploring", 0.45, "dark", 1280, 1180, live=False),
    View("page-phone", 0.97, "dark", 390, 844, live=True),
)


def main() -> None:
    """Fly the demo, and keep the pictures of it."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ross_payload.cli", "sitl", "--seed", SEED, "--out", folder]
        subprocess.run(command, check=True)  # noqa: S603 - our own command
        with sync_playwright() as playwright:
            executable = (
                os.environ.get("CHROMIUM") or shutil.which("chromium-headless-shell") or shutil.which("chromium")
            )
            browser = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox", "--disable-gpu"])
            take(Path(folder) / "mission.tlog", STATIC, browser)
            browser.close()


def take(log: Path, into: Path, browser: Browser) -> None:
    """Take every picture of a telemetry log."""
    for view in VIEWS:
        port = free_port()
        with in_background([f"udpin:127.0.0.1:{port}"], flights=log.parent) as served, window(view, browser) as page:
            page.goto(served.url)
            (live if view.live else recorded)(page, served.url, log, view.moment, port)
            keep(page.screenshot(), into / f"{view.name}.png")


@contextmanager
def window(view: View, browser: Browser) -> Iterator[Page]:
    """Open a page as large as the view's screen."""
    size: ViewportSize = {"width": view.width, "height": view.height}
    page = browser.new_page(viewport=size, color_scheme=view.scheme, reduced_motion="reduce")
    try:
        yield page
    finally:
        page.close()


def live(page: Page, url: str, log: Path, moment: float, port: int) -> None:
    """Say what was said up to a moment, and that the payload is alive."""
    said = list(frames(log))
    end = said[0][0] + moment * (said[-1][0] - said[0][0])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as payload:
        payload.connect(("127.0.0.1", port))
        for number, (time, frame) in enumerate(said):
            if time <= end:
                payload.send(frame)
            if number % 50 == 0:
                page.wait_for_timeout(20)
        beat = [frame for time, frame in said if time <= end and int.from_bytes(frame[7:10], "little") == HEARTBEAT][-1]
        page.goto(f"{url}#/payload/{PAYLOAD}")
        page.locator(".scope .source").first.wait_for()
        for _ in range(SETTLED):
            payload.send(beat)
            page.wait_for_timeout(BEAT)


def recorded(page: Page, url: str, log: Path, moment: float, port: int) -> None:
    """Open the flight at a moment."""
    page.goto(f"{url}#/flights")
    page.get_by_role("button", name=f"Open {log.name}").click()
    slider = page.get_by_label(f"Time of {log.name}")
    slider.fill(str(round(moment * float(slider.evaluate("slider => slider.max")), 1)))
    page.locator(".recorded .scope .source").first.wait_for()
    page.wait_for_timeout(SETTLED * BEAT)
    page.evaluate("() => scrollTo(0, document.querySelector('.slots').offsetTop - 80)")


def frames(log: Path) -> Iterator[tuple[int, bytes]]:
    """Read the times [us] and frames of a log of unsigned MAVLink 2."""
    data, start = log.read_bytes(), 0
    while start + 10 <= len(data):
        size = 12 + data[start + 9]
        yield int.from_bytes(data[start : start + 8], "big"), data[start + 8 : start + 8 + size]
        start += 8 + size


def keep(picture: bytes, path: Path) -> None:
    """Keep a picture with few colours, so that it stays small."""
    with tempfile.TemporaryFile() as file:
        file.write(picture)
        with Image.open(file) as shot:
            shot.convert("RGB").quantize(COLOURS).save(path, optimize=True)


if __name__ == "__main__":
    main()
