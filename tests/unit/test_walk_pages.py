"""The pages that walk through the code: every name exists, every number is right, every quote is the paper's."""

import doctest
import importlib
import os
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXPLANATION = ROOT / "docs" / "explanation"
PAGES = ("one-turn-through-the-code.md", "contradictions.md")
PAPER = Path(os.environ.get("ROSS_PAPER", ROOT.parent / "shared" / "paper" / "RoSS.tex"))
PACKAGES = ("ross_payload", "ross_sim", "ross_protocols")
PACKAGE_FOLDERS = (ROOT / "ross_payload", ROOT / "protocols" / "ross_protocols", ROOT / "sim" / "ross_sim")
ROOMS = {path.stem for path in (ROOT / "ross_payload").iterdir() if path.suffix in ("", ".py")}


def text(page):
    return (EXPLANATION / page).read_text(encoding="utf-8")


def names(page):
    """Code spans that begin with a package, or with a room of ours: `dsp.itd.itd_per_bin`."""
    spans = re.findall(r"`([A-Za-z_]\w*(?:\.\w+)+)`", text(page))
    return sorted({span for span in spans if span.split(".")[0] in {*PACKAGES, *ROOMS}})


def resolved(name):
    full = name if name.split(".")[0] in PACKAGES else f"ross_payload.{name}"
    parts = full.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        for part in parts[cut:]:
            found = getattr(found, part)
        return found
    raise AttributeError(name)


@pytest.mark.parametrize("name", sorted({name for page in PAGES for name in names(page)}))
def test_a_name_on_the_page_exists(name):
    assert resolved(name) is not None


def test_the_walk_names_a_function_at_every_step():
    steps = re.split(r"^## (?=\d+\.)", text(PAGES[0]), flags=re.MULTILINE)[1:]
    assert [int(step.split(".")[0]) for step in steps] == list(range(1, len(steps) + 1))
    without = [step.splitlines()[0] for step in steps if not re.search(r"`\w+\.\w+\.[\w.]+`|`service\.", step)]
    assert not without


def test_a_name_that_is_gone_is_noticed():
    with pytest.raises(AttributeError):
        resolved("dsp.itd.no_such_function")


@pytest.mark.parametrize("page", PAGES)
def test_the_numbers_on_the_page_are_right(page):
    source = "\n".join(re.findall(r"```python\n(.*?)```", text(page), re.DOTALL))
    test = doctest.DocTestParser().get_doctest(source, {}, page, page, 0)
    assert test.examples
    said = []
    failed = doctest.DocTestRunner(verbose=False).run(test, out=said.append).failed
    assert not failed, "".join(said)


def plain(words):
    """Words without markup: commands and math signs gone, spaces alike."""
    words = re.sub(r"\\(?:em|bf|algo|minus|new|noindent)\b", " ", words)
    return re.sub(r"\s+", " ", re.sub(r"[\\${}]", "", words)).strip()


def test_every_quote_is_in_the_paper():
    if not PAPER.is_file():
        pytest.skip(f"needs the paper's source {PAPER.name} in ../shared/paper (or ROSS_PAPER)")
    paper = plain(PAPER.read_text(encoding="utf-8"))
    quotes = [plain(line) for line in re.findall(r"^> (.*)$", text("contradictions.md"), re.MULTILINE)]
    assert len(quotes) > 10
    assert [quote for quote in quotes if quote not in paper] == []


def test_the_glossary_names_what_the_code_is_called():
    code = "\n".join(path.read_text(encoding="utf-8") for top in PACKAGE_FOLDERS for path in top.rglob("*.py"))
    words = {re.match(r"\w*", path.stem)[0] for top in PACKAGE_FOLDERS for path in top.rglob("*")} | set(
        re.findall(r"\w+", code)
    )
    rows = [line.split("|")[-2] for line in text("glossary.md").splitlines() if line.startswith("| ")]
    named = {name for row in rows for span in re.findall(r"`([^`]+)`", row) for name in re.findall(r"\w+", span)}
    assert named - words - {"py", "ross_sim", "scenarios", "sim"} == set()
