// A report of enamel-lab as one HTML file that needs nothing else: no server, no network. What
// draws it (a script and a style sheet) and what reads the report are given: draw_report.mjs builds
// them, the installed script has them.
import { readFileSync, statSync } from "node:fs";
import { oneFile, reason, write } from "./one_file.mjs";

const kLargest = 64 << 20;
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
  const { script, style } = parts;
  write(to, oneFile({ title: parts.titleOf(drawable.value), script, style, held: { report: drawable.value } }));
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
