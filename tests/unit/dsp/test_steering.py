import numpy as np

from ross_payload.dsp.steering import groups_of, steering_vectors, tdoa

HEADING = 0.3


def test_a_source_on_the_axis_of_microphone_2_leads_by_the_whole_spacing() -> None:
    np.testing.assert_allclose(tdoa(HEADING, HEADING, 0.05, 343.0), 0.05 / 343.0)
    np.testing.assert_allclose(tdoa(HEADING + np.pi, HEADING, 0.05, 343.0), -0.05 / 343.0)


def test_front_and_back_are_the_same_to_two_microphones() -> None:
    np.testing.assert_allclose(tdoa(HEADING + 0.7, HEADING, 0.05, 343.0), tdoa(HEADING - 0.7, HEADING, 0.05, 343.0))


def test_a_source_overhead_reaches_both_microphones_at_once() -> None:
    np.testing.assert_allclose(tdoa(0.0, 0.0, 0.05, 343.0, elevation=np.pi / 2), 0.0, atol=1e-18)


def test_the_steering_vector_is_the_transform_of_an_advanced_impulse() -> None:
    advance = 3
    samples = np.zeros((2, 64))
    samples[0, 10] = samples[1, 10 - advance] = 1
    first, second = np.fft.rfft(samples)
    vector = steering_vectors(np.fft.rfftfreq(64, 1 / 16000), [advance / 16000])
    np.testing.assert_allclose(second / first, vector[:, 1, 0], atol=1e-12)


def test_groups_are_chained_and_cover_every_source_once() -> None:
    assert groups_of([0.0, 3.0, 0.5, 1.0], tolerance=0.6) == ((0, 2, 3), (1,))
    assert groups_of([], tolerance=1.0) == ()
