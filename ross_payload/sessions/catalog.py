"""Recorded sessions as they are listed, on a terminal and on the ground's page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ross_payload.bounded_files import printable
from ross_payload.errors import ConfigError
from ross_payload.ground.errors import GroundError
from ross_payload.ground.recordings import Recording
from ross_payload.sessions.session_reader import RecordedSession
from ross_payload.sessions.session_store import FILES, SessionStore, StoredSession


class Catalog:
    """What the ground's page offers of a folder of sessions; see `ross_payload.ground.recordings.RecordingStore`."""

    def __init__(self, store: SessionStore) -> None:
        self._store = store

    @property
    def folder(self) -> Path:
        """Where they are kept."""
        return self._store.folder

    def recordings(self) -> Sequence[Recording]:
        """Return all of them, the oldest first."""
        return [described(kept) for kept in self._store.with_damaged()]

    def files(self, name: str) -> Mapping[str, Path]:
        """Return the files of one by their names.

        Raises
        ------
        LookupError
            When there is no such recording.
        """
        folder = self._kept(name).path
        paths = {file: folder / file for file in FILES}
        return {file: path for file, path in paths.items() if path.is_file() and not path.is_symlink()}

    def delete(self, name: str) -> None:
        """Delete one.

        Raises
        ------
        LookupError
            When there is no such recording.
        GroundError
            When it is being recorded, or cannot be deleted.
        """
        try:
            self._store.delete(self._kept(name))
        except ConfigError as error:
            raise GroundError(str(error)) from error

    def _kept(self, name: str) -> StoredSession:
        try:
            return self._store.find(name)
        except ConfigError as error:
            raise LookupError(name) from error


def described(kept: StoredSession) -> Recording:
    """Return what can be said of a session without reading all of it."""
    try:
        session = RecordedSession.open(kept.path)
        seconds, state = session.audio_length() / session.rate(), ended(session.manifest.end)
    except ConfigError as error:
        seconds, state = 0.0, printable(str(error))
    return Recording(kept.path.name, kept.bytes, seconds, "recording" if kept.running else state, kept.running)


def ended(reason: str | None) -> str:
    """Return how a session ended, in words.

    >>> ended("ended by order"), ended(None)
    ('ended by order', 'cut off')
    """
    return "cut off" if reason is None else printable(str(reason))
