"""How the payload itself is: who it is, its links, its microphones, its recorder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ross_payload.clock import Every
from ross_payload.health import AudioHealth, AudioTrouble, RecordingStatus
from ross_payload.mavlink import LinkStatus
from ross_payload.mavlink.message_board import Board, Rank
from ross_payload.telemetry import status_texts
from ross_payload.telemetry.computer import PERIOD
from ross_protocols.mavlink.computer import Computer, computer_message
from ross_protocols.mavlink.values import Audio, Information, LinkReport, Recording, RecordingState, Severity

OVER_S = 10.0  # [s] without a trouble until it is said to be over: a talker who clips now and then fills no screen


class HealthReport:
    """Puts the condition of the payload on the board and says what changes.

    ``audio``, ``recording`` and ``computer`` tell how these are; None: nothing is said of them.
    """

    def __init__(
        self,
        board: Board,
        send_text: Callable[[Severity, str], None],
        audio: Callable[[], AudioHealth] | None,
        recording: Callable[[], RecordingStatus] | None,
        computer: Callable[[], Computer] | None = None,
    ) -> None:
        self._board = board
        self._send_text = send_text
        self._ask_audio = audio
        self._ask_recording = recording
        self._ask_computer = computer
        self._looking = Every(PERIOD)
        self._health = AudioHealth()
        self._seen: dict[AudioTrouble, float] = {}  # when every trouble of the microphones was there last [s]
        self._said = AudioTrouble.NONE  # what the operator believes of them
        self._recording = RecordingStatus()

    @property
    def health(self) -> AudioHealth | None:
        """How the microphones are; None: nobody watches them."""
        return None if self._ask_audio is None else self._health

    @property
    def recording(self) -> bool:
        """Whether the recorder records."""
        return RecordingState[self._recording.state.name] is RecordingState.ON

    def look(self, information: Information, links: Sequence[LinkStatus], now: float) -> None:
        """Look at everything at ``now`` [s]; ``information`` is who we are at this moment."""
        self._board.put(Rank.INFORMATION, [information])
        self._board.put(Rank.LINK, reports(links, information.time_usec))
        if self._ask_audio is not None:
            self._listen(self._ask_audio(), information.time_usec, now)
        if self._ask_recording is not None:
            self._record(self._ask_recording(), information.time_usec)
        if self._ask_computer is not None and self._looking.due(now):
            self._board.put(Rank.COMPUTER, [computer_message(self._ask_computer(), information.time_usec)])

    def _listen(self, health: AudioHealth, time_usec: int, now: float) -> None:
        told = Audio(
            time_usec, int(health.trouble), health.level_db, health.peak_db, health.lost, health.reopened,
            health.waiting, health.rate,
        )  # fmt: skip
        self._seen |= dict.fromkeys(health.trouble, now)
        lately = AudioTrouble(sum(each for each, last in self._seen.items() if now - last < OVER_S))
        said = status_texts.microphone_text(replace(health, trouble=self._said), replace(health, trouble=lately))
        self._said = lately
        (self._board.put if said is None else self._board.announce)(Rank.AUDIO, [told])
        if said is not None:
            self._send_text(*said)
        self._health = health

    def _record(self, status: RecordingStatus, time_usec: int) -> None:
        free = None if status.free_gb is None else status.free_gb * 1e9
        state = RecordingState[status.state.name]
        told = Recording(time_usec, state, status.seconds, free, status.name, status.reason)
        said = status_texts.recorder_text(self._recording, status)
        (self._board.put if said is None else self._board.announce)(Rank.RECORDING, [told])
        if said is not None:
            self._send_text(*said)
        self._recording = status


def reports(links: Sequence[LinkStatus], time_usec: int) -> list[LinkReport]:
    """Return one value per link."""
    return [
        LinkReport(
            time_usec, index, len(links), link.url, link.up, link.role == "autopilot", link.sent, link.dropped,
            link.received, link.lost, link.bad, link.refused, link.reconnects,
        )
        for index, link in enumerate(links)
    ]  # fmt: skip
