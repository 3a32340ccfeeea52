// Bundles the scripts of the HTML reports into plant_bench/reports/bundles: a classic script a page,
// with everything that it imports, which Python puts into the page.

import { mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const HERE = path.dirname(fileURLToPath(import.meta.url));
const OUT = path.resolve(HERE, process.argv[2] ?? "../plant_bench/reports/bundles");
const ENTRIES = {
  theme: "src/shared/theme.js",
  leaderboard: "src/leaderboard/main.js",
  replay: "src/replay/main.js",
};

/**
 * Return the licences of the packages of which a bundle has code, as a comment. Packages with the
 * same text are listed above it.
 */
async function licences(inputs) {
  const folders = new Set(
    Object.entries(inputs)
      .filter(([, { bytesInOutput }]) => bytesInOutput > 0)
      .map(([file]) => /^.*node_modules\/(?:@[^/]+\/)?[^/]+/.exec(file)?.[0])
      .filter((folder) => folder !== undefined),
  );
  const packages = new Map();
  for (const folder of [...folders].sort()) {
    const at = path.join(HERE, folder);
    const { name, version } = JSON.parse(await readFile(path.join(at, "package.json"), "utf8"));
    const file = (await readdir(at)).find((entry) => /^licen[cs]e/i.test(entry));
    if (!file) throw new Error(`The package ${name} has no licence file: look for its licence.`);
    const text = (await readFile(path.join(at, file), "utf8")).trim();
    packages.set(text, [...(packages.get(text) ?? []), `${name} ${version}`]);
  }
  const notices = [...packages].map(([text, names]) => `${names.join(", ")}\n\n${text}`);
  if (!notices.length) return "";
  const comment = notices.join("\n\n---\n\n").replaceAll("*/", "* /");
  return `/*! This script contains code of these packages:\n\n${comment}\n*/\n`;
}

await mkdir(OUT, { recursive: true });
for (const old of await readdir(OUT)) {
  if (old.endsWith(".min.js")) await rm(path.join(OUT, old));
}
for (const [name, entry] of Object.entries(ENTRIES)) {
  const { outputFiles, metafile } = await build({
    absWorkingDir: HERE,
    entryPoints: [entry],
    bundle: true,
    format: "iife",
    legalComments: "eof",
    metafile: true,
    minify: true,
    outfile: `${name}.js`,
    target: "es2022",
    write: false,
  });
  const [{ inputs }] = Object.values(metafile.outputs);
  const text = (await licences(inputs)) + outputFiles[0].text;
  await writeFile(path.join(OUT, `${name}.min.js`), text);
  console.log(`${name}.min.js: ${(text.length / 1000).toFixed(0)} kB`);
}
