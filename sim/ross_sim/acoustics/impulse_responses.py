"""The impulse responses of one room, kept on disk heading by heading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples
from ross_sim.acoustics.room import PYROOMACOUSTICS, RoomSpec, n_taps, respond
from ross_sim.cache import Array, cache_folder, cached, fingerprint

TURN = 6_283_185  # [microradian], once around


def microradians(heading: float) -> int:
    """Round a heading [rad] to whole microradians within one turn: the name it goes by in the cache.

    >>> microradians(-0.5) == microradians(2 * np.pi - 0.5)
    True
    """
    return round(heading * 1e6) % TURN


class Responses:
    """The impulse responses of one room, heading by heading: simulated once, then read from disk.

    Headings are rounded to one microradian, which moves a microphone by nanometres. Another version of the library
    that simulates them (`ross_sim.acoustics.room`) has responses of its own.
    """

    def __init__(self, spec: RoomSpec, folder: Path | None = None) -> None:
        self._spec = spec
        self.n_taps = n_taps(spec)
        key = fingerprint(
            size=spec.size,
            t60=spec.t60,
            rate=spec.rate,
            array_centre=spec.array_centre,
            spacing=spec.spacing,
            sources=spec.sources,
            speed_of_sound=spec.speed_of_sound,
            pyroomacoustics=PYROOMACOUSTICS,
            layout=2,
        )
        self._folder = cache_folder(folder) / "rooms" / key

    def at(self, heading: float) -> Samples:
        """Return the responses at a heading [rad], (2, n_sources, n_taps)."""
        return self._kept(microradians(heading), {})

    def over(self, headings: Sequence[float]) -> Samples:
        """Return the responses at several headings [rad], (n_headings, 2, n_sources, n_taps).

        Those that are not on disk are simulated together, which finds the images of every source once, not once for
        each heading.
        """
        steps = [microradians(heading) for heading in headings]
        missing = [step for step in dict.fromkeys(steps) if not self._path(step).exists()]
        made = respond(self._spec, [step * 1e-6 for step in missing])
        return np.stack([self._kept(step, dict(zip(missing, made, strict=True))) for step in steps])

    def _path(self, step: int) -> Path:
        return self._folder / f"{step:07d}.npz"

    def _kept(self, step: int, made: Mapping[int, Samples]) -> Samples:
        """What is on disk for a heading [microradian]; what is missing there comes from ``made``, or is simulated."""

        def make() -> dict[str, Array]:
            return {"responses": made[step] if step in made else respond(self._spec, [step * 1e-6])[0]}

        path = self._path(step)
        responses = cached(path, make).get("responses")
        if responses is None or responses.dtype != np.float32 or responses.shape[:2] != (2, len(self._spec.sources)):
            raise ConfigError(f"{path}: expected impulse responses, got something else; delete it")
        return responses
