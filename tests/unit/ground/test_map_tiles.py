"""Tiles of a local MBTiles file: read only, images only, and one line for what is none."""

import sqlite3
from contextlib import closing

import pytest
from click.testing import CliRunner

from ground_page import page
from map_file import LEVELS, PLACE, map_file, png, tile_at
from ross_payload.ground.errors import GroundError
from ross_payload.ground.web.command import command
from ross_payload.ground.web.tiles import Tiles

aiohttp = pytest.importorskip("aiohttp", reason="the extra [ground]")

GZIP = b"\x1f\x8b\x08" + bytes(60)


@pytest.fixture
def field(tmp_path):
    return map_file(tmp_path / "a field #1.mbtiles")


def test_a_tile_is_found_where_the_page_looks_and_rows_count_from_the_north(field):
    column, row = tile_at(16)
    with Tiles(field) as tiles:
        here, north = tiles.read(16, column, row), tiles.read(16, column, row - 1)
    with closing(sqlite3.connect(field)) as file:
        query = "SELECT tile_data FROM tiles WHERE zoom_level = 16 AND tile_column = ? AND tile_row = ?"
        (stored,) = file.execute(query, (column, 2**16 - 1 - row)).fetchone()
    assert here.body == stored
    assert here.content_type == "image/png"
    assert north.body != here.body


def test_the_page_is_told_levels_the_middle_and_a_plain_attribution(field):
    with Tiles(field) as tiles:
        about = tiles.about
    assert (about["minzoom"], about["maxzoom"]) == (LEVELS[0], LEVELS[-1])
    assert about["attribution"] == "© Survey"
    assert (about["center"]["lat"], about["center"]["lon"]) == pytest.approx(PLACE, abs=0.02)


@pytest.mark.parametrize(
    ("told", "middle"),
    [
        ({"center": "8.5,47.5,12"}, (47.5, 8.5)),
        ({"bounds": "8,46,9,48"}, (47.0, 8.5)),
        ({"bounds": "everywhere"}, PLACE),
        ({"center": "nan,nan"}, PLACE),
    ],
)
def test_the_middle_comes_from_the_metadata_if_they_tell_one(tmp_path, told, middle):
    with Tiles(map_file(tmp_path / "map.mbtiles", told)) as tiles:
        center = tiles.about["center"]
    assert (center["lat"], center["lon"]) == pytest.approx(middle, abs=0.02)


@pytest.mark.parametrize("where", [(16, 0, 0), (31, 0, 0), (-1, 0, 0), (2, 4, 0), (2, 0, -1), (16, 10**12, 3)])
def test_where_there_is_no_tile_is_none(field, where):
    with Tiles(field) as tiles:
        assert tiles.read(*where) is None


def test_the_file_is_not_changed(field):
    before = field.read_bytes()
    field.chmod(0o400)
    with Tiles(field) as tiles, pytest.raises(sqlite3.OperationalError, match="readonly"):
        tiles._file.execute("DELETE FROM tiles")
    assert field.read_bytes() == before
    assert [each.name for each in field.parent.iterdir()] == [field.name]


def damaged(path, kind):
    """Make a file that is no map."""
    if kind == "folder":
        path.mkdir()
    elif kind == "text":
        path.write_text("this is no map at all\n" * 100)
    elif kind == "cut":
        path.write_bytes(map_file(path.with_suffix(".whole")).read_bytes()[:5000])
    elif kind == "vector":
        map_file(path, {"format": "pbf"}, body=GZIP)
    elif kind == "empty":
        map_file(path, levels=())
    elif kind == "deep":
        map_file(path, levels=(1,))
        with closing(sqlite3.connect(path)) as file, file:
            file.execute("UPDATE tiles SET zoom_level = 'x'")
    elif kind == "other":
        with closing(sqlite3.connect(path)) as file, file:
            file.execute("CREATE TABLE notes (text text)")
    return path


@pytest.mark.parametrize("kind", ["none", "folder", "text", "cut", "vector", "empty", "deep", "other"])
def test_what_is_no_map_is_refused_in_one_line(tmp_path, kind):
    with pytest.raises(GroundError) as refused:
        Tiles(damaged(tmp_path / "map.mbtiles", kind))
    assert refused.value.exit_code == 2
    assert refused.value.message.startswith(f"--map {tmp_path / 'map.mbtiles'}: expected ")
    assert ", got" in refused.value.message
    assert "\n" not in refused.value.message


def test_a_bad_map_ends_the_command_before_anything_is_served(tmp_path):
    done = CliRunner().invoke(command, ["--map", str(damaged(tmp_path / "map.mbtiles", "text")), "--port", "0"])
    assert done.exit_code == 2
    assert "expected an MBTiles file" in done.output
    assert "http" not in done.output


def test_what_is_no_image_is_not_served_as_one(tmp_path):
    path = map_file(tmp_path / "map.mbtiles")
    with closing(sqlite3.connect(path)) as file, file:
        file.execute("UPDATE tiles SET tile_data = '<script>' WHERE zoom_level = 15")
        file.execute("UPDATE tiles SET tile_data = NULL WHERE zoom_level = 16")
    with Tiles(path) as tiles:
        assert tiles.read(15, *tile_at(15)) is None
        assert tiles.read(16, *tile_at(16)) is None
        assert tiles.read(14, *tile_at(14)).body.startswith(png(0, 0, 0)[:8])


async def answers(field, wanted):
    with Tiles(field) as tiles:
        async with page(None, tiles=tiles) as served, aiohttp.ClientSession() as client:
            url = f"{served.url}tiles/{wanted}"
            async with client.get(url) as first:
                told = first.status, first.headers.get("Content-Type"), first.headers.get("ETag")
            async with client.get(url, headers={"If-None-Match": told[2] or '"none"'}) as again:
                return told, again.status


async def test_the_page_serves_a_tile_once(field):
    column, row = tile_at(16)
    (status, kind, _), again = await answers(field, f"16/{column}/{row}")
    assert (status, kind, again) == (200, "image/png", 304)


@pytest.mark.parametrize(("wanted", "status"), [("16/0/0", 204), ("16/0/x", 404), ("16/../../0", 404)])
async def test_the_page_serves_nothing_else(field, wanted, status):
    (found, _, _), _ = await answers(field, wanted)
    assert found == status
