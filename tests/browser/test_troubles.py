"""The page when something goes wrong or nobody is there, and with logs that are dropped on it."""

import pytest
from playwright.sync_api import expect

from browsing import eventually
from fleet_bench import FleetThread
from flight_logs import write_hour
from page_eyes import follow, longest_pause, note_pauses, seen, texts, watch
from served_ground import served


@pytest.fixture
def lone(browser, tmp_path):
    """One payload that a test may let go wrong: (ground, payloads)."""
    with served("--flights", tmp_path) as ground, FleetThread(ground.port) as payloads:
        yield ground, payloads


@pytest.fixture
def alone(browser, tmp_path):
    """A ground process that hears nobody."""
    (tmp_path / "flights").mkdir()
    with served("--flights", tmp_path / "flights") as ground:
        yield ground


def test_silence_is_told_within_three_seconds_and_ends_by_itself(lone, open_page):
    ground, payloads = lone
    page = watch(open_page, ground.url)
    page.evaluate("globalThis.sameDocument = true")
    banner = page.locator("#no-telemetry")
    follow(page, "#no-telemetry strong")
    note_pauses(page)
    payloads.tell(silence=[1])
    banner.wait_for()
    seconds = float(seen(page)[0].removeprefix("No telemetry for ").removesuffix(" s."))
    assert 2.0 <= seconds <= 3.0 + longest_pause(page)
    expect(page.locator(".payload-grid.stale")).to_have_count(1)
    payloads.tell(speak=[1])
    banner.wait_for(state="detached")
    assert page.evaluate("sameDocument")


def test_the_page_comes_back_when_the_ground_process_does(lone, open_page, window):
    window.expected.append("/live")
    ground, payloads = lone
    page = watch(open_page, ground.url)
    page.evaluate("globalThis.sameDocument = true")
    ground.end()
    page.locator("#no-ground").wait_for()
    expect(page.get_by_role("button", name="Explore", exact=True)).to_be_disabled()
    page.get_by_role("button", name="Stop 1-191").click()
    expect(page.locator(".stop-fate")).to_have_text("No connection: will be sent on reconnection")
    payloads.tell(silence=[1])
    ground.start()
    page.locator("#no-ground").wait_for(state="detached")
    expect(page.locator(".stop-fate")).to_have_text("Stop sent")  # to whoever may be heard a moment later
    payloads.tell(speak=[1])
    eventually(page, lambda: texts(page, ".payload-title .state") == ["Stopped"])
    assert page.evaluate("sameDocument")


def test_a_stop_that_is_not_answered_cannot_be_cancelled_and_is_done_when_it_is(lone, open_page):
    ground, payloads = lone
    page = watch(open_page, ground.url)
    payloads.tell(silence=[1])
    page.locator("#no-telemetry").wait_for()
    page.get_by_role("button", name="Stop 1-191").click()
    order = page.locator("li.order").filter(has_text="stop")
    order.wait_for()
    shown = order.evaluate("(each) => [each.dataset.state, each.querySelectorAll('button').length]")
    assert shown == ["sent", 0]
    expect(order).to_have_attribute("data-state", "no_answer")
    payloads.tell(speak=[1])
    expect(order).to_have_attribute("data-state", "done")
    expect(page.locator(".stop-fate")).to_have_text("Stopped")


def test_a_stop_that_stops_nobody_says_so(alone, open_page):
    page = open_page(alone.url)
    fates = page.evaluate("""async () => {
      const { stopFate } = await import("/assets/stop.js");
      const row = (state) => [{ id: "1-191", state }];
      const fate = (at, payloads) => stopFate({ ui: { stop: { ids: ["1-191"], at } }, store: { fleet: { payloads } } });
      const states = [[], row("explore_turn"), row("fault"), row("stopped")];
      return [0, 60000].map((ago) => states.map((each) => fate(performance.now() - ago, each).words));
    }""")
    assert fates[0] == ["Stop sent"] * 3 + ["Stopped"]
    other = "stop it by other means"
    assert fates[1] == [f"No telemetry from 1-191: {other}", f"1-191 has not stopped: {other}", "Stop sent", "Stopped"]


def test_a_stop_is_stopped_by_the_answer_to_no_other_order(alone, open_page):
    page = open_page(alone.url)
    fates = page.evaluate("""async () => {
      const { stopFate } = await import("/assets/stop.js");
      const fate = (words) => {
        const orders = [["stop", "no_answer"], [words, "done"]].map(([words, state]) => ({ words, state, since: 1 }));
        const ui = { stop: { ids: ["1-191"], at: performance.now(), now: 1 } };
        const fleet = { payloads: [{ id: "1-191", state: "run" }] };
        const store = { payload: { id: "1-191", sections: { orders } }, fleet };
        return stopFate({ ui, store }).words;
      };
      return ["stop recording", "stop stream 2", "stop"].map(fate);
    }""")
    assert fates == ["No answer: stop it by other means"] * 2 + ["Stopped"]


def test_a_stop_that_was_lost_with_its_socket_is_sent_again_on_the_next_one(lone, open_page, window):
    """The network is gone, and the browser does not know it yet: what it sends leaves, and reaches nobody."""
    ground, _ = lone
    window.expected.append("/live")
    page = watch(open_page, ground.url)
    page.evaluate("""() => {
      globalThis.sent = [];
      const send = WebSocket.prototype.send;
      WebSocket.prototype.send = function (text) {
        if (globalThis.broken) return;
        globalThis.sent.push(text);
        send.call(this, text);
      };
      globalThis.broken = true;
    }""")
    page.get_by_role("button", name="Stop 1-191").click()
    expect(page.locator(".stop-fate")).to_have_text("Stop sent")
    page.evaluate("globalThis.broken = false")
    ground.end()
    page.locator("#no-ground").wait_for()
    ground.start()
    page.locator("#no-ground").wait_for(state="detached")
    eventually(page, lambda: page.evaluate("globalThis.sent.filter((each) => each.includes('\"stop\"')).length") == 1)


def test_a_payload_that_is_armed_again_is_not_stopped_by_a_reconnection(alone, open_page):
    page = open_page(alone.url)
    again = page.evaluate("""async () => {
      const { noted, unstopped } = await import("/assets/stop.js");
      const rows = (first) => ({ payloads: [{ id: "1-191", state: first }, { id: "2-191", state: "run" }] });
      const seen = (stop, first) => noted({ ui: { stop }, store: { fleet: rows(first) } });
      const said = { ids: ["1-191", "2-191"], at: performance.now(), now: 1, stopped: [] };
      const before = Object.keys(unstopped(seen(said, "run"), []));
      return [before, Object.keys(unstopped(seen(seen(said, "stopped"), "explore_turn"), []))];
    }""")
    assert again == [["1-191", "2-191"], ["2-191"]]


@pytest.mark.soak
def test_what_is_odd_is_told_in_words(lone, open_page):
    ground, payloads = lone
    page = watch(open_page, ground.url)
    remarks = page.locator(".remarks")
    payloads.tell(nan=[1])
    eventually(page, lambda: "NaN" in remarks.inner_text())
    payloads.tell(restart=[1])
    eventually(page, lambda: "restarted" in remarks.inner_text())
    payloads.tell(crowd=[1])
    eventually(page, lambda: "200 sources announced, 32 shown" in remarks.inner_text())
    payloads.tell(twin=[1])
    eventually(page, lambda: "wo payloads use the id 1-191" in remarks.inner_text())


def test_nobody_heard_says_what_to_look_at(alone, open_page):
    page = open_page(alone.url)
    page.get_by_text("No payload found.").wait_for()
    expect(page.get_by_role("button", name="Stop", exact=True)).to_be_enabled()


def test_what_is_typed_outlives_a_lost_connection(lone, window):
    ground, _ = lone
    page = window.new_page()
    page.add_init_script("""globalThis.opened = [];
      globalThis.WebSocket = class extends WebSocket {
        constructor(...how) { super(...how); opened.push(this); }
      };""")
    window.open(page, f"{ground.url}#/payload/1-191")
    field = page.get_by_label("Axis heading")
    field.fill("12.5")
    page.evaluate("opened[0].close()")
    eventually(page, lambda: page.evaluate("opened[1]?.readyState") == 1)
    follow(page, ".payload-title .soft")
    eventually(page, lambda: len(seen(page)) > 1)
    expect(field).to_have_value("12.5")
    expect(field).to_be_focused()


def test_a_browser_that_keeps_nothing_shows_the_page_all_the_same(alone, open_page, window):
    """As where all cookies are blocked: an access to the storage is refused."""
    page = window.new_page()
    page.add_init_script("""for (const name of ["localStorage", "sessionStorage"])
      Object.defineProperty(globalThis, name, { get() { throw new DOMException("denied", "SecurityError"); } });""")
    window.open(page, alone.url)
    page.get_by_text("No payload found.").wait_for()
    page.get_by_label("Theme").select_option("dark")
    expect(page.locator("html[data-theme=dark]")).to_have_count(1)


def test_an_id_that_no_payload_can_have_is_neither_stopped_nor_watched(alone, open_page):
    page = open_page(alone.url)
    field = page.get_by_label("Payload by id")
    for wrong in ("0-1", "256-1", "1-256", "001-191"):
        field.fill(wrong)
        page.get_by_role("button", name="Stop this id").click()
        assert not page.locator(".stop-fate").count()
        page.evaluate("id => location.hash = `#/payload/${id}`", wrong)
        expect(page.get_by_role("heading", name="Payloads")).to_be_visible()
    field.fill("255-25")
    page.get_by_role("button", name="Stop this id").click()
    expect(page.locator(".stop-fate")).to_have_text("Stop sent")


def test_a_heading_a_little_west_of_north_is_never_360_degrees(alone, open_page):
    page = open_page(alone.url)
    words = page.evaluate("""async () => {
      const { missionFacts } = await import("/assets/parts/mission.js");
      const { render } = await import("/assets/templates.js");
      const box = document.createElement("div");
      render(missionFacts({ pointing: { heading: 359.7, goal: 359.6, settled: false } }), box);
      return box.textContent;
    }""")
    assert "360" not in words
    assert "turning to 0°" in words


def test_events_of_long_ago_are_told_by_their_age(alone, open_page):
    """The clock of the ground process counts from no moment that anybody knows."""
    page = open_page(alone.url)
    when = page.evaluate("""async () => {
      const { events } = await import("/assets/parts/events.js");
      const { render } = await import("/assets/templates.js");
      const box = document.createElement("div");
      const said = [7000, 67_000, 71_000].map((at) => ({ at, severity: 6, text: "hello" }));
      render(events({ events: said }, 93_400), box);
      return [...box.querySelectorAll(".when")].map((each) => each.textContent);
    }""")
    assert when == ["6 h ago", "7 h ago", "24 h ago"]


def test_a_dropped_log_is_played_and_compared(alone, open_page, tmp_path):
    log = tmp_path / "walk.tlog"
    write_hour(log, seconds=30, payloads=1)
    page = open_page(f"{alone.url}#/flights")
    page.get_by_label("Drop a telemetry log").set_input_files(log)
    slider = page.get_by_role("slider", name="Time of walk.tlog")
    slider.wait_for()
    page.locator(".recorded .scope").wait_for()
    slider.focus()
    page.keyboard.press("ArrowRight")
    eventually(page, lambda: page.locator(".moment").inner_text().startswith("0:05"))
    page.keyboard.press("Space")
    eventually(page, lambda: page.locator(".moment").inner_text() > "0:06")
    page.get_by_role("button", name="Pause").wait_for()
    page.get_by_role("button", name="Compare").click()
    eventually(page, lambda: page.locator(".slot .scope").count() == 2)
    assert not page.locator(".commands").count()
    assert page.evaluate("document.documentElement.scrollWidth") <= 1280


def test_a_log_that_is_dropped_anywhere_is_played_and_the_page_stays(alone, open_page, tmp_path):
    write_hour(tmp_path / "walk.tlog", seconds=2, payloads=1)
    page = open_page(alone.url)
    page.get_by_role("heading", name="Payloads").wait_for()  # it listens: its scripts come after it is loaded
    kept = page.evaluate(
        """(bytes) => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([new Uint8Array(bytes)], "walk.tlog"));
      const told = (kind) => new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true });
      return ["dragover", "drop"].map((kind) => !document.querySelector("h1").dispatchEvent(told(kind)));
    }""",
        list((tmp_path / "walk.tlog").read_bytes()),
    )
    assert kept == [True, True]
    page.get_by_role("slider", name="Time of walk.tlog").wait_for()


def test_what_is_no_log_is_refused_in_one_line(alone, open_page, window, tmp_path):
    window.expected.append("/flights")
    (tmp_path / "song.tlog").write_bytes(b"la" * 4000)
    page = open_page(f"{alone.url}#/flights")
    page.get_by_label("Drop a telemetry log").set_input_files(tmp_path / "song.tlog")
    complaint = page.locator(".picker .bad")
    expect(complaint).to_contain_text("song.tlog")
    assert "\n" not in complaint.inner_text()
