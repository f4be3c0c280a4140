"""Two flights beside each other: moved together, and how they differ."""

import json
import re

import pytest

from browsing import eventually
from emulated_log import log
from served_ground import served

pytest.importorskip("aiohttp", reason="the extra [ground]")

MINUS, UNKNOWN = "\N{MINUS SIGN}", "\N{EN DASH}"


@pytest.fixture(scope="module")
def ground(browser, tmp_path_factory):
    flights = tmp_path_factory.mktemp("flights")
    log(flights / "long.tlog")
    log(flights / "short.tlog", seconds=14)
    log(flights / "mission.tlog", start=0)
    with served("--flights", flights) as ground:
        yield ground


@pytest.fixture(scope="module")
def both(ground, keep_page):
    """A page that compares two flights."""
    page = keep_page(f"{ground.url}#/flights")
    page.get_by_role("button", name="Open long.tlog").click()
    page.get_by_role("slider", name="Time of long.tlog").fill("9")
    page.get_by_role("button", name="Compare with short.tlog").click()
    page.get_by_role("slider", name="Time of both flights").wait_for()
    return page


def value(page, quantity):
    """What the table says of a quantity: of the first flight, of the second, and their difference."""
    row = page.locator(".differences tbody tr", has=page.get_by_role("rowheader", name=quantity, exact=True))
    return row.locator("td").all_inner_texts()


def moments(page):
    """The date and time of each flight."""
    return page.locator(".slot .playback > .soft").all_inner_texts()


def test_where_the_slider_was_moved_is_shown_until_a_busy_ground_process_answers(ground, open_page):
    page = open_page(f"{ground.url}#/flights")
    page.get_by_role("button", name="Open long.tlog").click()
    page.get_by_role("slider", name="Time of long.tlog").wait_for()
    with ground.frozen():
        page.get_by_role("slider", name="Time of long.tlog").fill("9")
        page.wait_for_timeout(1500)
        assert "13:29" in moments(page)[0]
    page.get_by_role("button", name="Compare with short.tlog").click()
    eventually(page, lambda: len(moments(page)) == 2 and all("13:29" in moment for moment in moments(page)))


def test_two_flights_have_one_slider_and_one_play(both, window):
    page = both
    assert page.locator(".playback .slider input").count() == 1
    assert page.locator("button.play").count() == 1
    eventually(page, lambda: moments(page) == [moments(page)[0]] * 2 and "13:29" in moments(page)[0])  # 9 s, as opened
    page.get_by_role("slider", name="Time of both flights").fill("3")
    eventually(page, lambda: moments(page) == [moments(page)[0]] * 2 and "13:23" in moments(page)[0])
    page.get_by_role("button", name="Play").click()
    eventually(page, lambda: page.locator(".moment").inner_text() >= "0:05")
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    page.get_by_role("slider", name="Time of both flights").press("ArrowRight")
    eventually(page, lambda: moments(page) == [moments(page)[0]] * 2)


def test_the_table_tells_how_they_differ(both, window):
    page = both
    page.get_by_role("slider", name="Time of both flights").fill("19")
    eventually(page, lambda: "ended" in page.locator(".differences thead").inner_text())  # the short one
    eventually(page, lambda: value(page, "Elapsed")[2] not in (UNKNOWN, "0.0 s"))
    one, other, apart = (float(re.sub("[^0-9.-]", "", each.replace(MINUS, "-"))) for each in value(page, "Elapsed"))
    assert apart == pytest.approx(other - one, abs=1.0)  # both are rounded to a second
    assert value(page, "Target azimuth")[2].endswith("°")
    page.set_viewport_size({"width": 320, "height": 640})
    eventually(page, lambda: page.evaluate("innerWidth") == 320)
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    table = page.locator(".comparison .scroll")
    assert table.evaluate("each => each.scrollWidth <= each.clientWidth + 1")


def test_a_flight_that_is_closed_leaves_the_other_its_own_time(both, window):
    page = both
    page.get_by_role("button", name="Close short.tlog").click()
    page.get_by_role("slider", name="Time of long.tlog").wait_for()
    assert not page.locator(".comparison").count()


@pytest.mark.soak
def test_a_simulated_flight_has_no_date(ground, open_page):
    page = open_page(f"{ground.url}#/flights")
    row = page.locator(".known li", has_text="mission.tlog")
    row.wait_for()
    assert "1970" not in page.locator(".known").inner_text()
    assert "Simulated" in row.inner_text()
    page.get_by_role("button", name="Open mission.tlog").click()
    page.locator(".playback").wait_for()
    assert "Simulated" in page.locator(".playback").inner_text()
    assert "0:00 of 0:19" in page.locator(".playback").inner_text()


def test_a_flight_goes_on_as_it_was_played_when_the_ground_process_comes_back(browser, tmp_path, open_page, window):
    window.expected.append("/live")
    log(tmp_path / "one.tlog", seconds=60)
    with served("--flights", tmp_path) as own:
        page = open_page(f"{own.url}#/flights")
        page.get_by_role("button", name="Open one.tlog").click()
        page.get_by_label("Speed").select_option("2")
        page.get_by_role("button", name="Play", exact=True).click()
        page.get_by_role("button", name="Pause").wait_for()
        told = []
        page.on("websocket", lambda live: live.on("framereceived", lambda text: told.append(json.loads(text))))
        own.end()
        own.start()
        flights = lambda: [(each["speed"], each["playing"]) for each in told if each["type"] == "flight"]  # noqa: E731
        eventually(page, lambda: (2, True) in flights(), what=flights)


def test_the_speed_is_shown_that_is_told_whatever_was_chosen(ground, open_page):
    page = open_page(ground.url)
    shown = page.evaluate("""async () => {
      const { speedSwitch } = await import("/assets/parts/playback.js");
      const { render } = await import("/assets/templates.js");
      const box = document.createElement("div");
      const draw = (speed) => render(speedSwitch(speed, () => {}), box);
      draw(1);
      const select = box.querySelector("select");
      for (const index of [2, 0, 1]) select.selectedIndex = index; // as a hand does
      draw(1);
      return select.value;
    }""")
    assert shown == "1"
