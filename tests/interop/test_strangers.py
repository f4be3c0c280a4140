"""A payload in another process with a signed port: what strangers and a full disk leave to who has the key."""

import subprocess
import sys
import time
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

import strangers
from full_disk import lose
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.dialect import common
from strangers import STOP, Station, key_file
from waiting import wait_for

EXPLORE = 54000
ACCEPTED, DENIED, IN_PROGRESS = 0, 2, 5

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


class Operator(Station):
    """A station whose commands are answered."""

    def __init__(self, unix, where):
        super().__init__(unix)
        self._where, self._answers, self.texts = where, Decoder(), []

    def command(self, number, seconds=20.0):
        """Send a command once; return its last answer, None when there is none."""
        self.sock.sendto(self.frame(common.MAVLink_command_long_message(1, 191, number, 0, *[0.0] * 7)), self._where)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for result in self.results(number):
                if result != IN_PROGRESS:
                    return result
            time.sleep(0.002)
        return None

    def results(self, number):
        """Take in what has arrived; return the answers to a command."""
        found = []
        with suppress(BlockingIOError):
            while True:
                for packet in self._answers.feed(self.sock.recv(2048)):
                    if packet.name == "COMMAND_ACK" and packet.message.command == number:
                        found.append(packet.message.result)
                    elif packet.name == "STATUSTEXT":
                        self.texts.append(packet.message.text)
        return found


def test_a_full_disk_leaves_the_stop_to_a_signed_link_and_refuses_the_rest_aloud(ross_run, free_port, tmp_path):
    where = ("127.0.0.1", free_port())
    key_file(tmp_path)
    with ross_run(tmp_path, f'url = "udpin:127.0.0.1:{where[1]}"\nkey_file = "key"') as payload, ExitStack() as stack:
        lose(tmp_path / "state" / "signing-time")
        ahead = Operator(time.time() + 90, where)  # beyond what is saved
        stack.callback(ahead.sock.close)
        assert [ahead.command(STOP) for _ in range(20)] == [ACCEPTED] * 20
        wait_for(lambda: any(line.startswith("stopped") for line in payload.lines()))
        wait_for(lambda: ahead.command(EXPLORE, 0.2) == DENIED)
        said = "signing-time: Is a directory"
        wait_for(
            lambda: ahead.results(0) or (said in "".join(ahead.texts) and "explore refused" in "".join(ahead.texts))
        )
        assert (tmp_path / "state" / "stopped").exists()
