"""Local Gaussian model: directions known, covariances learnt, PSDs per bin, multichannel Wiener output.

Every bin is x ~ N(0, sum_k v_k R_k + n I) with a spatial covariance R_k per group and frequency, the noise PSD n, and a
source PSD v_k per bin (Duong, Vincent, Gribonval 2010; multiplicative updates as in Sawada et al. 2013).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, direct, outer
from ross_payload.dsp.metrics import qualities
from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.smoothing import average, averaged_rows
from ross_payload.dsp.steering import directions_of
from ross_payload.dsp.stft import Stft, band
from ross_payload.interfaces import Complex, Groups, LiveSeparator, Quality, Real, Scene
from ross_payload.separation.cacgmm import AT_ONCE, learn
from ross_payload.separation.directness import ASTRAY, VOICE, astray, geometric_start
from ross_payload.separation.evened_noise import FLOOR, evened
from ross_payload.separation.live_gaussian import LiveGaussian

UPDATES = 20
UNSMOOTHED = 2  # updates before the smoothing begins
TINY = float(np.finfo(np.float32).tiny)
MOST = np.float32(1e12)  # of a PSD in a mixture of power 1: more is a matrix that cannot be inverted
LOUDEST = 100.0  # times the mixture: no group is in any bin
ROUNDED = 1e-9  # a determinant that is a smaller part of the product of its diagonal is one of rounding
ACTIVE = 1.15  # bins with less than this many times the noise hold nobody
TIED = 0.05  # weight of the shares of the groups among the averages that every update is drawn towards
LONG = 0.128  # frames that a reverberant recording is cut into [s]


def source_psds(
    observed: Real,
    covariances: Real,
    noise_psd: Real,
    shares: Real,
    *,
    noise: Real | None = None,
    updates: int = UPDATES,
) -> Real:
    """PSDs of sources with known covariances, smoothed over neighbouring bins.

    Multiplicative updates v_k <- v_k x^H S^-1 R_k S^-1 x / tr(S^-1 R_k) with S = sum_k v_k R_k. For two microphones
    the fraction is t - tr(R_k adj(x x^H)) / tr(R_k adj(S)) with t = tr(adj(S) x x^H) / det(S) (Cayley-Hamilton), so
    that one matrix product per update is enough. All but the first are smoothed: the geometric mean of the update
    and of the 3 x 3 average before it, with a little of what the shares of the groups let expect.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    covariances
        Coordinates of every R_k, the noise last, (n_freqs, n_groups + 1, 4).
    noise_psd
        n, (n_freqs,).
    shares
        How probable every group is in a bin, (n_freqs, n_groups, n_frames).
    noise
        Coordinates of the covariance of the noise in every bin, trace 2, (n_freqs, 4, n_frames); None: that of
        ``covariances`` in all frames.
    updates
        How many.

    Returns
    -------
    ndarray
        v, the noise last, (n_freqs, n_groups + 1, n_frames).
    """
    n_groups = covariances.shape[1] - 1
    given = _Given.of(observed, covariances, noise_psd, noise)
    psds = np.empty_like(given.cross)
    psds[:] = shares * (0.5 * (observed[:, :1] + observed[:, 1:2])) + FLOOR
    np.maximum(psds, FLOOR, out=psds)  # shares of matrices that cannot be inverted may be below 0
    expected = np.log(average(psds))
    expected *= TIED
    other = np.empty_like(psds)
    height = max(AT_ONCE // max(psds.shape[2], 1), 1)
    for update in range(updates):
        for low in range(0, len(psds), height):
            rows = slice(low, low + height)
            sources = _updated(psds[rows], given, rows)
            if update >= UNSMOOTHED:
                smooth = np.log(averaged_rows(psds, low, low + height))
                smooth *= 0.5 - TIED
                smooth += expected[rows]
                np.log(sources, out=sources)
                sources *= 0.5
                sources += smooth
                np.exp(sources, out=sources)
            np.clip(sources, FLOOR, MOST, out=other[rows])
        psds, other = other, psds
    noise = np.broadcast_to(noise_psd[:, None, None], (len(psds), 1, psds.shape[2])).astype(psds.dtype)
    return np.concatenate([psds[:, :n_groups], noise], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Given:
    """What every update needs of the recording: traces of products with adjugates."""

    cross: Real  # tr(R_k adj(x x^H)), (n_freqs, n_groups, n_frames)
    gram: Real  # tr(R_j adj(R_k)), (n_freqs, n_groups, n_groups)
    beside: Real  # n tr(R_k adj(N)), (n_freqs, n_groups, 1 or n_frames)
    noise_cross: Real  # n tr(N adj(x x^H)), (n_freqs, n_frames)
    noise: Real  # n^2 tr(N adj(N)), (n_freqs, 1 or n_frames)

    @classmethod
    def of(cls, observed: Real, covariances: Real, noise_psd: Real, field: Real | None) -> _Given:
        cross = covariances @ adjugate(observed, axis=1)
        gram = covariances @ np.swapaxes(adjugate(covariances), 1, 2)
        noise = noise_psd[:, None]
        sources = np.ascontiguousarray(gram[:, :-1, :-1])
        if field is not None:
            opposite = adjugate(field, axis=1)
            across = (field * adjugate(observed, axis=1)).sum(axis=1)
            beside, own = covariances[:, :-1] @ opposite, (field * opposite).sum(axis=1)
            kept = np.ascontiguousarray(cross[:, :-1])
            return cls(kept, sources, noise[..., None] * beside, noise * across, noise**2 * own)
        beside, own = noise[..., None] * gram[:, :-1, -1:], noise**2 * gram[:, -1:, -1]
        return cls(np.ascontiguousarray(cross[:, :-1]), sources, beside, noise * cross[:, -1], own)


def _updated(psds: Real, given: _Given, rows: slice) -> Real:
    """One multiplicative update of the sources, (n_rows, n_groups, n_frames), above 0."""
    cross, beside = given.cross[rows], given.beside[rows]
    mixed = given.gram[rows] @ psds
    mixed += beside
    ratio = np.asarray(cross / mixed)
    mixed += beside
    total = np.einsum("fkt,fkt->ft", psds, cross)
    total += given.noise_cross[rows]
    total *= 2
    total /= np.einsum("fkt,fkt->ft", psds, mixed) + given.noise[rows]
    np.subtract(total[:, None], ratio, out=ratio)
    ratio *= psds
    np.fmax(ratio, TINY, out=ratio)  # also where matrices cannot be inverted, and it is no number
    return ratio


def wiener(spectrogram: Complex, psds: Real, covariances: Real, noise: Real | None = None) -> Complex:
    """Multichannel Wiener output v_k e_1^T R_k S^-1 x of every group at microphone 1, (n_groups, n_freqs, n_frames).

    Parameters
    ----------
    spectrogram
        (2, n_freqs, n_frames).
    psds, covariances
        As of `source_psds`, the noise last.
    noise
        As of `source_psds`.
    """
    total = np.swapaxes(covariances, 1, 2) @ psds
    if noise is not None:
        total = np.swapaxes(covariances[:, :-1], 1, 2) @ psds[:, :-1] + psds[:, -1:] * noise
    whole = total[:, :1] * total[:, 1:2]
    inverse = adjugate(total, axis=1) / np.maximum(
        whole - 0.5 * (total[:, 2:] ** 2).sum(1, keepdims=True), ROUNDED * whole
    )
    cross = (inverse[:, 2] + 1j * inverse[:, 3]) / ROOT2
    first, second = spectrogram
    white = np.stack([inverse[:, 0] * first + cross * second, cross.conj() * first + inverse[:, 1] * second])
    signals = []
    for psd, matrix in zip(np.swapaxes(psds, 0, 1)[:-1], np.swapaxes(covariances, 0, 1)[:-1], strict=True):
        across = ((matrix[:, 2] + 1j * matrix[:, 3]) / ROOT2).astype(white.dtype)
        signals.append(psd * (matrix[:, :1] * white[0] + across[:, None] * white[1]))
    found = np.stack(signals)
    found[~(np.abs(found) < LOUDEST * np.abs(spectrogram).sum(axis=0) + TINY)] = 0  # of what has no inverse nothing
    return found


def long_frame(rate: float) -> int:
    """Return the size of a long frame [samples] at a rate [Hz]: it has four hops.

    >>> long_frame(16000), long_frame(44100)
    (2048, 5644)
    """
    return 4 * round(LONG * rate / 4)


def in_long_frames(separate: Callable[[Complex, Scene], Groups], spectrogram: Complex, scene: Scene) -> Groups:
    """Separate a recording in frames of 128 ms, in which more of the reverberation fits; masks are lost.

    Needs ``scene.hop``. What the separator gives is cut into the frames of the recording again.
    """
    frame, hop, rate = 2 * (scene.frequencies.size - 1), int(scene.hop or 0), round(2 * scene.frequencies[-1])
    size = long_frame(rate)
    given, longer = Stft(rate, frame, hop), Stft(rate, size, size // 4)
    n = spectrogram.shape[2] * hop - (frame - hop)
    noise = scene.noise_psd
    if noise is not None:
        noise = np.interp(longer.frequencies, scene.frequencies, noise) * size / frame
    inner = replace(scene, frequencies=longer.frequencies, noise_psd=noise, hop=longer.hop)
    groups = separate(longer.analyse(given.synthesise(spectrogram, n)), inner)
    signals = given.analyse(longer.synthesise(groups.signals, n))
    return replace(groups, signals=signals, masks=None)


def reverberant(spectrogram: Complex, scene: Scene) -> bool:
    """Whether longer frames would help, and can be had: the hop is known and the room is not dry.

    Among noise that has a direction they are not tried: what no talker explains would pass for reverberation.
    """
    frame = 2 * (scene.frequencies.size - 1)
    if scene.noise_field is not None:
        return False
    if scene.hop is None or scene.tau is None or spectrogram.shape[2] * scene.hop <= frame - scene.hop:
        return False
    if frame >= long_frame(2 * scene.frequencies[-1]):
        return False
    use = band(scene.frequencies, *VOICE)
    heard = spectrogram[:, use]
    noise = guessed_psd(heard) if scene.noise_psd is None else np.asarray(scene.noise_psd)[use]
    waves = direct(scene.frequencies[use], np.asarray(scene.tau))
    return astray(outer(heard), scene.frequencies[use], waves, noise) > ASTRAY[1]


Core = Callable[[Complex, Scene, Real], tuple[Complex, Real, tuple[Quality, ...]]]


def from_directions(
    core: Core,
    spectrogram: Complex,
    scene: Scene,
    name: str,
    *,
    always_below: float = 0.0,
    larger: float | None = None,
) -> Groups:
    """Separate a recording (2, n_freqs, n_frames) at unit power, in the frequencies in which somebody is heard.

    A reverberant one is separated in long frames. Sources that share a TDOA are one group. Where the noise has a
    direction every bin is divided by the level of the noise there before, and multiplied by it again afterwards.

    Parameters
    ----------
    core
        From mixture, scene (its ``tau`` those of the groups) and noise PSD of those frequencies: signals and Wiener
        masks, both (n_groups, n_freqs, n_frames), and how clean every group is.
    name
        Of the separator.
    always_below
        Frequencies [Hz] that count though nobody is heard there.
    larger
        As of `ross_payload.separation.evened_noise.evened`.

    Raises
    ------
    ConfigError
        When the TDOAs are not known.
    """
    members, delays = directions_of(scene, f"the {name} model")
    if reverberant(spectrogram, scene):
        return in_long_frames(partial(from_directions, core, name=name, always_below=always_below), spectrogram, scene)
    shape = (len(members), *spectrogram.shape[1:])
    signals, masks = np.zeros(shape, spectrogram.dtype), np.zeros(shape, np.float32)
    power = float((np.abs(spectrogram) ** 2).mean()) if spectrogram.size else 0.0
    if scene.noise_field is not None and members and power > 0:
        return replace(_in_noise(core, spectrogram, scene, delays, larger), members=members, method=name)
    quality: tuple[Quality, ...] = ()
    if members and power > 0:
        unit = (spectrogram / np.sqrt(power)).astype(np.complex64)
        noise = guessed_psd(unit) if scene.noise_psd is None else scene.noise_psd / power
        noise = np.maximum(noise, FLOOR).astype(np.float32)
        use = (np.abs(unit) ** 2).mean(axis=(0, 2)) > ACTIVE * noise
        use |= scene.frequencies < always_below
        part = replace(scene, frequencies=scene.frequencies[use], tau=delays)
        if use.any():
            with np.errstate(all="ignore"):  # a rumble is as coherent as can be, and its covariances have no inverse
                found, masks[:, use], quality = core(unit[:, use], part, noise[use])
            signals[:, use] = found * np.sqrt(power)
            masks[~np.isfinite(masks)] = 0
    return Groups(signals, members, name, masks=masks, quality=quality)


def _in_noise(core: Core, spectrogram: Complex, scene: Scene, delays: Real, larger: float | None) -> Groups:
    """Separate in the frequencies of voices; the noise term is larger than the noise, which is not all Gaussian."""
    even = evened(spectrogram, scene, delays, larger)
    signals = np.zeros((len(delays), *spectrogram.shape[1:]), spectrogram.dtype)
    masks = np.zeros(signals.shape, np.float32)
    with np.errstate(all="ignore"):
        found, masks[:, even.used], quality = core(even.unit, even.scene, even.noise_psd)
    signals[:, even.used] = found * even.level
    return Groups(signals, (), "", masks=masks, quality=quality)


class Gaussian:
    """The separator: local Gaussian model from known TDOAs."""

    name = "gaussian"

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the same model frame by frame."""
        return LiveGaussian(lookahead)

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate as `from_directions` says."""
        return from_directions(_separated, spectrogram, scene, self.name)


def _separated(unit: Complex, scene: Scene, noise_psd: Real) -> tuple[Complex, Real, tuple[Quality, ...]]:
    _, covariances, psds = fitted(unit, scene, noise_psd)
    masks = np.swapaxes(psds[:, :-1] / psds.sum(axis=1, keepdims=True), 0, 1)
    return wiener(unit, psds, covariances, scene.noise_field), masks, qualities(psds, covariances)


def fitted(unit: Complex, scene: Scene, noise_psd: Real, updates: int = UPDATES) -> tuple[Real, Real, Real]:
    """Coordinates of x x^H, of every covariance, and the PSDs: the arguments and the result of `source_psds`.

    Parameters
    ----------
    unit
        Mixture of mean power 1, (2, n_freqs, n_frames).
    scene
        Its ``tau`` are those of the groups [s], (n_groups,).
    noise_psd
        (n_freqs,).
    updates
        Of the PSDs.
    """
    observed = outer(unit).astype(np.float32)
    waves = direct(scene.frequencies, np.asarray(scene.tau)).astype(np.float32)
    part = astray(observed, scene.frequencies, waves, noise_psd)
    start, anchor = geometric_start(scene, waves, part)
    covariances, shares = learn(observed, start, noise_psd, anchor)
    white = np.broadcast_to(np.array([1, 1, 0, 0], np.float32), (len(start), 1, 4))
    covariances = np.concatenate([covariances, white], axis=1)
    psds = source_psds(observed, covariances, noise_psd, shares, noise=scene.noise_field, updates=updates)
    return observed, covariances, psds


separator = Gaussian()
