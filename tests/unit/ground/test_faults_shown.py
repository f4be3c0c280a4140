"""What the page's program tells on its terminal."""

import os
import sys
from contextlib import contextmanager, suppress

import pytest

from ross_payload.ground.web.faults import Reporter, show, write_line


@contextmanager
def terminal(monkeypatch, room):
    """One that takes so many bytes more, and what reads it."""
    reads, writes = os.pipe()
    os.set_blocking(writes, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writes, bytes(4096))
    os.set_blocking(writes, True)
    with (
        os.fdopen(reads, "rb", buffering=0) as reader,
        os.fdopen(writes, "w") as stream,
        monkeypatch.context() as patch,
    ):
        reader.read(room)
        patch.setattr(sys, "stderr", stream)
        yield reader


@pytest.mark.timeout(20)
@pytest.mark.parametrize("write", [write_line, Reporter()])
def test_a_terminal_that_is_held_does_not_hold_up_the_page(monkeypatch, write):
    """As after Ctrl-S: it takes nothing until Ctrl-Q."""
    with terminal(monkeypatch, 0) as reader:
        write("nobody can read this")
        assert not any(reader.read(1 << 20))
        write_line("two  words")
        assert reader.read(100) == b"ross ground: two words\n"


@pytest.mark.timeout(20)
def test_a_traceback_longer_than_what_a_terminal_takes_does_not_hold_up_the_page(monkeypatch):
    lines = [f"line {number} of a traceback that is longer than most\n" for number in range(300)]
    with terminal(monkeypatch, 8192) as reader:
        show("".join(lines))
        told = reader.read(1 << 20).replace(b"\0", b"").decode()
    assert "".join(lines[:50]) in told
    assert "".join(lines).startswith(told)
