"""The instruments of the page, in a real browser: what a reader hears, and whether every eye can read them."""

import random
import re
from itertools import combinations

import numpy as np
import pytest

from gallery import ASSETS
from page_eyes import violations
from scenes import pointing, scene, scenes, source, three

THEMES = ("dark", "light", "sunlight")
GROUNDS = {"light": ("#ffffff", "#f4f6f7"), "dark": ("#0e1317", "#151b20", "#1c242a")}  # of theme.css
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Linear sRGB as the colour-blind see it, at full severity (Machado, Oliveira, Fernandes 2009).
SIGHTS = {
    "usual": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
# From linear sRGB to OKLab (Ottosson 2020), in which equal distances look about equal.
CONES = np.array([[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
                  [0.0883024619, 0.2817188376, 0.6299787005]])  # fmt: skip
OKLAB = np.array([[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
                  [0.0259040371, 0.7827717662, -0.8086757660]])  # fmt: skip


# Readers


def test_a_source_says_everything_to_a_screen_reader(board):
    page = board(scene([source(0, 70, resolved=False, mirror=350.0), source(2, 40, target=True)]))
    words = [each.get_attribute("aria-label") for each in page.query_selector_all(".source")]
    assert words[0].startswith("source 0, 70 degrees, plus or minus 3, or 350 degrees")
    assert words[1] == "source 2, 40 degrees, plus or minus 3, confidence 90 percent, target"


def test_the_summary_changes_only_with_the_sources_and_the_target(board):
    page = board(three())
    page.evaluate(
        """() => { globalThis.spoken = 0; new MutationObserver(() => globalThis.spoken++)
          .observe(document.querySelector('.scope [aria-live]'),
                   {childList: true, characterData: true, subtree: true}); }"""
    )  # fmt: skip
    assert page.locator(".scope [aria-live]").text_content() == "3 sources, target: source 1"
    for heading in range(5):
        page.evaluate("state => show(state)", {"sections": {**three(), "pointing": pointing(heading)}})
    assert page.evaluate("spoken") == 0
    page.evaluate("state => show(state)", {"sections": scenes()["five"]})
    assert page.evaluate("spoken") > 0


@pytest.mark.parametrize("theme", THEMES)
def test_axe_finds_nothing_wrong(board, theme):
    assert violations(board(scenes()["limits"], theme=theme, selected=1)) == []


# Sizes and colours


@pytest.mark.parametrize("name", ["three", "thirty-two", "limits"])
def test_no_text_is_smaller_than_12_px_on_a_phone(board, name):
    page = board(scenes()[name], width=320)
    sizes = page.evaluate(
        """() => [...document.querySelectorAll('main text, main p, main span')].filter(each => each.textContent.trim())
          .map(each => parseFloat(getComputedStyle(each).fontSize) * (each.getScreenCTM?.().a ?? 1))"""
    )
    assert min(sizes) >= 12


@pytest.mark.parametrize("width", [320, 800, 1920, 3840])
def test_nothing_is_wider_than_the_screen(board, width):
    page = board(three(), width=width)
    assert page.evaluate("document.documentElement.scrollWidth") <= width


TEXTS = """drawings => drawings.map((sections) => {
  show({ sections });
  const texts = [...document.querySelectorAll(".labels text, .corners text")].filter((each) => each.textContent.trim());
  return texts.map((each) => {
    const { left, right, top, bottom } = each.getBoundingClientRect();
    return [left, right, top + 0.15 * (bottom - top), bottom - 0.15 * (bottom - top), each.textContent];
  });
})"""


def overlaps(page, drawings):
    """For each drawing the pairs of texts of the polar view that cover each other."""
    drawn = page.evaluate(TEXTS, drawings)
    assert all(len(boxes) > 2 for boxes in drawn)
    return [
        [(a[4], b[4]) for a, b in combinations(boxes, 2)
         if min(a[1], b[1]) > max(a[0], b[0]) and min(a[3], b[3]) > max(a[2], b[2])] for boxes in drawn
    ]  # fmt: skip


@pytest.mark.parametrize("width", [320, 1920])
def test_no_label_covers_another(board, width):
    page = board({}, width=width)
    names = ("three", "five", "thirty-two", "crowd", "around north")
    for name, found in zip(names, overlaps(page, [scenes()[name] for name in names]), strict=True):
        assert not found, name


def test_labels_keep_apart_wherever_the_sources_are(board):
    page = board({}, width=320)
    chance, bare = random.Random(4), scene([])  # noqa: S311 - without curves, which have places of their own
    drawings = []
    for _ in range(20):
        count = chance.randrange(1, 33)
        width = chance.choice((20, 90, 360))
        found = [source(index, (300 + width * chance.random()) % 360) for index in range(count)]
        drawings.append({**bare, "sources": found})
    for drawing, found in zip(drawings, overlaps(page, drawings), strict=True):
        assert not found, [each["azimuth"] for each in drawing["sources"]]


def linear(colour):
    """Linear sRGB of #rrggbb."""
    shares = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    low, high = sorted(float(LUMINANCE @ linear(each)) for each in (one, other))
    return (high + 0.05) / (low + 0.05)


def palette(look):
    text = (ASSETS / "instruments" / "instruments.css").read_text()
    pairs = re.findall(r"--source-\d: light-dark\((#\w{6}), (#\w{6})\)", text)
    assert len(pairs) == 8
    return [pair[look == "dark"] for pair in pairs]


@pytest.mark.parametrize("look", GROUNDS)
def test_every_colour_stands_out_from_every_ground(look):
    for ground in GROUNDS[look]:
        for colour in palette(look):
            assert contrast(colour, ground) >= 4.5, (colour, ground)


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("look", GROUNDS)
def test_no_two_colours_look_alike_to_anybody(look, sight):
    seen = {colour: np.clip(SIGHTS[sight] @ linear(colour), 0, 1) for colour in palette(look)}
    placed = {colour: OKLAB @ np.cbrt(CONES @ each) for colour, each in seen.items()}
    for one, other in combinations(placed, 2):
        assert np.linalg.norm(placed[one] - placed[other]) > 0.1, (one, other)


def test_every_source_looks_different(board):
    page = board(scenes()["thirty-two"])
    looks = page.evaluate(
        """() => [...document.querySelectorAll('.source > .mark')].map(each =>
          each.getAttribute('class') + each.firstElementChild.getAttribute('d') + each.childElementCount)"""
    )
    assert len(set(looks)) == 32


@pytest.mark.soak
def test_an_update_of_everything_costs_less_than_8_ms_of_the_processor(board):
    page = board(scenes()["five"], selected=1)
    profiler = page.context.new_cdp_session(page)
    profiler.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent():
        counts = profiler.send("Performance.getMetrics")["metrics"]
        return next(each["value"] for each in counts if each["name"] == "TaskDuration")

    page.evaluate("sections => updates(sections, 50)", scenes()["five"])
    before = spent()
    page.evaluate("sections => updates(sections, 300)", scenes()["five"])
    each = (spent() - before) / 300
    assert each < 0.008, f"{1e3 * each:.1f} ms"
