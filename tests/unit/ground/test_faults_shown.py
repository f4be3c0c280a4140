"""What the page's program tells on its terminal."""

import os
import sys
from contextlib import suppress

import pytest

from ross_payload.ground.web.faults import Reporter, write_line


@pytest.mark.timeout(20)
@pytest.mark.parametrize("write", [write_line, Reporter()])
def test_a_terminal_that_is_held_does_not_hold_up_the_page(monkeypatch, write):
    """As after Ctrl-S: it takes nothing until Ctrl-Q."""
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
        patch.setattr(sys, "stderr", stream)
        write("nobody can read this")
        assert not any(reader.read(1 << 20))
        write_line("two  words")
        assert reader.read(100) == b"ross ground: two words\n"
