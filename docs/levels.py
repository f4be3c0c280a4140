"""Prints the tables of levels of docs/explanation/how-loud-may-the-drone-be.md; a test compares both.

Levels at the array by the inverse square law alone. Run it in a checkout: ``python docs/levels.py``.
"""

import math
import sys

HEIGHTS = (5.0, 10.0, 20.0)  # above the mouths [m]
ASIDE = 5.5  # of the talkers from the point below the array, the middle of 3 to 8 [m]
SPEECH = {"normal": 60.0, "loud": 72.0, "very loud": 78.0}  # at 1 m, ISO 9921 [dB]
DRONE = 85.0 - 11.0  # at 1 m: sound power [dB(A)] over a sphere of 1 m
ROTOR = 0.38  # from the array [m]
RATIOS = (0.0, -10.0)  # talkers over rotors [dB]


def at_array(level: float, height: float) -> float:
    """Level of a talker at the array, whose level is told at 1 m [dB].

    >>> round(at_array(60.0, 5.0), 1)
    42.6
    """
    return level - 20 * math.log10(math.hypot(height, ASIDE))


def away(level: float, ratio: float) -> str:
    """How far the drone must be from the array [m] for a ratio to a level there [dB].

    >>> away(42.6, 0.0), away(60.6, -10.0)
    ('37 m', '1.5 m')
    """
    distance = 10 ** ((DRONE - level + ratio) / 20)
    return f"{distance:.0f} m" if distance >= 8.5 else f"{distance:.1f} m"


def levels() -> list[str]:
    """Levels of talkers and drone at the array, and their ratio."""
    drone = DRONE - 20 * math.log10(ROTOR)
    told = [f"{name}, {level:.0f} dB" for name, level in SPEECH.items()]
    header = [
        "height above the mouths",
        f"{told[0]} at 1 m",
        *told[1:],
        f"drone, array at {ROTOR} m",
        "ratio: normal to very loud",
    ]
    lines = [header, ["---"] * len(header)]
    for height in HEIGHTS:
        heard = [at_array(level, height) for level in SPEECH.values()]
        ratio = f"{heard[0] - drone:.0f} to {heard[-1] - drone:.0f} dB"
        lines.append([f"{height:.0f} m", *(f"{level:.0f} dB" for level in heard), f"{drone:.0f} dB", ratio])
    return [f"| {' | '.join(cells)} |" for cells in lines]


def distances() -> list[str]:
    """How far from the drone the array must be for every ratio."""
    header = ["height above the mouths"]
    for name in SPEECH:
        header += [f"{name}, {RATIOS[0]:.0f} dB", *(f"{ratio:.0f} dB" for ratio in RATIOS[1:])]
    lines = [header, ["---"] * len(header)]
    for height in HEIGHTS:
        heard = [at_array(level, height) for level in SPEECH.values()]
        lines.append([f"{height:.0f} m", *(away(level, ratio) for level in heard for ratio in RATIOS)])
    return [f"| {' | '.join(cells)} |" for cells in lines]


def tables() -> list[str]:
    """Both tables."""
    return ["\n".join(levels()), "\n".join(distances())]


if __name__ == "__main__":
    sys.stdout.write("\n\n".join(tables()) + "\n")
