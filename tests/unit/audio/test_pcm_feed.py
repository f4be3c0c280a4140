"""Samples that come over TCP, evenly or not, and are taken as a clock asks for them."""

import re
import socket
import threading

import numpy as np
import pytest
import soundfile

from clocks import FakeClock
from examples import in_soak
from full_disk import fill
from ross_payload.audio.listener.pcm_feed import DELAY_S, FARTHEST_S, NEAR_S, PcmFeed
from ross_payload.audio.listener.playback import Meter, to_file
from ross_payload.errors import OutputError
from ross_protocols.audio.pcm import Header, encode, encode_header
from waiting import wait_for

RATE = 16000
TAKEN = 160  # samples at once: 10 ms
TIMES = np.arange(20 * RATE) / RATE
VOICE = (0.3 * np.sin(2 * np.pi * 170 * TIMES) * (1 + np.sin(2 * np.pi * 3.1 * TIMES)) / 2).astype(np.float32)


class Sender:
    """Sends as many samples as it is told, and waits until they are there."""

    def __init__(self):
        self.sent = 0

    def __enter__(self):
        with socket.create_server(("127.0.0.1", 0)) as door:
            greeting = threading.Thread(target=self._greet, args=(door,))
            greeting.start()
            self.feed = PcmFeed(door.getsockname())
            self.feed.__enter__()
            greeting.join()
        return self

    def _greet(self, door):
        self._line, _ = door.accept()
        self._line.sendall(encode_header(Header(RATE, 1, "f32le")))

    def __exit__(self, *exception):
        self.feed.__exit__()
        self._line.close()

    @property
    def waiting(self):
        """Samples that wait to be taken, to the millisecond."""
        return int(re.match(r"delay (\d+) ms here", self.feed.progress(0.0).words)[1]) * RATE // 1000

    @property
    def _lost(self):
        return int(re.search(r"lost (\d+) ms", self.feed.progress(0.0).words)[1]) * RATE // 1000

    def send(self, n):
        before = self.waiting + self._lost
        self._line.sendall(encode(VOICE[self.sent : self.sent + n, None], "f32le"))
        self.sent += n
        wait_for(lambda: self.waiting + self._lost >= before + n - RATE // 500)

    def take(self, n):
        """Take so many samples as a sound output does; return them."""
        return np.concatenate([self.feed.read(TAKEN) for _ in range(n // TAKEN)])


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
def test_a_disk_that_fills_while_it_is_written_is_one_line_and_keeps_what_was_heard(tmp_path, suffix):
    path, clock = tmp_path / f"heard{suffix}", FakeClock()
    with (
        Sender() as sender,
        pytest.raises(
            OutputError, match=r"heard\.\w+: cannot be written: (No space left on device|Input/output error)"
        ),
    ):
        sender.send(2 * RATE)
        with to_file(sender.feed, path, Meter(), clock) as pump:
            clock.sleep(1.0)
            pump()
            fill(path)
            clock.sleep(0.9)
            pump()
    kept = soundfile.read(path, dtype="float32")[0]
    assert len(kept) > 0.7 * RATE
    assert np.abs(kept - VOICE[: len(kept)]).max() < 2**-22


@pytest.mark.parametrize("lump", [160, 800, 1600, 3200])
def test_blocks_that_come_unevenly_change_no_sample(lump):
    with Sender() as sender:
        sender.send(max(lump, round(DELAY_S * RATE)))
        heard = []
        for _ in range(3 * RATE // lump):
            heard.append(sender.take(lump))
            sender.send(lump)
    heard = np.concatenate(heard)
    assert np.array_equal(heard, VOICE[: len(heard)])


@pytest.mark.parametrize("lump", [792, *in_soak(808)])
def test_a_sender_with_another_clock_is_followed(lump):
    """Every 50 ms come 1 % less, or more, than are taken."""
    with Sender() as sender:
        sender.send(round(DELAY_S * RATE))
        waited = []
        for _ in range(350):
            sender.take(800)
            sender.send(lump)
            waited.append(sender.waiting)
        words = sender.feed.progress(0.0).words
    assert "lost 0 ms, silent 0 ms" in words
    assert max(waited) < (DELAY_S + NEAR_S + 0.1) * RATE


def test_what_nobody_takes_for_long_is_lost_and_counted_and_the_newest_is_heard():
    with Sender() as sender:
        sender.send(3 * RATE)
        assert sender.waiting == FARTHEST_S * RATE
        heard = sender.take(TAKEN)
        assert ", lost 1000 ms" in sender.feed.progress(0.0).words
    assert np.array_equal(heard, VOICE[RATE : RATE + TAKEN])
