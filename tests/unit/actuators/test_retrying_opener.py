"""A server that is started after its client is waited for; nothing else is."""

import pytest

from ross_payload.clock import RetryingOpener
from ross_payload.errors import LinkError
from ross_sim.clock import SimClock


class Server:
    """Refuses connections until a time, and whatever else is wanted."""

    def __init__(self, clock, until, cause=ConnectionRefusedError):
        self.clock, self.until, self.cause, self.attempts = clock, until, cause, 0

    def open(self, url):
        self.attempts += 1
        if self.clock.now() < self.until:
            raise LinkError(f"{url}: cannot connect") from self.cause()
        return url


def opener_of(server, timeout):
    return RetryingOpener(server.open, server.clock, timeout)


def test_a_refused_connection_is_tried_again_until_the_server_is_there():
    server = Server(SimClock(), until=3.0)
    assert opener_of(server, 10.0)("tcp:here:1") == "tcp:here:1"
    assert server.clock.now() == pytest.approx(3.0, abs=0.11)


def test_the_wait_ends():
    server = Server(SimClock(), until=100.0)
    with pytest.raises(LinkError, match="cannot connect"):
        opener_of(server, 10.0)("tcp:here:1")
    assert server.clock.now() == pytest.approx(10.0, abs=0.11)


@pytest.mark.parametrize("cause", [TimeoutError, OSError, ValueError])
def test_another_error_is_not_waited_for(cause):
    server = Server(SimClock(), until=3.0, cause=cause)
    with pytest.raises(LinkError):
        opener_of(server, 10.0)("tcp:here:1")
    assert (server.attempts, server.clock.now()) == (1, 0.0)


def test_what_was_open_once_is_opened_again_without_waiting():
    server = Server(SimClock(), until=0.0)
    again = opener_of(server, 10.0)
    again("tcp:here:1")
    server.until = 5.0
    with pytest.raises(LinkError):
        again("tcp:here:1")
    assert server.clock.now() == 0.0
