"""The page as its operator meets it: a real browser, `ross ground` in its process, emulated payloads on real UDP."""

import pytest
from playwright.sync_api import expect

from browsing import drawn, eventually
from examples import in_soak
from fleet_bench import FleetThread
from page_eyes import free_place, sees, texts, violations, watch
from served_ground import served

pytest.importorskip("aiohttp", reason="the extra [ground]")


SIZES = ((320, 640), (768, 1024), (1280, 800))
LARGE = (3840, 2160)

THEMES = ("dark", "light", "sunlight")
COLOURS = ["color-contrast"]  # axe's rules

VIEWS = ("payload/1-191", "", "map", "flights")

OVERLAPS = """() => {
  const shown = (element) => element.getClientRects().length && getComputedStyle(element).visibility !== "hidden";
  const boxes = [...document.querySelectorAll(
    ".card, .hero, h1, .topbar :is(.brand, nav, .theme, .control, .stop-button, .square)"
  )].filter(shown).map((element) => ({ element, box: element.getBoundingClientRect() }));
  const pinned = (element) => Boolean(element.closest(".topbar"));
  const found = [];
  for (const [index, one] of boxes.entries()) for (const other of boxes.slice(index + 1)) {
    if (one.element.contains(other.element) || pinned(one.element) !== pinned(other.element)) continue;
    const across = Math.min(one.box.right, other.box.right) - Math.max(one.box.left, other.box.left);
    const down = Math.min(one.box.bottom, other.box.bottom) - Math.max(one.box.top, other.box.top);
    if (across > 1 && down > 1) found.push(`${one.element.className} on ${other.element.className}`);
  }
  return found;
}"""

STOP_IN_SIGHT = """() => {
  const box = document.querySelector(".stop-button").getBoundingClientRect();
  const on = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
  return box.top >= 0 && box.right <= innerWidth && Math.min(box.width, box.height) >= 44
    && Boolean(on?.closest(".stop-button"));
}"""

STATES = """() => {
  globalThis.rossStates = [];
  const look = () => {
    const latest = document.querySelector(".order");
    const [words, bars] = [".what", "progress"].map((each) => [...(latest?.querySelectorAll(each) ?? [])]);
    globalThis.rossStates.push(`${words[0]?.textContent} ${latest?.dataset.state} ${bars.length}`);
  };
  new MutationObserver(look).observe(document.body, { attributes: true, childList: true, subtree: true });
}"""


@pytest.fixture(scope="module")
def crew(browser, tmp_path_factory):
    """Three payloads that are well, for tests that change nothing for the next one but orders."""
    flights = tmp_path_factory.mktemp("flights")
    with served("--flights", flights) as ground, FleetThread(ground.port, payloads=3, sources=4):
        yield ground


@pytest.fixture(scope="module")
def kept(crew, keep_page):
    return keep_page(crew.url)


def at(page, who="1-191"):
    """Show a payload."""
    go(page, f"payload/{who}")
    page.get_by_role("heading", name=f"Payload {who}").wait_for()
    page.locator("table.sources").wait_for()
    return page


def command(page, who="1-191"):
    """Show a payload and have control: it may wait a while for another browser's."""
    at(page, who)
    take_control(page)
    return page


def take_control(page):
    held, free = (page.get_by_role("button", name=f"{what} control") for what in ("Release", "Take"))
    held.or_(free).wait_for()
    if not held.count():
        free.click()
    held.wait_for()


def go(page, view):
    """Show another view."""
    page.evaluate("view => { location.hash = `#/${view}`; }", view)
    page.locator(f".view-{view.split('/')[0] or 'fleet'}").wait_for()


def rearm(page):
    page.get_by_role("button", name="Rearm").click()
    eventually(page, lambda: page.locator(".payload-title .state").inner_text() != "Stopped")


def show_more(page):
    """Show what a source and a parameter have to say."""
    page.locator("table.sources button").first.click()
    page.locator(".parameters summary").click()
    page.get_by_label("Filter").fill("EXP_UNIT")
    eventually(page, lambda: page.locator(".parameters tbody tr").count() == 1)


FEW = {"payload/1-191": THEMES}  # what has most colours; elsewhere they are some of the same


@pytest.mark.parametrize("themes", [FEW, *in_soak(dict.fromkeys((*VIEWS, "help"), THEMES))], ids=["few", "all"])
def test_axe_finds_nothing_wrong(crew, open_page, themes):
    page = watch(open_page, crew.url)
    page.emulate_media(reduced_motion="reduce")  # colours change at once
    show_more(page)
    for view in (*VIEWS, "help"):
        if view == "help":
            page.get_by_role("button", name="Help").click()
        else:
            go(page, view)
        for theme in themes.get(view, THEMES[:1]):  # a theme changes colours alone
            page.get_by_label("Theme").select_option(theme)
            drawn(page)
            assert violations(page, None if theme == THEMES[0] else COLOURS) == [], (view, theme)


@pytest.mark.parametrize("sizes", [SIZES, *in_soak((LARGE,))], ids=["usual", "large"])
def test_nothing_overlaps_or_leaves_the_screen(crew, open_page, sizes):
    page = watch(open_page, crew.url)
    show_more(page)
    for view in VIEWS:
        go(page, view)
        for width, height in sizes:
            page.set_viewport_size({"width": width, "height": height})
            drawn(page)
            at = f"{view} at {width} x {height}"
            assert page.evaluate("document.documentElement.scrollWidth") <= width, at
            assert page.evaluate(OVERLAPS) == [], at
            assert page.evaluate(STOP_IN_SIGHT), at
            page.evaluate("scrollTo(0, document.body.scrollHeight)")
            assert page.evaluate(STOP_IN_SIGHT), f"{at}, scrolled down"
            page.evaluate("scrollTo(0, 0)")


def test_every_payload_is_listed_with_a_way_to_it(kept, window):
    page = kept
    go(page, "")
    page.get_by_role("link", name="Payload 2-191").click()
    page.get_by_role("heading", name="Payload 2-191").wait_for()
    page.locator("table.sources").wait_for()
    expect(page.locator("h1")).to_be_focused()


def test_escape_twice_stops_also_from_a_field(kept, window):
    page = command(kept)
    page.get_by_label("Axis heading").focus()
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    eventually(page, lambda: texts(page, ".payload-title .state") == ["Stopped"])
    eventually(page, lambda: texts(page, ".stop-fate") == ["Stopped"])
    rearm(page)


def test_one_escape_stops_nothing(crew, open_page):
    page = watch(open_page, crew.url)
    page.keyboard.press("Escape")
    page.wait_for_timeout(1200)  # more than the second within which a second one stops
    page.keyboard.press("Escape")
    drawn(page)  # a stop is told at once
    assert not page.locator(".stop-fate").count()


@pytest.mark.parametrize("what", [".ends circle", ".handle .knob"])
def test_escape_gives_up_a_drag_for_good(kept, crew, window, what):
    page = command(kept)
    with crew.frozen():  # both walk: an end of the axis goes on, and sources cross it
        drawn(page)
        x, y = free_place(page, what)
        page.mouse.move(x, y)
        page.mouse.down()
    page.mouse.move(x + 60, y + 60, steps=4)
    sees(page, "turn to", ".corners")
    given = page.locator(".order").count()
    page.keyboard.press("Escape")
    page.mouse.move(x + 80, y + 60, steps=4)
    drawn(page)
    assert not page.locator(".ghost.drag").count()
    page.mouse.up()
    page.wait_for_timeout(500)
    assert page.locator(".order").count() == given
    page.wait_for_timeout(600)  # or the next test's Escape would be the second one of a stop


def test_stop_needs_no_control_and_no_second_click(kept, crew, open_page):
    holder, other = watch(open_page, crew.url), at(kept)
    holder.get_by_role("button", name="Take control").click()
    sees(holder, "You have control", ".control")
    explore = other.get_by_role("button", name="Explore", exact=True)
    expect(explore).to_be_disabled()
    expect(other.locator(".control")).not_to_contain_text("You")
    expect(other.locator(".tied")).to_contain_text("has control. Take control")
    other.get_by_role("button", name="Stop 1-191").click()
    eventually(other, lambda: texts(other, ".payload-title .state") == ["Stopped"])
    other.get_by_role("button", name="Take control").click()
    eventually(other, explore.is_enabled)
    eventually(holder, holder.get_by_role("button", name="Explore", exact=True).is_disabled)
    rearm(other)
    other.get_by_role("button", name="Release control").click()
    other.get_by_role("button", name="Take control").wait_for()  # else the next test takes it for held yet


def test_away_from_a_payload_stop_is_for_all(kept, window):
    page = kept
    go(page, "")
    take_control(page)
    page.get_by_role("button", name="Stop all 3 payloads").click()
    eventually(
        page, lambda: [each.split("\n")[0] for each in texts(page, ".fleet .state")] == ["Stopped Health: Good"] * 3
    )
    eventually(page, lambda: texts(page, ".stop-fate") == ["Stopped"])
    for who in ("1-191", "2-191", "3-191"):
        page.evaluate("who => { location.hash = `#/payload/${who}`; }", who)
        page.get_by_role("heading", name=f"Payload {who}").wait_for()
        rearm(page)


def test_what_was_on_its_way_of_another_payload_is_not_shown_as_that_of_the_chosen_one(kept, window):
    """Else its state would stand below the other's name, and a command would go to it."""
    shown = kept.evaluate("""async () => {
      const { blank, take, watching } = await import("/assets/connection.js");
      const late = { type: "payload", id: "1-191", now: 1, sections: { standing: { state: "stopped" } } };
      const before = take(blank("1-191"), late, 0);
      const after = take(watching(before, "2-191"), late, 1);
      return [before, after, take(after, { ...late, id: "2-191" }, 2)].map((store) => store.payload?.id ?? null);
    }""")
    assert shown == ["1-191", None, "2-191"]


def test_an_order_is_followed_to_its_end(kept, window):
    page = command(kept, "2-191")
    page.evaluate(STATES)
    page.get_by_role("button", name="Explore", exact=True).click()
    latest = page.locator(".order").first
    eventually(page, lambda: "explore done 0" in page.evaluate("rossStates"))
    assert "explore in_progress 1" in page.evaluate("rossStates")
    expect(latest.locator("progress")).to_have_count(0)


def test_a_refusal_says_why_in_the_payloads_words(kept, window):
    page = command(kept, "3-191")
    page.locator("table.sources").get_by_role("button", name="Source 3").click()
    page.get_by_role("button", name="Listen to source 3").first.click()  # its commands know of three: 0, 1 and 2
    latest = page.locator(".order").first
    eventually(page, lambda: latest.get_attribute("data-state") == "refused")
    expect(latest.locator(".fate")).to_contain_text("source: expected 0 to 2")


def test_a_heading_that_is_none_is_not_sent(kept, window):
    page = command(kept, "3-191")
    sent = page.locator(".order").count()
    page.get_by_label("Axis heading").fill("4000")
    page.get_by_role("button", name="Turn to").click()
    assert page.evaluate("document.querySelector('#turn').validity.rangeOverflow")
    page.get_by_label("Axis heading").fill("30")
    page.get_by_role("button", name="Turn to").click()
    expect(page.locator(".order")).to_have_count(sent + 1)
    expect(page.locator(".order .what").first).to_contain_text("30")


def test_a_source_of_the_table_can_be_listened_to(kept, window):
    page = command(kept, "2-191")
    page.locator("table.sources").get_by_role("button", name="Source 1").click()
    page.get_by_role("button", name="Listen to source 1").first.click()
    eventually(page, lambda: "source 1" in page.locator(".order .what").first.inner_text())


def test_a_parameter_is_checked_here_and_set_there(kept, window):
    page = command(kept)
    page.locator(".parameters summary").click()
    row = page.locator("tr", has=page.get_by_label("EXP_UNIT", exact=True))
    field = page.get_by_label("EXP_UNIT", exact=True)
    expect(row).to_contain_text("0.5 to 60")
    field.fill("900")
    expect(row).to_contain_text("expected at most 60, got 900")
    expect(row.get_by_role("button", name="Set")).to_be_disabled()
    field.fill("4.5")
    field.press("Enter")
    expect(row).to_have_attribute("data-state", "set")
    expect(field).to_have_value("4.5")
    page.get_by_label("Filter").fill("lead_in")
    eventually(page, lambda: page.locator(".parameters tbody tr").count() == 1)


def test_a_mission_is_ordered_with_the_keyboard_alone(crew, open_page):
    page = open_page(crew.url)
    page.get_by_role("link", name="Payload 1-191").wait_for()
    tab_to(page, "Payload 1-191")
    page.keyboard.press("Enter")
    page.locator("table.sources").wait_for()
    tab_to(page, "Take control")
    page.keyboard.press("Enter")
    tab_to(page, "Explore")
    page.keyboard.press("Enter")
    eventually(page, lambda: "explore" in page.locator(".order .what").first.inner_text())
    tab_to(page, "Source 0")
    page.keyboard.press("Space")
    tab_to(page, "Listen to source 0")
    page.keyboard.press("Enter")
    eventually(page, lambda: "source 0" in page.locator(".order .what").first.inner_text())
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    eventually(page, lambda: texts(page, ".payload-title .state") == ["Stopped"])
    rearm(page)


def tab_to(page, name):
    """Press Tab until something of this name has the focus."""
    for _ in range(80):
        page.keyboard.press("Tab")
        if name == page.evaluate("document.activeElement.innerText?.trim().split('\\n')[0]"):
            return
    raise AssertionError(f"no way to {name} by Tab")


def test_what_is_drawn_can_be_measured(kept, window):
    page = at(kept)
    eventually(page, lambda: page.evaluate("(globalThis.rossLatency ?? []).length") >= 5)
    assert all(each["drawn"] >= each["heard"] - 1 for each in page.evaluate("rossLatency"))


def test_two_placed_payloads_cross_their_bearings(kept, window):
    page = kept
    go(page, "map")
    for who, north in (("1-191", "47.0"), ("2-191", "47.001")):
        page.get_by_label("Payload", exact=True).select_option(who)
        page.get_by_label("Latitude").fill(north)
        page.get_by_label("Longitude").fill("8.0")
        page.get_by_role("button", name="Set position").click()
        page.locator(".places li", has_text=who).wait_for()
    eventually(page, lambda: page.locator(".map .crossing").count() > 0 and page.locator(".map .ray").count() >= 8)
    assert page.locator(".map .scale text").text_content().endswith(" m")
    before = page.locator(".map .stand").first.get_attribute("transform")
    page.locator(".map").focus()
    page.keyboard.press("ArrowLeft")
    eventually(page, lambda: page.locator(".map .stand").first.get_attribute("transform") != before)
