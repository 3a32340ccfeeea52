import js from "@eslint/js";
import globals from "globals";

// External text must never become markup or code, and pages must not load anything: see
// docs/architecture.md, "Scripts of the HTML reports".
const MARKUP_FROM_TEXT = ["innerHTML", "outerHTML", "insertAdjacentHTML", "setHTMLUnsafe", "write"];
const message = "Make elements with `element` of shared/dom.js: its strings become text nodes.";
const noNetwork = "Pages load nothing; scripts beside the replay page are run by replay/loader.js.";

export default [
  js.configs.recommended,
  {
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      curly: ["error", "multi-line"],
      eqeqeq: "error",
      "no-eval": "error",
      "no-implied-eval": "error",
      "no-new-func": "error",
      "no-restricted-globals": [
        "error",
        ...["fetch", "XMLHttpRequest", "WebSocket", "EventSource"].map((name) => ({
          name,
          message: noNetwork,
        })),
      ],
      "no-restricted-properties": [
        "error",
        ...MARKUP_FROM_TEXT.map((property) => ({ property, message })),
      ],
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
    },
  },
  { files: ["src/**"], languageOptions: { globals: globals.browser } },
  {
    files: ["*.js"],
    languageOptions: { globals: globals.node },
    rules: { "no-restricted-properties": "off" },
  },
];
