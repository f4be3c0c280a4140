"""The login in a real browser, while another site does its worst."""

import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from page_eyes import sees
from ross_payload.ground.web.security import TRIES
from served_ground import served

TOKEN = "open-sesame-open-sesame"  # noqa: S105


@contextmanager
def another_site(html):
    """Serve a page on another port, which is another origin."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(html.encode())

        def log_message(self, *words):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()


def test_images_of_another_site_do_not_keep_the_user_out(window, open_page, tmp_path):
    window.expected += ["Failed to load resource", "ERR_BLOCKED"]
    file = tmp_path / "token"
    file.write_text(TOKEN)
    file.chmod(0o600)
    with served("--token-file", file) as ground:
        images = "".join(f'<img src="{ground.url}?token=guess{number}">' for number in range(2 * TRIES))
        with another_site(images) as evil:
            evil_page = open_page(evil)
            evil_page.wait_for_load_state("networkidle")
        page = open_page(ground.url)
        page.get_by_label("Token").fill(TOKEN)
        page.get_by_role("button", name="Open").click()
        sees(page, "No payload found", "main")
        linked = open_page(f"{ground.url}?token={TOKEN}")
        sees(linked, "No payload found", "main")
        window.close_pages()
