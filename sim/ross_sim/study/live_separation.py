"""Live separation against the same separator on the whole recording: `python -m ross_sim.study.live_separation ROWS`.

Every mixture is separated as a whole and frame by frame, at several algorithmic latencies, with covariances learnt
from the latest 4 s and renewed two to four times a second. Rows are appended to a CSV file, and what it holds is not
measured again; `--page` writes the tables made from it into a page of the documentation.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.stft import Stft
from ross_payload.dsp.streaming_stft import StreamingAnalysis, StreamingSynthesis, transform_for
from ross_payload.errors import ConfigError
from ross_payload.interfaces import LiveSeparator, Real, Scene
from ross_payload.plugin_checks import load_separator
from ross_sim.study.option_types import NATURAL, CommaSeparated
from ross_sim.study.page_tables import write_page
from ross_sim.study.rows.live_tables import Row, appended, read_rows, tables
from ross_sim.study.runs.talker_placement import standard_voices
from ross_sim.study.scenes.mixtures import PAPER_DEG, Mixture, aligned_heading, is_silent, layouts, record, scene_of
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND, check_rooms
from ross_sim.study.script_errors import told_in_a_line

SECONDS, SETTLED, FIRST = 10.0, 4.0, 1.0  # of a mixture, until its covariances are learnt, after a turn [s]
WINDOW = 4.0  # learnt from [s]
SOON, LATER, EARLY = 0.25, 0.5, 2.0  # between renewals: in the beginning, and then; how long it lasts [s]
EARLIER = 3.0  # heard at another heading before [s]
TURN = np.deg2rad(60.0)  # from there
BATCH_FRAME = 2048  # of the whole recording, as the payload separates it
SILENT_DB = -20.0  # a talker this far below its mean level is not scored
VARIANTS = (("auto", 45), ("gaussian", 100), ("auto", 100), ("duet", 100), ("auto", 200))  # and latency [ms]


@dataclass(frozen=True, slots=True, eq=False)
class SeparatedRecording:
    """What a live separator made of a recording."""

    voices: Real  # (n_groups, n), the first sample that of the recording
    members: tuple[tuple[int, ...], ...]
    latency: float  # [s]
    step: float  # CPU of every frame with its transforms, per second of audio
    learn: float  # CPU of learning, per second of audio


class Listener:
    """Separates recordings frame by frame as the payload does.

    Parameters
    ----------
    name
        Of the separator.
    rate
        [Hz].
    latency
        At most [s].
    """

    def __init__(self, name: str, rate: int, latency: float) -> None:
        self._transform, lookahead = transform_for(rate, latency)
        self.separator: LiveSeparator = load_separator(name).live(lookahead)
        self.latency = (self._transform.latency + lookahead * self._transform.stft.hop) / rate

    def scene(self, recording: Mixture) -> Scene:
        """What is known of a recording; the noise PSD from its lead-in."""
        stft = self._transform.stft
        lead_in = StreamingAnalysis(self._transform, 2).push(recording.lead_in)
        psd = quiet_psd(lead_in, StreamingAnalysis(self._transform, 2).push(recording.mixture))
        tau = recording.tau
        return Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, tau.size, tau, psd, hop=stft.hop)

    def learnt(self, recording: Mixture) -> object:
        """What a whole recording tells."""
        return self.separator.learn(
            StreamingAnalysis(self._transform, 2).push(recording.mixture), self.scene(recording)
        )

    def listen(self, recording: Mixture, before: object = None) -> SeparatedRecording:
        """Separate a recording; ``before``: what was learnt at another heading."""
        stft, scene, n = self._transform.stft, self.scene(recording), recording.mixture.shape[1]
        state, learning = self.separator.start(scene), 0.0
        state = state if before is None else self.separator.renewed(state, before)
        window = round(WINDOW / stft.period)
        began, found = time.process_time(), []
        frames = StreamingAnalysis(self._transform, 2).push(recording.mixture)
        for index in range(frames.shape[2]):
            state, groups = self.separator.step(state, frames[:, :, index], scene)
            found.append(groups.signals)
            every = round((SOON if index * stft.period < EARLY else LATER) / stft.period)
            if index % every == every - 1:
                mark = time.process_time()
                before = self.separator.learn(frames[:, :, max(index + 1 - window, 0) : index + 1], scene, before)
                learning += time.process_time() - mark
                state = self.separator.renewed(state, before)
        voices = StreamingSynthesis(self._transform, len(groups.members)).push(np.concatenate(found, axis=2))
        spent, seconds = time.process_time() - began - learning, n / stft.rate
        skipped = self.separator.lookahead * stft.hop - self._transform.first_sample(0)
        return SeparatedRecording(
            voices[:, skipped:], groups.members, self.latency, spent / seconds, learning / seconds
        )


def score(voices: Real, members: Sequence[tuple[int, ...]], recording: Mixture, first: int, last: int) -> float | None:
    """SI-SDR [dB] of the group that holds the target, between two samples; None when it is silent there."""
    reference = recording.reference
    least = 10 ** (SILENT_DB / 10) * (reference**2).mean()
    owner = next((g for g, group in enumerate(members) if recording.target in group), None)
    if owner is None or not np.ptp(reference) or (reference[first:last] ** 2).mean() < least:
        return None
    last = min(last, voices.shape[1])
    return si_sdr(voices[owner, first:last], reference[first:last])


def measured(recording: Mixture, earlier: Mixture, blank: Row) -> Iterator[Row]:
    """Rows about one mixture: every variant against its separator on the whole recording."""
    stft = Stft(blank.rate, BATCH_FRAME, BATCH_FRAME // 4)
    n, settled, first = recording.mixture.shape[1], round(SETTLED * blank.rate), round(FIRST * blank.rate)
    spectrogram, scene = stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True)
    whole: dict[str, tuple[Real, tuple[tuple[int, ...], ...]]] = {}
    for name, latency in VARIANTS:
        base = "auto" if name == "gaussian" else name
        if base not in whole:
            groups = load_separator(base).batch(spectrogram, scene)
            whole[base] = stft.synthesise(groups.signals, n), groups.members
        listener = Listener(name, blank.rate, latency / 1000)
        heard = listener.listen(recording)
        short = replace(recording, mixture=recording.mixture[:, : 2 * first])
        again = listener.listen(short, listener.learnt(earlier))
        last = n - round(0.25 * blank.rate)
        yield replace(
            blank,
            separator=name,
            wanted_ms=latency,
            latency_ms=round(1000 * heard.latency, 1),
            batch_db=score(*whole[base], recording, settled, last),
            live_db=score(heard.voices, heard.members, recording, settled, last),
            first_batch_db=score(*whole[base], recording, 0, first),
            first_live_db=score(heard.voices, heard.members, recording, 0, first),
            first_room_db=score(again.voices, again.members, recording, 0, first),
            step_cpu=round(heard.step, 4),
            learn_cpu=round(heard.learn, 4),
        )


def mixtures(blank: Row, voices: Sequence[Real]) -> tuple[Mixture, Mixture]:
    """The mixture of a row, and what was heard before it at another heading."""
    azimuths = layouts(blank.k, blank.layout, np.random.default_rng(blank.seed))[blank.layout]
    heading, setting, rate = aligned_heading(azimuths, blank.target), SETTINGS[blank.setting], blank.rate
    n, m = round(SECONDS * rate), round(EARLIER * rate)
    rng = np.random.default_rng([blank.seed, blank.layout, blank.target])
    spoken = [voice[:n].astype(float) for voice in voices[: blank.k]]
    recording = record(spoken, azimuths, blank.target, heading, setting, rng=rng, rate=rate)
    spoken = [voice[n : n + m].astype(float) for voice in voices[: blank.k]]
    return recording, record(spoken, azimuths, blank.target, heading + TURN, setting, rng=rng, rate=rate)


@click.command()
@click.argument("rows", type=click.Path(path_type=Path))
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of talkers; absent: nothing is measured.")
@click.option("--settings", type=CommaSeparated(), default="S1,S2,A0.45", show_default=True)
@click.option(
    "--k",
    type=CommaSeparated(int, low=2, high=len(PAPER_DEG)),
    default="3,4,5",
    show_default=True,
    help="Numbers of talkers.",
)
@click.option(
    "--rates", type=CommaSeparated(int, low=8000, high=48000), default="16000,24000", show_default=True, help="[Hz]"
)
@click.option("--layouts", "n_layouts", type=click.IntRange(min=0), default=0, show_default=True, help="Random ones.")
@click.option("--targets", type=click.IntRange(min=1), default=2, show_default=True, help="Of every layout.")
@click.option("--seed", type=NATURAL, default=0, show_default=True)
@click.option("--page", type=click.Path(path_type=Path), help="Page to write the tables into.")
def main(
    *,
    rows: Path,
    speech: Path | None,
    settings: tuple[str, ...],
    k: tuple[int, ...],
    rates: tuple[int, ...],
    n_layouts: int,
    targets: int,
    seed: int,
    page: Path | None,
) -> None:
    """Measure what is missing in ROWS (CSV), and print the tables."""
    with told_in_a_line():
        check_rooms(settings)
        if targets > min(k):
            raise ConfigError(f"--targets: expected at most {min(k)}, the fewest talkers of --k, got {targets}")
        blanks = [
            Row(setting, count, layout, target, rate, seed)
            for rate in rates
            for layout in range(n_layouts + 1)
            for target in range(targets)
            for count in k
            for setting in settings
        ]
        if speech is not None:
            with threadpool_limits(1), np.errstate(all="ignore"):
                _measure(rows, blanks, speech)
        found = read_rows(rows)
        click.echo(tables(found))
        if page is not None:
            write_page(page, rows)


def _measure(path: Path, blanks: Sequence[Row], speech: Path) -> None:
    done = {row.mixture for row in read_rows(path)} if path.exists() else set()
    voices: dict[int, list[Real]] = {}
    for blank in blanks:
        if blank.mixture in done:
            continue
        if blank.rate not in voices:
            voices[blank.rate] = _voices(speech, blank.rate, max(each.k for each in blanks))
        recording, earlier = mixtures(blank, voices[blank.rate])
        appended(path, measured(recording, earlier, blank))
        click.echo(f"{blank.mixture}", err=True)


def _voices(speech: Path, rate: int, least: int) -> list[Real]:
    """So many talkers or more of a folder, (n,) each at ``rate`` [Hz], who speak long enough for `mixtures`."""
    found, needed = standard_voices(speech, rate, least), SECONDS + EARLIER
    for voice in found:
        if voice.speech.size < round(needed * rate):
            seconds = voice.speech.size / rate
            raise ConfigError(f"talker '{voice.name}': expected at least {needed:g} s of speech, got {seconds:.1f} s")
        if is_silent(voice.speech[: round(SECONDS * rate)]) or is_silent(voice.speech[round(SECONDS * rate) :]):
            raise ConfigError(f"talker '{voice.name}': silent in the first {SECONDS:g} s, or after them")
    return [voice.speech for voice in found]


if __name__ == "__main__":
    main()
