// @ts-check
// Light or dark theme: the one chosen before, otherwise the one that the system prefers. A bundle of
// its own that runs in the head, before anything is painted. A button with the id "theme" switches.

/** @typedef {"light" | "dark"} Theme */

const STORAGE_KEY = "plant-bench-theme";
const root = document.documentElement;
const prefersDark = matchMedia("(prefers-color-scheme: dark)");

/** @returns {Theme | null} */
function storedTheme() {
  try {
    const value = localStorage.getItem(STORAGE_KEY);
    return value === "dark" || value === "light" ? value : null;
  } catch {
    return null; // some browsers have no storage for pages from disk
  }
}

/** @param {Theme} theme */
function storeTheme(theme) {
  try {
    localStorage.setItem(STORAGE_KEY, theme);
  } catch {
    // without storage the choice lasts until the page is closed
  }
}

/** @param {Theme} theme */
function applyTheme(theme) {
  root.dataset.theme = theme;
  const button = document.getElementById("theme");
  if (button) button.textContent = theme === "dark" ? "Light mode" : "Dark mode";
  document.dispatchEvent(new CustomEvent("themechange", { detail: theme }));
}

/** @returns {Theme} */
const systemTheme = () => (prefersDark.matches ? "dark" : "light");
/** @returns {Theme} */
const currentTheme = () => (root.dataset.theme === "dark" ? "dark" : "light");

applyTheme(storedTheme() ?? systemTheme());
prefersDark.addEventListener("change", () => {
  if (!storedTheme()) applyTheme(systemTheme());
});
document.addEventListener("DOMContentLoaded", () => {
  applyTheme(currentTheme());
  document.getElementById("theme")?.addEventListener("click", () => {
    const next = currentTheme() === "dark" ? "light" : "dark";
    storeTheme(next);
    applyTheme(next);
  });
});
