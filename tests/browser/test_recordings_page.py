"""In a browser: recordings that are downloaded and deleted, and a payload that is addressed by its id."""

import zipfile

import pytest
from playwright.sync_api import expect

from browsing import eventually
from fleet_bench import FleetThread
from page_eyes import sees, violations
from ports import free_port
from recording_bench import input_of, record
from ross_payload.ground.web.app import in_background
from ross_payload.sessions.catalog import Catalog
from ross_payload.sessions.session_store import SessionStore


@pytest.fixture
def store(tmp_path):
    record(tmp_path / "recordings", [input_of(index) for index in range(50)])
    return SessionStore(tmp_path / "recordings")


def test_a_recording_is_downloaded_and_deleted_on_the_page(store, window, open_page):
    with in_background([f"udpin:127.0.0.1:{free_port()}"], recordings=Catalog(store)) as served:
        page = open_page(f"{served.url}#/flights")
        sees(page, str(store.folder), "section[aria-label='Recordings']")
        with page.expect_download() as download:
            page.get_by_role("link", name="Download 0001").click()
        with zipfile.ZipFile(download.value.path()) as archive:
            assert archive.read("0001/audio.wav") == (store.folder / "0001" / "audio.wav").read_bytes()
        page.on("dialog", lambda dialog: pytest.fail("the page, and its stop, is held up"))
        page.get_by_role("button", name="Delete 0001").click()
        page.get_by_role("button", name="Keep 0001").click()
        page.get_by_role("button", name="Delete 0001", exact=True).click()
        expect(page.get_by_role("button", name="Keep 0001")).to_be_focused()
        assert store.all()
        assert violations(page) == []
        page.wait_for_timeout(500)  # sooner it could be the second press of a double click
        page.get_by_role("button", name="Delete 0001 for good").click()
        sees(page, "Nothing is recorded yet", "section[aria-label='Recordings']")
        assert not store.all()
        page.close()


def middle_of_both(one, other):
    """The middle of what two boxes have in common."""
    spans = [
        (max(one[begin], other[begin]), min(one[begin] + one[size], other[begin] + other[size]))
        for begin, size in (("x", "width"), ("y", "height"))
    ]
    assert all(end > begin for begin, end in spans)
    return [(begin + end) / 2 for begin, end in spans]


def test_a_double_click_deletes_no_recording(store, window, open_page):
    """On a phone the answer stands where the question was asked."""
    with in_background([f"udpin:127.0.0.1:{free_port()}"], recordings=Catalog(store)) as served:
        page = open_page(f"{served.url}#/flights", width=360)
        question, answer = (
            page.get_by_role("button", name=f"Delete 0001{rest}", exact=True) for rest in ("", " for good")
        )
        question.click()
        told = answer.bounding_box()
        page.get_by_role("button", name="Keep 0001").click()
        place = middle_of_both(question.bounding_box(), told)
        page.mouse.click(*place)
        page.wait_for_timeout(120)
        page.mouse.click(*place)
        page.wait_for_timeout(500)
        assert store.all()
        answer.click()
        sees(page, "Nothing is recorded yet", "section[aria-label='Recordings']")
        page.close()


def test_a_payload_is_stopped_and_watched_by_its_id(window, open_page):
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"]) as served, FleetThread(port) as bench:
        page = open_page(served.url)
        sees(page, "1 payload found", "main")
        page.get_by_label("Payload by id").fill("1-191")
        page.get_by_role("button", name="Stop this id").click()
        orders = served.state.client.orders
        eventually(page, lambda: any(each.words == "stop" for each in orders.doing))
        page.get_by_label("Payload by id").fill("1-191")
        page.get_by_role("button", name="Watch this id").click()
        page.locator(".scope").first.wait_for()
        page.close()
        assert bench is not None
