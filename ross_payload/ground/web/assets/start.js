/**
 * Starts the page. The network of a field laptop changes now and then, and files on their way are lost with it:
 * then the page is loaded again, a few times, until it is whole.
 */

const MOST = 5; // tries
const WAIT = 700; // [ms]
const TRIES = "ross-tries";

const whole = () => [...document.querySelectorAll("link[rel=stylesheet]")].every((link) => link.sheet);

function again() {
  const tries = Number(sessionStorage.getItem(TRIES) ?? 0) + 1;
  sessionStorage.setItem(TRIES, String(tries));
  if (tries <= MOST) setTimeout(() => location.reload(), WAIT);
}

async function start() {
  if (document.readyState !== "complete") await new Promise((done) => addEventListener("load", done, { once: true }));
  if (!whole()) return again();
  try {
    await import("./app.js");
    sessionStorage.removeItem(TRIES);
  } catch (error) {
    console.error(error);
    again();
  }
}

start();
