"""The reporter: what the mission says and how things stand, put on the board.

It owns no port, no clock and no thread: values go to the board, texts to ``send_text``, time comes with every call.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ross_payload import events
from ross_payload.mavlink.message_board import Board, Rank
from ross_payload.mission_state import SAME_ANGLE, MissionState, is_same_fault, reduce
from ross_payload.telemetry import event_messages
from ross_payload.telemetry.event_messages import Stamp
from ross_payload.telemetry.snapshot import Snapshot
from ross_payload.telemetry.status_texts import line
from ross_protocols.mavlink import values

TRACKING_PERIOD = 0.5  # [s] at least between two announcements of sources that move


class Reporter:
    """Turns a mission into what there is to tell; one that lives through many tasks.

    ``sought``: a voice is enrolled from the beginning, and what is separated is compared with it.
    """

    def __init__(self, board: Board, send_text: Callable[[values.Severity, str], None], *, sought: bool = True) -> None:
        self._board = board
        self._send_text = send_text
        self.mission = MissionState(sought=sought)
        self._snapshot = Snapshot()
        self._fault = ""  # that was sent as a text
        self._densities: list[values.Density] = []
        self.sources: list[values.Source] = []  # of the latest estimate
        self._announced: list[values.Source] = []  # when they were announced last because they had moved
        self._tracked = -math.inf  # when that was, in mission time [s]
        self._alignments: list[values.Alignment] = []
        self._separations: list[values.Separation] = []
        self._beat()

    @property
    def status(self) -> values.Status:
        """The mission at a glance."""
        return event_messages.status(self.mission, self._snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """Take in how things stand."""
        if snapshot.settled:
            self.mission = replace(self.mission, goal=None)
        if snapshot.fault and not is_same_fault(snapshot.fault, self._fault):
            self._send_text(values.Severity.ERROR, f"fault: {snapshot.fault}")
        self._fault, self._snapshot = snapshot.fault, snapshot
        self._board.put(Rank.STATUS, [self.status])

    def handle(self, event: events.Event, snapshot: Snapshot) -> None:
        """Take in an event of the mission."""
        self._snapshot = snapshot
        self.mission = reduce(self.mission, event)
        self._learn(event, Stamp(snapshot.time_usec, snapshot.earth))
        text = line(event)
        if text is not None:
            self._send_text(*text)
        self._board.announce(Rank.STATUS, [self.status])

    def _learn(self, event: events.Event, stamp: Stamp) -> None:
        match event:
            case events.StateChanged():
                self._beat()
            case events.OrientationHeard():
                self._orient(event, stamp)
            case events.SourcesEstimated():
                self._estimate(event, stamp)
            case events.SourcesTracked():
                self._track(event, stamp)
            case events.SourcesReconsidered():
                self.sources = event_messages.reconsidered(self.sources, event, stamp)
                self._board.announce(Rank.SOURCE, self.sources)
            case events.AlignmentPlanned():
                self._alignments = event_messages.alignments(event, self.mission.plans, stamp)
                self._board.announce(Rank.ALIGNMENT, self._alignments)
                self._board.announce(Rank.ISOLATION, event_messages.isolations(event, self.mission.plans, stamp))
            case events.TurnStarted() if self.mission.state is events.State.ALIGN_TURN:
                here = [a for a in self._alignments if abs(a.joint - event.joint) < SAME_ANGLE]
                self._mark(here, values.CandidateState.TURNING)
            case events.Checked() | events.Separated():
                self._separate(event, stamp)
            case events.Enrolled():
                self._forget_target()

    def _orient(self, event: events.OrientationHeard, stamp: Stamp) -> None:
        if event.index == 0:
            self._densities = []
        self._densities += event_messages.densities(event, self.mission.explorations, stamp)
        self._board.announce(Rank.DENSITY, self._densities)

    def _estimate(self, event: events.SourcesEstimated, stamp: Stamp) -> None:
        axis = event_messages.common_axis(self.mission.headings)
        self.sources = event_messages.sources(event.estimate, self.mission.estimates, stamp, axis, event.final)
        self._alignments, self._separations = [], []  # they speak of the sources of an older estimate
        self._board.announce(Rank.SOURCE, self.sources)
        for rank in (Rank.ALIGNMENT, Rank.SEPARATION, Rank.ISOLATION):
            self._board.announce(rank, [])

    def _track(self, event: events.SourcesTracked, stamp: Stamp) -> None:
        """Tell where the sources are by now: at once when one of them has moved, but not with every event."""
        self.sources = event_messages.tracked(self.sources, event, stamp)
        moved = event_messages.moved(self._announced, self.sources)
        if moved and event.time - self._tracked >= TRACKING_PERIOD:
            self._announced, self._tracked = self.sources, event.time
            self._board.announce(Rank.SOURCE, self.sources)
        else:
            self._board.put(Rank.SOURCE, self.sources)

    def _separate(self, event: events.Checked | events.Separated, stamp: Stamp) -> None:
        compared = event.groups if self.mission.sought else ()
        self.sources = event_messages.scored(self.sources, compared, self.mission.target)
        self._board.announce(Rank.SOURCE, self.sources)
        if isinstance(event, events.Checked):
            tried = [a for a in self._alignments if a.source == event.candidate.source]
            self._mark(tried, event_messages.verdict(event))
        self._separations = event_messages.separations(event, self.mission, stamp, self._snapshot.criterion)
        self._board.announce(Rank.SEPARATION, self._separations)

    def _forget_target(self) -> None:
        """Tell no more who sounds like the target: another voice is enrolled, which nobody was compared with yet.

        Groups are told again without it: whoever listens keeps the latest of each.
        """
        self.sources = [replace(source, score=None, target=False) for source in self.sources]
        self._separations = [replace(each, score=None, accepted=False, target=False) for each in self._separations]
        self._board.announce(Rank.SOURCE, self.sources)
        self._board.announce(Rank.SEPARATION, self._separations)

    def _mark(self, changed: list[values.Alignment], state: values.CandidateState) -> None:
        self._alignments = [replace(a, state=state) if a in changed else a for a in self._alignments]
        self._board.announce(Rank.ALIGNMENT, self._alignments)

    def _beat(self) -> None:
        state = self.mission.state
        self._board.announce(
            Rank.HEARTBEAT, [values.Heartbeat(event_messages.health(state), int(state or events.State.IDLE))]
        )
