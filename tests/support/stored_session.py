"""The sound of the stored session in tests/data, made again from its seed, and how that session was recorded.

Three talkers that no person is: bursts of noise from a seeded generator. Each microphone gets them with the delay that
the recorded heading has, by linear interpolation: additions and multiplications alone, so that the same samples come
out on every computer. ``python tests/support/stored_session.py FOLDER`` records a session like the stored one.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np

SEED, RATE, HOP = 5, 16000, 320
SPACING, SPEED = 0.1, 343.0  # of the array [m], of sound [m/s]
AZIMUTHS = tuple(map(math.radians, (20, 95, 160)))
LEAD = 16  # samples of every talker before the first one that is heard
GRID = 2.0**-23


def talkers(n):
    """What each says in the first ``n`` samples, (3, n + 2 * LEAD): nobody before 0.6 s, then one burst in two."""
    found = []
    for number in range(len(AZIMUTHS)):
        generator = np.random.Generator(np.random.PCG64([SEED, number]))
        noise = generator.integers(-1000, 1001, n + 2 * LEAD) / 8000
        smooth = (noise + np.roll(noise, 1) + np.roll(noise, 2)) / 2
        generator = np.random.Generator(np.random.PCG64([SEED, number, 1]))
        bursts = np.repeat(generator.integers(0, 2, n // 800 + 2), 800)[: n + 2 * LEAD]
        found.append(smooth * bursts * (np.arange(n + 2 * LEAD) > LEAD + 0.6 * RATE))
    return np.stack(found)


def samples(said, start, n, heading):
    """What the microphones hear from sample ``start`` on, (2, n) on the grid of 24 bits."""
    generator = np.random.Generator(np.random.PCG64([SEED, 100, start]))
    total = generator.integers(-8, 9, (2, n)) / 8000
    for speech, azimuth in zip(said, AZIMUTHS, strict=True):
        half = RATE * SPACING / SPEED * math.cos(azimuth - heading) / 2
        for microphone, delay in enumerate((half, -half)):  # a positive delay of arrival: microphone 2 leads
            whole = math.floor(-delay)
            part = -delay - whole
            first = LEAD + start + whole
            total[microphone] += (1 - part) * speech[first : first + n] + part * speech[first + 1 : first + n + 1]
    return (np.rint(total / GRID) * GRID).astype(np.float32)


def sound(inputs):
    """What the microphones heard in a session, (2, n); ``inputs`` is the text of its inputs.jsonl."""
    lines = [json.loads(line) for line in inputs.splitlines()]
    said = talkers(sum(line["n"] for line in lines))
    places = np.cumsum([0, *(line["n"] for line in lines)])
    blocks = [samples(said, int(at), line["n"], line["heading"][0]) for at, line in zip(places, lines, strict=False)]
    return np.concatenate(blocks, axis=1)


def record(folder):
    """Record a session in which an operator gives every kind of order."""
    from ross_payload import orders
    from ross_payload.config import Config
    from ross_payload.interfaces import Attitude, AudioBlock, Input, Score, VoicePrint
    from ross_payload.mission.live_session import Kit, Session
    from ross_payload.service.assemble import settings_of, tools_of
    from ross_payload.sessions.manifest import Beginning
    from ross_payload.sessions.recorder import Recorder
    from ross_payload.sessions.session_store import SessionStore

    class Voice(VoicePrint):
        """Accepts the loudest half of what it is asked."""

        def score(self, voice, rate):
            value = round(float(np.sqrt(np.mean(np.square(voice)))) * 100 - 2, 6)
            return Score(value, value > 0)

    config = Config.model_validate(
        {
            "audio": {"rate_hz": RATE, "hop_ms": 1000 * HOP // RATE, "frame": 512},
            "array": {"spacing_m": SPACING, "speed_of_sound_m_s": SPEED},
            "explore": {"lead_in_s": 0.5, "unit_s": 0.5, "min_rotations": 2, "max_rotations": 3},
            "exploit": {"check_s": 0.5, "run_s": 1.0, "max_restarts": 0, "separator": "gaussian"},
            "service": {"target": "nobody"},
            "recording": {"always": True, "min_free_gb": 0},
        }
    )
    wanted = [
        orders.MeasureNoise(0.4, number=1), orders.Explore(number=2), orders.ListenTo(1, number=3),
        orders.Set("EXP_UNIT", 0.6, number=4), orders.TurnTo(0.3, number=5), orders.Point(joint=-0.2, number=6),
        orders.Cancel(number=7), orders.ListenAt(math.radians(160), number=8), orders.Informed((0.35, 1.6), number=9),
        orders.Park(number=10), orders.Home(number=11), orders.Stop(number=12), orders.Park(number=13),
        orders.Rearm(number=14), orders.Seek(number=15), orders.Shutdown(number=16),
    ]  # fmt: skip
    said, joint, goal, moving = talkers(60 * RATE), 0.0, 0.0, 0
    with Recorder(
        SessionStore(folder),
        config.recording,
        lambda: Beginning("session", config, -3.0, 3.0, "nobody", session.memory),
    ) as recorder:
        voice = recorder.noting(Voice())
        session = Session(config, lambda now: Kit(settings_of(now, -3.0, 3.0), tools_of(now, voice)))
        mission, waits = session.mission(None), 0
        output = next(mission)
        try:
            for hop in range(60 * RATE // HOP):
                if output.goal is not None:
                    goal, moving = output.goal, 4
                if output.halt or output.stop:
                    goal, moving = joint, 0
                settled = moving == 0
                moving = max(moving - 1, 0)
                joint = joint if moving else goal
                waits = 0 if session.busy and not isinstance(wanted[0], (orders.Cancel, orders.Stop)) else waits + 1
                given, waits = ((wanted.pop(0),), 0) if waits > 4 and wanted else ((), waits)
                block = AudioBlock(samples(said, hop * HOP, HOP, joint), hop * HOP, hop * HOP / RATE)
                heard = Input(block, joint, joint, joint, settled, Attitude(0.0, known=False), orders=given)
                recorder.on_input(heard)
                output = mission.send(heard)
                for event in output.events:
                    recorder.on_event(event, heard)
        except StopIteration:
            pass


if __name__ == "__main__":
    record(Path(sys.argv[1]))
