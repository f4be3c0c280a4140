"""The separators that choose among the others and say why: `auto` by the scene, `paper` as Algorithm 2 does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ross_payload.dsp.covariance import direct, outer
from ross_payload.dsp.steering import ALIAS, groups_of
from ross_payload.interfaces import Complex, Groups, LiveSeparator, Scene, Separator
from ross_payload.separation import auxiva, duet, local_gaussian_model, natural_gradient_iva, refined
from ross_payload.separation.directness import directness_of

INFORMED, UNMIXING, ANY = refined.separator, auxiva.separator, duet.separator  # the best of those that know, and do not
AT_ONCE = local_gaussian_model.separator  # the best without a look-ahead
CLEAN_DB = 36.0  # from here on two groups in the open are unmixed rather than filtered
OPEN = 0.5  # directness
WIDE = 0.5  # TDOAs of two groups this far apart [d / v_p]
MOST_SOURCES = 3  # that, aligned, are two groups: as many as microphones


def choose(spectrogram: Complex, scene: Scene) -> tuple[Separator, str]:
    """Return the separator for a recording (2, n_freqs, n_frames) and the reason in words."""
    if scene.tau is not None and scene.noise_field is not None:
        return INFORMED, "directions known, noise that is not white"
    if scene.tau is not None:
        against = _against_unmixing(spectrogram, scene)
        if against:
            return INFORMED, f"directions known, {against}"
        return (UNMIXING, f"two groups wide apart in the open, {_ratio_db(spectrogram, scene):.0f} dB above the noise")
    if scene.n_sources == 2:
        return UNMIXING, "two sources, two microphones, directions unknown"
    return ANY, f"{scene.n_sources} sources, directions unknown"


def _against_unmixing(spectrogram: Complex, scene: Scene) -> str:
    """Why AuxIVA would not do better than a model of every bin; empty when it would."""
    longest = scene.spacing / scene.speed_of_sound
    members = groups_of(np.asarray(scene.tau), ALIAS * longest)
    if len(members) != 2:
        return f"{len(members)} group{'s' * (len(members) != 1)}, not two"
    if scene.noise_psd is None:
        return "noise unknown"
    if _ratio_db(spectrogram, scene) < CLEAN_DB:
        return f"{_ratio_db(spectrogram, scene):.0f} dB above the noise"
    first, second = (np.asarray(scene.tau)[list(group)].mean() for group in members)
    if abs(first - second) < WIDE * longest:
        return "two groups close together"
    return "in reverberation" if _directness(spectrogram, scene) < OPEN else ""


def _ratio_db(spectrogram: Complex, scene: Scene) -> float:
    power, noise = float((np.abs(spectrogram) ** 2).mean()), float(np.mean(scene.noise_psd))  # type: ignore[arg-type]
    return float(10 * np.log10(max(power, 1e-30) / max(noise, 1e-30)))


def _directness(spectrogram: Complex, scene: Scene) -> float:
    waves = direct(scene.frequencies, np.asarray(scene.tau))
    return directness_of(outer(spectrogram), scene.frequencies, waves, np.asarray(scene.noise_psd))


class Auto:
    """The separator that picks one of the others."""

    name = "auto"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) by the method that suits it; `Groups.why` says why."""
        method, why = choose(spectrogram, scene)
        return replace(method.batch(spectrogram, scene), why=why)

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the best that separates frame by frame: `refined` where it may look ahead, else `gaussian`."""
        return (INFORMED if lookahead else AT_ONCE).live(lookahead)


class Algorithm2:
    """Natural-gradient IVA when K <= 3, else DUET."""

    name = "paper"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames); `Groups.method` says which of the two it was."""
        method = natural_gradient_iva.separator if scene.n_sources <= MOST_SOURCES else duet.separator
        return replace(method.batch(spectrogram, scene), why=f"K = {scene.n_sources}, as in Algorithm 2")


separator = Auto()
paper = Algorithm2()
