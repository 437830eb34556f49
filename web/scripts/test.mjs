// Bundles every src/**/*.test.ts into build/test and runs them with node --test.
import { spawnSync } from "node:child_process";
import { readdirSync, rmSync } from "node:fs";
import { join, relative, sep } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { englishAtOnce } from "./words.mjs";

const web = fileURLToPath(new URL("..", import.meta.url));
const out = join(web, "build", "test");

function testFiles(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return testFiles(path);
    return entry.name.endsWith(".test.ts") ? [path] : [];
  });
}

const sources = testFiles(join(web, "src"));
rmSync(out, { recursive: true, force: true });
await build({
  entryPoints: sources,
  outdir: out,
  outbase: join(web, "src"),
  outExtension: { ".js": ".mjs" },
  bundle: true,
  platform: "node",
  format: "esm",
  target: "node18",
  sourcemap: "inline",
  logLevel: "warning",
  plugins: [englishAtOnce()],
  external: ["typescript"],
});
const compiled = sources.map((path) =>
  join(out, relative(join(web, "src"), path).split(sep).join("/").replace(/\.ts$/, ".mjs")),
);
const { status } = spawnSync(process.execPath, ["--test", "--enable-source-maps", ...compiled], {
  cwd: web,
  stdio: "inherit",
});
process.exit(status ?? 1);
