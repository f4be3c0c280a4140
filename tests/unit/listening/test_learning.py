"""What is learnt beside the frames: on a thread of its own, and only for the heading at which it was heard."""

import threading

import numpy as np
import pytest

from ross_payload.config import Config
from ross_payload.dsp.streaming_stft import transform_for
from ross_payload.errors import PluginError
from ross_payload.interfaces import Groups
from ross_payload.listening.learning import BackgroundLearner, LearningRequest, Outcome
from ross_payload.listening.scene_tracker import Placement
from ross_payload.listening.voice_separation import LEAST_S, VoiceSeparation
from waiting import wait_for

STFT = transform_for(16000, 0.1)[0].stft
TAU = np.array([1e-5, -1e-5])
FRAME = np.ones((2, STFT.frequencies.size), np.complex64)


class Separator:
    """Gives the frame to every source, and notes what it is told to have learnt."""

    name = "theirs"
    lookahead = 0

    def __init__(self):
        self.renewals, self.fault = [], ""
        self.go_on = threading.Event()
        self.go_on.set()

    def start(self, scene):
        return 0

    def step(self, state, frame, scene):
        return state, Groups(np.stack([frame[0], frame[0]])[..., None], ((0,), (1,)), self.name)

    def learn(self, window, scene, before=None):
        assert self.go_on.wait(30)
        if self.fault:
            raise PluginError(self.fault)
        return "learnt"

    def renewed(self, state, learnt):
        self.renewals.append(learnt)
        return state


class Pupil:
    """Takes the place of a learner; its outcome is what the test says."""

    idle = True

    def __init__(self):
        self.requests, self.told = [], None

    def begin(self, request):
        self.requests.append(request)

    def outcome(self):
        told, self.told = self.told, None
        return told


@pytest.fixture
def separator():
    separator = Separator()
    yield separator
    separator.go_on.set()


@pytest.fixture
def learner(separator):
    learner = BackgroundLearner(separator)
    yield learner
    separator.go_on.set()
    learner.close()


def request(stretch):
    return LearningRequest(stretch, np.zeros((2, STFT.frequencies.size, 10), np.complex64), None, None)


def test_what_was_learnt_in_the_background_is_told_once(learner, separator):
    separator.go_on.clear()
    learner.begin(request(3))
    assert (learner.idle, learner.outcome()) == (False, None)
    separator.go_on.set()
    wait_for(lambda: learner.idle)
    told = learner.outcome()
    assert (told.stretch, told.learnt, told.fault) == (3, "learnt", "")
    assert learner.outcome() is None


def test_without_a_thread_left_it_is_asked_again_with_the_next_request(learner, monkeypatch):
    def refused(thread):
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refused)
        learner.begin(request(3))
        assert (learner.idle, learner.outcome()) == (True, None)
        learner.close()
    assert learner.idle


def test_what_fails_in_the_background_is_told_in_words(learner, separator):
    separator.fault = "separator 'theirs': learn: too little"
    learner.begin(request(4))
    wait_for(lambda: learner.idle)
    told = learner.outcome()
    assert (told.stretch, told.learnt, told.fault) == (4, None, separator.fault)


def test_what_was_learnt_at_another_heading_is_not_taken_over():
    separator, pupil = Separator(), Pupil()
    voices = VoiceSeparation(separator, pupil, STFT, Config())
    for _ in range(2 * round(LEAST_S / STFT.period)):
        voices.step(FRAME, Placement(TAU, stretch=1))
    assert [each.stretch for each in pupil.requests][:1] == [1]
    voices.step(FRAME, Placement(TAU, stretch=2))
    pupil.told = Outcome(1, "of the heading before")
    voices.step(FRAME, Placement(TAU, stretch=2))
    assert separator.renewals == []
    pupil.told = Outcome(2, "of this heading")
    voices.step(FRAME, Placement(TAU, stretch=2))
    assert separator.renewals == ["of this heading"]


def test_what_failed_at_another_heading_is_no_fault_here():
    pupil = Pupil()
    voices = VoiceSeparation(Separator(), pupil, STFT, Config())
    voices.step(FRAME, Placement(TAU, stretch=1))
    voices.step(FRAME, Placement(TAU, stretch=2))
    pupil.told = Outcome(1, fault="too little")
    assert voices.step(FRAME, Placement(TAU, stretch=2)) is not None
    assert voices.fault == ""
