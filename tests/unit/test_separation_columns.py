import numpy as np
import pytest
from click.testing import CliRunner

from ross_payload import plugins
from ross_payload.errors import PluginError
from ross_sim.study.rooms import SETTINGS
from ross_sim.study.separation import NOISE_BLIND, column, improvement, main, measure, recordings


def _voices(n: int = 24000) -> list[np.ndarray]:
    """Three bursts of noise that take turns, the first of them longest."""
    rng = np.random.default_rng(0)
    return [rng.standard_normal(n) * np.repeat(rng.gamma(0.3, size=n // 600), 600) for _ in range(3)]


def test_the_reference_is_the_target_alone_and_all_talkers_and_noise_are_the_mixture() -> None:
    recording = next(recordings(_voices(), 3, SETTINGS["S1"], count=0, seed=0))
    noise = recording.mixture - recording.images.sum(axis=0)
    np.testing.assert_array_equal(recording.reference, recording.images[recording.target, 0])
    clean = (recording.images.sum(axis=0)[0] ** 2).mean()
    assert 10 * np.log10(clean / (noise[0] ** 2).mean()) == pytest.approx(15, abs=0.2)


def test_an_oracle_beats_the_beam_and_both_have_one_number() -> None:
    scores = measure(_voices(), 3, SETTINGS["S1"], 0, 0, names=("mvdr", "tvmwf"))
    assert [len(values) for values in scores.values()] == [1, 1]
    assert scores["tvmwf"][0] > scores["mvdr"][0] > 0


@pytest.mark.parametrize("name", sorted(NOISE_BLIND - {"fastmnmf2"}))
def test_columns_with_one_number_do_not_depend_on_the_noise_psd(name: str) -> None:
    recording = next(recordings(_voices(), 3, SETTINGS["S1"], count=0, seed=0))
    separator = plugins.load("ross_payload.separators", name)
    with_psd, without = (improvement(separator, recording, known) for known in (True, False))
    assert with_psd == without
    assert abs(with_psd) > 0.1


def test_an_unknown_column_is_refused() -> None:
    with pytest.raises(PluginError, match="there are"):
        column("nonesuch")


def test_columns_need_their_option() -> None:
    ended = CliRunner().invoke(main, ["duet", "mvdr"])
    assert ended.exit_code == 2
    assert "--separators" in ended.output
