"""The instruments of the page, in a real browser: where things lie, and what a hand does."""

import math
import re

import pytest

from browsing import drawn
from scenes import UNIT, pointing, scene, scenes, source, three

RIM = 150  # of the polar view, in its own units


def middle(page, selector):
    """Middle of a shape in the units of the polar view, y downward."""
    return page.evaluate(
        """selector => {
          const box = document.querySelector(selector).getBoundingClientRect();
          const screen = document.querySelector('.scope > svg').getScreenCTM().inverse();
          const {x, y} = new DOMPoint(box.x + box.width / 2, box.y + box.height / 2).matrixTransform(screen);
          return [x, y];
        }""",
        selector,
    )


def compass(angle, radius):
    return [radius * math.sin(math.radians(angle)), -radius * math.cos(math.radians(angle))]


def on_screen(page, angle, radius):
    """Where a place of the polar view is on the screen."""
    return page.evaluate(
        """([x, y]) => {
          const screen = document.querySelector('.scope > svg').getScreenCTM();
          const {x: left, y: top} = new DOMPoint(x, y).matrixTransform(screen);
          return [left, top];
        }""",
        compass(angle, radius),
    )  # fmt: skip


def numbers(path):
    return [float(each) for each in re.findall(r"-?\d+(?:\.\d+)?", path)]


# Where things lie


@pytest.mark.parametrize(("azimuth", "place"), [(0, (0, -RIM)), (90, (RIM, 0)), (180, (0, RIM)), (270, (-RIM, 0))])
def test_a_source_stands_where_the_compass_says(board, azimuth, place):
    page = board(scene([source(0, azimuth)]))
    assert middle(page, ".source .mark") == pytest.approx(place, abs=1.5)


def test_a_wedge_is_one_standard_deviation_to_each_side(board):
    page = board(scene([source(0, 90, sigma=20, confidence=1.0)]))
    corners = numbers(page.get_attribute(".source .wedge", "d"))
    assert corners[2:4] == pytest.approx(compass(70, RIM), abs=0.1)
    assert corners[-2:] == pytest.approx(compass(110, RIM), abs=0.1)


def test_a_source_of_unknown_width_is_a_line_without_a_wedge(board):
    page = board(scenes()["mirrors only"])
    assert page.locator(".source .wedge").count() == 0
    assert middle(page, "[data-source='1'] .mark") == pytest.approx(compass(130, RIM), abs=1.5)


def test_a_certain_source_reaches_further_than_a_doubtful_one(board):
    page = board(scene([source(0, 40, confidence=1.0), source(1, 90, confidence=0.2)]))
    paths = [numbers(each.get_attribute("d")) for each in page.query_selector_all(".source .wedge")]
    reach = [math.hypot(path[2], path[3]) for path in paths]
    assert reach[0] == pytest.approx(RIM, abs=0.1)
    assert reach[1] < 0.7 * reach[0]


def test_a_source_of_unknown_front_shows_its_mirror(board):
    page = board(scene([source(0, 70, resolved=False, mirror=350.0)]))
    assert middle(page, "circle.mirrored") == pytest.approx(compass(350, RIM), abs=1)
    assert page.locator(".label").all_text_contents()[0].split() == ["0?", "70°"]
    assert page.locator(".label.mirror").text_content().split() == ["0?", "350°"]
    assert "front or back unknown" in page.locator(".corners").text_content()


def test_the_axis_goes_both_ways_and_microphone_2_is_where_it_points(board):
    page = board(scene([], heading=90.0))
    assert numbers(page.get_attribute(".axis", "d")) == pytest.approx([RIM, 0, -RIM, 0], abs=0.1)
    second = page.locator(".microphone").nth(1)
    assert second.text_content().strip() == "2"
    assert numbers(second.get_attribute("transform"))[0] > 0
    assert "axis 90° / 270°" in page.locator(".corners").text_content()


def test_north_is_up_or_the_zero_of_the_mount_and_it_says_which(board):
    page = board(three())
    assert "north up" in page.locator(".corners").text_content()
    assert page.locator(".degree").first.text_content() == "N"
    page.evaluate("state => show(state)", {"sections": scenes()["mount"]})
    assert "nose up" in page.locator(".corners").text_content()
    assert page.locator(".degree").first.text_content() == "0"


def test_interferers_that_pose_as_one_meet_at_the_same_foot_of_the_axis(board):
    page = board(three())
    feet = [numbers(each.get_attribute("d"))[2:] for each in page.query_selector_all(".plumb.alike")]
    expected = compass(45, RIM * math.cos(math.radians(35)))
    assert feet == [pytest.approx(expected, abs=0.1), pytest.approx(expected, abs=0.1)]
    assert "0 and 2 have the same delay at 45°" in page.locator(".corners").text_content()


def test_a_plumb_line_meets_the_axis_at_a_right_angle(board):
    page = board(scene([source(3, 100)], heading=30.0), selected=3)
    x1, y1, x2, y2 = numbers(page.get_attribute(".plumb.now", "d"))
    axis = compass(30, 1)
    assert (x2 - x1) * axis[0] + (y2 - y1) * axis[1] == pytest.approx(0, abs=0.1)
    assert f"ITD {UNIT * math.cos(math.radians(70)):.0f} µs" in page.locator(".corners").text_content()


@pytest.mark.parametrize(("limits", "never"), [((315.0, 95.0), 2), ((250.0, 170.0), 0)])
def test_only_what_neither_heading_reaches_is_closed_to_the_axis(board, limits, never):
    page = board({**three(), "pointing": pointing(45.0, limits=list(limits))})
    assert page.locator(".limits .beyond").count() == 1
    assert page.locator(".limits .never").count() == never


def test_a_path_of_densities_runs_through_their_ridges(board):
    page = board(scene([source(0, 40)]))
    marks = page.locator(".ridges .path .at")
    shares = [float(marks.nth(index).get_attribute("x").rstrip("%")) for index in range(marks.count())]
    expected = [50 + 50 * math.cos(math.radians(40 - 22.5 * row)) for row in range(8)]
    assert shares == pytest.approx(expected, abs=0.1)


def test_an_isolation_is_read_where_the_axis_points(board):
    page = board(three(), cursor=45)
    apart = UNIT * (math.cos(math.radians(35)) - math.cos(math.radians(185)))
    assert page.locator(".isolation .readout").text_content().startswith(f"45° / 225°: source 1 {apart:.0f} µs")


# What cannot be known or shown


def test_every_scene_is_drawn_without_a_broken_number(board):
    page = board({})
    for name, sections in scenes().items():
        page.evaluate("state => show(state)", {"sections": sections})
        assert page.locator("svg").count() > 0
        assert not re.search(r"NaN|undefined|Infinity|null", page.locator("main").inner_html()), name


def test_what_is_not_known_is_a_dash_that_says_so(board):
    page = board({})
    assert page.locator(".levels .value span[title='unknown']").count() == 2
    assert page.locator(".corners tspan title").text_content() == "unknown"
    assert page.locator(".instrument.empty").count() == 3


def test_old_sources_fade_and_their_age_is_told(board):
    page = board(scenes()["stale"])
    assert page.locator(".scene.old").count() == 1
    assert "no telemetry for 12 s" in page.locator(".corners").text_content()


# Hands


def test_a_click_selects_a_source(board):
    page = board(three())
    page.mouse.click(*on_screen(page, 80, RIM))
    assert page.evaluate("told.selected") == [2]
    assert page.get_attribute("[data-source='2'][role=button]", "aria-pressed") == "true"


def test_a_target_right_on_the_axis_can_still_be_clicked(board):
    page = board(scene([source(0, 30, target=True)], heading=30.0))
    page.mouse.click(*on_screen(page, 30, RIM))
    assert page.evaluate("told.selected") == [0]


def test_sources_are_reached_and_selected_by_keyboard(board):
    page = board(three())
    page.focus(".source")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    assert page.evaluate("told.selected") == [1]
    assert page.locator(".source[tabindex='0']").count() == 1


@pytest.mark.parametrize("place", [96, RIM - 6])  # the circle on the axis, and its end
@pytest.mark.parametrize(("end", "goal"), [(45, 100), (225, 280), (45, 5)])
def test_dragging_either_end_of_the_axis_orders_the_heading_of_microphone_2(board, end, goal, place):
    page = board(scene([source(0, 120)], heading=45.0))
    page.mouse.move(*on_screen(page, end, place))
    page.mouse.down()
    page.mouse.move(*on_screen(page, goal, 130), steps=4)
    page.mouse.up()
    assert page.evaluate("told.turned") == [goal - (end - 45)]


def test_a_finger_drags_the_axis_and_the_page_stays(board):
    page = board(three(), width=360)
    fingers = page.context.new_cdp_session(page)
    fingers.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    path = [on_screen(page, angle, 96) for angle in (45, 60, 90, 120, 135)]
    for kind, (x, y) in [("touchStart", path[0]), *(("touchMove", place) for place in path)]:
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    fingers.detach()
    assert page.evaluate("[told.turned, told.chosen, scrollY]") == [[], [135], 0]  # chosen, to be confirmed


def swipe(page, path, rest_ms=0):
    """Let a finger go from place to place in steps, as a hand does."""
    fingers = page.context.new_cdp_session(page)
    fingers.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    drawn(page)  # a page that does not answer at once scrolls
    for index, (x, y) in enumerate(path):
        kind = "touchMove" if index else "touchStart"
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
        page.wait_for_timeout(16 if index else rest_ms)
    page.wait_for_timeout(200)  # else the page would scroll on by itself
    fingers.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [{"x": x, "y": y}]})
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    fingers.detach()


@pytest.mark.parametrize("place", [96, RIM])  # the circle on the axis, and its end
@pytest.mark.parametrize("heading", [0, 20, 90])
def test_a_swipe_that_begins_on_the_axis_scrolls_the_page(board, heading, place):
    page = board(scene([source(0, 140)], heading=float(heading)), width=360)
    page.evaluate("scrollTo(0, 0)")
    x, y = on_screen(page, heading, place)
    path = [(x + step / 10, y - step) for step in range(0, 81, 8)]
    if y < 100:
        path = [(x - 2, y + 20 - step) for step in range(0, 81, 8)]
    swipe(page, path)
    page.wait_for_function("scrollY > 20")
    assert page.evaluate("[told.turned, told.chosen]") == [[], []]
    assert page.locator(".ghost.drag").count() == 0
    page.evaluate("scrollTo(0, 0)")


def test_a_finger_that_rests_first_drags_up_and_down(board):
    page = board(scene([source(0, 140)], heading=90.0), width=360)
    page.evaluate("scrollTo(0, 0)")
    swipe(page, [on_screen(page, angle, 96) for angle in range(90, 131, 4)], rest_ms=400)
    assert page.evaluate("[told.turned, told.chosen, scrollY]") == [[], [130], 0]


JUMP = "down => { document.body.style.paddingTop = `${down}px`; }"


def test_a_chosen_heading_stays_when_the_page_jumps_under_a_finger(board):
    page = board(three(), width=360)
    page.evaluate("scrollTo(0, 0)")  # where no browser keeps in place what is seen
    path = [on_screen(page, angle, 96) for angle in (45, 60, 90, 120, 135)]
    fingers = page.context.new_cdp_session(page)
    fingers.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    for kind, (x, y) in [("touchStart", path[0]), *(("touchMove", place) for place in path)]:
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
    page.evaluate(JUMP, 60)
    drawn(page)
    for step in (1, 0):  # a finger is never still
        place = {"x": path[-1][0] + step, "y": path[-1][1]}
        fingers.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [place]})
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    fingers.detach()
    page.evaluate(JUMP, 0)
    assert page.evaluate("told.chosen") == [135]


def test_a_drag_goes_along_with_a_page_that_is_scrolled(board):
    page = board(scene([source(0, 120)], heading=45.0), width=360)
    page.evaluate("scrollTo(0, 0)")
    page.mouse.move(*on_screen(page, 45, 96))
    page.mouse.down()
    page.mouse.move(*on_screen(page, 90, 96), steps=4)
    page.evaluate("scrollTo(0, 40)")
    drawn(page)
    page.mouse.move(*on_screen(page, 100, 96), steps=4)
    page.mouse.up()
    page.evaluate("scrollTo(0, 0)")
    assert page.evaluate("told.turned") == [100]


@pytest.mark.parametrize("where", [(45, 96), (52, 96), (52, RIM), (219, 90)])
def test_a_click_on_the_handle_orders_nothing(board, where):
    """Also on its edge, which is seen at another angle than its middle."""
    page = board(three())
    page.mouse.click(*on_screen(page, *where))
    assert page.evaluate("[told.turned, told.chosen]") == [[], []]
    assert page.locator(".ghost.drag").count() == 0


def test_a_tap_on_the_handle_chooses_nothing(board):
    page = board(three(), width=360)
    swipe(page, [on_screen(page, 52, 96)])
    assert page.evaluate("[told.turned, told.chosen]") == [[], []]


def test_escape_gives_a_drag_up(board):
    page = board(three())
    page.mouse.move(*on_screen(page, 45, 96))
    page.mouse.down()
    page.mouse.move(*on_screen(page, 100, 96), steps=4)
    page.focus("[role=slider]")
    page.keyboard.press("Escape")
    page.mouse.up()
    assert page.evaluate("told.turned") == []
    assert page.locator(".ghost.drag").count() == 0


def test_a_drag_whose_end_was_not_told_is_given_up(board):
    """As when a menu that opens meanwhile takes the release of the button."""
    page = board(three())
    page.mouse.move(*on_screen(page, 45, 96))
    page.mouse.down()
    page.mouse.move(*on_screen(page, 100, 96), steps=4)
    move = "each.dispatchEvent(new PointerEvent('pointermove', { pointerId: +each.dataset.pointer, buttons: 0 }))"
    page.evaluate(f"each => {move}", page.query_selector(".handle"))
    page.mouse.up()
    assert page.evaluate("told.turned") == []
    assert page.locator(".ghost.drag").count() == 0


def test_a_source_at_the_end_of_the_axis_is_still_selected(board):
    page = board(scene([source(0, 45)], heading=45.0))
    page.mouse.click(*on_screen(page, 45, RIM))
    assert page.evaluate("told.selected") == [0]
    assert page.evaluate("told.turned") == []


def test_arrows_turn_the_handle_and_only_enter_orders(board):
    page = board(three())
    page.focus("[role=slider]")
    for key in ("ArrowRight", "ArrowRight", "Shift+ArrowRight", "ArrowLeft"):
        page.keyboard.press(key)
    assert page.evaluate("told.turned") == []
    assert page.get_attribute("[role=slider]", "aria-valuenow") == "56"
    page.keyboard.press("Enter")
    assert page.evaluate("told.turned") == [56]


def test_a_heading_beyond_the_limits_is_told_before_it_is_ordered(board):
    page = board(scenes()["limits"], drag=200)
    assert "out of range: 200°" in page.locator(".corners").text_content()
    assert "out of range" in page.get_attribute("[role=slider]", "aria-valuetext")


def test_who_may_not_order_cannot_drag(board):
    page = board(three(), mayOrder=False)
    page.mouse.move(*on_screen(page, 45, 96))
    page.mouse.down()
    page.mouse.move(*on_screen(page, 100, 96), steps=4)
    page.mouse.up()
    assert page.evaluate("told.turned") == []
    assert page.get_attribute("[role=slider]", "aria-disabled") == "true"
