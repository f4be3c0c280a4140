"""Recorded sessions as a ground station knows them, wherever they are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

from ross_payload.json_values import encodable


@dataclass(frozen=True, slots=True)
class Recording:
    """One recorded session."""

    name: str
    bytes: int
    seconds: float  # of audio
    state: str  # why it ended, in words
    running: bool


class RecordingStore(Protocol):
    """A folder of recorded sessions; every method may take its time, on any thread."""

    @property
    def folder(self) -> Path:
        """Where they are kept."""

    def recordings(self) -> Sequence[Recording]:
        """Return all of them, the oldest first."""

    def files(self, name: str) -> Mapping[str, Path]:
        """Return the files of one by their names; LookupError: there is no such recording."""

    def delete(self, name: str) -> None:
        """Delete one; LookupError: there is no such recording; GroundError: why it stays."""


def described(store: RecordingStore) -> dict[str, Any]:
    """Return the folder and what is in it, as the page tells them."""
    return {"folder": encodable(str(store.folder.absolute())), "known": [asdict(each) for each in store.recordings()]}
