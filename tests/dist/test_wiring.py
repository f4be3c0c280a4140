"""The pictures of how a bench is wired are those of the script, their pins those of the examples, their sums right."""

import math
import re
import sys
import tomllib
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "tutorials" / "from-the-box.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def wiring():
    sys.path.insert(0, str(DOCS))
    try:
        import wiring

        yield wiring
    finally:
        sys.path.remove(str(DOCS))


def test_the_pictures_are_those_of_the_script(wiring):
    for name, picture in wiring.PICTURES.items():
        assert (DOCS / "_static" / f"{name}.svg").read_text(encoding="utf-8") == picture.svg()
        assert f"_static/{name}.svg" in PAGE


def test_every_wire_ends_at_two_terminals_and_no_terminal_has_two(wiring):
    for picture in wiring.PICTURES.values():
        ends = [end for wire in picture.wires for end in (wire.begin, wire.end)]
        assert len(set(ends)) == len(ends)
        for box, terminal in ends:
            assert terminal in (*picture.boxes[box].left, *picture.boxes[box].right)


def test_the_pins_are_those_of_the_example_and_of_the_stepper_s_page(wiring):
    example = tomllib.loads((DOCS / "examples" / "paper-bench.toml").read_text(encoding="utf-8"))
    step, direction, enable = example["actuator"]["options"]["port"].rpartition(":")[2].split(",")
    follow = {wire.begin: wire.end for wire in wiring.PICTURES["wiring-tb6600"].wires}
    stepper = (DOCS / "how-to" / "stepper.md").read_text(encoding="utf-8")
    for gpio, signal in ((step, "PUL"), (direction, "DIR"), (enable, "ENA")):
        terminal = next(terminal for box, terminal in follow if box == "pi" and terminal.startswith(f"GPIO {gpio} "))
        assert f"| {signal}+ | {terminal} |" in stepper
        buffer = follow["pi", terminal][1].replace("B", "C")
        assert follow["buffer", buffer] == ("module", f"{signal}-")


def test_currents_and_torque_are_worked_out_right():
    inertia = 0.150 * 0.05**2 / 2
    acceleration = tomllib.loads((DOCS / "examples" / "pan-unit-grbl.toml").read_text())["actuator"]["options"]
    turning = inertia * math.radians(acceleration["max_acceleration_deg_s2"])
    cable, holding = 10e-3, 80e-3
    said = dict(re.findall(r"^\| ([^|]+?) \|[^|]*\| ([\d.e-]+) ", PAGE, re.MULTILINE))
    values = {
        "plate and array: a disc of 150 g, 5 cm in radius": inertia,
        "acceleration of the example, 180 deg/s²": 1e3 * turning,
        "pull of a stiff cable (measure it with a spring balance)": 1e3 * 0.020 * 9.81 * 0.05,
        "torque needed": 1e3 * (cable + turning),
        "reserve": holding / (cable + turning),
        "how far the cable pulls the array from where it should be": math.degrees(math.asin(cable / holding) / 50),
        "heat of the motor at rest, winding 3.7 Ω": 0.5**2 * 3.7,
        "free oscillation": math.sqrt(50 * holding / inertia) / (2 * math.pi),
    }
    for what, value in values.items():
        assert float(said[what]) == pytest.approx(value, rel=0.05), what
