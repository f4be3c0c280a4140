"""What a person would see on a page: the words that stood in a place one after the other, and words anywhere."""

import pytest

from browsing import eventually

FOLLOW = """selector => {
  globalThis.rossSeen = [];
  const look = () => {
    const words = document.querySelector(selector)?.textContent.trim();
    if (words && globalThis.rossSeen.at(-1) !== words) globalThis.rossSeen.push(words);
  };
  new MutationObserver(look).observe(document.body, {childList: true, characterData: true, subtree: true});
  look();
}"""
PAUSES = """() => {
  globalThis.rossPause = 0;
  let before = performance.now();
  const step = 20;
  setInterval(() => {
    const now = performance.now();
    globalThis.rossPause = Math.max(globalThis.rossPause, (now - before - step) / 1000);
    before = now;
  }, step);
}"""
FREE = """(selector) => {
  const middle = ([x, y]) => Math.hypot(x - 5, y - 5);
  const places = Array.from({ length: 81 }, (_, place) => [1 + (place % 9), 1 + Math.floor(place / 9)]);
  places.sort((one, other) => middle(one) - middle(other));
  return Array.from(document.querySelectorAll(selector)).flatMap((end) => {
    const box = end.getBoundingClientRect();
    return places.map(([x, y]) => [box.x + (box.width * x) / 10, box.y + (box.height * y) / 10])
      .filter(([x, y]) => document.elementFromPoint(x, y)?.parentElement === end.parentElement);
  }).at(0);
}"""
AXE = """async (rules) => {
  const { violations } = await axe.run({ resultTypes: ["violations"], ...(rules && { runOnly: rules }) });
  return violations.map((each) => [each.id, each.nodes.map((node) => node.html)]);
}"""


def follow(page, selector):
    """From now on, note all words that the page shows in a place; `seen` tells them in their order."""
    page.evaluate(FOLLOW, selector)


def seen(page):
    return page.evaluate("() => globalThis.rossSeen")


def note_pauses(page):
    """From now on, note for how long the computer keeps the page from running; `longest_pause` tells it [s]."""
    page.evaluate(PAUSES)


def longest_pause(page):
    return page.evaluate("() => globalThis.rossPause")


def free_place(page, selector):
    """A place [px] of an end of the axis on which nothing else lies: sources walk over them."""
    return page.evaluate(FREE, selector)


def violations(page, rules=None):
    """What keeps people from using the page, as axe-core finds it: rules (None: of all), and what breaks them."""
    axe = pytest.importorskip("axe_playwright_python.base")
    if not page.evaluate("'axe' in globalThis"):
        page.evaluate(axe.AXE_SCRIPT)
    return page.evaluate(AXE, rules)


def sees(page, words, selector="body"):
    """Wait until words are on the page."""
    there = page.locator(selector).first
    eventually(page, lambda: words in (there.text_content() or ""), what=lambda: f"{words!r}: {there.text_content()!r}")


def watch(open_page, url, who="1-191", **options):
    """Open a payload's page and wait for its picture."""
    page = open_page(f"{url}#/payload/{who}", **options)
    page.locator(".hero .scope").wait_for()
    page.locator("table.sources").wait_for()
    return page


def texts(page, selector):
    """The words of all that fits a selector."""
    return page.locator(selector).all_inner_texts()
