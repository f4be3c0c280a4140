"""A disk that fills while the payload lives: a limit on the size of a file stands for it."""

import numpy as np
import soundfile

from ross_protocols.mavlink.dialect import ross
from short_mission import NOISE
from waiting import wait_for

RATE = 16000
RECORD, EXPLORE = 54008, 54000
SMALL_DISK = """
import resource
from ross_payload import cli

resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
cli.main()
"""
RECORDING = """
[recording]
min_free_gb = 0
"""


def test_a_disk_that_fills_ends_the_recording_and_not_the_mission(tmp_path, process, ground_station, free_port):
    port = free_port()
    (tmp_path / "ross.toml").write_text(NOISE.format(port=port) + RECORDING)
    noise = np.random.default_rng(0).integers(-300, 300, (120 * RATE, 2), np.int16)
    soundfile.write(tmp_path / "noise.wav", noise, RATE)
    start = process(["run", "ross.toml"], tmp_path, "payload", ("-c", SMALL_DISK))
    with start, ground_station(port) as ground:
        wait_for(lambda: "ROSS_AUDIO" in ground.latest)
        assert ground.order(RECORD, 1) == 0
        ended = ground.order(EXPLORE)
        wait_for(lambda: ground.latest["ROSS_RECORDING"].state == ross.ROSS_RECORDING_STATE_FULL)
        assert ground.latest["ROSS_RECORDING"].reason
    assert ended == 0
