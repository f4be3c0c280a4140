"""The stop: in reach at all times, and what is told of it is so."""

import signal

import pytest
from playwright.sync_api import expect

from browsing import drawn, eventually
from fleet_bench import FleetThread
from page_eyes import follow, seen, sees, violations, watch
from served_ground import served

PHONE, SMALL_PHONE, DESK = (390, 844), (320, 480), (1280, 800)
HERE = "document.querySelector('.stop-button')"
IN_REACH = f"""() => {{
  const {{ left, top, width, height }} = {HERE}.getBoundingClientRect();
  return document.elementFromPoint(left + width / 2, top + height / 2)?.closest(".stop-button") === {HERE};
}}"""
FATES = """async ([stop, rows, orders, stopping, stops]) => {
  const { stopFate } = await import("/assets/stop.js");
  const ui = { stop: { ids: ["1-191"], stopped: [], ...stop, at: performance.now() - stop.ago } };
  const fleet = { payloads: rows.map((each) => ({ id: "1-191", ...each })), stopping, stops };
  return stopFate({ ui, store: { fleet, payload: orders && { id: "1-191", sections: { orders } } } }).words;
}"""
BANNERS = """async ([state, orders, stopping]) => {
  const { banners } = await import("/assets/parts/banners.js");
  const { commandStatus } = await import("/assets/parts/command-status.js");
  const { render } = await import("/assets/templates.js");
  const now = performance.now();
  const payload = { id: "1-191", now: 9, got: now, sections: { orders, standing: { state, last: 9 } } };
  const fleet = { payloads: [{ id: "1-191", state, last: 9 }], stopping, now: 9, links: [] };
  const page = {
    store: { payload, fleet, fleetGot: now, refusals: [], mode: "live" }, socket: { up: true, ever: true, since: now },
    route: { view: "payload", id: "1-191" }, now: () => 9, silence: () => 0, over: "", commandsBlocked: null,
  };
  return [banners(page), commandStatus(page, payload)].map((each) => {
    const box = document.createElement("div");
    render(each, box);
    return box.textContent.replace(/\\s+/g, " ").trim();
  });
}"""
OTHERWISE, RANGE = "stop it by other means", "check that it is in range"


@pytest.fixture(scope="module")
def crew(browser):
    with served() as ground, FleetThread(ground.port) as payloads:
        yield ground, payloads


@pytest.fixture
def page(crew, open_page):
    return watch(open_page, crew[0].url)


def unanswered():
    return [{"number": 1, "words": "stop", "state": "no_answer", "reason": RANGE, "since": 2.0, "at": 4.2}]


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


@pytest.mark.parametrize("size", [(320, 640), PHONE])
@pytest.mark.parametrize("percent", [150, 200])
def test_the_stop_is_in_reach_with_large_letters_on_a_phone(page, size, percent):
    width, height = size
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate("size => { document.documentElement.style.fontSize = size; }", f"{percent}%")
    drawn(page)
    for place in (0, 400):
        page.evaluate("place => scrollTo(0, place)", place)
        drawn(page)
        box = page.locator(".stop-button").bounding_box()
        assert page.evaluate(IN_REACH), place
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
        assert box["y"] + box["height"] <= height


def test_consent_of_one_talker_is_not_that_of_another(page):
    page.get_by_role("button", name="Take control").click()
    dialog = page.get_by_role("dialog")
    for source in (1, 0):
        page.locator("table.sources").get_by_role("button", name=f"Source {source}").click()
        page.get_by_role("button", name=f"Enrol source {source}").click()
        sees(page, f"Enrol the talker at source {source}", "#enrolment")
        expect(dialog.get_by_role("checkbox")).not_to_be_checked()
        expect(dialog.get_by_label("Number of the talker")).to_have_value("0")
        dialog.get_by_role("checkbox").check()
        dialog.get_by_label("Number of the talker").fill("7")
    dialog.get_by_role("button", name="Cancel").click()


def test_stopped_is_told_no_longer_once_a_payload_is_armed_again(page, crew, open_page):
    other = open_page(crew[0].url)
    page.get_by_role("button", name="Take control").click()
    for one in (page, other):
        one.get_by_role("button", name="Stop 1-191").click()
        sees(one, "Stopped", ".stop-fate")
    sees(page, "Stopped", ".payload-title")
    sees(other, "Stopped", ".fleet .state")
    page.get_by_role("button", name="Rearm", exact=True).click()
    page.get_by_role("button", name="Explore", exact=True).click()
    for one in (page, other):
        eventually(one, lambda one=one: not one.locator(".stop-fate").count(), 4.0)


def test_a_stop_whose_acknowledgement_is_lost_is_stopped_when_telemetry_says_so(page):
    stop = {"ago": 20_000, "now": 2.0}

    def fate(rows, stopping):
        return page.evaluate(FATES, [stop, rows, unanswered(), stopping])

    assert fate([{"state": "stopped", "last": 3.0}], ["1-191"]) == "Stopped"
    assert fate([{"state": "stopped", "last": 1.0}], []) == f"No answer: {OTHERWISE}"  # of before the stop
    assert fate([{"state": "stopped", "state_at": 1.0, "last": 3.0}], []) == f"No answer: {OTHERWISE}"
    assert fate([{"state": "run", "last": 3.0}], ["1-191"]) == f"No answer, still being sent: {OTHERWISE}"


def test_a_stop_of_another_page_says_whether_it_is_still_being_sent(page):
    stop = {"ago": 20_000, "now": 2.0}

    def fate(rows, stopping):
        return page.evaluate(FATES, [stop, rows, None, stopping])

    assert fate([{"state": "run", "last": 3.0}], ["1-191"]) == f"1-191 has not stopped, still being sent: {OTHERWISE}"
    assert fate([{"state": "run", "last": 3.0}], ["2-191"]) == f"1-191 has not stopped: {OTHERWISE}"
    assert fate([], ["1-191"]) == f"No telemetry from 1-191, still being sent: {OTHERWISE}"


def test_a_stop_of_another_page_is_confirmed_by_its_acknowledgement_alone(page):
    """Telemetry tells nothing of whether what has a fault stands still."""

    def fate(state, at, stopping=()):
        stops = [{"id": "1-191", "words": "stop", "state": state, "reason": "", "since": at, "at": at}]
        rows = [{"state": "fault", "last": 30.0}]
        return page.evaluate(FATES, [{"ago": 20_000, "now": 2.0}, rows, None, list(stopping), stops])

    assert fate("done", 2.0) == "Stopped"
    assert fate("sent", 2.0, ["1-191"]) == "Stop sent"
    assert fate("no_answer", 2.0, ["1-191"]) == f"No answer from 1-191, still being sent: {OTHERWISE}"
    assert fate("no_answer", 2.0) == f"No answer from 1-191: {OTHERWISE}"
    assert fate("done", 0.5) == "Stop sent"  # an earlier one


def test_every_payload_that_has_not_stopped_is_named(page):
    def fate(count):
        ids = [f"{system}-191" for system in range(1, count + 1)]
        stop = {"ago": 20_000, "now": 2.0, "ids": ["9-191", *ids]}
        rows = [{"id": each, "state": "run", "last": 3.0} for each in ids]
        return page.evaluate(FATES, [stop, [{"id": "9-191", "state": "stopped", "last": 3.0}, *rows], None, ids[:1]])

    assert fate(2) == "1-191 has not stopped, still being sent; 2-191 has not stopped: stop them by other means"
    assert fate(7).endswith("4-191 has not stopped; and 3 more: stop them by other means")


def pressed(page, who):
    page.evaluate("who => { location.hash = `#/payload/${who}`; }", who)
    page.get_by_role("heading", name=f"Payload {who}").wait_for()
    page.get_by_role("button", name=f"Stop {who}").click()


def test_every_stop_that_is_pressed_without_a_connection_is_sent(open_page, window):
    window.expected.append("ERR_CONNECTION_REFUSED")
    with served() as ground, FleetThread(ground.port, payloads=3):
        page = watch(open_page, ground.url)
        ground.end(signal.SIGKILL)
        for who in ("1-191", "2-191"):
            pressed(page, who)
            sees(page, "No connection: will be sent on reconnection", ".stop-fate")
        ground.start()
        page.evaluate("location.hash = '#/'")
        eventually(page, lambda: page.locator(".fleet .state", has_text="Stopped").count() == 2, 20.0)
        sees(page, "Stopped", ".stop-fate")


def test_a_stop_that_a_dying_connection_swallowed_is_sent_on_reconnection(open_page, window):
    """As when the network goes before the browser notices: what it sends meanwhile arrives nowhere."""
    dead, routes = [], []

    def route(socket):
        routes.append(socket)
        server = socket.connect_to_server()
        socket.on_message(lambda said: None if socket in dead else server.send(said))
        server.on_message(lambda said: None if socket in dead else socket.send(said))

    with served() as ground, FleetThread(ground.port, payloads=2):
        page = open_page("about:blank")
        page.route_web_socket("**/live**", route)
        window.open(page, f"{ground.url}#/payload/1-191")
        page.locator(".hero .scope").wait_for()
        dead.append(routes[-1])
        pressed(page, "1-191")
        sees(page, "Stop sent", ".stop-fate")
        follow(page, ".stop-fate")
        routes[-1].close()
        sees(page, "Stopped", ".stop-fate")
        sees(page, "Stopped", ".payload-title")
        assert seen(page)[:2] == ["Stop sent", "No connection: will be sent on reconnection"]
        window.close_pages()  # else it complains that the ground process has ended


def test_a_stop_that_was_not_answered_is_not_forgotten_with_the_next_one_of_another_payload(open_page, window):
    with served() as ground, FleetThread(ground.port, payloads=2):
        page = watch(open_page, ground.url)
        pressed(page, "7-191")  # of which nothing is heard
        pressed(page, "2-191")
        sees(page, "Stopped", ".payload-title")
        eventually(page, lambda: "7-191" in page.locator(".stop-fate").text_content(), 10.0)
        window.close_pages()  # else it complains that the ground process has ended


def test_a_stop_that_is_still_sent_is_not_over_when_the_payload_goes_on(page):
    """As on a slow link, where what tells of an earlier stop comes after this one was pressed."""
    after = page.evaluate("""async () => {
      const { followed } = await import("/assets/stop.js");
      const at = performance.now();
      const step = (stop, state, stopping) => {
        const fleet = { payloads: [{ id: "1-191", state, last: 3 }], stopping };
        return followed({ ui: { stop }, store: { fleet, payload: null } });
      };
      const stop = { ids: ["1-191"], at, now: 2, stopped: [] };
      const rested = step(step(stop, "stopped", ["1-191"]), "stopped", ["1-191"]);
      const still = step(rested, "run", ["1-191"]);
      return [rested.confirmed > 0, still && still.confirmed, still && still.ids, step(rested, "run", [])];
    }""")
    assert after == [True, None, ["1-191"], None]


def test_a_payload_that_another_page_armed_again_is_not_told_as_stopped_with_the_last_one(page):
    words = page.evaluate("""async () => {
      const { followed, noted, stopFate } = await import("/assets/stop.js");
      const done = { id: "1-191", words: "stop", state: "done", since: 2, at: 3 };
      const page = { ui: { stop: { ids: ["1-191", "2-191"], at: -20000, now: 2, stopped: [] } } };
      return [["stopped", "run"], ["run", "run"], ["run", "stopped"]].map(([one, other], step) => {
        const row = (id, state) => ({ id, state, state_at: 3 + step });
        const rows = [row("1-191", one), row("2-191", other)];
        page.store = { fleet: { payloads: rows, stopping: ["2-191"], stops: [done] }, payload: null };
        page.ui.stop = noted(page);
        page.ui.stop = followed(page);
        return [stopFate(page).words, page.ui.stop.ids];
      });
    }""")
    going_on = f"2-191 has not stopped, still being sent: {OTHERWISE}"
    assert words == [[going_on, ["1-191", "2-191"]], [going_on, ["2-191"]], ["Stopped", ["2-191"]]]


def test_a_stop_is_not_asked_for_any_longer_of_a_payload_that_was_armed_again_here(page):
    def rearmed(ids, **stop):
        stop = {"ids": ids, "stopped": [], "at": 0, "now": 2, **stop}
        return page.evaluate("async (stop) => (await import('/assets/stop.js')).rearmed(stop, '1-191')", stop)

    assert rearmed(["1-191"]) is None
    assert rearmed(["1-191", "2-191"], confirmed=1) is None
    assert rearmed(["1-191", "2-191"])["ids"] == ["2-191"]
    assert rearmed(["2-191"])["ids"] == ["2-191"]


def test_a_stop_without_an_answer_is_a_notice_only_while_the_payload_has_not_stopped(page):
    def told(state, stopping):
        return page.evaluate(BANNERS, [state, unanswered(), stopping])

    banner, commands = told("run", ["1-191"])
    assert banner == "No answer: stop. It is still being sent. Check that it is in range."
    assert "no answer, still being sent: check that it is in range" in commands
    banner, commands = told("run", [])
    assert banner == "No answer: stop. Check that it is in range."
    assert "still being sent" not in commands
    assert told("stopped", ["1-191"])[0] == ""
