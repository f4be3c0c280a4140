"""`ross sitl --serve` is listened to: what the mission computes holds up neither sound nor heartbeats."""

import os
import signal

import numpy as np
import pytest
import soundfile

from examples import in_soak
from ross_payload.config import Link
from ross_sim.scenario import load
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.serve import serve
from ross_sim.sitl.talker_selection import talkers_of
from stream_listener import GroundListener, StreamListener, place_of
from waiting import wait_for

FIRST = 25  # packets that are compared: half a second
COMPUTED_S = 3.0  # of sound that has to be heard while the mission computes
pytest.importorskip("aiortc", reason="the extra [stream]")


class Computing(MissionView):
    """Holds the mission up, on its thread, until it has been heard for a while; then it ends the payload."""

    def __init__(self, ear, ground):
        self._ear, self._ground = ear, ground
        self.computed = 0
        self.error = None

    def on_input(self, hop):
        if self.computed or not self._ear.packets:
            return
        self.computed = 1
        try:
            packets, beats = len(self._ear.packets), len(self._ground.messages("HEARTBEAT"))
            wait_for(lambda: len(self._ear.packets) > packets + 50 * COMPUTED_S)
            wait_for(lambda: len(self._ground.messages("HEARTBEAT")) >= beats + 2)
        except AssertionError as error:
            self.error = error
        os.kill(os.getpid(), signal.SIGINT)  # as a terminal does it: the main thread hears it


def served(scenario, folder, speed):
    """Serve, stop when it was heard; return what heard it and the first sound that was there."""
    with StreamListener() as ear, GroundListener(ear.order) as ground, ResultsFolder(folder / "out") as out:
        chosen = load(str(scenario))
        links = {"links": (Link(url=ground.link),)}
        chosen = chosen.model_copy(update={"payload": chosen.payload.model_copy(update=links)})
        view, company = Computing(ear, ground), talkers_of(chosen, None, None)
        serve(chosen, company, view, out=out, speed=speed, recordings=folder / "kept", always=False)
    assert view.error is None, view.error
    return ear


@pytest.mark.parametrize("speed", [*in_soak(1.0), 2.0])
def test_sound_and_heartbeats_go_on_while_the_mission_computes(short, tmp_path, speed):
    ear = served(short, tmp_path, speed)
    assert ear.missing == 0
    mixture = soundfile.read(tmp_path / "out" / "mixture.wav")[0][:, 0]
    heard = np.concatenate([packet.samples for packet in ear.packets[:FIRST]]) / 2**15
    assert place_of(heard, mixture) >= 0
