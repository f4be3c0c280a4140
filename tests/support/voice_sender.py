"""The sink ``rtp``, written to in real time."""

import socket
import threading
from contextlib import contextmanager

import numpy as np

from lossy_network import voiced
from ross_payload.audio.sinks import SinkServices, checked_options, make_sink
from ross_payload.clock import SystemClock
from ross_payload.interfaces import VoiceBlock

RATE = 16000
BLOCK = 160
CLOCK = SystemClock()


def opened(port, folder, **options):
    """Make the sink, to this computer."""
    asked = checked_options("rtp", {"address": "127.0.0.1", "port": port, **options}, "options")
    return make_sink("rtp", asked, SinkServices(CLOCK, RATE, 0, "target", folder))


@contextmanager
def ear(timeout=30.0):
    """Give a socket that packets can be sent to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(timeout)
        yield sock


def block_at(index, samples):
    """Make a block that was heard just now."""
    return VoiceBlock(samples.astype(np.float32), index, CLOCK.now())


@contextmanager
def talking(sink, voice=None):
    """Write to a sink in real time, over and over, until the end; give when sample 0 was heard."""
    voice = voiced(4.0, RATE) if voice is None else voice
    over, began = threading.Event(), CLOCK.now()

    def talk():
        index = 0
        while not over.is_set():
            place = index % (len(voice) // BLOCK * BLOCK)
            over.wait(max(began + (index + BLOCK) / RATE - CLOCK.now(), 0))
            sink.write(VoiceBlock(voice[place : place + BLOCK], index, began + index / RATE))
            index += BLOCK

    thread = threading.Thread(target=talk)
    thread.start()
    try:
        yield began
    finally:
        over.set()
        thread.join()
