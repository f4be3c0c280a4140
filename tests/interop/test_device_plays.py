"""The sink ``device`` plays into a real sound system, and again after that was killed; nobody else notices."""

import subprocess
import sys
import threading
from pathlib import Path

import numpy as np

from loudspeaker_voice import delays
from waiting import wait_for

PROGRAM = Path(__file__).with_name("device_process.py")
SUPPORT = Path(__file__).parents[1] / "support"
SOON_S = 0.6  # from a write to the recorder; 0.135 s where nothing else runs
STEADY_S = 0.1  # by which that may change within a second


def test_what_it_plays_arrives_whole_and_soon_and_again_after_the_server_was_killed(loudspeaker):
    command = [sys.executable, PROGRAM, "pulse"]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    environment = loudspeaker.environment | {"PYTHONPATH": str(SUPPORT)}
    with subprocess.Popen(command, env=environment, text=True, **pipes) as player:
        log = []
        reader = threading.Thread(target=lambda: log.extend(player.stderr))
        reader.start()
        began = float(player.stdout.readline())

        def heard():
            told = delays(loudspeaker.samples, loudspeaker.heard_until - began) if len(loudspeaker.samples) else []
            return told if told and max(told) < SOON_S and np.ptp(told) < STEADY_S else None

        assert min(wait_for(heard)) > 0
        loudspeaker.kill()
        wait_for(lambda: any("disconnected" in line for line in log))
        loudspeaker.start()
        assert min(wait_for(heard)) > 0
        player.stdin.close()
        count = int(player.stdout.read())
        reader.join()
    said = [line[line.index("stream 0") :].strip() for line in log if "stream 0" in line]  # libraries end no line
    killed = said.index("stream 0: the sound output 'pulse' was disconnected")  # before, it may have opened late
    assert said[killed + 1].startswith("stream 0: works again after ")
    assert len(said) == killed + 2, said
    assert count > 300, "whoever writes goes on"
    assert "Traceback" not in "".join(log)
