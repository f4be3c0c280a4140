"""Voice print: enrol a talker from a few seconds of speech, then tell how much another recording sounds alike.

::

    print_ = enrol(samples, rate)            # AudioError when there is too little to go by
    print_.score(voice, rate)                # Score(value [nat], accepted); 0 nat is undecided
    VoiceStore.default().save("ann", print_)

It serves to pick one voice out of a few that were just separated. It is no proof of identity.
"""

from ross_payload.voiceprint.background import Background, VoicePrintModel, shipped_background
from ross_payload.voiceprint.speaker_model import EnrolledVoice, VoiceModel, enrol
from ross_payload.voiceprint.store import VoiceStore, load, save

__all__ = [
    "Background", "EnrolledVoice", "VoiceModel", "VoicePrintModel", "VoiceStore", "enrol", "load", "save",
    "shipped_background",
]  # fmt: skip
