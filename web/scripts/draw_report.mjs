// Draws a report of enamel-lab as one HTML file that needs nothing else: no server, no network.
//   enamel-lab qualify --profile omega3 --suite withdrawal --json strokes.json
//   node scripts/draw_report.mjs strokes.json strokes.html
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { runCommand, writePage } from "./report_page.mjs";
import { scriptAndStyle, web } from "./report_parts.mjs";
import { englishAtOnce } from "./words.mjs";

// What the page itself makes of a report: one reader for both.
async function reader() {
  const result = await build({
    absWorkingDir: web,
    entryPoints: ["src/api/drawable.ts"],
    bundle: true,
    format: "esm",
    target: "node18",
    write: false,
    logLevel: "warning",
    plugins: [englishAtOnce()],
  });
  return import(`data:text/javascript;base64,${Buffer.from(result.outputFiles[0].contents).toString("base64")}`);
}

export async function drawReport(from, to) {
  writePage(from, to, { ...(await reader()), ...(await scriptAndStyle()) });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await runCommand(process.argv.slice(2), drawReport);
