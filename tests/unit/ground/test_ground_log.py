"""The log of a ground station: whole, private, never written over, and no reason to stop."""

import resource
from datetime import UTC, datetime
from pathlib import Path

import pytest
from pymavlink import mavutil

from ports import free_port
from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.tlog import MAX_WAITING_BYTES, BufferedTlog
from ross_payload.ground.station import Station
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.commands import long_message
from ross_protocols.mavlink.component_id import ComponentId
from station_bench import AUDIO, BEAT, Far
from waiting import wait_for_async

TODAY = 1_795_000_000.0  # UNIX [s]
NAME = datetime.fromtimestamp(TODAY, UTC).strftime("%Y%m%dT%H%M%SZ")
FRAME = Encoder(1, 191).encode(BEAT)


def records(path: Path) -> list[tuple[float, int, str]]:
    """Read a log with pymavlink: time [s], component, name."""
    log = mavutil.mavlink_connection(str(path), dialect="common")
    found = []
    while (message := log.recv_match()) is not None:
        found.append((message._timestamp, message.get_srcComponent(), message.get_type()))
    log.close()
    return found


async def test_pymavlink_reads_all_that_was_heard_and_sent_with_its_time(tmp_path: Path) -> None:
    port, clock = free_port(), [TODAY]
    async with Station([f"udpin:127.0.0.1:{port}"], log=tmp_path / "logs", unix=lambda: clock[0]) as station:
        with Far(port) as payload:
            payload.say(BEAT)
            await wait_for_async(lambda: station.links()[0].frames)
            clock[0] += 12.5
            station.send(long_message(54004, [0.0] * 7, ComponentId(1, 191), 0), ComponentId(1, 191))
    (path,) = (tmp_path / "logs").iterdir()
    assert path.name == f"{NAME}.tlog"
    assert path.stat().st_mode & 0o777 == 0o600
    found = records(path)
    assert (TODAY, 191, "HEARTBEAT") in found
    assert (TODAY, 190, "HEARTBEAT") in found
    assert (TODAY + 12.5, 190, "COMMAND_LONG") in found


async def test_what_is_refused_is_not_in_the_log(tmp_path: Path) -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"], key=bytes(32), log=tmp_path) as station:
        with Far(port) as payload:
            payload.say(BEAT)
            await wait_for_async(lambda: station.links()[0].refused)
    (path,) = tmp_path.iterdir()
    assert {component for _, component, _ in records(path)} == {190}


async def test_the_log_is_on_the_disk_while_the_station_goes_on(tmp_path: Path) -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"], log=tmp_path):
        with Far(port) as payload:
            payload.say(AUDIO)
            (path,) = tmp_path.iterdir()
            await wait_for_async(lambda: b"\xfd" in path.read_bytes())


async def test_a_log_is_never_written_over(tmp_path: Path) -> None:
    (tmp_path / f"{NAME}.tlog").write_text("mine")

    log = BufferedTlog(tmp_path, TODAY)
    log.add(TODAY, FRAME, 0)
    await log.close()
    await log.close()
    assert log.path.name == f"{NAME}-2.tlog"
    assert (tmp_path / f"{NAME}.tlog").read_text() == "mine"


async def test_the_link_stands_in_the_lowest_bits_of_the_time(tmp_path: Path) -> None:
    log = BufferedTlog(tmp_path, TODAY)
    log.add(TODAY, FRAME, 2)
    await log.close()
    assert log.path.read_bytes() == (round(TODAY * 1e6) | 2).to_bytes(8, "big") + FRAME


async def test_a_full_disk_ends_the_log_with_whole_records_and_words_and_the_station_goes_on(tmp_path: Path) -> None:
    room, usual = 1000, resource.getrlimit(resource.RLIMIT_FSIZE)

    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, usual[1]))
        port = free_port()
        async with Station([f"udpin:127.0.0.1:{port}"], log=tmp_path) as station:
            with Far(port) as payload:
                for number in range(100):
                    payload.say(BEAT)
                    await wait_for_async(lambda number=number: station.links()[0].frames == number + 1)
                await wait_for_async(lambda: "the log has ended: File too large" in station.advice())
                payload.say(BEAT)
                await wait_for_async(lambda: station.links()[0].frames == 101)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    (path,) = tmp_path.iterdir()
    assert room / 2 < path.stat().st_size <= room
    assert path.stat().st_size == sum(8 + 21 for _ in records(path))


async def test_a_disk_that_hangs_does_not_fill_the_memory(tmp_path: Path) -> None:
    log = BufferedTlog(tmp_path, TODAY)
    for _ in range(MAX_WAITING_BYTES // len(FRAME)):
        log.add(TODAY, FRAME, 0)
    assert log.error.endswith("the log has ended: the disk is too slow")
    assert len(log._records) == 0
    await log.close()


async def test_a_folder_that_cannot_be_written_is_one_clear_line_and_no_port_stays_open(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("no folder")

    with pytest.raises(GroundError, match=rf"^--log {file}: cannot be written: File exists$"):
        async with Station([f"udpin:127.0.0.1:{free_port()}"], log=file):
            pass
