"""Enrol by pointing: turn to where one talker stands alone, separate, and make a voice print of what is heard."""

from __future__ import annotations

import numpy as np

from ross_payload.errors import AudioError, ConfigError
from ross_payload.events import Enrolled, Estimate, Outcome, State
from ross_payload.interfaces import Result
from ross_payload.mission.align import align
from ross_payload.mission.context import Context, Step
from ross_payload.mission.heading_hold import attend, face_alignment
from ross_payload.mission.identify_target import separate
from ross_payload.mission.voice_evidence import lone_voices
from ross_payload.orders import Enrol
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.dominance import dominant

MOST_PERIODS = 3  # people pause: so often as long as was ordered is listened


class NotEnrolled(Exception):
    """Nobody was enrolled; says why."""


def enrol_source(context: Context, estimate: Estimate, source: int, order: Enrol) -> Step[Result]:
    """Listen to one source of an estimate, whose talker agrees to it, and enrol what is heard.

    The voice print is the one of `ross_payload.voiceprint.enrol`, made from the separated voice, or the parts in which
    it dominates. Where there is too little speech in it the array goes on listening, three periods at most.

    Raises
    ------
    NotEnrolled
        When no heading sets the source apart, too little of it was heard, or no model of voices can be used.
    """
    try:
        voice_model = context.tools.voice_model()
    except ConfigError as error:
        raise NotEnrolled(str(error)) from error
    own = next((candidate for candidate in align(context, estimate) if candidate.source == source), None)
    if own is None:
        raise NotEnrolled(f"no heading within the limits isolates source {source}")
    yield from face_alignment(context, own)
    context.enter(State.RUN, f"enrolling source {source}")
    context.yields = False  # what was heard so far would be lost
    seconds = order.seconds or context.settings.run
    voice, why = np.zeros(0, np.float32), ""
    for _ in range(MOST_PERIODS):
        heard = yield from attend(context, seconds)
        groups, voices = separate(context, estimate, heard)
        alone = lone_voices(groups, dominant(voices, groups.quality, context.settings.rate))
        if source not in alone:  # it poses as one with others: the print would be of a mixture
            raise NotEnrolled(f"source {source} cannot be told from the others at any heading within the limits")
        voice = np.concatenate([voice, alone[source].samples])
        try:
            model = enrol(voice, context.settings.rate, voice_model, separated=True)
        except AudioError as error:
            why = str(error)
            continue
        azimuth = estimate.sources[source].azimuth
        context.publish(Enrolled(context.time, order.name, source, azimuth, model.seconds, model))
        told = f"enrolled {order.name} from {model.seconds:.1f} s of speech of source {source}"
        return Result(Outcome.COMPLETED, told)
    raise NotEnrolled(f"{order.name}: {why}")
