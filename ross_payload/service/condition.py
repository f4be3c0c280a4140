"""How a payload is, in plain values, for whoever asks on its computer."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ross_payload import __version__
from ross_payload.events import Event, StateChanged
from ross_payload.health import AudioHealth, AudioTrouble, RecordingStatus
from ross_payload.interfaces import Input
from ross_payload.mavlink import LinkStatus


class Condition:
    """An observer of the mission that tells how the payload is.

    ``late`` tells who makes no progress; the others how microphones, recorder and links are.
    """

    def __init__(
        self,
        late: Callable[[], tuple[str, ...]],
        audio: Callable[[], AudioHealth],
        recording: Callable[[], RecordingStatus],
        links: Callable[[], Iterable[LinkStatus]],
    ) -> None:
        self._late = late
        self._audio = audio
        self._recording = recording
        self._links = links
        self._state, self._detail = "starting", ""

    def on_input(self, hop: Input) -> None:
        """Hops change nothing that is told."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Note the state of the mission."""
        if isinstance(event, StateChanged):
            self._state, self._detail = event.state.name.lower().replace("_", " "), event.detail

    def values(self) -> dict[str, Any]:
        """Return the values of this moment."""
        trouble = self._audio().trouble
        return {
            "version": __version__,
            "late": list(self._late()),
            "state": self._state,
            "detail": self._detail,
            "microphones": [str(each.name).lower().replace("_", " ") for each in AudioTrouble if each in trouble],
            "recording": str(self._recording().state),
            "links_down": [link.url for link in self._links() if not link.up],
        }
