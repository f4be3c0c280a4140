"""Ports of this computer for tests."""

import socket


def free_port(kind: int = socket.SOCK_DGRAM) -> int:
    """Tell a port of the loopback that nobody has now: UDP's, or TCP's with ``socket.SOCK_STREAM``."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
