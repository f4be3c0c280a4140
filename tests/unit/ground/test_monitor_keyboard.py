"""The keys of the monitor on a pseudo terminal of the test."""

import asyncio
import os
import pty
import termios

import pytest

from ross_payload.ground.terminal.keyboard import Keyboard


@pytest.fixture
def terminal():
    master, slave = pty.openpty()
    yield master, slave
    for file in (master, slave):
        try:
            os.close(file)
        except OSError:
            continue  # a test has closed it


async def listen(slave, act):
    """Run a keyboard while ``act`` does something; the keys that came, and how often it was told that it is alone."""
    pressed, gone = [], []
    async with asyncio.timeout(20):
        with Keyboard(slave, pressed.append, lambda: gone.append(True)):
            await act(pressed)
    return pressed, len(gone)


async def test_every_key_is_told_at_once(terminal):
    master, slave = terminal

    async def act(pressed):
        os.write(master, b"s\x1b[D")
        while len(pressed) < 2:
            await asyncio.sleep(0.01)

    assert await listen(slave, act) == (["s", "left"], 0)


async def test_a_key_that_is_taken_away_before_it_is_read_holds_nothing_up(terminal):
    """As Ctrl-C does: the loop has seen that there is a key, and finds none."""
    master, slave = terminal

    async def act(pressed):
        loop = asyncio.get_running_loop()
        for _ in range(3):
            os.write(master, b"x")
            ready = loop._selector.select(1)
            termios.tcflush(slave, termios.TCIFLUSH)
            loop._process_events(ready)
            await asyncio.sleep(0.02)
        os.write(master, b"q")
        while not pressed:
            await asyncio.sleep(0.01)

    assert await listen(slave, act) == (["q"], 0)


async def test_ctrl_s_and_ctrl_z_are_keys_and_nothing_stands_still(terminal):
    master, slave = terminal

    async def act(pressed):
        os.write(master, b"\x13\x1a")
        while len(pressed) < 2:
            await asyncio.sleep(0.01)
        await asyncio.wait_for(asyncio.to_thread(os.write, slave, b"drawn"), 5)

    assert await listen(slave, act) == (["\x13", "\x1a"], 0)
    assert os.read(master, 100) == b"drawn"


async def test_a_terminal_that_is_closed_is_told_once_and_nothing_spins(terminal):
    master, slave = terminal

    async def act(pressed):
        os.close(master)
        await asyncio.sleep(0.3)

    assert await listen(slave, act) == ([], 1)


async def test_the_terminal_is_left_as_it_was(terminal):
    _, slave = terminal
    before = termios.tcgetattr(slave)

    async def act(pressed):
        assert termios.tcgetattr(slave) != before

    await listen(slave, act)
    assert termios.tcgetattr(slave) == before
