"""How templates are drawn, in a real browser: what changes is changed, and nothing else is touched."""

import random

import pytest

from gallery import board_of

SCRIPT = """async (argument) => {
  const { guard, html, nothing, render, repeat, svg } = await import("/assets/templates.js");
  const place = document.body.appendChild(document.createElement("div"));
  try { %s } finally { place.remove(); }
}"""


@pytest.fixture(scope="module")
def run(profile):
    with board_of(profile) as board:
        page = board({})
        yield lambda script, argument=None: page.evaluate(SCRIPT % script, argument)


def test_a_value_is_text_whatever_it_holds(run):
    text = run(
        """const told = '<img src="x" onerror="alert(1)">"><b>';
        render(html`<p title=${told} class="a ${told}">${told}</p>`, place);
        const [p] = place.children;
        return [p.title, p.className, p.textContent, place.querySelectorAll("*").length];"""
    )
    told = '<img src="x" onerror="alert(1)">"><b>'
    assert text == [told, f"a {told}", told, 1]


def test_what_does_not_change_is_not_touched(run):
    records = run(
        """const draw = (a, b) => render(html`<p class=${a} ?hidden=${false} @click=${() => a}>${a}: ${b}</p>`, place);
        draw("one", 1);
        const changes = new MutationObserver(() => {});
        changes.observe(place, { subtree: true, childList: true, attributes: true, characterData: true });
        draw("one", 1);
        const none = changes.takeRecords().length;
        draw("one", 2);
        return [none, changes.takeRecords().map((each) => each.type), place.textContent];"""
    )
    assert records == [0, ["characterData"], "one: 2"]


def test_focus_and_selection_stay_while_a_list_changes_around_them(run):
    kept = run(
        """const draw = (keys) => render(html`<ul>${repeat(keys, (key) => key, (key) =>
          html`<li><input id=${key} value=${key}></li>`)}</ul>`, place);
        draw(["gone", "typed", "last"]);
        const field = place.querySelector("#typed");
        field.focus();
        field.setSelectionRange(1, 3);
        draw(["newest", "newer", "typed", "last"]);
        draw(["newest", "typed"]);
        const same = document.activeElement === field && place.querySelector("#typed") === field;
        const ids = [...place.querySelectorAll("input")].map(({ id }) => id);
        return [same, field.selectionStart, field.selectionEnd, ids];"""
    )
    assert kept == [True, 1, 3, ["newest", "typed"]]


def test_an_element_goes_with_its_key(run):
    same = run(
        """const draw = (keys) => render(repeat(keys, (key) => key, (key) => html`<i>${key}</i>`), place);
        draw(["a", "b", "c"]);
        const [a, b, c] = place.children;
        draw(["c", "d", "a", "b"]);
        const [first, , third, fourth] = place.children;
        return [first === c, third === a, fourth === b, place.textContent];"""
    )
    assert same == [True, True, True, "cdab"]


@pytest.mark.parametrize("seed", range(5))
def test_a_changed_list_shows_what_a_new_one_would(run, seed):
    generator = random.Random(seed)  # noqa: S311 - no secret
    lists = [[generator.choice("abcdefgh") for _ in range(generator.randrange(9))] for _ in range(40)]  # some twice
    shown = run(
        """return argument.map((keys) => {
          render(html`<p>${repeat(keys, (key) => key, (key) => key < "e" ? html`<i>${key}</i>` : key)}</p>`, place);
          return place.textContent;
        });""",
        lists,
    )
    assert shown == ["".join(keys) for keys in lists]


def test_every_kind_of_value_gives_way_to_every_other(run):
    shown = run(
        """const kinds = { text: "t", number: 0, template: html`<b>b</b>`, list: ["l", html`<i>m</i>`], none: nothing,
          unknown: null, drawing: html`<svg>${svg`<path></path>`}</svg>` };
        const names = Object.keys(kinds);
        return names.flatMap((one) => names.map((other) => {
          render(kinds[one], place);
          render(kinds[other], place);
          const before = place.textContent;
          const fresh = document.createElement("div");
          render(kinds[other], fresh);
          return before === fresh.textContent ? null : `${one} to ${other}`;
        })).filter(Boolean);"""
    )
    assert shown == []


def test_an_attribute_without_a_value_is_left_out(run):
    shown = run(
        """const draw = (value) => render(html`<a href="#" aria-current=${value} ?hidden=${value}>x</a>`, place);
        return ["page", nothing, "true"].map((value) => {
          draw(value);
          const [a] = place.children;
          return [a.getAttribute("aria-current"), a.hasAttribute("hidden")];
        });"""
    )
    assert shown == [["page", True], [None, False], ["true", True]]


def test_a_property_follows_its_value_after_the_user_has_changed_it(run):
    shown = run(
        """const draw = (value) => render(html`<input .value=${value}>`, place);
        draw("told");
        const [field] = place.children;
        field.value = "typed";
        draw("told");
        return [field.value, field.hasAttribute(".value")];"""
    )
    assert shown == ["told", False]


def test_the_latest_listener_is_called_once(run):
    calls = run(
        """const calls = [];
        const draw = (name) => render(html`<button @click=${() => calls.push(name)}>x</button>`, place);
        ["first", "second"].forEach(draw);
        place.querySelector("button").click();
        return calls;"""
    )
    assert calls == ["second"]


def test_what_is_guarded_is_drawn_again_when_a_source_is_another(run):
    shown = run(
        """let times = 0;
        const draw = (sources) => render(html`<p>${guard(sources, () => `${++times}`)}</p>`, place);
        const list = [];
        return [[list, 1], [list, 1], [[], 1], [list, 1]].map((sources) => (draw(sources), place.textContent));"""
    )
    assert shown == ["1", "1", "2", "3"]


def test_a_drawing_is_of_the_namespace_of_svg_and_keeps_the_case_of_its_attributes(run):
    shown = run(
        """const line = svg`<path d=${"M0 0"}><title>${"a < b"}</title></path>`;
        render(html`<svg viewBox="0 0 ${4} ${2}">${line}</svg>`, place);
        const drawing = place.querySelector("svg");
        const path = place.querySelector("path");
        return [drawing.viewBox.baseVal.width, path.namespaceURI, path.getAttribute("d"), path.textContent];"""
    )
    assert shown == [4, "http://www.w3.org/2000/svg", "M0 0", "a < b"]


def test_rows_of_a_table_are_drawn_where_they_belong(run):
    shown = run(
        """render(html`<table><tbody>${[1, 2].map((each) => html`<tr><td>${each}</td></tr>`)}</tbody></table>`, place);
        return [...place.querySelectorAll("table > tbody > tr > td")].map((each) => each.textContent);"""
    )
    assert shown == ["1", "2"]


def test_messages_that_came_late_make_no_loss_less_than_none(run):
    loss = run(
        """const { rates } = await import("/assets/parts/health.js");
        const counts = [[0, 100, 5], [5, 150, 3]].map(([now, frames, lost]) => ({ now, frames, bytes: 0, lost }));
        return rates(counts).loss;"""
    )
    assert loss == 0
