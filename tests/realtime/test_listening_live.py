"""``ross run`` is listened to: all that is heard arrives soon, whatever the mission computes and other sinks do."""

import contextlib
import socket
import threading
import time

import numpy as np
import soundfile

from ross_protocols.audio.pcm import Decoder
from short_mission import NOISE
from waiting import wait_for

RATE = 16000
EXPLORE, STREAM = 54000, 54011
LATE_S = 0.6  # from the microphone to the listener; the stage itself takes 0.085 s
PAYLOAD = (
    NOISE
    + """
[[listening.streams]]
sink = "tcp"
what = "mixture"
options = {{ port = {pcm} }}
[[listening.streams]]
sink = "file"
options = {{ path = "noise.wav/target.flac" }}
[[listening.streams]]
sink = "tcp"
options = {{ port = {busy} }}
[[listening.streams]]
sink = "tcp"
what = "source 0"
options = {{ port = {absent}, mode = "connect" }}
"""
)


class Listener:
    """Hears PCM, and remembers when what came."""

    def __init__(self, port):
        self._socket = wait_for(lambda: connected(port))
        self._decoder = Decoder()
        self.arrivals = []  # time [s], samples so far
        self.blocks = []
        self.over = False
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self):
        count = 0
        with contextlib.suppress(OSError):
            while data := self._socket.recv(65536):
                frames = self._decoder.feed(data)
                if frames.size:
                    count += len(frames)
                    self.blocks.append(frames[:, 0])
                    self.arrivals.append((time.monotonic(), count))
        self.over = True

    @property
    def samples(self):
        return np.concatenate(self.blocks)

    def close(self):
        self._socket.close()


def connected(port):
    with contextlib.suppress(OSError):
        return socket.create_connection(("127.0.0.1", port), 20)


def test_it_is_heard_while_it_explores_and_while_other_sinks_fail(tmp_path, process, ground_station, free_port):
    port, pcm, absent = free_port(), free_port(), free_port()
    noise = np.random.default_rng(0).integers(-3000, 3000, (120 * RATE, 2), np.int16)
    soundfile.write(tmp_path / "noise.wav", noise, RATE)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        busy = taken.getsockname()[1]
        (tmp_path / "ross.toml").write_text(PAYLOAD.format(port=port, pcm=pcm, busy=busy, absent=absent))
        with (
            process(["run", "ross.toml"], tmp_path, "payload"),
            ground_station(port) as ground,
            contextlib.closing(Listener(pcm)) as listener,
        ):
            assert wait_for(lambda: ground.latest.get("HEARTBEAT"))
            assert ground.order(EXPLORE) == 0
            wait_for(lambda: len(ground.streams) == 4 and ground.streams[0].listeners == 1)
            told = dict(ground.streams)
            assert ground.order(STREAM, 0, 0) == 0
            wait_for(lambda: listener.over)
    samples, (begin, first) = listener.samples, listener.arrivals[0]
    heard = noise[:, 0].astype(np.float32) / 2**15
    starts = np.flatnonzero(np.abs(heard[: 60 * RATE] - samples[0]) < 1e-6)
    off = min(np.abs(heard[start : start + len(samples)] - samples).max() for start in starts)
    assert off < 2**-22  # nothing is lost
    late = [when - begin - (count - first) / RATE for when, count in listener.arrivals]
    assert max(late) - min(late) < LATE_S
    faults = (
        "noise.wav/target.flac: cannot be made: ",
        f"tcp:127.0.0.1:{busy}: cannot listen: Address already in use",
        f"tcp:127.0.0.1:{absent}: no listener: Connection refused",
    )
    for number, fault in enumerate(faults, start=1):
        assert told[number].detail
        assert fault.endswith(told[number].detail) or fault.endswith(": ")  # the cause; the log has all
    log = (tmp_path / "payload.log").read_text()
    assert f"stream 0 (mixture to tcp {pcm}) begins" in log
    assert f"stream 0 (mixture to tcp {pcm}) ends: ordered" in log
    assert [log.count(fault) for fault in faults] == [1, 1, 1]
    assert "Traceback" not in log
