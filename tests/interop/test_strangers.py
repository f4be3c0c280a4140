"""A payload in another process, whose signed port strangers talk to without end: its station misses nothing."""

import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

import strangers
from strangers import Station, key_file

NOISE = """
import sys, time
sys.path.insert(0, sys.argv[1])
from strangers import Strangers
host, port, rate, seconds = sys.argv[2], int(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5])
strangers, begin, said = Strangers((host, port)), time.monotonic(), 0
while (now := time.monotonic() - begin) < seconds:
    count = int(now * rate) - said
    strangers.say(count)
    said += count
    time.sleep(0.005)
print(strangers.heard())
"""


class Counting(Station):
    """A station that speaks ten times a second and counts what it is told."""

    def messages(self, seconds, where):
        """Say once in 0.1 s that we are here; return how many messages came in so many seconds."""
        before, end = self.listen(), time.monotonic() + seconds
        while time.monotonic() < end:
            self.sock.sendto(self.frame(), where)
            time.sleep(0.1)
            self.listen()
        return self.listen() - before


@pytest.mark.soak
@pytest.mark.parametrize("rate", [50, 200, 1000])
def test_a_signed_station_is_told_everything_while_strangers_talk(ross_run, free_port, tmp_path, rate):
    where, seconds = ("127.0.0.1", free_port()), 15.0
    key_file(tmp_path)
    with ExitStack() as stack:
        stack.enter_context(ross_run(tmp_path, f'url = "udpin:127.0.0.1:{where[1]}"\nkey_file = "key"'))
        station = Counting(time.time())
        stack.callback(station.sock.close)
        quiet = station.messages(seconds, where)
        command = [sys.executable, "-c", NOISE, Path(strangers.__file__).parent, *map(str, (*where, rate, seconds + 1))]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as noise:
            among = station.messages(seconds, where)
            leaked = int(noise.communicate()[0])
    print(f"{rate} strange datagrams/s: {among / seconds:.1f} messages/s, {quiet / seconds:.1f} without")  # noqa: T201
    assert among >= 0.9 * quiet
    assert leaked == 0
