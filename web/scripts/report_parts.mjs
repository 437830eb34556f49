// What draws a report (scripts/report_page.mjs), built from the page's own sources.
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { englishAtOnce, keysIn, readCatalogue } from "./words.mjs";

export const web = fileURLToPath(new URL("..", import.meta.url));

// The words that `entry` and its imports need.
async function wordsOf(entry) {
  const { metafile } = await build({
    absWorkingDir: web,
    entryPoints: [entry],
    bundle: true,
    write: false,
    metafile: true,
    logLevel: "silent",
    plugins: [englishAtOnce([])],
  });
  const text = Object.keys(metafile.inputs)
    .filter((path) => path.startsWith("src/"))
    .map((path) => readFileSync(join(web, path), "utf8"))
    .join("\n");
  return englishAtOnce(keysIn(text, Object.keys(readCatalogue("en"))));
}

// `end`: the text that would end the enclosing element, and its replacement.
async function bundled(entry, end, written) {
  const result = await build({
    absWorkingDir: web,
    entryPoints: [entry],
    bundle: true,
    format: "iife",
    target: "es2022",
    minify: true,
    write: false,
    jsx: "automatic",
    jsxImportSource: "preact",
    legalComments: "none",
    logLevel: "warning",
    plugins: [await wordsOf(entry)],
  });
  return result.outputFiles[0].text.replaceAll(end, written);
}

export async function scriptAndStyle() {
  const [script, style] = await Promise.all([
    bundled("src/app/report.tsx", /<\/script/gi, "<\\/script"),
    bundled("src/app/style.css", /<\/style/gi, "<\\/style"),
  ]);
  return { script, style };
}
