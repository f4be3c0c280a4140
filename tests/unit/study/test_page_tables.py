"""Tables of the manual: those with rows are what the rows give, and the others say where they come from."""

import errno
import os
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from ross_payload.errors import ConfigError, OutputError
from ross_sim.study.command import command
from ross_sim.study.page_tables import BLOCK, tables_of, with_tables, write_page
from ross_sim.study.rows.live_tables import Row, appended, tables
from ross_sim.study.rows.tables import Table

DOCS = Path(__file__).parents[3] / "docs"
PAGES = sorted(path for suffix in ("md", "inc") for path in DOCS.rglob(f"*.{suffix}") if "_build" not in path.parts)
MADE = [page for page in PAGES if BLOCK.search(page.read_text(encoding="utf-8"))]
MEASURED = [
    DOCS / name
    for name in (
        "explanation/measured.md", "explanation/measured-live.md", "explanation/measured-ground.md",
        "explanation/measured-moving.inc", "explanation/voice-print.md", "explanation/where-to-turn.md",
        "explanation/refiner.md", "explanation/markov.md", "how-to/paper.md",
    )
]  # fmt: skip
TYPED = re.compile(r"<!-- (typed: .+; (commit [0-9a-f]{7,}|not measured)|calculated by docs/\w+\.py.*) -->")
ROW = Row("S1", 3, 0, 0, 16000, 0, "auto", 100, 100.0, 12.0, 11.5, 9.0, 8.0, None, 0.05, 0.03)


def name(page):
    return page.relative_to(DOCS).as_posix()


@pytest.mark.parametrize("page", MADE, ids=name)
def test_a_page_has_the_tables_that_its_rows_give(page):
    assert page.read_text(encoding="utf-8") == with_tables(page)


@pytest.mark.parametrize("page", MEASURED, ids=name)
def test_a_measured_table_without_rows_says_from_which_command_and_commit_or_script_it_comes(page):
    lines = BLOCK.sub("", page.read_text(encoding="utf-8")).splitlines()
    begins = [i for i, line in enumerate(lines) if line.startswith("|") and not lines[i - 1].startswith("|")]
    assert [lines[i] for i in begins if not TYPED.fullmatch(lines[i - 1])] == []


@pytest.fixture
def page(tmp_path):
    appended(tmp_path / "rows.csv", [ROW])
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- rows: rows.csv, table: live -->\nold\n<!-- rows: end -->\nafter\n")
    return page


def test_a_file_that_was_cut_short_in_its_last_row_is_refused_in_one_line(tmp_path):
    whole, path = (DOCS / "rows" / "noise.csv").read_bytes(), tmp_path / "rows.csv"
    for cut in range(whole.rindex(b"\n", 0, -1) + 2, len(whole)):
        path.write_bytes(whole[:cut])
        with pytest.raises(ConfigError, match="was the file cut short") as refused:
            tables_of(path)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("make", "got"),
    [
        (os.mkfifo, "expected a regular file, got a named pipe"),
        (Path.mkdir, "expected a regular file, got a folder"),
        (lambda path: path.symlink_to("/dev/zero"), "expected a regular file, got a device"),
        (lambda path: None, "No such file or directory"),
        (lambda path: path.write_bytes(b"\xde\n"), "expected the rows of a study, got no UTF-8 text"),
    ],
    ids=["pipe", "folder", "device", "nothing", "bytes"],
)
def test_what_holds_no_rows_is_refused_without_waiting_or_reading_for_ever(tmp_path, make, got):
    path = tmp_path / "rows.csv"
    make(path)
    with pytest.raises(ConfigError) as refused:
        tables_of(path)
    assert str(refused.value).endswith(got)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text + "S1,3\n", "line 3: expected 16 cells, got 2"),
        (lambda text: text.replace("auto", "auto,5"), "line 2: expected 16 cells, got 17"),
        (lambda text: text.replace("auto", '"auto'), "expected the rows of a study: line 2"),
    ],
)
def test_a_row_with_other_cells_than_there_are_names_is_refused(page, change, words):
    rows = page.parent / "rows.csv"
    rows.write_text(change(rows.read_text()))
    with pytest.raises(ConfigError, match=words):
        tables_of(rows)


def test_rows_of_live_separation_are_added_whole_or_not_at_all(page, monkeypatch):
    rows = page.parent / "rows.csv"
    before = rows.read_bytes()
    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OutputError, match="cannot be written: No space left"):
        appended(rows, [ROW])
    assert rows.read_bytes() == before
    assert [path.name for path in page.parent.iterdir() if "part" in path.name] == []


def full(*_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_table_takes_the_place_of_the_old_one_and_nothing_else_changes(page):
    rows = page.parent / "rows.csv"
    done = CliRunner().invoke(command, ["table", str(rows), "--into", str(page)], standalone_mode=False)
    assert done.exception is None
    begin, made, end = "<!-- rows: rows.csv, table: live -->", tables([ROW]), "<!-- rows: end -->"
    assert page.read_text() == f"before\n{begin}\n{made}\n{end}\nafter\n"
    assert with_tables(page) == page.read_text()


def test_line_ends_links_and_the_mode_of_a_page_stay(page):
    page.write_bytes(page.read_bytes().replace(b"\n", b"\r\n"))
    page.chmod(0o640)
    link = page.with_name("link.md")
    link.symlink_to(page.name)
    write_page(link)
    assert link.is_symlink()
    assert page.stat().st_mode & 0o777 == 0o640
    text = page.read_bytes()
    assert text.count(b"\n") == text.count(b"\r\n")
    assert tables([ROW]).splitlines()[0].encode() in text


def test_a_page_in_another_encoding_is_refused_in_one_line(page):
    page.write_bytes(b"\xff" + page.read_bytes())
    with pytest.raises(ConfigError, match=r"page\.md: expected UTF-8 text, got other bytes"):
        write_page(page)


def test_tables_of_other_rows_stay(page):
    other = page.parent / "other.csv"
    appended(other, [ROW])
    text = page.read_text() + "<!-- rows: other.csv, table: live -->\nolder\n<!-- rows: end -->\n"
    page.write_text(text)
    write_page(page, other)
    assert "\nold\n" in page.read_text()
    assert "\nolder\n" not in page.read_text()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            ("rows.csv, table", "nothing.csv, table"),
            "expected a mark '<!-- rows: FILE, table: NAME -->' for .*rows.csv",
        ),
        (("table: live", "table: dead"), "table 'dead' is unknown; there are: live"),
        (("<!-- rows: end -->", ""), "expected a mark"),
    ],
)
def test_a_page_that_does_not_fit_is_refused_in_one_line_and_left_alone(page, change, words):
    page.write_text(page.read_text().replace(*change))
    before = page.read_text()
    with pytest.raises(ConfigError, match=words) as refused:
        write_page(page, page.parent / "rows.csv")
    assert "\n" not in str(refused.value)
    assert page.read_text() == before


def test_rows_that_are_none_are_refused(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_text(",".join(Row.__dataclass_fields__) + "\n")
    with pytest.raises(ConfigError, match="expected rows, got none"):
        tables_of(path)


def test_a_name_cannot_break_the_table_that_it_stands_in():
    table = Table("", ("", "a|b"), (("two\nlines", "1"),))
    assert table.body() == "|  | a\\|b |\n| --- | ---: |\n| two lines | 1 |"
