"""What is heard of a simulated mission: the same on every run, and at the samples where it was in the mixture."""

import json

import numpy as np
import pytest
import soundfile

from command_line import called_once
from ross_payload.sessions.session_store import SessionStore
from short_mission import PAIR

pytestmark = pytest.mark.usefixtures("undrawn")

LISTENING = '[payload.listening]\nseparator = "gaussian"\n'
LISTENED = PAIR.replace("run_s = 1.0", "run_s = 2.0") + LISTENING
RECORDED = "[payload.recording]\ntarget = true\nsources = true\nmin_free_gb = 0\n"


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "listened.toml"
    path.write_text(LISTENED)
    return path


def si_sdr(estimate, reference):
    scaled = (estimate @ reference) / (reference @ reference) * reference
    return 10 * np.log10(scaled @ scaled / ((estimate - scaled) @ (estimate - scaled)))


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The folder of a mission that is listened to and recorded: `heard.flac`, its results in `out`, its `tapes`."""
    folder = tmp_path_factory.mktemp("flown")
    (folder / "recorded.toml").write_text(LISTENED + RECORDED)
    kept = ("--listen", folder / "heard.flac", "--out", folder / "out", "--record", folder / "tapes")
    code, _, err = called_once("sitl", "--json", "--scenario", folder / "recorded.toml", "--informed", *kept)
    assert code == 0, err
    return folder


def test_the_target_is_heard_live_as_it_is_separated_afterwards(flown):
    out = flown / "out"
    heard, rate = soundfile.read(flown / "heard.flac")
    mixture = soundfile.read(out / "mixture.wav")[0][:, 0]
    assert len(heard) == len(mixture)
    events = [json.loads(line) for line in (out / "events.jsonl").read_text().splitlines()]
    assert np.abs(heard[: 2 * rate] - mixture[: 2 * rate]).max() < 2**-22  # the lead-in: nobody is known
    separated = next(event for event in events if event["event"] == "Separated")
    target = soundfile.read(out / "target.wav")[0]
    live = heard[separated["start"] : separated["start"] + len(target)]
    before = mixture[separated["start"] : separated["start"] + len(target)]
    assert si_sdr(live, target) > si_sdr(before, target) + 6


@pytest.mark.soak  # of who looks on: test_onlooker
def test_who_listens_changes_nothing(fly, scenario, tmp_path):
    listened = fly("--scenario", scenario, "--informed", "--listen", tmp_path / "heard.flac")
    assert fly("--scenario", scenario, "--informed") | {"timing": 0} == listened | {"timing": 0}


@pytest.mark.soak
def test_a_rerun_is_heard_the_same(fly, scenario, tmp_path):
    for name in ("heard", "again"):
        fly("--scenario", scenario, "--listen", tmp_path / f"{name}.flac")
    assert (tmp_path / "heard.flac").read_bytes() == (tmp_path / "again.flac").read_bytes()


def test_a_recording_keeps_the_voices_that_it_is_asked_for_beside_the_mixture(flown, run):
    one = flown / "tapes" / "0001"
    voices = sorted(path.name for path in one.glob("*.flac"))
    assert voices == ["source-0.flac", "source-1.flac", "target.flac"]
    assert all((one / name).stat().st_mode & 0o777 == 0o600 for name in voices)
    mixture, rate = soundfile.read(one / "audio.wav")
    target = soundfile.read(one / "target.flac")[0]
    assert 0 <= len(mixture) - len(target) < 0.3 * rate
    assert np.abs(target[: 2 * rate] - mixture[: 2 * rate, 0]).max() < 2**-22  # the lead-in: nobody is known
    (kept,) = SessionStore(flown / "tapes").all()
    assert kept.bytes >= sum((one / name).stat().st_size for name in voices)
    code, _, errors = run("sessions", "--folder", flown / "tapes", "delete", "0001")
    assert (code, errors) == (0, "")
    assert not one.exists()


@pytest.mark.soak
def test_streams_of_a_scenario_are_served_too(fly, tmp_path):
    path = tmp_path / "streams.toml"
    streams = [("mixture", "a.wav"), ("source 0", "b.wav"), ("azimuth 40", "c.wav")]
    path.write_text(PAIR + "[payload.listening]\nseparator = 'gaussian'\notherwise = 'silence'\n" + "".join(
        f"[[payload.listening.streams]]\nsink = 'file'\nwhat = '{what}'\noptions = {{ path = '{tmp_path / name}' }}\n"
        for what, name in streams
    ))  # fmt: skip
    report = fly("--scenario", path, "--informed")
    mixture, one, other = (soundfile.read(tmp_path / name)[0] for _, name in streams)
    nearest = min(range(report["k"]), key=lambda k: abs(report["sources"][k]["azimuth_deg"] - 40))
    assert np.array_equal(one, other) == (nearest == 0)
    assert len(mixture) == len(one) == len(other)
    assert one.any()
    assert not one[: 3 * 8000].any()  # nobody is known
    assert mixture[: 3 * 8000].any()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("heard.mp3", "--listen: path: expected a name that ends in .flac or .wav, got 'heard.mp3'"),
        ("listened.toml/heard.flac", "listened.toml/heard.flac: cannot be written: Not a directory"),
        ("/proc/heard.flac", "--listen /proc/heard.flac: cannot be written: No such file or directory"),
    ],
)
def test_a_file_that_cannot_be_is_told_before_anything_is_simulated(run, scenario, tmp_path, name, said):
    code, out, errors = run("sitl", "--scenario", scenario, "--listen", tmp_path / name)
    assert (code, out) == (2, "")
    assert errors.strip().startswith("ross: ")
    assert errors.strip().endswith(said)
    assert len(errors.strip().splitlines()) == 1


def test_a_file_that_is_there_is_refused_and_nothing_is_touched(run, scenario, tmp_path):
    (tmp_path / "heard.flac").write_text("precious")
    before = sorted(tmp_path.iterdir())
    code, out, errors = run("sitl", "--scenario", scenario, "--listen", tmp_path / "heard.flac")
    assert (code, out) == (2, "")
    assert errors == f"ross: --listen: {tmp_path}/heard.flac is there already: delete it, or give another name\n"
    new = tmp_path / "new" / "heard.flac"
    assert run("sitl", "--scenario", scenario, "--listen", new, "--target", "nobody")[0] == 2
    assert (tmp_path / "heard.flac").read_text() == "precious"
    assert sorted(tmp_path.iterdir()) == before
