"""`ross sitl --page`: somebody looks on over MAVLink, and the mission is the same as without."""

import signal
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager

import numpy as np
import pytest
import soundfile

from ross_payload.events import Outcome
from ross_payload.listening.observers import BEHIND_S
from ross_protocols.mavlink.dialect import common, ross
from ross_sim.scenario import load
from ross_sim.sitl.mission_session import perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.page_observer import SCRIPTED, PageObserver
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.talker_selection import talkers_of
from short_mission import PAIR
from stream_listener import GroundListener, StreamListener, place_of

pytestmark = pytest.mark.usefixtures("undrawn")

TOLD = PAIR + "[payload.informed]\nazimuths_deg = [40, 155]\n"

TURN, STOP = ross.MAV_CMD_ROSS_TURN, ross.MAV_CMD_ROSS_STOP
RESULTS = ("report.json", "events.jsonl", "mission.tlog", "mixture.wav", "target.wav")


@pytest.fixture
def short(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(TOLD)
    return path


def command(number, *values):
    return common.MAVLink_command_long_message(1, 191, number, 0, *values, *[0] * (7 - len(values)))


def flown(scenario, out, onlooker=None):
    chosen = load(str(scenario))
    with ResultsFolder(out) as folder:
        return perform(chosen, talkers_of(chosen, None, None), MissionView(), folder, None, page=onlooker)


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """A mission that somebody looks on who asks for a turn: what is left, the folder of the results, the onlooker."""
    folder = tmp_path_factory.mktemp("watched")
    (folder / "short.toml").write_text(TOLD)
    with GroundListener(command(TURN, 20.0)) as gazer:
        finished = flown(folder / "short.toml", folder / "out", PageObserver("", gazer.link))
    return finished, folder / "out", gazer


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The results of the same mission that nobody looks on."""
    folder = tmp_path_factory.mktemp("alone")
    (folder / "short.toml").write_text(TOLD)
    flown(folder / "short.toml", folder / "out")
    return folder / "out"


def test_the_results_are_the_same_whether_somebody_looks_on_or_not(watched, alone):
    _, results, gazer = watched
    for name in RESULTS:
        assert (alone / name).read_bytes() == (results / name).read_bytes()
    assert [packet.value for packet in gazer.packets if packet.name == "ROSS_STATUS"][-1].mission_time > 1.0
    assert gazer.messages("ROSS_AUDIO")


def test_what_a_scripted_mission_cannot_do_is_refused_in_words(watched):
    finished, _, gazer = watched
    assert finished.result.outcome is Outcome.TARGET_FOUND
    assert [ack.result for ack in gazer.messages("COMMAND_ACK")] == [common.MAV_RESULT_DENIED]
    assert f"refused: {SCRIPTED}" in gazer.texts()


@pytest.mark.parametrize("number", [STOP, ross.MAV_CMD_ROSS_CANCEL])
def test_a_stop_or_a_cancel_from_the_page_ends_the_mission(short, tmp_path, number):
    with GroundListener(command(number)) as gazer:
        onlooker = PageObserver("", gazer.link)
        finished = flown(short, tmp_path, onlooker)
    assert finished.result.outcome is Outcome.STOPPED
    assert onlooker.stopped
    assert [ack.result for ack in gazer.messages("COMMAND_ACK")] == [common.MAV_RESULT_ACCEPTED]


@pytest.mark.soak
def test_what_somebody_hears_live_is_the_mixture_in_real_time_and_the_results_stay_the_same(alone, short, tmp_path):
    pytest.importorskip("aiortc", reason="the extra [stream]")
    begun = time.monotonic()
    with StreamListener() as ear, GroundListener(ear.order) as gazer:
        flown(short, tmp_path / "heard", PageObserver("", gazer.link))
    took = time.monotonic() - begun
    for name in RESULTS:
        assert (alone / name).read_bytes() == (tmp_path / "heard" / name).read_bytes()
    assert [ack.result for ack in gazer.messages("COMMAND_ACK")] == [common.MAV_RESULT_ACCEPTED]
    assert took > ear.seconds - BEHIND_S  # at real time, but for what was under way when it was asked for
    heard = np.concatenate([packet.samples for packet in ear.packets[:25]]) / 2**15
    assert place_of(heard, soundfile.read(tmp_path / "heard" / "mixture.wav")[0][:, 0]) >= 0
    assert ear.missing == 0
    assert not gazer.messages("ROSS_STREAM")[-1].flags & ross.ROSS_STREAM_FLAGS_ON


@contextmanager
def running(*arguments):
    command = [sys.executable, "-u", "-m", "ross_payload.cli", "sitl", "--page", *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        yield process
        process.wait(60)


def address(process):
    line = next(line for line in process.stdout if line.startswith("the page"))
    return line.split()[-1] if line.startswith("the page:") else line.split()[-4]


@pytest.mark.soak  # in a browser: test_whole_mission
@pytest.mark.timeout(240)
def test_the_page_is_there_during_the_mission_and_after_it_until_ctrl_c(short, tmp_path):
    pytest.importorskip("aiohttp", reason="the extra [ground]")
    with running("--scenario", short, "--out", tmp_path / "out", "--speed", "max") as process:
        url = address(process)
        assert "<html" in urllib.request.urlopen(url, timeout=20).read().decode()  # noqa: S310 - our own page
        rest = next(line for line in process.stdout if "replays the mission" in line)
        assert url in rest
        assert (tmp_path / "out" / "mission.tlog").is_file()
        assert "<html" in urllib.request.urlopen(url, timeout=20).read().decode()  # noqa: S310
        process.send_signal(signal.SIGINT)
    assert process.returncode == 0
