"""A short mission like the demo's, watched through its page from the first word to the replay."""

import re
import signal
import subprocess
from contextlib import contextmanager

import pytest

from browsing import eventually
from page_eyes import sees
from processes import ROSS
from short_mission import SHORT, brief

PANEL = "section[aria-label='Listen']"
INTERRUPTED = 130
PASSES = ["lead in", "explore listen", "explore turn", "align turn", "check", "target recognised", "done"]
LEVEL_DB = """() => {
  const { playout } = globalThis.rossSound.live;
  if (!playout) return -200;
  const samples = new Float32Array(playout.spectrum.fftSize);
  playout.spectrum.getFloatTimeDomainData(samples);
  return 20 * Math.log10(Math.max(...samples.map(Math.abs)) + 1e-10);
}"""
GONE = "ERR_CONNECTION_REFUSED"  # the page tries to come back when its server has ended


@contextmanager
def mission(window, *arguments):
    """``ross sitl --page``: the process and the address of its page; Ctrl-C ends it."""
    command = [*ROSS, "sitl", "--page", *map(str, arguments)]
    window.expected.append(GONE)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        process.said = ""
        try:
            yield process, heard(process, "the page:").split()[-1]
        finally:
            process.send_signal(signal.SIGINT)
            process.said += process.communicate(timeout=90)[0]


def heard(process, words):
    """Read on until a line has these words; return it."""
    for line in process.stdout:
        process.said += line
        if words in line:
            return line
    raise AssertionError(process.said)


def payload(open_page, url):
    page = open_page(f"{url}#/payload/1-191")
    page.locator(".payload-title .state").wait_for()
    return page


@pytest.mark.timeout(280)
def test_the_whole_mission_is_watched_and_played_again(window, open_page, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    with mission(window, "--scenario", tmp_path / "short.toml", "--out", tmp_path) as (process, url):
        page = payload(open_page, url)  # however late: the mission does not wait for it
        eventually(page, lambda: page.locator(".payload-title .state").text_content() == "Done", 120.0)
        assert "target" in page.locator("table.sources").text_content()
        assert "replays the mission" in heard(process, "Ctrl-C ends it")
        sees(page, "The simulation has ended", "#ended")
        assert page.get_by_role("button", name="Stop: nothing is running").get_attribute("aria-disabled") == "true"
        page.get_by_role("link", name="Replay the mission").click(timeout=60_000)
        replayed(page)
    assert process.returncode == 0, process.said


@pytest.mark.timeout(180)
def test_a_mission_that_runs_by_itself_is_heard_and_refuses_commands(window, open_page, tmp_path):
    lasting = brief("demo", tmp_path, run_s=600.0)  # however late somebody begins to listen
    with mission(window, "--scenario", lasting) as (process, url):
        page = payload(open_page, url)
        sees(page, "4 times real time", f"{PANEL} .pace")
        panel = page.locator(PANEL)
        panel.get_by_role("combobox", name="What is heard").select_option("mixture")
        panel.get_by_role("button", name="Listen", exact=True).focus()
        page.keyboard.press("Enter")  # what is above it is still growing, and would move it from under the mouse
        sees(page, "Playing: mixture", PANEL)
        eventually(page, lambda: page.evaluate(LEVEL_DB) > -60, 60.0)
        panel.get_by_role("button", name="Listen", exact=True).click()
        sees(page, "Silent", PANEL)
        page.get_by_role("button", name="Park").click()
        sees(page, "refused: this mission runs by itself", ".orders")
    assert process.returncode == INTERRUPTED, process.said


def replayed(page):
    page.get_by_role("button", name="Open mission.tlog").click(timeout=60_000)
    assert "1970" not in page.locator("main").inner_text()
    slider = page.get_by_label("Time of mission.tlog")
    slider.wait_for()
    passed = re.findall("|".join(PASSES), page.locator("ol.marks").text_content())
    assert list(dict.fromkeys(passed)) == PASSES
    slider.fill("3")
    sees(page, "orientation of the exploration", ".recorded .mission")
    slider.fill("6")
    moment = page.locator(".playback .moment")
    eventually(page, lambda: moment.text_content().startswith("0:06"))
    page.locator(".recorded .scope .source").first.wait_for()
    page.get_by_role("button", name="Play", exact=True).click()
    eventually(page, lambda: "0:06" < moment.text_content()[:4] <= "0:59")


@pytest.mark.timeout(200)
def test_a_stop_pressed_on_the_page_ends_the_mission(window, open_page, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    with mission(window, "--scenario", tmp_path / "short.toml", "--speed", "0.5") as (process, url):
        page = payload(open_page, url)
        page.get_by_role("button", name="Stop 1-191").click()
        eventually(page, lambda: "Stopped" in page.locator(".payload-title .state").text_content(), 60.0)
        assert "shows how it ended" in heard(process, "Ctrl-C ends it")
    assert process.returncode == 130
    assert "stopped" in process.said
