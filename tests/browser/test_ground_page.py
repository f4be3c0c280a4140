"""`ross ground` and its page: tokens, payloads that change, a log that ends."""

from contextlib import contextmanager

import pytest

from browsing import eventually
from fleet_bench import FleetThread
from page_eyes import sees
from served_ground import served


@pytest.fixture
def fly(window):
    """Run the ground and emulated payloads; pages are closed before it ends."""

    @contextmanager
    def flying(*arguments, **payloads):
        with served(*arguments) as ground, FleetThread(ground.port, **payloads) as bench:
            try:
                yield ground, bench
            finally:
                window.close_pages()

    return flying


def shown(page):
    page.locator(".scope .source").first.wait_for()
    page.evaluate("() => { globalThis.rossHere = true; }")  # is lost by a reload
    return page


def not_reloaded(page):
    return page.evaluate("() => globalThis.rossHere === true")


@pytest.mark.soak
def test_a_source_that_is_clicked_is_listened_to_and_a_stop_ends_it(fly, open_page):
    with fly() as (ground, _):
        page = shown(open_page(f"{ground.url}#/payload/1-191"))
        page.locator(".scope .source[data-source='2']").focus()
        page.keyboard.press("Enter")
        page.get_by_role("button", name="Listen to source 2").first.click()
        order = page.locator(".order", has_text="listen").first
        eventually(page, lambda: order.get_attribute("data-state") == "done")
        page.keyboard.press("Escape")
        page.keyboard.press("Escape")
        sees(page, "Stopped", ".payload-title")
        page.get_by_role("button", name="Explore").click()
        sees(page, "stopped: re-arm first", ".orders")


def test_a_wrong_token_opens_nothing_and_the_right_one_the_page(fly, open_page, tmp_path, window):
    window.expected += ["401", "403"]
    file = tmp_path / "token"
    file.write_text("right-0123456789abcdef\n")
    file.chmod(0o600)
    with fly("--token-file", file) as (ground, _):
        page = open_page(ground.url.partition("?")[0])
        page.get_by_label("Token").fill("wrong")
        page.get_by_role("button", name="Open").click()
        sees(page, "wrong")
        assert not page.locator(".topbar").count()
        page.get_by_label("Token").fill("right-0123456789abcdef")
        page.get_by_role("button", name="Open").click()
        page.locator(".topbar").wait_for()


@pytest.mark.soak
def test_a_payload_that_starts_with_other_parameters_is_asked_again(fly, open_page):
    with fly() as (ground, bench):
        page = shown(open_page(f"{ground.url}#/payload/1-191"))
        page.locator(".parameters summary").click()
        page.locator("#p-XPL_RUN, [id^='p-']").first.wait_for()
        bench.tell(change=[1])
        page.locator("#p-OTHER_TWO").wait_for(timeout=60_000)
        eventually(page, lambda: page.locator(".parameters tbody tr").count() == 2, 60.0)
        assert not_reloaded(page)


def test_a_log_that_has_ended_is_told_though_all_else_is_well(fly, open_page, tmp_path):
    with fly("--log", tmp_path) as (ground, _):
        page = shown(open_page(f"{ground.url}#/payload/1-191"))
        assert not page.locator(".banner").count()
        ground.fill_disk()
        sees(page, "the log has ended", ".banner")
        page.get_by_role("link", name="Map").click()
        sees(page, "the log has ended", ".banner")
