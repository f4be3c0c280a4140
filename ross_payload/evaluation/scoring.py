"""Separate a take with interference and score every group against the target alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ross_payload.config import Config
from ross_payload.dsp.density import prominent_peaks
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft, separation_frame, short_frames
from ross_payload.errors import AudioError, ConfigError
from ross_payload.evaluation.takes import Pair, Take
from ross_payload.interfaces import Observation, Real, Scene
from ross_payload.localization import markov_explorer
from ross_payload.localization.front_back_test import refined
from ross_payload.plugin_checks import load_separator

MOST_DEG = 360  # of an angle on the command line, as of one in an order
PROMINENCE = 0.005  # of a peak that is a group, over the highest
ELSEWHERE = 0.35  # of d / v_p between the delay of the target alone and all that were given: reflections move it less
FAINT = 1 / 3  # of its highest density, below which a target alone is not near a direction: fans have peaks, too


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """One separated group."""

    members: tuple[int, ...]  # indices into the TDOAs; () when unknown
    voice: Real  # at microphone 1, over the whole mixture, (n,)
    si_sdr: float | None  # [dB] against the target alone; None: the group is silent
    level: float | None  # RMS [dB re full scale]


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """What separating one pair of takes gives."""

    before: float  # SI-SDR of the mixture [dB]
    groups: tuple[Group, ...]
    tau: tuple[float, ...]  # of every source [s]
    given: bool  # whether they were given, or are those that stand out in the mixture
    method: str
    why: str
    noise_known: bool  # from a quiet start
    elsewhere: float | None = None  # delay of the target alone [s], when none that was given is near it

    @property
    def best(self) -> int | None:
        """The group nearest to the target."""
        heard = [i for i, group in enumerate(self.groups) if group.si_sdr is not None]
        return max(heard, key=lambda i: self.groups[i].si_sdr or 0.0, default=None)


def at_rate(config: Config, rate: int) -> Config:
    """A configuration for recordings at a rate [Hz]; where it tells no frame, one of about 0.1 s.

    >>> [at_rate(Config(), rate).audio.frame for rate in (16000, 24000, 48000)]
    [2048, 2048, 4096]
    """
    update = {"rate_hz": rate, "frame": config.audio.frame or separation_frame(rate)}
    return config.model_copy(update={"audio": config.audio.model_copy(update=update)})


def evaluate(pair: Pair, config: Config, tau: Real | None, n_sources: int | None) -> Evaluation:
    """Separate the mixture of a pair, score every group where both takes overlap.

    Parameters
    ----------
    pair
        Both takes at the rate of the configuration.
    config
        Array, STFT and separator.
    tau
        TDOA of every source [s], (n_sources,); None: the prominent peaks of the mixture's ITD density.
    n_sources
        Take so many of the highest peaks; None: all of them.

    Raises
    ------
    AudioError
        When no direction stands out in the mixture.
    PluginError, ConfigError
        When the separator cannot be used.
    """
    separator = load_separator(config.exploit.separator)
    given = tau is not None
    if tau is None:
        tau = heard_delays(pair, config, n_sources)
    if not tau.size:
        raise AudioError("mixture: no direction found: it holds only noise, or is too short")
    audio, n = config.audio, pair.mixture.samples.shape[1]
    frame = audio.frame or separation_frame(audio.rate_hz)
    stft = Stft(audio.rate_hz, frame, round(frame * (1 - audio.overlap)))
    scene = Scene(
        stft.frequencies, config.array.spacing_m, config.array.speed_of_sound_m_s, tau.size, tau, seed=config.seed
    )
    spectrogram = stft.analyse(pair.mixture.samples.astype(np.float32))
    scene = replace(scene, noise_psd=noise_of(pair.mixture, config, stft), hop=stft.hop)
    groups = separator.batch(spectrogram, scene)
    voices = stft.synthesise(groups.signals, n)
    found = tuple(_scored(m, voice, pair) for m, voice in zip(groups.members, voices, strict=True))
    before = si_sdr(pair.mixture.samples[0, pair.span], pair.target)
    known = scene.noise_psd is not None
    elsewhere = _elsewhere(pair, config, tau) if given else None
    return Evaluation(before, found, tuple(tau.tolist()), given, groups.method, groups.why, known, elsewhere)


def heard_delays(pair: Pair, config: Config, n_sources: int | None) -> Real:
    """TDOAs [s] of the peaks of the mixture's ITD density, the highest first: one per group of sources, (n_groups,)."""
    return _peaks(_heard(pair.mixture, config), config)[:n_sources]


def _heard(take: Take, config: Config) -> Observation:
    """ITD density of a take."""
    array = config.array
    stft = short_frames(config.audio.rate_hz)
    explorer = markov_explorer.explorer.make(array.spacing_m, array.speed_of_sound_m_s)
    return explorer.observe(stft.analyse(take.samples), stft.frequencies, 0.0, noise_of(take, config, stft))


def _peaks(seen: Observation, config: Config) -> Real:
    """TDOAs [s] of the peaks of a density, the highest first, (n_peaks,)."""
    peaks = prominent_peaks(seen.density, seen.grid, PROMINENCE)
    longest = config.array.spacing_m / config.array.speed_of_sound_m_s
    return np.clip([refined(seen.density, seen.grid, peak) for peak in peaks], -longest, longest)


def _elsewhere(pair: Pair, config: Config, tau: Real) -> float | None:
    """Delay [s] at which the target alone is heard, when it is hardly heard near that of any source that was given."""
    seen = _heard(pair.alone, config)
    heard = _peaks(seen, config)[:1]
    near = ELSEWHERE * config.array.spacing_m / config.array.speed_of_sound_m_s
    if not heard.size or np.abs(tau - heard[0]).min() <= near:
        return None
    around = np.abs(seen.grid[:, None] - tau).min(axis=1) <= near
    return float(heard[0]) if seen.density[around].max(initial=0.0) < FAINT * seen.density.max() else None


def noise_of(take: Take, config: Config, stft: Stft) -> Real | None:
    """Noise PSD per bin, (n_freqs,), when nobody talks at the start of a take, else None."""
    start = round(config.explore.lead_in_s * stft.rate)
    samples = take.samples
    if not stft.frame <= start < samples.shape[1]:
        return None
    return quiet_psd(stft.analyse(samples[:, :start]), stft.analyse(samples[:, start:]))


def level_of(samples: Real) -> float | None:
    """RMS [dB re full scale]; None for silence.

    >>> level_of(np.array([0.1, -0.1]))
    -20.0
    """
    power = float(np.mean(np.square(samples, dtype=np.float64)))
    return 10 * math.log10(power) if power > 0 else None


def _scored(members: tuple[int, ...], voice: Real, pair: Pair) -> Group:
    heard = voice[pair.span]
    score = si_sdr(heard, pair.target) if np.ptp(heard) > 0 else None
    return Group(members, voice, score, level_of(heard))


def delays(
    config: Config,
    azimuths_deg: Sequence[float],
    heading_deg: float | None,
    tdoas_us: Sequence[float],
    sources: int | None,
) -> Real | None:
    """TDOAs [s] of every source, (n_sources,); None when nothing is known. Degrees are those of a compass, clockwise.

    Raises
    ------
    ConfigError
        When two ways of saying where the sources are contradict each other, or a number is impossible.

    Examples
    --------
    On the axis the sound takes 5 cm / 343 m/s = 145.8 us from one microphone to the other:

    >>> (1e6 * delays(Config(), [30.0, 120.0], 30.0, [], None)).round(1).tolist()
    [145.8, 0.0]
    """
    if not np.isfinite([*azimuths_deg, heading_deg or 0.0, *tdoas_us]).all():
        raise ConfigError("--azimuth, --heading and --tdoa-us: expected finite numbers")
    for name, angle in (*(("azimuth", each) for each in azimuths_deg), ("heading", heading_deg or 0.0)):
        if abs(angle) > MOST_DEG:
            raise ConfigError(f"--{name}: expected -{MOST_DEG} to {MOST_DEG} deg, got {angle:g}")
    if sum(map(bool, (azimuths_deg, tdoas_us, sources))) > 1:
        raise ConfigError("--azimuth, --tdoa-us, --sources: expected only one of them")
    if heading_deg is not None and not azimuths_deg:
        raise ConfigError("--heading: expected together with --azimuth")
    array = config.array
    longest = array.spacing_m / array.speed_of_sound_m_s
    if azimuths_deg:
        heading = -math.radians(heading_deg or 0.0)
        return tdoa(-np.deg2rad(azimuths_deg), heading, array.spacing_m, array.speed_of_sound_m_s)
    for delay in tdoas_us:
        if not abs(delay) <= 1e6 * longest + 1:
            raise ConfigError(f"--tdoa-us: expected at most {1e6 * longest:.0f} us (d / v_p), got {delay:g}")
    return np.array(tdoas_us) * 1e-6 if tdoas_us else None
