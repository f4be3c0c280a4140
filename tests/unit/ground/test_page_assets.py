"""What the page is served with: headers of safety, and every file that it names."""

import posixpath
import re

import aiohttp

from ground_page import page
from hand_station import HandStation


async def test_the_page_is_served_with_the_headers_of_safety():
    async with page(HandStation()) as served, aiohttp.ClientSession() as client, client.get(served.url) as answer:
        assert answer.status == 200
        assert answer.content_type == "text/html"
        assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
        assert "unsafe" not in answer.headers["Content-Security-Policy"]
        assert answer.headers["Cache-Control"] == "no-cache"


async def test_an_asset_that_did_not_change_is_not_sent_again():
    async with page(HandStation()) as served, aiohttp.ClientSession() as client:
        url = f"{served.url}assets/connection.js"
        async with client.get(url) as first:
            assert first.content_type == "text/javascript"
            assert await first.read()
        async with client.get(url, headers={"If-None-Match": first.headers["ETag"]}) as second:
            assert second.status == 304
            assert not await second.read()


async def test_every_file_that_the_page_names_is_there_and_every_module_that_those_import():
    async with page(HandStation()) as served, aiohttp.ClientSession() as client:
        async with client.get(served.url) as answer:
            waiting = re.findall(r'(?:src|href)="/(assets/[^"]+)"', await answer.text())
        found = set()
        while waiting:
            name = waiting.pop()
            async with client.get(f"{served.url}{name}") as answer:
                assert answer.status == 200, name
                text = await answer.text()
            found.add(name)
            imported = re.findall(r'(?:from|import\()\s*"(\.[^"]+)"', text) if name.endswith(".js") else []
            names = {posixpath.normpath(posixpath.join(posixpath.dirname(name), each)) for each in imported}
            waiting += names - found
        assert {"assets/app.js", "assets/templates.js"} < found
