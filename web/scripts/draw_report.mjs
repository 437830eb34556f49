// Draws a qualification report as one HTML file that needs nothing else: no server, no network.
//   enamel-station qualify --profile omega3 --suite strokes --json strokes.json
//   node scripts/draw_report.mjs strokes.json strokes.html
import { createHash } from "node:crypto";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const web = fileURLToPath(new URL("..", import.meta.url));
const kLargest = 64 << 20;

// `end`: what would end the element that holds the text, and how it is written instead.
async function bundled(entry, end, escaped) {
  const result = await build({
    absWorkingDir: web, entryPoints: [entry], bundle: true, format: "iife", target: "es2022", minify: true, write: false,
    jsx: "automatic", jsxImportSource: "preact", legalComments: "none", logLevel: "warning",
  });
  return result.outputFiles[0].text.replaceAll(end, escaped);
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

function page(report, script, style) {
  // Only what is in this file may run or be loaded; the browser is told so.
  const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; base-uri 'none'; form-action 'none'`;
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>How cutting feels: force against time</title>
<style>${style}</style>
</head>
<body>
<div id="app"></div>
<script type="application/json" id="report">${report}</script>
<script>${script}</script>
</body>
</html>
`;
}

// Reads the report named first, writes the page named second. Says what is wrong and throws.
export async function drawReport(from, to) {
  if (statSync(from).size > kLargest) throw new Error(`${from}: expected at most ${kLargest >> 20} MiB`);
  let report;
  try {
    report = JSON.parse(readFileSync(from, "utf8"));
  } catch (error) {
    throw new Error(`${from}: expected JSON as enamel-station qualify --json writes it, found ${error.message}`);
  }
  const strokes = report?.strokes ?? report;
  if (!Array.isArray(strokes?.devices)) {
    throw new Error(`${from}: no strokes in it: run enamel-station qualify --suite strokes --json ${from}`);
  }
  const [script, style] = await Promise.all([bundled("src/app/report.tsx", /<\/script/gi, "<\\/script"),
                                             bundled("src/app/style.css", /<\/style/gi, "<\\/style")]);
  // "<" cannot stand in a script element's text: it is written as JSON's own escape.
  const text = JSON.stringify(strokes).replaceAll("<", "\\u003c");
  writeFileSync(to, page(text, script, style));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [from, to] = process.argv.slice(2);
  if (to === undefined) {
    console.error("usage: node scripts/draw_report.mjs REPORT.json PAGE.html");
    process.exit(1);
  }
  try {
    await drawReport(from, to);
    console.log(`${to}: ${(statSync(to).size / 1000).toFixed(0)} kB`);
  } catch (error) {
    console.error(error.message);
    process.exit(1);
  }
}
