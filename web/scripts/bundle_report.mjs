// Writes dist_lab/draw_report.mjs: draw_report.mjs with all that it needs in itself, for where
// enamel-lab is installed. It needs node and nothing else.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { build } from "esbuild";
import { scriptAndStyle, web } from "./report_parts.mjs";
import { englishAtOnce } from "./words.mjs";

export async function bundleReport() {
  const parts = await scriptAndStyle();
  mkdirSync(join(web, "dist_lab"), { recursive: true });
  await build({
    absWorkingDir: web,
    outfile: "dist_lab/draw_report.mjs",
    bundle: true,
    platform: "node",
    format: "esm",
    target: "node18",
    minify: true,
    legalComments: "none",
    logLevel: "warning",
    plugins: [englishAtOnce()],
    stdin: {
      resolveDir: web,
      contents: `import * as reader from "./src/api/drawable.ts";
        import { runCommand, writePage } from "./scripts/report_page.mjs";
        const parts = { ...reader, ...${JSON.stringify(parts)} };
        await runCommand(process.argv.slice(2), (from, to) => writePage(from, to, parts));`,
    },
  });
}
