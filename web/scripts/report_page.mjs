// A report of enamel-lab as one HTML file that needs nothing else: no server, no network. What
// draws it (a script and a style sheet) and what reads the report are given: draw_report.mjs builds
// them, the installed script has them.
import { createHash } from "node:crypto";
import { readFileSync, statSync, writeFileSync } from "node:fs";

const kLargest = 64 << 20;

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
const kEscapes = { "&": "&amp;", "<": "&lt;", ">": "&gt;" };
const escaped = (text) => text.replace(/[&<>]/g, (found) => kEscapes[found]);

function page(title, report, script, style) {
  // The policy lets the browser run and load only what is in this file.
  const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; base-uri 'none'; form-action 'none'`;
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>${escaped(title)}</title>
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

// What the system says of a path, in words.
const kReasons = {
  ENOENT: "nothing there",
  ENOTDIR: "a file where a folder should be",
  EISDIR: "a folder",
  EACCES: "no permission",
  EPERM: "no permission",
  EROFS: "a disk that is read only",
  ENOSPC: "a full disk",
};
const reason = (error) => kReasons[error.code] ?? error.message;
const kHowToWrite = "write one with enamel-lab qualify --json FILE";

function readReport(from) {
  let text;
  try {
    const { size } = statSync(from);
    if (size > kLargest) throw new Error(`${(size / (1 << 20)).toFixed(0)} MiB`);
    text = readFileSync(from, "utf8");
  } catch (error) {
    throw new Error(
      `${from}: expected a report that can be read, of at most ${kLargest >> 20} MiB, found ${reason(error)}; ${kHowToWrite}`,
    );
  }
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`${from}: expected a report in JSON, found text that is none (${error.message}); ${kHowToWrite}`);
  }
}

// Reads the report named first, writes the page named second. Says what is wrong and throws; then
// nothing is written. `parts`: script, style, and drawable: what src/api/drawable.ts has.
export function writePage(from, to, parts) {
  const drawable = parts.drawableIn(readReport(from));
  if (!drawable.ok)
    throw new Error(`${from}: expected a report that can be drawn, but ${drawable.error}; ${kHowToWrite}`);
  // "<" could end the script element, so it is written as a JSON escape.
  const text = JSON.stringify(drawable.value).replaceAll("<", "\\u003c");
  try {
    writeFileSync(to, page(parts.titleOf(drawable.value), text, parts.script, parts.style));
  } catch (error) {
    throw new Error(
      `${to}: expected a file that can be written, found ${error.code === "ENOENT" ? "no such folder" : reason(error)}; name another`,
    );
  }
}

// The command line: REPORT.json PAGE.html. Sets the exit code.
export async function runCommand(args, draw) {
  const [from, to] = args;
  try {
    if (to === undefined) throw new Error("usage: node draw_report.mjs REPORT.json PAGE.html");
    await draw(from, to);
    console.log(`${to}: ${(statSync(to).size / 1000).toFixed(0)} kB`);
  } catch (error) {
    console.error(error.message);
    process.exitCode = 1;
  }
}
