import re
from pathlib import Path

from ross_payload.plugin_checks import load_separator
from ross_payload.plugins import available
from ross_payload.separation.auto_separator import ANY, INFORMED, UNMIXING
from ross_sim.study.oracle_separators import ORACLES

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "separators.md"


def _rows(heading: str) -> dict[str, list[str]]:
    """Cells of the first table below a heading, by the name in the first one."""
    text = PAGE.read_text(encoding="utf-8").split(heading, 1)[1]
    table = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert table
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table[0].splitlines()[2:]]
    return {cells[0].strip("`"): cells for cells in lines}


def test_the_page_lists_every_separator_that_is_built_in() -> None:
    ours = {name for name, point in available("ross_payload.separators").items() if point.value.startswith("ross_")}
    assert set(_rows("# Separators")) == ours


def test_the_page_says_which_ones_auto_takes() -> None:
    taken = {separator.name for separator in (INFORMED, UNMIXING, ANY)} | {load_separator("auto").live(0).name}
    rows = _rows("# Separators")
    assert {name for name in rows if rows[name][-1] not in ("never", "")} == taken


def test_the_page_says_which_ones_need_the_extra() -> None:
    points = available("ross_payload.separators")
    for name, cells in _rows("# Separators").items():
        assert points[name].value.startswith("ross_sim") == ("extra `sim`" in cells[3])


def test_the_page_says_which_ones_are_live() -> None:
    ours = {
        name: point for name, point in available("ross_payload.separators").items() if "ross_sim" not in point.value
    }
    live = {name for name, point in ours.items() if hasattr(point.load(), "live")}
    assert live == {name for name, cells in _rows("# Separators").items() if "live" in cells[4]}
    assert live == set(_rows("## Frame by frame"))


def test_the_page_lists_every_oracle() -> None:
    assert set(_rows("## Upper bounds")) == set(ORACLES)
