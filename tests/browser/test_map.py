"""The map before any position is known, and over the tiles of a file."""

import pytest

from browsing import eventually
from fleet_bench import FleetThread
from map_file import corner_of, map_file, tile_at
from served_ground import served

pytest.importorskip("aiohttp", reason="the extra [ground]")


@pytest.fixture(scope="module")
def ground(browser, tmp_path_factory):
    tiles = map_file(tmp_path_factory.mktemp("map") / "field.mbtiles")
    with served("--map", tiles) as ground, FleetThread(ground.port, payloads=2):
        yield ground


@pytest.fixture(scope="module")
def kept(ground, keep_page):
    page = keep_page(f"{ground.url}#/map")
    page.locator(".map image").first.wait_for()
    return page


def on_screen(page, selector):
    """Where the middle of a payload is drawn [px]."""
    words = page.locator(selector).first.get_attribute("transform")
    return tuple(float(each) for each in words.removeprefix("translate(").removesuffix(")").split())


def test_payloads_are_drawn_where_they_are_assumed_until_their_positions_are_known(crew_without_map, open_page):
    page = open_page(f"{crew_without_map.url}#/map")
    eventually(page, lambda: page.locator(".map .stand.assumed").count() == 2)
    assert page.locator(".map .stand.assumed .axis").count() == 2
    assert page.locator(".map .grid line").count() > 6
    assert page.locator(".map .scale text").text_content().endswith(" m")
    assert not page.locator(".map image").count()
    page.get_by_text("No payload position is known yet").wait_for()


@pytest.fixture(scope="module")
def crew_without_map(browser):
    with served() as ground, FleetThread(ground.port, payloads=2):
        yield ground


def test_tiles_lie_under_the_map_where_they_belong(kept, window):
    page = kept
    page.locator(".map .stand.assumed").first.wait_for()
    page.get_by_text("Map: © Survey").wait_for()
    column, row = tile_at(16)
    north, west = corner_of(16, column, row)
    page.get_by_label("Payload", exact=True).select_option("1-191")
    page.get_by_label("Latitude").fill(f"{north:.7f}")
    page.get_by_label("Longitude").fill(f"{west:.7f}")
    page.get_by_role("button", name="Set position").click()
    page.locator(".map .stand:not(.assumed)").wait_for()
    tile = page.locator(f".map image[href='/tiles/16/{column}/{row}']")
    tile.wait_for()
    x, y = on_screen(page, ".map .stand")
    assert float(tile.get_attribute("x")) == pytest.approx(x, abs=0.6)
    assert float(tile.get_attribute("y")) == pytest.approx(y, abs=0.6)
    loaded = page.evaluate("async path => (await fetch(path)).headers.get('content-type')", f"/tiles/16/{column}/{row}")
    assert loaded == "image/png"


def test_the_map_can_be_left_by_far_without_a_request_for_what_is_not_there(kept, window):
    page = kept
    page.locator(".map").focus()
    for _ in range(20):
        page.keyboard.press("-")
    eventually(page, lambda: page.locator(".map image").count() <= 120)
