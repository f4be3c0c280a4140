"""A flight with sound: the results of a simulation, or a session folder, of which every time is known."""

import json
from dataclasses import replace

import numpy as np
import soundfile

from emulated_scene import status
from flight_logs import UNIX, record
from ross_protocols.mavlink.codec import Encoder

RATE = 16000
SECONDS = 4.0  # of the mixture, from the first sample of the payload's time on
HEARD_FROM = 2.0  # [s] of the target
CLICK = 3.5  # [s], in mixture and target
CLOCK_AT_START = 5.0  # of a session's first sample [s]
HEARD_AT_START = 3.0  # [s] of audio before that
LATE_S = (0.004, 0.02, 0.011)  # of telemetry, one after the other
PERIOD = 0.1


def mixture():
    """A tone of 500 Hz with a click, (n,)."""
    return _tone(500.0, SECONDS, CLICK)


def target(begin=HEARD_FROM):
    """A tone of 1000 Hz with a click, (n,)."""
    return _tone(1000.0, SECONDS - begin, CLICK - begin)


def simulated(folder):
    """Write what `ross sitl --out` leaves; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    _telemetry(folder / "mission.tlog", 0.0, 0)
    soundfile.write(folder / "mixture.wav", np.stack([mixture()] * 2, axis=1), RATE, "PCM_24")
    soundfile.write(folder / "target.wav", target(), RATE, "PCM_24")
    (folder / "report.json").write_text(json.dumps({"heard_from_s": HEARD_FROM}))
    return folder


def session(folder, *, unix=False):
    """Write what a recording of `ross run` leaves, with UNIX time or that of the computer; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    _telemetry(folder / "telemetry.tlog", CLOCK_AT_START, UNIX, unix=unix)
    soundfile.write(folder / "audio.wav", np.stack([mixture()] * 2, axis=1), RATE, "PCM_24")
    soundfile.write(folder / "target.flac", target(0.0), RATE, "PCM_16")
    first = {"index": round(HEARD_AT_START * RATE), "n": 320, "time": CLOCK_AT_START}
    (folder / "inputs.jsonl").write_text(json.dumps(first) + "\n")
    return folder


def _telemetry(path, clock, start, *, unix=False):
    """Write statuses; the first one is two periods after the first sample."""
    encoder, records = Encoder(1, 191), []
    for number in range(2, int(SECONDS / PERIOD)):
        time = clock + number * PERIOD
        late = LATE_S[number % len(LATE_S)]
        told = replace(status(time), mission_time=time - clock + HEARD_AT_START)
        if unix:
            told = replace(told, time_unix=True, time_usec=told.time_usec + UNIX)
        records.append(record(start + round((time + late) * 1e6), encoder.encode(told)))
    path.write_bytes(b"".join(records))


def _tone(hertz, seconds, click):
    samples = 0.3 * np.sin(2 * np.pi * hertz * np.arange(round(seconds * RATE)) / RATE)
    samples[round(click * RATE)] = 1.0
    return samples
