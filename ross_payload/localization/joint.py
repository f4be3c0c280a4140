"""All orientations at once: K and every azimuth from the ITD densities at all headings (`joint`).

Histograms of trustworthy ITDs (`itd_votes`) are explained as one mixture over all orientations (`itd_mixture`), with as
many sources as are worth their penalty (`model_order`). Every orientation has two histograms: the rich one, to which
quiet talkers contribute as well, tells how many there are; the strict one, of bins of one talker alone, tells where.

In the open, known by narrow kernels, an amplitude below 1 is the cosine of an elevation. In a reverberant room
reflections lower it too, and no elevation is told. Where the height of the array is known (`below`), every amplitude
is one. Where amplitudes above 1 explain far more, the array is taken for wider than it is configured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.dsp.density import itd_grid, kde, prominent_peaks
from ross_payload.dsp.itd import RULED, STRICT, Trust, band_limits, check_array, lowest_noise, period_of
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Complex, Observation, Real
from ross_payload.localization import below, itd_mixture, model_order, talker_evidence
from ross_payload.localization.itd_votes import Votes, votes
from ross_payload.localization.sectors import covered, cut, rows_of, together
from ross_payload.localization.talker_evidence import Evidence

COUNT = 0.5  # effective counts per unit of weight: neighbouring bins are not independent
BANDWIDTH = 0.04  # of the published density [d / v_p]
BIAS = np.deg2rad(0.3)  # of every azimuth, however long one listens [rad]
SHARED = 4.4  # growth of a standard deviation with what is not direct, beside 1
ROUNDS = 10  # of refinement on the strict histograms
WIDENED = 3  # times at most, one after the other
LOOSE = 0.5  # counts by which amplitudes are drawn to each other there
OPEN = 0.06  # kernels on the strict histograms are narrower than this in the open [d / v_p]
AMPLITUDE_BIAS = 0.008  # of an amplitude, however long one listens
LOW = 0.97  # amplitude; a greater one may be that of a source at elevation 0
CLEAR = 2.5  # standard deviations by which an amplitude must lie below 1
ELSEWHERE = np.deg2rad(20.0)  # an azimuth further off than this is another place [rad]
RESOLVED = 10.0  # log-likelihood by which the place must beat every other place [nat]


@dataclass(frozen=True, slots=True)
class Fit:
    """The mixture that was chosen."""

    step: model_order.Step
    rival: float  # worth over penalty of the last source that was turned down
    likely: float  # probability that there are as many talkers as sources, or more
    more: float  # the largest such probability of the mixtures with more sources
    second: Fit | None = None  # the likeliest of those


@dataclass(frozen=True, slots=True)
class Stop:
    """When enough has been heard."""

    margin: float = 2.0  # every source is worth this many times its penalty, the last rival this many times less
    doubt: float = 0.1  # largest probability that there are fewer talkers, and that there are more without a rival
    missed: float = 0.025  # largest probability that there are more: after the exploration nobody is looked for
    sigma: float = np.deg2rad(2.0)  # largest standard deviation [rad]
    orientations: int = 7
    evidence: float = 100.0  # effective counts


@dataclass(frozen=True, slots=True)
class Joint:
    """The explorer: what it needs to know about the array, and its settings."""

    spacing: float
    speed_of_sound: float
    trust: Trust = STRICT
    strict: Trust = RULED
    penalty: model_order.Penalty = field(default_factory=model_order.Penalty)
    enough: Stop = field(default_factory=Stop)
    name: str = "joint"

    def observe(
        self,
        spectrogram: Complex,
        frequencies: Real,
        heading: float,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
    ) -> Observation:
        """Condense one orientation into a histogram of trustworthy ITDs; see `interfaces.Explorer`.

        Frames of about 43 ms that overlap by three quarters serve best.
        """
        return self._observation(heading, self._votes(spectrogram, frequencies, noise_psd, frame_period))

    def observe_turning(
        self,
        spectrogram: Complex,
        frequencies: Real,
        headings: Real,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
        skip: int = 0,
    ) -> Observation:
        """Condense a period in which the array turned; see `interfaces.TurningExplorer`.

        The motor is heard, too: the noise is at least what the quietest frames hold. The published density is that of
        the sector in the middle.
        """
        if noise_psd is not None and spectrogram.shape[-1]:
            period = period_of(frequencies, frame_period)
            noise_psd = np.maximum(noise_psd, lowest_noise(spectrogram, frequencies, period, self.trust))
        heard, headings = self._votes(spectrogram, frequencies, noise_psd, frame_period), headings[skip:]
        return together([
            self._observation(float(headings[part].mean()), heard.between(skip + part.start, skip + part.stop))
            for part in cut(headings, heard.block)
        ])  # fmt: skip

    def _votes(
        self, spectrogram: Complex, frequencies: Real, noise_psd: Real | None, frame_period: float | None
    ) -> Votes:
        grid, trusts = itd_grid(self.spacing, self.speed_of_sound), (self.trust, self.strict)
        low, high = band_limits(self.spacing, self.speed_of_sound)
        band = (frequencies >= low) & (frequencies <= high)
        noise, period = None if noise_psd is None else noise_psd[band], period_of(frequencies, frame_period)
        return votes(spectrogram[:, band], frequencies[band], grid, trusts, period=period, noise=noise)

    def _observation(self, heading: float, votes: Votes) -> Observation:
        rich, grid = votes.whole, votes.grid
        density = kde(rich, grid, BANDWIDTH * self.spacing / self.speed_of_sound)
        peaks = prominent_peaks(density, grid)
        return Observation(heading, grid, density, float(rich.sum()), peaks, votes.histograms())

    def estimate(self, observations: Sequence[Observation]) -> Estimate:
        """Estimate K and all azimuths from every orientation heard so far; see `interfaces.Explorer`."""
        return self._estimate(observations, None)

    def place(self, observations: Sequence[Observation], k: int) -> Estimate:
        """Estimate the azimuths of ``k`` sources; fewer when the histograms do not hold so many."""
        return self._estimate(observations, k)

    def reconsider(self, observations: Sequence[Observation], believed: Estimate) -> Estimate | None:
        """Explain all observations by the sources that are believed in; see `interfaces.ReconsideringExplorer`.

        The mixture begins where they are: one from scratch explains the same about as well by others, now and then.
        """
        if not believed.k or not observations:
            return None

        def begun(evidence: Evidence) -> Fit:
            return Fit(model_order.begun(evidence.rich, self.penalty, believed.azimuths), 0.0, 1.0, 0.0)

        evidence, begin = self._widened(observations, begun)
        if begin is None:
            return None
        rival, more, second = 0.0, 0.0, None
        for fit in self._fits(evidence):
            if len(fit.step.worth) <= believed.k:
                rival, more = fit.rival, fit.more
                break
            second = _likelier(second, fit)
        likely = talker_evidence.likely(evidence, begin.step, rival)
        return self._with_second(evidence, Fit(begin.step, rival, likely, more), second)

    def _estimate(self, observations: Sequence[Observation], known: int | None) -> Estimate:
        if not observations:
            return Estimate(())
        fitted = self._counted if known is None else partial(self._of_order, k=known)
        evidence, fit = self._widened(observations, fitted)
        if fit is None:
            return Estimate(())
        return self._with_second(evidence, fit, fit.second)

    def _with_second(self, evidence: Evidence, fit: Fit, second: Fit | None) -> Estimate:
        """What a fit says, and what the second-best one says where it is doubtful that there are no more."""
        doubted = second is not None and fit.more > self.enough.doubt
        rival = self._explained(evidence, second) if second is not None and doubted else None
        return replace(self._explained(evidence, fit), rival=rival)

    def _explained(self, evidence: Evidence, fit: Fit) -> Estimate:
        """What a fit says of sources and room."""
        placed = itd_mixture.refine(evidence.strict, fit.step.model, ROUNDS, LOOSE)
        directness = _directness(evidence.rich, fit.step.model, placed)
        sources = _sources(evidence, fit, placed, directness)
        return Estimate(sources, self._certain(evidence.rich, fit, sources), directness)

    def _counted(self, evidence: Evidence) -> Fit | None:
        """The largest mixture for which it is likely that there are as many talkers, with the likeliest larger one."""
        second: Fit | None = None
        for fit in self._fits(evidence):
            if fit.likely >= talker_evidence.LIKELY:
                return replace(fit, second=second)
            second = _likelier(second, fit)
        return None

    def _fits(self, evidence: Evidence) -> Iterator[Fit]:
        """Mixtures of falling order, each with the probability that there are as many talkers."""
        rival, more = 0.0, 0.0
        for step in model_order.steps(evidence.rich, self.penalty):
            if step.possible:
                likely = talker_evidence.likely(evidence, step, rival)
                yield Fit(step, rival, likely, more)
                rival, more = float(step.worth[step.least]), max(more, likely)

    def _of_order(self, evidence: Evidence, k: int) -> Fit | None:
        """The mixture of ``k`` sources."""
        step = model_order.search(evidence.rich, self.penalty, k)
        return None if step is None else Fit(step, 0.0, 1.0, 0.0)

    def _widened(
        self, observations: Sequence[Observation], fitted: Callable[[Evidence], Fit | None]
    ) -> tuple[Evidence, Fit | None]:
        """What fits all orientations, with the array as wide as it is configured, or as they show it to be."""
        evidence, wider = self.evidence(observations), 1.0
        fit = fitted(evidence)
        for _ in range(WIDENED):
            more = 1.0 if fit is None or evidence.among else itd_mixture.longer(evidence.rich, fit.step.model)
            if more == 1.0:
                break
            wider *= more
            evidence = self.evidence(observations, wider)
            fit = fitted(evidence)
        return evidence, fit

    def evidence(self, observations: Sequence[Observation], wider: float = 1.0) -> Evidence:
        """Histograms of all orientations, ITDs in units of d / v_p; d is so many times the configured spacing."""
        grid = observations[0].grid * self.speed_of_sound / (self.spacing * wider)
        height = height_of(observations)
        bounds = {} if height is None else {"amplitudes": below.amplitudes(height), "alike": below.ALIKE}
        rows = rows_of(observations)
        blocks = [COUNT * block for block in rows.blocks]
        rich, strict = np.stack([block.sum(axis=0) for block in blocks]), COUNT * rows.strict
        grid, rich, strict = (values.astype(np.float32) for values in (grid, rich, strict))
        shared: dict[str, Any] = bounds | {"periods": rows.periods}
        whole, clear = (itd_mixture.Data(grid, rows.headings, counts, **shared) for counts in (rich, strict))
        return Evidence(whole, clear, blocks, talker_evidence.together(rows.among))

    def _certain(self, data: itd_mixture.Data, fit: Fit, sources: tuple[SourceEstimate, ...]) -> bool:
        """The stop rule: K is beyond doubt, every place is sharp and unambiguous."""
        clear = fit.step.worth.min() >= self.enough.margin and fit.rival <= 1 / self.enough.margin
        sure = 1 - fit.likely <= self.enough.doubt and fit.more <= self.enough.missed
        sharp = all(source.resolved and source.nominal <= self.enough.sigma for source in sources)
        turned = len(data.headings) if data.periods is None else covered(data.headings)
        heard = turned >= self.enough.orientations and data.counts.sum() >= self.enough.evidence
        return bool(clear and sure and sharp and heard and sources)


def _likelier(one: Fit | None, other: Fit) -> Fit:
    return other if one is None or other.likely > one.likely else one


def height_of(observations: Sequence[Observation]) -> float | None:
    """Height of an array that flies [m], the median over the orientations; None: not known, or too low to matter."""
    heights = [each.height for each in observations if each.height is not None]
    if 2 * len(heights) <= len(observations):
        return None
    height = float(np.median(heights))
    return height if height >= below.AIRBORNE else None


def _directness(data: itd_mixture.Data, model: itd_mixture.Mixture, placed: itd_mixture.Mixture) -> float:
    """1 in the open; in a room s times the share of the evidence that is not diffuse."""
    if data.aloft:
        return 1.0
    diffuse = np.average(model.weights[:, -itd_mixture.OTHERS], weights=data.evidence + itd_mixture.TINY)
    return 1.0 if placed.width < OPEN else float(model.directness * (1 - diffuse))


def overdispersion(directness: float) -> float:
    """By what factor azimuths scatter more than their ITDs tell.

    The ITDs of an orientation are no independent observations in a room: they share its reflections. Fitted to
    simulated rooms, see docs/explanation/joint.md.

    >>> overdispersion(1.0), round(overdispersion(0.75), 2)
    (1.0, 1.49)
    """
    return math.hypot(1.0, SHARED * (1 - directness))


def _sources(
    evidence: Evidence, fit: Fit, placed: itd_mixture.Mixture, directness: float
) -> tuple[SourceEstimate, ...]:
    """The sources of a fit, ``placed`` by the strict histograms, the one with the most evidence first."""
    model, data = fit.step.model, evidence.rich
    every = talker_evidence.features(evidence, fit.step, fit.rival, range(len(model.azimuths)))
    confidences = talker_evidence.fitted("source", evidence.file).probability(every)
    shares = np.average(model.weights, axis=0, weights=data.evidence + itd_mixture.TINY)
    azimuths, amplitudes = itd_mixture.sigmas(evidence.strict, placed)
    nominal = np.minimum(np.hypot(azimuths, BIAS), np.pi)
    sigmas = np.minimum(overdispersion(directness) * nominal, np.pi)
    found = []
    for k, azimuth in enumerate(placed.azimuths):
        elevation, elevation_sigma = None, None
        sigma = float(np.hypot(amplitudes[k], AMPLITUDE_BIAS))
        if data.aloft:
            elevation, elevation_sigma = below.elevation(float(placed.amplitudes[k]), sigma)
        elif placed.width < OPEN:
            elevation, elevation_sigma = _elevation(float(placed.amplitudes[k]), sigma)
        found.append(
            SourceEstimate(
                azimuth=wrap(float(azimuth)),
                sigma=float(sigmas[k]),
                confidence=float(confidences[k]),
                resolved=_resolved(data, model, k),
                weight=float(shares[k]),
                elevation=elevation,
                elevation_sigma=elevation_sigma,
                nominal_sigma=float(nominal[k]),
            )
        )
    return tuple(sorted(found, key=lambda source: -source.weight))


def _elevation(amplitude: float, sigma: float) -> tuple[float | None, float | None]:
    """Elevation [rad] of a source in the open, and one standard deviation; None when it may be 0.

    Two microphones on a horizontal axis do not tell up from down: the elevation is told as a drone hears it, negative.

    >>> np.rad2deg(_elevation(0.5, 0.01)).round(1).tolist()
    [-60.0, 0.7]
    >>> _elevation(0.99, 0.01), _elevation(0.9, 0.05)
    ((None, None), (None, None))
    """
    if amplitude > LOW or 1 - amplitude < CLEAR * sigma:
        return None, None
    return -float(np.arccos(amplitude)), sigma / float(np.sqrt(1 - amplitude**2))


def _resolved(data: itd_mixture.Data, model: itd_mixture.Mixture, source: int) -> bool:
    """Whether the likelihood prefers this place clearly to every other, the mirror image among them."""
    gain = model_order.profile(data, model, source)
    away = np.abs(difference(model_order.GRID, model.azimuths[source])) > ELSEWHERE
    return bool(gain[~away].max() - gain[away].max() >= RESOLVED)


@dataclass(frozen=True, slots=True)
class Factory:
    """Makes explorers; the object behind the entry point ``joint``."""

    name: str = "joint"

    def make(self, spacing: float, speed_of_sound: float) -> Joint:
        """Make an explorer for an array.

        Raises
        ------
        ConfigError
            When a number is not positive and finite.
        """
        check_array(spacing, speed_of_sound)
        return Joint(spacing, speed_of_sound)


explorer = Factory()
