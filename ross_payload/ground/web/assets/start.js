/**
 * Starts the page. The network of a field laptop changes now and then, and files on their way are lost with it:
 * then the page is loaded again, a few times, until it is whole.
 */

const MOST = 5; // tries
const WAIT = 700; // [ms]

const whole = () => [...document.querySelectorAll("link[rel=stylesheet]")].every((link) => link.sheet);

function again() {
  const tries = (history.state?.tries ?? 0) + 1; // it outlives a reload, and needs no storage, which may be forbidden
  history.replaceState({ tries }, "");
  if (tries <= MOST) setTimeout(() => location.reload(), WAIT);
}

async function start() {
  if (document.readyState !== "complete") await new Promise((done) => addEventListener("load", done, { once: true }));
  if (!whole()) return again();
  try {
    await import("./app.js");
    history.replaceState(null, "");
  } catch (error) {
    console.error(error);
    again();
  }
}

start();
