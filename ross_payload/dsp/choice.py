"""The separator `auto`: chooses among the others and says why."""

from __future__ import annotations

from dataclasses import replace

from ross_payload.dsp import duet, gaussian, iva
from ross_payload.interfaces import Complex, Groups, Scene, Separator


def choose(scene: Scene) -> tuple[Separator, str]:
    """Return the separator for a scene and the reason in words."""
    if scene.tau is not None:
        return gaussian.separator, "the TDOAs are known"
    if scene.n_sources == 2:
        return iva.separator, "two sources, two microphones, directions unknown"
    return duet.separator, "more sources than microphones, directions unknown"


class Auto:
    """The separator that picks one of the others."""

    name = "auto"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) by the method that suits the scene."""
        method, why = choose(scene)
        return replace(method.batch(spectrogram, scene), why=f"{method.name}: {why}")


separator = Auto()
