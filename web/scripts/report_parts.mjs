// Scripts and styles of files that need no server, built from the page's own sources.
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { englishAtOnce, keysIn, readCatalogue } from "./words.mjs";

export const kStyle = "src/app/style.css";
export const web = fileURLToPath(new URL("..", import.meta.url));

// The keys of the words that `entry` and its imports need.
export async function keysOf(entry) {
  const { metafile } = await build({
    absWorkingDir: web,
    entryPoints: [entry],
    bundle: true,
    write: false,
    metafile: true,
    jsx: "automatic",
    jsxImportSource: "preact",
    logLevel: "silent",
    plugins: [englishAtOnce([])],
  });
  const text = Object.keys(metafile.inputs)
    .filter((path) => path.startsWith("src/"))
    .map((path) => readFileSync(join(web, path), "utf8"))
    .join("\n");
  return keysIn(text, Object.keys(readCatalogue("en")));
}

// In one file, for an element of a page. What would end that element is written in another way.
export async function bundled(entry, options = {}) {
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
    ...options,
  });
  return result.outputFiles[0].text.replaceAll(/<\/(?=script|style)/gi, "<\\/");
}

// What these sources of the page export, for node: `contents` is `export … from "./src/…"`.
export async function imported(contents) {
  const result = await build({
    stdin: { contents, resolveDir: web },
    bundle: true,
    format: "esm",
    target: "node18",
    write: false,
    logLevel: "warning",
    plugins: [englishAtOnce()],
  });
  return import(`data:text/javascript;base64,${Buffer.from(result.outputFiles[0].contents).toString("base64")}`);
}

export async function scriptAndStyle() {
  const kReport = "src/app/report.tsx";
  const plugins = [englishAtOnce(await keysOf(kReport))];
  const [script, style] = await Promise.all([bundled(kReport, { plugins }), bundled(kStyle)]);
  return { script, style };
}
