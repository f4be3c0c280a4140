"""The instruments of the ground page alone, served with the page's own rules, for tests and for a look at them."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from browsing import HERE, Profile
from scenes import NOW

ROOT = Path(__file__).resolve().parents[2]
ASSETS = ROOT / "ross_payload" / "ground" / "web" / "assets"
PAGE = ROOT / "tests" / "browser"
POLICY = "default-src 'self'; object-src 'none'; base-uri 'none'"
TYPES = {".svg": "image/svg+xml", ".html": "text/html", ".css": "text/css", ".js": "text/javascript"}


class _Handler(BaseHTTPRequestHandler):
    def do_GET(self):
        path = self.path.partition("?")[0]
        file = ASSETS / path.removeprefix("/assets/") if path.startswith("/assets/") else PAGE / f"gallery{path[8:]}"
        body = file.read_bytes() if file.suffix in TYPES and file.is_file() else None
        self.send_response(404 if body is None else 200)
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("Content-Type", TYPES.get(file.suffix, "text/plain"))
        self.end_headers()
        self.wfile.write(body or b"")

    def log_message(self, *words):
        pass


@contextmanager
def gallery() -> Iterator[str]:
    """Serve the gallery; its URL."""
    with ThreadingHTTPServer((HERE, 0), _Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://{HERE}:{server.server_port}/gallery.html"
        finally:
            server.shutdown()
            thread.join()


class Board:
    """The gallery on one page of a browser, drawn again as often as asked."""

    def __init__(self, page: Any) -> None:
        self._page = page
        page.wait_for_function("globalThis.show !== undefined")

    def __call__(self, sections: Any, *, width: int = 1000, theme: str = "light", **state: Any) -> Any:
        """Draw sections of a payload; the page."""
        self._page.set_viewport_size({"width": width, "height": 900})
        self._page.evaluate("theme => { document.documentElement.dataset.theme = theme; }", theme)
        blank = {"selected": None, "hovered": None, "drag": None, "cursor": None, "mayOrder": True, "now": NOW}
        self._page.evaluate(
            "state => { told.turned = []; told.chosen = []; told.selected = []; show(state); }",
            {**blank, "sections": sections, **state},
        )
        return self._page


@contextmanager
def board_of(profile: Profile) -> Iterator[Board]:
    """A board, which asks no other machine and does not complain."""
    with gallery() as url, profile.watched() as watched:
        page = watched.new_page()
        page.emulate_media(reduced_motion="reduce")
        watched.open(page, url)
        yield Board(page)
    assert not watched.strangers, f"asked other machines: {watched.strangers}"
    assert not watched.errors, f"the page complains: {watched.errors}"
