// Draws a report of enamel-lab as one HTML file that needs nothing else: no server, no network.
//   enamel-lab qualify --profile omega3 --suite withdrawal --json strokes.json
//   node scripts/draw_report.mjs strokes.json strokes.html
import { fileURLToPath } from "node:url";
import { runCommand, writePage } from "./report_page.mjs";
import { imported, scriptAndStyle } from "./report_parts.mjs";

export async function drawReport(from, to) {
  // What the page itself makes of a report: one reader for both.
  const reader = await imported('export * from "./src/api/drawable.ts"');
  writePage(from, to, { ...reader, ...(await scriptAndStyle()) });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await runCommand(process.argv.slice(2), drawReport);
