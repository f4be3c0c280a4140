"""Voice print: enrol a talker from a few seconds of speech, then tell how much another recording sounds alike.

::

    print_ = enrol(samples, rate)            # AudioError when there is too little to go by
    print_.score(voice, rate)                # Score(value [nat], accepted); 0 nat is undecided
    VoiceStore.default().save("ann", print_)

It serves to pick one voice out of a few that were just separated. It is no proof of identity.
"""

from ross_payload.voiceprint.built_in import BuiltInModel, built_in_model
from ross_payload.voiceprint.embedding_print import EmbeddingPrint
from ross_payload.voiceprint.speaker_model import VoiceModel, enrol
from ross_payload.voiceprint.store import VoiceStore, load, save

__all__ = [
    "BuiltInModel", "EmbeddingPrint", "VoiceModel", "VoiceStore", "built_in_model", "enrol", "load",
    "save",
]  # fmt: skip
