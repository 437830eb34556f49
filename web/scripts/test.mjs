// Bundles all src/**/*.test.ts into one file and runs it with node --test: a process and a bundle for each of a hundred
// files cost more than the tests.
import { spawnSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { englishAtOnce } from "./words.mjs";

const web = fileURLToPath(new URL("..", import.meta.url));
const bundle = join(web, "build", "test.mjs");

function testFiles(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return testFiles(path);
    return entry.name.endsWith(".test.ts") ? [path] : [];
  });
}

const imports = testFiles(join(web, "src")).map((path) => `import ${JSON.stringify(path)};`);
await build({
  stdin: { contents: imports.join("\n"), resolveDir: web },
  outfile: bundle,
  bundle: true,
  platform: "node",
  format: "esm",
  target: "node18",
  sourcemap: "inline",
  logLevel: "warning",
  plugins: [englishAtOnce()],
  external: ["typescript"],
});
const { status } = spawnSync(process.execPath, ["--test", "--enable-source-maps", bundle], {
  cwd: web,
  stdio: "inherit",
});
process.exit(status ?? 1);
