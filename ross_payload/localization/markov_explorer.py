"""The explorers `markov` and `markov-plain`: Algorithm 1 of the paper as [explore.options] sets it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from ross_payload.config import Table
from ross_payload.dsp.itd import check_array
from ross_payload.localization.front_back_test import Trial
from ross_payload.localization.markov import TRUSTS, Markov, Rule


class MarkovOptions(Table):
    """[explore.options] of ``markov``: its front end and the numbers that the paper leaves open."""

    every_bin: bool = False  # every bin counts one, as in the paper; else those that `dsp/itd.py` trusts count more
    bandwidth: Annotated[float, Field(gt=0, le=1)] = 0.045  # of the KDE [d / v_p]
    prominence: Annotated[float, Field(ge=0, lt=1)] = 0.01  # of a peak, as a share of the highest
    power: Annotated[float, Field(ge=0, le=4)] = 0.7  # of the clearness of a test as the weight of its vote
    both_ways: bool = True  # peaks of the later orientation are tested against the earlier one too
    spread_deg: Annotated[float, Field(gt=0, le=90)] = 16.0  # a cluster must save the inertia of one vote so far off
    share: Annotated[float, Field(gt=0, le=1)] = 0.2  # of the votes that a source could have, that it must hold


class PlainOptions(MarkovOptions):
    """[explore.options] of ``markov-plain``: the same with the paper's front end and votes as defaults."""

    every_bin: bool = True
    bandwidth: Annotated[float, Field(gt=0, le=1)] = 0.05
    prominence: Annotated[float, Field(ge=0, lt=1)] = 0.04
    power: Annotated[float, Field(ge=0, le=4)] = 0.0
    both_ways: bool = False
    spread_deg: Annotated[float, Field(gt=0, le=90)] = 24.0
    share: Annotated[float, Field(gt=0, le=1)] = 0.15


@dataclass(frozen=True, slots=True)
class Factory:
    """Makes explorers; the objects behind the entry points ``markov`` and ``markov-plain``."""

    name: str
    Options: type[MarkovOptions]

    def make(self, spacing: float, speed_of_sound: float, options: MarkovOptions | None = None) -> Markov:
        """Make an explorer for an array.

        Raises
        ------
        ConfigError
            When a number is not positive and finite.
        """
        check_array(spacing, speed_of_sound)
        chosen = self.Options() if options is None else options
        rule = Rule(
            bandwidth=chosen.bandwidth,
            prominence=chosen.prominence,
            trial=Trial(chosen.power, chosen.both_ways),
            spread=float(np.deg2rad(chosen.spread_deg)),
            share=chosen.share,
        )
        return Markov(spacing, speed_of_sound, () if chosen.every_bin else TRUSTS, rule, self.name)


explorer = Factory("markov", MarkovOptions)
plain = Factory("markov-plain", PlainOptions)
