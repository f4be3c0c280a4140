"""What an operator must see on every screen: refusals, whole tables, letters that can be read; and plain words."""

import pytest

from browsing import drawn, eventually
from fleet_bench import FleetThread
from made_telemetry import MadeTelemetry
from page_eyes import sees, violations, watch
from served_ground import served

pytest.importorskip("aiohttp", reason="the extra [ground]")

SIZES = ((390, 844), (320, 640), (768, 1024), (1280, 800), (3840, 2160))
VIEWS = ("payload/1-191", "", "map", "flights")
IN_SIGHT = """selector => {
  const element = document.querySelector(selector);
  if (!element) return `no ${selector}`;
  const { left, top, right, bottom } = element.getBoundingClientRect();
  if (top < 0 || left < 0 || bottom > innerHeight || right > innerWidth) return `at ${top} to ${bottom}`;
  const covered = [top + 2, bottom - 2].some((y) =>
    document.elementFromPoint(left + (right - left) / 4, y)?.closest(selector) !== element);
  return covered ? "covered" : "in sight";
}"""
APART = """selectors => {
  const [one, other] = selectors.map((each) => document.querySelector(each)?.getBoundingClientRect());
  if (!one || !other) return "not there";
  const aside = one.right <= other.left || other.right <= one.left;
  return aside || one.bottom <= other.top || other.bottom <= one.top ? "apart" : "one covers the other";
}"""
HIDDEN_COLUMNS = """() => [...document.querySelectorAll(".scroll")]
  .filter((each) => each.scrollWidth > each.clientWidth + 1).map((each) => each.getAttribute("aria-label"))"""
SMALLEST = """() => {
  const sizes = [];
  const walk = document.createTreeWalker(document.getElementById("page"), NodeFilter.SHOW_TEXT);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    const element = node.parentElement;
    if (!node.data.trim() || element.closest(".unseen, .skip, title, option") || !element.getClientRects().length)
      continue;
    const zoom = element.getScreenCTM?.()?.d ?? 1;
    sizes.push(zoom * parseFloat(getComputedStyle(element).fontSize));
  }
  return Math.min(...sizes);
}"""
MISSION = """async (mission) => {
  const { missionFacts } = await import("/assets/parts/mission.js");
  const { render } = await import("/assets/templates.js");
  const place = document.createElement("div");
  render(missionFacts({ mission }), place);
  return [...place.querySelectorAll(".facts > div")].map((each) => each.innerText ?? each.textContent)
    .map((each) => each.replace(/\\s+/g, " ").trim()).find((each) => each.startsWith("Target"));
}"""


@pytest.fixture(scope="module")
def crew(browser, tmp_path_factory):
    with served("--flights", tmp_path_factory.mktemp("flights")) as ground, FleetThread(ground.port, sources=4):
        yield ground


@pytest.fixture
def kept(pages, window):
    """Their page, as large as it mostly is."""
    pages.set_viewport_size({"width": 1280, "height": 800})
    pages.evaluate("location.hash = '#/payload/1-191'")
    pages.locator("table.sources").wait_for()
    return pages


@pytest.fixture(scope="module")
def pages(crew, keep_page):
    return keep_page(crew.url)


def test_a_refusal_is_in_sight_at_every_width_and_wherever_the_page_is_scrolled(crew, open_page):
    page = watch(open_page, crew.url, width=SIZES[0][0], height=SIZES[0][1])
    page.get_by_role("button", name="Take control").click()
    page.locator("table.sources").get_by_role("button", name="Source 3").click()
    page.get_by_role("button", name="Listen to source 3").first.click()  # its commands know of three: 0, 1 and 2
    page.locator(".order[data-state='refused']").wait_for()
    assert page.evaluate(IN_SIGHT, "#failure") == "in sight"  # as soon as it is known here
    sees(page, "expected 0 to 2", "#failure")  # in the payload's words, which come by themselves
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        for place in ("document.body.scrollHeight", "0"):
            page.evaluate(f"scrollTo(0, {place})")
            assert page.evaluate(IN_SIGHT, "#failure") == "in sight", f"{width} x {height}, scrolled to {place}"


def test_what_became_of_a_stop_does_not_cover_a_refusal(crew, open_page):
    page = watch(open_page, crew.url, width=SIZES[0][0], height=SIZES[0][1])
    page.get_by_role("button", name="Take control").click()
    page.get_by_role("button", name="Stop 1-191").click()
    page.locator(".stop-fate").wait_for()
    page.locator("table.sources").get_by_role("button", name="Source 3").click()
    page.get_by_role("button", name="Listen to source 3").first.click()
    page.locator("#failure").wait_for()
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("scrollTo(0, document.body.scrollHeight)")
        assert page.evaluate(APART, [".stop-fate", "#failure"]) == "apart", f"{width} x {height}"
        assert page.evaluate(IN_SIGHT, ".stop-fate") == "in sight", f"{width} x {height}"


def test_no_table_hides_columns_on_the_smallest_phone(kept):
    page = kept
    page.set_viewport_size({"width": 320, "height": 640})
    page.locator(".parameters summary").click()
    page.locator(".parameters table").wait_for()
    for view in VIEWS:
        page.evaluate("view => { location.hash = `#/${view}`; }", view)
        page.locator(f".view-{view.split('/')[0] or 'fleet'}").wait_for()
        assert page.evaluate(HIDDEN_COLUMNS) == [], view


def test_letters_grow_with_the_screen(kept):
    page = kept
    small = page.evaluate(SMALLEST)
    page.set_viewport_size({"width": 3840, "height": 2160})
    eventually(page, lambda: page.evaluate(SMALLEST) >= 1.7 * small)
    assert small >= 11.5


def test_a_target_says_whether_it_is_the_enrolled_voice(kept):
    page = kept
    assert page.evaluate(MISSION, {"target": 1, "target_found": True}).endswith("recognised as the enrolled voice")
    chosen = page.evaluate(MISSION, {"target": 1, "target_found": False})
    assert chosen.endswith("Source 1 selected; not recognised as the enrolled voice")
    assert page.evaluate(MISSION, {"target": None, "target_found": False}).endswith("no target yet")


def test_how_long_the_payload_runs_is_not_how_long_its_computer_does(kept):
    page = kept
    assert "running for" in page.locator(".payload-title").inner_text()
    assert "Computer up for" in page.locator(".health").inner_text()
    assert "Runs for" not in page.locator(".health").inner_text()


LINK_NAMES = """async (links) => {
  const { linkName } = await import("/assets/parts/health.js");
  return links.map((each) => linkName(each, links));
}"""


def test_a_link_is_named_by_its_medium_and_where_it_leads(kept):
    links = [
        {"url": "udpin:127.0.0.1:51234", "autopilot": False},
        {"url": "serial:/dev/ttyAMA0:921600", "autopilot": True},
        {"url": "udpout:10.0.0.2:14550", "autopilot": False},
        {"url": "tcpin:0.0.0.0:5760", "autopilot": False},
    ]
    names = kept.evaluate(LINK_NAMES, links)
    assert names[:2] == ["UDP link to the ground, 1", "Serial link to the autopilot"]
    assert names[2:] == ["UDP link to the ground, 2", "TCP link to the ground"]


@pytest.mark.parametrize("percent", [150, 200])
def test_large_letters_make_the_page_no_wider_than_a_phone(kept, percent):
    kept.set_viewport_size({"width": 320, "height": 640})
    kept.evaluate("size => { document.documentElement.style.fontSize = size; }", f"{percent}%")
    drawn(kept)
    wide = kept.evaluate("document.documentElement.scrollWidth")
    kept.evaluate("document.documentElement.style.fontSize = ''")
    assert wide == 320


def test_words_can_be_read_while_telemetry_stays_away(crew, window):
    told = MadeTelemetry(window, crew.url, 1280, 800)
    told.tell(age=65)
    assert violations(told.page, ["color-contrast"]) == []
