"""What tests read in the report of a mission."""

from typing import Any


def gain(report: dict[str, Any]) -> float:
    """SI-SDRi of the group that is the target [dB]."""
    return float(next(group["si_sdri_db"] for group in report["groups"] if group["target"]))


def gains(report: dict[str, Any]) -> list[float]:
    """SI-SDRi of every group [dB]."""
    return [group["si_sdri_db"] for group in report["groups"]]


def worst_azimuth(report: dict[str, Any]) -> float:
    """The largest azimuth error [deg], with everybody found."""
    assert report["k"] == report["k_true"]
    return max(abs(source["azimuth_error_deg"]) for source in report["sources"])
