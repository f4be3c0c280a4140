/** Every instrument on one page. A test calls `show(state)`; `told` remembers what the instruments asked for. */

import { html, render } from "/assets/templates.js";
import { glyph } from "/assets/instruments/colours.js";
import { densities } from "/assets/instruments/densities.js";
import { levels } from "/assets/instruments/level-meters.js";
import { isolation } from "/assets/instruments/isolation.js";
import { scope } from "/assets/instruments/scope.js";
import { strip } from "/assets/instruments/mission-chart.js";

const gallery = document.getElementById("gallery");
let state = { sections: {}, now: 0, selected: null, hovered: null, drag: null, cursor: null, mayOrder: true };
const told = { turned: [], chosen: [], selected: [] };

const change = (patch) => {
  state = { ...state, ...patch };
  draw();
};

const hands = {
  onSelect: (selected) => { told.selected.push(selected); change({ selected }); },
  onTurn: (heading) => told.turned.push(heading),
  onChoose: (heading) => told.chosen.push(heading),
  onDrag: (drag) => change({ drag }),
  onHover: (hovered) => queueMicrotask(() => change({ hovered })), // it may come while drawing
  onCursor: (cursor) => change({ cursor }),
};

function draw() {
  const { sections } = state;
  const all = { ...state, ...hands };
  render(html`<h1 class="wide">Instruments</h1>
    <section class="card hero">${scope(all)}</section>
    <section class="card">${densities(all)}</section><section class="card">${isolation(all)}</section>
    <section class="card">${levels(sections.health?.microphones ?? {})}
      <p>${(sections.sources ?? []).map((each) => html`${glyph(each.source)} ${each.source} `)}</p></section>
    <section class="card wide">${strip(all)}</section>`, gallery);
}

/** Draw sections again and again, all of them new each time, one per frame. */
async function updates(sections, count) {
  for (let index = 0; index < count; index++) {
    const fresh = structuredClone(sections);
    fresh.pointing.heading = index;
    change({ sections: fresh, now: state.now + 0.1 });
    await new Promise((drawn) => requestAnimationFrame(drawn));
  }
}

Object.assign(globalThis, { show: change, told, updates });
draw();
