"""Enrol by pointing: turn to where one talker stands alone, separate, and make a voice print of what is heard."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.errors import AudioError, ConfigError
from ross_payload.events import Enrolled, Estimate, Outcome, State
from ross_payload.interfaces import Real, Result
from ross_payload.mission.align import align
from ross_payload.mission.context import Context, Step
from ross_payload.mission.heading_hold import attend, face_alignment
from ross_payload.mission.identify_target import separate
from ross_payload.mission.voice_evidence import lone_voices
from ross_payload.orders import Enrol
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.dominance import dominant

MOST_PERIODS = 3  # people pause: so often as long as was ordered is listened
PIECE = 30.0  # separated at once, at most [s]: memory grows with it
MOST = 40.0  # that a print is made of [s]: more tells nothing new, and takes longer to compute


class NotEnrolled(Exception):
    """Nobody was enrolled; says why."""


def enrol_source(context: Context, estimate: Estimate, source: int, order: Enrol) -> Step[Result]:
    """Listen to one source of an estimate, whose talker agrees to it, and enrol what is heard.

    The voice print is the one of `ross_payload.voiceprint.enrol`, made from the separated voice, or the parts in which
    it dominates; of a long one `MOST` seconds. Where there is too little speech in it the array goes on listening,
    three periods at most.

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
    rate, seconds = context.settings.rate, order.seconds or context.settings.run
    voice, why = np.zeros(0, np.float32), ""
    for _ in range(MOST_PERIODS):
        voice = np.concatenate([voice, *(yield from _listen(context, estimate, source, seconds))])
        try:
            model = enrol(loudest(voice, round(MOST * rate)), rate, voice_model, separated=True)
        except AudioError as error:
            why = str(error)
            continue
        azimuth = estimate.sources[source].azimuth
        context.publish(Enrolled(context.time, order.name, source, azimuth, model.seconds, model))
        told = f"enrolled {order.name} from {model.seconds:.1f} s of speech of source {source}"
        return Result(Outcome.COMPLETED, told)
    raise NotEnrolled(f"{order.name}: {why}")


def _listen(context: Context, estimate: Estimate, source: int, seconds: float) -> Step[list[Real]]:
    """Return what was heard of a source alone in so many seconds, piece by piece, (n,) each."""
    pieces = max(math.ceil(seconds / PIECE), 1)
    found = []
    for _ in range(pieces):
        heard = yield from attend(context, seconds / pieces)
        groups, voices = separate(context, estimate, heard)
        alone = lone_voices(groups, dominant(voices, groups.quality, context.settings.rate))
        if source not in alone:  # it poses as one with others: the print would be of a mixture
            raise NotEnrolled(f"source {source} cannot be told from the others at any heading within the limits")
        found.append(alone[source].samples)
    return found


def loudest(voice: Real, most: int) -> Real:
    """Return the stretch of a voice (n,) that holds the most of it, at most so many samples.

    >>> loudest(np.array([0.0, 0.1, 0.9, 0.2, 0.0]), 2)
    array([0.9, 0.2])
    """
    if len(voice) <= most:
        return voice
    energy = np.concatenate([[0.0], np.cumsum(np.square(voice, dtype=np.float64))])
    first = int(np.argmax(energy[most:] - energy[:-most]))
    return voice[first : first + most]
