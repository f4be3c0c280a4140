"""The study of estimated qualities: it compares with the truth, for every group."""

import pytest

from ross_sim.study import quality_study

pytestmark = pytest.mark.lockstep


@pytest.mark.soak
def test_it_compares_every_group_with_the_truth(capsys, monkeypatch):
    monkeypatch.setattr(quality_study, "DURATIONS", (2.0,))
    monkeypatch.setattr(quality_study, "TALKERS", (2, 3))
    assert quality_study.main(["--draws", "1", "--seed", "2"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.endswith("[dB]")
    numbers = {tuple(row.split()[:2]): [float(cell) for cell in row.split()[2:5]] for row in rows}
    assert set(numbers) == {(room, name) for room in ("S1", "all") for name in ("gaussian", "refined")}
    for mean, rms, p90 in numbers.values():
        assert abs(mean) <= rms < 4
        assert p90 < 6


def test_an_error_is_the_estimate_less_the_truth():
    assert quality_study.row("S1", "x", [1.0, -1.0, 3.0]).split()[2:5] == ["+1.00", "1.91", "2.60"]
