"""When telemetry ends: nothing on the page says that all is well, and a simulation that is over says so."""

import pytest
from playwright.sync_api import expect

from browsing import eventually
from fleet_bench import FleetThread
from page_eyes import sees, watch
from ports import free_port
from ross_payload.ground.web.app import in_background
from ross_sim.sitl.pace import speed_words

OVER = "The simulation has ended."
LISTEN = "section[aria-label='Listen']"


@pytest.fixture
def simulated(browser):
    """A page in the process of a simulation, and its payload: (page, payload)."""
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"]) as served, FleetThread(port) as payload:
        yield served, payload


def test_silence_is_neither_live_nor_good(simulated, open_page):
    served, payload = simulated
    page = watch(open_page, served.url)
    assert page.locator(".brand .tag").inner_text() == "Live"
    payload.tell(silence=[1])
    eventually(page, lambda: page.locator(".brand .tag").inner_text() == "No telemetry")
    assert page.locator(".tag.good").count() == 0
    assert page.locator(".health .tag").first.inner_text() == "No data"
    assert "Last report: Good" in page.locator(".health").inner_text()
    assert "Last state:" in page.locator(".payload-title").inner_text()
    page.evaluate("location.hash = '#/'")
    sees(page, "Health: No data", ".fleet")
    assert page.locator(".tag.good").count() == 0
    assert page.get_by_role("button", name="Stop 1-191").get_attribute("aria-disabled") == "false"


def test_a_simulation_that_has_ended_has_nothing_to_stop_and_says_so(simulated, open_page):
    served, payload = simulated
    page = watch(open_page, served.url)
    payload.tell(silence=[1])
    served.state.over = OVER
    sees(page, OVER, "#ended")
    assert page.locator(".brand .tag").inner_text() == "Ended"
    assert page.locator("#no-telemetry").count() == 0
    expect(page.get_by_role("button", name="Explore", exact=True)).to_be_disabled()
    assert "nothing is streamed any more" in page.locator(LISTEN).inner_text()
    expect(page.get_by_role("button", name="Listen", exact=True)).to_be_disabled()
    stop = page.get_by_role("button", name="Stop: nothing is running")
    assert stop.get_attribute("aria-disabled") == "true"
    stop.click(force=True)  # a click on it is not lost: it says why
    sees(page, "nothing to stop", ".stop-fate")
    assert page.locator(".order", has_text="stop").count() == 0


@pytest.mark.soak
def test_who_may_listen_is_told_how_fast_simulated_time_goes(simulated, open_page):
    served, _ = simulated
    page = watch(open_page, served.url)
    assert page.locator(f"{LISTEN} .pace").count() == 0
    served.state.pace = speed_words(4.0)
    sees(page, "4 times real time, and at real time while a stream is on", f"{LISTEN} .pace")
