/** The four looks. `auto` follows the system; `sunlight` is light with the greatest contrast and thicker lines. */

export const THEMES = ["auto", "dark", "light", "sunlight"];
const KEPT = "ross-theme";

export function readTheme() {
  const kept = localStorage.getItem(KEPT);
  return THEMES.includes(kept) ? kept : "auto";
}

export function applyTheme(theme) {
  document.documentElement.dataset.theme = theme;
}

export function keepTheme(theme) {
  localStorage.setItem(KEPT, theme);
  applyTheme(theme);
}
