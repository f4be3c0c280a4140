"""The stop: in reach at all times, and what is told of it is so."""

import pytest

from fleet_bench import FleetThread
from page_eyes import sees, violations, watch
from served_ground import served

PHONE, SMALL_PHONE, DESK = (390, 844), (320, 480), (1280, 800)
HERE = "document.querySelector('.stop-button')"
IN_REACH = f"""() => {{
  const {{ left, top, width, height }} = {HERE}.getBoundingClientRect();
  return document.elementFromPoint(left + width / 2, top + height / 2)?.closest(".stop-button") === {HERE};
}}"""


@pytest.fixture(scope="module")
def crew(browser):
    with served() as ground, FleetThread(ground.port) as payloads:
        yield ground, payloads


@pytest.fixture
def page(crew, open_page):
    return watch(open_page, crew[0].url)


def test_the_stop_is_in_reach_while_a_talker_is_to_be_enrolled(page):
    page.get_by_role("button", name="Take control").click()
    page.locator("table.sources").get_by_role("button", name="Source 1").click()
    for width, height in (DESK, PHONE, SMALL_PHONE):
        page.set_viewport_size({"width": width, "height": height})
        page.get_by_role("button", name="Enrol source 1").click()
        dialog = page.get_by_role("dialog")
        dialog.get_by_role("checkbox").wait_for()
        assert page.evaluate(IN_REACH), f"{width} x {height}"
        dialog.get_by_role("button", name="Enrol", exact=True).scroll_into_view_if_needed()
        assert page.evaluate(IN_REACH), f"{width} x {height}"
        assert violations(page) == []
        dialog.get_by_role("button", name="Cancel").click()
        dialog.wait_for(state="hidden")
        assert page.evaluate("document.activeElement.textContent.trim()") == "Enrol source 1…"
    page.get_by_role("button", name="Enrol source 1").click()
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="hidden")
    page.get_by_role("button", name="Enrol source 1").click()
    page.get_by_role("dialog").wait_for()
    page.get_by_role("button", name="Stop 1-191").click()
    sees(page, "Stopped", ".payload-title")
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Rearm", exact=True).click()
