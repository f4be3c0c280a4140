"""Follow the sources while the mission listens: every hop is heard, and every quarter of a second they are tracked.

Nothing of this waits for a separation. A track *acts* only when its source has left its place for sure and somebody
else has not: until then azimuths are those of the exploration, which are sharper; and when everybody has moved alike it
is the array that has slipped. What a dead or saturated microphone gives, or one in both channels, tells nothing of
anybody, and is no reason to turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ross_payload.alignment.realignment import Beliefs, worth
from ross_payload.angles import difference, wrap
from ross_payload.dsp.noise import guessed_psd, quiet_psd
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourcesTracked
from ross_payload.interfaces import Complex, Input, Real, Samples
from ross_payload.localization import tracking
from ross_payload.localization.phase_likelihood import excess
from ross_payload.localization.phase_statistics import statistics
from ross_payload.localization.track_hypotheses import Tracks
from ross_payload.pointing import Pointing

UPDATE = 0.25  # [s] between corrections
SAY = 0.5  # [s] between events
ECHOES = 0.1  # heard before frames to know which echoes are still to come [s]
LEVEL = 3.0  # heard for the noise level where nobody measured it [s]
TURNING = np.radians(30.0)  # frames heard while the array turns faster tell of its motor [rad/s]
MOVED = np.radians(5.0)  # away from the place of the exploration [rad]
SURE = 0.7  # probability of that, from which on the source has moved
STIRRED = 0.7  # probability that anybody has moved from which on a turn may tell who
UNSURE = 0.6  # and up to which it has not
HEARD = (0.08, 0.12)  # change of its delay that cannot come from echoes, in the open and in planes [d / v_p]
FAR_OFF = np.radians(10.0)  # away from the place of the exploration: off the axis, more than echoes can do [rad]
CLEAR = 0.4  # sigma over how far a source is from that place, up to which it is clear where it is
ASIDE = np.sin(np.radians(5.0))  # of its angle to the axis: nearer to it nobody is clear
TELLING = 1.3  # times that, the delay of who stays would have changed if the array had slipped
LASTING = 2  # corrections in a row that must say so
LONGER = 15  # more of them for every unit by which reflections draw delays to 0 more than in a plane
FAR = 3  # a correction says it for as many as its delay has changed by times HEARD, at most so many
ALIKE = np.radians(5.0)  # between the shifts of sources that a slip has moved [rad]
FRESH = 1.0  # a source that was heard within this can witness [s]
LOST = 0.5  # probability of the likeliest place, below which a track is lost
SHORT = np.radians(30.0)  # turns are no longer than this [rad]
FINE = np.radians(2.5)  # between headings that are tried [rad]
MARGIN_DB = 0.7  # a turn must promise more than this [dB]
PER_DEGREE = 0.02  # and so much for every degree [dB]
UNSEEN = np.radians(6.5)  # standard deviation from which on a turn may tell whether somebody has moved [rad]
DWELL = 2.0  # [s] at rest between turns
AGAIN = 0.3  # of the time for which nobody has moved, that a look is later than the turn before it
AHEAD = 0.75  # [s] that a turn is planned ahead


@dataclass(slots=True)
class SourceTracker:
    """What is known of the sources since the listening began."""

    anchor: Estimate  # of the exploration, or told
    source: int  # that is listened to
    stft: Stft
    spacing: float  # [m]
    speed_of_sound: float  # [m/s]
    lead_in: Samples | None  # (2, n)
    noise_psd: Real | None  # known already, (n_freqs,)
    rested: float = 0.0  # for how long the sources were heard before, at rest [s]
    tracks: Tracks = field(init=False)
    moved: list[bool] = field(init=False)  # whose track acts
    stirred: bool = False  # somebody has moved, whoever it is
    deaf: bool = False  # what is heard next tells of no direction, as of `Hearing`
    turned: float = -np.inf  # end of the latest turn [s]
    places: list[tuple[float, Real]] = field(default_factory=list)  # time [s] and azimuths that act [rad]
    _streak: list[int] = field(init=False)
    _stir: int = 0
    _samples: Samples = field(init=False)  # not forgotten yet, (2, n)
    _blocks: list[Samples] = field(default_factory=list)  # heard since
    _ends: list[tuple[int, float, bool]] = field(default_factory=list)  # sample, heading there [rad], and `deaf`
    _first: int = 0  # index of the first sample that is kept, since tracking began
    _frames: int = 0  # told
    _planned: int = -1  # of them, when a turn was last considered
    _began: float = 0.0  # to hear [s]
    _said: float = 0.0
    _deaf_until: float = -np.inf  # [s]

    def __post_init__(self) -> None:
        """Begin where the exploration has found the sources."""
        self.tracks = tracking.begin(self.anchor, self.spacing, self.speed_of_sound)
        self.moved, self._streak = [False] * self.anchor.k, [0] * self.anchor.k
        self._samples = np.zeros((2, 0), np.float32)

    @property
    def acts(self) -> bool:
        """Whether anybody has moved."""
        return any(self.moved)

    @property
    def anybody(self) -> bool:
        """Whether somebody has moved, known who or not."""
        return self.acts or self.stirred

    @property
    def lost(self) -> bool:
        """Whether it is not known any more where the source is that is listened to, though it could be heard."""
        return self.acts and not self.deaf and bool(self.tracks.held[self.source] < LOST)

    @property
    def azimuths(self) -> Real:
        """Where the sources are taken to be [rad], (k,)."""
        homes = self.anchor.azimuths
        return np.where(self.moved, self.tracks.azimuths + self.tracks.rates * self.behind, homes)

    @property
    def _echoed(self) -> float:
        """Change of a delay that may come from echoes [d / v_p]."""
        return HEARD[self.tracks.wet] + excess(self.tracks.amplitude)

    @property
    def behind(self) -> float:
        """How long ago the middle of what was heard last was, for which the tracks stand [s]."""
        return (UPDATE + self.stft.frame / self.stft.rate) / 2

    @property
    def estimate(self) -> Estimate:
        """The exploration's estimate with the sources where they are."""
        sources = tuple(
            replace(source, azimuth=float(azimuth), sigma=float(sigma), nominal_sigma=None)
            for source, azimuth, sigma in zip(self.anchor.sources, self.azimuths, self.tracks.sigmas, strict=True)
        )
        return replace(self.anchor, sources=sources)

    def hear(self, hop: Input, time: float) -> SourcesTracked | None:
        """Hear one hop that ends at a mission time [s]; return what there is to say now and then."""
        block = hop.block.samples
        if not self._ends:
            self._ends.append((0, hop.heading_start, self.deaf))
            self._began = self._said = time
        last, heading, _ = self._ends[-1]
        self._ends.append((last + block.shape[1], heading + wrap(hop.pointing.heading - heading), self.deaf))
        self._blocks.append(block)
        if not self._due(last + block.shape[1]):
            return None
        self._update(last + block.shape[1])
        if not self.deaf:
            self.corrected(time)
        self.places.append((time, self.azimuths))
        if time - self._said < SAY - UPDATE / 2:
            return None
        self._said = time
        rates = np.where(self.moved, self.tracks.rates, 0.0)
        return SourcesTracked(time, self.estimate, tuple(rates.tolist()), tuple(self.tracks.ages.tolist()))

    def _due(self, n_samples: int) -> bool:
        ready = (n_samples - self.stft.frame) // self.stft.hop + 1
        return (ready - self._frames) * self.stft.period >= UPDATE

    def _update(self, n_samples: int) -> None:
        ready = (n_samples - self.stft.frame) // self.stft.hop + 1
        self._samples, self._blocks = np.concatenate([self._samples, *self._blocks], axis=1), []
        before = min(self._frames, round(ECHOES / self.stft.period))
        first = (self._frames - before) * self.stft.hop - self._first
        spectrogram = _frames(self._samples[:, first:], self.stft, ready - self._frames + before)
        middles = (np.arange(self._frames - before, ready) + 0.5) * self.stft.hop + (
            self.stft.frame - self.stft.hop
        ) / 2
        ends, headings, deaf = np.array(self._ends).T
        at = np.interp(middles, ends, headings)
        span = self.stft.frame / 2
        swept = np.interp(middles + span, ends, headings) - np.interp(middles - span, ends, headings)
        still = np.abs(swept) * self.stft.rate / self.stft.frame <= TURNING
        still &= np.interp(middles, ends, deaf) == 0
        found = statistics(
            spectrogram,
            self.stft.frequencies,
            at,
            self._noise(spectrogram),
            period=self.stft.period,
            skip=before,
            still=still,
        )
        self.tracks = tracking.step(self.tracks, found)
        self._frames = ready
        keep = ready * self.stft.hop - round(LEVEL * self.stft.rate)
        if keep > self._first:
            self._samples, self._first = self._samples[:, keep - self._first :], keep
            self._ends = [end for end in self._ends if end[0] >= keep]

    def _noise(self, spectrogram: Complex) -> Real | None:
        if self.noise_psd is None and self.lead_in is not None and self.lead_in.shape[1] >= self.stft.frame:
            self.noise_psd = quiet_psd(self.stft.analyse(self.lead_in), spectrogram)
            self.lead_in = None
        if self.noise_psd is not None:
            return self.noise_psd
        return guessed_psd(
            _frames(self._samples, self.stft, (self._samples.shape[1] - self.stft.frame) // self.stft.hop + 1)
        )

    def corrected(self, time: float) -> None:
        """Decide at a mission time [s] who has moved: for sure, for a while, and beside somebody who has not."""
        homes = self.anchor.azimuths
        echoes = excess(self.tracks.amplitude)  # [d / v_p], at broadside also [rad]
        each, anybody = self.tracks.gone(homes, MOVED, self._echoed)
        each = np.maximum(each, self._clear(homes, FAR_OFF + echoes))
        witness = self._witness(homes, each)
        if not witness and self._alike(homes, each >= SURE):
            self.moved, self.stirred = [False] * self.anchor.k, False
        self._stir = self._stir + 1 if anybody >= STIRRED else 0
        self.stirred = self.stirred or (witness and self._stir >= LASTING // 2)
        far = np.clip(self._changed(homes) / self._echoed, 1, FAR)
        lasting = LASTING + int(LONGER * echoes)
        for k in range(self.anchor.k):
            certain = each[k] >= SURE and self.tracks.ages[k] <= UPDATE
            self._streak[k] = 0 if each[k] <= UNSURE else self._streak[k] + int(certain) * int(far[k])
            self.moved[k] = self.moved[k] or (witness and self._streak[k] >= lasting)

    def _clear(self, homes: Real, far: float) -> Real:
        """Probability that every source is ``far`` [rad] from its place, 0 where it is not clear where it is, (k,).

        A source that walks near the axis, or past the mirror image of its place, may have the delay of that place for
        long. What echoes feign near the axis has a mirror image itself, and is not clear; nor is the axis, which has
        none: a delay that they draw to 0 less than expected is that of a source on the axis.
        """
        away, _ = self.tracks.gone(homes, far, 0.0)
        now, axis = self.tracks.azimuths, self.tracks.heading
        clear = (self.tracks.sigmas <= CLEAR * np.abs(difference(now, homes))) & (np.abs(np.sin(now - axis)) >= ASIDE)
        return np.asarray(away * clear)

    def _changed(self, homes: Real) -> Real:
        """By how much the delays at this heading differ from those at the azimuths that were told [d / v_p], (k,)."""
        now, then = (np.cos(each - self.tracks.heading) for each in (self.tracks.azimuths, homes))
        return np.asarray(np.abs(self.tracks.elevations * (now - then)))

    def _witness(self, homes: Real, gone: Real) -> bool:
        """Whether somebody stays whose delay would have changed, too, if the array had slipped; nobody else: yes."""
        if self.anchor.k == 1:
            return True
        shift = float(difference(self.tracks.azimuths, homes)[gone.argmax()])
        axis = homes - self.tracks.heading
        slipped = np.abs(self.tracks.elevations * (np.cos(axis + shift) - np.cos(axis)))
        return bool(np.any((slipped > TELLING * self._echoed) & (self.tracks.ages <= FRESH) & (gone <= UNSURE)))

    def _alike(self, homes: Real, gone: NDArray[np.bool_]) -> bool:
        """Whether two sources at least are gone, all by the same angle."""
        shifts = difference(self.tracks.azimuths, homes)[gone]
        return len(shifts) > 1 and bool(np.ptp(shifts) <= ALIKE)

    def heading_for(self, time: float, here: Pointing, lower: float, upper: float, *, settled: bool) -> float | None:
        """Return the heading [rad] to turn to now, None to stay.

        Where it is worth clearly more than the present one, at most 30 degrees away, within the limits of the joint
        [rad]; not before somebody has moved, or may have unseen, not soon after another turn, nor while it is deaf.
        """
        if not settled:
            self.turned = time
        if self.deaf:
            self._deaf_until = time
        if time - max(self.turned, self._deaf_until) < DWELL or self._planned == self._frames:
            return None
        self._planned = self._frames  # nothing new is known before the next correction
        if not (self.anybody or self._looks(time)):
            return None
        ahead = tracking.predict(self.tracks, AHEAD)
        offsets = np.arange(-round(SHORT / FINE), round(SHORT / FINE) + 1) * FINE
        offsets = offsets[(here.joint + offsets >= lower) & (here.joint + offsets <= upper) | (offsets == 0.0)]
        odds, ways = ahead.ways
        beliefs = Beliefs(odds, ways, ahead.azimuths, ahead.spreads, ahead.elevations, self.anchor.directness)
        value = worth(beliefs, self.source, here.heading + offsets)
        gain = value - value[offsets == 0.0] - PER_DEGREE * np.degrees(np.abs(offsets))
        if gain.max() <= MARGIN_DB:
            return None
        return float(here.heading + offsets[gain.argmax()])

    def _looks(self, time: float) -> bool:
        """Whether to look if anybody has moved unseen: the more seldom the longer all rest."""
        waited, rested = time - max(self.turned, self._began, self._deaf_until), self.rested + time - self._began
        return waited >= AGAIN * rested and bool(self.tracks.spreads.max(initial=0.0) > UNSEEN)

    def azimuths_at(self, times: Sequence[float] | Real) -> Real:
        """Where the sources were taken to be at mission times [s], (k, n_times); as they are now for times to come."""
        if not self.places:
            return np.repeat(self.azimuths[:, None], len(times), axis=1)
        known = np.array([time for time, _ in self.places])
        path = np.stack([azimuths for _, azimuths in self.places])
        steps = np.cumsum(np.vstack([path[:1], difference(path[1:], path[:-1])]), axis=0)
        return np.stack([np.interp(times, known, column) for column in steps.T])

    def forget(self, time: float) -> None:
        """Forget where the sources were before a mission time [s]."""
        self.places = [place for place in self.places if place[0] >= time - UPDATE]


def _frames(samples: Samples, stft: Stft, count: int) -> Complex:
    """The first ``count`` whole frames, (2, n_freqs, count)."""
    cut = sliding_window_view(samples[:, : (count - 1) * stft.hop + stft.frame], stft.frame, axis=-1)[:, :: stft.hop]
    return np.swapaxes(np.fft.rfft(cut * stft.window.astype(np.float32), axis=-1), -1, -2)
