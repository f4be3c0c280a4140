"""A heading that a finger chooses in the polar view: the payload turns once that is confirmed, and not without."""

import pytest
from playwright.sync_api import expect

from browsing import drawn
from page_eyes import follow, free_place, seen, sees, violations, watch

PHONE = {"width": 390, "height": 844}
STANDS = """async ([before, now, ago]) => {
  const { chosenHeading, choose } = await import("/assets/parts/chosen-heading.js");
  const told = ({ state, boots, earth, goal, order }) => ({
    id: "1-191", sections: { standing: { state, boots }, pointing: { earth, goal }, orders: [{ number: order }] },
  });
  const page = { ui: {}, store: {}, change: (ui) => { page.ui = ui; } };
  choose(page, told(before), 164);
  page.store.payload = told(now);
  page.ui.chosen.at -= 1000 * ago;
  return chosenHeading(page)?.heading ?? null;
}"""
CONFIRMED = """async ([before, now]) => {
  const { choose, confirmation } = await import("/assets/parts/chosen-heading.js");
  const { render } = await import("/assets/templates.js");
  const given = [];
  const told = (standing) => ({ id: "1-191", sections: { standing } });
  const page = {
    ui: {}, store: { payload: told(before) }, commandsBlocked: null,
    change: (ui) => { page.ui = ui; }, order: (id, order) => given.push(order.kind),
  };
  choose(page, page.store.payload, 164);
  const box = document.createElement("div");
  render(confirmation(page, page.store.payload), box);
  page.store.payload = told(now);
  box.querySelector("button").click();
  return given;
}"""
IDLE = {"state": "idle", "boots": 1, "earth": True, "goal": 40, "order": 3}


@pytest.fixture
def page(crew, open_page):
    page = watch(open_page, crew.url)
    page.set_viewport_size(PHONE)
    page.get_by_role("button", name="Take control").click()
    sees(page, "You have control", ".control")
    return page


def choose(page, crew):
    """Drag an end of the axis sideways with a finger; the button that confirms."""
    fingers = page.context.new_cdp_session(page)
    fingers.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    button = page.get_by_role("group", name="Chosen heading").get_by_role("button", name="Turn to")
    with crew.frozen():  # both walk: an end of the axis goes on, and sources cross it
        drawn(page)
        x, y = free_place(page, ".handle .knob")
        towards = 1 if x < PHONE["width"] / 2 else -1
        for step in range(0, 81, 8):
            place = {"x": x + towards * step, "y": y + step / 8}
            kind = "touchMove" if step else "touchStart"
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [place]})
        fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        button.wait_for()
    fingers.detach()
    return button


def orders(page):
    return page.locator(".order .what").all_text_contents()


def test_a_payload_turns_to_what_a_finger_chose_once_that_is_confirmed(page, crew):
    given = orders(page)
    follow(page, "#announcer")
    button = choose(page, crew)
    words = button.text_content().strip()
    sees(page, words.lower(), ".corners")
    assert any(f"{words}: confirm or cancel" in said for said in seen(page))
    page.wait_for_timeout(500)
    assert orders(page) == given
    button.click()
    heading = words.removeprefix("Turn to ").removesuffix("°")
    sees(page, f"turn to {heading} deg", ".order")
    expect(button).to_have_count(0)
    assert len(orders(page)) == len(given) + 1


def test_the_question_moves_nothing_that_can_be_pressed(page, crew):
    controls = page.locator(".commands")
    before = controls.bounding_box()["y"]
    choose(page, crew)
    assert controls.bounding_box()["y"] == pytest.approx(before, abs=1.0)


def test_axe_finds_nothing_wrong_with_the_question(page, crew):
    """By itself: on a busy computer that may take longer than is waited for a confirmation."""
    choose(page, crew)
    assert violations(page) == []


@pytest.mark.parametrize("how", ["cancel", "escape", "another order", "another payload", "stop"])
def test_a_chosen_heading_is_given_up(page, how, crew, open_page):
    given = orders(page)
    button = choose(page, crew)
    if how == "cancel":
        page.get_by_role("group", name="Chosen heading").get_by_role("button", name="Cancel").click()
    elif how == "escape":
        page.keyboard.press("Escape")
        page.wait_for_timeout(1100)  # else the next one would be the second one of a stop
    elif how == "another order":
        page.get_by_role("button", name="Park", exact=True).click()
    elif how == "another payload":
        page.evaluate("location.hash = '#/payload/7-191'")
    else:
        other = open_page(f"{crew.url}#/payload/1-191")
        other.get_by_role("button", name="Stop 1-191").click()
        sees(page, "Stopped", ".payload-title")
    expect(button).to_have_count(0)
    expect(page.locator(".ghost.drag")).to_have_count(0)
    if how in ("cancel", "escape"):
        assert orders(page) == given
    if how == "stop":
        page.get_by_role("button", name="Rearm", exact=True).click()
        sees(page, "done", ".order")


@pytest.mark.parametrize(
    ("change", "ago", "stands"),
    [
        ({}, 1, True),
        ({}, 11, False),
        ({"goal": 40.4}, 1, True),
        ({"goal": 120}, 1, False),
        ({"goal": None}, 1, False),
        ({"state": "turn"}, 1, True),
        ({"state": "stopped"}, 1, False),
        ({"boots": 2}, 1, False),
        ({"order": 4}, 1, False),
        ({"earth": False}, 1, False),  # the same number is another direction
    ],
)
def test_a_chosen_heading_stands_until_something_else_turns_or_stops_the_payload(page, change, ago, stands):
    assert page.evaluate(STANDS, [IDLE, IDLE | change, ago]) == (164 if stands else None)


def test_what_ended_a_chosen_heading_does_so_before_it_is_drawn(page):
    running, stopped = {"state": "idle"}, {"state": "stopped"}
    assert page.evaluate(CONFIRMED, [running, running]) == ["turn"]
    assert page.evaluate(CONFIRMED, [running, stopped]) == []


def test_an_exploration_goes_on_while_a_heading_is_chosen(page):
    turning, listening = IDLE | {"state": "explore_turn"}, IDLE | {"state": "explore_listen", "goal": 70}
    assert page.evaluate(STANDS, [turning, listening, 1]) == 164
