"""Explorations with known talkers to fit `ross_payload.localization.talker_evidence` to.

Around the array in every room, 36 places are simulated once; every scene puts talkers into some of them. The rooms are
those of `room_settings`, two more with the array off their middle, and the open with talkers below the array. In three
of four scenes all talkers are equally loud and the noise is 15 dB below them; in the fourth they differ by up to 6 dB,
and the noise is 8 to 25 dB below. Scenes can be kept in a folder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from pathlib import Path

import numpy as np
import scipy.fft

from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.cache import Array, cached
from ross_sim.study.elevation_study import FIELDS
from ross_sim.study.scenes.exploration import BEFORE, STEP, UNIT
from ross_sim.study.scenes.mixtures import APART, RATE, SNR_DB
from ross_sim.study.scenes.room_settings import ARRAY, SETTINGS, SPACING, SPEED_OF_SOUND, Setting
from ross_sim.study.training.training_voices import voices_fingerprint

PLACES = 36
HEADINGS = STEP * np.arange(13)
SCENES = {1: 6, 2: 18, 3: 36, 4: 42, 5: 48}  # in every true room, by the number of talkers
IN_PLANES = {1: 2, 2: 5, 3: 8, 4: 8, 5: 10}
SILENT = 12  # scenes of noise alone
LOUDER_DB, SNRS_DB = 3.0, (8.0, 25.0)  # of every fourth scene
LEVEL = 0.05  # root mean square of what is kept, of full scale
FULL = 32767
Places = Callable[[], tuple[Real, Samples]]


@dataclass(frozen=True, slots=True)
class OffCentre(Setting):
    """A room with the array somewhere else than in its middle."""

    at: tuple[float, float] = (0.0, 0.0)  # [m]

    @property
    def centre(self) -> tuple[float, ...]:
        """Where the array is [m]."""
        return (*self.at, ARRAY)


ROOMS: dict[str, Setting] = SETTINGS | {
    "C0.35": OffCentre("C0.35", (7.0, 5.5, 2.7), 0.33, (3.3, 2.9)),
    "D0.5": OffCentre("D0.5", (11.0, 8.0, 3.4), 0.45, (4.6, 3.4)),
    "above": FIELDS[1],
}


@dataclass(frozen=True, slots=True, eq=False)
class EvidenceScene:
    """What the array hears at every heading of `HEADINGS`, and who talks."""

    name: str
    heard: Real  # (n_headings, 2, n_samples), float32
    azimuths: Real  # [rad], (k,)


def scenes(rooms: Sequence[str], voices: Sequence[Samples], seed: int, folder: Path | None) -> Iterator[EvidenceScene]:
    """Make the scenes of some rooms, or read those that ``folder`` keeps; voices are (n,) at `RATE`."""
    if folder is not None:
        folder /= voices_fingerprint({str(index): voice for index, voice in enumerate(voices)})
    for index in range(SILENT):
        rng = np.random.default_rng([seed, index])
        noise = LEVEL * rng.standard_normal((len(HEADINGS), 2, round(UNIT * RATE)))
        yield EvidenceScene(f"silent-0-{index}-{seed}", noise.astype(np.float32), np.zeros(0))
    for room in rooms:
        drawn = SCENES if not ROOMS[room].flat and ROOMS[room].t60 else IN_PLANES
        names = [(k, n, f"{room}-{k}-{n}-{seed}.npz") for k, count in drawn.items() for n in range(count)]
        places = cache(partial(simulated, room, seed))
        for k, n, name in names:

            def made(room: str = room, k: int = k, n: int = n, places: Places = places) -> dict[str, Array]:
                rng = np.random.default_rng([seed, _number(room), k, n])
                heard, azimuths = mixed(*places(), voices, k, odd=n % 4 == 3, rng=rng)
                return {"x": heard, "az": azimuths}

            kept = made() if folder is None else cached(folder / name, made)
            yield EvidenceScene(name.removesuffix(".npz"), kept["x"].astype(np.float32) / FULL, kept["az"])


def _number(room: str) -> int:
    return sum(map(ord, room))


def simulated(room: str, seed: int) -> tuple[Real, Samples]:
    """Azimuths [rad] of the places of a room, (n,), and the responses from there, (n_headings, 2, n, n_taps)."""
    setting, rng = ROOMS[room], np.random.default_rng([seed, _number(room)])
    azimuths = -np.pi + 2 * np.pi * (np.arange(PLACES) + rng.uniform(0.05, 0.95, PLACES)) / PLACES
    places = tuple(map(tuple, setting.places(azimuths, rng).tolist()))
    spec = RoomSpec(setting.size, setting.t60, RATE, setting.centre, SPACING, places, SPEED_OF_SOUND)
    return azimuths, respond(spec, HEADINGS.tolist())


def mixed(
    azimuths: Real, responses: Samples, voices: Sequence[Samples], k: int, *, odd: bool, rng: np.random.Generator
) -> tuple[Real, Real]:
    """What both microphones hear of ``k`` random voices, 16 bits, and the azimuths [rad], (k,).

    What is heard is (n_headings, 2, n_samples).
    """
    chosen = rng.permutation(len(azimuths))[:k]
    while _nearest(azimuths[chosen]) < APART:
        chosen = rng.permutation(len(azimuths))[:k]
    louder = 10 ** (rng.uniform(-LOUDER_DB, LOUDER_DB, k) / 20) if odd else np.ones(k)
    snr = rng.uniform(*SNRS_DB) if odd else SNR_DB
    talkers = [voices[index] for index in rng.permutation(len(voices))[:k]]
    unit, before = round(UNIT * RATE), round(BEFORE * RATE)
    n = scipy.fft.next_fast_len(unit + before + responses.shape[-1] - 1, real=True)
    spectrum = np.zeros((len(HEADINGS), 2, n // 2 + 1), dtype=complex)
    for source, voice, gain in zip(chosen, talkers, louder, strict=True):
        speech = np.resize(np.roll(voice, -int(rng.integers(len(voice)))), unit * len(HEADINGS) + before)
        pieces = np.stack([speech[r * unit : (r + 1) * unit + before] for r in range(len(HEADINGS))])
        image = scipy.fft.rfft(pieces, n)[:, None] * scipy.fft.rfft(responses[:, :, source], n)
        first = scipy.fft.irfft(image[:, 0], n)[:, before : before + unit]
        spectrum += gain * image / np.sqrt(np.mean(first**2))
    heard = scipy.fft.irfft(spectrum, n)[..., before : before + unit]
    heard += np.sqrt(np.mean(heard[:, 0] ** 2)) * 10 ** (-snr / 20) * rng.standard_normal(heard.shape)
    whole = np.round(heard * LEVEL / np.sqrt(np.mean(heard**2)) * FULL)
    return np.clip(whole, -FULL, FULL).astype(np.int16), azimuths[chosen]


def _nearest(azimuths: Real) -> float:
    """The smallest angle between two azimuths [rad]; pi for one."""
    apart = [abs(np.angle(np.exp(1j * (one - other)))) for one, other in product(azimuths, azimuths) if one != other]
    return min(apart, default=np.pi)
