"""The separator `paper`: what Algorithm 2 of the paper takes, IVA up to three sources and DUET for more."""

from __future__ import annotations

from dataclasses import replace

from ross_payload.dsp import duet, natural
from ross_payload.interfaces import Complex, Groups, Scene

MOST = 3  # sources that, aligned, are two groups: as many as microphones


class Algorithm2:
    """Natural-gradient IVA when K <= 3, else DUET."""

    name = "paper"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames); `Groups.method` says which of the two it was."""
        method = natural.separator if scene.n_sources <= MOST else duet.separator
        return replace(method.batch(spectrogram, scene), why=f"K = {scene.n_sources}, as in Algorithm 2")


separator = Algorithm2()
