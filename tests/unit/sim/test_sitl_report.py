"""From when on the right voice can be heard, by the truth."""

import numpy as np
import pytest

from ross_payload.events import (
    Estimate,
    GroupScore,
    Outcome,
    Separated,
    SourceEstimate,
    SourcesEstimated,
    SourcesReconsidered,
)
from ross_payload.interfaces import Result
from ross_sim.sitl.report import EventLog, Truth, report, right_from

RATE = 1000
RATES = {"rate_hz": RATE}
NAMES = ("anna", "ben")


@pytest.fixture(scope="module")
def images():
    """Ten seconds of two talkers, uncorrelated, the second ten times as loud."""
    return np.random.default_rng(1).standard_normal((2, 10 * RATE)).astype(np.float32) * [[1.0], [10.0]]


def truth(images, target="anna", names=NAMES):
    nowhere = np.zeros(len(names))
    return Truth(names, nowhere, nowhere, images, images.sum(axis=0), target)


def period(images, start, talker):
    """A T_run of 2 s whose target is mostly one talker; the other group is the other one."""
    heard = images[:, start : start + 2 * RATE]
    voices = heard[[talker, 1 - talker]] + 0.2 * heard[[1 - talker, talker]] / 10
    scores = (GroupScore((0,), 3.0, accepted=True), GroupScore((1,), -3.0, accepted=False))
    return Separated(start / RATE + 2, start, 0.0, voices, scores, 0, "gaussian", "")


def test_the_right_voice_is_heard_from_the_first_period_that_holds_it(images):
    story = EventLog([period(images, start, talker) for start, talker in ((1000, 1), (4000, 0), (6000, 0))])
    assert right_from(story, truth(images), RATE) == 4.0
    assert right_from(story, truth(images, "ben"), RATE) == 1.0


def test_a_voice_that_is_never_delivered_is_never_heard(images):
    story = EventLog([period(images, 1000, 1)])
    assert right_from(story, truth(images), RATE) is None
    assert right_from(EventLog([]), truth(images), RATE) is None


def test_a_target_who_is_not_in_the_room_is_never_heard(images):
    assert right_from(EventLog([period(images, 1000, 0)]), truth(images, "carl"), RATE) is None


def test_silence_is_nobody(images):
    story = EventLog([period(0 * images, 1000, 0)])
    assert right_from(story, truth(0 * images), RATE) is None


def test_groups_are_told_by_the_estimate_that_they_were_separated_with(images):
    def found(time, *azimuths):
        return SourcesEstimated(
            time, Estimate(tuple(SourceEstimate(azimuth, 0.01, 1.0, True) for azimuth in azimuths)), 4, final=True
        )

    there = Truth(NAMES, np.array([0.0, 2.0]), np.zeros(2), images, images.sum(axis=0), "anna")
    story = EventLog([found(0.5, 0.0, 2.0), period(images, 1000, 0), found(5.0, 2.0)])  # anna has left
    told = report(story, there, Result(Outcome.NO_TARGET, ""), {"payload": {"audio": RATES}})
    assert [(group["talkers"], group["target"]) for group in told["groups"]] == [(["anna"], True), (["ben"], False)]
    assert min(group["si_sdri_db"] for group in told["groups"]) > 10
    assert [source["name"] for source in told["sources"]] == ["ben"]


def test_sources_are_as_sure_as_by_all_that_was_heard(images):
    def told(*sure):
        return Estimate(tuple(SourceEstimate(0.0, 0.01, confidence, True) for confidence in sure))

    def confidences(*events):
        values = report(
            EventLog(list(events)), truth(images), Result(Outcome.NO_TARGET, ""), {"payload": {"audio": RATES}}
        )
        return [source["confidence"] for source in values["sources"]]

    found, again = SourcesEstimated(1.0, told(0.8, 0.6), 4, final=True), SourcesReconsidered(2.0, told(0.9, 0.1), (1,))
    assert confidences(found) == [0.8, 0.6]
    assert confidences(found, again) == [0.9, 0.1]
    assert confidences(found, again, SourcesEstimated(2.0, told(0.9), 4, final=True)) == [0.9]
