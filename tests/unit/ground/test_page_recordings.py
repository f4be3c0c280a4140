"""Recorded sessions over the page: listed, downloaded and deleted by whoever may open it, and by nobody else."""

import asyncio
import io
import stat
import zipfile

import aiohttp
import pytest

from ground_page import browser, page
from hand_station import HandStation
from recording_bench import input_of, record, recording
from ross_payload.sessions.catalog import Catalog
from ross_payload.sessions.session_store import SessionStore

TOKEN = "open-sesame-open-sesame"  # noqa: S105


@pytest.fixture
def catalog(tmp_path):
    """Two recordings of 0.5 s."""
    folder = tmp_path / "recordings"
    for _ in range(2):
        record(folder, [input_of(index) for index in range(50)])
    return Catalog(SessionStore(folder))


async def visited(catalog, visit, **options):
    """Serve the recordings and visit them with a browser's session and the address of the page."""
    async with page(HandStation(), recordings=catalog, **options) as served, aiohttp.ClientSession() as client:
        return await visit(client, served.url)


async def fetched(client, url, method="GET", **options):
    async with client.request(method, url, **options) as answer:
        return answer.status, await answer.read(), answer.headers


async def test_the_page_tells_where_recordings_are_kept_and_which_there_are(catalog):
    async with page(HandStation(), recordings=catalog) as served, browser(served.url) as one:
        told = await one.next("recordings")
        assert told["folder"] == str(catalog.folder)
        first, second = told["known"]
        assert (first["name"], second["name"]) == ("0001", "0002")
        assert first["seconds"] == pytest.approx(0.5)
        assert first["bytes"] == sum(path.stat().st_size for path in catalog.files("0001").values())
        assert not first["running"]
        record(catalog.folder, [input_of(0)])
        again = await one.next("recordings")
        assert [each["name"] for each in again["known"]] == ["0001", "0002", "0003"]


async def test_an_archive_holds_every_file_to_the_byte(catalog):
    async def visit(client, url):
        return await fetched(client, f"{url}recordings/0002.zip")

    status, body, headers = await visited(catalog, visit)
    assert status == 200
    assert headers["Content-Disposition"] == 'attachment; filename="0002.zip"'
    assert headers["Cache-Control"] == "no-store"
    with zipfile.ZipFile(io.BytesIO(body)) as archive:
        assert archive.testzip() is None
        found = {name: archive.read(name) for name in archive.namelist()}
        assert all(stat.S_IMODE(info.external_attr >> 16) == 0o600 for info in archive.infolist())
    assert found == {f"0002/{name}": path.read_bytes() for name, path in catalog.files("0002").items()}
    assert "0002/audio.wav" in found


async def test_one_file_can_be_had_alone_and_in_parts(catalog):
    async def visit(client, url):
        whole = await fetched(client, f"{url}recordings/0001/audio.wav")
        part = await fetched(client, f"{url}recordings/0001/audio.wav", headers={"Range": "bytes=4-11"})
        return whole, part

    (status, body, headers), (part_status, part, _) = await visited(catalog, visit)
    assert (status, part_status) == (200, 206)
    assert body == catalog.files("0001")["audio.wav"].read_bytes()
    assert part == body[4:12]
    assert headers["Cache-Control"] == "no-store"


async def test_a_deleted_recording_is_gone_and_the_others_stay(catalog):
    async def visit(client, url):
        status, _, _ = await fetched(client, f"{url}recordings/0001", "DELETE")
        again, why, _ = await fetched(client, f"{url}recordings/0001", "DELETE")
        return status, again, why, await fetched(client, f"{url}recordings")

    status, again, why, (_, left, _) = await visited(catalog, visit)
    assert (status, again) == (200, 404)
    assert b"not found" in why
    assert b"0002" in left
    assert b"0001" not in left
    assert not (catalog.folder / "0001").exists()


async def test_a_recording_that_goes_on_is_downloaded_as_far_as_it_has_come_and_not_deleted(catalog):
    async def visit(client, url):
        refused = await fetched(client, f"{url}recordings/0003", "DELETE")
        return refused, await fetched(client, f"{url}recordings/0003.zip")

    with recording(catalog.folder) as recorder:
        for index in range(300):
            recorder.on_input(input_of(index))
        recorder.drain()
        (status, why, _), (_, body, _) = await visited(catalog, visit)
        written = catalog.files("0003")["inputs.jsonl"].read_bytes()
    assert status == 409
    assert b"is being recorded" in why
    with zipfile.ZipFile(io.BytesIO(body)) as archive:
        assert archive.testzip() is None
        assert archive.read("0003/inputs.jsonl") == written
    assert written.count(b"\n") >= 100


async def test_a_download_of_a_recording_that_is_deleted_meanwhile_breaks_off(catalog, capsys):
    with catalog.files("0001")["audio.wav"].open("ab") as file:
        file.truncate(16 << 20)  # more than fits on the way to the browser

    async def visit(client, url):
        async with client.get(f"{url}recordings/0001.zip") as answer:
            await answer.content.readexactly(1000)
            assert (await fetched(client, f"{url}recordings/0001", "DELETE"))[0] == 200
            async with asyncio.timeout(10):
                with pytest.raises(aiohttp.ClientPayloadError):
                    await answer.read()

    await visited(catalog, visit)
    assert not capsys.readouterr().err


async def test_without_the_token_or_from_another_site_nothing_is_listed_given_or_deleted(catalog):
    paths = [("GET", "recordings"), ("GET", "recordings/0001.zip"), ("GET", "recordings/0001/audio.wav")]
    requests = [*paths, ("DELETE", "recordings/0001")]

    async def stranger(client, url):
        return [(await fetched(client, url + path, method))[0] for method, path in requests]

    async def elsewhere(client, url):
        origin = {"Origin": "http://evil.example"}
        return [(await fetched(client, url + path, method, headers=origin))[0] for method, path in requests]

    assert await visited(catalog, stranger, token=TOKEN) == [401] * 4
    assert await visited(catalog, elsewhere) == [403] * 4
    assert (catalog.folder / "0001" / "audio.wav").is_file()


NOT_TO_BE_HAD = (
        "recordings/0009.zip", "recordings/0001/nothing", "recordings/0001/secret",
        "recordings/0001/.session.json.part", "recordings/..%2f0001.zip",
        "recordings/0001/..%2fsecret", "recordings/%2e%2e/secret",
        "recordings/0001/voice.npz", "recordings/", "recordings/0001/", "recordings/0001%00.zip", "recordings/%ff.zip",
)  # fmt: skip


async def test_no_path_leads_to_anything_but_the_files_of_a_recording(catalog):
    (catalog.folder / "secret").write_text("secret")
    (catalog.folder / "0001" / "secret").write_text("secret")
    (catalog.folder / "0001" / "voice.npz").symlink_to(catalog.folder / "secret")

    async def visit(client, url):
        urls = (aiohttp.client.URL(url + path, encoded=True) for path in NOT_TO_BE_HAD)
        return [(each, await fetched(client, each)) for each in urls]

    for url, (status, body, _) in await visited(catalog, visit):
        assert status == 404, url
        assert b"secret" not in body, url


async def test_a_ground_without_recordings_offers_none(catalog):
    async def visit(client, url):
        return [(await fetched(client, url + path))[:2] for path in ("recordings", "recordings/0001.zip")]

    (status, listed), (missing, _) = await visited(None, visit)
    assert (status, listed) == (200, b'{"folder": null, "known": []}')
    assert missing == 404
