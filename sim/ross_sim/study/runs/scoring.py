"""Separate one recording by every separator of a study and score the targets."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ross_payload.alignment.plan import isolation
from ross_payload.dsp.metrics import si_sdr
from ross_payload.interfaces import Real, Separator
from ross_payload.plugin_checks import load_separator
from ross_sim.study.oracle_separators import ORACLES
from ross_sim.study.rows.result_rows import DIGITS, Separation, degrees, number
from ross_sim.study.runs.study_design import Study
from ross_sim.study.scenes.mixtures import Mixture, scene_of
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND

NOISE_BLIND = frozenset({"mvdr", "lcmv", "iva", "ilrma", "fastmnmf2"})  # never look at the noise PSD


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """What the separators are told about the talkers."""

    tau: Real  # TDOA of every source at the heading of the recording [s], (n_sources,)
    true: bool = True  # else oracles are left out


@dataclass(frozen=True, slots=True, eq=False)
class Separated:
    """What one separator makes of a recording."""

    separator: str
    noise: str  # known or unknown to the separator
    voices: Real  # (n_groups, n)
    members: tuple[tuple[int, ...], ...]
    cpu: float  # [s]

    def voice_of(self, source: int) -> Real | None:
        """The group that holds a source, (n,); None when none does or it is silent."""
        for voice, members in zip(self.voices, self.members, strict=True):
            if source in members and np.ptp(voice) > 0:
                return np.asarray(voice)
        return None


def columns(study: Study, *, oracles: bool) -> list[tuple[str, str]]:
    """Separators and what they know of the noise; those that never look at it appear once."""
    found = []
    for name in study.separators:
        if name in ORACLES:
            found += [(name, "known")] * oracles
        else:
            found += [(name, noise) for noise in (("known",) if name in NOISE_BLIND else study.noise)]
    return found


def tools_of(study: Study) -> dict[str, Separator]:
    """Load the separators of a study; oracles are none."""
    names = [name for name in study.separators if name not in ORACLES]
    return {name: load_separator(name) for name in names}


def separations(
    study: Study, tools: Mapping[str, Separator], recording: Mixture, belief: Belief
) -> Iterator[Separated]:
    """What every separator makes of a recording."""
    stft, n = study.stft, recording.mixture.shape[1]
    mixture = stft.analyse(recording.mixture)
    known, tau = scene_of(recording, stft, known_noise=True), belief.tau
    scene = replace(known, n_sources=tau.size, tau=tau, seed=study.seed)
    for name, noise in columns(study, oracles=belief.true):
        began, told = time.process_time(), scene if noise == "known" else replace(scene, noise_psd=None)
        members: tuple[tuple[int, ...], ...] = tuple((k,) for k in range(tau.size))
        if name in ORACLES:
            voices = ORACLES[name](recording.images, recording.mixture - recording.images.sum(axis=0), stft)
        else:
            groups = tools[name].batch(mixture, told)
            voices, members = stft.synthesise(groups.signals, n), groups.members
        yield Separated(name, noise, voices, members, time.process_time() - began)


def scored(
    row: Separation, recording: Mixture, separated: Separated, *, source: int, heading: float, azimuths: Real
) -> Separation:
    """Complete a row: SI-SDR of the group that holds ``source``, against the target alone at microphone 1.

    The isolation is the one that the target truly has, with all talkers at ``azimuths`` [rad].
    """
    apart = 1e6 * float(isolation(azimuths, [heading], SPACING, SPEED_OF_SOUND)[recording.target, 0])
    row = replace(row, separator=separated.separator, noise=separated.noise)
    row = replace(row, heading_deg=degrees(heading), isolation_us=number(apart))
    voice = separated.voice_of(source)
    if voice is None:
        return replace(row, missed=True)
    before, after = si_sdr(recording.mixture[0], recording.reference), si_sdr(voice, recording.reference)
    return replace(
        row, si_sdr_in_db=number(before), si_sdr_out_db=number(after), si_sdri_db=round(after - before, DIGITS)
    )
