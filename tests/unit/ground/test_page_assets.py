"""What the page is served with: headers of safety, and every file that it names."""

import asyncio
import re

import aiohttp

from ground_page import page
from hand_station import HandStation


def test_the_page_is_served_with_the_headers_of_safety():
    async def run():
        async with page(HandStation()) as served, aiohttp.ClientSession() as client, client.get(served.url) as answer:
            assert answer.status == 200
            assert answer.content_type == "text/html"
            assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
            assert "unsafe" not in answer.headers["Content-Security-Policy"]
            assert answer.headers["Cache-Control"] == "no-cache"

    asyncio.run(run())


def test_an_asset_that_did_not_change_is_not_sent_again():
    async def run():
        async with page(HandStation()) as served, aiohttp.ClientSession() as client:
            url = f"{served.url}assets/live.js"
            async with client.get(url) as first:
                assert first.content_type == "text/javascript"
                assert await first.read()
            async with client.get(url, headers={"If-None-Match": first.headers["ETag"]}) as second:
                assert second.status == 304
                assert not await second.read()

    asyncio.run(run())


def test_every_file_that_the_page_names_is_there():
    async def run():
        async with page(HandStation()) as served, aiohttp.ClientSession() as client:
            async with client.get(served.url) as answer:
                text = await answer.text()
            names = re.findall(r'(?:src|href)="/(assets/[^"]+)"', text)
            assert names
            for name in names:
                async with client.get(f"{served.url}{name}") as answer:
                    assert answer.status == 200, name

    asyncio.run(run())
