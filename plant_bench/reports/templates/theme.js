// Light or dark: what was chosen before, else what the system prefers. Runs in the head, before
// anything is painted. A button with the id "theme" switches.
"use strict";
(() => {
  const root = document.documentElement;
  const preference = matchMedia("(prefers-color-scheme: dark)");

  function remembered() {
    try {
      const value = localStorage.getItem("plant-bench-theme");
      return value === "dark" || value === "light" ? value : null;
    } catch {
      return null; // some browsers keep nothing for pages from disk
    }
  }

  function remember(value) {
    try {
      localStorage.setItem("plant-bench-theme", value);
    } catch {
      // it lasts until the page is closed
    }
  }

  function show(theme) {
    root.dataset.theme = theme;
    const button = document.getElementById("theme");
    if (button) button.textContent = theme === "dark" ? "Light mode" : "Dark mode";
    document.dispatchEvent(new CustomEvent("themechange", { detail: theme }));
  }

  const preferred = () => (preference.matches ? "dark" : "light");
  show(remembered() ?? preferred());
  preference.addEventListener("change", () => {
    if (!remembered()) show(preferred());
  });
  document.addEventListener("DOMContentLoaded", () => {
    show(root.dataset.theme);
    document.getElementById("theme")?.addEventListener("click", () => {
      const next = root.dataset.theme === "dark" ? "light" : "dark";
      remember(next);
      show(next);
    });
  });
})();
