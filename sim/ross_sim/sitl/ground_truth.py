"""What a live world knows and the payload does not, written while it lives."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, ExitStack
from typing import Any

import numpy as np

from ross_payload.audio.audio_files import WavWriter
from ross_payload.interfaces import Real
from ross_sim.clock import QUANTUM
from ross_sim.scenario import Cast, Scenario
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.world import Rendered

STILL = 1e-6  # a quantum that turns by less is not worth a line [rad]


class TruthWriter(AbstractContextManager["TruthWriter"]):
    """Writes `mixture.wav`, one `image-K.wav` per talker and, in the end, `truth.json`. A context manager.

    Parameters
    ----------
    out
        Where to; None: nowhere.
    rate
        Sampling rate [Hz].
    n_talkers
        How many images there are.
    """

    def __init__(self, out: ResultsFolder | None, rate: int, n_talkers: int) -> None:
        self._out = out
        self._files = ExitStack()
        self._turns = Turns()
        self._samples = 0
        names = ["mixture.wav", *(f"image-{index}.wav" for index in range(n_talkers))] if out is not None else []
        self._writers = [
            self._files.enter_context(WavWriter(out.staging / name, rate, channels=2)) for name in names if out
        ]

    def write(self, rendered: Rendered) -> None:
        """Write a stretch.

        Raises
        ------
        OutputError
            When the disk is full or gone.
        """
        if self._out is None:
            return
        self._samples += rendered.mixture.shape[1]
        self._turns.follow(rendered.headings)
        tracks = [rendered.mixture, *rendered.images.swapaxes(0, 1)]
        for writer, track in zip(self._writers, tracks, strict=False):
            writer.write(track)

    def finish(self, values: dict[str, Any], scenario: Scenario | None = None) -> None:
        """Write `truth.json`: ``values``, how many samples there are, and every turn; and where who moves was."""
        self._files.close()
        if self._out is not None:
            if scenario is not None:
                write_azimuths(self._out, scenario, self._samples)
            told = values | {"samples": self._samples, "headings_deg": self._turns.points()}
            self._out.write_json("truth.json", told)

    def __exit__(self, *exception: object) -> None:
        self._files.close()


class Turns:
    """The true heading as a broken line, with points only where it turns.

    >>> import numpy as np
    >>> turns = Turns()
    >>> turns.follow(np.radians([5, 5, 5, 6, 7, 7, 7]))
    >>> turns.points()
    [[0.0, 5.0], [0.02, 5.0], [0.03, 6.0], [0.04, 7.0], [0.06, 7.0]]
    """

    def __init__(self) -> None:
        self._points: list[list[float]] = []
        self._index = 0  # of the newest heading
        self._last = math.nan
        self._still = False

    def follow(self, headings: Real) -> None:
        """Take headings at the ends of quanta [rad]; the first is that of the last end of the stretch before."""
        if len(headings) and not self._points:
            self._note(0, float(headings[0]))
        for heading in headings[1:]:
            still = abs(float(heading) - self._last) < STILL
            if not still:
                if self._still:
                    self._note(self._index, self._last)
                self._note(self._index + 1, float(heading))
            self._index, self._still = self._index + 1, still

    def points(self) -> list[list[float]]:
        """Return times since the beginning of the sound [s] and headings [deg], mount frame."""
        end = [[self._time(self._index), self._points[-1][1]]] if self._still else []
        return [*self._points, *end]

    def _note(self, index: int, heading: float) -> None:
        self._last = heading
        self._points.append([self._time(index), round(math.degrees(heading), 4)])

    @staticmethod
    def _time(index: int) -> float:
        return round(index * QUANTUM, 2)


def write_azimuths(out: ResultsFolder, scenario: Scenario, samples: int) -> None:
    """Write `azimuths.csv` when somebody moves: the time [s] and true azimuths [deg] at the end of every hop.

    Azimuths are counter-clockwise in the frame of the mount and not wrapped: who walks round twice passes 720.
    """
    if not any(walk.moves for walk in scenario.walks()):
        return
    config = scenario.payload
    times = np.arange(config.hop, samples + 1, config.hop) / config.audio.rate_hz
    azimuths = np.degrees(scenario.azimuths_at(times)).T
    rows = [
        f"{time:.3f},{','.join(f'{azimuth:.3f}' for azimuth in row)}" for time, row in zip(times, azimuths, strict=True)
    ]
    names = [f"talker_{index}_deg" for index in range(len(scenario.talkers))]
    out.write_text("azimuths.csv", "\n".join([",".join(["time_s", *names]), *rows, ""]))


def facts(scenario: Scenario, cast: Cast) -> dict[str, Any]:
    """Return who talks where, as plain values."""
    people = zip(cast.talkers, scenario.azimuths(), scenario.elevations(), strict=True)
    return {
        "title": scenario.title,
        "rate_hz": scenario.payload.audio.rate_hz,
        "seed": scenario.payload.seed,
        "target": cast.target.name,
        "talkers": [
            {"name": voice.name, "azimuth_deg": _degrees(azimuth), "elevation_deg": _degrees(elevation)}
            for voice, azimuth, elevation in people
        ],
    }


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 6)
