"""The script that makes the manual's pictures of the page still makes the same views."""

import importlib.util
from pathlib import Path

import pytest
from PIL import Image

from emulated_log import log

DOCS = Path(__file__).parents[2] / "docs"
LARGEST = 150_000  # [bytes]


@pytest.fixture(scope="module")
def tour():
    spec = importlib.util.spec_from_file_location("tour", DOCS / "tour.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.BEAT = 50  # [ms]: here no picture needs to be of something that rests
    return module


@pytest.mark.soak
def test_every_view_can_be_taken_and_the_manual_shows_it(tour, browser, tmp_path):
    flights = tmp_path / "flights"
    flights.mkdir()
    tour.take(log(flights / "mission.tlog", seconds=4), tmp_path, browser)
    manual = (DOCS / "tutorials" / "the-page.md").read_text()
    for view in tour.VIEWS:
        kept = DOCS / "_static" / f"{view.name}.png"
        assert f"_static/{view.name}.png" in manual
        assert kept.stat().st_size < LARGEST
        for path in (kept, tmp_path / f"{view.name}.png"):
            with Image.open(path) as picture:
                assert picture.size == (view.width, view.height)
                assert len(picture.convert("RGB").getcolors(100_000)) > 20  # something is drawn
