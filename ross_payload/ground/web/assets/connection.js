/**
 * The socket to the ground process, and the store that its messages fill.
 *
 * The store is a plain frozen-in-spirit object: `take` returns a new one, so a view can never change what is known.
 */

const FIRST_RETRY = 200; // [ms]
const LONGEST_RETRY = 2000; // [ms]
const LONGEST_SILENCE = 10_000; // [ms]: the ground process says something every second
const MOST_REFUSALS = 5;
const RATE_SPAN = 5; // [s] over which rates are taken

/**
 * @typedef {object} Told  A payload as it was told: live, or of a recording.
 * @property {string} id
 * @property {number} now  the teller's clock [s]
 * @property {number} got  when it came, `performance.now()` [ms]
 * @property {?number} heard  when its newest message came to the ground process, UNIX time [ms]
 * @property {Object<string, any>} sections
 * @property {{now: number, frames: number, bytes: number, lost: number}[]} counts  of the last seconds, oldest first
 */

/** Return a store that knows nothing, and of which payload it is to know more; null: of none. */
export function blank(watched = null) {
  return {
    watched,
    you: null,
    proof: null, // that this browser is who it says it was
    version: "",
    mode: "live",
    mayOrder: false,
    tiles: null, // of the map that the ground process was given: {minzoom, maxzoom, attribution, center}
    fleet: null,
    fleetGot: 0,
    control: { holder: null, name: null, yours: false },
    payload: /** @type {?Told} */ (null),
    flights: null,
    recordings: null,
    slots: { a: null, b: null }, // {flight, got, payload}
    refusals: [], // newest first: {what, reason, got}
  };
}

/** Return the store after a message that came at `got` [ms]. Unknown types change nothing: the server may be newer. */
export function take(store, message, got) {
  const taker = Object.hasOwn(TAKERS, message.type) ? TAKERS[message.type] : null;
  return taker ? taker(store, message, got) : store;
}

const TAKERS = {
  hello: (store, { you, proof, version, mode, may_order: mayOrder, map }) => ({
    ...store,
    you,
    proof,
    version,
    mode: mode ?? "live",
    mayOrder: mayOrder ?? true,
    tiles: map ?? null,
    payload: proof && proof === store.proof ? store.payload : null, // of another process: another clock
  }),
  fleet: (store, message, got) => ({ ...store, fleet: message, fleetGot: got }),
  control: (store, { holder, name, yours }) => ({ ...store, control: { holder, name, yours } }),
  refused: (store, { what, reason }, got) => ({
    ...store,
    refusals: [{ what, reason, got }, ...store.refusals].slice(0, MOST_REFUSALS),
  }),
  flights: (store, { known }) => ({ ...store, flights: known }),
  recordings: (store, { folder, known }) => ({ ...store, recordings: { folder, known } }),
  flight: (store, message, got) => inSlot(store, message.slot, (slot) => flown(slot, message, got)),
  payload: (store, message, got) =>
    message.slot
      ? inSlot(store, message.slot, (slot) => ({ ...slot, payload: told(slot?.payload, message, got) }))
      : message.id === store.watched // else it was on its way when another one was chosen
        ? { ...store, payload: told(store.payload, message, got) }
        : store,
};

function inSlot(store, slot, change) {
  if (slot !== "a" && slot !== "b") return store;
  return { ...store, slots: { ...store.slots, [slot]: change(store.slots[slot]) } };
}

/** A flight as it goes on; another flight in its place begins with nothing. */
const flown = (slot, flight, got) =>
  slot?.flight && slot.flight.name !== flight.name ? { flight, got, payload: null } : { ...slot, flight, got };

/** Merge a payload's changed sections into those that are known of it. @returns {Told} */
function told(before, message, got) {
  const same = before?.id === message.id ? before : null;
  const sections = { ...same?.sections, ...message.sections };
  return {
    id: message.id,
    now: message.now,
    got,
    heard: message.heard ?? null,
    sections,
    counts: counted(same?.counts ?? [], message.now, sections.health?.reception),
  };
}

function counted(counts, now, reception) {
  if (!reception) return counts;
  const kept = counts.filter((each) => each.now <= now && now - each.now < RATE_SPAN);
  return [...kept, { now, frames: reception.frames, bytes: reception.bytes, lost: reception.lost }];
}

/** Return the store that watches another payload, of which it knows nothing yet; null: none. */
export const watching = (store, watched) => ({ ...store, payload: null, watched });

/** Return the store with one slot emptied. */
export const closed = (store, slot) => ({ ...store, slots: { ...store.slots, [slot]: null } });

/**
 * Keep a socket open: it is opened again within two seconds, for as long as the page is there.
 *
 * @param {() => string} address  of the socket, asked for before every attempt
 * @param {{message: (message: object) => void, up: () => void, down: () => void}} on
 * @returns {{send: (message: object) => boolean}} `send` says whether the message left
 */
export function connect(address, on) {
  let socket = null;
  let wait = FIRST_RETRY;
  let heard = 0;
  const open = () => {
    const mine = new WebSocket(address());
    const listen = (name, call) => mine.addEventListener(name, (event) => mine === socket && call(event));
    socket = mine;
    listen("open", () => {
      wait = FIRST_RETRY;
      heard = performance.now();
      on.up();
    });
    listen("message", (event) => {
      heard = performance.now();
      receive(event.data, on.message);
    });
    listen("close", lost);
  };
  const lost = () => {
    socket = null;
    on.down();
    setTimeout(open, wait);
    wait = Math.min(wait * 2, LONGEST_RETRY);
  };
  setInterval(() => {
    if (socket?.readyState !== WebSocket.OPEN || performance.now() - heard < LONGEST_SILENCE) return;
    socket.close(); // the network is gone: it would not notice for minutes
    lost();
  }, 1000);
  open();
  return {
    send(message) {
      if (socket?.readyState !== WebSocket.OPEN) return false;
      socket.send(JSON.stringify(message));
      return true;
    },
  };
}

function receive(data, call) {
  let message = null;
  try {
    message = JSON.parse(data);
  } catch {
    return; // a broken message is as good as a lost one: the next one tells it again
  }
  if (message && typeof message === "object") call(message);
}

/** Return the address of the socket beside this page; `you` is who this browser was, to go on as the same one. */
export function liveAddress({ protocol, host }, you, proof) {
  return `${protocol === "https:" ? "wss" : "ws"}://${host}/live${you ? `?${new URLSearchParams({ you, proof })}` : ""}`;
}
