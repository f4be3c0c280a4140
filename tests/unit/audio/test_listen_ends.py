"""When ``ross listen`` ends: at the sender's goodbye, when nothing comes any more, or never, if it is to wait."""

import threading
from contextlib import nullcontext

import numpy as np
import pytest
import soundfile

from clocks import FakeClock
from command_line import called
from ross_payload.audio.listener.feed import Progress
from ross_payload.audio.listener.playback import Meter, listen, to_file
from ross_payload.audio.sinks import info_of
from ross_payload.errors import AudioError
from ross_payload.streams import LISTENER_TIMEOUT_S
from ross_payload.transport.rtp.receiver import RtpReceiver
from ross_payload.transport.rtp.session_description import Media
from voice_sender import RATE, block_at, ear, opened, talking
from waiting import wait_for


class Script:
    """A feed that is as a function of the time says."""

    where = "127.0.0.1 port 5004"

    def __init__(self, clock, progress):
        self._clock, self._progress = clock, progress

    def progress(self, wall):
        return self._progress(self._clock.now())


def listened(progress, **options):
    """Listen to a script; return when it ended [s], and the lines."""
    clock, lines = FakeClock(), []
    began = clock.now()
    feed = Script(clock, lambda now: progress(now - began))
    try:
        listen(
            feed, nullcontext(lambda: None), meter=Meter(), clock=clock, wall=clock.now, report=lines.append, **options
        )
    except AudioError as error:
        lines.append(f"error: {error}")
    return clock.now() - began, lines


def playing_until(end, **then):
    return lambda now: Progress(True, True, "well") if now < end else Progress(False, True, "the end", **then)


def test_a_goodbye_ends_it_and_is_one_line():
    ended, lines = listened(playing_until(2.5, ended=True), duration=None)
    assert ended == pytest.approx(2.5, abs=0.1)
    assert [line for line in lines if "the end" in line] == ["     3 s  the end"]


def test_a_sender_that_falls_silent_is_given_up():
    def progress(now):
        return Progress(now < 2, True, "well", silent_s=max(now - 2, 0.0))

    ended, lines = listened(progress, duration=None)
    assert ended == pytest.approx(2 + LISTENER_TIMEOUT_S, abs=0.1)
    assert lines[-1] == "error: nothing has come to 127.0.0.1 port 5004 for 25 s, and no end was said"
    assert lines[3].endswith("well; nothing comes")


@pytest.mark.parametrize("then", [{"ended": True}, {"silent_s": 100.0}])
def test_who_waits_goes_on_until_the_time_is_over(then):
    ended, lines = listened(playing_until(2.5, **then), duration=60, waits=True)
    assert ended == pytest.approx(60, abs=0.1)
    assert not any(line.startswith("error") for line in lines)
    assert lines[-1].endswith("waits for the next" if "ended" in then else "nothing comes")


def test_what_is_final_ends_who_waits_too():
    assert listened(playing_until(2.5, ended=True, final=True), duration=60, waits=True)[0] < 3


def test_before_anything_came_it_waits_for_the_first_sound():
    ended, lines = listened(lambda now: Progress(False, now > 100, "", ended=now > 101), duration=None)
    assert ended == pytest.approx(101, abs=0.1)
    assert lines[50].endswith("waits on 127.0.0.1 port 5004")


class Late:
    """A feed on which nothing comes for ten minutes, and then sound for two seconds."""

    where, rate = "here", RATE

    def __init__(self, clock):
        self._clock, self._began = clock, clock.now()

    def read(self, n):
        return np.full(n, 0.25, np.float32)

    def progress(self, wall):
        elapsed = self._clock.now() - self._began
        return Progress(elapsed > 600, elapsed > 600, "", ended=elapsed > 602)


def test_a_file_begins_with_the_first_sound(tmp_path):
    clock = FakeClock()
    feed, meter = Late(clock), Meter()
    place = to_file(feed, tmp_path / "heard.wav", meter, clock)
    listen(feed, place, meter=meter, clock=clock, wall=clock.now, report=lambda line: None, duration=None)
    samples, _ = soundfile.read(tmp_path / "heard.wav")
    assert samples.size / RATE == pytest.approx(2, abs=0.1)
    assert samples.min() > 0.2


def test_a_report_is_a_sign_of_life_while_no_sound_comes():
    receiver, now = RtpReceiver(Media.of("L16", RATE)), 0.0
    assert receiver.reception(100.0).silent_s == 0
    from ross_payload.audio.sinks.rtp_sender import RtpSender

    sender = RtpSender(RATE, Media.of("L16", RATE), 0)
    for packet in sender.packets(block_at(0, np.zeros(RATE))):
        receiver.on_datagram(packet, now)
    assert receiver.reception(7.0).silent_s == 7.0
    receiver.on_datagram(sender.report(7.0, 1e9), 7.0)
    assert receiver.reception(9.0).silent_s == 2.0


def test_the_goodbye_of_a_payload_ends_it(tmp_path, monkeypatch, capsys):
    with ear() as sock:
        port = sock.getsockname()[1]

    def talk():
        with opened(port, tmp_path) as sink, talking(sink):
            wait_for(lambda: info_of(sink).packets_lost is not None)  # it is heard, and says so

    talker = threading.Thread(target=talk)
    talker.start()
    code, said, _ = called(monkeypatch, capsys, "listen", f"rtp://:{port}", "--out", str(tmp_path / "heard.flac"))
    talker.join()
    assert code == 0
    last = said.splitlines()[-1]
    assert last.endswith("the sender has ended it")
    assert (tmp_path / "heard.flac").stat().st_size > 1000


def test_a_connection_cannot_be_waited_for(monkeypatch, capsys):
    code, _, complained = called(monkeypatch, capsys, "listen", "tcp://127.0.0.1:1", "--wait")
    assert code == 2
    assert "--wait: expected a stream of RTP, got tcp://127.0.0.1:1" in complained
