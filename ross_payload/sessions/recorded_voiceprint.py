"""The voice that a recorded mission looks for: enrolled here, kept with the session, or its recorded answers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clip, Real, Score, VoicePrint
from ross_payload.sessions.npz_memory import VOICE_FILE, restored_voice
from ross_payload.sessions.session_reader import RecordedSession
from ross_payload.voiceprint import VoiceModel, VoiceStore, built_in_model


class Unanswered(Exception):
    """The mission asks about a voice that nobody was asked about when it was recorded."""


@dataclass(frozen=True, slots=True)
class TargetVoice:
    """Whom the mission looks for, and how it is told."""

    voiceprint: VoicePrint | None
    how: str  # in words, empty: no target


class RecordedAnswers:
    """A voice print that repeats recorded answers, each after the same number of Inputs as then."""

    def __init__(self, scores: Iterator[tuple[int, Score]], inputs: Callable[[], int]) -> None:
        self._scores = scores
        self._inputs = inputs

    def score(self, voice: Real, rate: int) -> Score:
        """Return the next recorded answer.

        Raises
        ------
        Unanswered
            When this was not asked at this moment of the recording.
        """
        number, score = next(self._scores, (-1, None))
        if score is None or number != self._inputs():
            raise Unanswered("the voice print is not here, and its recorded answers end where the replay diverges")
        return score

    def score_clips(self, clips: Sequence[Clip], rate: int) -> Score:
        """Return the next recorded answer, as `score` does."""
        return self.score(clips[-1].samples, rate)


def target_voice(
    session: RecordedSession,
    store: VoiceStore,
    inputs: Callable[[], int],
    *,
    same: bool,
    model: Callable[[], VoiceModel] = built_in_model,
) -> TargetVoice:
    """Find whom a session looks for; ``same``: in the recorded configuration, where recorded answers serve.

    Prints are those of ``model``, which is asked for where one is needed; one that is kept with a session may also be
    of the built-in one.

    Raises
    ------
    ConfigError
        When the configuration is another one, and the voice is neither enrolled here with this model nor kept with the
        session.
    """
    name, kept = session.manifest.voice, session.path / VOICE_FILE
    synthetic = kept.exists()  # a person who is enrolled under this name is somebody else
    if not name:
        return TargetVoice(None, "")
    why = f"'{name}' is synthetic" if synthetic else f"no voice '{name}' is enrolled here"
    if name in store.names() and not synthetic:
        try:
            return TargetVoice(store.load(name, model()), f"the voice '{name}' as it is enrolled here")
        except ConfigError as error:  # with another model, or one that is not here
            if not same:
                raise
            why = str(error)
    if same:
        return TargetVoice(RecordedAnswers(iter(session.scores()), inputs), f"recorded answers: {why}")
    if synthetic:
        return TargetVoice(restored_voice(kept, model()), f"the synthetic voice '{name}', kept with the session")
    raise ConfigError(
        f"the target voice of the session is '{name}', which is not enrolled here: "
        "ross enroll it, or replay the recorded configuration"
    )
