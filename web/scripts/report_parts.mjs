// What draws a report (scripts/report_page.mjs), built from the page's own sources.
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

export const web = fileURLToPath(new URL("..", import.meta.url));

// `end`: what would end the element that holds the text, and how it is written instead.
async function bundled(entry, end, written) {
  const result = await build({
    absWorkingDir: web, entryPoints: [entry], bundle: true, format: "iife", target: "es2022", minify: true, write: false,
    jsx: "automatic", jsxImportSource: "preact", legalComments: "none", logLevel: "warning",
  });
  return result.outputFiles[0].text.replaceAll(end, written);
}

export async function scriptAndStyle() {
  const [script, style] = await Promise.all([bundled("src/app/report.tsx", /<\/script/gi, "<\\/script"), bundled("src/app/style.css", /<\/style/gi, "<\\/style")]);
  return { script, style };
}
