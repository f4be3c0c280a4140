/**
 * Draws templates. The fixed text of a template is parsed once; a later drawing touches only what has changed, so that
 * focus, selection and what is being typed stay. A value is never parsed: it becomes text, or the value of an attribute.
 *
 * Between tags stands text, a template, a list of either, or `nothing`. In a tag:
 * `name=${text}` (with `nothing` the attribute is left out), `?name=${condition}`, `.name=${property}`, `@name=${listener}`.
 * A property follows its value also after the user has changed it.
 */

const HOLE = "\uE000"; // stands for a value in the text of a template
const TAG = /<[a-z](?:"[^"]*"|[^">])*>/gi;
const ATTRIBUTE = /\s([^\s"=>]+)=("[^"]*"|[^\s">]+)/g;
const BOUND = "data-bound"; // marks an element with values in its tag until the template is prepared

export const nothing = Symbol("nothing");

/** A template of HTML, or of what stands inside of an SVG. */
export const html = (strings, ...values) => ({ strings, values, inSvg: false });
export const svg = (strings, ...values) => ({ strings, values, inSvg: true });

/** A list whose elements stay the same as long as their keys do, wherever they stand. */
export const repeat = (items, keyOf, draw) => new Keyed(items.map((item) => [keyOf(item), draw(item)]));

/** What `draw` returns, drawn again only when one of `sources` is another one. */
export const guard = (sources, draw) => new Guarded(sources, draw);

/** Draw a value into an element, after what stands there already. */
export function render(value, element) {
  if (!places.has(element)) places.set(element, new Place(element.appendChild(new Comment())));
  places.get(element).update(value);
}

const places = new WeakMap(); // of `render`, by their elements

class Keyed {
  constructor(entries) {
    this.entries = entries;
  }
}

class Guarded {
  constructor(sources, draw) {
    Object.assign(this, { sources, draw });
  }
}

const prepared = new WeakMap(); // by the strings of the template

/** Parse the fixed text of a template, and find where its values go: nodes by their number in the order of the document. */
function prepare({ strings, inSvg }) {
  const tags = []; // of the elements with values in their tags: their attributes as [name, fixed texts]
  const marked = strings.join(HOLE).replace(TAG, (tag) => (tag.includes(HOLE) ? mark(tag, tags) : tag));
  const text = marked.replaceAll(HOLE, `<!--${HOLE}-->`);
  const template = document.createElement("template");
  template.innerHTML = inSvg ? `<svg>${text}</svg>` : text;
  const { content } = template;
  if (inSvg) content.firstChild.replaceWith(...content.firstChild.childNodes);
  const holes = [];
  nodesOf(content).forEach((node, number) => {
    if (node instanceof Comment && node.data === HOLE) holes.push({ number, attributes: null });
    if (!(node instanceof Element && node.hasAttribute(BOUND))) return;
    node.removeAttribute(BOUND);
    holes.push({ number, attributes: tags.shift() });
  });
  return { content, holes };
}

/** Take the attributes with values out of a tag: half-made ones would be complained about. */
function mark(tag, tags) {
  const attributes = [];
  const rest = tag.replace(ATTRIBUTE, (whole, name, value) => {
    if (!value.includes(HOLE)) return whole;
    attributes.push([name, value.replaceAll('"', "").split(HOLE)]);
    return "";
  });
  tags.push(attributes);
  return rest.replace(/^<[^\s/>]+/, `$& ${BOUND}`);
}

function nodesOf(root) {
  const walker = document.createTreeWalker(root, NodeFilter.SHOW_ELEMENT | NodeFilter.SHOW_COMMENT);
  const nodes = [];
  while (walker.nextNode()) nodes.push(walker.currentNode);
  return nodes;
}

/** A template on the page: its values are written by `update`. */
class Instance {
  constructor(template) {
    this.strings = template.strings;
    if (!prepared.has(this.strings)) prepared.set(this.strings, prepare(template));
    const { content, holes } = prepared.get(this.strings);
    this.fragment = document.importNode(content, true);
    const nodes = nodesOf(this.fragment);
    this.parts = holes.flatMap(({ number, attributes }) =>
      attributes ? attributes.map((each) => attribute(nodes[number], ...each)) : [child(nodes[number])],
    );
    this.update(template.values);
  }

  update(values) {
    let at = 0;
    for (const { count, write } of this.parts) {
      write(...values.slice(at, at + count));
      at += count;
    }
  }
}

function child(comment) {
  const place = new Place(comment);
  return { count: 1, write: (value) => place.update(value) };
}

function attribute(element, name, texts) {
  const write = Object.hasOwn(WRITERS, name[0]) ? WRITERS[name[0]](element, name.slice(1)) : written(element, name, texts);
  return { count: texts.length - 1, write };
}

const WRITERS = {
  "?": (element, name) => (value) => element.toggleAttribute(name, Boolean(value) && value !== nothing),
  ".": (element, name) => (value) => {
    if (element[name] !== value) element[name] = value;
  },
  "@": (element, name) => {
    let listener = null;
    element.addEventListener(name, (event) => listener(event));
    return (value) => (listener = value);
  },
};

/** An attribute with its fixed texts around the values. */
function written(element, name, texts) {
  let before = null;
  return (...values) => {
    const text = values.map((value, index) => `${value === nothing ? "" : (value ?? "")}${texts[index + 1]}`);
    const after = values.includes(nothing) ? null : texts[0] + text.join("");
    if (after === before) return;
    before = after;
    if (after === null) element.removeAttribute(name);
    else element.setAttribute(name, after);
  };
}

/** A place between two comments: text, the instance of a template, a list of places, or nothing stands there. */
class Place {
  constructor(end) {
    this.start = end.parentNode.insertBefore(new Comment(), end);
    this.end = end;
    this.content = null; // Text, Instance, or Map of places by key
    this.sources = null; // of a guarded value
  }

  update(value) {
    if (value instanceof Guarded) {
      const { sources } = value;
      if (this.sources?.length === sources.length && sources.every((each, index) => each === this.sources[index])) return;
      this.show(value.draw());
      this.sources = sources;
    } else {
      this.sources = null;
      this.show(value);
    }
  }

  show(value) {
    if (value === nothing || value == null || value === "") this.clear();
    else if (value instanceof Keyed) this.list(value.entries);
    else if (Array.isArray(value)) this.list([...value.entries()]);
    else if (value.strings) this.template(value);
    else this.text(String(value));
  }

  text(text) {
    if (!(this.content instanceof Text)) this.fill(new Text(), (made) => made);
    if (this.content.data !== text) this.content.data = text;
  }

  template(template) {
    if (this.content?.strings === template.strings) this.content.update(template.values);
    else this.fill(new Instance(template), (made) => made.fragment);
  }

  /** Show values by key: what is gone goes first, so that what stays need not move. */
  list(entries) {
    const before = this.content instanceof Map ? this.content : new Map();
    if (before !== this.content) this.clear();
    const keys = new Set(entries.map(([key]) => key));
    before.forEach((place, key) => keys.has(key) || place.remove());
    this.content = new Map();
    let next = this.start.nextSibling;
    for (const [key, value] of entries) {
      const again = this.content.has(key); // a key that is there twice is another one each time
      const place = (again ? null : before.get(key)) ?? new Place(next.parentNode.insertBefore(new Comment(), next));
      if (place.end.nextSibling !== next && place.start !== next) next.before(...place.nodes());
      place.update(value);
      this.content.set(again ? Symbol("again") : key, place);
      next = place.end.nextSibling;
    }
  }

  fill(content, nodeOf) {
    this.clear();
    this.end.before(nodeOf(content));
    this.content = content;
  }

  clear() {
    if (this.content !== null) while (this.start.nextSibling !== this.end) this.start.nextSibling.remove();
    this.content = null;
  }

  remove() {
    for (const node of this.nodes()) node.remove();
  }

  nodes() {
    const nodes = [this.start];
    while (nodes.at(-1) !== this.end) nodes.push(nodes.at(-1).nextSibling);
    return nodes;
  }
}
