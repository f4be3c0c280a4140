"""The voice print of a synthetic talker, kept with a session to the last bit; a person's is never written here."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.recording.memory import packed, unpacked
from ross_payload.voiceprint import VoicePrintModel, shipped_background
from ross_payload.voiceprint.background import Adapted

NAME = "voice.npz"


@dataclass(frozen=True, slots=True)
class Print:
    """What a print is made of beside the background model."""

    offsets: Real
    pitch_weights: Real
    seconds: float
    criterion: float
    background: str  # its fingerprint


def kept(model: VoicePrintModel) -> bytes:
    """Return the content of the file."""
    voice = model.voice
    return packed(
        Print(voice.offsets, voice.pitch_weights, model.seconds, model.criterion, model.background.fingerprint)
    )


def restored(path: Path) -> VoicePrintModel:
    """Read it again.

    Raises
    ------
    ConfigError
        When the file is damaged, or was made with another background model.
    """
    values, background = unpacked(path, Print), shipped_background()
    if values.background != background.fingerprint:
        raise ConfigError(f"{path.name}: made with another background model")
    return VoicePrintModel(Adapted(values.offsets, values.pitch_weights), values.seconds, background, values.criterion)
