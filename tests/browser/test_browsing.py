"""What holds tests of the page to account works itself."""

import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from browsing import HERE, eventually, leaves


@contextmanager
def serving(html):
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200 if self.path == "/" else 404)
            self.end_headers()
            self.wfile.write(html.encode())

        def log_message(self, *words):
            pass

    with ThreadingHTTPServer((HERE, 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://{HERE}:{server.server_port}/"
        server.shutdown()
        thread.join()


@pytest.fixture
def watch(profile):
    with profile.watched() as watched:
        yield watched


def visit(watch, html, claim):
    with serving(html) as url:
        page = watch.new_page()
        page.goto(url)
        eventually(page, lambda: claim(page))


@pytest.mark.parametrize(
    "html",
    [
        '<img src="http://example.org/a.png">',
        '<link rel="stylesheet" href="https://192.0.2.7/a.css">',
        '<script>new WebSocket("ws://example.org/live")</script>',
        '<script>fetch("http://localhost:1/").catch(() => 0)</script>',
    ],
)
def test_a_request_to_another_machine_is_noticed(watch, html):
    visit(watch, f"<title>x</title>{html}", lambda _: watch.strangers and watch.unexpected())
    assert len(watch.strangers) == 1


def test_an_error_of_a_script_is_noticed(watch):
    visit(watch, "<title>x</title><script>nonsense()</script>", lambda _: watch.unexpected())
    assert any("nonsense is not defined" in error for error in watch.unexpected())


def test_a_good_page_is_not_blamed(watch):
    html = '<title>x</title><link rel="icon" href="data:,"><script>console.log("fine"); globalThis.fine = true</script>'
    visit(watch, html, lambda page: page.wait_for_load_state("networkidle") or page.evaluate("fine"))
    assert not watch.strangers
    assert not watch.unexpected()


def test_what_a_page_makes_itself_does_not_leave():
    assert not leaves("data:text/plain,x")
    assert leaves("https://fonts.example/a.woff")
