"""Draws how the parts of a bench are wired: `python docs/wiring.py` writes `_static/wiring-*.svg`.

A picture is boxes with terminals at their left and right, and wires between terminals. The test
`tests/dist/test_wiring.py` holds the pictures to this script, and their pins to the examples of configurations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

STATIC = Path(__file__).parent / "_static"
PITCH, HEAD, MARGIN, LANE = 22, 34, 20, 9  # between terminals, height of a title, around, between wires [px]
SIGNAL, GROUND, SUPPLY, MOTOR = "#1f6feb", "#444444", "#c62828", "#2e7d32"


@dataclass(frozen=True)
class Box:
    """A part with its terminals, from top to bottom."""

    title: str
    at: tuple[int, int]  # its upper left corner [px]
    width: int
    left: Sequence[str] = ()
    right: Sequence[str] = ()

    @property
    def height(self) -> int:
        """Of the title and the longer column [px]."""
        return HEAD + PITCH * max(len(self.left), len(self.right), 1)

    def place(self, terminal: str) -> tuple[int, int]:
        """Where the wire of a terminal ends [px]."""
        column, x = (self.left, self.at[0]) if terminal in self.left else (self.right, self.at[0] + self.width)
        return x, self.at[1] + HEAD + PITCH * list(column).index(terminal) + PITCH // 2


@dataclass(frozen=True)
class Wire:
    """From a terminal to another: (box, terminal); ``bend`` is how far right of the first it turns [lanes]."""

    begin: tuple[str, str]
    end: tuple[str, str]
    colour: str
    bend: int = 2


@dataclass(frozen=True)
class Picture:
    """Boxes by name, and wires."""

    title: str
    boxes: dict[str, Box]
    wires: Sequence[Wire]

    def svg(self) -> str:
        """Draw it."""
        width = max(box.at[0] + box.width for box in self.boxes.values()) + MARGIN
        height = max(box.at[1] + box.height for box in self.boxes.values()) + MARGIN
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" role="img"'
            ' font-family="sans-serif" font-size="13">',
            f"<title>{escape(self.title)}</title>",
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
            *map(self._wire, self.wires),
            *(line for box in self.boxes.values() for line in _drawn(box)),
            "</svg>",
        ]
        return "\n".join(lines) + "\n"

    def _wire(self, wire: Wire) -> str:
        (x, y), (to, down) = (self.boxes[box].place(terminal) for box, terminal in (wire.begin, wire.end))
        middle = x + wire.bend * LANE
        return (
            f'<polyline points="{x},{y} {middle},{y} {middle},{down} {to},{down}"'
            f' fill="none" stroke="{wire.colour}" stroke-width="2"/>'
        )


def _drawn(box: Box) -> list[str]:
    (x, y), lines = box.at, []
    lines.append(
        f'<rect x="{x}" y="{y}" width="{box.width}" height="{box.height}" rx="6" fill="#f4f4f4" stroke="#444444"/>'
    )
    lines.append(
        f'<text x="{x + box.width / 2:g}" y="{y + 22}" font-weight="bold" text-anchor="middle">'
        f"{escape(box.title)}</text>"
    )
    for names, anchor, inside in ((box.left, "start", 8), (box.right, "end", box.width - 8)):
        for row, name in enumerate(names):
            level = y + HEAD + PITCH * row + PITCH // 2 + 5
            lines.append(f'<text x="{x + inside}" y="{level}" text-anchor="{anchor}">{escape(name)}</text>')
    return lines


def _supply(level: int, *, width: int, fuse_at: int, switch_at: int) -> dict[str, Box]:
    """The motor's supply with its fuse and its switch, side by side [px]."""
    return {
        "supply": Box("12 V, 2 A", (20, level), width, right=("+", "-")),
        "fuse": Box("fuse 1 A", (fuse_at, level), 100, left=("in",), right=("out",)),
        "switch": Box("switch", (switch_at, level), 90, left=("in",), right=("out",)),
    }


FUSED = (Wire(("supply", "+"), ("fuse", "in"), SUPPLY), Wire(("fuse", "out"), ("switch", "in"), SUPPLY))
PICTURES = {
    "wiring-grbl": Picture(
        "A Raspberry Pi, a microcontroller with grbl, a stepper motor and a USB array of microphones",
        {
            "array": Box("microphone array", (20, 20), 170, right=("USB",)),
            "pi": Box("Raspberry Pi", (270, 20), 170, left=("USB 1",), right=("USB 2",)),
            "board": Box(
                "Uno and CNC shield",
                (520, 20),
                190,
                left=("USB", "12 V", "GND"),
                right=("X 2B", "X 2A", "X 1A", "X 1B"),
            ),
            "motor": Box("NEMA 17", (800, 20), 120, left=("B-", "B+", "A+", "A-")),
            **_supply(130, width=170, fuse_at=240, switch_at=380),
        },
        (
            Wire(("array", "USB"), ("pi", "USB 1"), SIGNAL),
            Wire(("pi", "USB 2"), ("board", "USB"), SIGNAL),
            Wire(("board", "X 2B"), ("motor", "B-"), MOTOR),
            Wire(("board", "X 2A"), ("motor", "B+"), MOTOR),
            Wire(("board", "X 1A"), ("motor", "A+"), MOTOR),
            Wire(("board", "X 1B"), ("motor", "A-"), MOTOR),
            *FUSED,
            Wire(("switch", "out"), ("board", "12 V"), SUPPLY),
            Wire(("supply", "-"), ("board", "GND"), GROUND, bend=35),
        ),
    ),
    "wiring-tb6600": Picture(
        "A Raspberry Pi, a ULN2003, a TB6600 module and a stepper motor",
        {
            "pi": Box(
                "Raspberry Pi",
                (20, 20),
                190,
                right=("5 V (pin 2)", "GPIO 23 (pin 16)", "GPIO 24 (pin 18)", "GPIO 25 (pin 22)", "GND (pin 20)"),
            ),
            "buffer": Box("ULN2003", (290, 90), 120, left=("1B", "2B", "3B", "E"), right=("1C", "2C", "3C")),
            "module": Box(
                "TB6600",
                (530, 20),
                190,
                left=("PUL+ DIR+ ENA+", "PUL-", "DIR-", "ENA-", "VCC", "GND"),
                right=("A+", "A-", "B+", "B-"),
            ),
            "motor": Box("NEMA 17", (800, 20), 120, left=("A+", "A-", "B+", "B-")),
            **_supply(240, width=120, fuse_at=200, switch_at=360),
        },
        (
            Wire(("pi", "5 V (pin 2)"), ("module", "PUL+ DIR+ ENA+"), SUPPLY),
            Wire(("pi", "GPIO 23 (pin 16)"), ("buffer", "1B"), SIGNAL, bend=5),
            Wire(("pi", "GPIO 24 (pin 18)"), ("buffer", "2B"), SIGNAL, bend=4),
            Wire(("pi", "GPIO 25 (pin 22)"), ("buffer", "3B"), SIGNAL, bend=3),
            Wire(("pi", "GND (pin 20)"), ("buffer", "E"), GROUND),
            Wire(("buffer", "1C"), ("module", "PUL-"), SIGNAL, bend=3),
            Wire(("buffer", "2C"), ("module", "DIR-"), SIGNAL, bend=4),
            Wire(("buffer", "3C"), ("module", "ENA-"), SIGNAL, bend=5),
            *(Wire(("module", end), ("motor", end), MOTOR) for end in ("A+", "A-", "B+", "B-")),
            *FUSED,
            Wire(("switch", "out"), ("module", "VCC"), SUPPLY, bend=4),
            Wire(("supply", "-"), ("module", "GND"), GROUND, bend=40),
        ),
    ),
}


def main() -> None:
    """Write every picture."""
    for name, picture in PICTURES.items():
        (STATIC / f"{name}.svg").write_text(picture.svg(), encoding="utf-8")


if __name__ == "__main__":
    main()
