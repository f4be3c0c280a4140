"""Serial links of the ground side over pseudo terminals: both ways, pulled out, at an unknown rate."""

import asyncio
import contextlib
import os
import pty
import sys
import termios
from pathlib import Path

import pytest

from ross_payload.ground.errors import GroundError
from ross_payload.ground.station import Station
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from station_bench import BEAT, FRAME, opened
from waiting import wait_for_async


async def test_serial_goes_both_ways_and_survives_being_pulled_out(tmp_path: Path) -> None:
    plug = tmp_path / "ttyUSB0"

    async with Station([f"serial:{plug}:57600"]) as station:
        await wait_for_async(lambda: "No such file" in station.links()[0].error)
        for life in (1, 2):
            far, near = pty.openpty()
            plug.symlink_to(os.ttyname(near))
            await wait_for_async(lambda: station.links()[0].up)
            os.close(near)
            os.write(far, FRAME)
            await wait_for_async(lambda life=life: station.links()[0].frames == life)
            assert (await _first(far)).name == "HEARTBEAT"
            plug.unlink()
            os.close(far)
            await wait_for_async(lambda: not station.links()[0].up)


async def _first(far: int) -> Packet:
    """Return the first packet that arrives at the far end of a pseudo terminal."""
    os.set_blocking(far, False)
    decoder = Decoder()
    while True:
        with contextlib.suppress(BlockingIOError):
            for packet in decoder.feed(os.read(far, 1000)):
                return packet
        await asyncio.sleep(0.01)


async def test_a_line_that_takes_nothing_drops_whole_frames() -> None:
    far, near = pty.openpty()
    async with Station([f"serial:{os.ttyname(near)}:57600"]) as station:
        await wait_for_async(lambda: station.links()[0].up)
        for _ in range(5000):
            station.send(BEAT)
        os.set_blocking(far, False)
        heard = bytearray()
        for _ in range(50):
            with contextlib.suppress(BlockingIOError):
                heard += os.read(far, 65536)
            await asyncio.sleep(0.01)
        decoder = Decoder()
        assert 10 < len(decoder.feed(bytes(heard))) < 5000
        assert decoder.bad == 0, "no frame was cut"
    os.close(near)
    os.close(far)


async def test_the_baud_rate_is_found_by_listening() -> None:
    far, near = pty.openpty()
    async with Station([f"serial:{os.ttyname(near)}:auto"]) as station:
        speaking = asyncio.create_task(_speak_at(far, termios.B115200))
        await wait_for_async(lambda: station.links()[0].error == "listens for a heartbeat at 57600 baud")
        await wait_for_async(lambda: station.links()[0].frames)
        assert station.links()[0].up
        assert termios.tcgetattr(near)[4] == termios.B115200
        speaking.cancel()
    os.close(near)
    os.close(far)


async def _speak_at(far: int, rate: int) -> None:
    """Beat while the near end has this rate, else make noise."""
    os.set_blocking(far, False)
    encoder = Encoder(1, 191)
    while True:
        frame = encoder.encode(BEAT)
        right = termios.tcgetattr(far)[4] == rate
        with contextlib.suppress(BlockingIOError):
            os.write(far, frame if right else bytes(byte ^ 0x5A for byte in frame))
        await asyncio.sleep(0.02)


async def test_a_device_is_ours_alone_and_its_dtr_stays_when_it_is_closed() -> None:
    far, near = pty.openpty()
    url = f"serial:{os.ttyname(near)}:57600"
    async with Station([url]) as station, Station([url]) as second:
        await wait_for_async(lambda: station.links()[0].up)
        await wait_for_async(lambda: second.links()[0].error == "Device or resource busy")
        assert not termios.tcgetattr(near)[2] & termios.HUPCL
    os.close(near)
    os.close(far)


async def test_what_is_connected_may_be_unplugged_while_its_rate_is_looked_for(tmp_path: Path) -> None:
    far, near = pty.openpty()
    plug = tmp_path / "ttyUSB0"
    plug.symlink_to(os.ttyname(near))
    async with Station([f"serial:{plug}:auto"]) as station:
        await wait_for_async(lambda: "listens" in station.links()[0].error)
        os.close(near)
        os.close(far)
        plug.unlink()
        await wait_for_async(lambda: "No such file" in station.links()[0].error)


async def test_serial_without_its_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(GroundError, match="pip install 'pyserial>="):
        await opened("serial:/dev/ttyUSB0:57600")
