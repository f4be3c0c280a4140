"""What a mission among talkers who move is worth: tracked against true azimuths, and what every period sounds like."""

from __future__ import annotations

import math
from typing import Any

from ross_payload.angles import wrap
from ross_payload.events import Separated, SourcesEstimated, SourcesTracked
from ross_sim.sitl.report import EventLog, Truth, match, qualities


def moving_report(log: EventLog, truth: Truth) -> dict[str, Any]:
    """Return ``tracks`` and ``periods``, as plain values; nothing when nobody moves."""
    if not truth.walks:
        return {}
    return {"tracks": tracks(log, truth), "periods": periods(log, truth)}


def tracks(log: EventLog, truth: Truth) -> list[dict[str, Any]]:
    """Every tracked azimuth beside the true one of the talker for whom its source was found."""
    rows: list[dict[str, Any]] = []
    pairs: dict[int, int] = {}
    for event in log.events:
        if isinstance(event, SourcesEstimated):
            pairs = match(event.estimate.sources, truth.azimuths_at(event.time))
        if not isinstance(event, SourcesTracked):
            continue
        azimuths = truth.azimuths_at(event.time)
        for index, source in enumerate(event.estimate.sources):
            true = float(azimuths[pairs[index]]) if index in pairs else None
            rows.append(
                {
                    "time_s": round(event.time, 3),
                    "source": index,
                    "name": truth.names[pairs[index]] if index in pairs else None,
                    "azimuth_true_deg": None if true is None else _degrees(true),
                    "azimuth_deg": _degrees(source.azimuth),
                    "azimuth_error_deg": None if true is None else _degrees(wrap(source.azimuth - true)),
                    "sigma_deg": _degrees(source.sigma),
                    "rate_deg_s": _degrees(event.rates[index]),
                    "age_s": round(event.ages[index], 3),
                }
            )
    return rows


def periods(log: EventLog, truth: Truth) -> list[dict[str, Any]]:
    """Every T_run: from when, and the SI-SDR of the target and of the mixture [dB]."""
    rows: list[dict[str, Any]] = []
    for event in log.all(Separated):
        quality = qualities(event, log.estimated_before(event), truth)[event.target]
        rows.append(
            {
                "time_s": round(event.time, 3),
                "talkers": list(quality.names),
                "score": round(quality.score, 3),
                "si_sdr_db": None if quality.si_sdr is None else round(quality.si_sdr, 2),
                "si_sdri_db": None if quality.si_sdri is None else round(quality.si_sdri, 2),
                "why": event.why,
            }
        )
    return rows


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 3)
