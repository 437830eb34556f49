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

// What the page itself makes of a report (src/api/strokes.ts): one reader for both.
async function reader() {
  const result = await build({
    absWorkingDir: web, entryPoints: ["src/api/strokes.ts"], bundle: true, format: "esm", target: "node18", write: false, logLevel: "warning",
  });
  return import(`data:text/javascript;base64,${Buffer.from(result.outputFiles[0].contents).toString("base64")}`);
}

// What the system says of a path, in words.
const kReasons = {
  ENOENT: "nothing there", ENOTDIR: "a file where a folder should be", EISDIR: "a folder", EACCES: "no permission", EPERM: "no permission",
  EROFS: "a disk that is read only", ENOSPC: "a full disk",
};
const reason = (error) => kReasons[error.code] ?? error.message;
const kHowToWrite = "write one with enamel-station qualify --suite strokes --json FILE";

function readReport(from) {
  let text;
  try {
    const { size } = statSync(from);
    if (size > kLargest) throw new Error(`${(size / (1 << 20)).toFixed(0)} MiB`);
    text = readFileSync(from, "utf8");
  } catch (error) {
    throw new Error(`${from}: expected a report that can be read, of at most ${kLargest >> 20} MiB, found ${reason(error)}; ${kHowToWrite}`);
  }
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`${from}: expected a report in JSON, found text that is none (${error.message}); ${kHowToWrite}`);
  }
}

// Reads the report named first, writes the page named second. Says what is wrong and throws; then nothing is written.
export async function drawReport(from, to) {
  const report = readReport(from);
  const { strokesIn } = await reader();
  const strokes = strokesIn(report);
  if (!strokes.ok) throw new Error(`${from}: expected strokes that can be drawn, but ${strokes.error}; ${kHowToWrite}`);
  const [script, style] = await Promise.all([bundled("src/app/report.tsx", /<\/script/gi, "<\\/script"),
                                             bundled("src/app/style.css", /<\/style/gi, "<\\/style")]);
  // "<" cannot stand in a script element's text: it is written as JSON's own escape.
  const text = JSON.stringify(strokes.value).replaceAll("<", "\\u003c");
  try {
    writeFileSync(to, page(text, script, style));
  } catch (error) {
    throw new Error(`${to}: expected a file that can be written, found ${error.code === "ENOENT" ? "no such folder" : reason(error)}; name another`);
  }
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
