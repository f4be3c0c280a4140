"""How sources sound here, learnt beside the frames: at once in simulated time, on a thread of its own live."""

from __future__ import annotations

import logging
import threading
from dataclasses import dataclass
from typing import Any, Protocol

from ross_payload.errors import PluginError
from ross_payload.interfaces import Complex, LiveSeparator, Scene

LAST_CALL_S = 2.0  # that what is being learnt may take at the end

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class LearningRequest:
    """What is to be learnt from."""

    stretch: int  # its number, by which the answer is told from that of an earlier one
    window: Complex  # (2, n_freqs, n_frames)
    scene: Scene
    before: Any  # what was learnt last in this stretch, or None


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What was learnt, or why nothing was."""

    stretch: int
    learnt: Any = None
    fault: str = ""


class Learner(Protocol):
    """Learns, one request at a time."""

    @property
    def idle(self) -> bool:
        """Whether a request would be begun."""

    def begin(self, request: LearningRequest) -> None:
        """Begin to learn."""

    def outcome(self) -> Outcome | None:
        """Return what was learnt since the last time that somebody asked."""

    def close(self) -> None:
        """End; idempotent."""


def learnt_from(separator: LiveSeparator, request: LearningRequest) -> Outcome:
    """Learn; what goes wrong in a separator of others is told."""
    try:
        learnt = separator.learn(request.window, request.scene, request.before)
    except PluginError as error:
        return Outcome(request.stretch, fault=str(error))
    return Outcome(request.stretch, learnt)


class ImmediateLearner:
    """Learns while the caller waits: the same on every computer."""

    idle = True

    def __init__(self, separator: LiveSeparator) -> None:
        self._separator = separator
        self._outcome: Outcome | None = None

    def begin(self, request: LearningRequest) -> None:
        """Learn."""
        self._outcome = learnt_from(self._separator, request)

    def outcome(self) -> Outcome | None:
        """Return what was learnt since the last time that somebody asked."""
        outcome, self._outcome = self._outcome, None
        return outcome

    def close(self) -> None:
        """Nothing goes on."""


class BackgroundLearner:
    """Learns on a thread of its own, which the first request starts."""

    def __init__(self, separator: LiveSeparator) -> None:
        self._separator = separator
        self._changed = threading.Condition()
        self._request: LearningRequest | None = None
        self._outcome: Outcome | None = None
        self._over = False
        self._thread: threading.Thread | None = None

    @property
    def idle(self) -> bool:
        """Whether a request would be begun."""
        return self._request is None

    def begin(self, request: LearningRequest) -> None:
        """Have it learnt."""
        with self._changed:
            self._request = request
            self._changed.notify()
        if self._thread is None:
            thread = threading.Thread(target=self._work, name="learning", daemon=True)
            try:
                thread.start()
            except RuntimeError as error:  # the system has none left: it is asked again with the next request
                log.warning("nothing is learnt of the voices: %s", error)
                self._request = None
            else:
                self._thread = thread

    def outcome(self) -> Outcome | None:
        """Return what was learnt since the last time that somebody asked."""
        outcome = self._outcome
        if outcome is not None:
            self._outcome = None
        return outcome

    def close(self) -> None:
        """End after the request that is being learnt."""
        with self._changed:
            self._over = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join(LAST_CALL_S)

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._over or self._request is not None)
                request = self._request
            if self._over or request is None:
                return
            outcome = learnt_from(self._separator, request)
            self._outcome, self._request = outcome, None
