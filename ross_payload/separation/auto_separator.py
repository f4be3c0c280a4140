"""The separators that choose among the others and say why: `auto` by the scene, `paper` as Algorithm 2 does."""

from __future__ import annotations

from dataclasses import replace

from ross_payload.interfaces import Complex, Groups, LiveSeparator, Scene, Separator
from ross_payload.separation import auxiva, duet, local_gaussian_model, natural_gradient_iva, refined

INFORMED = refined.separator  # the best of those that need directions
UNMIXING, ANY = auxiva.separator, duet.separator  # and of those that do not
AT_ONCE = local_gaussian_model.separator  # the best without a look-ahead
MOST_SOURCES = 3  # that, aligned, are two groups: as many as microphones


def choose(scene: Scene) -> tuple[Separator, str]:
    """Return the separator for a scene and the reason in words."""
    if scene.tau is not None:
        return INFORMED, f"directions known{', noise that is not white' if scene.noise_field is not None else ''}"
    if scene.n_sources == 2:
        return UNMIXING, "two sources, two microphones, directions unknown"
    return ANY, f"{scene.n_sources} sources, directions unknown"


class Auto:
    """The separator that picks one of the others."""

    name = "auto"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) by the method that suits it; `Groups.why` says why."""
        method, why = choose(scene)
        return _because(why, method.batch(spectrogram, scene))

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the best that separates frame by frame: `refined` where it may look ahead, else `gaussian`."""
        return (INFORMED if lookahead else AT_ONCE).live(lookahead)


class Algorithm2:
    """Natural-gradient IVA when K <= 3, else DUET."""

    name = "paper"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames); `Groups.method` says which of the two it was."""
        method = natural_gradient_iva.separator if scene.n_sources <= MOST_SOURCES else duet.separator
        return _because(f"K = {scene.n_sources}, as in Algorithm 2", method.batch(spectrogram, scene))


def _because(why: str, groups: Groups) -> Groups:
    """The groups of the method that was chosen, with the reason before what that method says itself."""
    return replace(groups, why=f"{why}; {groups.why}" if groups.why else why)


separator = Auto()
paper = Algorithm2()
