"""What a lead-in tells of the noise of the vehicle, and what the explorer makes of it."""

import dataclasses

import numpy as np
import pytest

from ross_payload.angles import difference
from ross_payload.dsp.ego_noise import learnt
from ross_payload.dsp.itd import Trust, weighted_itd
from ross_payload.dsp.itd_in_noise import weighted_itd_in_noise
from ross_payload.dsp.noise_field import noise_field
from ross_payload.dsp.rotors import Rotors, heard_from
from ross_payload.localization import model_order, talker_evidence
from ross_payload.localization.joint import Joint
from ross_payload.localization.joint_in_noise import JointInNoise, Votes
from ross_payload.localization.talker_evidence import Among
from rotor_scenes import PLACES, RATE, ROTORS, SPACING, SPEED_OF_SOUND, STFT, observations, rotor_noise, talk

UNIT = SPACING / SPEED_OF_SOUND
BAND = (STFT.frequencies > 500) & (STFT.frequencies < 3400)


def spectrogram(samples):
    return STFT.analyse(samples.astype(np.float32))


def told(samples, rotors=ROTORS):
    return learnt(spectrogram(samples), STFT.frequencies, STFT.period, 0.0, rotors)


@pytest.fixture(scope="module")
def seen():
    """What is observed of one talker among the rotors."""
    return observations([1.6])


def test_white_noise_teaches_nothing():
    assert told(np.random.default_rng(1).standard_normal((2, 2 * RATE))) is None


def test_talk_in_the_lead_in_teaches_nothing():
    assert told(talk(3, 1.0, 0.0) + 1e-3 * np.random.default_rng(1).standard_normal((2, 3 * RATE))) is None


def test_too_short_a_lead_in_teaches_nothing():
    assert told(rotor_noise(2, 0.0)[:, :600]) is None


def test_rotors_are_learnt_with_or_without_their_places():
    noise = told(rotor_noise(2, 0.0))
    assert np.median(noise.directed[BAND]) > 0.7
    assert (noise.outliers >= 1).all()
    assert np.median(noise.outliers[BAND]) < 1.5
    assert told(rotor_noise(2, 0.0), None).directed.max() == 0


def test_noise_that_is_louder_now_and_then_has_outliers():
    rng = np.random.default_rng(3)
    noise = rotor_noise(2, 0.0) * np.repeat(1 + 3 * (rng.random(100) < 0.1), 320)[None]
    assert np.median(told(noise).outliers[BAND]) > 1.2 * np.median(told(rotor_noise(2, 0.0)).outliers[BAND])


def test_a_rotor_votes_where_it_is_heard_from():
    grid = np.linspace(-1.5, 1.5, 61) * UNIT
    one = Rotors(PLACES[:1], SPACING, SPEED_OF_SOUND)
    for heading in (0.0, 1.0, 2.5):
        place = heard_from(one, grid, heading, 0.1 * UNIT)
        assert place.sum() == pytest.approx(1)
        assert grid[place.argmax()] == pytest.approx(one.delays(heading)[0], abs=0.03 * UNIT)


def test_noise_from_elsewhere_does_not_pull_the_delay_of_a_talker():
    heading, azimuth = 0.3, 2.2
    mixture = spectrogram(talk(3, azimuth, heading) + rotor_noise(3, heading))
    field = noise_field(mixture, STFT.frequencies, STFT.period)
    trust = Trust(coherence=0.98)
    within = weighted_itd_in_noise(
        mixture[:, BAND], STFT.frequencies[BAND], STFT.period, field[BAND], floor=2.0, trust=trust
    )
    psd = 0.5 * (field[BAND, 0] + field[BAND, 1]).mean(axis=1)
    white = weighted_itd(mixture[:, BAND], STFT.frequencies[BAND], STFT.period, psd, trust)
    true = UNIT * np.cos(azimuth - heading)
    share = [float(weight[np.abs(itd - true) < 0.15 * UNIT].sum() / weight.sum()) for itd, weight in (within, white)]
    assert share[0] > 0.7
    assert share[0] > share[1]


def test_what_is_not_coherent_does_not_vote():
    wind = np.random.default_rng(5).standard_normal((2, 3 * RATE)) * np.repeat([1.0, 6.0, 1.0], RATE)
    quiet = spectrogram(0.2 * np.random.default_rng(6).standard_normal((2, 3 * RATE)))
    field = noise_field(quiet, STFT.frequencies, STFT.period)
    _, weight = weighted_itd_in_noise(
        spectrogram(wind)[:, BAND],
        STFT.frequencies[BAND],
        STFT.period,
        field[BAND],
        floor=2.0,
        trust=Trust(coherence=0.98),
    )
    assert weight.astype(bool).mean() < 0.1


def test_votes_are_shared_between_the_rotors_and_anywhere():
    rotors = np.array([0.0, 0.5, 0.5, 0.0])
    votes = Votes.of(np.array([2.0, 12.0, 12.0, 2.0]), rotors, 2.0)
    assert (votes.rotors, votes.anywhere) == (pytest.approx(10.0), pytest.approx(4.0))
    assert (2.0 * votes.over(rotors, 4)).tolist() == pytest.approx([2.0, 12.0, 12.0, 2.0])
    assert Votes.of(np.array([1.0, 0.0, 0.0, 1.0]), rotors, 1.0).rotors == 0


def test_a_talker_among_rotors_is_found_and_the_rotors_are_nobody():
    azimuths, headings = np.array([0.6, -2.4]), np.deg2rad(15.0 * np.arange(7))
    explorer, within = Joint(SPACING, SPEED_OF_SOUND), JointInNoise(SPACING, SPEED_OF_SOUND)
    known = within.learn(spectrogram(rotor_noise(2, 0.0, 9)), STFT.frequencies, STFT.period, 0.0, ROTORS)
    seen = []
    for r, heading in enumerate(headings):
        talks = sum(talk(2, azimuth, heading, seed=20 + r) for azimuth in azimuths)
        heard = spectrogram(talks + np.sqrt(2) * rotor_noise(2, heading, 30 + r))
        seen.append(within.observe(heard, STFT.frequencies, heading, heading, known, period=STFT.period))
    places = np.array([source.azimuth for source in explorer.estimate(seen).sources])
    assert places.size == azimuths.size
    assert np.rad2deg(np.abs(difference(azimuths[:, None], places)).min(axis=1)).max() < 5


def test_silence_after_the_lead_in_is_nobody():
    within = JointInNoise(SPACING, SPEED_OF_SOUND)
    known = within.learn(spectrogram(rotor_noise(2, 0.0)), STFT.frequencies, STFT.period, 0.0, ROTORS)
    seen = [
        within.observe(spectrogram(rotor_noise(2, h, 40 + r)), STFT.frequencies, h, h, known, period=STFT.period)
        for r, h in enumerate(np.deg2rad(15.0 * np.arange(3)))
    ]
    assert Joint(SPACING, SPEED_OF_SOUND).estimate(seen).k == 0
    nothing = within.observe(np.zeros((2, 257, 0), complex), STFT.frequencies, 0.0, 0.0, known, period=STFT.period)
    assert nothing.weight == 0


@pytest.mark.soak
def test_a_source_where_a_rotor_is_must_have_more_to_say_than_one_elsewhere(seen):
    joint = Joint(SPACING, SPEED_OF_SOUND)
    assert all(0 <= each.features.among.kept <= 1 for each in seen)
    step = next(step for step in model_order.steps(joint.evidence(seen).rich, joint.penalty) if len(step.worth) == 1)
    at = joint.evidence(seen)
    there = Among((complex(step.model.amplitudes[0] * np.exp(1j * step.model.azimuths[0])),), at.among.kept)
    near, far = (
        talker_evidence.likely(dataclasses.replace(at, among=among), step, 0.0)
        for among in (there, Among((), there.kept))
    )
    assert near < far


def test_evidence_among_noise_has_weights_of_its_own(seen):
    joint = Joint(SPACING, SPEED_OF_SOUND)
    at = joint.evidence(seen)
    (step, *_) = model_order.steps(at.rich, joint.penalty)
    shown = talker_evidence.features(at, step, 0.0, [0])
    white = talker_evidence.features(dataclasses.replace(at, among=None), step, 0.0, [0])
    assert shown.shape[1] == white.shape[1] + len(talker_evidence.IN_NOISE)
    np.testing.assert_array_equal(shown[:, : white.shape[1]], white)
    assert talker_evidence.fitted("count", talker_evidence.AMONG).weights.shape == (shown.shape[1],)


def test_rotors_are_named_in_the_frame_of_the_azimuths_and_not_at_all_in_wind():
    within = JointInNoise(SPACING, SPEED_OF_SOUND)
    heard = spectrogram(rotor_noise(2, 0.0))
    known = within.learn(heard, STFT.frequencies, STFT.period, 0.0, ROTORS)
    turned = within.observe(heard, STFT.frequencies, 0.7, 0.0, known, period=STFT.period).features.among
    assert np.angle(turned.rotors[0]) == pytest.approx(np.arctan2(0.25, 0.25) + 0.7)
    windy = dataclasses.replace(known, noise=dataclasses.replace(known.noise, gusty=True))
    assert within.observe(heard, STFT.frequencies, 0.7, 0.0, windy, period=STFT.period).features.among.rotors == ()


def test_far_below_a_vehicle_the_weights_are_those_of_white_noise(seen):
    joint = Joint(SPACING, SPEED_OF_SOUND)
    aloft = joint.evidence([dataclasses.replace(each, height=10.0) for each in seen])
    assert aloft.among is not None
    assert not aloft.in_noise
    (step, *_) = model_order.steps(aloft.rich, joint.penalty)
    assert talker_evidence.features(aloft, step, 0.0, [0]).shape[1] == len(talker_evidence.FEATURES)
