"""In a browser: live listening, from the order to the samples that are played; and the consent of who is enrolled."""

from itertools import groupby

import pytest

from browsing import eventually
from fleet_bench import FleetThread
from flight_sound import HEARD_FROM, session, simulated
from page_eyes import sees, violations, watch
from ports import free_port
from ross_payload.ground.flights.reading import open_flight
from ross_payload.ground.web.app import in_background
from ross_protocols.mavlink.stream_values import Selection
from voice_payload import RATE, VoicePayload

PANEL = "section[aria-label='Listen']"
TAP = """() => {
  const { recorded } = globalThis.rossSound;
  const context = new AudioContext({ sampleRate: 16000 });
  const tap = new AnalyserNode(context, { fftSize: 1024 });
  context.createMediaElementSource(recorded.audio).connect(tap);
  const samples = new Float32Array(1024);
  globalThis.rossHeard = [];
  setInterval(() => {
    context.resume(); // it may, once somebody has pressed something
    tap.getFloatTimeDomainData(samples);
    const crossings = [...samples.keys()].filter((index) => index && samples[index - 1] < 0 && samples[index] >= 0);
    const hertz = (16000 * (crossings.length - 1)) / (crossings.at(-1) - crossings[0]);
    if (Math.max(...samples) > 0.2) globalThis.rossHeard.push([recorded.chosen.track, hertz]);
  }, 20);
}"""
RECORDED = """() => {
  const { audio } = globalThis.rossSound.recorded;
  return { at: audio.currentTime, paused: audio.paused };
}"""
ANOTHER = """() => {
  const socket = globalThis.rossOther = new WebSocket(`ws://${location.host}/listen?id=1-191`);
  socket.addEventListener("open", () => socket.send(JSON.stringify({ type: "choose", what: "mixture" })));
}"""
DRIFT = """async () => {
  const { PlayoutBuffer } = await import("/assets/audio/playout-buffer.js");
  const rate = 16000, block = 320, quantum = 128, fast = 1 + 3e-4;
  const tone = (index) => Math.sin(2 * Math.PI * 440 * index / rate);
  const buffer = new PlayoutBuffer(rate), played = [], fills = [];
  let sent = 0, due = 0;
  for (let at = 0; at < 60 * rate; at += quantum) {
    for (; due <= at; due = (sent / fast) + 0.01 * rate * ((sent / block * 7919) % 100) / 100) {
      buffer.push(Float32Array.from({ length: block }, (_, index) => tone(sent + index)));
      sent += block;
    }
    const output = new Float32Array(quantum);
    buffer.pull(output);
    played.push(...output);
    if (at > 30 * rate) fills.push(buffer.waiting / rate);
  }
  const steps = played.slice(rate).map((sample, index, all) => Math.abs(sample - (all[index - 1] ?? sample)));
  const step = steps.reduce((one, other) => Math.max(one, other));
  return { ...buffer.counts, least: Math.min(...fills), most: Math.max(...fills), step };
}"""
GAP = """async () => {
  const { PlayoutBuffer } = await import("/assets/audio/playout-buffer.js");
  const rate = 16000, buffer = new PlayoutBuffer(rate), output = new Float32Array(1600);
  const before = buffer.target;
  buffer.push(new Float32Array(1600).fill(0.5));
  buffer.pull(output);
  const last = output.slice(1500, 1600);
  const after = buffer.target;
  buffer.push(new Float32Array(16000));
  return { last: [...last], before, after, waiting: buffer.waiting, ...buffer.counts };
}"""
PLAYED = """() => {
  const panel = globalThis.rossSound.live;
  if (!panel.playout) return { samples: [], rate: 0 };
  const { spectrum } = panel.playout;
  const samples = new Float32Array(spectrum.fftSize);
  spectrum.getFloatTimeDomainData(samples);
  return { samples: [...samples], rate: panel.playout.context.sampleRate, ...panel.state.played };
}"""


def tone(page):
    """The frequency of what is played [Hz], from its sign changes, and its amplitude."""
    heard = page.evaluate(PLAYED)
    samples = heard["samples"]
    peak = max(map(abs, samples), default=0.0)
    crossings = [index for index in range(1, len(samples)) if samples[index - 1] < 0 <= samples[index]]
    if len(crossings) < 3:
        return 0.0, peak
    return heard["rate"] * (len(crossings) - 1) / (crossings[-1] - crossings[0]), peak


def hears(page, hertz):
    def claim():
        found, peak = tone(page)
        return abs(found - hertz) < 15 and peak > 0.2

    eventually(page, claim)


def heard_of(page, track, hertz):
    """Whether a track of a flight was heard, by its tone."""
    heard = page.evaluate("() => globalThis.rossHeard")
    return any(name == track and found is not None and abs(found - hertz) < 25 for name, found in heard)


def test_somebody_listens_chooses_and_stops(window, open_page):
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"]) as served, VoicePayload(port, lose=25) as payload:
        page = watch(open_page, served.url)
        sees(page, "Silent", PANEL)
        assert not payload.orders, "nobody asked for it"
        button = page.locator(PANEL).get_by_role("button", name="Listen", exact=True)
        assert button.get_attribute("aria-pressed") == "false"
        button.focus()
        page.keyboard.press("Enter")
        hears(page, 1000.0)
        assert page.evaluate(PLAYED)["rate"] == RATE
        assert button.get_attribute("aria-pressed") == "true"
        sees(page, "Playing: target", PANEL)
        eventually(page, lambda: 40 < page.evaluate("() => globalThis.rossSound.live.delay ?? 0") < 1500)
        eventually(page, lambda: page.evaluate("() => globalThis.rossSound.live.state.told?.lost ?? 0") > 0)
        page.locator(PANEL).get_by_role("combobox", name="What is heard").select_option("source 1")
        hears(page, 1750.0)
        page.evaluate(ANOTHER)
        sees(page, "1 other browser listens: what is heard is chosen for all.", PANEL)
        hears(page, 500.0)
        chosen = page.locator(PANEL).get_by_role("combobox", name="What is heard")
        eventually(page, lambda: chosen.input_value() == "mixture")
        page.evaluate("() => globalThis.rossOther.close()")
        eventually(page, lambda: "other browser" not in page.locator(PANEL).text_content())
        asked = [selection for selection, _ in groupby(order.selection for order in payload.orders)]
        assert asked == [Selection.TARGET, Selection.SOURCE, Selection.MIXTURE]
        button.click()
        sees(page, "Silent", PANEL)
        eventually(page, lambda: not payload.stream.on)
        page.evaluate("() => globalThis.rossSound.live.start('1-191', null)")  # the rate is not known yet
        hears(page, 500.0)
        assert page.evaluate(PLAYED)["rate"] == RATE
        page.get_by_role("link", name="Map").click()
        eventually(page, lambda: not payload.stream.on)
        page.close()


def test_a_stream_to_somebody_else_is_ended_by_its_address(window, open_page):
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"]) as served, VoicePayload(port) as payload:
        payload.go_to("192.0.2.7", 5004)
        page = watch(open_page, served.url)
        page.get_by_role("button", name="End the stream to 192.0.2.7:5004").click()
        eventually(page, lambda: payload.orders)
        order = payload.orders[0]
        assert (order.selection, order.number) == (Selection.NONE, None)
        assert (order.address, order.port) == ("192.0.2.7", 5004)
        page.get_by_role("button", name="End the stream to 192.0.2.7:5004").wait_for(state="hidden")
        page.close()


def test_a_talker_is_enrolled_with_consent_only(window, open_page):
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"]) as served, VoicePayload(port):
        page = watch(open_page, served.url, width=320)
        page.get_by_role("button", name="Source 1").first.click()
        page.get_by_role("button", name="Enrol source 1").click()
        dialog = page.get_by_role("dialog")
        dialog.wait_for()
        dialog.get_by_role("button", name="Enrol", exact=True).click()
        assert not served.state.client.orders.doing, "without consent nothing is sent"
        assert page.evaluate("() => document.documentElement.scrollWidth") <= 320
        dialog.get_by_role("checkbox").check()
        dialog.get_by_role("button", name="Enrol", exact=True).click()
        eventually(page, lambda: [each.words for each in served.state.client.orders.doing] == ["enrol source 1"])
        dialog.wait_for(state="hidden")
        page.close()


def test_a_mission_that_is_over_is_heard_before_and_after_with_one_click(tmp_path, window, open_page):
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"], flights=simulated(tmp_path)) as served, FleetThread(port):
        served.state.over = "The simulation has ended."
        page = open_page(served.url)
        hear = page.get_by_role("button", name="Hear before and after")
        hear.wait_for()
        page.evaluate(TAP)
        hear.click()
        for track, hertz in [("mixture", 500.0), ("target", 1000.0)]:
            eventually(page, lambda track=track, hertz=hertz: heard_of(page, track, hertz))
        page.get_by_label("Time of mission.tlog").fill("3")  # a click of the user moves the sound as well
        eventually(page, lambda: abs(page.evaluate(RECORDED)["at"] - 3.0 + HEARD_FROM) < 0.9)
        assert not violations(page)
        page.get_by_role("button", name="Target").click()
        eventually(page, lambda: page.evaluate(RECORDED)["paused"])
        page.close()


def test_a_flight_is_heard_while_another_tab_is_seen(tmp_path, window, open_page):
    with in_background([f"udpin:127.0.0.1:{free_port()}"], flights=simulated(tmp_path)) as served:
        page = open_page(f"{served.url}#/flights")
        page.get_by_role("button", name="Open mission.tlog").click()
        page.get_by_role("button", name="Mixture").click()
        page.locator("button.play").wait_for()
        page.evaluate(
            """() => {
          Object.defineProperty(document, "hidden", { value: true });
          globalThis.requestAnimationFrame = () => 0;
          document.querySelector("button.play").click();
        }"""
        )
        eventually(page, lambda: not page.evaluate(RECORDED)["paused"])
        page.close()


@pytest.mark.soak
def test_an_mcap_file_that_is_uploaded_is_heard_beside_its_telemetry(tmp_path, window, open_page):
    pytest.importorskip("foxglove", reason="needs the extra 'mcap'")
    from ross_payload.ground.flights.mcap import export

    flight = open_flight(session(tmp_path / "flown"))
    export(flight, flight.payloads, tmp_path / "flown.mcap")
    with in_background([f"udpin:127.0.0.1:{free_port()}"]) as served:
        page = open_page(f"{served.url}#/flights")
        page.get_by_label("Drop a telemetry log").set_input_files(tmp_path / "flown.mcap")
        page.get_by_role("button", name="Mixture").wait_for()
        page.evaluate(TAP)
        page.get_by_role("button", name="Mixture").click()
        page.get_by_role("button", name="Play", exact=True).click()
        eventually(page, lambda: heard_of(page, "mixture", 500.0))
        page.locator("section[aria-label='Flight flown.mcap'] section[aria-label='Mission']").wait_for()
        assert not violations(page)
        page.close()


def test_two_clocks_that_differ_neither_starve_nor_flood_what_is_played(window, open_page):
    with in_background([f"udpin:127.0.0.1:{free_port()}"]) as served:
        page = open_page(served.url)
        heard = page.evaluate(DRIFT)
        assert (heard["gaps"], heard["skipped"]) == (0, 0)
        assert heard["least"] > 0.005
        assert heard["most"] < 0.12
        assert heard["step"] < 2 * 3.1416 * 440 / 16000 * 1.05, "no jump between two samples"
        gap = page.evaluate(GAP)
        assert gap["gaps"] == 1
        assert gap["after"] > gap["before"], "after a gap more is kept"
        assert abs(gap["last"][-1]) < 0.01, "it fades"
        assert gap["skipped"] > 0
        assert gap["waiting"] < 16000 / 2, "what is too old is left out"
        page.close()
