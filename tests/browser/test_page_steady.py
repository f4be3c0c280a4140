"""What can be pressed stays where it is: a page that jumps under a finger turns an array that nobody meant to turn."""

import pytest

from examples import rows_in_soak
from made_telemetry import MadeTelemetry
from page_eyes import sees
from ross_protocols.mavlink.dialect import ross

PLACES = """(rows) => {
  const what = [".pinned :is(a, button, select)", ".scope > svg", ".commands :is(button, input)", ".choice", rows];
  return Object.fromEntries(what.flatMap((selector) => [...document.querySelectorAll(selector)].map((each, index) => {
    const { left, top } = each.getBoundingClientRect();
    const scrolled = each.closest(".pinned") ? 0 : scrollY;
    return [`${selector} ${index}`, [left, top + scrolled]];
  })));
}"""
ROWS = ".sources tbody button"
BELOW = """() => {
  const { activeElement: focused } = document;
  const { bottom } = focused.getBoundingClientRect();
  const covered = bottom > document.querySelector(".banners").getBoundingClientRect().top;
  return covered && focused.closest("main") ? focused.outerHTML : null;
}"""
PRESS = """(names) => {
  const press = () => {
    if (!document.querySelector(".remarks")) return;
    watch.disconnect();
    const buttons = [...document.querySelectorAll(".commands button, .stop-button")];
    names.forEach((name) => buttons.find((each) => each.textContent.includes(name)).click());
  };
  const watch = new MutationObserver(press);
  watch.observe(document.body, { childList: true, subtree: true });
  press();
}"""
SCROLLED = """async (by) => {
  const { isHasty, watchingMoves } = await import("/assets/steadiness.js");
  watchingMoves(() => {});
  scrollBy(0, by);
  return [scrollY, isHasty({ kind: "turn" })];
}"""
TOP = "() => document.querySelector('.commands').getBoundingClientRect().top"
ROOM = """() => {
  const [bar, notices] = [".pinned", ".banners"].map((each) => document.querySelector(each).getBoundingClientRect());
  return notices.top - bar.bottom;
}"""
HOURS = 23 * 3600 + 59 * 60
LONG = "both channels carry the same microphone: check the channel map; samples were lost: the USB port is overloaded"


def states():
    """Every state of a mission, and one that is not known."""
    entries = [entry for entry in ross.enums["ROSS_STATE"].values() if not entry.name.endswith("ENUM_END")]
    for entry in entries:
        name = entry.name.removeprefix("ROSS_STATE_").lower()
        yield f"state {name}", {"sections": {"standing": {"state": name, "state_meaning": entry.description}}}
    yield "no state", {"sections": {"standing": {"state": None, "state_meaning": ""}}}


def times():
    for age in (0.1, 5, 59, 65, 4000, 40_000):
        yield f"telemetry of {age} s ago", {"age": age}
    for time in (None, 0.5, 75, HOURS):
        yield f"a mission of {time} s", {"sections": {"mission": {"time": time, "elapsed": time}}}
    for expected in (None, 30, 3754):
        yield f"{expected} s expected", {"sections": {"mission": {"elapsed": 3754, "expected": expected}}}


def results():
    """What a mission finds."""
    for facts in (
        {"target": None, "target_found": False},
        {"target": 1, "target_found": False},
        {"target": 1, "target_found": True},
        {"k": None, "score": None, "criterion": None, "si_sdr": None, "si_sdri": None, "gain": None},
        {
            "k": 12,
            "certain": False,
            "score": -12.34,
            "criterion": -1.5,
            "si_sdr": -11.5,
            "si_sdri": -12.5,
            "gain": 12.5,
        },
        {"rotation": 12, "rotation_max": 12},
        {"rotation": None, "rotation_max": None},
    ):
        yield str(facts), {"sections": {"mission": facts}}
    for facts in ({"goal": 300, "settled": False}, {"goal": None, "settled": False}, {"earth": False}):
        yield str(facts), {"sections": {"pointing": facts}}


def sources(found):
    """From none to six sources; what is told of one."""
    for count in range(7):
        several = [{**found[0], "source": index, "azimuth": 10 + 50 * index} for index in range(count)]
        yield f"{count} sources", {"sections": {"sources": several, "mission": {"k": count}}}
    for facts in (
        {"resolved": False, "mirror": 123.0},
        {"resolved": True},
        {"sigma": 123.4, "score": -1.23},
        {"sigma": None, "confidence": None},
    ):
        yield str(facts), {"sections": {"sources": [{**each, **facts} for each in found]}}


def happenings(now):
    """What comes by itself, or by others."""
    order = {"words": "explore", "state": "done", "reason": "", "progress": None, "since": now - 30, "at": now - 30}
    for count in (0, 1, 8):
        yield f"{count} orders", {"sections": {"orders": [{**order, "number": index} for index in range(count)]}}
    running = {**order, "number": 1, "state": "in_progress", "progress": 0.5}
    yield "an order in progress", {"sections": {"orders": [running]}}
    refused = {**order, "number": 1, "state": "refused", "reason": "this mission runs by itself", "at": now}
    yield "a refused order", {"sections": {"orders": [refused]}}
    event = {"severity": 4, "text": "RoSS: something has happened that takes many words, more than one line has"}
    yield "events", {"sections": {"events": [{**event, "at": now - each} for each in range(50, 0, -1)]}}
    yield "bad health", {"sections": {"health": {"microphones": {"level": "act", "words": LONG}}}}
    yield "advice", {"fleet": {"advice": "The log is not written any longer: the disk is full."}}
    for name, yours in (("chrome at 127.0.0.1", False), ("firefox at 192.168.178.123", False), ("this one", True)):
        yield f"control of {name}", {"control": {"holder": "x", "name": name, "yours": yours}}
    yield "a refusal", {"refused": {"what": "explore", "reason": "chrome at 127.0.0.1 has control: take it first"}}


@pytest.mark.parametrize(
    ("width", "height", "letters"),
    [
        (390, 844, 100),
        *rows_in_soak((320, 640, 100), (768, 1024, 100), (1024, 768, 100), (1280, 800, 100), (1920, 1080, 100)),
        *rows_in_soak((390, 844, 200), (320, 640, 200)),
    ],
)
def test_nothing_that_is_told_moves_what_can_be_pressed(crew, window, width, height, letters):
    told = MadeTelemetry(window, crew.url, width, height)
    told.page.evaluate("size => { document.documentElement.style.fontSize = size; }", f"{letters}%")
    told.tell()
    rows = ROWS if letters == 100 else "none"  # a row of large letters has as many lines as it needs: it selects alone
    before = told.page.evaluate(PLACES, rows)
    assert len(before) > 20
    known = [*states(), *times(), *results(), *sources(told.sections["sources"]), *happenings(told.now)]
    moved = {}
    for name, what in known:
        told.tell(**what)
        now = told.page.evaluate(PLACES, rows)
        away = [each for each in now if each in before and now[each] != pytest.approx(before[each], abs=1.0)]
        moved |= {name: away} if away else {}
    assert moved == {}


def test_what_gets_the_focus_does_not_lie_below_a_notice(crew, window):
    told = MadeTelemetry(window, crew.url, 390, 844)
    told.tell(age=65)
    below = []
    for _ in range(28):  # to the commands, and past them
        told.page.keyboard.press("Tab")
        below.append(told.page.evaluate(BELOW))
    assert set(below) == {None}


@pytest.mark.parametrize(("width", "height", "letters"), [(360, 740, 200), (320, 640, 200), (390, 400, 100)])
def test_notices_leave_room_for_the_page_between_them_and_the_bar(crew, window, width, height, letters):
    """Else nothing can be pressed but the stop for as long as telemetry stays away."""
    told = MadeTelemetry(window, crew.url, width, height)
    told.page.evaluate("size => { document.documentElement.style.fontSize = size; }", f"{letters}%")
    told.tell(
        {"health": {"microphones": {"level": "act", "words": LONG}}}, age=65, refused={"what": "x", "reason": LONG}
    )
    told.page.evaluate("() => document.querySelector('.commands').scrollIntoView()")
    assert told.page.evaluate(ROOM) > 100


def test_a_press_right_after_the_page_has_jumped_turns_nothing(crew, window):
    """It was meant for what stood there before. A remark has no room until it comes."""
    told = MadeTelemetry(window, crew.url, 390, 844)
    told.tell()
    told.page.evaluate(PRESS, ["Park", "Cancel", "STOP"])  # as soon as it comes
    told.tell({"standing": {"boots": 2}})
    assert [told.sent(kind) for kind in ("park", "cancel", "stop")] == [0, 1, 1]
    sees(told.page, "Not sent: park. The page had just moved", "#refusal")
    told.page.wait_for_timeout(600)
    told.page.evaluate(PRESS, ["Park"])
    assert told.sent("park") == 1


def test_a_press_is_meant_where_the_browser_has_held_the_page_still(crew, window):
    """It scrolls along with what grows above the window: nothing has moved under the finger."""
    told = MadeTelemetry(window, crew.url, 390, 844)
    told.tell()
    told.page.evaluate("() => document.querySelector('.commands').scrollIntoView()")
    told.page.wait_for_timeout(600)
    before = told.page.evaluate(TOP)
    told.tell({"standing": {"boots": 2}})
    assert told.page.evaluate(TOP) == pytest.approx(before, abs=1.0)
    told.page.evaluate(PRESS, ["Park"])
    assert told.sent("park") == 1


def test_a_press_is_meant_after_the_user_has_scrolled_while_the_page_was_drawn(crew, window):
    """On a slow computer a drawing takes long: what is scrolled meanwhile has not moved by itself."""
    told = MadeTelemetry(window, crew.url, 390, 844)
    told.tell()
    told.page.wait_for_timeout(600)
    assert told.page.evaluate(SCROLLED, 700) == [700, False]


def test_a_press_right_after_a_page_that_was_at_its_end_has_become_shorter_turns_nothing(crew, window):
    """Then the browser scrolls back, by the height of the notices that have gone."""
    told = MadeTelemetry(window, crew.url, 1280, 800)
    told.tell()
    height = told.page.evaluate("() => document.documentElement.scrollHeight")
    told.page.set_viewport_size({"width": 1280, "height": height - 30})
    told.tell({"standing": {"boots": 2}}, age=65)
    told.page.evaluate("() => scrollTo(0, document.documentElement.scrollHeight)")
    told.page.wait_for_timeout(600)
    before = told.page.evaluate(TOP)
    told.tell({"standing": {"boots": 2}})
    assert told.page.evaluate(TOP) > before + 20
    told.page.evaluate(PRESS, ["Park"])
    assert told.sent("park") == 0
