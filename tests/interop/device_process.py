"""Writes a voice to the sink ``device`` in real time, as the stage does, until its input ends; tells how that went.

``device_process.py DEVICE``: prints when sample 0 was heard [s, monotonic], and in the end how many blocks were
written. The log goes to the standard error.
"""

import logging
import sys
import threading
from pathlib import Path

from loudspeaker_voice import voice
from ross_payload.audio.sinks import SinkServices, checked_options, make_sink
from ross_payload.clock import SystemClock
from ross_payload.interfaces import VoiceBlock
from ross_payload.listening.sink_runner import ThreadedRunner

RATE, BLOCK = 16000, 160


def main():
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    clock, over, samples = SystemClock(), threading.Event(), voice()
    options = checked_options("device", {"device": sys.argv[1]}, "options")
    services = SinkServices(clock, RATE, 0, "target", Path())
    runner = ThreadedRunner("stream 0", lambda: make_sink("device", options, services), clock)
    threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()
    began, count = clock.now(), 0
    sys.stdout.write(f"{began}\n")
    sys.stdout.flush()
    while not over.is_set():
        place = count * BLOCK % len(samples)
        due = began + (count + 1) * BLOCK / RATE
        over.wait(max(due - clock.now(), 0))
        runner.write(VoiceBlock(samples[place : place + BLOCK], count * BLOCK, due - BLOCK / RATE))
        count += 1
    runner.close()
    runner.wait()
    sys.stdout.write(f"{count}\n")


main()
