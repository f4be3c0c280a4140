"""In a browser: live listening, from the order to the samples that are played; and the consent of who is enrolled."""

from itertools import groupby

from browsing import eventually
from page_eyes import sees, violations, watch
from ports import free_port
from ross_payload.ground.web.page_thread import in_background
from ross_protocols.mavlink.stream_values import Selection
from voice_payload import RATE, VoicePayload

PANEL = "section[aria-label='Listen']"
PLAYED = """() => {
  const panel = globalThis.rossListening;
  const { spectrum } = panel.playout;
  const samples = new Float32Array(spectrum.fftSize);
  spectrum.getFloatTimeDomainData(samples);
  return { samples: [...samples], rate: panel.playout.context.sampleRate, ...panel.state.played };
}"""


def tone(page):
    """The frequency of what is played [Hz], from its sign changes, and its amplitude."""
    heard = page.evaluate(PLAYED)
    samples = heard["samples"]
    peak = max(map(abs, samples))
    crossings = [index for index in range(1, len(samples)) if samples[index - 1] < 0 <= samples[index]]
    if len(crossings) < 3:
        return 0.0, peak
    return heard["rate"] * (len(crossings) - 1) / (crossings[-1] - crossings[0]), peak


def hears(page, hertz):
    eventually(page, lambda: abs(tone(page)[0] - hertz) < 15 and tone(page)[1] > 0.3)


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
        eventually(page, lambda: 40 < page.evaluate("() => globalThis.rossListening.delay ?? 0") < 1500)
        eventually(page, lambda: page.evaluate("() => globalThis.rossListening.state.told?.lost ?? 0") > 0)
        assert not violations(page)
        page.locator(PANEL).get_by_role("combobox", name="What is heard").select_option("mixture")
        hears(page, 500.0)
        page.locator(PANEL).get_by_role("combobox", name="What is heard").select_option("source 1")
        hears(page, 1750.0)
        asked = [selection for selection, _ in groupby(order.selection for order in payload.orders)]
        assert asked == [Selection.TARGET, Selection.MIXTURE, Selection.SOURCE]
        button.click()
        sees(page, "Silent", PANEL)
        eventually(page, lambda: not payload.stream.on)
        page.close()


def test_a_talker_is_enrolled_with_consent_only(window, open_page):
    port = free_port()
    with in_background([f"udpin:127.0.0.1:{port}"]) as served, VoicePayload(port):
        page = watch(open_page, served.url, width=320)
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
