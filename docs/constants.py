"""Prints the table of constants of docs/explanation/where-to-turn.md from the code; a test compares both.

Run it where the payload is installed: ``python docs/constants.py``.
"""

import sys

from ross_payload.alignment import predicted_gain as gain

HEADER = ("", "", "in the open", "in reverberation")
ROWS = {
    "s": ("an interferer this far away leaks 1/e of its power", gain.REACH, " $d/v_p$"),
    "r": ("echoes come from everywhere", gain.ECHOES, ""),
    "m": (
        "interferers on both sides can resemble a source between them; 0 when all are on one side",
        gain.BETWEEN,
        "",
    ),
    "b": (
        "all interferers act as one: two groups, two microphones; "
        f"0 when their delays spread over {gain.POSING:g} $d/v_p$",
        gain.DETERMINED,
        " dB",
    ),
}


def tables() -> str:
    """What each constant of the predicted gain stands for, and its values."""
    lines = [
        (f"${name}$", means, *(f"{value:g}{unit}" for value in pair)) for name, (means, pair, unit) in ROWS.items()
    ]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (HEADER, ("---",) * len(HEADER), *lines))


if __name__ == "__main__":
    sys.stdout.write(f"{tables()}\n")
