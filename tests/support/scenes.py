"""What a payload may know, as `ross_payload.ground.model.view` draws it: sections from closed forms."""

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

UNIT = 146.0  # d / v_p [us]
POINTS = 80
NOW = 1000.0  # [s]
WIDTH = 12.0  # of a ridge [us]

Sections = dict[str, Any]


def source(index: int, azimuth: float, **more: Any) -> dict[str, Any]:
    """One source; degrees."""
    plain = {
        "source": index, "azimuth": azimuth, "mirror": None, "sigma": 3.0, "elevation": None, "confidence": 0.9,
        "weight": 0.5, "score": None, "resolved": True, "target": False, "final": True, "earth": True, "announced": 1,
        "trail": [[NOW - 20, azimuth - 12], [NOW - 12, azimuth - 5], [NOW - 4, azimuth]],
    }  # fmt: skip
    return {**plain, **more}


def itd(azimuth: float, heading: float) -> float:
    """Time difference of arrival [us]."""
    return UNIT * math.cos(math.radians(azimuth - heading))


def density(rotation: int, heading: float, azimuths: Sequence[float]) -> dict[str, Any]:
    """What an orientation hears of sources at some azimuths."""
    at = [-UNIT + 2 * UNIT * index / (POINTS - 1) for index in range(POINTS)]
    heard = [sum(math.exp(-0.5 * ((us - itd(azimuth, heading)) / WIDTH) ** 2) for azimuth in azimuths) for us in at]
    most = max(heard, default=1.0) or 1.0
    return {"rotation": rotation, "heading": heading, "first_us": -UNIT, "last_us": UNIT,
            "density": [round(each / most, 3) for each in heard]}  # fmt: skip


def isolations(azimuths: Sequence[float]) -> list[dict[str, Any]]:
    """How far every heading sets each source apart from the next one."""
    headings = [-180.0 * index / POINTS for index in range(POINTS)]
    curves = [[min((abs(itd(mine, heading) - itd(other, heading)) for j, other in enumerate(azimuths) if j != i),
                   default=2 * UNIT) for heading in headings] for i, mine in enumerate(azimuths)]  # fmt: skip
    return [
        {"source": index, "first": headings[0], "last": headings[-1], "maximum_us": max(curve),
         "isolation": [round(each / max(curve), 3) for each in curve]}
        for index, curve in enumerate(curves)
    ]  # fmt: skip


def candidate(index: int, alone: int, heading: float, aliased: Sequence[int], state: str) -> dict[str, Any]:
    """One heading at which interferers have the same delay."""
    return {"candidate": index, "source": alone, "heading": heading, "joint": heading, "isolation_us": 90.0,
            "gain": 8.5, "aliased": list(aliased), "rule": "bisector",
            "rule_meaning": "The bisector of the interferers.", "state": state}  # fmt: skip


def pointing(heading: float | None, **more: Any) -> Sections:
    """Where the axis points."""
    plain = {"earth": True, "heading": heading, "goal": None, "joint": 0.0, "joint_rate": 0.0, "mount_yaw": 20.0,
             "limits": None, "present": True, "settled": True,
             "homed": True, "fault": False, "open_loop": False}  # fmt: skip
    return {**plain, **more}


STATES = ("lead_in", *(["explore_turn", "explore_listen"] * 4), "align_turn", "check", "align_turn", "check", "run")


def history(k: int) -> list[dict[str, Any]]:
    """A mission of two minutes, from the noise to the listening."""
    step = 120 / (len(STATES) + 5)
    return [
        {"at": NOW - 120 + index * step, "time": index * step, "state": state, "heading": 0.0,
         "k": None if index < 3 else min(k, index // 2), "score": None if index < 10 else -1.0 + 0.6 * (index - 10),
         "criterion": 0.5}
        for index, state in enumerate(STATES)
    ]  # fmt: skip


def scene(sources: Sequence[Mapping[str, Any]], heading: float | None = 30.0, **more: Any) -> Sections:
    """Everything about some sources."""
    azimuths = [each["azimuth"] for each in sources]
    found = next((each["source"] for each in sources if each["target"]), None)
    return {
        "standing": {"who": "1-191", "last": NOW - 0.2, "state": "run", "mirrors_only": False},
        "pointing": pointing(heading),
        "mission": {"time": 104.0, "elapsed": 104.0, "expected": 130.0, "rotation": 8, "rotation_max": 12,
                    "k": len(sources), "target": found, "target_found": found is not None, "score": 1.4,
                    "criterion": 0.5},
        "sources": list(sources),
        "plan": {"current": None, "candidates": []},
        "densities": [density(index, 22.5 * index, azimuths) for index in range(8)],
        "isolation": isolations(azimuths),
        "history": history(len(sources)),
        "health": {"microphones": {"level_db": [-31.0, -33.5], "peak_db": [-12.0, -14.0]}},
        **more,
    }  # fmt: skip


def three() -> Sections:
    """Sources 0 and 2 pose as one at 45 degrees; source 1 is the target."""
    plan = {"current": 0, "candidates": [candidate(0, 1, 45.0, [0, 2], "accepted"),
                                         candidate(1, 0, 155.0, [1, 2], "planned"),
                                         candidate(2, 2, 100.0, [0, 1], "rejected")]}  # fmt: skip
    return scene([source(0, 10), source(1, 230, target=True), source(2, 80, sigma=6)], heading=45.0, plan=plan)


def mirrors_only() -> Sections:
    """Mirrored values alone: where sources are and nothing else of them; no frame, no curves."""
    vague = {**dict.fromkeys(("sigma", "confidence", "weight")), "earth": False, "final": False, "trail": []}
    return {
        "standing": {"last": NOW, "mirrors_only": True},
        "pointing": {"earth": False, "heading": 33.0, "goal": None, "limits": None, "present": False},
        "mission": {"k": 2, "score": 0.7, "target": None},
        "sources": [source(0, 40, **vague), source(1, 130, **vague)],
        "plan": {"current": None, "candidates": []},
        **{name: [] for name in ("densities", "isolation", "history")},
    }


@cache
def scenes() -> dict[str, Sections]:
    """Every state of the gallery, by name."""
    five = [
        source(index, azimuth, confidence=0.4 + 0.12 * index) for index, azimuth in enumerate((12, 20, 27, 140, 300))
    ]
    many = [source(index, (11.25 * index + 5 * (index % 3)) % 360) for index in range(32)]
    crowd = [source(index, 80 + 0.5 * index) for index in range(32)]
    round_zero = [source(0, 359), source(1, 1), source(2, 357, resolved=False, mirror=63.0)]
    return {
        "nothing known": {},
        "nothing heard": scene([], heading=None, densities=[], isolation=[], history=[], health={}),
        "unresolved": scene([source(0, 70, resolved=False, mirror=350.0, final=False)]),
        "three": three(),
        "five": scene(five),
        "thirty-two": scene(many),
        "crowd": scene(crowd),
        "limits": {**three(), "pointing": pointing(45.0, limits=[315.0, 95.0])},
        "wide limits": {**three(), "pointing": pointing(45.0, limits=[250.0, 170.0])},
        "mount": {**three(), "pointing": pointing(45.0, earth=False, mount_yaw=None)},
        "turning": {**three(), "pointing": pointing(15.0, goal=45.0, settled=False, joint_rate=40.0)},
        "mirrors only": mirrors_only(),
        "stale": {**three(), "standing": {"last": NOW - 12}},
        "around north": scene(round_zero, heading=0.0),
    }  # fmt: skip
