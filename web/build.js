// Bundles the scripts of the HTML reports into plant_bench/reports/bundles: a classic script per page,
// with everything that it imports, which Python puts into the page. With --check nothing is written:
// it fails if a committed bundle differs from a fresh one.

import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const HERE = path.dirname(fileURLToPath(import.meta.url));
const BUNDLES = "plant_bench/reports/bundles";
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

/** Return the bundle of an entry. */
async function bundle(entry) {
  const { outputFiles, metafile } = await build({
    absWorkingDir: HERE,
    entryPoints: [entry],
    bundle: true,
    format: "iife",
    legalComments: "eof",
    metafile: true,
    minify: true,
    outfile: "bundle.js",
    target: "es2022",
    write: false,
  });
  const [{ inputs }] = Object.values(metafile.outputs);
  return (await licences(inputs)) + outputFiles[0].text;
}

const isCheck = process.argv.includes("--check");
const folder = path.join(HERE, "..", BUNDLES);
await mkdir(folder, { recursive: true });
const names = Object.keys(ENTRIES).map((name) => `${name}.min.js`);
const outdated = (await readdir(folder)).filter((name) => !names.includes(name));
for (const [name, entry] of Object.entries(ENTRIES)) {
  const file = path.join(folder, `${name}.min.js`);
  const text = await bundle(entry);
  if (!isCheck) {
    await writeFile(file, text);
    console.log(`${BUNDLES}/${name}.min.js: ${(text.length / 1000).toFixed(0)} kB`);
  } else if ((await readFile(file, "utf8").catch(() => "")) !== text) {
    outdated.push(`${name}.min.js`);
  }
}
if (outdated.length) {
  const files = outdated.map((name) => `${BUNDLES}/${name}`).join(", ");
  console.error(
    isCheck
      ? `Expected bundles as of a fresh build, got other ones: ${files}. Run \`web/npm run build\` and commit.`
      : `Not bundles of build.js: ${files}. Remove them.`,
  );
  process.exitCode = 1;
}
