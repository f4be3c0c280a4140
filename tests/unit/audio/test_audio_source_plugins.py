"""Audio sources of others: found by name, given what they need, and told in one line what they do wrong."""

import sys
from dataclasses import replace
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from command_line import called
from examples import in_soak
from ross_payload import plugins
from ross_payload.audio.live_source import SourceStatus
from ross_payload.audio.open_source import GROUP, open_source
from ross_payload.config import Config, validated
from ross_payload.errors import AudioEnded, AudioError, PluginError
from ross_payload.interfaces import AudioBlock
from ross_sim.clock import SimClock

HOP = 160
BUILT_IN = {"device", "file", "tcp"}


class Tone:
    """A good source, and what to change of its blocks to make it a bad one."""

    def __init__(self, address, services, **wrong):
        self.address, self.services, self.wrong = address, services, wrong
        self.rate = services.audio.rate_hz
        self.index, self.entered, self.left = 0, 0, 0

    def read(self, n):
        first = AudioBlock(np.full((2, n), 0.25, np.float32), self.index, 5.0 + self.index / self.rate)
        self.index += n
        return replace(first, **self.wrong) if first.index and self.wrong else first

    def __enter__(self):
        self.entered += 1
        return self

    def __exit__(self, *exception):
        self.left += 1


@pytest.fixture
def installed(monkeypatch):
    """Make a function the audio source ``theirs``; returns the list of what it made."""

    def install(make):
        made = []
        monkeypatch.setattr(
            sys.modules[__name__], "theirs", lambda *a: made.append(make(*a)) or made[-1], raising=False
        )
        points = {**plugins.available(GROUP), "theirs": EntryPoint("theirs", f"{__name__}:theirs", GROUP)}
        monkeypatch.setattr(plugins, "available", lambda group: points)
        return made

    return install


def opened(source="theirs:there", clock=None, **audio):
    return open_source(validated(Config, {"audio": {"source": source, **audio}}, "test"), clock or SimClock(), 2.5)


def test_the_built_in_sources_are_registered_as_those_of_others_are():
    assert plugins.available(GROUP).keys() >= BUILT_IN
    assert all(callable(plugins.load(GROUP, name)) for name in BUILT_IN)


def test_a_source_is_given_its_address_and_what_the_configuration_says(installed):
    made, clock = installed(Tone), SimClock()
    opened("theirs:a:b/c?d", clock, channels=[3, 1], rate_hz=48000)
    services = made[0].services
    assert made[0].address == "a:b/c?d"
    assert (services.clock, services.connect_timeout, services.audio.rate_hz) == (clock, 2.5, 48000)
    assert services.wiring.channels == (3, 1)
    assert made[0].entered == 0


def test_what_it_gives_arrives_unchanged_and_it_is_closed_once(installed):
    made = installed(Tone)
    with (source := opened()):
        blocks = [source.read(HOP) for _ in range(3)]
    source.__exit__(None, None, None)
    assert [block.index for block in blocks] == [0, HOP, 2 * HOP]
    assert np.all(blocks[-1].samples == 0.25)
    assert (made[0].entered, made[0].left) == (1, 1)


BAD_BLOCKS = {
    "shape": ({"samples": np.zeros((HOP, 2), np.float32)}, "samples: expected float32 (2, 160), got float32 (160, 2)"),
    "dtype": ({"samples": np.zeros((2, HOP))}, "samples: expected float32 (2, 160), got float64 (2, 160)"),
    "list": ({"samples": [0.0]}, "samples: expected float32 (2, 160), got list"),
    "loud": ({"samples": np.full((2, HOP), 300, np.float32)}, "samples: expected samples within -1 to 1, got 300"),
    "nan": ({"samples": np.full((2, HOP), np.nan, np.float32)}, "samples: expected samples within -1 to 1, got nan"),
    "raw": ({"raw": np.zeros((2, 3), np.float32)}, "raw: expected float32 (2, 160), got float32 (2, 3)"),
    "skips": ({"index": 2 * HOP}, "index: expected 160 and what was lost, got 320 with 0 lost"),
    "repeats": ({"index": 0}, "index: expected 160 and what was lost, got 0 with 0 lost"),
    "carried": ({"carried": float("nan")}, "carried: expected a finite number, got nan"),
    "back": ({"time": 4.0}, "time: expected one that grows, got 4.0 s after 5.0 s"),
    "no time": ({"time": float("nan")}, "time: expected one that grows, got nan s after 5.0 s"),
}


@pytest.mark.parametrize(("wrong", "said"), BAD_BLOCKS.values(), ids=BAD_BLOCKS)
def test_a_block_that_no_source_may_give_ends_it_in_one_line(installed, wrong, said):
    installed(lambda *given: Tone(*given, **wrong))
    with opened() as source:
        source.read(HOP)
        with pytest.raises(PluginError) as error:
            source.read(HOP)
    assert str(error.value) == f"audio source 'theirs': read(160): {said}"


def test_samples_that_were_lost_and_counted_may_be_left_out(installed):
    installed(lambda *given: Tone(*given, index=HOP + 7, lost=7))
    with opened() as source:
        source.read(HOP)
        assert source.read(HOP).lost == 7


def raising(error):
    def call(*_):
        raise error

    return call


class Nothing:
    rate = 16000


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda *_: None, "expected open() to return an AudioSource, got one without read"),
        (lambda *_: Nothing(), "expected open() to return an AudioSource, got one without read"),
        (raising(KeyError("x")), "open raised KeyError: 'x'"),
        (lambda address: 0, "open raised TypeError: "),
    ],
)
def test_a_plug_in_that_makes_no_source_is_one_line(installed, make, said):
    installed(make)
    with pytest.raises(PluginError, match="audio source 'theirs': ") as error:
        opened()
    assert said in str(error.value)


def test_a_source_of_another_rate_is_one_line(installed):
    def slow(*given):
        source = Tone(*given)
        source.rate = 8000
        return source

    installed(slow)
    with pytest.raises(PluginError, match=r"expected a rate of 16000 Hz \(audio.rate_hz\), got 8000"):
        opened()


def test_what_it_raises_while_it_is_open_is_one_line_and_ours_stays_as_it_is(installed):
    errors = [ValueError("two\nlines"), SystemExit(0), AudioEnded("over")]

    class Broken(Tone):
        def read(self, n):
            raise errors.pop(0)

    installed(Broken)
    with opened() as source:
        with pytest.raises(AudioError, match=r"^audio source 'theirs': read raised ValueError: two lines$"):
            source.read(HOP)
        with pytest.raises(AudioError, match=r"^audio source 'theirs': read raised SystemExit: 0$"):
            source.read(HOP)
        with pytest.raises(AudioEnded, match=r"^over$"):
            source.read(HOP)


def test_it_is_read_while_it_is_open_and_opened_once(installed):
    installed(Tone)
    source = opened()
    with pytest.raises(AudioError, match="audio source 'theirs' is not open"):
        source.read(HOP)
    with source:
        source.read(HOP)
    with pytest.raises(AudioError, match="audio source 'theirs' is not open"):
        source.read(HOP)
    with pytest.raises(AudioError, match="audio source 'theirs' can be opened only once"), source:
        pass


def test_one_that_cannot_be_opened_is_one_line_and_is_not_closed(installed):
    class Closed(Tone):
        __enter__ = raising(RuntimeError("no"))

    made = installed(Closed)
    with pytest.raises(AudioError, match=r"^audio source 'theirs': cannot be opened: RuntimeError: no$"), opened():
        pass
    assert made[0].left == 0


@pytest.mark.parametrize(
    ("status", "trouble"),
    [
        (lambda self: SourceStatus(lost=3, trouble="gone"), "gone"),
        (lambda self: 7, "audio source 'theirs': status: expected SourceStatus, got int"),
        (raising(OSError("no")), "audio source 'theirs': status raised OSError: no"),
        (None, ""),
    ],
)
def test_its_status_is_told_and_a_bad_one_is_its_trouble(installed, status, trouble):
    installed(type("Told", (Tone,), {} if status is None else {"status": status}))
    assert opened().status().trouble == trouble


@pytest.mark.parametrize("command", [("config", "check"), ("run",), *in_soak(("doctor",))])
def test_an_unknown_source_is_refused_with_what_there_is_and_how_to_get_more(command, monkeypatch, capsys, tmp_path):
    file = tmp_path / "ross.toml"
    cheap = "exploit.separator = 'duet'\nexploit.run_s = 3\n"  # to rehearse
    file.write_text(f"audio.source = 'filee:x'\nservice.state_dir = '{tmp_path}'\nactuator.kind = 'ideal'\n{cheap}")
    code, out, err = called(monkeypatch, capsys, *command, file)
    said = " ".join((out + err).replace("\n", " ").split())
    assert code != 0
    assert "audio source 'filee' is unknown; there are: " in said
    assert "did you mean 'file'?; others come with their packages: " in said
    assert "install PACKAGE" in said
    assert "Traceback" not in said
