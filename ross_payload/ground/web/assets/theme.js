/** The four looks. `auto` follows the system; `sunlight` is light with the greatest contrast and thicker lines. */

export const THEMES = ["auto", "dark", "light", "sunlight"];
const KEPT = "ross-theme";

/** What an access to the browser's storage gives; null where it is forbidden, as by who blocks all cookies. */
function stored(access) {
  try {
    return access();
  } catch {
    return null;
  }
}

export function readTheme() {
  const kept = stored(() => localStorage.getItem(KEPT));
  return THEMES.includes(kept) ? kept : "auto";
}

export function applyTheme(theme) {
  document.documentElement.dataset.theme = theme;
}

export function keepTheme(theme) {
  stored(() => localStorage.setItem(KEPT, theme));
  applyTheme(theme);
}
