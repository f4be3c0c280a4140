"""What our node keeps over a restart: its unique id, the node id it had, and which ids it gave to others."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ross_payload.atomic_files import write_whole
from ross_payload.bounded_files import parsed_json, read_bounded, set_aside
from ross_protocols.dronecan.messages import UNIQUE

VERSION = 1
HIGHEST = 127  # node id
log = logging.getLogger(__name__)


class PersistentIds(AbstractContextManager["PersistentIds"]):
    """A file that is read at the start and written by a thread of its own. A context manager.

    Parameters
    ----------
    path
        The file; None: nothing is kept.
    rng
        Makes the unique id when there is none: 16 random bytes, which tell nobody what computer this is.
    """

    def __init__(self, path: Path | None, rng: np.random.Generator) -> None:
        self._path = path
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="dronecan")
        found = None if path is None else _found(path)
        self.unique_id = rng.bytes(UNIQUE) if found is None else found[0]
        self.node_id = 0 if found is None else found[1]  # 0: none was given yet
        self._table: dict[bytes, int] = {} if found is None else found[2]
        if found is None:
            self._save()

    @property
    def table(self) -> Mapping[bytes, int]:
        """The node id that was given to each unique id."""
        return MappingProxyType(self._table)

    def had(self, node_id: int) -> None:
        """Keep the node id that was given to us."""
        self.node_id = node_id
        self._save()

    def gave(self, unique_id: bytes, node_id: int) -> None:
        """Keep a node id that we gave."""
        self._table[unique_id] = node_id
        self._save()

    def _save(self) -> None:
        content = {
            "version": VERSION,
            "unique_id": self.unique_id.hex(),
            "node_id": self.node_id,
            "given": {unique_id.hex(): node_id for unique_id, node_id in self._table.items()},
        }
        if self._path is not None:
            try:
                self._writer.submit(_write, self._path, json.dumps(content, indent=1) + "\n")
            except RuntimeError as error:  # the system has no thread left: it is written with the next one
                log.warning("%s: cannot be written: %s", self._path, error)

    def __exit__(self, *exception: object) -> None:
        """Wait until all is in the file."""
        self._writer.shutdown()


def _write(path: Path, text: str) -> None:
    try:
        write_whole(path, text.encode())
    except OSError as error:
        log.warning("%s: cannot be written: %s; a restart will look like a new node", path, error.strerror)


def _found(path: Path) -> tuple[bytes, int, dict[bytes, int]] | None:
    """Read the file; one that cannot be used is put aside."""
    try:
        return _meant(parsed_json(read_bounded(path)))
    except FileNotFoundError:
        return None
    except OSError as error:
        why = f"cannot be read: {error.strerror}"
    except (ValueError, KeyError, TypeError, AttributeError):
        why = "damaged"
    log.warning("%s: %s; %s; other nodes take this payload for a new one", path, why, set_aside(path, "unreadable"))
    return None


def _meant(content: Any) -> tuple[bytes, int, dict[bytes, int]]:
    unique_id = bytes.fromhex(content["unique_id"])
    table = {bytes.fromhex(other): _id(number) for other, number in content["given"].items()}
    if content["version"] != VERSION or any(len(each) != UNIQUE for each in (unique_id, *table)):
        raise ValueError(f"version {content['version']}")
    return unique_id, _id(content["node_id"]), table


def _id(number: Any) -> int:
    if type(number) is not int or not 0 <= number <= HIGHEST:
        raise ValueError(f"node id {number!r}")
    return number
