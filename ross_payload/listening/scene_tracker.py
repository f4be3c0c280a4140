"""What live separation needs to know of the mission: who is where, whom it listens to, and when nothing can be heard.

All of it follows from the mission's events and from where the array points.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from ross_payload.angles import wrap
from ross_payload.config import Array
from ross_payload.dsp.steering import tdoa
from ross_payload.events import Estimate, Event, SourcesEstimated, SourcesTracked, State
from ross_payload.interfaces import Real
from ross_payload.mission_state import MissionState, reduce
from ross_payload.streams import Selection, What

NEAR = np.deg2rad(20.0)  # an azimuth that is asked for and a source within this are one
AWAY = np.deg2rad(6.0)  # the array may turn by so much, following its heading, before separation starts again
STEADY = np.deg2rad(2.0)  # a heading that has changed by less in the last frames is held, though the joint may turn
STEADY_FRAMES = 20  # about a third of a second
FAST = np.deg2rad(8.0)  # a turn by more within the frames that one frame overlaps cannot be followed
FAST_FRAMES = 8
QUIET = frozenset({State.LEAD_IN, State.NOISE})  # nobody is taken to talk
EXPLORING = QUIET | {State.EXPLORE_TURN, State.EXPLORE_LISTEN}
LISTENING = frozenset({State.CHECK, State.RUN})


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """Where the sources are as the array hears them."""

    tau: Real  # TDOAs [s], (n_sources,)
    stretch: int  # grows whenever separation has to start again: other sources, another heading
    still: bool = True  # at the heading at which the stretch began: what is heard can be learnt from


class SceneTracker:
    """Follows a mission; everything belongs to one thread.

    Parameters
    ----------
    array
        Spacing and speed of sound.
    """

    def __init__(self, array: Array) -> None:
        self._array = array
        self._mission = MissionState()
        self._estimate: Estimate | None = None
        self._earth = False  # the frame of its azimuths
        self._stretch = 0
        self._heading: float | None = None  # at the beginning of this stretch [rad]
        self._recent: deque[float] = deque(maxlen=STEADY_FRAMES)  # headings [rad]
        self._why = ""

    @property
    def quiet(self) -> bool:
        """Whether the mission measures the noise."""
        return self._mission.state in QUIET

    @property
    def n_sources(self) -> int:
        """K, 0 when nobody is known."""
        return 0 if self._estimate is None else self._estimate.k

    @property
    def why(self) -> str:
        """Why no voice can be separated, in words; empty: it can."""
        return self._why

    def on_event(self, event: Event, *, earth: bool) -> None:
        """Take what the mission says; ``earth`` tells the frame of its angles."""
        self._mission = reduce(self._mission, event)
        if isinstance(event, SourcesEstimated):
            self._estimate, self._earth, self._heading = event.estimate, earth, None
        elif isinstance(event, SourcesTracked):
            self._estimate, self._earth = event.estimate, earth

    def placement(self, heading: float, *, earth: bool, settled: bool) -> Placement | None:
        """Return where the sources are for an array that points to ``heading`` [rad]; None: nothing can be separated.

        A stretch begins at rest, or when the joint holds a heading on a base that yaws, and lasts as long as the array
        follows the heading that it began with, and through a slow turn, in which the TDOAs are followed, until the
        array is at rest again.
        """
        estimate, self._why = self._estimate, ""
        self._recent.append(heading)
        if self._mission.state in EXPLORING:
            self._why = "exploring"
        elif estimate is None or not estimate.k:
            self._why = "nobody is known"
        elif earth != self._earth:
            self._why = "azimuths: frame changed"
        if self._why or estimate is None:
            self._heading = None
            return None
        still = self._heading is not None and abs(wrap(heading - self._heading)) <= AWAY
        if not still and (settled or self._held()):
            self._heading, self._stretch, still = heading, self._stretch + 1, True
        elif not still and (self._heading is None or self._turned(FAST_FRAMES) > FAST):
            self._heading, self._why = None, "turning"
            return None
        array = self._array
        tau = tdoa(estimate.azimuths, heading, array.spacing_m, array.speed_of_sound_m_s, estimate.elevations)
        return Placement(tau, self._stretch, still)

    def _held(self) -> bool:
        """Whether the heading has hardly changed lately."""
        return len(self._recent) == STEADY_FRAMES and self._turned(STEADY_FRAMES) < STEADY

    def _turned(self, frames: int) -> float:
        """By how much the heading differs from those of the last frames, at most [rad]."""
        latest = list(self._recent)[-frames:]
        return float(max(abs(wrap(heading - latest[-1])) for heading in latest))

    def source_of(self, selection: Selection) -> tuple[int | None, str]:
        """Return which source of the estimate is meant, or None and why there is none."""
        estimate = self._estimate
        if estimate is None or not estimate.k:
            return None, "nobody is known"
        match selection.what:
            case What.TARGET:
                return self._target()
            case What.SOURCE if selection.source is not None and selection.source < estimate.k:
                return selection.source, ""
            case What.SOURCE:
                return None, f"there is no source {selection.source}"
            case What.AZIMUTH:
                return _nearest(estimate, selection.azimuth or 0.0)
        return None, ""

    def azimuth(self, source: int) -> float | None:
        """Return where a source of the estimate is [rad]."""
        known = self._estimate
        return known.sources[source].azimuth if known is not None and source < known.k else None

    def _target(self) -> tuple[int | None, str]:
        """Whom the mission has found, or while it checks somebody, who that is."""
        mission = self._mission
        if mission.target is not None and mission.target < self.n_sources:
            return mission.target, ""
        if mission.state in LISTENING and mission.alignment is not None:
            return mission.alignment.source, ""
        return None, "there is no target yet"


def _nearest(estimate: Estimate, azimuth: float) -> tuple[int | None, str]:
    away = [abs(wrap(source.azimuth - azimuth)) for source in estimate.sources]
    nearest = int(np.argmin(away))
    if away[nearest] > NEAR:
        return None, "nobody at this azimuth"
    return nearest, ""
