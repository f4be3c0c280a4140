"""The bench compares like with like; how long anything takes is no claim of a test."""

from dataclasses import replace

import numpy as np
import pytest

from ross_sim.study.rows.cost_rows import BLIND, CostRow, costs, growth
from ross_sim.study.scenes.workload import SNR_DB, VOICE_RATE, Case, prepared
from ross_sim.study.separation_cost import OURS, blind_auxiva, grown, peers

TINY = Case(rate=16000, seconds=1.0)


@pytest.fixture(scope="module")
def voices():
    rng = np.random.default_rng(4)
    gates = np.repeat(rng.random((6, 20)) < 0.5, VOICE_RATE // 10, axis=1)
    return [gate * rng.standard_normal(gate.size) for gate in gates]


@pytest.fixture(scope="module")
def work(voices):
    return prepared(TINY, voices)


def test_a_mixture_has_the_noise_and_the_power_of_the_papers_settings(work):
    """15 dB of noise, K equal talkers: SI-SDR of the mixture is that of 1 in K - 1 + K / 10^1.5."""
    k = TINY.n_sources
    expected = -10 * np.log10(k - 1 + k * 10 ** (-SNR_DB / 10))
    image = work.reference
    gain = (work.mixture[0] @ image) / (image @ image)
    rest = work.mixture[0] - gain * image
    assert 10 * np.log10((gain * image) @ (gain * image) / (rest @ rest)) == pytest.approx(expected, abs=0.5)


def test_the_interferers_pose_as_one_at_the_alignment(work):
    assert work.scene.tau[1] == pytest.approx(work.scene.tau[2])


def test_the_perfect_output_gains_without_end_and_the_mixture_nothing(work):
    perfect = work.stft.analyse(work.reference)[None]
    assert work.gain(perfect) > 100
    assert work.gain(work.spectrogram[:1]) == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("case", [replace(TINY, n_sources=6), replace(TINY, rate=48000), replace(TINY, seconds=3.0)])
def test_a_case_is_as_large_as_it_says(voices, case):
    large = prepared(case, voices)
    assert large.mixture.shape == (2, round(case.rate * case.seconds))
    assert large.scene.tau.size == case.n_sources
    assert large.stft.rate == case.rate


def test_our_blind_auxiva_splits_the_mixture_without_a_rest(work):
    np.testing.assert_allclose(blind_auxiva(work).sum(axis=0), work.spectrogram[0], atol=1e-4)


@pytest.mark.parametrize("peer", peers(2, 2, 2), ids=lambda peer: f"{peer.library} {peer.method}")
def test_the_libraries_give_two_parts_of_microphone_1_in_our_axes_and_the_same_again(work, peer):
    spectrogram = work.spectrogram.astype(np.complex128)
    found = peer.call(spectrogram, peer.iterations, 2)
    np.testing.assert_array_equal(found, peer.call(spectrogram, peer.iterations, 2))
    assert found.shape == work.spectrogram.shape
    total, heard = found.sum(axis=0), spectrogram[0]
    assert np.vdot(total, heard).real > 0.9 * np.linalg.norm(total) * np.linalg.norm(heard)


def test_a_ratio_is_of_the_same_mixture():
    """Twice the cost on each mixture is a ratio of 2, whichever mixture is the dearer one."""
    blank = CostRow(BLIND, "S1", 3, 24000, 10.0, 0, 0, None, 1.0, 0.0)
    base = [blank, replace(blank, setting="S2", cpu_s_s=10.0)]
    both = [*base, *(replace(row, method="gaussian") for row in base)]
    twice = [replace(row, method="x", cpu_s_s=2 * row.cpu_s_s) for row in base]
    assert costs([*both, *twice]).rows[-1][2:4] == ("2.0", "2.0")


@pytest.mark.soak
def test_what_was_not_measured_is_a_dash():
    alone = CostRow("duet", "S1", 3, 24000, 10.0, 0, 0, None, 0.1, 3.0)
    assert costs([alone, replace(alone, method="irm", setting="S2")]).rows[0] == (
        "duet",
        "0.1000",
        "-",
        "-",
        "3.0",
        "-",
    )


def test_every_growing_number_has_a_row_of_its_own(voices):
    rows = grown("K", [replace(TINY, n_sources=k, seconds=0.5) for k in (2, 3)], voices, 1, 0)
    table = growth(rows)
    assert [line[0] for line in table.rows] == ["K = 2", "K = 3"]
    assert table.header[1:] == ("simulation", "STFT", *OURS)
    assert {len(line) for line in table.rows} == {len(table.header)}
    (line,) = growth([replace(rows[0], growing="duration", duration_s=30.0)]).rows
    assert line[0] == "30 s"
